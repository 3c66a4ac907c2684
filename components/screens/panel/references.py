# SPDX-License-Identifier: GPL-2.0-or-later
"""The reference of thermal_displacement as its records, read and given back through its pins, as plumb-retain does it. Without a screen."""

import json
import time

from panel.settings import Refused, as_text
from panel.texts import _

PATIENCE = 5  # s for an answer, which takes a period of the thread
PAUSE = 0.001  # s
OF_WALK = ("row-shown",)


def read(hal, instance):
    """The records, each with its quantities by name. Raises Refused if the component does not answer."""
    for _attempt in range(3):  # plumb-retain may walk at the same time
        once, again = _walk(hal, instance), _walk(hal, instance)
        if same(once, again):
            break
    else:
        raise Refused(_("{name}: the reference cannot be read.").format(name=instance.name))
    hal.set(instance.full("row"), "-1")
    return once


def give(hal, instance, records):
    """Replaces the records. Raises Refused if the component refuses one, or does not answer."""
    def count(short):
        return hal.get(instance.full(short))

    _edge(hal, instance, "forget", lambda: count("rows") == 0)
    for record in records:
        for name, value in record.items():
            hal.set(instance.full("restore-" + name), as_text(value))
        accepted, refused = count("restores"), count("restores-refused")
        _edge(hal, instance, "restore", lambda: (count("restores"), count("restores-refused")) != (accepted, refused))  # noqa: B023
        if count("restores-refused") != refused:
            raise Refused(_("{name} refuses the former reference.").format(name=instance.name))


def same(some, others):
    """Whether these are the same records, also where a quantity is not a number."""
    return json.dumps(some) == json.dumps(others)


def as_words(text):
    """The records of the list of changes, for its page."""
    return _("contacts: {count}").format(count=len(json.loads(text))) if text else _("learn")


def _fields(instance):
    return [short[len("row-"):] for short in instance.pins if short.startswith("row-") and short not in OF_WALK]


def _walk(hal, instance):
    found = []
    for row in range(hal.get(instance.full("rows"))):
        _show(hal, instance, row)
        found.append({name: hal.get(instance.full("row-" + name)) for name in _fields(instance)})
    return found


def _show(hal, instance, row):
    """Asks again until the component shows it: plumb-retain may ask for another one meanwhile."""
    def shown():
        if hal.get(instance.full("row")) != row:
            hal.set(instance.full("row"), str(row))
        return hal.get(instance.full("row-shown")) == row

    _await(shown, instance)


def _edge(hal, instance, short, condition):
    """A rising edge, and its end when the component has seen it."""
    name = instance.full(short)
    hal.set(name, "0")
    _seen(hal, instance)
    hal.set(name, "1")
    try:
        _await(condition, instance)
    finally:
        hal.set(name, "0")


def _seen(hal, instance):
    """Until the component has read all earlier writes."""
    if hal.get(instance.full("rows")):
        for row in (0, -1):
            _show(hal, instance, row)
    else:
        time.sleep(0.05)


def _await(condition, instance):
    ends = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > ends:
            raise Refused(_("{name} does not answer: no thread runs it.").format(name=instance.name))
        time.sleep(PAUSE)

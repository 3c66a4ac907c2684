# SPDX-License-Identifier: GPL-2.0-or-later
"""What a component does now, as it says by its status-code and its faults, in words. Without a screen."""

import collections
import math

from panel.texts import _, in_micrometres, with_unit

Status = collections.namedtuple("Status", "kind text remedy button", defaults=("", ""))
Status.__doc__ = """kind is good, wait, off, warn or bad; remedy is a sentence, and button the name of the one that does it."""

# The quantity of a status, by its pin. For gettext: _("Standard deviation"), _("Contacts"), _("Strokes"), _("Offset"), _("Distance")
QUANTITIES = {"offset-sigma": "Standard deviation", "contacts": "Contacts", "rows": "Contacts", "stroke-count": "Strokes", "offset": "Offset",
              "stands-off-by": "Distance"}
SMALL = ("offset-sigma",)  # shown in micrometres


def of(instance, values):
    """The status of a function."""
    if not any(pin.name in values for pin in instance.pins.values()):
        return Status("bad", _("{name} is not loaded any more.").format(name=instance.name), _("Start LinuxCNC again."))
    its = instance.declared.statuses.get(instance.value(values, "status-code", 0))
    if its is None and instance.declared.is_users:
        return Status("good", _("No fault."))
    if its is None:
        return Status("bad", _("{name} is not called: no thread runs its function update.").format(name=instance.name), _("Run plumb doctor --running."))
    return Status(its["kind"], " ".join(filter(None, [_(its["sentence"]), *details(instance, values, its)])), _(its["remedy"]), its["button"])


def kind_and_words(instance, values):
    """Sentence and remedy together, for one line."""
    its = of(instance, values)
    return its.kind, " ".join(filter(None, (its.text, its.remedy)))


def details(instance, values, its):
    """The detail of a declared status, the sentence of a code or a quantity, and the size of that; each '' without one."""
    return _detail(instance, values, its["detail"]), _size(instance, values, its["size"])


def _detail(instance, values, short):
    now = instance.value(values, short)
    if short in instance.declared.codes:
        return instance.sentence(values, short)
    if now is None or (isinstance(now, float) and not math.isfinite(now)):
        return ""
    unit = instance.declared.pin(short).get("unit", "")
    shown = in_micrometres(float(now)).lstrip("+") if short in SMALL else with_unit(round(now, 4), unit)
    return "%s: %s." % (_(QUANTITIES.get(short, short)), shown)


def _size(instance, values, short):
    size = instance.value(values, short)
    return _("Size: {size}.").format(size=in_micrometres(size).lstrip("+")) if size else ""


def state_of(instance, values):
    """Kind and sentence of an instance: its status, or its faults; codes in words."""
    if instance.declared.statuses:
        return kind_and_words(instance, values)
    if not any(pin.name in values for pin in instance.pins.values()):
        return "bad", _("{name} is not loaded any more.").format(name=instance.name)
    if instance.value(values, "fault"):
        return "bad", instance.sentence(values, "fault-code") or _("A fault is active.")
    for short, pin in instance.pins.items():
        value = values.get(pin.name)
        if isinstance(value, float) and value != value:
            return "warn", _("{pin} is not a number.").format(pin=pin.name)
    for short in instance.declared.codes:
        if short != "fault-code" and not short.startswith("state") and instance.value(values, short[: -len("-code")]):
            return "warn", instance.sentence(values, short)
    return "good", _("No fault.")


def of_channel(channel, declared, values):
    """The sentence of the fault of a sensor's channel."""
    code = values.get(channel.pins.get("fault-code", ""), 0)
    sentence = declared[channel.module].codes.get("CHANNEL.fault-code", {}).get(code, "") if channel.module in declared else ""
    return _(sentence) or (_("fault {code}").format(code=code) if code else _("It is not valid."))


def program_state(values):
    """idle, running or paused; '' if nobody knows."""
    if values.get("task.alive") and "task.program" in values:
        return values["task.program"]
    if values.get("halui.program.is-paused"):
        return "paused"
    if values.get("halui.program.is-running"):
        return "running"
    for name in ("linuxcnc-alive.program-running", "halui.program.is-idle"):
        if name in values:
            return "running" if bool(values[name]) == name.endswith("running") else "idle"
    return ""

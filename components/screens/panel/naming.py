# SPDX-License-Identifier: GPL-2.0-or-later
"""Sentences of components that name their settings, with the values. Without a screen."""

import re

from panel import texts
from panel.texts import _, in_micrometres, with_unit

BRACES = re.compile(r"\{([a-z0-9-]+)\}")


def named(instance, values, sentence):
    """A sentence of a component in words, and the settings that are out of their range."""
    return " ".join(parts(instance, values, sentence))


def parts(instance, values, sentence):
    """A sentence of a component in words. A setting that is out of its range is added with its limit; if none is, the settings that the
    sentence names have their values, and pins in braces are their values. An operator reads words instead of the names of pins."""
    beyond = out_of_range(instance, values) if sentence else []

    def in_words(match):
        short, value = match[0], instance.value(values, match[0])
        if short not in instance.declared.pins:
            return short
        is_setting = value is not None and not instance.declared.pin(short).get("output")
        return _name(short) + (" (%s)" % with_unit(value, instance.declared.pin(short).get("unit", "")) if is_setting and not beyond else "")

    pieces = BRACES.split(_(sentence))  # text, pin, text, ...
    pieces[::2] = [re.sub(r"\b[a-z]+(?:-[a-z0-9]+)+\b", in_words, text) for text in pieces[::2]]
    pieces[1::2] = [filled(instance, values, short) for short in pieces[1::2]]
    return ["".join(pieces), *beyond]


def filled(instance, values, short):
    """The value of a pin in a sentence: a code as its sentence, a length in micrometres, a long time in minutes."""
    if short in instance.declared.codes:
        return instance.sentence(values, short)
    value, unit = instance.value(values, short, 0), instance.declared.pin(short).get("unit", "")
    if unit == "s" and value >= 120:
        return "%.0f min" % (value / 60)
    return in_micrometres(float(value)).lstrip("+") if unit == "mu" else with_unit(round(value), unit)


def _name(short):
    return short if texts.PIN_NAMES[0] else short.replace("-", " ")


def out_of_range(instance, values):
    """Sentences about the settings that are beyond their declared limits."""
    found = []
    for short, pin in instance.pins.items():
        limits, value = instance.declared.pin(short), instance.value(values, short)
        if pin.output or value is None or isinstance(value, bool):
            continue
        for key, which, sign in (("minimum", _("at least"), 1), ("maximum", _("at most"), -1)):
            if key in limits and not sign * value >= sign * limits[key]:
                unit = limits.get("unit", "")
                name = pin.name if texts.PIN_NAMES[0] else _name(short)
                found.append(_("{pin}: {value} is out of range: {which} {limit}.").format(
                    pin=name, value=with_unit(value, unit), which=which, limit=with_unit(limits[key], unit)))
    return found

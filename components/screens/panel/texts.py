# SPDX-License-Identifier: GPL-2.0-or-later
"""Sentences in the user's language, and numbers with their units."""

import gettext
import math
import os

DOMAIN = "plumb-panel"
_translation = gettext.NullTranslations()


def choose(folder, language=""):
    """The language by its name, such as de; else from the environment. `folder` holds LANGUAGE/LC_MESSAGES."""
    global _translation
    languages = [language] if language else None
    _translation = gettext.translation(DOMAIN, folder, languages=languages, fallback=True)


def _(text):
    return _translation.gettext(text) if text else ""


def number(value, digits=6):
    if isinstance(value, bool):
        return _("on") if value else _("off")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if math.isnan(value):
            return _("not a number")
        if math.isinf(value):
            return _("infinite")
        text = "%.*g" % (digits, value)
        if "e" in text and 1e-7 < abs(value) < 1e7:
            text = ("%.9f" % value).rstrip("0").rstrip(".")
        return text.replace("-", "\u2212")
    return str(value)


def with_unit(value, unit):
    shown = number(value)
    if isinstance(value, bool) or unit in ("", "1") or (isinstance(value, float) and not math.isfinite(value)):
        return shown
    return "%s %s" % (shown, unit_name(unit))


def unit_name(unit):
    """The machine unit by its name: mm or in."""
    if unit == "1":
        return ""
    return unit.replace("mu", MACHINE_UNIT[0]).replace("degC", "\u00b0C").replace("deg", "\u00b0")


MACHINE_UNIT = ["mm"]
PIN_NAMES = [True]  # false: sentences have none, for an operator
VERSION = [""]  # of Plumb


def for_program(value):
    """A length of the machine as an expression of G-code: a program may be in mm or inches."""
    return "%.6f%s" % (value, "*[1+24.4*#<_metric>]" if MACHINE_UNIT[0] == "in" else "/[1+24.4*#<_imperial>]")


def position(value):
    """A position of the machine, as a readout shows it."""
    return ("%.4f %s" % (value, unit_name("mu"))).replace("-", "\u2212")


def in_micrometres(value, unit="mm"):
    """A length of the machine as a text of a few digits."""
    if not isinstance(value, float) or not math.isfinite(value):
        return number(value)
    scale = 25400.0 if MACHINE_UNIT[0] in ("in", "inch") else 1000.0
    text = "%+.1f" % (value * scale)
    return (text[1:] if float(text) == 0 else text.replace("-", "\u2212")) + " \u00b5m"


def seconds(value):
    """A time in words that fit the length of it."""
    if not math.isfinite(value):
        return _("not a number")
    if value < 100:
        return "%.0f s" % value
    if value < 6000:
        return "%.0f min" % (value / 60)
    return "%.1f h" % (value / 3600)


def system_user():
    import getpass

    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return str(os.getuid())

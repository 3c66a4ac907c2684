# SPDX-License-Identifier: GPL-2.0-or-later
"""How strokes are ordered from a screen: by pins of chopping that have no signal, or by G-code in MDI. Without a screen."""

import collections
import math

from panel import texts
from panel.texts import _, for_program, with_unit

Stroke = collections.namedtuple("Stroke", "upper lower end speed")
Stroke.__doc__ = "Dead points and point R in machine units, in the frame of the joint; speed in machine units a second."

OFF, PHASES, BOTH, UPWARD, DOWNWARD = range(5)  # kinds of a section
MOST_SECTIONS = 4
BY_PINS = ("run", "shift", "upper", "lower", "feed")


def way(instance, ini):
    """How a screen may order strokes: "pins", "mdi", or "" where only a program can."""
    if all(short in instance.settings() for short in BY_PINS):
        return "pins"
    return "mdi" if any(line.split()[0].upper() == "G81.1" for line in ini.all("RS274NGC", "REMAP") if line.split()) else ""


def is_extra(ini):
    """Whether the stroke is on an extra joint: then point R is the place where it stands."""
    return bool(ini.get("CHOPPING", "EXTRA_JOINT"))


def refusal(instance, values, stroke):
    """Why a stroke is impossible, before anything is sent; '' if nothing speaks against it."""
    def get(short, otherwise):
        return instance.value(values, short, otherwise)

    if not all(map(math.isfinite, stroke)):
        return _("Enter numbers.")
    if stroke.upper <= stroke.lower:
        return _("The upper dead point must be above the lower one.")
    if stroke.speed <= 0:
        return _("The speed must be above 0.")
    most = get("max-feed", math.inf)
    if stroke.speed > most * 1.000001:
        return _("The speed is above the largest one, {speed}.").format(speed=a_minute(most))
    lowest, highest = get("min-limit", -math.inf), get("max-limit", math.inf)
    for place in stroke[:3]:
        if lowest < highest and not lowest <= place <= highest:
            return _("{place} is outside of the soft limits, {lowest} to {highest}.").format(
                place=with_unit(place, "mu"), lowest=with_unit(lowest, "mu"), highest=with_unit(highest, "mu"))
    if get("by-centre", False):
        return _("Centre and length give the strokes here, so dead points have no effect.")
    if get("speed-kind", 0) > 1:
        return _("A frequency or a cycle time gives the strokes here, so the speed has no effect.")
    return ""


def a_minute(speed):
    return "%s/min" % with_unit(round(60 * speed, 6), "mu")


def start_line(stroke, extra):
    """G81.1 in the units and the work coordinates that hold then."""
    origin = "" if extra else "-#<_abs_z>+#<_z>"
    end = "" if extra else " R[%s]" % for_program(stroke.end - stroke.upper)
    return "G81.1 Z[%s%s] Q[%s]%s P[%s]" % (
        for_program(stroke.upper), origin, for_program(stroke.lower - stroke.upper), end, for_program(60 * stroke.speed))


def change_line(stroke):
    return "O<chop_change> call [%.6f] [%.6f] [%.6f]" % (stroke.upper, stroke.lower, stroke.speed)


def sections(instance):
    """The numbers of the sections that it has pins for."""
    return [place for place in range(MOST_SECTIONS) if "section-%d-kind" % place in instance.pins]


def section_in_words(instance, values, place):
    kind, first, last, ratio = (instance.value(values, "section-%d-%s" % (place, part)) for part in ("kind", "from", "to", "ratio"))
    if not kind:
        return _("none")
    unit = "deg" if kind == PHASES else "mu"
    ways = {PHASES: _("by phase"), BOTH: _("both ways"), UPWARD: _("upward"), DOWNWARD: _("downward")}
    return _("{first} to {last}, {percent} % of the speed, {way}").format(
        first=with_unit(first, unit), last=with_unit(last, unit), percent=texts.number(100.0 * ratio, 4), way=ways.get(kind, kind))

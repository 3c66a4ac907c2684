# SPDX-License-Identifier: GPL-2.0-or-later
"""What the stroking axis does now. Without a screen."""

from panel.status import Status, bounded, fault, gone, machine_waits, withheld
from panel.texts import _, with_unit

NOTHING = 1e-6  # mu, of an offset


def status(machine, instance, values):
    found = gone(instance, values)
    if found:
        return found
    motion = _motion(machine, instance, values)
    found = fault(instance, values)
    if found:
        return Status("bad", "%s %s" % (found.text, motion.text))
    bound = bounded(instance, values) if motion.kind == "good" else None
    return Status("warn", "%s %s" % (motion.text, bound.text)) if bound else motion


def _motion(machine, instance, values):
    """Whether it strokes, stands or is at rest, and where."""
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    away = with_unit(round(float(get("offset", 0.0)), 4), "mu")
    if get("held"):
        if get("feed-hold") or get("emergency-hold"):
            return Status("warn", _("Held: the axis stands {distance} from point R. It goes on after the hold.").format(distance=away))
        return Status("warn", _("Held by the speed 0: the axis stands {distance} from point R.").format(distance=away))
    if get("withdrawing"):
        return Status("warn", _("The axis is on its way to point R."))
    if get("feed-wait"):
        return Status("warn", _("Moves wait until the axis is at point R. Jogs do not wait: jog another axis, not this one."))
    if get("stroking") and (get("feed-hold") or get("override", 1) == 0):
        return Status("warn", _("A hold is ordered: the axis goes on to a dead point or to point R, and stands there."))
    if get("active"):
        keeper = withheld(machine, instance, values)
        strokes = _("Strokes. {count} strokes so far.").format(count=get("stroke-count"))
        return Status("warn", strokes + " " + keeper.text) if keeper else Status("good", strokes)
    if not get("at-end", True) and abs(get("offset", 0.0)) > NOTHING:
        off = machine_waits(values) or ("" if get("motion-enabled", True) else _("The machine is off."))
        text = _("Stands {distance} from point R. \"To point R\" moves it there.").format(distance=away)
        return Status("warn", "%s %s" % (off, text) if off else text)
    rest = _("At rest at point R.")
    keeper = withheld(machine, instance, values)
    if keeper and keeper.kind != "off":
        return Status(keeper.kind, "%s %s" % (rest, keeper.text))
    why = (keeper.text if keeper else "") or machine_waits(values, get("homed", True)) or ("" if get("enable", True) else _("Strokes are not permitted now."))
    return Status("off", "%s %s" % (rest, why) if why else rest)

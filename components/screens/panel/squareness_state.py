# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether squareness corrects the tilts now. Without a screen."""

import re

from panel.status import Status, bounded, fault, gone, machine_waits, stages_fault, withheld
from panel.texts import _

ANGLE = re.compile(r"e[abc]0[xyzuvw]$")


def angles(instance, values):
    """The angles that are set, in rad, by the short names of their pins."""
    return {short: instance.value(values, short, 0.0) for short in instance.pins if ANGLE.match(short)}


def status(machine, instance, values):
    found = gone(instance, values) or fault(instance, values)
    if found:
        return found
    if not any(angles(instance, values).values()) and not instance.value(values, "tables", 0):
        return Status("off", _("No angle is set: nothing is corrected."))
    keeper = withheld(machine, instance, values)
    if keeper and not instance.value(values, "enable"):
        return keeper
    why = machine_waits(values, instance.value(values, "all-homed"))
    if why:
        return Status("wait", _("{why} Nothing is corrected.").format(why=why))
    found = stages_fault(machine, instance, values) or bounded(instance, values) or keeper
    if found:
        return found
    for axis, stage in machine.stages_of(instance).items():
        if stage.value(values, "limited"):
            return Status("warn", _("A bound of {stage} keeps the whole correction from {axis}.").format(stage=stage.name, axis=axis))
        if stage.value(values, "ramping"):
            return Status("wait", _("The axes move to their correction."))
    if instance.value(values, "ramping"):
        return Status("wait", _("The axes move to their correction."))
    return Status("good", _("Corrects the tilts that were measured."))


def corrections(machine, instance, values):
    """The corrections of X, Y and Z that the axes have: of their stages, or of the component where there is none."""
    stages = machine.stages_of(instance)
    found = {}
    for axis in "XYZ":
        stage = stages.get(axis)
        alone = stage is not None and len(machine.sources_of(stage)) == 1
        found[axis] = stage.value(values, "applied-offset", 0.0) if alone else instance.value(values, axis.lower() + "-correction", 0.0)
    return found

# SPDX-License-Identifier: GPL-2.0-or-later
"""The angles and the corrections of squareness. Without a screen."""

import re

ANGLE = re.compile(r"e[abc]0[xyzuvw]$")
OF_ROTARY = re.compile(r"e[abcxyz]0[abc]$")


def angles(instance, values):
    """The angles that are set, in rad, by the short names of their pins."""
    return {short: instance.value(values, short, 0.0) for short in instance.pins if ANGLE.match(short)}


def rotary_errors(instance, values):
    """The place errors, in mu, and the tilts, in rad, of rotary axes that are set, by the short names of their pins."""
    found = {short: instance.value(values, short, 0.0) for short in instance.pins if OF_ROTARY.match(short)}
    return {short: value for short, value in found.items() if value}


def corrections(machine, instance, values):
    """The corrections of X, Y and Z that the axes have: of their stages, or of the component where there is none."""
    stages = machine.stages_of(instance)
    found = {}
    for axis in "XYZ":
        stage = stages.get(axis)
        alone = stage is not None and len(machine.sources_of(stage)) == 1
        found[axis] = stage.value(values, "applied-offset", 0.0) if alone else instance.value(values, axis.lower() + "-correction", 0.0)
    return found

# SPDX-License-Identifier: GPL-2.0-or-later
"""What was loaded or wired so that nobody would see it: defaults in mm on a machine in inches, a function beside interlock. Without a screen."""

from panel import texts
from panel.texts import _, number, with_unit


def warnings(machine, values):
    """Sentences for the overview."""
    found = [_("{name} works without interlock: no lost service takes its offset back, and no commissioning holds it.").format(name=each.name)
             for each in machine.functions() if machine.of("interlock") and each.declared.moves and machine.permission(each)[0] is None]
    for instance in machine.instances:
        found += [in_millimetres(instance, short, values) for short in bounds_in_millimetres(instance, values)]
    return found


def bounds_in_millimetres(instance, values):
    """Bounds of an offset that have their default in mm as a number of inches: the component was loaded without unit=inch."""
    found = []
    for short in sorted({its.get("bound", "") for its in instance.declared.moves.values()}):
        declared = instance.declared.pin(short)
        is_default = declared.get("default") and instance.value(values, short) == declared["default"]
        if texts.MACHINE_UNIT[0] == "in" and is_default and declared.get("default_unit", "").startswith("mm"):
            found.append(short)
    return found


def in_millimetres(instance, short, values):
    value = instance.value(values, short)
    return _("{pin} is {value}, {mm} mm: its default in mm counts as inches. Load {module} with unit=inch, or change it.").format(
        pin=instance.full(short), value=with_unit(value, "mu"), mm=number(value * 25.4, 3), module=instance.module)

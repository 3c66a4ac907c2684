# SPDX-License-Identifier: GPL-2.0-or-later
"""What a function without a page of its own does, from what all functions have. Without a screen."""

from panel.status import Status, bounded, fault, gone, stages_fault, withheld
from panel.texts import _, in_micrometres


def status(machine, instance, values):
    found = (gone(instance, values) or fault(instance, values) or stages_fault(machine, instance, values)
             or withheld(machine, instance, values) or bounded(instance, values))
    if found:
        return found
    offsets = [(short[0].upper(), instance.value(values, short)) for short in instance.outputs() if short[1:] in ("-offset", "-correction")]
    if not offsets:
        return Status("good", _("No fault is active."))
    moves = ", ".join("%s %s" % (axis, in_micrometres(value)) for axis, value in offsets if value is not None)
    return Status("good", _("Offset in force: {moves}.").format(moves=moves))

# SPDX-License-Identifier: GPL-2.0-or-later
"""The states of the measurement of a tool's height, and its uncertainty. Without a screen."""

from panel.texts import in_micrometres

CUTS, WAITS, KNOWN, REFUSED, INTERRUPTED = 1, 2, 3, 4, 5
_STEPS = {41: CUTS, 47: REFUSED, 48: INTERRUPTED, 52: CUTS, 53: CUTS}  # by status-code; an entry that is refused ends no step


def step(instance, values):
    """The step of the measurement; 0 before the first one."""
    if instance.value(values, "measure", False):
        return WAITS
    return KNOWN if instance.value(values, "value-valid", False) else _STEPS.get(instance.value(values, "status-code", 0), 0)


def uncertainty(instance, values):
    """Expanded, k=2."""
    return in_micrometres(2 * instance.value(values, "sigma", 0.0)).lstrip("+")

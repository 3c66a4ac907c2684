# SPDX-License-Identifier: GPL-2.0-or-later
"""The states of the measurement of a tool's height, and its uncertainty. Without a screen."""

from panel.texts import in_micrometres

CUTS, WAITS, KNOWN, REFUSED, INTERRUPTED = 1, 2, 3, 4, 5  # state-code


def uncertainty(instance, values):
    """Expanded, k=2."""
    return in_micrometres(2 * instance.value(values, "sigma", 0.0)).lstrip("+")

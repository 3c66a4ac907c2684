# SPDX-License-Identifier: GPL-2.0-or-later
"""How far the measurement of a tool's height is, and whether the tool is on centre. Without a screen."""

from panel.status import Status, fault, gone
from panel.texts import _, in_micrometres

CUTS, WAITS, KNOWN, REFUSED, INTERRUPTED = 1, 2, 3, 4, 5  # state-code


def status(machine, instance, values):
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    found = gone(instance, values) or fault(instance, values)
    if found:
        return found
    state, sentence = get("state-code"), _(instance.sentence(values, "state-code"))
    if state == KNOWN:
        if get("on-centre"):
            return Status("good", _("The tool is on centre."))
        text = _("The tool is {height} off centre, \u00b1{sigma}.").format(height=in_micrometres(get("height", 0.0)), sigma=uncertainty(instance, values))
        if get("hold"):
            text += " " + _(instance.sentence(values, "hold-code"))
        return Status("warn", text)
    if state == REFUSED:
        return Status("bad", sentence)
    if state == INTERRUPTED:
        return Status("warn", sentence)
    return Status("wait", sentence) if state else Status("off", _("Begin with one of the methods below."))


def uncertainty(instance, values):
    """Expanded, k=2."""
    return in_micrometres(2 * instance.value(values, "sigma", 0.0)).lstrip("+")

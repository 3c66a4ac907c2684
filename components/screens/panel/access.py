# SPDX-License-Identifier: GPL-2.0-or-later
"""Who may do what, and when a button may move the machine."""

from panel.status import program_state
from panel.texts import _

LEVELS = ("view", "operator", "integrator")


class Access:
    def __init__(self, level):
        if level not in LEVELS:
            raise ValueError("%s is none of %s" % (level, ", ".join(LEVELS)))
        self.level = level

    def refusal(self, needed):
        """Why this screen may not do what needs a level; '' if it may."""
        if LEVELS.index(self.level) >= LEVELS.index(needed):
            return ""
        return _("This screen has the access \"{level}\", and this needs \"{needed}\". The INI file sets it: [PLUMB] ACCESS.").format(
            level=_(self.level), needed=_(needed))


# For gettext: _("view"), _("operator"), _("integrator")


def unsafe(values):
    """Why the machine may not be moved now; '' if it may. `values` holds all pins, and LinuxCNC's task."""
    if "motion.motion-enabled" not in values:
        return _("LinuxCNC's motion is not loaded.")
    if not values["motion.motion-enabled"]:
        return _("The machine is off.")
    if not values.get("motion.is-all-homed", True):
        return _("The machine is not homed.")
    return busy(values)


def busy(values):
    """What a write would disturb that moves an axis: a program, or a move; '' if nothing."""
    program = program_state(values)
    if program == "running":
        return _("A program runs.")
    if program == "paused":
        return _("A program is paused.")
    if not program and "motion.motion-enabled" in values:
        return _("LinuxCNC does not answer, so a program may run.")
    if values.get("motion.motion-type", 0):
        return _("An axis moves.")
    return ""

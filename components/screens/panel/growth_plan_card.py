# SPDX-License-Identifier: GPL-2.0-or-later
"""The plan of a growth test: its cycles, the uncertainty of each term of the law, and the file growth_plan.ngc."""

import json
import os
import subprocess

from gi.repository import Gtk

from panel.files import replace
from panel.growth_test_state import plan_in_words
from panel.texts import _
from panel.widgets import button, card, flow, label, set_text

HOURS = (2, 4, 8)
FILE = "growth_plan.ngc"


class PlanCard(Gtk.Box):
    """A button for each length of the test; the plan is made for the machine of the last log, or for a usual one."""

    def __init__(self, panel):
        super().__init__(orientation=Gtk.Orientation.VERTICAL)
        self._panel, self._program = panel, None
        self._plan = label(_("Choose how long the test may last."))
        self._write = button(_("Write {file}").format(file=FILE), self._ask)
        hours = [button(_("Plan {hours} h").format(hours=hours), lambda hours=hours: self._show(hours)) for hours in HOURS]
        self.pack_start(card(label(_("Plan of a test for the law of axis_growth"), "value"), flow(*hours, self._write), self._plan), True, True, 0)

    def _show(self, hours):
        """By the last log, if it shows the machine."""
        self._program = None
        why = ""
        for options in ["--log", os.path.join(self._panel.ini.folder or ".", "logs")], []:
            command = [self._panel.program("plumb-growth"), "plan", "--hours", str(hours), *options]
            done = [subprocess.run([*command, form], capture_output=True, text=True, timeout=60, check=False) for form in ("--json", "--ngc")]
            if any(each.returncode for each in done):
                why = (done[0].stderr.strip().splitlines() or ["plumb growth"])[0]
                continue
            self._program = done[1].stdout
            set_text(self._plan, "\n".join(plan_in_words(json.loads(done[0].stdout))))
            return
        self._panel.say(why, "bad")

    def _ask(self):
        action = _("Write the plan")
        if not self._program:
            self._panel.say(_("{action}: refused. {why}").format(action=action, why=_("Choose how long the test may last.")), "warn")
            return
        self._panel.guard.once_asked(lambda: (_("Write {file}? The next test of planned.ngc has these cycles.").format(file=FILE), []), action, self._do,
                                     must_be_safe=False, must_be_idle=True)

    def _do(self):
        path = os.path.join(self._panel.ini.folder or ".", FILE)
        replace(path, self._program)
        self._panel.say(_("{file} is written.").format(file=path))

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of AXIS, before the complete mill: a finger learns a part and changes a setting, over a restart."""

import json
import os
import shutil
import subprocess
import unittest

import linuxcnc_runs
from linuxcnc_runs import BUILD, PROGRAMS, ROOT, copy_configuration, finish, own_folder, plumb_run
from screen import Screen


class Days(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = own_folder(cls)
        cls.machine = copy_configuration("mill", cls.folder)
        screen = Screen(cls)
        shutil.copy(os.path.join(PROGRAMS, "panel_operator.py"), cls.machine)
        ini = os.path.join(cls.machine, "axis.ini")
        linuxcnc_runs.change(ini, "plumb-panel -x {XID}", "plumb-panel -x {XID} --widgets widgets.json --user anna")
        with open(ini, "a") as file:
            file.write("[APPLICATIONS]\nAPP = ./panel_operator.py\n")
        path = os.pathsep.join([os.path.join(BUILD, "python"), os.path.join(ROOT, "tests", "support")])
        cls.days = []
        for _ in range(2):
            process = subprocess.Popen(
                [*plumb_run(BUILD, "--speed", "4"), "linuxcnc", "-r", "axis.ini"],
                cwd=cls.machine,
                env=linuxcnc_runs.environment(cls.folder, PYTHONPATH=path, DISPLAY=screen.display, LC_ALL="C.UTF-8", NO_AT_BRIDGE="1",
                                               PLUMB_PATIENCE="600"),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            status, output = finish(process)
            with open(os.path.join(cls.machine, "seen.json")) as file:
                seen = json.load(file)
            if status or not seen.get("done"):
                raise AssertionError("linuxcnc ended with %d:\n%s\n%s" % (status, output, seen.get("error")))
            os.remove(os.path.join(cls.machine, "widgets.json"))
            cls.days.append(seen)

    def test_a_part_is_learnt_by_the_finger(self):
        self.assertIn("Valid, of 5 contacts", self.days[0]["reference"])

    def test_a_button_that_moves_is_refused_while_the_machine_is_off(self):
        self.assertIn("refused", self.days[0]["refused"])

    def test_a_changed_setting_wins_over_the_hal_file_after_a_restart(self):
        self.assertEqual(self.days[1]["gate-floor"], 0.025)
        self.assertIn("anna", self.days[1]["change"])

    def test_squareness_is_set_up_by_the_finger_and_is_there_after_a_restart(self):
        self.assertEqual(self.days[1]["ec0y"], -8e-05)


if __name__ == "__main__":
    unittest.main()

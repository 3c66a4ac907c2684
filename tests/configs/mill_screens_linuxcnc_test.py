#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of gmoccapy and of QtDragon, before the complete mill: a finger presses, and HAL and G-code answer."""

import json
import os
import shutil
import subprocess
import unittest

import linuxcnc_runs
from linuxcnc_runs import BUILD, PROGRAMS, ROOT, copy_configuration, finish, own_folder, plumb_run
from screen import Screen


class Screens(unittest.TestCase):
    def work(self, name):
        folder = own_folder(self)
        machine = copy_configuration("mill", folder)
        shutil.copy(os.path.join(PROGRAMS, "screen_operator.py"), machine)
        ini = os.path.join(machine, name + ".ini")
        linuxcnc_runs.change(ini, "plumb-panel -x {XID}", "plumb-panel -x {XID} --widgets widgets.json --user anna")
        with open(ini, "a") as file:
            file.write("[APPLICATIONS]\nAPP = ./screen_operator.py %s\n" % name)
        path = os.pathsep.join([os.path.join(BUILD, "python"), os.path.join(ROOT, "tests", "support")])
        process = subprocess.Popen(
            [*plumb_run(BUILD, "--speed", "2"), "linuxcnc", "-r", name + ".ini"],
            cwd=machine,
            # Without a service for notifications on the session's bus, QtDragon crashes in libdbus.
            env=linuxcnc_runs.environment(folder, PYTHONPATH=path, DISPLAY=Screen(self).display, LC_ALL="C.UTF-8", NO_AT_BRIDGE="1",
                                          PLUMB_PATIENCE="600", DBUS_SESSION_BUS_ADDRESS="disabled:"),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        output = finish(process)[1]
        with open(os.path.join(machine, "seen.json")) as file:
            seen = json.load(file)
        if not seen.get("done"):
            self.fail("%s\n%s" % (output, seen.get("error")))
        self.assertIn("refused", seen["refused"])

    def test_in_gmoccapy_a_finger_learns_takes_back_and_changes_a_setting(self):
        self.work("gmoccapy")

    def test_in_qtdragon_a_finger_learns_takes_back_and_changes_a_setting(self):
        self.work("qtdragon")


if __name__ == "__main__":
    unittest.main()

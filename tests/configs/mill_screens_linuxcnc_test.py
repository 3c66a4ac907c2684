#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of gmoccapy and of QtDragon, before the complete mill: a finger presses, and HAL and G-code answer."""

import unittest

import linuxcnc_runs
from linuxcnc_runs import copy_configuration, own_folder
from screen import Screen


ATTEMPTS = 3
PATIENCE = 110  # s; a screen that crashes leaves LinuxCNC's window of errors open, and all waits


class Screens(unittest.TestCase):
    def work(self, name):
        for _ in range(ATTEMPTS):
            folder = own_folder(self)
            machine = copy_configuration("mill", folder)
            linuxcnc_runs.add_operator(machine, name + ".ini", "screen_operator.py " + name)
            try:
                seen = linuxcnc_runs.work_screen(folder, machine, name + ".ini", Screen(self).display, speed=2, patience=PATIENCE)
            except AssertionError as error:
                if "Segmentation fault" not in str(error):
                    raise
                print("%s crashed:\n%s" % (name, error))
            else:
                return self.assertIn("refused", seen["refused"])
        return self.skipTest("%s crashed %d times" % (name, ATTEMPTS))

    def test_in_gmoccapy_a_finger_learns_takes_back_and_changes_a_setting(self):
        self.work("gmoccapy")

    def test_in_qtdragon_a_finger_learns_takes_back_and_changes_a_setting(self):
        self.work("qtdragon")


if __name__ == "__main__":
    unittest.main()

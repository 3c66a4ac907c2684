#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of gmoccapy and of QtDragon, before the complete mill: a finger presses, and HAL and G-code answer."""

import os
import unittest

import linuxcnc_runs
from linuxcnc_runs import copy_configuration, own_folder
from long import long
from screen import Screen
from starts import starts


@long
class Screens(unittest.TestCase):
    def work(self, name):
        folder = own_folder(self)
        machine = copy_configuration("mill", folder)
        ini = linuxcnc_runs.with_operator(os.path.join(machine, name + ".ini"), "screen_operator.py " + name)
        seen = linuxcnc_runs.work_screen(folder, ini, Screen(self).display, speed=2)
        self.assertIn("refused", seen["refused"])
        self.assertIn("0.025", seen["changes"])
        self.assertEqual(seen["old question"], "")
        self.assertEqual(seen["ago"], "", "no contact has come")
        self.assertEqual(seen["promise"], "", "no plumb-retain keeps the setting")
        self.assertIn("The machine is off. Turn the machine on.", seen["off"])
        self.assertEqual(seen["entries"], ["0.04"], "the half-filled form")
        self.assertIn("spindle-load", seen["lost sensor"])

    def test_in_gmoccapy_a_finger_learns_takes_back_and_changes_a_setting(self):
        self.work("gmoccapy")

    def test_in_qtdragon_a_finger_learns_takes_back_and_changes_a_setting(self):
        self.work("qtdragon")


tearDownModule = starts("mill/gmoccapy.ini", "mill/qtdragon.ini")


if __name__ == "__main__":
    unittest.main()

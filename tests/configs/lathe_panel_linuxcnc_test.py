#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of AXIS, before the complete lathe: a tool comes on centre by a finger and a micrometer."""

import os
import re
import unittest

import linuxcnc_runs
from linuxcnc_runs import copy_configuration, own_folder, um
from long import long
from screen import Screen
from starts import starts
from tree import ROOT


@long
class Lathe(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = copy_configuration("lathe", folder)
        ini = linuxcnc_runs.with_operator(os.path.join(machine, "axis.ini"), "lathe_operator.py")
        cls.seen = linuxcnc_runs.work_screen(folder, ini, Screen(cls).display, speed=4)

    def test_axis_jogs_y_only_when_the_machine_is_homed(self):
        self.assertEqual(self.seen["jogged unhomed"], [0, 0, 0])
        self.assertEqual(self.seen["jogged homed"], [0, 1, 0])

    def test_the_height_is_that_of_the_tool(self):
        self.assertAlmostEqual(self.seen["height"], 0.1, delta=12 * um)

    def test_a_finger_stores_it_in_the_tool_table(self):
        self.assertEqual(self.seen["before"], [-100, 0])
        x, y = self.seen["after"]
        self.assertAlmostEqual(y, -0.1, delta=12 * um)
        self.assertAlmostEqual(x, -100.02, delta=12 * um)

    def test_a_diameter_that_cannot_be_is_not_sent(self):
        self.assertIn("A tool on centre leaves the diameter 10.198 mm", self.seen["refused"])
        self.assertEqual(self.seen["state"], 42)

    def test_what_is_expected_shows_behind_the_entry_and_a_wrong_one_is_corrected(self):
        self.assertEqual(self.seen["before the entry"], "")
        self.assertIn("No other cut confirms it yet", self.seen["one entry"])
        self.assertIn("at the same Y", self.seen["twin"])
        self.assertIn("Entered before", self.seen["entered before"])

    def test_the_spindle_stands_and_x_is_clear_while_it_is_measured(self):
        self.assertEqual(set(self.seen["standing"]), {False})
        self.assertGreater(min(self.seen["clear"]), 5.3)

    def test_the_check_is_read_at_two_angles(self):
        self.assertIn("Diameter of cut 3, a quarter turn further", self.seen["second reading"])

    def test_a_land_shows_the_stored_height(self):
        self.assertIn("A land shows the stored height.", self.seen["shown"])

    def test_a_measurement_takes_as_many_presses_as_the_readme_says(self):
        with open(os.path.join(ROOT, "configs", "lathe", "README.md")) as file:
            said = int(re.search(r"with (\d+) presses", file.read())[1])
        self.assertEqual(self.seen["presses"], said)

    def test_an_interrupted_measurement_has_no_tick(self):
        words, tick = self.seen["interrupted"]
        self.assertIn("Resume it, or begin again.", words)
        self.assertFalse(tick)

    def test_refused_cuts_have_no_tick(self):
        words, tick = self.seen["no height"]
        self.assertIn("The last diameter does not fit. Check the insert", words)
        self.assertFalse(tick)

    def test_an_accepted_diameter_is_taken_back(self):
        self.assertRegex(self.seen["undo"], r"M452 P\[10\.\d+.*\] Q1")
        self.assertIn("M452 Q-1", self.seen["undo of the first"])

    def test_a_tool_off_centre_has_no_tick(self):
        self.assertIn("of the tool are wrong", self.seen["off centre"])
        self.assertEqual(self.seen["ticks"], "")

    def test_the_next_measurement_shows_that_it_is_on_centre(self):
        self.assertIn("on centre", self.seen["verdict"])


tearDownModule = starts("lathe/axis.ini")


if __name__ == "__main__":
    unittest.main()

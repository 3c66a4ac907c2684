#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The screens of grinder, growth, portal and three_axis: AXIS opens the program, the panel comes, and the machine homes."""

import os
import unittest

import linuxcnc_runs
from linuxcnc_runs import copy_configuration, own_folder
from screen import Screen
from starts import starts

PATIENCE = 100  # s; a screen that does not come leaves LinuxCNC's window of errors open
# Configuration, INI file, OPEN_FILE.
SCREENS = (
    ("growth", "axis.ini", "accelerated.ngc"),
    ("portal", "axis_portal.ini", "portal_cube.ngc"),
    ("portal", "axis_column.ini", "cube.ngc"),
    ("three_axis", "axis.ini", "sample.ngc"),
)


class Axis(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.display = Screen(cls).display

    def work(self, configuration, ini, operator=""):
        """What the operator has seen of a screen."""
        folder = own_folder(self)
        machine = copy_configuration(configuration, folder)
        operator = operator or ("axis_operator.py" if configuration == "three_axis" else "axis_operator.py panel")
        ini = linuxcnc_runs.with_operator(os.path.join(machine, ini), operator)
        return linuxcnc_runs.work_screen(folder, ini, self.display, speed=4, patience=PATIENCE)

    def test_each_opens_its_program_and_homes_without_an_error(self):
        for configuration, ini, program in SCREENS:
            with self.subTest(configuration + "/" + ini):
                seen = linuxcnc_runs.despite_axis(lambda: self.work(configuration, ini))
                self.assertEqual(seen["program"], program)
                self.assertEqual(seen["errors"], [])

    def test_strokes_begin_change_and_end_by_the_finger(self):
        seen = linuxcnc_runs.despite_axis(lambda: self.work("grinder", "axis.ini", "chopping_operator.py"))
        self.assertEqual(seen["program"], "contour.ngc")
        self.assertIn("The upper dead point must be above the lower one.", seen["swapped"])
        self.assertIn("12000 mm/min", seen["too fast"])
        self.assertIn("First the axis moves to point R, by \u221215 mm.", seen["question"])
        self.assertFalse(seen["before the answer"])
        self.assertEqual(seen["region"], [-20, -40, -15, 50])
        self.assertEqual(seen["section"], [-35, -25, 0.5])
        self.assertEqual(seen["second"], 0)
        self.assertTrue(seen["strokes on"])
        self.assertTrue(seen["still strokes"])
        self.assertFalse(seen["strokes"])
        self.assertEqual(len(seen["log"]), 2)


tearDownModule = starts("grinder/axis.ini", "growth/axis.ini", "portal/axis_portal.ini", "portal/axis_column.ini", "three_axis/axis.ini")


if __name__ == "__main__":
    unittest.main()

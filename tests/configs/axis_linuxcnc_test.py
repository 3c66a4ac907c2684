#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The screens of grinder, growth, portal and three_axis: AXIS opens the program, the panel comes, and the machine homes."""

import os
import unittest

import linuxcnc_runs
from linuxcnc_runs import copy_configuration, own_folder
from long import long
from screen import Screen
from starts import starts

PATIENCE = 100  # s; a screen that does not come leaves LinuxCNC's window of errors open
# Configuration, INI file, OPEN_FILE.
SCREENS = (
    ("portal", "axis_column.ini", "cube.ngc"),
    ("three_axis", "axis.ini", "sample.ngc"),
)


class Axis(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.display = Screen(cls).display

    def work(self, configuration, ini, operator="", **more):
        """What the operator has seen of a screen."""
        folder = own_folder(self)
        machine = copy_configuration(configuration, folder)
        operator = operator or ("axis_operator.py" if configuration == "three_axis" else "axis_operator.py panel")
        ini = linuxcnc_runs.with_operator(os.path.join(machine, ini), operator, **more)
        return linuxcnc_runs.work_screen(folder, ini, self.display, speed=4, patience=PATIENCE)

    def test_each_opens_its_program_and_homes_without_an_error(self):
        for configuration, ini, program in SCREENS:
            with self.subTest(configuration + "/" + ini):
                seen = linuxcnc_runs.despite_axis(lambda: self.work(configuration, ini))
                self.assertEqual(seen["program"], program)
                self.assertEqual(seen["errors"], [])

    @long
    def test_without_halui_a_running_program_is_noticed(self):
        without = linuxcnc_runs.at_the_end()
        seen = linuxcnc_runs.despite_axis(lambda: self.work("portal", "axis_portal.ini", "portal_operator.py", HAL=lambda lines: [
            line for line in without(lines) if not line.startswith("HALUI")]))
        self.assertEqual(seen["program"], "portal_cube.ngc")
        self.assertEqual(seen["errors"], [])
        self.assertFalse(seen["halui"])
        for state in ("running", "paused"):
            with self.subTest(state):
                self.assertIn("refused", seen[state])
                self.assertIn("refused", seen["undo, " + state])
        self.assertEqual(seen["moved"], 0)
        self.assertEqual(seen["still"], 0.5)
        self.assertFalse(seen["on"])

    @long
    def test_a_growth_test_is_begun_lost_stopped_and_resumed_by_the_finger(self):
        first, second = linuxcnc_runs.despite_axis(self.days_of_growth)
        self.assertEqual(first["program"], "accelerated.ngc")
        self.assertIn("There is no interrupted test.", first["nothing to resume"])
        self.assertFalse(first["before the answer"])
        self.assertFalse(first["tick"], "a test whose program has ended is none that runs")
        self.assertIn("Start LinuxCNC again, then resume.ngc.", first["lost"])
        self.assertIn("refused before a restart", first["not yet"])
        self.assertEqual(second["pass"], 1)

    def days_of_growth(self):
        folder = own_folder(self)
        machine = copy_configuration("growth", folder)
        ini = linuxcnc_runs.with_operator(os.path.join(machine, "axis.ini"), "growth_operator.py")
        days = []
        for _ in range(2):
            days.append(linuxcnc_runs.work_screen(folder, ini, self.display, speed=4, patience=PATIENCE))
            os.remove(os.path.join(machine, "widgets.json"))
        return days

    @long
    def test_strokes_begin_change_and_end_by_the_finger(self):
        seen = linuxcnc_runs.despite_axis(lambda: self.work("grinder", "axis.ini", "chopping_operator.py", CHOPPING=["SECTIONS = 4"]))
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
        self.assertIn("At rest at point R.", seen["at rest"])
        self.assertIn("away from point R", seen["held"])
        self.assertIn("away from point R. Offset: \u2212", seen["away"])
        self.assertFalse(seen["ticks"])
        self.assertFalse(seen["moved unasked"])
        self.assertEqual(seen["old question"], "")
        self.assertEqual(seen["entered"], "-47")
        self.assertIn("Start: refused. The machine is off.", seen["in emergency stop"])


tearDownModule = starts("grinder/axis.ini", "growth/axis.ini", "portal/axis_portal.ini", "portal/axis_column.ini", "three_axis/axis.ini")


if __name__ == "__main__":
    unittest.main()

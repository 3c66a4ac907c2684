#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of AXIS, before the complete mill: a finger learns a part, makes the machine square and changes a setting, over a restart."""

import os
import re
import sys
import unittest

import linuxcnc_runs
from linuxcnc_runs import PROGRAMS, copy_configuration, own_folder
from screen import Screen
from starts import starts

sys.path.append(PROGRAMS)
import lamp  # noqa: E402
from long import long


@long
class Days(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        linuxcnc_runs.despite_axis(cls.work)

    @classmethod
    def work(cls):
        folder = own_folder(cls)
        machine = copy_configuration("mill", folder)
        display = Screen(cls).display
        with open(os.path.join(machine, "leaning.hal"), "w") as file:
            file.write("setp square.ec0y 0\nsetp square.ea0y 0\n")
        with open(os.path.join(machine, "messages.toml"), "w") as file:
            file.write(lamp.MESSAGES)
        leaning = linuxcnc_runs.after("HALFILE = square_settings.hal", "HALFILE = leaning.hal")
        ini = linuxcnc_runs.with_operator(os.path.join(machine, "axis.ini"), "panel_operator.py", HAL=leaning)
        cls.days = []
        for _ in range(2):
            cls.days.append(linuxcnc_runs.work_screen(folder, ini, display, speed=4))
            os.remove(os.path.join(machine, "widgets.json"))

    def test_a_part_is_learnt_by_the_finger(self):
        self.assertIn("5 contacts of all programs are kept", self.days[0]["reference"])

    def test_a_button_that_moves_is_refused_while_the_machine_is_off(self):
        self.assertIn("refused", self.days[0]["refused"])

    def test_a_machine_that_is_off_corrects_no_tilt(self):
        self.assertIn("The machine is off. Turn the machine on.", self.days[0]["off"])

    def test_a_machine_that_stands_still_is_not_corrected_in_the_emergency_stop_nor_unhomed(self):
        off, unhomed = self.days[1]["asleep"]
        self.assertIn("The machine is off.", off)
        self.assertIn("The machine is not homed.", unhomed)
        self.assertFalse(self.days[1]["asleep ticks"])
        self.assertEqual(self.days[1]["asleep applied"], 0)

    def test_a_contact_that_never_came_is_not_of_a_moment_ago(self):
        self.assertIn("No contact has counted since the start.", self.days[1]["no contact yet"])
        self.assertEqual(self.days[1]["ago"], "")

    def test_a_dead_retain_is_no_switch_and_keeps_nothing(self):
        self.assertIn("Start LinuxCNC again.", self.days[1]["retain died"])
        self.assertIn("Off: plumb-retain", self.days[1]["overview"])
        self.assertEqual(self.days[1]["switched off"], "")
        self.assertEqual(self.days[1]["promise"], "")

    def test_nothing_moves_an_axis_in_a_paused_program_but_switching_off_which_says_how_far(self):
        self.assertIn("refused", self.days[0]["paused"])
        self.assertEqual(self.days[0]["moved in the pause"], 0)
        self.assertEqual(self.days[0]["held"], 0, "after Off, until the program ends")
        announced = re.search(r"X ([+\u2212][\d.]+) \u00b5m", self.days[0]["announced"])[1].replace("\u2212", "-")
        self.assertGreater(abs(float(announced)), 10)
        self.assertAlmostEqual(float(announced), 1000 * self.days[0]["moved"], delta=0.2)

    def test_a_reference_that_waits_is_not_learnt_again(self):
        self.assertIn("Do not learn again", self.days[1]["morning"])
        self.assertIn("A kept reference of this program is replaced; 5 contacts are kept.", self.days[1]["replaces"])

    def test_a_new_reference_is_taken_back(self):
        former, learnt, after = self.days[1]["references"]
        self.assertEqual(len(former), 5)
        self.assertNotEqual(learnt, former)
        self.assertEqual(after, former)

    def test_a_message_waits_behind_the_panel(self):
        question, texts = self.days[1]["in front"]
        self.assertTrue(question)
        self.assertEqual([text for text in texts if "lamp" in text], [])

    def test_a_residual_changes_its_lean_and_no_other(self):
        self.assertAlmostEqual(self.days[1]["residual"], -0.00016 - 0.001 / 300, delta=1e-9)
        self.assertEqual(*self.days[1]["others"])
        for error in self.days[1]["with residual"]:
            self.assertLess(abs(error), 3)

    def test_a_lean_that_corrects_nothing_is_not_offered_and_a_square_says_its_uncertainty(self):
        self.assertFalse(self.days[1]["offered"])
        self.assertRegex(self.days[1]["after"], r"\u00b1[\d.]+ \u00b5m \(k=2\)")

    def test_a_new_chain_waits_for_the_restart(self):
        self.assertIn("start LinuxCNC again", self.days[1]["new chain"])

    def test_a_new_component_leaves_a_half_filled_form_and_its_sensors_have_a_page(self):
        self.assertEqual(self.days[1]["stopped entries"], ["0.04"], "after an emergency stop")
        self.assertEqual(self.days[1]["entries"], ["0.04"])
        self.assertIn("spindle-load", self.days[1]["lost sensor"])

    def test_homing_is_no_alarm_in_production(self):
        self.assertEqual(self.days[0]["waiting"], "")

    def test_a_changed_setting_wins_over_the_hal_file_after_a_restart(self):
        self.assertEqual(self.days[1]["gate-floor"], 0.025)
        self.assertIn("anna", self.days[1]["change"])

    def test_leaning_machine_is_made_square_by_the_finger_and_is_square_after_a_restart(self):
        self.assertEqual(self.days[1]["angles"], [-0.00016, 0.00012])
        for axis, leaning, square, lean in zip("XZ", self.days[0]["leaning"], self.days[1]["square"], (48, 36)):
            with self.subTest(axis):
                self.assertAlmostEqual(abs(leaning), lean, delta=2)  # um over 300 mm
                self.assertLess(abs(square), 2)


class OwnWindow(unittest.TestCase):
    """plumb panel in its own window stays when LinuxCNC ends."""

    def test_it_says_that_linuxcnc_has_ended_and_comes_back_with_the_next_start(self):
        folder = own_folder(self)
        machine = copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "mill.ini"))
        seen = linuxcnc_runs.work_screen(folder, ini, Screen(self).display, speed=4, program=[os.path.join(PROGRAMS, "panel_waits.py"), ini])
        for name in ("first", "second"):
            self.assertIn("LinuxCNC has ended. This screen waits for the next start.", seen[name + " end"])
            self.assertTrue(seen[name + " lives"])
            self.assertLessEqual(seen[name + " lowest"], 740, "px, the height of the window, which the sentence leaves as it is")
        self.assertLess(seen["took"], 5, "without LinuxCNC it ends at once")
        self.assertIn("M64 P30", seen["answer"], "a shift of contacts is answered by a digital output")


tearDownModule = starts("mill/axis.ini")


if __name__ == "__main__":
    unittest.main()

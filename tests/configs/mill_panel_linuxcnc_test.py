#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a tab of AXIS, before the complete mill: a finger learns a part, makes the machine square and changes a setting, over a restart."""

import os
import unittest

import linuxcnc_runs
from linuxcnc_runs import copy_configuration, own_folder
from screen import Screen


ATTEMPTS = 3


class Days(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        for attempt in range(ATTEMPTS):
            try:
                return cls.work()
            except AssertionError as error:  # AXIS lost a command or a press, in 1 of 6 runs
                if attempt + 1 == ATTEMPTS:
                    raise
                print("The days begin afresh:\n%s" % error)
        return None

    @classmethod
    def work(cls):
        folder = own_folder(cls)
        machine = copy_configuration("mill", folder)
        display = Screen(cls).display
        angles = os.path.join(machine, "square_settings.hal")
        for text in ("square.ec0y -0.00016", "square.ea0y  0.00012"):
            linuxcnc_runs.change(angles, text, text.split()[0] + " 0")
        linuxcnc_runs.add_operator(machine, "axis.ini", "panel_operator.py")
        cls.days = []
        for _ in range(2):
            cls.days.append(linuxcnc_runs.work_screen(folder, machine, "axis.ini", display, speed=4))
            os.remove(os.path.join(machine, "widgets.json"))

    def test_a_part_is_learnt_by_the_finger(self):
        self.assertIn("Valid, of 5 contacts", self.days[0]["reference"])

    def test_a_button_that_moves_is_refused_while_the_machine_is_off(self):
        self.assertIn("refused", self.days[0]["refused"])

    def test_a_changed_setting_wins_over_the_hal_file_after_a_restart(self):
        self.assertEqual(self.days[1]["gate-floor"], 0.025)
        self.assertIn("anna", self.days[1]["change"])

    def test_leaning_machine_is_made_square_by_the_finger_and_is_square_after_a_restart(self):
        self.assertEqual(self.days[1]["angles"], [-0.00016, 0.00012])
        for axis, leaning, square, lean in zip("XZ", self.days[0]["leaning"], self.days[1]["square"], (48, 36)):
            with self.subTest(axis):
                self.assertAlmostEqual(abs(leaning), lean, delta=2)  # um over 300 mm
                self.assertLess(abs(square), 2)


if __name__ == "__main__":
    unittest.main()

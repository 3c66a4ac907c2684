#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/portal: squareness is switched off amid a cut of a program, by the servo cycles of a complete LinuxCNC."""

import os
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, own_folder, read_recording, um

RAPID, FEED = 1, 2  # motion types
LEAVES = 14  # function-status


class Off(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("portal", folder)
        its, _ = linuxcnc_runs.work(folder, linuxcnc_runs.own_ini(os.path.join(machine, "column.ini")), "off_scenario.py")
        cls.shift = shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.correction = np.array([shift["square.%s-correction" % letter] for letter in "xyz"])
        cls.error = np.linalg.norm([shift["portal.truth-%s-error" % letter] for letter in "xyz"], axis=0)
        leaves = np.flatnonzero(shift["interlock.function-status-0"] == LEAVES)
        cls.off, cls.gone = leaves[0], leaves[-1] + 1

    def test_in_the_cut_the_correction_holds(self):
        cut = np.arange(self.off, self.gone - 1)
        self.assertGreater(len(cut), 500)
        self.assertTrue((self.shift["interlock.function-enable-0"][cut] == 1).all())
        self.assertLess(self.error[cut].max(), 1 * um)

    def test_it_returns_from_the_rapid_move_on(self):
        self.assertEqual(self.shift["motion.motion-type"][self.gone], RAPID)
        self.assertEqual(self.shift["interlock.function-enable-0"][self.gone + 1], 0)

    def test_the_next_cut_waits_until_it_has_returned(self):
        """LinuxCNC begins a move in the period in which its kind is seen, and brakes."""
        rest = np.arange(self.gone, len(self.shift["time"]))
        cuts = self.shift["motion.motion-type"][rest] == FEED
        away = abs(self.correction[:, rest]).max(axis=0) > 1 * um
        speed = self.shift["motion.current-vel"][rest]
        self.assertGreater(np.count_nonzero(cuts & away) * PERIOD, 1, "s of a cut that waits")
        self.assertLess(speed[cuts & away].sum() * PERIOD, 20 * um)
        self.assertGreater(speed[cuts & ~away].max(), 49)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/grinder/face.ini: X feeds the wheel in while Z strokes, in a complete LinuxCNC, judged by the servo cycles of a shift."""

import os
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, nm, own_folder, read_recording, um
from starts import starts

SIZE, TOTAL, UPPER = -0.2, 0.2, 2  # of face.ngc, in mm
HARDEST = 50  # mm/s2, chop.infeed-max-accel
STOPS = ["%s_%s" % (stop, moment) for moment in ("stroke", "infeed", "spark_out") for stop in ("abort", "emergency_stop", "off")]


class Face(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("grinder", folder)
        its, cls.output = linuxcnc_runs.work(folder, linuxcnc_runs.own_ini(os.path.join(machine, "face.ini")), "grinder_face_scenario.py")
        cls.facts = its["facts"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, its["scenes"])

    def test_wear_of_the_wheel_stays_after_spark_out_and_deflection_goes(self):
        for number, (before, after) in enumerate(self.facts["wheels"]):
            for state in (before, after):
                state[2] = state[0] - SIZE - state[1]  # the last infeed has no contact yet
            print("wheel %d: the face is %.1f um too high when the infeed ends, by %.1f um of wear and %.1f um of deflection; after"
                  " spark-out %.1f um, by %.1f and %.1f" % (number, *(each / um for state in (before, after) for each in (state[0] - SIZE, *state[1:]))))
            self.assertGreater(before[2], 10 * um)
            self.assertLess(after[2], before[2] / 6)
            self.assertGreaterEqual(after[1], before[1])
            self.assertGreater(after[1], 1 * um)
            self.assertLess(after[2], 5 * um)

    def test_a_gauge_leaves_no_wear(self):
        face = self.facts["gauge"][0]
        self.assertLess(face, SIZE)
        self.assertGreater(face, SIZE - 15 * um)  # of the deflection, in the spark-out strokes

    def test_rough_and_finish_reach_the_size(self):
        face, wear, deflection = self.facts["two_strokes"]
        self.assertAlmostEqual(face, SIZE + wear + deflection, delta=0.5 * um)
        self.assertLess(deflection, 2 * um)

    def test_the_origin_follows_the_dressed_wheel(self):
        self.assertAlmostEqual(self.facts["dressing"], -0.02, delta=1 * nm)

    def test_the_joint_moves_inward_only_where_the_stroke_stands_at_the_clear_dead_point(self):
        z, x = self.shift["chop.command"], self.shift["x-stage.applied-offset"]
        inward = np.flatnonzero(np.diff(x) < -1e-9) + 1
        self.assertGreater(len(inward), 1000)
        self.assertLess(abs(z[inward] - UPPER).max(), 3.2)  # in dressing at 5
        self.assertGreater(z[inward].min(), UPPER - 0.1)
        moving = inward[abs(z[inward] - z[inward - 1]) > nm]
        # A stop takes the speed that the infeed had.
        slower = np.diff(x)[moving - 1] > np.diff(x)[moving - 2]
        self.assertTrue(slower.all())

    def test_nothing_is_deeper_than_the_total(self):
        x = self.shift["x-stage.applied-offset"]
        self.assertGreaterEqual(x.min(), -0.3 - nm)  # of gauge.ngc
        for name in STOPS:
            self.assertGreaterEqual(x[self.rows[name + "_again"]].min(), -TOTAL - nm, name)

    def test_each_stop_is_continued_to_the_size(self):
        for name in STOPS:
            _deep, _left, face, wear, deflection = self.facts[name]
            self.assertAlmostEqual(face, SIZE + wear, delta=0.5 * um, msg=name)
            self.assertLess(deflection, 0.5 * um, name)

    def test_an_abort_takes_the_infeed_back_in_its_period_and_machine_off_freezes_it(self):
        for name in STOPS:
            deep, left = self.facts[name][:2]
            rows = self.rows[name + "_stopped"]
            x = self.shift["x-stage.applied-offset"][rows]
            if name.startswith("abort"):
                self.assertEqual(left, 0, name)
                ordered = np.flatnonzero(self.shift["chop.program-word"][rows] == 15)[0]
                first = np.flatnonzero(np.diff(x) > 1e-9)[0]
                self.assertLessEqual(first, ordered + 3, name)
            else:
                # LinuxCNC's abort takes a part back before the machine is off.
                self.assertLessEqual(left, deep + 10 * um, name)
                self.assertLess(np.ptp(x[-round(1 / PERIOD):]), 0.1 * nm, name)
            brakes = 0.1  # s, of an infeed that was under way
            self.assertGreaterEqual(np.diff(x[int(brakes / PERIOD):]).min(), -1e-9, name)


tearDownModule = starts("grinder/face.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Face, __doc__)

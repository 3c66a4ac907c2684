# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench circle: its law and its circle of least squares by hand, and one machine."""

import math
import os
import unittest

import numpy as np

from bench_runs import run_bench
from plumb_folder import TemporaryFolder
from support import circle_machine


def machine(feed, radius):
    return circle_machine.Drawn(1, "xy", feed, radius, 30, {}, {}, 0)


class Figures(unittest.TestCase):
    def test_law_of_the_turn_is_that_of_the_readme(self):
        self.assertAlmostEqual(1000 * circle_machine.kept(0.01, machine(1000, 150)), 1.2, 1)
        self.assertAlmostEqual(1000 * circle_machine.kept(0.01, machine(3000, 50)), 4.7, 1)
        self.assertGreater(circle_machine.kept(0.01, machine(5000, 25)), circle_machine.kept(0.01, machine(3000, 50)))

    def test_centre_and_mean_radius_are_no_deviation(self):
        angles = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
        deviation = circle_machine.centred(angles, 50 + 0.02 * np.cos(angles) - 0.01 * np.sin(angles) + 0.003 * np.cos(2 * angles))
        self.assertAlmostEqual(np.abs(deviation).max(), 0.003)

    def test_machines_are_drawn_by_their_number_from_their_range(self):
        self.assertEqual(circle_machine.draw(5), circle_machine.draw(5))
        drawn = [circle_machine.draw(seed) for seed in range(1, 100)]
        self.assertEqual({its.plane for its in drawn}, set(circle_machine.PLANES))
        for its in drawn:
            self.assertTrue(500 <= its.feed <= 5000 and 25 <= its.radius <= 150 and 17 <= its.gain <= 60)
            self.assertTrue(all(0 <= play <= 0.02 for play in its.play.values()))


class Bench(unittest.TestCase):
    def test_one_machine_keeps_its_limits_and_is_drawn(self):
        with TemporaryFolder() as folder:
            done = run_bench("circle", "--seeds", "1", "--seed", "9001", "--output", folder)
            status, output, errors = done.returncode, done.stdout, done.stderr
            self.assertEqual(status, 0, output + errors)
            self.assertRegex(output, r"peak at most 1\.2 times the law and 0\.3 um: +1 of 1\n")
            self.assertRegex(output, r"at rest at most 0\.5 um and U of the indicator: 1 of 1\n")
            self.assertRegex(output, r"opening by ballbar within 1\.5 urad or its U: +1 of 1, noise 0\.3 um\n")
            self.assertEqual(sorted(os.listdir(folder)), ["circles.png", "circles.svg", "machines.csv"])
            without, corrected = (float(line.split()[-1]) for line in output.splitlines() if line.startswith("peak w"))
            self.assertLess(corrected, 0.7 * without)
            whole, left = (float(line.split()[-1]) for line in output.splitlines() if line.startswith("G w"))
            self.assertLess(left, 0.7 * whole)
            self.assertGreater(whole, 1.5 * without, "steps on both sides of the mean circle")
            self.assertTrue(math.isfinite(corrected))


if __name__ == "__main__":
    unittest.main()

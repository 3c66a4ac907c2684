# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench volume: its machine by hand, its coverage, and a few machines."""

import os
import tempfile
import unittest

import numpy as np

import volume
from bench_runs import run_bench
from support import volume_machine


class Figures(unittest.TestCase):
    def test_a_machine_without_errors_has_its_tip_where_it_is_sent(self):
        machine = volume_machine.Machine(1, {}, {axis: (0, 0, 0) for axis in "XYZ"})
        np.testing.assert_allclose(machine.tip((10, 20, -30), 1), [10, 20, -230])

    def test_leans_turn_what_they_carry_and_lost_motion_lags(self):
        machine = volume_machine.Machine(1, {"EC0Y": 1e-4, "EA0Z": 2e-4}, {"X": (0, 0, 0.005), "Y": (1e-5, 0, 0), "Z": (0, 0, 0)})
        tip = machine.tip((10, 600, -500), 1) - np.array([10, 600, -700])
        np.testing.assert_allclose(tip, [-0.005 - 0.06 - 2e-4 * 700 * 1e-4, 0.006 + 0.14, 0], atol=2e-5)
        self.assertAlmostEqual(machine.tip((10, 600, -500), -1)[0] - machine.tip((10, 600, -500), 1)[0], 0.01)

    def test_coverage_is_that_of_the_components(self):
        outcome = volume_machine.Outcome(1, np.array([[1.0, 0, 3], [0, 3, 1]]), np.full((2, 3), 2.0), np.array([4.0, 2]), 9, [])
        axes, together, worst = volume.coverage([outcome])
        np.testing.assert_allclose(axes, [100, 50, 50])
        self.assertAlmostEqual(together, 400 / 6)
        self.assertAlmostEqual(worst, 500 / 6)


class Bench(unittest.TestCase):
    def test_few_machines_are_within_what_is_stated(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run_bench("volume", "--seeds", "4", "--seed", "9001", "--output", folder)
            output, errors = done.stdout, done.stderr
            without, corrected, stated = (float(line.split()[-1]) for line in output.splitlines() if line.startswith("largest "))
            self.assertGreater(without, 30, output + errors)
            self.assertLess(corrected, 10)
            self.assertLess(stated, 10)
            self.assertRegex(output, r"components inside their U: X [\d.]+ %, Y [\d.]+ %, Z [\d.]+ %; all (8[5-9]|9\d|100)\.\d %")
            self.assertEqual(sorted(os.listdir(folder)), ["corners.csv", "coverage.png", "coverage.svg"])


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench pairs, in short, and the thresholds and the bound that stand beside its figures."""

import unittest

import numpy as np

import pairs
from bench_runs import run_bench
from pairs import CASES, FIT, MIDDLE
from support.figures import rms

PAIRS = 80  # 8 % of an rms is its standard deviation


class Pairs(unittest.TestCase):
    def scatter(self, case):
        return pairs.simulate(case, PAIRS, lambda seconds: True)

    def test_load_at_1_khz(self):
        self.check(CASES[0], 1.2)

    def test_load_that_is_held_8_ms_and_coarse(self):
        self.check(CASES[1], 3.0)

    def check(self, case, most):
        scatter = self.scatter(case)
        self.assertLess(rms(scatter.errors[FIT]), most)
        self.assertGreater(rms(scatter.errors[MIDDLE]), 12)
        self.assertLess(abs(scatter.errors[FIT].mean()), 3 * most / np.sqrt(PAIRS))
        self.assertAlmostEqual(rms(scatter.sigma) / rms(scatter.errors[FIT]), 1, delta=0.35)


def rise(height, first=300, length=700):
    """Loads behind the filter, of a contact at the sample before the first that is not 0."""
    time = pairs.PERIOD * (np.arange(length) - first + 1)
    return np.where(time > 0, height * -np.expm1(-time / pairs.LAG), 0)


class Thresholds(unittest.TestCase):
    def test_middle_comes_later_where_the_load_is_lower(self):
        usual, soft = (pairs.crosses_middle(rise(step), -0.299) for step in (8, 6.4))
        self.assertAlmostEqual(usual, 0.03 * np.log(2), delta=0.001)
        self.assertAlmostEqual(soft - usual, 0.03 * np.log(4 / 3), delta=0.001)

    def test_low_one_is_interpolated_and_lasts(self):
        load = rise(8)
        usual = pairs.crosses_low(load, -0.299)
        self.assertGreater(usual, 0.005)
        self.assertLess(usual, 0.015)
        load[100:103] = 6  # shorter than the debounce time
        self.assertAlmostEqual(pairs.crosses_low(load, -0.299), usual, delta=1e-6)


class Bound(unittest.TestCase):
    def test_is_that_of_white_noise_and_a_little_more_for_what_is_not_known(self):
        one = 1000 * pairs.FEED * 0.3 / 8 * np.sqrt(2 * 0.03 * 0.001)
        bound = pairs.bound(CASES[0])
        self.assertGreater(bound, one * np.hypot(1, 1 / 0.8))
        self.assertLess(bound, 1.15 * one * np.hypot(1, 1 / 0.8))


class Command(unittest.TestCase):
    def test_prints_a_table(self):
        done = run_bench("pairs", "--pairs", "3")
        for case in CASES:
            self.assertIn(case.name, done.stdout)

    def test_number_of_pairs_is_checked(self):
        done = run_bench("pairs", "--pairs", "0")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--pairs: '0'", done.stderr)


if __name__ == "__main__":
    unittest.main()

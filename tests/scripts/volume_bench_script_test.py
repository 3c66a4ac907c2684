# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench volume: its machine by hand, its coverage, and a few machines."""

import os
import re
import unittest

import numpy as np

import volume
from bench_runs import run_bench
from plumb_folder import TemporaryFolder
from support import volume_list, volume_machine, volume_methods


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


    def test_methods_agree_within_twice_the_uncertainty_of_their_difference(self):
        corner = volume_methods.Corner("XY", 0, {"square": (10e-6, 3e-6), "diagonals": (19e-6, 4e-6), "ballbar": (-30e-6, 1e-6)})
        agree, contradict, pairs = volume_methods.agreement([corner])
        self.assertAlmostEqual(agree, 100 / 3)
        self.assertEqual((contradict, pairs), (2, 3))

    def test_a_direction_for_each_axis_is_that_of_its_lost_motion(self):
        machine = volume_machine.Machine(1, {}, {"X": (0, 0, 0.005), "Y": (0, 0, 0.003), "Z": (0, 0, 0)})
        np.testing.assert_allclose(machine.tip((0, 0, 0), (1, -1, 0)), [-0.005, 0.003, -200])


class Listed(unittest.TestCase):
    def machine(self, **changed):
        still = {(axis, e): (0, 0, 0) for axis in "XYZ" for e in range(6)}
        its = {"tilts": {}, "shapes": still, "lost": dict.fromkeys("XYZ", (0, 0)), "second": np.zeros(3), "warmed": 0, "growth": dict.fromkeys("XYZ", 0), "bending": {}, "drift": 0}
        its["shapes"] = {**still, **changed.pop("shapes", {})}
        return volume_list.Machine(1, **{**its, **changed})

    def test_each_error_displaces_the_tip_to_its_side(self):
        place = np.array([800, 600, 0])
        for changed, expected in (
            ({}, (0, 0, 0)),
            ({"shapes": {("X", 1): (0.003, 0, 0)}}, (0, 0.003, 0)),
            ({"shapes": {("Y", 3): (1e-5, 0, 0)}}, (0, 1e-5 * 200, 0)),  # EAY turns the tool of 200 mm
            ({"shapes": {("X", 5): (1e-5, 0, 0)}}, (0.006, -0.008, 0)),  # ECX turns the work about its zero
            ({"lost": {"X": (0.01, 0), "Y": (0, 0), "Z": (0, 0)}}, (-0.005, 0, 0)),
            ({"tilts": {"EC0Y": 1e-5}}, (-0.006, 0, 0)),
            ({"second": np.array([0.001, 0, 0])}, (0.002, 0, 0)),
            ({"warmed": 2, "growth": dict.fromkeys("XYZ", 1e-5)}, (0.016, 0.012, 0.01)),
            ({"warmed": 2, "bending": {"EC0Y": 1e-5}}, (-0.012, 0, 0)),
        ):
            with self.subTest(changed):
                np.testing.assert_allclose(self.machine(**changed).tip(place, 1) - place - [0, 0, -200], expected, atol=2e-6)

    def test_one_of_five_is_drawn_twice_as_wide(self):
        import random

        drawn = random.Random(3)
        values = np.array([volume_list.wide(drawn) for _ in range(40000)])
        self.assertAlmostEqual(values.std(), 1, delta=0.02)
        self.assertGreater(np.mean(np.abs(values) > 3), 2 * 0.0027)  # a normal distribution has 0.27 % there

    def test_figures_miss_a_U_that_is_too_large_or_too_small(self):
        drawn = np.random.default_rng(2)
        errors = drawn.normal(0, 1, (400, 3))
        for U, good in ((2, True), (1, False), (4, False)):
            its = volume_list.Outcome(1, *({way: value for way in volume_list.WAYS} for value in (errors, np.full((400, 3), U), np.full(400, U), errors[:, 0])), [True, True])
            self.assertEqual(volume_list.figures([its])[1], good, U)
        its.open_states = [True, False]
        self.assertFalse(volume_list.figures([its])[1])


class Bench(unittest.TestCase):
    def test_few_machines_are_within_what_is_stated(self):
        with TemporaryFolder() as folder:
            done = run_bench("volume", "--seeds", "4", "--seed", "9001", "--output", folder)
            output, errors = done.stdout, done.stderr
            without, corrected, stated = (float(line.split()[-1]) for line in output.splitlines() if line.startswith("largest "))
            self.assertGreater(without, 30, output + errors)
            self.assertLess(corrected, 10)
            self.assertLess(stated, 10)
            self.assertRegex(output, r"components inside their U: X [\d.]+ %, Y [\d.]+ %, Z [\d.]+ %; all (8[5-9]|9\d|100)\.\d %")
            agree, pairs, contradict = re.search(r"ballbar: ([\d.]+) % of (\d+) pairs agree within 2 u, (\d+) of contrary sign", output).groups()
            self.assertGreater(float(agree), 85)
            self.assertEqual((pairs, contradict), ("72", "0"))
            self.assertEqual(sorted(os.listdir(folder)), ["corners.csv", "coverage.png", "coverage.svg"])

    def test_a_list_that_is_filled_covers_and_one_with_a_gap_says_so(self):
        done = run_bench("volume", "--list", "--seeds", "2", "--seed", "9001")
        self.assertEqual(len(re.findall(r"(?m)^(assumed|measured) +2 machines: ([7-9]\d|100)\.\d % of the components within their U", done.stdout)), 2, done.stdout + done.stderr)
        self.assertIn('one line left out: 100 % state "at least", and name it', done.stdout)

    def test_drawn_tables_survive_the_files_of_others(self):
        done = run_bench("volume", "--files", "--seeds", "2", "--seed", "9001")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.count("2 tables there and back"), 5)
        self.assertIn("78 of 78 taken rightly, or refused with file and reason", done.stdout)


if __name__ == "__main__":
    unittest.main()

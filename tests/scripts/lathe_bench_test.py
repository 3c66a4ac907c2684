# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/lathe/bench.hal: first the disease, then the cure; and the figures of scripts/bench lathe on a few lathes."""

import os
import unittest

import numpy as np

import lathe
from bench_runs import run_bench
from plumb_folder import TemporaryFolder
from support import lathe_machine, lathe_strangers
from support.figures import rms
from support.lathe_machine import Case, Outcome, simulate
from support.second_lathe import SecondCase, simulate_second

EDGE = lathe.EDGE
SEEDS = range(1, 201)


def no_news(_):
    return True


class Configuration(unittest.TestCase):
    """As it is shipped."""

    def turned(self, **pins):
        """The height of the tool at the end in um, and the error of the finished diameter in um."""
        import plumb

        with plumb.Host() as host:
            host.load(lathe_machine.CONFIG)
            for name, value in pins.items():
                host.set("trial." + name, value)
            host.command("start")
            host.run(10)
            self.assertEqual(host.get(["trial.done", "centre.fault", "centre.detail-code"]), [True, 0, 0])
            height, diameter = host.get(["lathe.truth-height", "lathe.truth-diameter"])
            return 1000 * height, 1000 * (diameter - host.get("trial.finish-diameter"))

    def test_without_correction_the_tool_stays_high_and_the_diameter_is_wrong(self):
        height, diameter = self.turned(correct=False)
        self.assertGreater(height, 90)
        self.assertGreater(diameter, 30)

    def test_with_correction_it_is_on_centre_and_the_diameter_is_right(self):
        height, diameter = self.turned()
        self.assertLess(abs(height), 12)
        self.assertLess(abs(diameter), 20)  # growth, wear and built-up edge go on

    def test_eight_cuts_do_as_well(self):
        height, _ = self.turned(plan=3)
        self.assertLess(abs(height), 12)


class Figures(unittest.TestCase):
    def residual(self, *case, least_moved=0.5):
        outcome = simulate(Case(*case), SEEDS, no_news)
        moved = outcome.moved
        self.assertGreater(moved.mean(), least_moved)
        self.assertLessEqual(lathe.worse(outcome), 3)
        return rms(outcome.residual[moved]), rms(outcome.residual[moved] / outcome.sigma[moved])

    def test_lands_reach_their_figures(self):
        for case, limit in (
            ((1, "lands ABBA", 0, 0), 0.5),
            ((10, "lands ABBA", 0, 0), 0.6),
            ((1, "one pair of lands", 0, EDGE), 2.5),
            ((10, "one pair of lands", 0, EDGE), 4.6),
            ((1, "lands ABBA x 3", 0, EDGE), 1.3),
            ((10, "lands ABBA x 3", 0, EDGE), 1.9),
            ((10, "lands ABBA", 7, 0), 0.9),
            ((1, "one pair of lands", 7, EDGE), 8.5),
            ((10, "lands ABBA x 3", 7, EDGE), 3.3),
        ):
            with self.subTest(case):
                self.assertLess(self.residual(*case)[0], limit)

    def test_sigma_is_the_scatter(self):
        for case in ((10, "two cuts"), (1, "one pair of lands"), (10, "lands ABBA x 3"), (10, "step of Y"), (10, "eight cuts")):
            with self.subTest(case):
                self.assertAlmostEqual(self.residual(*case, 0, EDGE, least_moved=0.3)[1], 1, delta=0.25)

    def test_micrometer_is_within_8_um(self):
        outcome = simulate(Case(10, "lands ABBA", 0, EDGE, True), SEEDS, no_news)
        self.assertLess(np.percentile(np.abs(outcome.residual[outcome.moved]), 95), 9)

    def test_two_cuts_refuse_small_heights(self):
        outcome = simulate(Case(1, "two cuts", 0, EDGE), SEEDS, no_news)
        small = np.abs(outcome.truth) < 15
        self.assertGreater(small.sum(), 10)
        self.assertFalse(outcome.moved[small].any())

    def test_a_row_counts_moves_that_made_it_worse(self):
        moved = np.array([True, True, False, True])
        centred = np.array([True, True, False, False])
        outcome = Outcome(np.array([10.0, 1, 0, 5]), np.array([12.0, 4, 9, 5]), np.array([1.0, 2, 1, 1]), np.full(4, 5.0), moved, np.zeros(4), np.array([0.0, 0, 3, 0]), centred)
        self.assertEqual(lathe.worse(outcome), 1)
        self.assertEqual(lathe.said_on_centre([(Case(1, "lands ABBA"), outcome)]), (2, 1))  # within 5 um
        # Errors of all four heights by their sigma: 2, 1.5, 9 and 0; of two cuts those of the squares by 25 um2.
        for method, ratio in (("two cuts", "1.87"), ("lands ABBA", "4.67")):
            row = lathe.row(Case(10, method), outcome)
            self.assertEqual(row.split()[-6:], ["2.08", "2.90", "1.41", ratio, "25.0%", "1"])


class SecondPlant(unittest.TestCase):
    """Lands 1 2 2 1 of 10 mm on the second lathe."""

    def outcome(self, method="lands ABBA", **case):
        return simulate_second(SecondCase(10, method, **case), SEEDS, no_news)

    def shares(self, outcome):
        its = outcome.values
        stored = (its["move-allowed"] > 0) | (its["x-allowed"] > 0)
        return {"refused": np.mean(its["fault"] > 0), "stored": np.mean(stored), "centre": np.mean(its["on-centre"] > 0)}

    def test_heights_are_right_and_sigma_is_honest_with_burrs_and_without(self):
        for burrs in (False, True):
            with self.subTest(burrs):
                outcome = self.outcome(burrs=burrs)
                self.assertGreater(lathe.within_two(lathe.errors_of(SecondCase(10, "lands ABBA"), outcome)), 0.9)
                self.assertEqual(lathe.second_worse(outcome), 0)
                self.assertGreater(np.mean(outcome.values["move-allowed"]), 0.6)

    def test_eight_lands_leave_burrs_out(self):
        outcome = self.outcome("lands ABBA x 3", burrs=True)
        self.assertGreater(np.sum(outcome.values["rejected-cuts"]), 50)
        self.assertGreater(np.mean(outcome.values["move-allowed"]), 0.85)
        self.assertEqual(np.sum(self.outcome("lands ABBA x 3").values["rejected-cuts"] > 1), 0)

    def test_cuts_that_met_nothing_are_refused(self):
        for slip in ("air", "standing"):
            with self.subTest(slip):
                outcome = self.outcome(slip=slip)
                self.assertFalse(outcome.met.any())
                self.assertEqual(self.shares(outcome), {"refused": 1, "stored": 0, "centre": 0})

    def test_radii_and_inches_are_refused(self):
        for slip in ("radius", "inch"):
            with self.subTest(slip):
                self.assertEqual(self.shares(self.outcome(slip=slip)), {"refused": 1, "stored": 0, "centre": 0})

    def test_another_tool_a_swapped_pair_a_burr_and_a_wrong_diameter_ask_for_more_cuts(self):
        for slip in ("tool", "swapped", "burr", "one wrong"):
            with self.subTest(slip):
                outcome = self.outcome(slip=slip)
                self.assertLess(self.shares(outcome)["stored"], 0.05)
                self.assertEqual(lathe.second_worse(outcome), 0)

    def test_lands_of_a_bar_that_is_not_of_one_diameter_leave_no_more_than_there_was(self):
        outcome = self.outcome(slip="depth")
        self.assertEqual(lathe.second_worse(outcome), 0)
        self.assertGreater(lathe.within_two(lathe.errors_of(SecondCase(10, "lands ABBA"), outcome)), 0.9)

    def test_tool_that_is_said_to_be_on_centre_is(self):
        case = SecondCase(10, "lands ABBA x 3", near=True)
        said, y_out, x_out, air = lathe.on_centre_of(case, simulate_second(case, range(1, 801), no_news))
        # With 99 %, the estimate of Y has room for 10 less 2.33 of its 2.6 um: two thirds of the room for 95 %.
        self.assertGreater(said, 55)
        self.assertLessEqual(max(y_out, x_out), 0.05 * said)
        self.assertEqual(air, 0)


class Strangers(unittest.TestCase):
    """A few rows of `scripts/bench lathe --strangers`."""

    def counts(self, plant, slip, lathes):
        case = lathe_strangers.StrangerCase(plant, slip)
        return lathe_strangers.total(lathe_strangers.simulate_strangers(case, range(1, lathes + 1), no_news))

    def test_the_same_land_for_all_stores_nothing_and_claims_nothing(self):
        its = self.counts(2, "same land", 4)
        self.assertEqual((its["moves"], its["claims"]), (0, 0))

    def test_a_stranger_without_a_slip_stores_and_is_on_centre(self):
        its = self.counts(1, "none", 16)
        self.assertGreater(its["moves"], 2)
        self.assertGreater(its["claims"], 0)
        self.assertEqual((its["worse"], its["wrong"]), (0, 0))

    def test_limit_of_a_share(self):
        self.assertAlmostEqual(lathe_strangers.upper(0, 299), 0.00997, delta=2e-5)
        self.assertAlmostEqual(lathe_strangers.upper(1, 473), 0.00999, delta=2e-5)
        self.assertGreaterEqual(len(lathe_strangers.SLIPS), 24)


class Command(unittest.TestCase):
    def test_prints_the_table_and_writes_chart_and_lathes(self):
        with TemporaryFolder() as folder:
            answer = run_bench("lathe", "--seeds", "2", "--output", folder)
            self.assertIn("Residual of the height at D 10 mm", answer.stdout, answer.stderr)
            for name in ("procedure.png", "procedure.svg", "lathes.csv"):
                self.assertGreater(os.path.getsize(os.path.join(folder, name)), 1000)


if __name__ == "__main__":
    unittest.main()

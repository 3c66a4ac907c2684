# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of scripts/bench mill, on recordings made by hand."""

import argparse
import math
import os
import unittest

import numpy as np

import mill
from bench_runs import run_bench
from plumb_folder import TemporaryFolder
from support.command import duration_of
from support.figures import largest, rms
from support.simulations import duration_text


def recording(rows, **columns):
    """Columns of zeros, but for those given."""
    names = ["time", *mill.LENGTHS, *mill.NUMBERS]
    return {name: np.array(columns.get(name, [0] * rows), float) for name in names}


def three_cycles():
    """Operation 10 twice and operation 20 once in each cycle; the first cycle is for learning."""
    tip_errors = [-1, -2, -5, -21, -23, -27, -11, -15, -4]
    return recording(
        10,
        time=range(10),
        cuts=range(10),
        cycle=[1] * 4 + [2] * 3 + [3] * 3,
        learning=[1] * 4 + [0] * 6,
        growth=[3, 4, 5, 6, 23, 24, 25, 18, 13, 14],
        offset=[0] * 5 + [20] * 5,
        **{
            "cut-operation": [0] + [10, 10, 20] * 3,
            "cut-occurrence": [0] + [1, 2, 1] * 3,
            "cut-tool": [0] + [1, 1, 2] * 3,
            "cut-error": [0] + tip_errors,
            "cut-growth": [0] + [1, 2, 3, 21, 22, 23, 11, 12, 13],
        },
    )


class Cuts(unittest.TestCase):
    def test_error_is_against_the_reference_cut_of_the_same_operation_and_occurrence(self):
        cuts = mill.find_cuts(three_cycles())
        self.assertEqual(list(cuts["error"]), [0, 0, 0, -20, -21, -22, -10, -13, 1])
        self.assertEqual(list(cuts["tip_error"][:4]), [-1, -2, -5, -21])

    def test_each_cut_carries_its_own_circumstances(self):
        cut = mill.find_cuts(three_cycles())[5]
        row = [cut[n] for n in ("time", "cycle", "operation", "occurrence", "tool", "growth", "offset", "learning")]
        self.assertEqual(row, [6, 2, 20, 1, 2, 23, 20, 0])

    def test_cuts_of_the_learning_cycle_are_not_judged(self):
        self.assertEqual(len(mill.warm_cuts(mill.find_cuts(three_cycles()))), 6)

    def test_cut_without_a_reference_is_not_judged(self):
        rows = three_cycles()
        rows["cut-operation"][4] = 30
        cuts = mill.find_cuts(rows)
        self.assertTrue(math.isnan(cuts["error"][3]))
        self.assertEqual(len(mill.warm_cuts(cuts)), 5)

    def test_two_cuts_in_one_row_are_an_error(self):
        rows = three_cycles()
        rows["cuts"][5:] += 1
        with self.assertRaises(ValueError):
            mill.find_cuts(rows)


class Figures(unittest.TestCase):
    def test_rms_and_largest(self):
        self.assertAlmostEqual(rms(np.array([3.0, -4.0])), math.sqrt(12.5))
        self.assertEqual(largest(np.array([3.0, -4.0])), 4)
        self.assertTrue(math.isnan(rms(np.array([]))))

    def test_peak_growth_counts_from_the_start(self):
        self.assertEqual(mill.judge(three_cycles()).peak_growth, 22)

    def test_table_leaves_out_the_first_warm_contact_and_shows_it_in_percent_of_peak_growth(self):
        without = mill.judge(three_cycles())
        compensated = mill.judge(three_cycles())
        compensated.cuts["error"][3:] = [-20, 2, -2, 2, -2, 2]
        lines = mill.error_table(without, compensated)
        row = next(line for line in lines if line.startswith("from the second warm contact on"))
        self.assertIn("2.0 (  9.1%)", row)
        self.assertNotIn("20.0", row)
        row = next(line for line in lines if line.startswith("all cuts after learning"))
        self.assertIn("20.0 ( 90.9%)", row)
        row = next(line for line in lines if line.startswith("range within a part"))
        self.assertIn("4.0 ( 18.2%)", row)

    def test_verdicts_are_counted_with_the_code_of_each_rejection(self):
        rows = recording(5, time=range(5), accepted=[0, 1, 1, 3, 3], rejected=[0, 0, 1, 1, 2], rejection=[0, 0, 4, 4, 8])
        verdicts = mill.find_verdicts(rows)
        self.assertEqual(
            verdicts,
            [(1, "accepted", 0), (2, "rejected", 4), (3, "accepted", 0), (3, "accepted", 0), (4, "rejected", 8)],
        )
        outcome = mill.Outcome(1, np.zeros(0, mill.CUT), verdicts, {})
        self.assertEqual(
            mill.contact_lines(outcome, {4: "The feed differs."}),
            ["Contacts: 3 accepted, 0 missed, 0 unexpected, 2 rejected", "  1 rejected: The feed differs.", "  1 rejected: code 8"],
        )

    def test_percentiles_are_over_machines(self):
        pairs = []
        for error in range(1, 12):
            outcomes = [mill.judge(three_cycles()) for _ in range(2)]
            outcomes[1].cuts["error"] = error
            pairs.append(tuple(outcomes))
        row = next(
            line
            for line in mill.percentile_table(pairs)
            if line.startswith("rms of the error, um, with compensation")
        )
        self.assertEqual(row.split()[-4:], ["2.0", "6.0", "10.0", "11.0"])


class Words(unittest.TestCase):
    def test_durations(self):
        self.assertEqual([duration_of(t) for t in ("4h", "10min", "90s", "600", "1.5h")], [14400, 600, 90, 600, 5400])
        self.assertEqual(duration_text(5400), "1 h 30 min")
        for wrong in ("", "h", "4 days", "-1", "0"):
            with self.assertRaises(argparse.ArgumentTypeError):
                duration_of(wrong)

class Command(unittest.TestCase):
    def test_writes_table_chart_and_files(self):
        with TemporaryFolder() as folder:
            done = run_bench("mill", "--for", "6min", "--seed", "3", "--output", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("6 min of milling on machine 3", done.stdout)
            self.assertIn("from the second warm contact on", done.stdout)
            with open(os.path.join(folder, "errors.png"), "rb") as chart:
                self.assertEqual(chart.read(8), b"\x89PNG\r\n\x1a\n")
            with open(os.path.join(folder, "cuts.csv"), encoding="ascii") as cuts:
                lines = cuts.read().splitlines()
            self.assertEqual(len(lines), 1 + 2 * 10)  # two runs of two cycles of five cuts
            with open(os.path.join(folder, "series.csv"), encoding="ascii") as series:
                self.assertEqual(len(series.read().splitlines()), 1 + 361)

    def test_a_part_is_even_only_if_the_offset_is_constant_in_it(self):
        for options, even in (((), False), (("--constant-in-part",), True)):
            with self.subTest(even=even), TemporaryFolder() as folder:
                done = run_bench("mill", "--for", "26min", "--output", folder, *options)
                self.assertEqual(done.returncode, 0, done.stderr)
                row = next(line for line in done.stdout.splitlines() if line.startswith("the same, of the offset"))
                self.assertEqual(row.endswith("0.0 (  0.0%)     0.0 (  0.0%)"), even, row)

    def test_unknown_option_is_refused(self):
        self.assertEqual(run_bench("mill", "--sed", "x").returncode, 2)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill/bench.hal: first the disease, then the cure, then all that may upset a program."""

import collections
import sys
import unittest

import numpy as np

import mill
from support import mill_cycles, mill_events
from support.figures import rms
from support.simulations import simulate_all

HOURS = 3600


class FourHours(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        duration = 4 * HOURS
        jobs = [(0, compensated, duration) for compensated in (False, True)]
        cls.without, cls.compensated = simulate_all(mill.simulate, jobs, 2 * duration)

    def error(self, outcome):
        """rms at the cuts from the second warm contact on, as a part of the peak growth."""
        return rms(mill.warm_cuts(outcome.cuts)["error"][1:]) / self.without.peak_growth

    def test_spindle_grows_and_the_growth_is_not_one_exponential(self):
        growth = self.without.series["growth"]
        self.assertGreater(self.without.peak_growth, 40)
        self.assertLess(self.without.peak_growth, 70)
        self.assertLess(growth[-1], self.without.peak_growth - 4)

    def test_without_compensation_most_of_the_growth_is_in_the_work(self):
        self.assertGreater(self.error(self.without), 0.6)
        self.assertTrue(np.all(self.without.series["offset"] == 0))
        self.assertEqual(self.without.verdicts, [])

    def test_with_compensation_8_percent_of_the_growth_are_left(self):
        self.assertLessEqual(self.error(self.compensated), 0.08)

    def test_every_operation_is_cut_truer(self):
        before, after = (mill.warm_cuts(o.cuts)[1:] for o in (self.without, self.compensated))
        operations = np.unique(after["operation"])
        self.assertGreaterEqual(len(operations), 3)
        for operation in operations:
            before_after = [rms(cuts["error"][cuts["operation"] == operation]) for cuts in (before, after)]
            self.assertLess(before_after[1], before_after[0] / 3, f"operation {operation}")

    def test_every_contact_of_an_undisturbed_program_is_accepted(self):
        cycles = self.compensated.cuts["cycle"][-1] - 1  # after learning
        self.assertEqual([verdict for _, verdict, _ in self.compensated.verdicts], ["accepted"] * 2 * cycles)

    def test_both_runs_make_the_same_cuts(self):
        for name in ("cycle", "operation", "occurrence", "tool"):
            self.assertTrue(np.array_equal(self.without.cuts[name], self.compensated.cuts[name]), name)


class Events(unittest.TestCase):
    def run_programs(self, count, small):
        programs = mill_events.draw_programs(count, small)
        outcomes = mill_events.run_programs(programs)
        print("\n" + "\n".join(mill_events.table(programs, outcomes)), file=sys.stderr)
        return [contact for contacts in outcomes for contact in contacts]

    def test_no_correction_beyond_the_gate_is_accepted(self):
        contacts = self.run_programs(30, small=False)
        self.assertEqual(mill_events.wrong(contacts), [])
        upset = [contact for contact in contacts if contact.event]
        self.assertGreater(len(upset), 30)
        self.assertGreater(sum(contact.accepted for contact in contacts), 45)
        displaced = [contact for contact in upset if contact.event in mill_events.WITH_HEIGHT]
        self.assertEqual([contact for contact in displaced if contact.accepted], [])

    def test_an_event_within_the_gate_shifts_the_work_by_less_than_the_gate(self):
        contacts = self.run_programs(10, small=True)
        self.assertEqual(mill_events.wrong(contacts), [])
        self.assertGreater(sum(contact.event != 0 for contact in contacts), 10)


class Cycles(unittest.TestCase):
    def test_cycle_after_cycle_nothing_wrong_is_accepted_and_all_counts_agree_with_the_truth(self):
        outcomes = mill_cycles.run_cycles(110)
        print("\n" + "\n".join(mill_cycles.table(outcomes)), file=sys.stderr)
        approaches = [approach for outcome in outcomes for approach in outcome.approaches]
        self.assertEqual([complaint for outcome in outcomes for complaint in outcome.complaints], [])
        self.assertEqual(mill_cycles.wrong(approaches), [])
        self.assertEqual([a for a in approaches if a.unseen == mill_cycles.UNKNOWN], [])
        verdicts = collections.Counter(approach.verdict for approach in approaches)
        self.assertGreater(verdicts["accepted"], 90)
        self.assertGreater(verdicts["rejected"], 100)
        self.assertGreater(len({approach.event for approach in approaches}), 11)
        self.assertGreater(sum(outcome.learnt for outcome in outcomes), len(outcomes), "edited programs are learned")


if __name__ == "__main__":
    unittest.main()

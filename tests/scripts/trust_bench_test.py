# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench trust: its figures on a recording made by hand, and short attacks."""

import unittest

import numpy as np

import trust
from support import attacks, contacts, figures



def recording():
    """A reference cut, and two warm ones: each row is LEAD s."""
    column = {name: np.zeros(6) for name in contacts.COLUMNS}
    column["time"] = np.arange(6) * contacts.LEAD
    column["program.learn"][:2] = 1
    column["mill.truth-cuts"] = np.array([0, 1, 1, 2, 2, 3])
    column["mill.truth-cut-operation"][:] = 10
    column["mill.truth-cut-error"] = np.array([0, 2, 2, -8, -8, 32]) / 1000
    column["mill.applied-offset"] = np.array([0, 0, 20, 20, 40, 0]) / 1000
    column["growth.offset-sigma"] = np.array([0, 0, 3, 3, 5, 5]) / 1000
    column["growth.doubt"] = np.array([0, 0, 0, 0, 1, 0])
    column["growth.contacts-accepted"] = np.arange(6)
    return column


class Judged(unittest.TestCase):
    def setUp(self):
        self.column = recording()
        self.cuts = contacts.find_cuts(self.column)

    def test_error_counts_from_the_reference_and_without_is_less_the_offset(self):
        np.testing.assert_allclose(self.cuts["error"], [-10, 30])
        np.testing.assert_allclose(self.cuts["worse"], [10 - 30, 30 - 10])
        np.testing.assert_allclose(self.cuts["sigma"], [3, 5])
        np.testing.assert_array_equal(self.cuts["announced"], [False, True])

    def test_cuts_of_tools_without_a_gauge_and_doubts_by_the_status_alone_are_counted_apart(self):
        self.column["mill.truth-cut-operation"][:] = 40
        self.column["growth.status-code"] = np.array([0, 0, 0, 0, 62, 0])
        cuts = contacts.find_cuts(self.column, {40})
        np.testing.assert_array_equal(self.cuts["gauge"], [True, True])
        np.testing.assert_array_equal(cuts["gauge"], [False, False])
        rows = [trust.machine_row(each, 0, 1, 1.0) for each in (self.cuts, cuts)]
        lines = "\n".join(trust.machine_table(500, rows, 2))
        self.assertIn("more than 5 um worse: 2 of 4 (50.00%", lines)
        self.assertIn("whose contacts count: 1 of 2 (50.00%", lines)
        self.assertIn("the other tools: 1 of 2", lines)
        self.assertIn("50.0% after the first part, 25.0% by the panel's status alone", lines)
        self.assertIn("in 100 h: 0.0 messages, 50.0 times", lines)

    def test_the_rivals_stand_in_the_row_of_an_attack(self):
        self.cuts["time"] += attacks.TEACH
        self.cuts["Hold"], self.cuts["Simple3"] = [30, 10], [0, 1]  # um; 30 and 10 would make them right
        row = trust.attack_table([attacks.Attack("an attack")], [self.cuts])[-1]
        self.assertEqual(row.split()[2:9], ["22.4", "22.4", "0.0", "22.1", "20.0", "-10.0", "0.0"])

    def test_an_upper_limit_falls_as_three_cuts_do(self):
        self.assertAlmostEqual(figures.most_likely(0, 1500), 1 - 0.05 ** (1 / 1500))

    def test_what_is_worse_and_not_announced_is_found(self):
        def found():
            return trust.broken(self.column, self.cuts, [(attacks.attack_named("load frozen"), -1e6)], 1, 1, 7)

        self.assertEqual(found(), [])
        self.cuts["announced"][1] = False
        self.assertRegex(found()[0], "day 7, load frozen .*: a cut at 15 s is worse by 20.0 um, and not announced")
        self.column["growth.z-offset"][3] = 1.5
        self.assertIn("an offset of 1.5000 mm", "\n".join(found()))

    def test_a_day_is_drawn_by_its_number(self):
        self.assertEqual(trust.drawn_attacks(3), trust.drawn_attacks(3))
        self.assertNotEqual(trust.drawn_attacks(3), trust.drawn_attacks(4))


class Attacks(unittest.TestCase):
    def test_a_dead_load_and_a_longer_tool_are_announced_and_make_nothing_worse(self):
        for name, code in (("load frozen", 49), ("two gauges 37 um apart", 56)):
            cuts, *_ = trust.simulate(0, 250, name, attacks.TEACH + 1800, lambda done: True)
            since = cuts[cuts["time"] > attacks.TEACH + trust.NOTICE]
            self.assertGreater(len(since), 15)
            self.assertIn(code, since["code"], name)
            self.assertTrue(since["announced"].all(), name)
            self.assertLess(since["worse"].max(), 3, name)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench trust --events: when its events come, its table, and short runs."""

import contextlib
import io
import os
import unittest
import unittest.mock

import numpy as np

import trust
from plumb_folder import TemporaryFolder
from support import contacts, load_events
from support.load_events import NONE, EVENTS, LoadEvent, Outcome, coolant, dip, event_named
from support.mill_machine import start_mill
from support.recordings import read_columns

SHORT = 1800  # s
LOST_TRACK, RISES_TWICE = 7, 45  # detail-code


def outcome(errors, announced, refused=False, learnt=1):
    cuts = np.zeros(len(errors), contacts.CUT)
    cuts["error"], cuts["announced"], cuts["gauge"], cuts["known"], cuts["sigma"] = errors, announced, True, True, 3
    cuts["offset"], cuts["Hold"], cuts["Simple3"] = -4, 0, 1
    return Outcome(cuts, learnt, refused, 20, {14: 5}, 1.0)


class Table(unittest.TestCase):
    def test_an_event_has_caused_the_difference_to_the_same_cuts_without_it(self):
        healthy, event = outcome([1, -2, 3], [0, 0, 0]), outcome([1, -12, 33], [0, 0, 1])
        np.testing.assert_allclose(load_events.caused(event, healthy), [0, 10])
        self.assertEqual(len(load_events.caused(outcome([1, -12, 33], [0, 0, 1], learnt=2), healthy)), 0, "another reference")

    def test_it_counts_refused_first_cycles_silent_cuts_and_rejections(self):
        lines = load_events.table([NONE, EVENTS[1]], [[outcome([1, -2, 3], [0, 0, 0])], [outcome([1, -12, 33], [0, 0, 1], True)]])
        self.assertRegex(lines[2], r"none +0 of 1 +2\.0 +3\.0 +5\.0 +7\.0 +5\.0 +7\.0 +6\.0 +8\.0 +100% +0\.0 +0\.0 +100% +25\.0%  14: 5")
        self.assertRegex(lines[3], r" 1 of 1 +12\.0 +33\.0 .* 67% +5\.0 +10\.0 +33% ")

    def test_the_second_structure_is_refused_and_not_left_out(self):
        for option in (["--events", "--seeds", "1", "--for", "600"], ["--attacks"], ["--days", "1"]):
            said, folder = io.StringIO(), self.enterContext(TemporaryFolder())
            arguments = ["trust", *option, "--plant", "2", "--output", folder]
            with self.subTest(option[0]), unittest.mock.patch("sys.argv", arguments), contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
                with unittest.mock.patch("trust.simulate_all", side_effect=AssertionError("it runs")):
                    self.assertRaises(SystemExit, trust.main)
                self.assertIn(option[0] + " changes the mill of the first structure", said.getvalue())

    def test_names_are_unique(self):
        self.assertEqual(len({event.name for event in EVENTS}), len(EVENTS))


def times_of(event, duration=40):
    """s from each change of the coolant to the contact that follows, in the first cycle; negative: switched off."""
    import plumb

    with TemporaryFolder() as folder, plumb.Host() as host:
        start_mill(host, 0)
        event.prepare(host)
        event.happen(host, True)
        path = os.path.join(folder, "signals.csv")
        host.record(path, ["drive.coolant", "mill.truth-contact", "program.operation", "program.motion-type"], 0.001)
        host.run(duration)
        column = read_columns(path)
    contacts = np.flatnonzero((np.diff(column["mill.truth-contact"]) > 0) & (column["program.operation"][1:] == 10)) + 1
    feeds = column["program.motion-type"] == 2
    found = []
    for row in contacts:
        changes = [i for i in np.flatnonzero(np.diff(column["drive.coolant"])) + 1 if row - 1000 < i < row and feeds[i]]
        found.append([(row - i) / 1000 * (1 if column["drive.coolant"][i] else -1) for i in changes])
    return found


class Events(unittest.TestCase):
    def test_coolant_comes_on_as_long_before_the_contacts_as_its_name_says(self):
        for (before,) in times_of(coolant(4, 0.06, later=True)):
            self.assertAlmostEqual(before, 0.06, delta=0.002)

    def test_a_dip_ends_then_and_is_long(self):
        for begins, ends in times_of(dip(4, 0.02, later=True)):
            self.assertAlmostEqual(begins, -0.12, delta=0.002)
            self.assertAlmostEqual(ends, 0.02, delta=0.002)

    def test_nothing_comes_without_an_event(self):
        self.assertEqual(times_of(LoadEvent("none", 4)), times_of(NONE))

    def run_event(self, name):
        return trust.simulate_event(0, 500, name, SHORT, 30, lambda done: True)[0]

    def test_a_healthy_machine_loses_no_contact_and_an_event_reaches_the_load(self):
        healthy, resonance = (self.run_event(name) for name in ("none", "resonance, later"))
        self.assertFalse(healthy.refused)
        self.assertGreater(healthy.contacts, 8)
        self.assertEqual(healthy.rejections, {})
        self.assertLess(np.median(np.abs(healthy.cuts["error"])), 5)
        self.assertGreater(np.max(load_events.caused(resonance, healthy)), 5)

    def test_a_load_that_rises_twice_is_not_learned_and_not_followed(self):
        for name in ("coolant 2 %, 60 ms before, learning", "coolant 6 %, 60 ms before, learning", "dip 4 %, ends 20 ms before, learning"):
            self.assertTrue(self.run_event(name).refused, name)
        later = self.run_event("coolant 6 %, 60 ms before, later")
        self.assertEqual(set(later.rejections), {LOST_TRACK, RISES_TWICE})
        self.assertEqual(sum(later.rejections.values()), later.contacts)
        self.assertTrue(later.cuts["announced"][4:].all())


if __name__ == "__main__":
    unittest.main()

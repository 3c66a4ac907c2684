# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether counts that do not agree with the truth are noticed, on recordings made by hand."""

import math
import unittest

import numpy as np

from support import mill_cycles


def recording(*rows):
    """Rows of changes: each column keeps its value until a row gives it another; a second from one to the next."""
    names = [*mill_cycles.NUMBERS, *mill_cycles.LENGTHS, "time"]
    columns = {name: [0.0] for name in names}
    for number, row in enumerate(rows, 1):
        for name, column in columns.items():
            column.append(float(row.get(name, number if name == "time" else column[-1])))
    return {name: np.array(column) for name, column in columns.items()}


START = dict(running=1, complete=0, feeding=1, program=1)
END = dict(running=0, complete=1, operation=0)
LEARN = [
    dict(START, cycle=1, learn=1, operation=10, occurrence=1, gate=60),
    dict(met=1, growth=5),
    dict(found=1),
    dict(END, rows=1),
]
SECOND = dict(START, cycle=2, learn=0, operation=10, growth=25)


def judge(*rows):
    return mill_cycles.judge(recording(*LEARN, *rows))


def complaints(*rows):
    return judge(*rows).complaints


class Agreement(unittest.TestCase):
    def test_a_contact_that_was_met_found_and_accepted_agrees(self):
        outcome = judge(SECOND, dict(met=2), dict(found=2, accepted=1, estimate=23, sigma=1), END)
        self.assertEqual(outcome.complaints, [])
        self.assertEqual((outcome.cycles, outcome.learnt), (2, 1))
        learnt, contact = outcome.approaches
        self.assertEqual((learnt.verdict, contact.verdict), ("learnt", "accepted"))
        self.assertEqual(contact.error, 3)
        self.assertEqual(contact.excess, 3 - 20 - 60 - 3)

    def test_a_contact_that_is_missed_is_counted_as_such(self):
        self.assertEqual(complaints(SECOND, dict(END, missed=1)), [])
        self.assertIn("0 contacts missed, not 1", complaints(SECOND, END)[0])

    def test_a_contact_that_was_met_and_not_seen_wants_a_reason(self):
        def reason(*rows):
            outcome = judge(*rows, dict(END, missed=1, time=9))
            self.assertEqual(outcome.complaints, [])
            return outcome.approaches[-1].unseen

        self.assertEqual(reason(SECOND, dict(met=2)), mill_cycles.UNKNOWN)
        self.assertEqual(reason(SECOND, dict(met=2), dict(feeding=0, time=6.2)), "the feed ended")
        self.assertEqual(reason(SECOND, dict(speed=100, time=5.5), dict(met=2, time=6)), "blanked")
        self.assertEqual(reason(SECOND, dict(met=2, time=8.5)), "the cycle ended")

    def test_what_is_found_as_the_cycle_ends_belongs_to_it(self):
        self.assertEqual(complaints(SECOND, dict(met=2), dict(END, found=2, rejected=1, code=38)), [])

    def test_a_contact_that_is_counted_nowhere_or_twice_is_noticed(self):
        self.assertIn("counted nowhere", complaints(SECOND, dict(met=2), dict(found=2), END)[0])
        self.assertIn("counted twice", complaints(SECOND, dict(met=2), dict(found=2, accepted=1, rejected=1), END)[0])

    def test_a_rejection_without_a_name_is_noticed(self):
        self.assertIn("code without a name", complaints(SECOND, dict(met=2), dict(found=2, rejected=1, code=99), END)[0])

    def test_a_fault_may_hide_the_reason_of_a_rejection(self):
        self.assertEqual(complaints(SECOND, dict(met=2), dict(found=2, rejected=1, code=7), END), [])

    def test_unexpected_is_what_was_not_learnt(self):
        rows = [SECOND, dict(met=2), dict(found=2, unexpected=1), END]
        self.assertIn("contradicts", complaints(*rows)[0])
        rows[0] = dict(SECOND, operation=40)
        self.assertEqual(complaints(*rows[:3], dict(END, missed=1)), [])

    def test_an_edited_program_must_be_refused(self):
        edited = [dict(SECOND, program=2, refused=1), dict(met=2), dict(found=2, rejected=1, code=21), END]
        self.assertEqual(complaints(*edited), [])
        edited[0] = dict(SECOND, program=2)
        self.assertIn("not refused", complaints(*edited)[0])
        self.assertIn("is refused", complaints(dict(SECOND, refused=1), END)[0])

    def test_a_correction_where_the_tool_met_nothing_is_wrong(self):
        outcome = judge(SECOND, dict(found=2, accepted=1, estimate=1), END)
        self.assertEqual([a.excess for a in mill_cycles.wrong(outcome.approaches)], [math.inf])

    def test_a_contact_where_none_is_looked_for_is_noticed(self):
        rows = [dict(SECOND, operation=20), dict(found=2, rejected=1, code=38), dict(END, missed=1)]
        self.assertIn("none is looked for", complaints(*rows)[0])

    def test_the_table_counts_by_event_and_code(self):
        outcome = judge(dict(SECOND, event=2), dict(met=2), dict(found=2, rejected=1, code=38), END)
        lines = mill_cycles.table([outcome])
        heads = lines[0].replace("code ", "code-").split()[1:]
        cells = dict(zip(heads, lines[2].split()[-len(heads) :]))
        self.assertEqual((cells["approaches"], cells["met"], cells["code-38"], cells["wrong"]), ("1", "1", "1", "0"))
        self.assertIn("Rejected, code 38: " + mill_cycles.rejections()[38], lines)
        self.assertNotIn("code-33", cells)


if __name__ == "__main__":
    unittest.main()

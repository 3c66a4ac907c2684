# SPDX-License-Identifier: GPL-2.0-or-later
"""The counts in the tables of events, on recordings made by hand."""

import math
import unittest

import numpy as np

from support import mill_events
from support.mill_events import Contact


def recording(*rows):
    """Rows of changes: each column keeps its value until a row gives it another."""
    columns = {name: [0.0] for name in mill_events.COLUMNS}
    for row in rows:
        for name, column in columns.items():
            column.append(float(row.get(name, column[-1])))
    return {name: np.array(column) for name, column in columns.items()}


LEARN = dict(cycle=1, contacts=1, found=1, operation=10, growth=5, gate=60)


class Contacts(unittest.TestCase):
    def test_learning_cycle_gives_the_reference_and_no_contact(self):
        self.assertEqual(mill_events.read_contacts(recording(LEARN)), [])

    def test_error_counts_from_the_growth_at_the_reference(self):
        (contact,) = mill_events.read_contacts(
            recording(
                LEARN,
                dict(cycle=2, contacts=2, growth=25),
                dict(found=2, accepted=1, estimate=23, sigma=1, gate=15),
            )
        )
        self.assertTrue(contact.found and contact.accepted)
        self.assertEqual(contact.error, 3)
        self.assertEqual(contact.excess, 3 - 20 - 60 - 3)

    def test_correction_that_leaves_more_than_gate_and_3_sigma_is_wrong(self):
        for displacement, wrong in ((20 + 60 + 3 + 5 + 1, True), (20 + 60 + 3 + 5 - 1, False)):
            contacts = mill_events.read_contacts(
                recording(
                    LEARN,
                    dict(cycle=2, offset=15),
                    dict(contacts=2, growth=25, event=2),
                    dict(found=2, accepted=1, estimate=displacement, sigma=1),
                )
            )
            self.assertEqual([c.event for c in mill_events.wrong(contacts)], [2] * wrong)

    def test_gate_is_that_before_the_contact(self):
        (contact,) = mill_events.read_contacts(
            recording(
                LEARN,
                dict(cycle=2, contacts=2, growth=5, gate=20),
                dict(found=2, accepted=1, estimate=30, gate=15),
            )
        )
        self.assertEqual(contact.excess, 30 - 20)

    def test_contact_where_the_tool_met_nothing_is_wrong_when_accepted(self):
        contacts = mill_events.read_contacts(
            recording(LEARN, dict(cycle=2, found=2, accepted=1, estimate=1, happening=1))
        )
        self.assertEqual([(c.event, c.excess) for c in mill_events.wrong(contacts)], [(1, math.inf)])

    def test_contact_that_was_not_found_counts_as_such(self):
        contacts = mill_events.read_contacts(recording(LEARN, dict(cycle=2, contacts=2, event=7)))
        self.assertEqual(contacts, [Contact(2, 7)])

    def test_occurrences_of_one_operation_have_references_of_their_own(self):
        contacts = mill_events.read_contacts(
            recording(
                LEARN,
                dict(contacts=2, found=2, growth=8),
                dict(cycle=2, contacts=3, growth=25),
                dict(found=3, accepted=1, estimate=20),
                dict(contacts=4, growth=26),
                dict(found=4, accepted=2, estimate=18),
            )
        )
        self.assertEqual([contact.error for contact in contacts], [0, 0])


class Table(unittest.TestCase):
    def test_counts_by_event(self):
        outcomes = [
            [Contact(2, 0, True, True, 3.0, -10), Contact(3, 0, True, True, -4.0, -10)],
            [Contact(3, 2, True, True, 90.0, 5), Contact(3, 2, True), Contact(3, 2)],
        ]
        lines = mill_events.table([(1, 2, False, 60), (2, 2, False, 60)], outcomes)
        self.assertEqual(lines[1].split(), ["None.", "2", "2", "2", "2", "0", "3.5", "4.0"])
        chip = mill_events.event_names()[2]
        self.assertEqual(lines[2].split(), [*chip.split(), "2", "3", "2", "1", "1", "90.0", "90.0"])

    def test_programs_are_drawn_alike_each_time_with_every_event(self):
        programs = mill_events.draw_programs(22, False)
        self.assertEqual(programs, mill_events.draw_programs(22, False))
        self.assertEqual({event for _, event, _, _ in programs}, set(range(1, 12)))
        self.assertTrue(all(60 <= interval <= 300 for _, _, _, interval in programs))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb-contacts: how it finds descents in a recording, and the load's step in each."""

import os
import unittest

import numpy as np

import plumb_contacts
from tree import own_folder

PERIOD = 0.001  # seconds
NO_MOTION, RAPID, FEED = 0, 1, 2
APPROACH, CUT = 1.5, 0.4  # seconds of feeding, without load and with it


def plunge(dwell):
    """Rows of record.hal: a plunge of operation 10 with tool 1, a dwell at depth, and the retract."""
    noise = np.random.default_rng(1)

    def rows(seconds, load, velocity, motion):
        count = round(seconds / PERIOD)
        table = np.zeros((count, len(plumb_contacts.COLUMNS)))
        columns = dict(zip(plumb_contacts.COLUMNS, table.T))
        columns["load"][:] = load + noise.normal(0, 0.1, count)
        columns["velocity"][:], columns["motion"][:] = velocity, motion
        columns["operation"][:], columns["tool"][:], columns["running"][:] = 10, 1, 1
        return table

    return np.concatenate(
        [
            rows(0.5, 20, 0, NO_MOTION),
            rows(APPROACH, 20, -2, FEED),
            rows(CUT, 27, -2, FEED),
            rows(dwell, 20, 0, NO_MOTION),
            rows(0.3, 20, 50, RAPID),
        ]
    )


class Descents(unittest.TestCase):
    def recording(self, rows):
        file = os.path.join(own_folder(self), "load.txt")
        np.savetxt(file, rows, fmt="%.6f")
        return plumb_contacts.Recording(file, PERIOD)

    def test_the_step_of_the_load_is_found_however_long_the_tool_dwells_at_depth(self):
        for dwell in (0.1, 1, 10):
            with self.subTest(dwell):
                rows = plunge(dwell)
                recording = self.recording(np.concatenate([rows, rows]))
                self.assertEqual([a.occurrence for a in recording.approaches], [1, 2])
                for number, approach in enumerate(recording.approaches):
                    onset = (approach.onset - number * len(rows)) * PERIOD
                    self.assertAlmostEqual(onset, 0.5 + APPROACH, delta=0.01)
                    self.assertAlmostEqual(approach.rise, 7, delta=0.2)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill in a complete LinuxCNC under a drawn attack: the offset stays in its bounds, and what is wrong is announced.

    python3 tests/support/run.py tests/configs/mill_attacks_linuxcnc_test.py --repeat 12

goes through all attacks, nearly five minutes of the machine's time each.
"""

import os
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, changes, own_folder, read_recording, um
from starts import starts

LEAD = 3  # s before the end of a cut, by which it must be announced
MAX_OFFSET, MAX_RATE = 0.1, 0.1  # mm and mm/s, as configs/mill sets them
ANNOUNCING = ["growth." + pin for pin in ("doubt", "fault", "reference-refused", "learning-failed")]
# Attacks, and whether no contact counts any more: the operator must know.
ATTACKS = {
    "load_frozen": True,
    "load_dead": True,
    "load_not_a_number": True,
    "load_not_valid": True,
    "load_noisy": False,
    "sister_tool": True,
    "tool_longer_than_its_table": False,
    "feed_override": False,
    "spindle_override": False,
    "step": False,
    "abort": False,
    "off_and_on": False,
}
GROWTH = """
loadrt limit3 names=warming
setp warming.maxv 0.0002
unlinkp mill.growth-replay
net grown warming.out => mill.growth-replay
addf warming servo-thread
"""


class Attacked(unittest.TestCase):
    turn = 0

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        cls.name = list(ATTACKS)[Attacked.turn % len(ATTACKS)]
        Attacked.turn += 1
        machine = linuxcnc_runs.copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "mill.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = growth.hal"))
        with open(os.path.join(machine, "growth.hal"), "w") as file:
            file.write(GROWTH)
        its, _ = linuxcnc_runs.work(folder, ini, "mill_attacks.py", cls.name)
        cls.facts, cls.messages = its["facts"], its["errors"] + its["messages"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, its["scenes"])
        cls.announced = sum(cls.shift[pin] for pin in ANNOUNCING) > 0

    def cuts(self, scene):
        """The last row of each cut, its error from that in the cycle of learning, and by how much the offset makes it worse; um."""
        ends = changes(self.shift["mill.truth-cuts"])
        error = self.shift["mill.truth-cut-error"] / um

        def of(scene):
            return ends[(ends >= self.rows[scene][0]) & (ends <= self.rows[scene][-1])]

        rows, learnt = of(scene), of("learnt")
        errors = error[rows] - error[learnt[: len(rows)]]
        worse = abs(errors) - abs(errors - self.shift["axis.z.eoffset"][rows - 1] / um)
        return rows, errors, worse

    def test_the_offset_keeps_its_bounds_and_its_rate(self):
        offset = self.shift["axis.z.eoffset"]
        self.assertLessEqual(abs(offset).max(), MAX_OFFSET)
        on = self.shift["motion.motion-enabled"][1:] * self.shift["motion.motion-enabled"][:-1] > 0  # else LinuxCNC drops it, and moves nothing
        self.assertLessEqual(abs(np.diff(offset))[on].max(), 1.001 * MAX_RATE * PERIOD)

    def test_the_offset_stands_in_the_work(self):
        moves = abs(np.diff(self.shift["axis.z.eoffset"])) > 1e-9
        # An abort takes the offset out of force, slowly, wherever the tool is.
        cutting = (self.shift["mill.engagement"][1:] > 0) & (self.shift["motion.digital-out-00"][1:] > 0)
        self.assertEqual(np.count_nonzero(moves & cutting), 0, self.name)

    def test_before_the_attack_the_parts_are_true(self):
        _, errors, _ = self.cuts("warm_2")
        self.assertLess(abs(errors[2:]).max(), 6, self.name)

    def test_two_cycles_later_no_cut_is_worse_unless_announced(self):
        rows, errors, worse = self.cuts("attacked_3")
        sigma = self.shift["growth.offset-sigma"][rows] / um
        announced = self.announced[rows - round(LEAD / PERIOD)]
        self.assertGreater(len(rows), 0, self.name)
        self.assertFalse(np.any((worse > 3 + sigma) & ~announced), "%s: %s %s %s" % (self.name, errors, worse, announced))

    def test_lost_contacts_are_announced_in_two_cycles_and_the_operator_gets_a_message(self):
        if ATTACKS[self.name]:
            self.assertTrue(self.announced[self.rows["attacked_2"][-1]], self.name)
            self.assertTrue(any("offset" in message or "reference" in message for message in self.messages), self.messages)


tearDownModule = starts("mill/mill.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Attacked, __doc__)

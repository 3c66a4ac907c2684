#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill on days with disturbances: the depth of each cut, and that nothing moves by itself.

    python3 tests/support/run.py tests/configs/mill_linuxcnc_test.py --repeat 20 --hogs 2 --speed 10

goes through these days twenty times beside two busy loops, and counts failures.
"""

import os
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, STILL, changes, nm, own_folder, read_recording, um
from starts import starts

TOLERANCE = 6 * um  # of the cuts
MAX_RATE = 0.1  # mm/s, of the stage
STEP = 0.5 * nm  # of a cycle, at least, in motion: at home LinuxCNC 2.9.4 sets its command exactly, by 0.2 nm
UNKNOWN = 51  # status-code
OPERATIONS = [10, 10, 10, 20, 20, 30]
# Parts made with compensation: their names give the event before them.
COMPENSATED = {
    "first": ["compensated", "compensated_again", "after_abort", "after_stop", "after_off_and_on", "after_homing"],
    "second": ["after_restart"],
}

# Growth that comes while parts are made, and a load that is as good as a load can be.
GROWTH = """
setp drive.white-noise   0.1
setp drive.flicker-noise 0.05
setp drive.quantum       0.1
loadrt limit3 names=warming
setp warming.maxv 0.0001
unlinkp mill.growth-replay
net grown warming.out => mill.growth-replay
addf warming servo-thread
"""


class Days(unittest.TestCase):
    """Starts of LinuxCNC, in each of which programs/mill_disturbances.py works through a day."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "mill.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = growth.hal"))
        with open(os.path.join(machine, "growth.hal"), "w") as file:
            file.write(GROWTH)
        cls.days, cls.facts = {}, {}
        for day in ("first", "second", "forgotten"):
            if day == "forgotten":
                os.remove(os.path.join(machine, "mill.retained"))
            cls.facts[day], _ = linuxcnc_runs.work(folder, ini, "mill_disturbances.py", day, facts=day + ".json")
            cls.days[day] = read_recording(os.path.join(machine, day + ".csv"))

    def rows(self, day, scene):
        return linuxcnc_runs.rows_of(self.days[day], self.facts[day]["scenes"])[scene]

    def cuts(self, day, scene):
        """Rows after those in which a cut of this scene has ended."""
        rows = self.rows(day, scene)
        ends = changes(self.days[day]["mill.truth-cuts"])
        return ends[(ends >= rows[0]) & (ends <= rows[-1])]

    def errors(self, day, scene):
        rows = self.cuts(day, scene)
        self.assertEqual(list(self.days[day]["mill.truth-cut-operation"][rows]), OPERATIONS, scene)
        return self.days[day]["mill.truth-cut-error"][rows]

    def recent(self, happens, rows=10):
        """Whether something happens now, or did in some rows before: as many as LinuxCNC's interpolation takes."""
        return np.convolve(happens, np.ones(rows))[: len(happens)] > 0

    def test_every_servo_cycle_is_recorded(self):
        for day in self.days.values():
            np.testing.assert_allclose(np.diff(day["time"]), PERIOD, rtol=0, atol=1e-9)

    def test_parts_are_true_on_the_cold_machine(self):
        self.assertLess(abs(self.errors("first", "learnt")).max(), 3 * um)

    def test_without_compensation_growth_goes_into_the_work(self):
        growth = self.days["first"]["mill.truth-growth"][self.cuts("first", "uncompensated")]
        self.assertGreater(growth[0], 9 * um)
        np.testing.assert_allclose(self.errors("first", "uncompensated"), -growth, atol=3 * um)

    def test_restart_without_what_was_learnt_leaves_growth_in_the_work(self):
        growth = self.days["forgotten"]["mill.truth-growth"][self.cuts("forgotten", "after_restart")]
        self.assertGreater(growth[0], 25 * um)
        np.testing.assert_allclose(self.errors("forgotten", "after_restart"), -growth, atol=3 * um)

    def test_with_compensation_cuts_are_true_from_the_second_contact_on(self):
        for day, scenes in COMPENSATED.items():
            for scene in scenes:
                with self.subTest(scene):
                    first = 2 if scene == "after_restart" else 1  # a growth of which nothing is known takes two contacts
                    self.assertLess(abs(self.errors(day, scene)[first:]).max(), TOLERANCE)
        self.assertGreater(self.days["first"]["mill.truth-growth"][-1], 25 * um)

    def test_cut_that_is_broken_off_is_true_as_well(self):
        for scene in ("aborted", "stopped"):
            with self.subTest(scene):
                rows = self.cuts("first", scene)
                self.assertEqual(len(rows), 2)
                self.assertLess(abs(self.days["first"]["mill.truth-cut-error"][rows[1]]), TOLERANCE)

    def test_nothing_moves_but_by_a_program_or_in_a_cycle(self):
        for name, day in self.days.items():
            with self.subTest(name):
                moved = abs(np.diff(day["joint.2.motor-pos-cmd"], prepend=0)) > STEP
                programmed = self.recent(abs(np.diff(day["axis.z.pos-cmd"], prepend=0)) > STEP)
                cycle = self.recent(day["motion.digital-out-00"] + day["z-axis-stage.clear"])
                taken_out = self.recent(day["growth.enabled"] == 0)
                on = day["motion.motion-enabled"] == 1
                self.assertEqual(list(np.flatnonzero(moved & ~programmed & ~cycle & ~taken_out & on)), [])
                rate = abs(np.diff(day["joint.2.motor-pos-cmd"], prepend=0)) / PERIOD
                self.assertLess(rate[~programmed & on].max(), MAX_RATE * 1.001)

    def test_program_moves_z_only_while_a_move_is_carried_out(self):
        for name, day in self.days.items():
            with self.subTest(name):
                moved = abs(np.diff(day["axis.z.pos-cmd"], prepend=0)) > STEP
                moving = self.recent(np.append(day["motion.motion-type"][1:], 0) != 0)  # in the cycle after it
                turned_on = self.recent(np.diff(day["motion.motion-enabled"], prepend=0) != 0)
                on = day["motion.motion-enabled"] == 1
                self.assertEqual(list(np.flatnonzero(moved & on & ~moving & ~turned_on)), [])

    def test_stop_off_and_on_let_the_axis_where_it_is(self):
        day = self.days["first"]
        switched = changes(day["motion.motion-enabled"])
        offs, ons = switched[1::2], switched[2::2]
        self.assertEqual(len(ons), 2)
        for off, on in zip(offs, ons):
            until = on + 500  # which is before the next command
            for pin in ("joint.2.motor-pos-cmd", "mill.z-position"):
                self.assertLess(np.ptp(day[pin][off + 100 : until]), 1 * um, pin)
            self.assertLess(np.ptp(day["joint.2.motor-pos-cmd"][on:until]), nm)
            self.assertGreater(day["axis.z.eoffset"][off], 15 * um)
            self.assertAlmostEqual(day["axis.z.eoffset"][until], 0, delta=STILL)
            self.assertTrue(day["z-axis-stage.uncompensated"][until])

    def test_stage_is_armed_by_the_start_of_a_part_alone(self):
        for name, day in self.days.items():
            with self.subTest(name):
                armed = np.flatnonzero(np.diff(day["z-axis-stage.armed"], prepend=0) == 1)
                scenes = [self.facts[name]["scenes"][int(day["scene"][row]) - 1] for row in armed]
                first = ["learnt", "after_stop", "after_off_and_on", "after_homing"]
                self.assertEqual(scenes, {"first": first, "second": ["rejected"]}.get(name, ["after_restart"]))

    def test_cycle_of_a_program_that_was_not_identified_is_refused(self):
        for day in ("second", "forgotten"):
            self.assertIn("which program is this?", self.facts[day]["errors"][0])

    def test_without_retain_growth_is_not_compensated_and_the_operator_knows(self):
        for name in ("second", "forgotten"):
            day, rows = self.days[name], self.rows(name, "retain_killed")
            self.assertEqual(list(day["growth.enabled"][rows[[0, -1]]]), [1, 0])
            self.assertTrue(day["square.enabled"][rows].all())  # which needs no plumb-retain
            self.assertAlmostEqual(day["axis.z.eoffset"][rows[-1]], 0, delta=nm)
            self.assertIn("plumb-retain (service 0) does not answer", self.facts[name]["errors"][-1])

    def test_touch_off_is_refused_as_long_as_no_contact_was_accepted(self):
        day, rows = self.days["second"], self.rows("second", "rejected")
        self.assertEqual(np.ptp(day["growth.contacts"][rows]), 1)
        self.assertEqual(np.ptp(day["growth.contacts-accepted"][rows]), 0)
        self.assertIn("no contact was accepted yet", self.facts["second"]["errors"][1])

    def test_after_a_restart_the_unknown_growth_is_told_before_the_first_cut(self):
        day, first = self.days["second"], self.cuts("second", "after_restart")[0]
        contact = changes(day["growth.contacts-accepted"])[0]
        cycle = self.rows("second", "after_restart")[0]
        self.assertLess(cycle, contact)
        self.assertEqual(set(day["growth.status-code"][cycle:contact]), {UNKNOWN})
        self.assertFalse(day["growth.doubt"][self.rows("second", "after_restart")[-1]])
        self.assertGreater(first, contact)
        unknown = [text for text in self.facts["second"]["messages"] if "growth is not known" in text]
        self.assertEqual(unknown, ["Growth of Z: Waits for the first contact: the growth is not known yet. The program brings it. Until then nothing is corrected: pre-cut, probe, or accept."])

    def test_offset_stands_while_the_tool_is_in_the_work(self):
        for name, day in self.days.items():
            with self.subTest(name):
                # While it is drawn out of the work it bears on the bottom no more.
                rising = np.diff(day["axis.z.pos-cmd"], prepend=0) > 0
                cutting = (day["mill.engagement"] > 0) & (day["motion.motion-enabled"] == 1) & ~rising
                # That the offset is forgotten when the machine is turned on is no motion.
                turned_on = self.recent(np.diff(day["motion.motion-enabled"], prepend=0) != 0)
                moved = abs(np.diff(day["axis.z.eoffset"], prepend=0)) * (cutting & ~turned_on)
                number = np.cumsum(np.diff(cutting, prepend=0) == 1)
                travel = np.bincount(number, moved)
                self.assertGreater(len(travel), 5)
                scene = self.facts[name]["scenes"][int(day["scene"][np.argmax(number == travel.argmax())]) - 1]
                self.assertLess(travel.max(), 1 * um, scene)  # until the load has shown that it is there

    def test_nothing_moves_while_the_machine_is_idle(self):
        day = self.days["first"]
        for scene in ("idle", "idle_after_abort"):
            with self.subTest(scene):
                rows = self.rows("first", scene)
                self.assertGreater(len(rows), 60 / PERIOD)
                self.assertGreater(day["axis.z.eoffset"][rows[0]], 10 * um)
                self.assertLess(np.ptp(day["joint.2.motor-pos-cmd"][rows]), STILL)

    def test_homing_without_an_offset_moves_nothing(self):
        day, rows = self.days["first"], self.rows("first", "homed_again")
        self.assertAlmostEqual(day["axis.z.eoffset"][rows[-1]], 0, delta=nm)
        self.assertLess(np.ptp(day["joint.2.motor-pos-cmd"][rows[-400:]]), nm)

    def test_probing_with_an_offset_in_force_is_refused(self):
        day, rows = self.days["first"], self.rows("first", "probing")
        probing = rows[day["motion.motion-type"][rows] == 5]
        self.assertGreater(day["axis.z.eoffset"][probing[0]], 15 * um)
        self.assertLess(np.ptp(day["joint.2.motor-pos-cmd"][probing]), 0.1)
        errors = self.facts["first"]["errors"]
        self.assertEqual(len(errors), 2, errors)
        self.assertTrue(any("Probing is aborted" in error for error in errors), errors)


tearDownModule = starts("mill/mill.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Days, __doc__)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill with thermal_displacement and squareness at once: a column that leans, and a spindle that grows.

    python3 tests/support/run.py tests/configs/mill_both_linuxcnc_test.py --repeat 20 --hogs 2 --speed 10

goes through these days twenty times beside two busy loops, and counts failures.
"""

import os
import re
import unittest
import zlib

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import STILL, changes, nm, own_folder, read_recording, um
from starts import starts

GROWN = 15 * um
PLACES = [(-200, -150), (200, -150), (200, 150), (-200, 150)]
OPERATIONS = [10, 10, 10, 20]
LEAN_X, LEAN_Z = 0.00016, 0.00012  # of the column, towards + as Y goes to +
LENGTHS = [50, 50, 50, 62.5]  # of the tools
TOLERANCE = 7 * um  # of the depth of cuts: the seat of the tools, and the noise of the load
SETTLED = 0.05 * um  # of the tip, by squareness
SANITIZED = bool(os.environ.get("PLUMB_SANITIZE"))  # one short day shows the same code
TABLE = ("neither", "growth_alone", "square_alone", "both")
COMPENSATED = ("both", "after_abort", "after_off_and_on", "after_homing")
FEED, PROBE = 2, 5  # motion types

# A load that is as good as a load can be.
MEASURE = """
setp drive.white-noise   0.1
setp drive.flicker-noise 0.05
setp drive.quantum       0.1
"""


def rename_records(path, now, former):
    """Makes the store of plumb-retain one of a machine whose function had another name."""
    with open(path) as file:
        rest = file.read().partition("\n")[2]
    assert '"%s" = [' % now in rest, rest[:300]
    rest = rest.replace('"%s" = [' % now, '"%s" = [' % former)
    with open(path, "w") as file:
        file.write("# retain 1, CRC-32 of the rest: %08x\n%s" % (zlib.crc32(rest.encode()), rest))


class Days(unittest.TestCase):
    """Starts of LinuxCNC, in each of which programs/mill_both_scenario.py works through a day."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        cls.machine = machine = linuxcnc_runs.copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "mill.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = measure.hal"))
        with open(os.path.join(machine, "measure.hal"), "w") as file:
            file.write(MEASURE)
        cls.days, cls.facts = {}, {}
        for day in ("first", "restarted", "renamed") if not SANITIZED else ("short",):
            if day == "renamed":
                rename_records(os.path.join(machine, "mill.retained"), "growth", "thermal")
            cls.facts[day], _ = linuxcnc_runs.work(folder, ini, "mill_both_scenario.py", day, facts=day + ".json")
            cls.days[day] = read_recording(os.path.join(machine, day + ".csv"))
        if SANITIZED:
            cls.days["first"], cls.facts["first"] = cls.days["short"], cls.facts["short"]

    def rows(self, scene, day="first"):
        return linuxcnc_runs.rows_of(self.days[day], self.facts[day]["scenes"])[scene]

    def errors(self, scene, day="first"):
        """Of the tip at the bottom of each cut of a part, in X, Y and Z: a row for each cut."""
        rows, its = self.rows(scene, day), self.days[day]
        ends = changes(its["mill.truth-cuts"])
        ends = ends[(ends >= rows[0]) & (ends <= rows[-1])]
        self.assertEqual(list(its["mill.truth-cut-operation"][ends]), OPERATIONS, scene)
        errors = np.column_stack([its["portal.truth-%s-error" % axis][ends] for axis in "xyz"])
        errors[:, 2] += its["mill.truth-cut-error"][ends]
        return errors

    def lean(self):
        """What the column does to the tip at these places."""
        y = np.array([place[1] for place in PLACES])
        return np.column_stack([LEAN_X * y, LEAN_Z * np.array(LENGTHS), LEAN_Z * y])

    @unittest.skipIf(SANITIZED, "not on the short day")
    def test_table(self):
        print("\nlargest error at the cuts, um      X      Y      Z")
        for scene in TABLE:
            print("  %-26s" % scene.replace("_", " ") + "".join("%7.1f" % e for e in abs(self.errors(scene)).max(axis=0) / um))
        largest = {scene: abs(self.errors(scene)).max(axis=0) for scene in TABLE}
        self.assertLess(largest["both"][2], largest["growth_alone"][2] / 2)
        self.assertLess(largest["both"][2], largest["square_alone"][2] / 2)
        self.assertLess(max(largest["growth_alone"][2], largest["square_alone"][2]), largest["neither"][2])

    @unittest.skipIf(SANITIZED, "not on the short day")
    def test_with_neither_both_diseases_go_into_the_work(self):
        expected = self.lean() - [0, 0, GROWN]
        np.testing.assert_allclose(abs(self.errors("neither")[:, :2]), abs(expected[:, :2]), atol=0.1 * um)
        np.testing.assert_allclose(self.errors("neither")[:, 2], expected[:, 2], atol=3 * um)

    @unittest.skipIf(SANITIZED, "not on the short day")
    def test_growth_alone_leaves_the_lean(self):
        np.testing.assert_allclose(self.errors("growth_alone")[:, 2], self.lean()[:, 2], atol=TOLERANCE)
        np.testing.assert_allclose(abs(self.errors("growth_alone")[:, 0]), abs(self.lean()[:, 0]), atol=0.1 * um)

    def test_squareness_alone_leaves_the_growth(self):
        errors = self.errors("square_alone")
        self.assertLess(abs(errors[:, :2]).max(), SETTLED)
        np.testing.assert_allclose(errors[:, 2], -GROWN, atol=3 * um)

    def test_both_leave_neither(self):
        for scene in COMPENSATED:
            with self.subTest(scene):
                errors = self.errors(scene)
                self.assertLess(abs(errors[:, :2]).max(), SETTLED)
                self.assertLess(abs(errors[:, 2]).max(), TOLERANCE)

    def test_each_way_into_z_carries_its_own_function(self):
        rows = self.rows("both")
        its = self.days["first"]
        feeding = rows[its["motion.motion-type"][rows] == FEED]
        np.testing.assert_allclose(its["axis.z.eoffset"][feeding], GROWN, atol=TOLERANCE)
        self.assertGreater(len(feeding), 1000)

    def test_tip_is_on_its_way_whenever_it_feeds_also_after_a_tool_change(self):
        for scene in COMPENSATED:
            rows = self.rows(scene)
            feeding = rows[self.days["first"]["motion.motion-type"][rows] == FEED]
            self.assertGreater(len(feeding), 1000)
            for axis in "xyz":
                with self.subTest(scene=scene, axis=axis):
                    self.assertLess(abs(self.days["first"]["portal.truth-%s-error" % axis][feeding]).max(), SETTLED)

    def test_machine_learns_again_when_squareness_is_switched_on(self):
        self.assertFalse(self.facts["first"]["facts"]["learning failed"])
        errors = self.errors("learnt")
        self.assertLess(abs(errors[:, 2]).max(), 3 * um)

    def test_abort_moves_nothing(self):
        rows = self.rows("aborted")[-500:]
        for axis in "xyz":
            self.assertLess(np.ptp(self.days["first"][axis + "-stage.drive-command"][rows]), STILL, axis)
        self.assertAlmostEqual(self.days["first"]["axis.z.eoffset"][rows[-1]], GROWN, delta=TOLERANCE)

    def test_off_and_on_move_nothing(self):
        its, rows = self.days["first"], self.rows("off_and_on")
        off = rows[its["motion.motion-enabled"][rows] == 0]
        self.assertGreater(len(off), 400)
        after = np.arange(off[0] + 100, rows[-1])
        for axis in "xyz":
            self.assertLess(np.ptp(its["portal.%s-position" % axis][after]), 1 * um, axis)
            on = after[after > off[-1] + 1]
            self.assertLess(np.ptp(its[axis + "-stage.drive-command"][on]), nm, axis)
        self.assertGreater(its["axis.z.eoffset"][rows[0]], GROWN / 2)
        offset, uncompensated = self.facts["first"]["facts"]["off and on"]
        self.assertAlmostEqual(offset, 0, delta=STILL)  # LinuxCNC has forgotten it
        self.assertTrue(uncompensated)

    def test_homing_with_an_offset_in_force_is_refused(self):
        its, rows = self.days["first"], self.rows("homed_too_early")
        self.assertTrue(its["motion.homing-inhibit"][rows].all())
        for axis in "xyz":
            self.assertLess(np.ptp(its[axis + "-stage.drive-command"][rows]), nm, axis)
        self.assertIn("Homing denied by motion.homing-inhibit joint=-1", self.facts["first"]["errors"])
        self.assertEqual(self.facts["first"]["facts"]["homed"], [False] * 4)

    def test_probing_with_the_offset_in_force_is_refused(self):
        its, rows = self.days["first"], self.rows("probing")
        probing = rows[its["motion.motion-type"][rows] == PROBE]
        self.assertGreater(its["axis.z.eoffset"][probing[0]], GROWN / 2)
        self.assertLess(np.ptp(its["z-stage.drive-command"][probing]), 0.1)
        self.assertTrue(any("Probing is aborted" in error for error in self.facts["first"]["errors"]))
        self.assertEqual(len(self.facts["first"]["errors"]), 3, self.facts["first"]["errors"])

    def test_flat_work_is_probed_flat_and_where_the_offset_will_be_right(self):
        tops = self.facts["first"]["facts"]["tops"]
        self.assertLess(abs(tops[0] - tops[1]), 1 * um)  # 36 um by the column
        right = -250 + GROWN - self.facts["first"]["facts"]["wanted"]
        np.testing.assert_allclose(tops, right, atol=3 * um)  # the seat of the probe

    def test_touch_off_comes_out_alike_with_the_offset_and_without(self):
        for top in self.facts["first"]["facts"]["touched off"]:
            self.assertAlmostEqual(top, self.facts["first"]["facts"]["tops"][-1], delta=0.2 * um)

    @unittest.skipIf(SANITIZED, "not on the short day")
    def test_restart_keeps_what_was_learnt_also_under_the_former_name(self):
        for day in ("restarted", "renamed"):
            with self.subTest(day):
                self.assertEqual(self.facts[day]["facts"]["rows"], len(PLACES))
                errors = self.errors("after_restart", day)
                self.assertLess(errors[0, 2], -GROWN / 2)  # no contact was seen yet
                self.assertLess(abs(errors[1:, 2]).max(), TOLERANCE)
                self.assertLess(abs(errors[:, :2]).max(), SETTLED)
                self.assertEqual(self.facts[day]["facts"]["errors"], [])
        with open(os.path.join(self.machine, "mill.retained")) as file:
            self.assertEqual(re.findall(r'^"(\w+)" = \[', file.read(), re.M), ["growth"])

    @unittest.skipIf(SANITIZED, "the short day has no losses")
    def test_offsets_hold_without_task_and_retain_until_the_program_ends(self):
        day, lost, returned = self.days["renamed"], self.rows("lost", "renamed"), self.rows("returned", "renamed")
        held = lost[np.flatnonzero(day["interlock.feed-service-lost"][lost])[0] :]
        self.assertGreater(np.ptp(day["x-stage.drive-command"][lost[0] : held[0]]), 1)  # motion goes on without task
        self.assertLess(np.ptp(day["x-stage.drive-command"][held[500:]]), nm)
        self.assertGreater(day["axis.z.eoffset"][lost[0]], 5 * um)
        self.assertLess(np.ptp(day["axis.z.eoffset"][lost]), STILL)
        self.assertTrue(day["growth.enabled"][lost].all())
        self.assertEqual([day[name + ".enabled"][returned[-1]] for name in ("growth", "square")], [0, 1])
        self.assertAlmostEqual(day["axis.z.eoffset"][returned[-1]], 0, delta=nm)


tearDownModule = starts("mill/mill.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Days, __doc__)

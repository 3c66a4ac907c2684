#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/portal: where a cut begins after another tool, by the servo cycles of a complete LinuxCNC.

    python3 tests/support/run.py tests/configs/portal_settling_test.py --repeat 20 --hogs 2 --speed 10

cuts twenty times beside two busy loops, and counts failures.
"""

import os
import sys
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, STILL, own_folder, read_recording, um

EXACT = 0.01 * um  # of the tip
AT_ONCE = 0.2 * um  # where the drives are yet behind the last step of the ramp, by 3 ms
RAPID, FEED, ARC = 1, 2, 3  # motion types
NOT_HELD = ("m49_m53", "m51_m53")
HELD = ("plain", "m48", "m49", "m50", "m51", "m52", "m53")
EARLY = "Squareness: The next cut did not wait for the correction of its tool. "
CHECK = " Check the first cut of this tool."


class Settling(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("portal", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "column.ini"))
        its, _ = linuxcnc_runs.work(folder, ini, "settling_scenario.py")
        cls.facts, cls.messages = its["facts"], its["facts"]["messages"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, its["scenes"])
        cls.error = np.linalg.norm([cls.shift["portal.truth-%s-error" % letter] for letter in "xyz"], axis=0)
        cls.moves = abs(cls.shift["motion.current-vel"]) > 1e-9
        cls.works = ~np.isin(cls.shift["motion.motion-type"], (0, RAPID))

    def last_change(self, scene):
        """The row in which the last tool of a scene is in force."""
        rows = self.rows[scene]
        return rows[linuxcnc_runs.changes(self.shift["motion.tooloffset.z"][rows])[-1]]

    def begin_of_the_cut(self, scene):
        """The row of the first motion that cuts behind the last change of the tool; its type comes a cycle later."""
        rows = np.arange(self.last_change(scene), self.rows[scene][-1] - 1)
        begins = self.moves[rows] & (self.shift["motion.motion-type"][rows + 1] != RAPID)
        return rows[np.flatnonzero(begins)[0]]

    def held(self, scene):
        """For how many cycles a cut waited at its start."""
        rows = self.rows[scene]
        return np.count_nonzero((self.works & ~self.moves & (self.shift["square.settling"] == 1))[rows])

    def test_every_servo_cycle_is_recorded(self):
        np.testing.assert_allclose(np.diff(self.shift["time"]), PERIOD, rtol=0, atol=1e-9)

    def test_without_it_a_cut_begins_beside_its_place(self):
        error = self.error[self.begin_of_the_cut("without")]
        print("\nwithout settling a cut begins %.1f um off" % (error / um), file=sys.stderr)
        self.assertGreater(error, 10 * um)

    def test_with_it_a_cut_begins_in_its_place(self):
        for scene in (*HELD, "between_cuts", "arc", "behind_a_rapid"):
            begin = self.begin_of_the_cut(scene)
            self.assertLess(self.error[begin], AT_ONCE, scene)
            self.assertLess(self.error[begin + 20 : self.rows[scene][-1]].max(), EXACT, scene)
        for scene in (*HELD, "g49", "between_cuts", "arc", "behind_a_rapid"):
            self.assertEqual(self.shift["square.ramping"][self.begin_of_the_cut(scene) - 1], 0, scene)
            since = np.arange(self.last_change(scene), self.rows[scene][-1])
            self.assertEqual(self.shift["square.unsettled-code"][since].max(), 0, scene)
            self.assertEqual(self.messages[scene], [], scene)
        # However late a busy computer comes with the cut, here and there it has to wait.
        self.assertGreater(sum(self.held(scene) > 0 for scene in HELD), len(HELD) / 2)
        worst = max(self.error[self.begin_of_the_cut(scene)] for scene in HELD)
        print("\nwith settling a cut begins %.2g um off" % (worst / um), file=sys.stderr)

    def test_with_feed_hold_and_its_substitute_off_the_cut_begins_early_and_the_operator_gets_a_message(self):
        for scene in NOT_HELD:
            begin = self.begin_of_the_cut(scene)
            self.assertGreater(self.error[begin], 5 * um, scene)
            self.assertEqual(self.shift["square.unsettled-code"][begin + 1], 5, scene)
            self.assertEqual(len(self.messages[scene]), 1, scene)
            self.assertTrue(self.messages[scene][0].startswith(EARLY + "A cut began"), scene)

    def test_overrides_that_come_back_stop_no_cut(self):
        for scene in NOT_HELD:
            begin = self.begin_of_the_cut(scene)
            x = self.shift["joint.0.pos-cmd"][begin : self.rows[scene][-1]]
            cut = np.count_nonzero(np.diff(x)) * PERIOD
            stands = np.diff(x[: np.flatnonzero(np.diff(x))[-1]]) == 0
            held = self.shift["motion.feed-inhibit"][begin:][: len(stands)] + self.shift["motion.feed-hold"][begin:][: len(stands)] > 0
            self.assertLess(cut, 65 / 50 + 0.2, scene)
            self.assertEqual(np.count_nonzero(stands & held), 0, scene)  # LinuxCNC stops by itself for some of them

    def test_it_is_never_true_in_a_cut(self):
        settling = self.shift["square.settling"] == 1
        cutting = self.works & self.moves
        both = settling & cutting
        self.assertEqual(np.count_nonzero(both), 0)
        self.assertGreater(np.count_nonzero(settling), 1000)

    def test_its_signal_reaches_motion_in_the_cycle_in_which_the_tool_is_in_force(self):
        rows = np.concatenate([self.rows[scene] for scene in (*HELD, *NOT_HELD)])
        for pin in ("feed-inhibit", "feed-hold"):
            np.testing.assert_array_equal(self.shift["motion." + pin][rows], self.shift["square.settling"][rows])
        for scene in HELD:
            self.assertEqual(self.shift["square.settling"][self.last_change(scene)], 1, scene)

    def test_a_tool_that_is_no_longer_holds_nothing(self):
        self.assertEqual(self.shift["square.settling"][self.rows["no_longer"][-1]], 0)
        self.assertEqual(self.held("no_longer"), 0)

    def test_mdi_waits_too(self):
        self.assertGreater(self.held("mdi"), 0)
        self.assertLess(self.error[self.begin_of_the_cut("mdi")], AT_ONCE)

    def test_abort_ends_the_wait_of_one_cut_and_the_next_one_waits(self):
        place, settling = self.facts["aborted"]
        self.assertAlmostEqual(place, 0, delta=STILL)
        self.assertTrue(settling)
        self.assertLess(self.error[self.begin_of_the_cut("abort")], AT_ONCE)

    def test_jogs_do_not_wait(self):
        self.assertEqual(self.facts["jogged while it ramps"], [True, True])
        rows = self.rows["jog_in_both_modes"]
        jogs = self.shift["motion.coord-mode"][rows] == 0
        self.assertGreater(np.count_nonzero(jogs), 200)
        self.assertEqual(self.shift["square.settling"][rows][jogs].max(), 0)
        self.assertEqual(self.messages["jog_in_both_modes"], [])

    def test_released_early_the_operator_gets_the_reason(self):
        for scene, code, why in (
            ("late", 4, "Settling took longer than settling-time."),
            ("disable", 1, "The correction was switched off, or a joint is not homed any more."),
            ("in_a_cut", 6, "The tool changed in a cut."),
        ):
            self.assertIn(code, self.shift["square.unsettled-code"][self.rows[scene]], scene)
            self.assertEqual(self.messages[scene], [EARLY + why.replace("settling-time", "settling time (10 s)") + CHECK], scene)
        settled = np.count_nonzero(self.shift["square.settling"][self.last_change("late") : self.rows["late"][-1]]) * PERIOD
        self.assertAlmostEqual(settled, 0.3, delta=2 * PERIOD)

    def test_a_change_in_a_cut_does_not_slow_it(self):
        rows = self.rows["in_a_cut"]
        fast = rows[self.works[rows] & (self.shift["motion.current-vel"][rows] > 49.9)]
        self.assertEqual(np.ptp(fast), len(fast) - 1)
        self.assertTrue((self.shift["square.unsettled-code"][fast] == 6).any())

    def test_threads_and_taps_run_as_they_do_without(self):
        for scene in ("thread", "tap"):
            begin = self.begin_of_the_cut(scene)
            self.assertTrue(self.shift["square.ramping"][begin], scene)
            self.assertEqual(self.shift["square.unsettled-code"][begin + 1], 5, scene)
            lengths = []
            for name in (scene, scene + "_settled"):
                rows = np.arange(self.last_change(name), self.rows[name][-1])
                z = self.shift["joint.2.pos-cmd"][rows]
                deepest = np.argmin(z)
                self.assertAlmostEqual(z[0] - z[deepest], 21, delta=1.1, msg=name)  # a tap goes on until the spindle turns back
                down = np.arange(deepest)
                down = down[(z[down] < z[0] - 5) & (z[down] > z[0] - 18)]
                pitch = z[down] + self.shift["spindle.0.revs"][rows][down]
                self.assertLess(np.ptp(pitch), 0.02, name)
                lengths.append(len(down) * PERIOD)
            self.assertAlmostEqual(*lengths, delta=0.02, msg=scene)


if __name__ == "__main__":
    linuxcnc_runs.main(Settling, __doc__)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/grinder: chopping in a complete LinuxCNC, judged by the servo cycles of a shift.

    python3 tests/support/run.py tests/configs/grinder_linuxcnc_test.py --repeat 20 --hogs 2 --speed 10
"""

import os
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, STILL, nm, own_folder, read_recording, um
from starts import starts

UPPER, LOWER, R = 5, -25, 10  # of the stroke of the scenario and of the first one of contour.ngc
SHIFT = 10  # mm, of the second region of contour.ngc
FEED = 20  # mm/s, of the contour
HARDEST = 1000  # mm/s2, chop.max-acceleration


class Recorded(unittest.TestCase):
    """One start of LinuxCNC, in which a scenario works through all scenes."""

    @classmethod
    def work(cls, ini, scenario):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("grinder", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, ini))
        cls.machine = machine
        its, cls.output = linuxcnc_runs.work(folder, ini, scenario)
        cls.facts, cls.scenes, cls.errors = its["facts"], its["scenes"], its["errors"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, cls.scenes)

    def of(self, pin, scene):
        return self.shift[pin][self.rows[scene]]

    def test_every_servo_cycle_is_recorded(self):
        np.testing.assert_allclose(np.diff(self.shift["time"]), PERIOD, rtol=0, atol=1e-9)


class Shift(Recorded):
    @classmethod
    def setUpClass(cls):
        cls.work("grinder.ini", "grinder_scenario.py")

    def strokes(self, scene):
        """Rows in which it strokes, behind the first stroke."""
        rows = self.rows[scene]
        return rows[(self.shift["chop.active"][rows] == 1) & (self.shift["chop.stroke-count"][rows] >= 1)]

    def test_drive_gets_the_stroke_whole(self):
        active = self.shift["chop.active"] == 1
        difference = self.shift["z-stage.applied-offset"] - self.shift["chop.offset"]
        self.assertLess(abs(difference[active]).max(), 0.1 * nm)

    def test_strokes_of_the_contour_stay_in_their_regions_and_fill_them(self):
        rows = self.strokes("contour")
        z = self.shift["z-stage.drive-command"][rows]
        middle = np.flatnonzero(np.diff((z > UPPER + 1).astype(int)) > 0)[0]  # first beyond the old region
        first, second = z[:middle], z[middle:]
        a = HARDEST * PERIOD**2 / 8 + HARDEST * 0.02**2 / 24  # of sampling, and by jerk-time
        self.assertLessEqual(first.max(), UPPER + 2)
        self.assertGreaterEqual(first.min(), LOWER)
        self.assertAlmostEqual(first.min(), LOWER, delta=a)
        self.assertLessEqual(second.max(), UPPER + SHIFT)
        self.assertAlmostEqual(second.max(), UPPER + SHIFT, delta=a)
        later = second[3000:-2000]
        self.assertAlmostEqual(later.min(), LOWER + SHIFT, delta=a)
        self.assertGreaterEqual(later.min(), LOWER + SHIFT)

    def test_stroke_begins_and_ends_at_r_without_an_offset(self):
        offset, command = self.of("chop.offset", "contour"), self.of("joint.2.pos-cmd", "contour")
        active = self.of("chop.active", "contour") == 1
        self.assertEqual(abs(offset[~active]).max(), 0)
        self.assertEqual(np.ptp(command[active]), 0)
        self.assertAlmostEqual(command[active][0], R, delta=nm)

    def test_path_speed_is_undisturbed(self):
        rows = self.strokes("contour")
        speed = self.shift["motion.current-vel"][rows]
        moving = np.flatnonzero(speed > 0)
        inner = rows[moving[0] : moving[-1]]
        inner = inner[100:-100]  # without acceleration and braking
        self.assertGreater(len(inner), 5000)
        self.assertGreater(self.shift["motion.current-vel"][inner].min(), 0.99 * FEED)

    def test_acceleration_of_the_command_is_limited(self):
        for scene in ("contour", "pause", "abort", "back_at_r", "changed_settings", "enable_lost", "to_point_r", "learn"):
            rows = self.rows[scene]
            z = self.shift["chop.command"][rows]
            still = np.ptp(np.lib.stride_tricks.sliding_window_view(self.shift["joint.2.pos-cmd"][rows], 3), axis=1) == 0
            hardest = abs(np.diff(z, 2))[still].max() / PERIOD**2
            self.assertLess(hardest, 1.01 * HARDEST, scene)

    def test_pause_of_the_program_does_not_stop_the_stroke(self):
        rows = self.strokes("pause")
        standing = rows[self.shift["motion.current-vel"][rows] == 0]
        self.assertGreater(np.ptp(self.shift["chop.stroke-count"][standing]), 1)

    def test_abort_returns_to_r(self):
        self.assertEqual(self.of("chop.offset", "abort")[-1], 0)
        self.assertEqual(self.of("chop.active", "after_abort").max(), 0)

    def test_moves_after_an_abort_wait_until_the_wheel_is_at_r(self):
        self.assertEqual(self.facts["output"], [1, 1])  # an output at once, while it returns
        self.assertRegex(self.facts["told"], "wheel leaves the work")
        for scene in ("waiting", "next_program"):
            x, active = self.of("joint.0.pos-cmd", scene), self.of("chop.active", scene) == 1
            returning = active & (self.of("interlock.feed-inhibit", scene) == 1)
            self.assertGreater(np.count_nonzero(returning), 100, scene)
            self.assertEqual(np.ptp(x[returning][: 100]), 0, scene)
            first = np.flatnonzero(np.diff(x) != 0)[0]
            self.assertEqual(self.of("chop.at-end", scene)[first], 1, scene)
        self.assertAlmostEqual(self.of("joint.0.pos-cmd", "waiting")[-1], 30, delta=nm)

    def test_jogs_are_free_while_the_wheel_returns(self):
        x, active = self.of("joint.0.pos-cmd", "jogging"), self.of("chop.active", "jogging") == 1
        self.assertGreater(np.count_nonzero(active[1:] & (np.diff(x) != 0)), 100)

    def test_a_move_that_no_hold_stops_is_aborted(self):
        for code, way in self.facts["defeated"].items():
            self.assertLess(way, 10 * 0.05 * linuxcnc_runs.speed, code)  # mm of 40: 0.05 s of the computer's clock
        self.assertGreater("\n".join(self.errors).count("M49, M51 P0 and M53 P0"), 1)

    def test_strokes_end_with_their_program_unless_it_says_otherwise(self):
        ends = self.rows["program_ends"][np.flatnonzero(self.of("chop.stroking", "program_ends") == 1)[-1] + 1]
        self.assertEqual([self.shift[pin][ends] for pin in ("chop.active", "chop.run")], [1, 1])  # on the way to R, though the output stays
        self.assertEqual(self.facts["next_program"], [1, 0])
        self.assertGreater(self.of("chop.stroking", "next_program").max(), 0)
        self.assertEqual([self.facts["outlasting"], self.facts["of_mdi"]], [1, 1])

    def test_a_program_ends_strokes_of_mdi_and_its_first_move_waits_for_r(self):
        x, at_end = self.of("joint.0.pos-cmd", "begun_in_mdi"), self.of("chop.at-end", "begun_in_mdi") == 1
        begins = np.flatnonzero(self.of("chop.stroking", "begun_in_mdi") == 1)[-1] + 1  # of the way to R
        ends = begins + np.flatnonzero(at_end[begins:])[0]
        self.assertGreater(ends - begins, 100)
        self.assertLess(np.ptp(x[:ends]), 20 * 0.05 * linuxcnc_runs.speed + 1)  # mm: linuxcnc_alive reads by the computer's clock
        self.assertGreater(np.ptp(x[ends:]), 15)

    def test_a_program_that_begins_with_g81_1_takes_over_from_mdi(self):
        there = self.rows["taken_over"][self.of("joint.0.pos-cmd", "taken_over").argmin()]
        self.assertEqual([self.shift[pin][there] for pin in ("chop.stroking", "chop.upper")], [1, 4])

    def test_a_shift_comes_with_the_next_move_of_its_program(self):
        z, active = self.of("chop.command", "shifts"), self.of("chop.active", "shifts") == 1
        first, second = self.runs(active)
        self.assertAlmostEqual(z[first].min(), LOWER - 1, delta=0.05)  # the second one of a row
        x = self.of("joint.0.pos-cmd", "shifts")
        below = first.start + np.flatnonzero(z[first] < LOWER - 0.1)[0]
        self.assertGreater(x[below], 21)
        self.assertAlmostEqual(z[second].min(), LOWER, delta=0.05)  # none of a shift before G80.1
        at_work = z[second][np.flatnonzero(z[second] < UPPER)[0] : -1500]
        self.assertGreater(len(at_work), 2000)
        self.assertLessEqual(at_work.max(), UPPER)
        self.assertLess(at_work[-2000:].min(), LOWER + 0.05)

    def test_a_shift_in_mdi_or_before_m482_comes_at_once(self):
        z, active = self.of("chop.command", "shifted_in_mdi"), self.of("chop.active", "shifted_in_mdi") == 1
        self.assertEqual([round(z[each].min(), 1) for each in self.runs(active)], [LOWER - 1, LOWER - 2])
        self.assertAlmostEqual(self.facts["faster_cycle"], np.pi * 30 / 80, delta=0.002)
        self.assertEqual(self.facts["awaited_region"], 3)
        self.assertEqual(np.ptp(self.of("joint.0.pos-cmd", "shifted_in_mdi")), 0)

    def test_a_hold_ends_at_a_dead_point_or_at_r_and_an_emergency_at_once(self):
        (at_dead_point, _), (at_r, _), (stands, _) = self.facts["holds"]
        self.assertEqual([active for _, active in self.facts["holds"]], [1, 1, 1])
        ordered = self.of("chop.command", "holds")[np.flatnonzero(self.of("chop.emergency-hold", "holds"))[0]]
        self.assertAlmostEqual(at_dead_point, LOWER, delta=nm)
        self.assertAlmostEqual(at_r, R, delta=nm)
        self.assertLess(abs(ordered - stands), 60**2 / (2 * HARDEST) + 60 * 0.1)
        self.assertGreater(stands, LOWER + 1)

    def test_a_display_shows_r_and_the_axis(self):
        rows = self.strokes("contour")
        self.assertEqual(set(self.shift["chop.end-position"][rows]), {R})
        measured, truth = self.shift["chop.measured-position"][rows], self.shift["grinder.truth-position"][rows]
        self.assertLess(abs(measured[1:] - truth[:-1]).max(), 5 * um)
        self.assertGreater(np.ptp(measured), 30)

    def test_a_way_to_r_keeps_the_rule_of_the_lead(self):
        self.assertEqual(self.facts["lead_refused"], 8)
        z = self.of("chop.command", "to_point_r_with_a_lead")
        self.assertAlmostEqual(z[-1], R, delta=nm)
        self.assertLess(abs(np.diff(z, 2)).max() / PERIOD**2, 1.01 * HARDEST)

    def test_emergency_stop_and_off_freeze_and_turning_on_moves_nothing(self):
        for scene in ("on_again", "off_and_on"):
            begin = 0 if scene == "on_again" else np.flatnonzero(self.of("motion.motion-enabled", scene) == 0)[0] + 200
            self.assertLess(np.ptp(self.of("grinder.truth-position", scene)[begin:]), 2 * um, scene)
            self.assertLess(np.ptp(self.of("z-stage.drive-command", scene)[begin + 1 :]), 10 * um, scene)

    PLACES = ("z-stage.drive-command", "z-stage.applied-offset", "joint.2.pos-cmd")

    def test_machine_off_makes_the_stroke_part_of_the_position(self):
        on = self.shift["motion.motion-enabled"]
        falls = np.flatnonzero(np.diff(on) < 0) + 1
        falls = falls[abs(self.shift["chop.offset"][falls]) > 0.1]
        self.assertEqual(len(falls), 5)
        for at in falls:
            drive = self.shift["z-stage.drive-command"][at - 2 : at + 200]
            # The command becomes the place where the drive stands, which lags behind it by up to 1.8 mm.
            self.assertAlmostEqual(drive[2], self.shift["grinder.truth-position"][at - 1], delta=um)
            self.assertLess(abs(np.diff(drive))[2:].max(), 0.2)  # at most 100 mm/s, by the drive
            command, applied, position = (self.shift[pin][at - 5 : at + 200] for pin in self.PLACES)
            origin = command[0] - applied[0] - position[0]  # of the joint, where it was homed
            np.testing.assert_allclose(position[6:] + origin, command[6:], rtol=0, atol=nm)
            for pin in ("chop.offset", "z-stage.applied-offset", "motion.homing-inhibit"):
                self.assertEqual(abs(self.shift[pin][at + 2 : at + 200]).max(), 0, pin)

    def test_linuxcnc_shows_the_true_place_and_mdi_starts_there(self):
        for name in ("emergency_stop", "off"):
            shown, measured, truth, after_relative, offset = self.facts[name]
            self.assertLess(truth, 5, name)  # below R: the wheel is in its stroke
            self.assertAlmostEqual(shown, truth, delta=2 * um, msg=name)
            self.assertAlmostEqual(measured, truth, delta=2 * um, msg=name)
            self.assertAlmostEqual(after_relative, truth + 1, delta=2 * um, msg=name)
            self.assertEqual(offset, 0, name)
        self.assertEqual(self.facts["stands"][0], 0)  # no fault, and no message
        self.assertEqual(self.facts["stands"][1], 0)

    def test_after_a_stop_in_the_work_mdi_and_a_program_move_the_wheel_where_they_say(self):
        self.assertAlmostEqual(self.facts["mdi_after_stop"], -20, delta=5 * um)
        z, active = self.of("z-stage.drive-command", "retracted"), self.of("chop.active", "retracted") == 1
        begin = np.flatnonzero(self.of("joint.2.pos-cmd", "retracted") > 19.9)[0]  # retracted by hand
        z, active = z[begin:], active[begin:]
        self.assertTrue(active.any())
        self.assertGreaterEqual(z[~active].min(), R - nm)
        self.assertGreaterEqual(z.min(), LOWER)
        self.assertLess(abs(np.diff(z)[active[1:]]).max() / PERIOD, 61)

    def test_settings_that_change_in_the_work_take_the_wheel_nowhere_else(self):
        rows = self.strokes("changed_settings")
        z = self.shift["z-stage.drive-command"][rows]
        self.assertGreaterEqual(z.min(), LOWER)
        self.assertLessEqual(z.max(), R)
        self.assertEqual(self.facts["smaller_bound"], [0, 17])

    def test_unhoming_after_a_stop_moves_nothing_and_linuxcnc_homes(self):
        rows = self.rows["unhomed"]
        off = rows[self.shift["joint.2.homed"][rows] == 0]
        self.assertGreater(len(off), 100)
        self.assertLess(np.ptp(self.shift["grinder.truth-position"][off]), 2 * um)
        self.assertEqual(self.facts["homed_again"], 1)

    def test_a_homed_that_is_lost_amid_a_stroke_brakes_it_and_holds_the_axis(self):
        rows = self.rows["lost_homed"]
        off = rows[self.shift["joint.2.homed"][rows] == 0]
        self.assertGreater(len(off), 2500)
        command = self.shift["z-stage.drive-command"][off]
        self.assertLess(abs(np.diff(command, 2)).max() / PERIOD**2, 1.01 * HARDEST)
        self.assertGreaterEqual(self.shift["chop.command"][off].min(), LOWER)
        self.assertLess(np.ptp(self.shift["grinder.truth-position"][off[1500:]]), 2 * um)
        self.assertRegex("\n".join(self.errors), "not homed while a stroke is in force")
        self.assertRegex("\n".join(self.errors), "lost homed while the axis stroked")

    def test_g80_1_after_off_and_on_gives_the_reason_at_once(self):
        stands_off, message, seconds = self.facts["g801_after_off"]
        self.assertEqual(stands_off, 1)
        self.assertRegex(message, "machine off has ended the strokes where Z stands")
        self.assertLess(seconds, 2 * linuxcnc_runs.speed)
        self.assertEqual(self.facts["at_r"], [0, 0])

    def test_a_program_waits_for_learned(self):
        self.assertRegex(self.facts["m482_at_rest"], "M482: the axis does not stroke")
        self.assertEqual(self.facts["m482_without_learn"], [0, "", 0])
        self.assertRegex(self.facts["impatient"], "M482: the dead points were not learned in time")
        self.assertEqual(self.facts["waited"], 1)

    def test_contour_runs_at_full_speed_where_the_joint_has_proven_it(self):
        rows = self.strokes("proven")
        self.assertEqual(set(self.shift["chop.speed-factor"][rows]), {1})
        z = self.shift["grinder.truth-position"][rows]
        self.assertGreater(z.min(), LOWER - 5 * um)
        self.assertLess(z[-3000:].max(), UPPER + SHIFT + 5 * um)

    def test_stroke_after_a_stop_is_where_it_was_commanded(self):
        z = self.shift["chop.command"][self.strokes("start_again")][1000:]
        self.assertGreaterEqual(z.min(), LOWER - nm)
        self.assertLessEqual(z.max(), R + nm)
        self.assertEqual(self.facts["at_r"], [0, 0])

    def test_without_enable_or_by_go_to_end_the_axis_goes_to_r_and_stops_nowhere_in_the_work(self):
        for scene in ("enable_lost", "to_point_r"):
            z = self.of("chop.command", scene)
            self.assertEqual([self.of("chop." + pin, scene)[-1] for pin in ("offset", "active")], [0, 0], scene)
            speed = np.diff(z)
            turned = z[1:-1][speed[1:] * speed[:-1] < 0]
            self.assertGreater(len(turned), 2, scene)
            self.assertLess(np.min(abs(turned[:, None] - [UPPER, LOWER]), axis=1).max(), 0.1, scene)
            standing = z[1:][speed == 0]
            self.assertLess(np.min(abs(standing[:, None] - [UPPER, LOWER, R]), axis=1).max(), 0.1, scene)

    def test_an_enable_that_returns_starts_nothing(self):
        self.assertEqual(self.facts["enable_back"], [1, 1])
        self.assertEqual(self.of("chop.active", "enable_back").max(), 0)
        self.assertEqual(abs(self.of("chop.offset", "enable_back")).max(), 0)

    def test_refusals_give_the_reason(self):
        reasons = {
            "fast": "max-feed",
            "far": "soft limits",
            "deep": "soft limits",
            "flat": "Q0.000000 must not be 0",
            "no_q": "missing: Q",
            "negative": "P-5.000000 must be above 0",
            "F20": "F20.000000 would stay",
            "X40.5": "X40.500000 has no meaning",
            "L1": "H, L, U",
            "I-1": "I-1.000000 must be 0 to 3600",
            "J3601": "J3601.000000 must be 0 to 3600",
            "K1.5": "K1.500000 must be a number",
            "D2": "D2.000000 must be 0 or 1",
            "E-0.1": "E-0.100000 must not be below 0",
            "Q3": "Q3.000000 must be 0, 1 or 2",
            "M481 I5 J5 P1": "I5.000000 and J5.000000 must differ",
            "M481 I0 J1 P0": "P0.000000 must be 0.001",
            "G80.1 P3": "P3.000000 must be 0, 1 or 2",
            "G80.1 K0.5": "K0.500000 must be a number",
            "overlap": "Z5.000000 Q-30.000000 R25.000000 P3600.000000 was refused",
        }
        self.assertEqual(sorted(self.facts["refused"]), sorted(reasons))
        for name, reason in reasons.items():
            self.assertIn(reason, self.facts["refused"][name], name)
        self.assertIn("two overlap", self.facts["refused"]["overlap"])
        self.assertIn("soft limits", self.facts["refused"]["deep"])

    def test_a_refused_word_moves_nothing_and_leaves_no_word_behind(self):
        self.assertEqual(abs(self.of("chop.offset", "refusals")).max(), 0)
        for joint in (0, 2):
            self.assertEqual(np.ptp(self.of("joint.%d.pos-cmd" % joint, "refusals")), 0)
        self.assertEqual(self.facts["words_left"], 0)

    def test_words_are_in_work_coordinates_with_any_origin_and_tool(self):
        r = self.facts["joint"]
        self.assertAlmostEqual(self.facts["with_a_tool"][0], r - 5, delta=1e-6)
        self.assertAlmostEqual(self.facts["with_a_tool"][1], r - 35, delta=1e-6)

    def test_words_in_inches_are_those_lengths(self):
        np.testing.assert_allclose(self.facts["in_inches"], [5.08, -20.32, 25.4 * 100 / 60], rtol=1e-9)

    def test_words_of_the_program_slow_a_section_and_dwell_where_the_axis_is(self):
        self.assertEqual(self.facts["sections"], 1)
        rows = self.strokes("by_words")
        z, axis = self.shift["chop.command"][rows], self.shift["grinder.truth-position"][rows]
        speed = abs(np.diff(z)) / PERIOD
        self.assertAlmostEqual(speed.max(), 60, delta=0.5)  # the override of 0.5 does not act
        inside = (z[1:] > LOWER + 0.1) & (z[1:] < LOWER + 9.5)  # without the change of speed, which jerk-time spreads
        self.assertLess(speed[inside].max(), 0.5 * 60)
        self.assertLess(z.max(), UPPER + nm)
        upper = self.visits(abs(axis - UPPER) < 0.05)
        lower = self.visits(abs(axis - LOWER) < 0.05)
        self.assertGreater(min(upper[1:-1]), 200)
        self.assertGreater(min(lower[1:3]), 100)
        self.assertLess(min(lower), 100)  # after J0

    @staticmethod
    def runs(there):
        """The slices where it is true."""
        edges = np.flatnonzero(np.diff(np.concatenate([[0], there.astype(int), [0]])))
        return [slice(begin, end) for begin, end in zip(edges[::2], edges[1::2])]

    def visits(self, there):
        """The lengths of these."""
        return [each.stop - each.start for each in self.runs(there)]

    def test_strokes_end_at_a_dead_point_that_the_program_names(self):
        self.assertEqual(self.facts["at_lower"][1:], [0, 0])
        self.assertAlmostEqual(self.facts["at_lower"][0], LOWER, delta=nm)
        z, count = self.of("chop.command", "at_the_lower_dead_point"), self.of("chop.stroke-count", "at_the_lower_dead_point")
        self.assertGreaterEqual(np.sum(z == z.min()), 150)
        self.assertEqual(self.facts["from_lower_to_r"], [0, 1])
        self.assertGreaterEqual(count.max() - count[0], 2)  # spark-out
        self.assertEqual(abs(self.of("chop.offset", "learn")[0]), 0)

    def test_words_end_with_their_strokes(self):
        self.assertAlmostEqual(self.facts["cycle_without_words"], 2 * np.pi * 30 / 60, delta=0.01)

    def test_what_was_learned_is_kept_over_a_restart(self):
        with open(os.path.join(self.machine, "grinder.retained")) as kept:
            text = kept.read()
        self.assertRegex(text, r'"chop" = \[\n  \{ .*"?upper-offset"? = 0\.[0-9]+')

    def test_learns_the_dead_points(self):
        upper, lower = self.facts["dead_points"]
        self.assertAlmostEqual(upper, UPPER, delta=2 * um)
        self.assertAlmostEqual(lower, LOWER, delta=2 * um)
        self.assertEqual(self.facts["codes"], [0, 0])
        z = self.shift["grinder.truth-position"][self.strokes("learn")]
        self.assertGreater(z.min(), LOWER - 5 * um)

    def test_after_an_end_at_r_it_is_learned_still(self):
        self.assertEqual(self.facts["learned_again"], [1, 0])
        z = self.shift["grinder.truth-position"][self.strokes("learned_again")]
        self.assertGreater(z.min(), LOWER - 5 * um)

    def test_without_task_or_io_the_stroke_ends_at_r_and_the_feed_is_held(self):
        for scene in ("task_stopped", "io_stopped", "both_dead"):
            x, z = self.of("joint.0.pos-cmd", scene), self.of("chop.command", scene)
            lost = np.flatnonzero(self.of("interlock.feed-service-lost", scene))[0]
            self.assertLess(lost * PERIOD, 3 * linuxcnc_runs.speed, scene)
            self.assertGreater(abs(x[lost] - x[0]), 1, scene)  # motion goes on without them
            self.assertEqual(np.ptp(x[lost + 200 :]), 0, scene)
            self.assertEqual(self.of("interlock.function-enable-0", scene)[lost:].max(), 0, scene)
            self.assertEqual([self.of("chop." + pin, scene)[-1] for pin in ("offset", "active")], [0, 0], scene)
            speed = np.diff(z)
            turned = z[1:-1][speed[1:] * speed[:-1] < 0]
            self.assertLess(np.min(abs(turned[:, None] - [UPPER, LOWER, R]), axis=1).max(), 0.1, scene)  # no stop in the work

    def test_after_a_loss_nothing_goes_on_by_itself(self):
        for scene in ("task_returns", "io_returns"):
            self.assertEqual(self.facts[scene][:3], [1, 0, 0], scene)
            self.assertGreater(self.facts[scene][3], 0, scene)  # the move is there still
            self.assertEqual(self.of("chop.active", scene).max(), 0, scene)
        self.assertRegex("\n".join(self.errors), r"io \(service 5\) does not answer")
        self.assertRegex("\n".join(self.errors), "a service was lost, and answers again")

    def test_dead_programs_are_lost(self):
        self.assertEqual(self.facts["lost"], [1, 1, 1])

    def test_without_linuxcnc_link_the_stroke_goes_on(self):
        for pin, value in (("chop.active", 1), ("interlock.function-enable-0", 1), ("interlock.feed-service-lost", 0)):
            self.assertEqual(set(self.of(pin, "link_dead")), {value}, pin)

    def test_no_service_is_lost_while_all_live(self):
        end = self.rows["task_stopped"][0]
        self.assertEqual(self.shift["interlock.feed-service-lost"][:end].max(), 0)


class ExtraJoint(Recorded):
    """The stroke on a joint of its own, for which LinuxCNC has neither soft limits nor following error."""

    @classmethod
    def setUpClass(cls):
        cls.work("extra.ini", "grinder_extra_scenario.py")

    def test_table_strokes_while_the_path_goes_on(self):
        rows = self.rows["cross_feed"]
        z = self.shift["joint.3.motor-pos-cmd"][rows]
        self.assertAlmostEqual(z.min(), -200, delta=0.3)  # a T^2 / 24 inside
        self.assertGreaterEqual(z.min(), -200)
        self.assertLessEqual(z.max(), 200)
        self.assertGreater(z.max(), 199.7)
        self.assertAlmostEqual(z[-1], 0, delta=nm)
        self.assertEqual(self.of("chop.active", "cross_feed")[-1], 0)

    def test_a_stroke_beyond_a_soft_limit_is_refused(self):
        self.assertEqual(self.of("chop.active", "beyond_a_limit").max(), 0)
        self.assertIn("Z270.000000 is outside of the soft limits", self.facts["message"])
        self.assertIn("R10.000000 has no meaning on an extra joint", self.facts["with_r"])

    def test_strokes_end_with_their_program_and_moves_wait_for_r(self):
        ends = self.rows["program_ends"][np.flatnonzero(self.of("chop.stroking", "program_ends") == 1)[-1] + 2]
        pins = ("chop.active", "chop.run", "motion.feed-inhibit", "motion.feed-hold")
        self.assertEqual([self.shift[pin][ends] for pin in pins], [1, 1, 1, 1])
        self.assertEqual(self.facts["after_its_move"], [1, 0])
        y, active = self.of("joint.1.pos-cmd", "program_ends"), self.of("chop.active", "program_ends") == 1
        last = np.flatnonzero(active)[-1]
        self.assertAlmostEqual(y[last], 5, delta=nm)

    def test_words_are_positions_of_the_joint(self):
        z, active = self.of("joint.3.motor-pos-cmd", "by_words"), self.of("chop.active", "by_words") == 1
        self.assertAlmostEqual(z.min(), -40, delta=0.2)
        self.assertAlmostEqual(z.max(), 60, delta=0.2)
        self.assertEqual(self.facts["z"], 10)
        speed = np.diff(z)[active[1:]] / PERIOD
        inside = abs(z[1:][active[1:]]) < 17
        count = self.of("chop.stroke-count", "by_words")[1:][active[1:]]
        whole = inside & (count > 1) & (count < 4)
        self.assertLess(speed[whole].max(), 51)  # upward
        self.assertLess(speed[whole].min(), -90)

    def test_settings_that_change_amid_a_stroke_take_the_joint_nowhere_else(self):
        z = self.of("chop.command", "changed_settings")
        self.assertLessEqual(abs(z).max(), 200)
        self.assertLess(abs(np.diff(z, 2)).max() / PERIOD**2, 1.01 * self.facts["hardest"])

    def test_all_codes_work_while_the_feed_is_inhibited(self):
        self.assertEqual(self.facts["inhibited"], [40, 1])
        self.assertEqual(self.facts["inhibited_end"], [0, 1, 1])

    def test_a_homed_that_is_lost_for_8_ms_brakes_the_stroke(self):
        place, active = self.facts["lost_homed"]
        self.assertEqual(active, 0)
        z = self.of("joint.3.motor-pos-cmd", "lost_homed")
        self.assertLess(abs(place), 200)
        self.assertGreater(np.count_nonzero(abs(z - place) < nm), 400)
        self.assertLess(abs(np.diff(z)).max() / PERIOD, 401)
        self.assertLess(abs(np.diff(z, 2)).max() / PERIOD**2, 1.01 * self.facts["hardest"])
        self.assertLessEqual(abs(z).max(), 200)
        self.assertIn("lost homed while the axis stroked", self.facts["homed_told"])
        self.assertAlmostEqual(z[-1], 0, delta=nm)

    def test_learned_corrections_outlive_a_restart(self):
        self.assertRegex(self.facts["kept"], r"upper = 40\..*upper-offset = -?0\.[0-9]+")
        self.assertIn("was refused", self.facts["before"])
        self.assertIn("enable is false", self.facts["before"])
        self.assertEqual(self.facts["restored"], 1)

    def test_emergency_stop_freezes_and_turning_on_moves_nothing(self):
        z = self.of("chop.command", "on_again")
        self.assertLess(abs(z[0]), 200)
        self.assertLess(np.ptp(z), STILL)

    def test_g80_1_after_off_and_on_returns_the_axis(self):
        self.assertEqual(self.facts["back_at_r"], [0, 1])

    def test_an_axis_that_does_not_follow_stops_the_stroke(self):
        self.assertEqual(self.facts["lag"], 10)
        self.assertIn("max following error", self.facts["lags"])
        self.assertLessEqual(abs(self.of("chop.command", "lag")).max(), 200)


class ExtraJointOff(Recorded):
    """An extra joint that stops amid a stroke, is pushed by hand, or loses its encoder while the machine is off."""

    @classmethod
    def setUpClass(cls):
        cls.work("extra.ini", "grinder_place_scenario.py")

    def moved_at_on(self, scene):
        """Mm, of the table in 0.4 s after the machine was turned on."""
        on = np.flatnonzero(np.diff(self.of("motion.motion-enabled", scene)) > 0)[0]
        return np.ptp(self.of("table.truth-position", scene)[on : on + 400])

    def test_turning_on_moves_nothing_where_it_stopped_amid_a_stroke(self):
        self.assertGreater(self.of("table.truth-position", "on_after_stop")[0], 50)
        self.assertLess(self.moved_at_on("on_after_stop"), um)
        self.assertEqual(self.facts["back"], [0, 1])

    def test_turning_on_moves_nothing_where_it_was_pushed(self):
        pushed = self.of("table.truth-position", "on_after_push")
        self.assertGreater(pushed[0], 100)
        self.assertLess(self.moved_at_on("on_after_push"), um)
        self.assertAlmostEqual(pushed[-1], 0, delta=0.02)  # G80.1

    def test_an_encoder_without_supply_moves_nothing_until_the_joint_is_homed_again(self):
        self.assertGreater(self.of("table.truth-position", "on_without_supply")[0], 50)
        self.assertLess(self.moved_at_on("on_without_supply"), um)
        self.assertLess(np.ptp(self.of("table.truth-position", "on_with_supply")), um)
        self.assertIn("The place of the axis is unknown", self.facts["told"])
        self.assertEqual(self.facts["on_without_supply"], [26, 53])
        self.assertIn("was refused", self.facts["refused"])
        self.assertEqual(self.facts["strokes"], [1, 0])


class Wheel(Recorded):
    """The wheel leaves the work at an abort, and where its spindle stops."""

    LATEST = {0: 2.4, 2: 1.0}  # s, until it is above the upper dead point for good; a cycle lasts 1.57 s

    @classmethod
    def setUpClass(cls):
        cls.work("grinder.ini", "grinder_wheel_scenario.py")

    def test_abort_leaves_the_work_by_the_clear_dead_point_at_once(self):
        taken = {0: [], 2: []}
        for scene in [scene for scene in self.scenes if scene.startswith("abort_")]:
            kind, _depth, way = scene.removeprefix("abort_").split("_")
            z, on, leaves = (self.of(pin, scene) for pin in ("chop.command", "spindle.0.on", "chop.withdrawing"))
            stops = np.flatnonzero(np.diff(on) < 0)[-1] + 1  # LinuxCNC's abort stops the spindle
            clear = np.flatnonzero(z < UPPER - 0.01)[-1] + 1
            taken[int(kind)].append((clear - stops) * PERIOD)
            self.assertGreaterEqual(z.min(), LOWER - nm, scene)
            self.assertEqual(z[-1], R, scene)
            if kind == "2":
                begins = np.flatnonzero(np.diff(leaves) > 0)[-1] + 1
                self.assertLessEqual(begins - stops, 1, scene)
                if way == "down":  # it turns before the lower dead point, or at it
                    self.assertLess(np.count_nonzero(np.diff(z[stops:clear]) < 0) * PERIOD, 0.4, scene)
        for kind, latest in self.LATEST.items():
            self.assertLess(max(taken[kind]), latest, taken[kind])

    def test_a_wheel_that_trips_is_told_and_the_path_holds(self):
        self.assertRegex(self.facts["tripped"], "spindle stopped, or lost its speed")
        self.assertEqual(self.facts["spindle_on"], 1)
        self.assertEqual(self.facts["path_holds"], [1, 0])
        z, at_speed, leaves = (self.of(pin, "tripped") for pin in ("chop.command", "chop.spindle-at-speed", "chop.withdrawing"))
        lost = np.flatnonzero(np.diff(at_speed) < 0)[-1] + 1
        self.assertAlmostEqual((np.flatnonzero(leaves[lost:])[0]) * PERIOD, 0.2, delta=0.003)  # at-speed-time
        self.assertEqual(z[np.flatnonzero(leaves)[-1] + 1], R)

    def test_a_start_with_a_wheel_that_stands_is_refused(self):
        self.assertRegex(self.facts["stands"], "the spindle does not turn at its speed")
        self.assertEqual(self.of("chop.active", "stands").max(), 0)

    def test_a_spindle_that_is_switched_off_ends_the_strokes_in_its_period(self):
        on, leaves = self.of("spindle.0.on", "switched_off"), self.of("chop.withdrawing", "switched_off")
        self.assertLessEqual(np.flatnonzero(leaves)[0] - (np.flatnonzero(np.diff(on) < 0)[0] + 1), 1)

    def test_strokes_without_a_wheel_need_no_spindle(self):
        self.assertEqual(self.of("spindle.0.on", "without_wheel").max(), 0)
        self.assertGreater(np.ptp(self.of("chop.command", "without_wheel")), 30)


class Inch(Recorded):
    """A machine in inches: its simulated axis is in millimetres."""

    @classmethod
    def setUpClass(cls):
        cls.work("inch.ini", "grinder_inch_scenario.py")

    def test_strokes_of_the_contour_stay_in_their_regions_and_fill_them(self):
        rows = self.rows["contour"]
        rows = rows[(self.shift["chop.active"][rows] == 1) & (self.shift["chop.stroke-count"][rows] >= 1)]
        z, axis = self.shift["chop.command"][rows], self.shift["grinder.truth-position"][rows]
        self.assertAlmostEqual(z.min(), -1, delta=0.001)
        self.assertAlmostEqual(z.max(), 0.6, delta=0.001)
        self.assertEqual(self.of("z-stage.limited", "contour").max(), 0)
        first = np.flatnonzero(z > 0.21)[0]
        inside = (z[1:first] < -0.21) & (z[1:first] > -0.79)
        self.assertLess(abs(np.diff(z[:first]))[inside].max() / PERIOD, 0.51 * 140 / 60)
        there = np.flatnonzero(abs(axis[:first] / 25.4 - 0.2) < 0.0021)
        self.assertGreater(np.sum(there < there[0] + 300), 100)  # the dwell, within the first visit

    def test_words_are_lengths_of_their_program(self):
        for name in ("in_millimetres", "in_inches"):
            np.testing.assert_allclose(self.facts[name], [0.2, -1, 60 / 25.4], rtol=1e-9, err_msg=name)

    def test_refusals_are_in_the_unit_of_the_program(self):
        fast, deep, metric = self.facts["refused"]
        self.assertIn("P481.000000 is above max-feed, which is 480.000000", fast)
        self.assertIn("Q-14.000000 has a dead point outside of the soft limits", deep)
        self.assertIn("P12193.000000 is above max-feed, which is 12192.000000", metric)
        self.assertEqual(np.ptp(self.of("joint.2.pos-cmd", "refusals")), 0)

    def test_learns_the_dead_points(self):
        upper, lower = self.facts["dead_points"]
        self.assertAlmostEqual(upper, 0.2 * 25.4, delta=2.5 * um)  # tolerance is 0.002 mm, in inches
        self.assertAlmostEqual(lower, -25.4, delta=2.5 * um)
        self.assertEqual(self.facts["code"], 0)


del Recorded  # its tests are those of the machines


tearDownModule = starts("grinder/grinder.ini", "grinder/extra.ini", "grinder/inch.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Shift, __doc__)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/portal: squareness in a complete LinuxCNC, on both machines, judged by the servo cycles of a shift.

    python3 tests/support/run.py tests/configs/portal_linuxcnc_test.py --repeat 20 --hogs 2 --speed 10

goes through the shift of the portal twenty times beside two busy loops, and counts failures.
"""

import os
import re
import shutil
import subprocess
import unittest

import linuxcnc_runs
import numpy as np
import plumb
from linuxcnc_runs import BUILD, PERIOD, PROGRAMS, ROOT, STILL, change, nm, own_folder, read_recording, um
from starts import starts

CONFIGURATION = os.path.join(ROOT, "configs", "portal")

AXES = "xyz"
RAMP = 0.1  # mm/s, the defaults of squareness and of each stage
STEEPEST = 1e-3  # the tilts of these machines and the edit of an angle, together
LAG = 1 / 333  # of the drives, seconds
EXACT = 0.01 * um  # of the tip
TOUCH = 0.6 * um  # of the probe, which is looked at once in a cycle
TOOLS = {1: (0, 0, -60), 2: (0, 0, -120), 3: (25, 0, -200), 4: (0, 0, -100), 6: (0, 0, -120)}  # from gauge point to tip


class Shift:
    """One start of LinuxCNC, in which programs/portal_scenario.py works through all scenes."""

    name = None
    leans_of_the_box = {}
    corners = 16
    wrong = []  # messages of its own scenes

    @classmethod
    def prepare(cls, machine):
        """The differences of this machine's copy of the configuration."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("portal", folder)
        for program in ("portal_tools.ngc", "portal_forgotten.ngc"):
            shutil.copy(os.path.join(PROGRAMS, program), machine)
        cls.prepare(machine)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, cls.name + ".ini"))
        table = os.path.join(machine, "errors.csv")
        with open(table, "w") as file:
            file.write("X,EYX\n-260,0\n260,0\n# end, 2 rows\n")
        its, cls.output = linuxcnc_runs.work(folder, ini, "portal_scenario.py", options=["--option", "squareness.table=" + table])
        cls.facts, cls.errors, cls.scenes = its["facts"], its["errors"], its["scenes"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, cls.scenes)
        cls.position = np.array([cls.shift["joint.%d.pos-cmd" % joint] for joint in range(3)])
        cls.rail = cls.shift.get("joint.3.pos-cmd", np.zeros(len(cls.shift["time"])))
        cls.offset = cls.of_each("%s-stage.applied-offset")
        cls.command = cls.of_each("%s-stage.drive-command")
        cls.tip_error = cls.of_each("portal.truth-%s-error")

    @classmethod
    def of_each(cls, pin):
        """A pin of X, Y and Z, in three rows."""
        return np.array([cls.shift[pin % letter] for letter in AXES])

    def moved(self):
        """How far all axes together have been commanded in each cycle."""
        return abs(np.diff(np.vstack([self.position, self.rail]), axis=1, prepend=0)).sum(axis=0)

    def allowed_by_motion(self):
        """How much an offset may change in each cycle as the axes move; homing sets positions, and moves nothing."""
        moved = self.moved()
        return np.where(moved < 3, STEEPEST * moved, 0) + 1e-9

    def steps(self):
        return np.diff(self.offset, axis=1, prepend=0)

    def turned_by(self, ways, level):
        """The parts of the ways of X, Y, Z and W that each tilt turns: pairs of the axis that leans and a way in space.

        Where level is true, the axes that the one that leans carries stay level, those parallel to it excepted.
        """
        raise NotImplementedError

    def beyond_motion(self):
        """The change of the offsets in each cycle beyond that by the axes' ways and the tilts in force."""
        ways = np.diff(np.vstack([self.position, self.rail]), axis=1, prepend=0)
        ways[:, self.moved() > 3] = 0  # homing sets positions
        nothing = np.zeros(len(self.rail))
        enabled = self.shift["square.enabled"]  # as square reads it
        active = (enabled == 1) & (self.shift["motion.is-all-homed"] == 1)
        level = self.shift["square.axis-direction"] == 1
        beyond = []
        for before in (0, 1):  # where a setting changes amid a move, by the one behind or the one before
            rest = self.steps()
            for letter, way in self.turned_by(ways, np.roll(level, before)):
                tilt = [self.shift.get("square.e%s0%s-in-use" % (r, letter), nothing) * active for r in "abc"]
                rest += np.cross(np.roll(tilt, before, axis=1), way, axis=0)
            beyond.append(rest)
        lengths = [np.linalg.norm(rest, axis=0) for rest in beyond]
        return np.where(lengths[0] < lengths[1], *beyond)

    def first_order_error(self, row):
        """The error by the tilts of this machine at a place, computed in another way than the code under test."""
        raise NotImplementedError

    def rests(self, scene, cycles=30):
        """The last row of each time in which nothing moves and nothing is on its way, with the tool in force."""
        rows = self.rows[scene]
        length = -np.array([TOOLS.get(int(tool), (0, 0, 0))[2] for tool in self.shift["iocontrol.0.tool-number"][rows]])
        right = (self.moved()[rows] == 0) & (self.shift["motion.tooloffset.z"][rows] == length) & (length > 0)
        right &= self.shift["square.ramping"][rows] == 0
        edges = np.flatnonzero(np.diff(np.concatenate(([0], right.astype(int), [0]))))
        return [rows[end - 1] for begin, end in zip(edges[::2], edges[1::2]) if end - begin > cycles]

    def moves(self, scene):
        """First row and row behind the last of each move of the path."""
        rows = self.rows[scene]
        rows = rows[self.shift["motion.digital-out-01"][rows] == 1]
        moving = self.moved()[rows] > 0
        edges = np.flatnonzero(np.diff(np.concatenate(([0], moving.astype(int), [0]))))
        return [(rows[begin], rows[end]) for begin, end in zip(edges[::2], edges[1::2])]

    def test_every_servo_cycle_is_recorded(self):
        np.testing.assert_allclose(np.diff(self.shift["time"]), PERIOD, rtol=0, atol=1e-9)
        self.assertGreater(len(self.shift["time"]), 50000)

    def test_correction_makes_no_step_beyond_its_ramp_and_what_motion_causes(self):
        steps = np.linalg.norm(self.beyond_motion(), axis=0)
        judged = np.ones(len(steps), bool)
        for scene in ("on_again", "unhome", "home_again", "home_too_early", "home_once_more", "contour_stopped", "circles"):
            judged[self.rows.get(scene, [])] = False  # where each stage has a ramp of its own
        judged &= (self.of_each("%s-stage.limited").sum(axis=0) == 0) & (np.arange(len(steps)) > 0)
        judged[self.rows["soft_limit"]] = False
        self.assertLessEqual(steps[judged].max(), RAMP * PERIOD + 0.1 * nm)
        for scene in ("choose_a_tool", "disable", "enable", "edit_an_angle", "reload_a_table"):
            self.assertAlmostEqual(steps[self.rows[scene]].max(), RAMP * PERIOD, delta=0.1 * RAMP * PERIOD, msg=scene)

    def test_changes_come_while_it_moves(self):
        moving = self.moved() > 0
        ramping = self.shift["square.ramping"] == 1
        self.assertGreater(np.count_nonzero((moving & ramping)[self.rows["change_amid_a_move"]]), 100)
        stopped = np.ptp(self.position[0, self.rows["emergency_stop"]])
        self.assertTrue(10 < stopped < 240, stopped)

    def test_no_cut_begins_before_the_correction_of_its_tool_is_in_force(self):
        rows = self.rows["change_the_tool"]
        ramping = self.shift["square.ramping"] == 1
        self.assertGreater(np.count_nonzero(ramping[rows]), 1000)
        begun = ramping & np.roll(ramping, 3)  # LinuxCNC changes the offset up to 3 cycles before the last move has ended
        self.assertEqual(np.count_nonzero((begun & (self.moved() > 0))[rows]), 0)

    def test_stages_make_no_step_beyond_two_ramps_where_they_are_released_and_come_back(self):
        for scene in ("on_again", "contour_stopped", "unhome", "home_again", "home_too_early", "home_once_more"):
            rows = self.rows.get(scene, [])
            if not len(rows):
                continue
            steps = abs(self.beyond_motion()[:, rows])
            axis, row = np.unravel_index(steps.argmax(), steps.shape)
            seen = {pin: values[rows[row] - 2:rows[row] + 3] for pin, values in self.shift.items()}
            self.assertLessEqual(steps.max(), 2 * RAMP * PERIOD + 0.1 * nm, "%s, %s: %s" % (scene, AXES[axis], seen))

    def test_what_moves_no_axis_moves_no_drive(self):
        for scene in ("turn_on", "change_modes", "off_and_on", "change_while_off"):
            self.assertLess(np.ptp(self.command[:, self.rows[scene]], axis=1).max(), STILL, scene)

    def test_enable_and_disable_take_the_time_of_the_ramp(self):
        for scene in ("disable", "enable"):
            ramping = np.count_nonzero(self.shift["square.ramping"][self.rows[scene]])
            length = np.linalg.norm(self.offset[:, self.rows["enable"][-1]])
            self.assertAlmostEqual(ramping * PERIOD, length / RAMP, delta=2 * PERIOD, msg=scene)

    def test_stages_apply_what_squareness_asks_for(self):
        released = ("change_while_off", "unhome", "home_too_early")
        last = [self.rows[scene][-1] for scene in self.scenes if scene not in released]
        wanted = self.of_each("square.%s-correction")
        np.testing.assert_allclose(self.offset[:, last], wanted[:, last], rtol=0, atol=1e-12)

    def test_tip_is_right_after_every_change_and_wrong_without_correction(self):
        homed_where_the_machine_is_measured = self.scenes[: self.scenes.index("unhome")]
        for scene in homed_where_the_machine_is_measured:
            error = np.linalg.norm(self.tip_error[:, self.rows[scene][-1]])
            if scene in ("disable", "uncorrected_path", "suspend", "uncorrected_cube", "uncorrected_box", "circles_without"):
                self.assertGreater(error, 10 * um, scene)
            else:
                self.assertLess(error, EXACT, scene)

    def test_tip_is_right_while_it_moves(self):
        for begin, end in self.moves("corrected_path"):
            self.assertLess(abs(self.tip_error[:, begin:end]).max(), EXACT)
        errors = [abs(self.tip_error[:, begin:end]).max() for begin, end in self.moves("uncorrected_path")]
        self.assertGreater(max(errors), 10 * um)

    def test_corners_of_the_cube_are_off_by_the_tilts_and_right_with_correction(self):
        without, corrected = self.rests("uncorrected_cube"), self.rests("corrected_cube")
        for rows in (without, corrected):
            self.assertGreaterEqual(len(rows), self.corners)
            self.assertLessEqual({1, 3}, set(self.shift["iocontrol.0.tool-number"][rows]))
        for row in without:
            np.testing.assert_allclose(self.tip_error[:, row], self.first_order_error(row), rtol=0, atol=EXACT)
        self.assertGreater(np.linalg.norm(self.tip_error[:, without], axis=0).max(), 20 * um)
        self.assertLess(abs(self.tip_error[:, corrected]).max(), EXACT)

    def test_following_error_grows_by_the_speed_of_the_correction_times_the_lag_at_most(self):
        without, corrected = self.moves("uncorrected_path"), self.moves("corrected_path")
        self.assertEqual((len(without), len(corrected)), (4, 4))
        grown = 0
        for (before, _), (begin, end) in zip(without, corrected):
            cycles = np.arange(end - begin + 50)
            there = self.position[:, begin + cycles]
            np.testing.assert_allclose(there, self.position[:, before + cycles], rtol=0, atol=10 * nm)
            for joint in range(3):
                errors = abs(self.shift["joint.%d.f-error" % joint])
                speed = abs(np.diff(self.offset[joint, begin - 1 + np.arange(len(cycles) + 1)])) / PERIOD
                allowed = np.maximum.accumulate(speed) * LAG + nm
                growth = errors[begin + cycles] - errors[before + cycles]
                self.assertLessEqual((growth - allowed).max(), 0, (begin, joint))
                grown = max(grown, growth.max())
        self.assertGreater(grown, 20 * nm)

    def test_integral_of_the_corrected_velocity_is_the_change_of_position(self):
        for begin, end in self.moves("corrected_path"):
            for letter in AXES:
                velocity = self.shift["square.%s-corrected-velocity" % letter][begin - 1 : end + 1]
                position = self.shift["square.%s-corrected-position" % letter][begin - 1 : end + 1]
                travelled = (velocity[1:] + velocity[:-1]).sum() / 2 * PERIOD
                self.assertAlmostEqual(travelled, position[-1] - position[0], delta=0.01 * nm)
        self.assertGreater(np.ptp(self.offset[:, self.rows["corrected_path"]], axis=1).max(), 20 * um)

    def test_table_read_again_is_in_force(self):
        crooked, straight = self.facts["reloaded"]
        self.assertAlmostEqual(crooked - straight, -15 * um, delta=EXACT)

    def test_tables_that_are_read_name_their_machine(self):
        self.assertRegex(self.output, "squareness: /.*/errors.csv: error tables of X, 2 rows, no machine, ")
        self.assertRegex(self.output, "squareness: /.*/errors.csv: error tables of X, 2 rows, machine a lathe, ")

    def test_drive_stops_at_the_soft_limit_and_steps_nowhere(self):
        rows = self.rows["soft_limit"]
        self.assertTrue(self.facts["limited"])
        self.assertAlmostEqual(abs(self.position[0, rows]).max(), 250, delta=nm)
        self.assertAlmostEqual(abs(self.command[0, rows]).max(), 250, delta=nm)
        steps = abs(np.diff(self.command[0, rows])) - abs(np.diff(self.position[0, rows]))
        self.assertLessEqual((steps - self.allowed_by_motion()[rows[1:]]).max(), RAMP * PERIOD)
        self.assertFalse(self.of_each("%s-stage.limited")[:, rows[-1]].any())

    def test_off_with_a_change_under_way_holds_the_drives_and_brings_it_by_the_ramp(self):
        self.assertGreater(np.linalg.norm(self.offset[:, self.rows["change_while_off"][-1]]), 10 * um)
        released = np.linalg.norm(self.offset[:, self.rows["on_again"]], axis=0)
        self.assertLess(released.min(), STILL)
        self.assertGreater(released[-1], 10 * um)
        self.assertTrue(self.facts["waited for the stages"])

    def test_unhomed_the_stages_release_their_offset(self):
        unhomed = self.rows["unhome"][-1]
        self.assertFalse(self.shift["motion.is-all-homed"][unhomed])
        self.assertLess(abs(self.offset[:, unhomed]).max(), STILL)
        self.assertGreater(np.linalg.norm(self.offset[:, self.rows["home_again"][-1]]), 10 * um)

    def test_homed_with_an_offset_in_force_is_a_fault_until_homed_again(self):
        self.assertEqual(self.facts["homed too early"], [False, True])
        self.assertEqual(self.facts["too early"], [6, 6, 6])
        self.assertLess(abs(self.offset[:, self.rows["home_too_early"][-1]]).max(), STILL)
        codes = self.of_each("%s-stage.fault-code")
        self.assertEqual(codes[:, self.rows["home_once_more"][-1]].max(), 0)
        self.assertGreater(np.linalg.norm(self.offset[:, self.rows["home_once_more"][-1]]), 10 * um)
        self.assertEqual(codes[:, : self.rows["home_too_early"][0]].max(), 0)
        forgotten = self.rows.get("contour_forgotten", [])
        self.assertEqual(np.delete(self.shift["square.fault-code"], forgotten).max(), 0)

    def test_square_box_is_probed_as_leaning_without_correction_and_as_square_with_it(self):
        for side, lean in self.leans_of_the_box.items():
            printed = re.findall(r"^ along %s the side is at .([-\d.]+) and .([-\d.]+)$" % side, self.output, re.M)
            self.assertEqual(len(printed), 2, side)
            without, corrected = np.array(printed, float)
            self.assertAlmostEqual(without[1] - without[0], lean, delta=TOUCH, msg=side)
            np.testing.assert_allclose(abs(corrected), 63, rtol=0, atol=TOUCH)

    def test_operator_gets_messages_about_what_was_wrong_and_no_other(self):
        sentence = plumb.declarations("joint_offset")["codes"]["fault-code"][6]
        sentences = ["%s-stage: %s" % (letter, sentence) for letter in "xyz"]
        told = [re.sub(r"compensation radius \([^)]*\)", "compensation-radius", text) for text in self.errors]
        self.assertEqual(sorted(told), sorted([*self.wrong, *sentences, "Homing denied by motion.homing-inhibit joint=-1"]))


def rotation(axis, angle):
    """About X, Y or Z, by the right hand."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    turned = np.eye(3)
    turned[[one, other], [one, other]] = np.cos(angle)
    turned[one, other], turned[other, one] = -np.sin(angle), np.sin(angle)
    return turned


class Portal(Shift, unittest.TestCase):
    name = "portal"
    leans_of_the_box = {"Y": 0, "Z": -0.000089 * 90}  # rail and ram towards Y, over the way between two touches
    corners = 8

    @classmethod
    def prepare(cls, machine):
        """Two corners at each height: nothing of its errors changes along X, and the column goes to all eight."""
        program = os.path.join(machine, "corners.ngc")
        change(program, "    G1 X#<half>\n    o<corner> call\n    G1 Y#<half>\n", "    G1 X#<half> Y#<half>\n")
        change(program, "    G1 X[-#<half>]\n    o<corner> call\n", "")

    def test_rail_corrects_its_own_travel_if_it_is_to(self):
        stays, corrects, stays_again = np.array(self.facts["rail"])
        for z, own, applied, nominal, place in (stays, stays_again):
            self.assertEqual((own, applied), (0, 0))
            self.assertAlmostEqual(place, nominal, delta=STILL)
        z, own, applied, nominal, place = corrects
        self.assertAlmostEqual(own, 20 - 20 / 0.9995, delta=nm)
        self.assertLess(own, -10 * um)
        self.assertAlmostEqual(applied, own, delta=STILL)
        self.assertAlmostEqual(place - nominal, own, delta=STILL)
        self.assertAlmostEqual(stays[0] - z, own, delta=10 * nm)
        self.assertAlmostEqual(stays_again[0], stays[0], delta=nm)

    def turned_by(self, ways, level):
        _, y, z, w = ways
        return (
            ("w", np.array([0 * y, np.where(level, 0, y), w + z])),
            ("y", np.array([0 * y, y, np.where(level, 0, z)])),
            ("z", np.array([0 * y, 0 * y, z])),
        )

    def first_order_error(self, row):
        tool = np.array(TOOLS[int(self.shift["iocontrol.0.tool-number"][row])])
        _, y, z = self.position[:, row]
        behind_z = np.array((0, 0, z)) + tool
        behind_w = np.array((0, y, self.rail[row])) + behind_z
        return np.cross((0.000041, -0.000087, 0), behind_w) + np.cross((-0.00013, 0.000061, 0), behind_z)


EA0Y, EC0Y, RADIUS = 0.00012, -0.00016, 25  # of the column; of tool 6, mm
LAGGING = 15  # cycles, of the drives behind the arc that leads into a circle
CIRCLES = {35: 1, 65: -1}  # radii of the tool's axis in bored.ngc and turned.ngc: whether the tip is outwards of it


class Column(Shift, unittest.TestCase):
    name = "column"
    leans_of_the_box = {"Y": -0.00016 * 100, "Z": 0}

    @classmethod
    def prepare(cls, machine):
        cls.wrong = ["Squareness: " + plumb.declarations("squareness")["codes"]["fault-code"][12]]
        cls.wrong += ["contour_tip: the first number must be 40, 41 or 42", "contour_tip: the tool has no diameter"]

    def contour_error(self, scene, axis_radius):
        """Error of the tip outwards, along the path and in depth, around a circle: by the place of the tool's axis.

        sim_portal has the tip in the axis; the turned radius comes here, with the rotation of ISO 230-1.
        """
        rows = self.rows[scene]
        centred = np.hypot(*self.position[:2, rows]) - axis_radius
        rows = rows[(abs(centred) < 1e-4) & (abs(self.shift["square.compensation-radius"][rows]) == RADIUS)][LAGGING:]
        place = np.array([self.shift["portal.%s-position" % letter][rows] for letter in "xy"])
        out = np.vstack([place / np.hypot(*place), 0 * rows])
        along = np.cross((0, 0, 1), out, axis=0)
        turned = rotation(2, EC0Y) @ rotation(0, EA0Y)
        error = self.tip_error[:, rows] + (turned - np.eye(3)) @ (CIRCLES[axis_radius] * RADIUS * out)
        return np.array([(error * out).sum(axis=0), (error * along).sum(axis=0), error[2]])

    def test_bore_and_boss_are_off_by_the_turned_radius_and_right_with_it(self):
        for axis_radius, outwards in CIRCLES.items():
            out, along, depth = self.contour_error("contour_without", axis_radius)
            self.assertGreater(len(depth), 4000)
            self.assertLess(abs(out).max(), EXACT)
            np.testing.assert_allclose(along, outwards * EC0Y * RADIUS, rtol=0, atol=EXACT)
            self.assertAlmostEqual(depth.max(), EA0Y * RADIUS, delta=EXACT)
            self.assertAlmostEqual(depth.min(), -EA0Y * RADIUS, delta=EXACT)
            corrected = abs(self.contour_error("contour", axis_radius))
            self.assertGreater(corrected.shape[1], 4000)
            self.assertLess(corrected.max(), EXACT)
            print("axis on %s mm: along the path %.2f um, depth +-%.2f um; with the radius %.3f um" % (
                axis_radius, abs(along).max() / um, depth.max() / um, corrected.max() / um))

    def test_radius_comes_and_goes_with_its_moves(self):
        rows = self.rows["contour"]
        radius = self.shift["square.compensation-radius"][rows]
        changes = rows[1:][np.diff(radius) != 0]
        places = [(0, 0), (30, 5), (-110, 50), (-70, -5)]  # where G41 and G40, then G42 and G40, begin to act
        self.assertEqual(len(changes), len(places))
        for row, place in zip(changes, places):
            np.testing.assert_allclose(self.position[:2, row], place, rtol=0, atol=0.05)
        self.assertEqual(self.shift["square.fault-code"][rows].max(), 0)
        self.assertEqual(self.shift["square.unsettled-code"][rows].max(), 0)
        self.assertEqual(set(radius), {RADIUS, 0, -RADIUS})
        self.assertEqual({-1, 0, 1} & set(self.shift["square.compensation-side"][rows]), {-1, 0, 1})

    def test_abort_and_emergency_stop_in_a_contour_end_the_radius_and_move_nothing(self):
        self.assertEqual(len(self.facts["ended"]), 2)
        for radius, x, y in self.facts["ended"]:
            self.assertEqual(radius, 0)
            self.assertAlmostEqual(np.hypot(x, y), 35, delta=0.01)
        np.testing.assert_allclose(self.facts["after the abort"], (0, 0), rtol=0, atol=nm)
        self.assertEqual(self.shift["square.compensation-side"][self.rows["contour_aborted"][-1]], 2, "in MDI")

    def test_radius_is_that_of_the_call_in_each_unit_and_plane(self):
        rows = self.rows["contour_by_hand"]
        rows = rows[self.moved()[rows] > 0]
        radius, plane = (self.shift["square.compensation-" + word][rows] for word in ("radius", "plane"))
        self.assertEqual({(round(r, 6), p) for r, p in zip(radius, plane) if r}, {(-25.4, 17), (12.7, 18)})
        self.assertGreater(np.count_nonzero(radius == 0), 100)

    def test_circles_in_both_directions_keep_the_lost_motion_without_direction_columns_and_lose_it_with_them(self):
        peaks = []
        for scene in ("circles_without", "circles"):
            rows = self.rows[scene]
            rows = rows[(self.shift["motion.digital-out-01"][rows] == 1) & (self.moved()[rows] > 0)]
            self.assertGreater(len(rows), 10000)
            middle = (self.position[:2, rows].max(axis=1) + self.position[:2, rows].min(axis=1)) / 2
            outwards = self.position[:2, rows] - middle[:, None]
            radial = (self.tip_error[:2, rows] * outwards).sum(axis=0) / np.linalg.norm(outwards, axis=0)
            peaks.append(abs(radial).max())
        self.assertGreater(peaks[0], 9 * um)
        self.assertLess(peaks[1], 5.7 * um)  # 4.5 um by the law of the turn, for 125 mm/s2
        without, corrected = (np.array(its) for its in self.facts["both sides"])
        np.testing.assert_allclose(abs(without[0] - without[1]), [20 * um, 10 * um], rtol=0, atol=0.1 * um)
        np.testing.assert_allclose(corrected, 0, rtol=0, atol=0.05 * um)

    def test_side_that_the_program_contradicts_is_said_and_not_corrected(self):
        rows = self.rows["contour_forgotten"]
        contradicted = rows[(self.shift["square.fault-code"][rows] == 12) & (self.shift["square.ramping"][rows] == 0)]
        self.assertGreater(len(contradicted), 500)
        self.assertEqual(set(self.shift["square.compensation-radius"][contradicted]), {RADIUS})
        self.assertLess(abs(self.tip_error[:, contradicted[50:]]).max(), EXACT)

    def turned_by(self, ways, level):
        return (("y", np.array([0 * ways[1], ways[1], 0 * ways[1]])),)

    def first_order_error(self, row):
        tool = np.array(TOOLS[int(self.shift["iocontrol.0.tool-number"][row])])
        return np.cross((0.00012, 0, -0.00016), np.array((0, self.position[1, row], 0)) + tool)

    def test_cube_prints_what_the_readme_shows(self):
        with open(os.path.join(CONFIGURATION, "README.md")) as page:
            shown = re.findall(r"^     (T\d at .*)$", page.read(), re.M)
        self.assertGreater(len(shown), 5)
        for line in shown:
            self.assertIn(" %s\n" % line, self.output)


class Configuration(unittest.TestCase):
    def read(self, name):
        with open(os.path.join(CONFIGURATION, name)) as file:
            return file.read()

    def test_axis_shows_the_same_machines(self):
        for name in ("portal", "column"):
            headless, screen = (re.findall("#INCLUDE .*", self.read(kind + name + ".ini")) for kind in ("", "axis_"))
            self.assertEqual(headless, screen)
            self.assertGreater(len(headless), 8)

    def test_no_joint_is_faster_than_squareness_takes_for_a_motion(self):
        def values(ini, name):
            files = [self.read(file) for file in re.findall("^#INCLUDE (.*)$", self.read(ini), re.M)]
            return [float(value) for value in re.findall(r"^%s *= *(\S+)" % name, "\n".join(files), re.M)]

        self.assertIn("setp square.max-speed [TRAJ]MAX_LINEAR_VELOCITY\n", self.read("functions/squareness/squareness.hal"))
        for ini, joints in (("column.ini", 3), ("portal.ini", 4)):
            speeds = values(ini, "MAX_VELOCITY")
            self.assertEqual(len(speeds), 2 * joints)
            self.assertLessEqual(max(speeds), values(ini, "MAX_LINEAR_VELOCITY")[0])

    def test_settings_are_what_plumb_squareness_makes_of_the_leans_of_the_readme(self):
        commands = re.findall(r"^    plumb (squareness .*)$", self.read("README.md"), re.M)
        self.assertEqual(len(commands), 2)
        for name, command in zip(("column", "portal"), commands):
            self.assertIn("CHAIN = %s\n" % command.split()[2], self.read(name + "_hal.inc"))
            plumb = os.path.join(BUILD, "bin", "plumb")
            printed = subprocess.run([plumb, *command.split()], capture_output=True, text=True, check=True).stdout
            tilts = [
                {pin: float(angle) for pin, angle in re.findall(r"^ *setp \w+\.(e[abc]0\w) +(\S+)", text, re.M)}
                for text in (printed, self.read(name + "_settings.hal"), self.read(name + "_machine.hal"))
            ]
            self.assertEqual(tilts[0], tilts[1])
            self.assertEqual(tilts[1], tilts[2])
            self.assertGreater(len(tilts[0]), 1)

    def test_both_machines_have_the_tab_and_keep_its_settings(self):
        for name in ("axis_portal.ini", "axis_column.ini"):
            self.assertIn("EMBED_TAB_COMMAND = plumb-panel -x {XID}\n", self.read(name))
            self.assertTrue(self.read(name).endswith("HALFILE = common/panel.hal\n"), "behind all files that set pins")
            self.assertEqual(re.findall("SETTINGS = (.*)", self.read(name)), [name[len("axis_"):-len(".ini")] + "_panel.toml"])


tearDownModule = starts("portal/portal.ini", "portal/column.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Portal, __doc__)

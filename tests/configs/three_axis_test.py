#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/three_axis: a complete LinuxCNC in virtual time, ten times faster than the clock.

    python3 tests/support/run.py tests/configs/three_axis_test.py --repeat 20 --hogs 3 --speed 10

goes through the shift of the tests twenty times beside three busy loops, and counts failures.
"""

import math
import os
import re
import shutil
import subprocess
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import PERIOD, PROGRAMS, ROOT, STILL, changes, copy_configuration, finish, nm, own_folder, read_recording, start
from starts import starts

CONFIGURATION = os.path.join(ROOT, "configs", "three_axis")

RAPID = 200  # mm/s
ACCELERATION = 2000  # mm/s2
LAG = 0.003  # of the drives, seconds

# Mounts a /tmp and a /dev/shm of its own, starts a program, and lists the files there before and afterwards.
ALONE = r"""
mount -t tmpfs tmpfs /mnt
for path in "$ROOT" "$BUILD" "$FOLDER"; do
    case $path in /tmp/*) mkdir -p "/mnt/${path#/tmp/}"; mount --rbind "$path" "/mnt/${path#/tmp/}" ;; esac
done
chmod 1777 /mnt
mount --rbind /mnt /tmp
mount -t tmpfs tmpfs /dev/shm
look() { ls -A /tmp /dev/shm; ipcs -m -s -q; ps -A -o comm= | grep -vxE 'sh|ls|ps|grep|sort'; }
look >"$FOLDER/before"
"$@"
status=$?
look >"$FOLDER/after"
exit $status
"""


class Shift(unittest.TestCase):
    """One start of LinuxCNC, in which programs/three_axis_scenario.py works through all scenes."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = copy_configuration("three_axis", folder)
        for name in ("three_axis_path.ngc", "three_axis_line.ngc"):
            shutil.copy(os.path.join(PROGRAMS, name), machine)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "three_axis.ini"))
        its, _ = linuxcnc_runs.work(folder, ini, "three_axis_scenario.py")
        cls.facts, cls.errors = its["facts"], its["errors"]
        cls.scenes = linuxcnc_runs.read_scenes(machine, its["scenes"])

    def test_every_servo_cycle_is_recorded(self):
        self.assertEqual(len(self.scenes), 14)
        for name, scene in self.scenes.items():
            with self.subTest(name):
                time = scene["time"]
                self.assertEqual(len(time), round((time[-1] - time[0]) / PERIOD) + 1)
                np.testing.assert_allclose(np.diff(time), PERIOD, rtol=0, atol=1e-9)

    def test_no_joint_is_commanded_faster_or_harder_than_its_limits(self):
        for name, scene in self.scenes.items():
            if name == "emergency_stop":  # where the commands fall back to where the drives are
                continue
            for joint in range(3):
                with self.subTest(name, joint=joint):
                    velocity = np.diff(scene["joint.%d.motor-pos-cmd" % joint]) / PERIOD
                    self.assertLess(abs(velocity).max(), RAPID * (1 + 1e-6))
                    self.assertLess(abs(np.diff(velocity)).max() / PERIOD, ACCELERATION * (1 + 1e-3))

    def test_homing_moves_nothing_and_begins_with_z(self):
        scene = self.scenes["home"]
        homed = [changes(scene["joint.%d.homed" % joint]) for joint in range(3)]
        self.assertEqual([len(rows) for rows in homed], [1, 1, 1])
        self.assertLess(homed[2], homed[0])
        self.assertLess(homed[2], homed[1])
        for joint in range(3):
            self.assertLess(np.ptp(scene["joint.%d.motor-pos-fb" % joint]), STILL)

    def test_homing_again_loses_home_first(self):
        for joint in range(3):
            homed = self.scenes["home_again"]["joint.%d.homed" % joint]
            self.assertEqual([homed[row] for row in (0, *changes(homed))], [1, 0, 1])

    def test_long_rapid_takes_the_time_of_a_trapezoid(self):
        x = self.scenes["rapid"]["joint.0.motor-pos-cmd"]
        self.assertAlmostEqual(x[-1], 100, delta=nm)
        cycles = (100 / RAPID + RAPID / ACCELERATION) / PERIOD
        self.assertAlmostEqual(len(changes(x)), cycles, delta=2)

    def test_short_rapid_takes_the_time_of_a_triangle(self):
        y = self.scenes["short_rapid"]["joint.1.motor-pos-cmd"]
        self.assertAlmostEqual(y[-1], 5, delta=nm)
        self.assertAlmostEqual(len(changes(y)), 2 * math.sqrt(5 / ACCELERATION) / PERIOD, delta=2)

    def test_drives_follow_with_their_lag(self):
        scene = self.scenes["rapid"]
        behind = scene["joint.0.motor-pos-cmd"] - scene["joint.0.motor-pos-fb"]
        self.assertAlmostEqual(behind.max(), RAPID * LAG, delta=RAPID * PERIOD)
        self.assertAlmostEqual(behind[-1], 0, delta=nm)

    def test_beyond_a_limit_is_refused_with_the_operators_message(self):
        self.assertIn("exceed X's positive limit", self.facts["refusal"])
        for error in self.errors:  # all of them of this cause, and none has disturbed a later scene
            self.assertRegex(error, "positive limit|invalid params")

    def test_blended_path_stays_within_the_tolerance(self):
        scene = self.scenes["program"]
        cutting = slice(*self.rows_between((0, 20), (50, -20)))
        x, y = scene["axis.x.pos-cmd"][cutting], scene["axis.y.pos-cmd"][cutting]
        self.assertGreater(len(x), 5000)
        lines = (((0, 20), (40, 20)), ((60, 0), (60, -20)), ((60, -20), (50, -20)))
        off_lines = [distance_to_line(x, y, *ends) for ends in lines]
        arc = np.where((x > 40) & (y > 0), abs(np.hypot(x - 40, y) - 20), np.inf)
        deviation = np.minimum.reduce([*off_lines, arc])
        self.assertLess(deviation.max(), 0.01 + nm)
        self.assertGreater(deviation.max(), 10 * nm)  # it does cut the corners

    def test_path_ends_and_exact_stops_are_where_they_are_programmed(self):
        for corner in ((50, -20), (0, -20), (0, 0)):
            with self.subTest(corner=corner):
                self.assertGreater(len(self.rows_at(corner)), 0)
        scene = self.scenes["program"]
        for joint in range(3):
            self.assertAlmostEqual(scene["joint.%d.motor-pos-fb" % joint][-1], 0, delta=nm)

    def test_spindle_is_at_speed_at_the_end_of_its_ramp_and_the_feed_waits_for_it(self):
        scene = self.scenes["program"]
        on = np.flatnonzero(scene["spindle.0.speed-out"] == 3000)[0]
        at_speed = on + np.flatnonzero(scene["spindle.0.at-speed"][on:] == 1)[0]
        self.assertAlmostEqual((at_speed - on) * PERIOD, 3000 / 1.02 / 3000, delta=2 * PERIOD)
        feed = np.flatnonzero(scene["axis.y.pos-cmd"])
        feed = feed[feed > on][0]
        self.assertGreaterEqual(feed, at_speed)
        self.assertLess(feed - at_speed, 5)

    def test_outputs_come_with_their_motion(self):
        scene = self.scenes["program"]
        on, off = changes(scene["motion.digital-out-00"])
        # A line of the program begins where it has blended half with the one before.
        self.assertAlmostEqual(scene["axis.x.pos-cmd"][on], 0, delta=0.1)
        self.assertAlmostEqual(scene["axis.y.pos-cmd"][on], 20, delta=0.1)
        self.assertAlmostEqual(scene["axis.x.pos-cmd"][off], 60, delta=0.1)
        self.assertAlmostEqual(scene["axis.y.pos-cmd"][off], 0, delta=0.1)
        self.assertGreater(scene["motion.current-vel"][on], 0)  # and do not stop it
        self.assertGreater(scene["motion.current-vel"][off], 0)
        stopped, _ = changes(scene["motion.digital-out-01"])
        self.assertEqual(scene["motion.current-vel"][stopped], 0)
        self.assertAlmostEqual(scene["axis.y.pos-cmd"][stopped], -20, delta=nm)

    def test_tool_is_changed(self):
        numbers = self.scenes["program"]["iocontrol.0.tool-number"]
        self.assertEqual([numbers[0], numbers[-1], len(changes(numbers))], [0, 2, 1])

    def test_feed_override_halves_the_feed(self):
        x = self.scenes["override"]["axis.x.pos-cmd"]
        moving = changes(x)
        velocity = np.diff(x)[moving - 1] / PERIOD
        self.assertAlmostEqual(np.median(velocity), 10, delta=1e-6)
        self.assertAlmostEqual(len(moving) * PERIOD, 20 / 10 + 10 / ACCELERATION, delta=2 * PERIOD)

    def test_paused_program_stands_and_goes_on(self):
        x = self.scenes["pause"]["joint.0.motor-pos-cmd"]
        pauses = np.diff(changes(x))
        self.assertEqual(np.count_nonzero(pauses > 10), 1)
        self.assertGreater(pauses.max(), 100)
        stood = x[changes(x)[pauses.argmax()]]
        self.assertAlmostEqual(stood, self.facts["paused_at"], delta=nm)
        self.assertGreater(stood, 30)
        self.assertAlmostEqual(x[-1], 240, delta=nm)

    def test_abort_brakes_at_the_limit_and_stands(self):
        x = self.scenes["abort"]["joint.0.motor-pos-cmd"]
        velocity = np.diff(x) / PERIOD
        last_at_feed = np.flatnonzero(velocity > 50 - 1e-6)[-1]
        self.assertAlmostEqual(x[-1] - x[last_at_feed + 1], 50**2 / 2 / ACCELERATION, delta=2 * 50 * PERIOD)
        self.assertTrue(30 < x[-1] < 240)
        self.assertLess(np.ptp(x[-100:]), STILL)
        after = self.scenes["after_abort"]["joint.0.motor-pos-cmd"]
        self.assertAlmostEqual(after[0], x[-1], delta=STILL)
        self.assertAlmostEqual(after[-1], 60, delta=nm)

    def test_off_and_on_moves_nothing(self):
        scene = self.scenes["off_and_on"]
        enabled = scene["motion.motion-enabled"]
        self.assertEqual([enabled[row] for row in (0, *changes(enabled))], [1, 0, 1])
        for joint in range(3):
            for pin in ("motor-pos-cmd", "motor-pos-fb"):
                self.assertLess(np.ptp(scene["joint.%d.%s" % (joint, pin)]), STILL)

    def test_emergency_stop_stops_the_drives_and_they_stay(self):
        scene = self.scenes["emergency_stop"]
        off, on = changes(scene["motion.motion-enabled"])
        x = scene["joint.0.motor-pos-fb"]
        self.assertAlmostEqual(np.diff(x[:off]).max() / PERIOD, 50, delta=0.1)
        self.assertTrue(30 < x[off] < 239)  # in mid-move
        self.assertLess(np.ptp(x[off:]), 2 * 50 * PERIOD)
        self.assertLess(np.ptp(x[off + 3 :]), STILL)
        self.assertLess(on, len(x) - 100)
        after = self.scenes["after_emergency_stop"]
        self.assertAlmostEqual(after["joint.0.motor-pos-fb"][0], x[-1], delta=STILL)
        self.assertAlmostEqual(after["joint.0.motor-pos-fb"][-1], 20, delta=nm)
        self.assertAlmostEqual(after["joint.1.motor-pos-fb"][-1], 20, delta=nm)

    def test_jog_moves_by_its_increment(self):
        y = self.scenes["jog_increment"]["joint.1.motor-pos-cmd"]
        self.assertAlmostEqual(y[-1] - y[0], 12.5, delta=nm)
        self.assertAlmostEqual(len(changes(y)) * PERIOD, 12.5 / 50 + 50 / ACCELERATION, delta=10 * PERIOD)

    def test_jog_stops_when_it_is_let_go(self):
        y = self.scenes["jog"]["joint.1.motor-pos-cmd"]
        self.assertAlmostEqual(np.diff(y).max() / PERIOD, 50, delta=1e-6)
        self.assertGreater(y[-1], 60)
        self.assertLess(np.ptp(y[-100:]), STILL)

    def rows_at(self, corner):
        scene = self.scenes["program"]
        return np.flatnonzero(
            np.hypot(scene["axis.x.pos-cmd"] - corner[0], scene["axis.y.pos-cmd"] - corner[1]) < nm
        )

    def rows_between(self, first, last):
        scene = self.scenes["program"]
        near = np.hypot(scene["axis.x.pos-cmd"] - first[0], scene["axis.y.pos-cmd"] - first[1])
        return near.argmin(), self.rows_at(last)[0]


def distance_to_line(x, y, begin, end):
    """The distances of points from the straight line from begin to end."""
    length = math.dist(begin, end)
    along = ((x - begin[0]) * (end[0] - begin[0]) + (y - begin[1]) * (end[1] - begin[1])) / length
    along = np.clip(along, 0, length) / length
    return np.hypot(x - begin[0] - along * (end[0] - begin[0]), y - begin[1] - along * (end[1] - begin[1]))


class Sample(unittest.TestCase):
    """The shipped configuration, started as in the README."""

    def setUp(self):
        self.folder = own_folder(self)

    def run_sample(self, *arguments, prefix=()):
        ini = os.path.join(copy_configuration("three_axis", self.folder), "three_axis.ini")
        return finish(start(self.folder, ini, *arguments, prefix=prefix))

    def test_it_runs_its_program_and_leaves_nothing_behind(self):
        user = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
        alone = ["unshare", *user, "--mount", "--ipc", "--pid", "--fork", "--kill-child", "--mount-proc", "sh", "-c"]
        looks = subprocess.run([*alone, "true"], capture_output=True).returncode == 0
        status, output = self.run_sample(prefix=[*alone, ALONE, "alone"] if looks else [])
        self.assertEqual(status, 0, output)
        self.assertIn("sample.ngc is done", output)
        if not looks:
            self.skipTest("files of this system look like leftovers")
        with open(os.path.join(self.folder, "before")) as before, open(os.path.join(self.folder, "after")) as after:
            self.assertEqual(after.read(), before.read())

    def test_it_fails_with_the_operators_message(self):
        program = os.path.join(self.folder, "wrong.ngc")
        with open(program, "w") as file:
            file.write("G1 X10\nM2\n")
        status, output = self.run_sample(program)
        self.assertEqual(status, 1, output)
        self.assertIn("feed rate", output)

    def test_axis_shows_the_same_machine(self):
        included = []
        for name in ("three_axis.ini", "axis.ini"):
            with open(os.path.join(CONFIGURATION, name)) as ini:
                included.append([line for line in ini if line.startswith("#INCLUDE")])
        self.assertEqual(included[0], included[1])
        self.assertGreater(len(included[0]), 8)

    def test_two_run_beside_each_other(self):
        machines = [copy_configuration("three_axis", self.folder, name) for name in ("one", "other")]
        records = [os.path.join(machine, "shift.csv") for machine in machines]
        processes = [
            start(self.folder, os.path.join(machine, "three_axis.ini"), "--record", record)
            for machine, record in zip(machines, records)
        ]
        for status, output in [finish(process) for process in processes]:
            self.assertEqual(status, 0, output)
        one, other = [read_recording(record) for record in records]
        for letter, least, most in (("x", -30, 30), ("y", -20, 20), ("z", -201, 0)):
            for positions in (one["axis.%s.pos-cmd" % letter], other["axis.%s.pos-cmd" % letter]):
                self.assertAlmostEqual(positions.min(), least, delta=nm)
                self.assertAlmostEqual(positions.max(), most, delta=nm)

    def test_no_probing_move_or_wait_is_lost_where_a_period_lasts_long(self):
        """A function holds the thread between the echo of a command and the motion; task looks meanwhile."""
        machine = copy_configuration("three_axis", self.folder)
        with open(os.path.join(machine, "busy.hal"), "w") as file:
            file.write("loadrt busy_function names=busy\nsetp busy.hold 0.0002\naddf busy.update servo-thread 2\n")
        with open(os.path.join(machine, "probe.ngc"), "w") as file:
            file.write("o1 repeat [25]\nG91 G38.3 Z-0.02 F600\nG90 G1 Z0\nM66 P0 L4 Q0.1\n(DEBUG,passed #5399)\no1 endrepeat\nM2\n")
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "three_axis.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = busy.hal"))
        specimens = ["--modules", os.path.join(linuxcnc_runs.BUILD, "specimens")]
        status, output = finish(start(self.folder, ini, os.path.join(machine, "probe.ngc"), options=specimens, at=1))
        self.assertEqual(status, 0, output)
        self.assertEqual(output.count("passed 0.0"), 25, output)

    def test_configuration_of_the_readme_adds_to_the_common_one(self):
        with open(os.path.join(CONFIGURATION, "README.md")) as page:
            text = page.read()
        machine = os.path.join(self.folder, "mill")
        os.mkdir(machine)
        os.symlink(os.path.join(ROOT, "configs", "common"), os.path.join(machine, "common"))
        for name, language in (("mill.ini", "ini"), ("shift.hal", "hal")):
            with open(os.path.join(machine, name), "w") as file:
                file.write(re.search("```%s\n(.*?)```" % language, text, re.S)[1])
        with open(os.path.join(machine, "shift.ngc"), "w") as file:
            file.write("M68 E0 Q0.05\nG0 Z-10\nG4 P0.1\nM2\n")
        record = os.path.join(machine, "shift.csv")
        pins = ["joint.2.motor-pos-cmd", "joint.2.motor-pos-fb", "z-drive.out"]
        options = ["shift.ngc", "--record", record, "--pins", ",".join(pins)]
        status, output = finish(start(self.folder, os.path.join(machine, "mill.ini"), *options))
        self.assertEqual(status, 0, output)
        z = read_recording(record)
        self.assertAlmostEqual(z["joint.2.motor-pos-cmd"][-1], -10, delta=STILL)
        self.assertAlmostEqual(z["joint.2.motor-pos-fb"][-1], -10, delta=nm)
        self.assertAlmostEqual(z["z-drive.out"][-1], -9.95, delta=nm)


tearDownModule = starts("three_axis/three_axis.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Shift, __doc__)

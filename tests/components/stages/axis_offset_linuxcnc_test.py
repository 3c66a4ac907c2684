#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""axis_offset in a complete LinuxCNC, wired as in its manual page, and judged by the servo cycles of a shift.

    python3 tests/support/run.py tests/components/stages/axis_offset_linuxcnc_test.py --repeat 20 --hogs 2 --speed 10

goes through the shift twenty times beside two busy loops, and counts failures.
"""

import os
import re
import shutil
import subprocess
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import BUILD, PERIOD, PROGRAMS, STILL, at_the_end, changes, nm, own_folder, own_ini, read_recording, um

MAX_RATE = 0.1  # mm/s, the default
COUNT = 0.1 * um
EXTERNAL_OFFSETS = ["OFFSET_AV_RATIO = 0.2"]


def wiring_of_the_manual():
    """The lines of the manual page, but for the source of the offset, which here is the scenario."""
    command = ["mandoc", "-T", "ascii", os.path.join(BUILD, "man", "axis_offset.9")]
    page = subprocess.run(command, capture_output=True, text=True, check=True)
    lines = re.findall(r"^\s+((?:net|addf z-stage).*)$", re.sub(".\b", "", page.stdout), re.M)
    return [line for line in lines if "growth." not in line]


class Shift(unittest.TestCase):
    """One start of LinuxCNC, in which programs/axis_offset_scenario.py works through all scenes."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("three_axis", folder)
        shutil.copy(os.path.join(PROGRAMS, "axis_offset_part.ngc"), machine)
        ini = os.path.join(machine, "three_axis.ini")
        with open(os.path.join(machine, "stage.hal"), "w") as file:
            probe = ["loadrt comp names=probe", "addf probe servo-thread", "setp probe.in1 -20"]
            probe += ["net z-motor-fb => probe.in0", "net probe probe.out => motion.probe-input"]
            stage = ["loadrt axis_offset names=z-stage interlock=no", *wiring_of_the_manual()]
            file.write("\n".join([*stage, *probe]) + "\n")
        ini = own_ini(ini, AXIS_Z=EXTERNAL_OFFSETS, HAL=at_the_end("HALFILE = stage.hal"))
        its, _ = linuxcnc_runs.work(folder, ini, "axis_offset_scenario.py")
        cls.facts, cls.errors = its["facts"], its["errors"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, its["scenes"])

    def column(self, scene, name):
        return self.shift[name][self.rows[scene]]

    def z(self, scene):
        """The commands that the motor got."""
        return self.column(scene, "joint.2.motor-pos-cmd")

    def offset(self, scene):
        return self.column(scene, "axis.z.eoffset")

    def standing(self):
        """Servo cycles at whose end the program has not moved Z for as long as the interpolation takes."""
        moves = np.diff(self.shift["axis.z.pos-cmd"], prepend=0) != 0
        return np.convolve(moves, np.ones(10))[: len(moves)] == 0

    def test_every_servo_cycle_is_recorded(self):
        np.testing.assert_allclose(np.diff(self.shift["time"]), PERIOD, rtol=0, atol=1e-9)
        self.assertGreater(len(self.shift["time"]), 20000)

    def test_nothing_moves_but_by_a_program_an_armed_stage_or_clear(self):
        moved = abs(np.diff(self.shift["joint.2.motor-pos-cmd"], prepend=0)) > 1e-3 * nm
        may = np.convolve(self.shift["z-stage.armed"] + self.shift["z-stage.clear"], np.ones(10))[: len(moved)] > 0
        self.assertEqual(np.count_nonzero(moved & self.standing() & ~may), 0)
        self.assertGreater(np.count_nonzero(moved & self.standing()), 1000)

    def test_offset_moves_the_axis_by_max_rate_at_most(self):
        velocity = abs(np.diff(self.shift["joint.2.motor-pos-cmd"], prepend=0)) / PERIOD
        velocity[~self.standing()] = 0
        fast = np.flatnonzero(velocity > MAX_RATE * 1.001)
        # After joint mode LinuxCNC catches up with the requests of the stage meanwhile.
        fast = fast[~np.isin(fast, self.rows["out_of_joint_mode"])]
        self.assertEqual(len(fast), 0)
        caught_up = velocity[self.rows["out_of_joint_mode"]]
        self.assertLess(np.sum(caught_up[caught_up > MAX_RATE * 1.001]) * PERIOD, 3 * um)

    def test_axis_stands_at_program_and_offset(self):
        standing = self.standing() & (self.shift["motion.motion-enabled"] == 1)
        standing[self.rows["out_of_joint_mode"]] = False  # where LinuxCNC catches up
        standing[self.rows["home_again"][0] :] = False  # since then the motor has another origin
        shift = {name: values[standing] for name, values in self.shift.items()}
        where = shift["joint.2.motor-pos-cmd"] - shift["axis.z.pos-cmd"]
        self.assertLess(abs(where - shift["z-stage.applied-offset"]).max(), 1 * um)  # it lags three cycles
        self.assertLess(abs(shift["axis.z.eoffset"] - shift["z-stage.applied-offset"]).max(), 1e-9)

    def test_on_and_homed_nothing_moves_and_the_operator_gets_a_message(self):
        self.assertLess(np.ptp(self.z("turn_on")), STILL)
        self.assertEqual(self.column("turn_on", "z-stage.counts").max(), 0)
        self.assertEqual(self.column("turn_on", "z-stage.uncompensated")[-1], 1)

    def test_cycle_start_brings_the_offset(self):
        z = self.z("start_a_cycle")
        self.assertAlmostEqual(z[-1], 50 * um, delta=COUNT)
        self.assertTrue((np.diff(z) >= 0).all())
        self.assertAlmostEqual(len(changes(z)) * PERIOD, 50 * um / MAX_RATE, delta=0.01)
        self.assertEqual(self.column("start_a_cycle", "z-stage.uncompensated")[-1], 0)

    def test_change_of_mode_moves_nothing(self):
        self.assertLess(np.ptp(self.z("change_modes")), STILL)

    def test_offset_follows_within_a_program(self):
        cutting = abs(self.column("run_a_program", "motion.current-vel") - 10) < nm
        self.assertAlmostEqual(np.count_nonzero(cutting) * PERIOD, 100 / 10, delta=0.2)  # which it does not disturb
        self.assertGreater(np.ptp(self.offset("run_a_program")[cutting]), 10 * COUNT)
        self.assertAlmostEqual(self.offset("run_a_program")[-1], 80 * um, delta=COUNT)

    def test_offset_of_a_paused_program_moves_that_axis_alone(self):
        self.assertAlmostEqual(np.ptp(self.z("paused")), 60 * um, delta=COUNT)
        self.assertLess(np.ptp(self.column("paused", "joint.0.motor-pos-cmd")), STILL)
        self.assertAlmostEqual(self.z("resumed").min(), -10 + 20 * um, delta=COUNT)

    def test_abort_keeps_the_offset(self):
        self.assertLess(np.ptp(self.offset("abort")), STILL)
        self.assertTrue(self.column("abort", "z-stage.armed").all())

    def test_soft_limit_holds_the_axis_and_winds_nothing_up(self):
        self.assertAlmostEqual(self.z("soft_limit").max(), 50, delta=STILL)
        self.assertLess(np.ptp(self.z("at_the_limit")), STILL)
        self.assertEqual(np.ptp(self.column("at_the_limit", "z-stage.counts")), 0)
        self.assertTrue(self.column("at_the_limit", "z-stage.uncompensated")[-1])
        self.assertAlmostEqual(self.z("behind_the_limit")[-1], 40 + 50 * um, delta=COUNT)
        self.assertFalse(self.column("behind_the_limit", "z-stage.limited")[-1])

    def test_touch_off_takes_the_position_without_the_offset(self):
        self.assertAlmostEqual(self.facts["touched_off"], 15 + 50 * um, delta=COUNT)

    def test_probing_with_an_offset_in_force_is_refused(self):
        scene = "refused_probing"
        probing = self.column(scene, "motion.motion-type") == 5
        refused = self.column(scene, "z-stage.probing-refused") == 1
        self.assertLess(np.argmax(refused) - np.argmax(probing), 3)  # servo cycles
        self.assertLess(np.ptp(self.z(scene)), 0.2)
        self.assertFalse(refused[-1])
        self.assertLess(np.ptp(self.offset(scene)), STILL)

    def test_clear_takes_the_offset_back(self):
        self.assertAlmostEqual(self.offset("clear")[-1], 0, delta=nm)
        self.assertFalse(self.column("clear", "z-stage.armed")[-1])
        self.assertTrue(self.column("clear", "z-stage.uncompensated")[-1])

    def test_probing_result_contains_the_offset_that_was_allowed(self):
        scene = "allowed_probing"
        probing = self.column(scene, "motion.motion-type") == 5
        self.assertLess(np.ptp(self.offset(scene)[probing]), COUNT)  # though its source had changed
        self.assertAlmostEqual(self.offset(scene)[probing][-1], 50 * um, delta=COUNT)
        self.assertAlmostEqual(self.facts["probed_with_offset"], self.facts["probed"], delta=0.1 * um)
        self.assertAlmostEqual(self.offset(scene)[-1], 90 * um, delta=COUNT)

    def test_joint_mode_lets_the_offset_wait(self):
        self.assertLess(np.ptp(self.z("in_joint_mode")), STILL)
        self.assertTrue(self.column("in_joint_mode", "z-stage.uncompensated")[-1])
        self.assertAlmostEqual(self.offset("out_of_joint_mode")[-1], 30 * um, delta=COUNT)

    def test_off_and_on_moves_nothing_until_the_next_cycle(self):
        self.assertLess(np.ptp(self.z("off_and_on")), nm)
        self.assertAlmostEqual(self.offset("off_and_on")[-1], 0, delta=STILL)
        self.assertFalse(self.column("off_and_on", "z-stage.armed")[-1])
        self.assertTrue(self.column("off_and_on", "z-stage.uncompensated")[-1])
        self.assertAlmostEqual(self.z("after_off_and_on").min(), 0, delta=nm)  # by G0 Z0
        self.assertAlmostEqual(self.z("after_off_and_on")[-1], 30 * um, delta=COUNT)

    def test_emergency_stop_amid_a_change_moves_nothing_afterwards(self):
        stopped = changes(self.column("emergency_stop", "motion.motion-enabled"))
        moving = self.offset("emergency_stop")[stopped]
        self.assertTrue(30 * um < moving < 79 * um)
        self.assertLess(np.ptp(self.z("after_emergency_stop")), 1 * um)  # falls back to where the drive is
        self.assertLess(np.ptp(self.z("after_emergency_stop")[-1000:]), nm)
        self.assertAlmostEqual(self.offset("after_emergency_stop")[-1], 0, delta=STILL)
        self.assertAlmostEqual(self.z("after_all_that")[-1], 80 * um, delta=COUNT)

    def test_homed_with_an_offset_in_force_it_cannot_be_armed(self):
        self.assertLess(np.ptp(self.z("home_again")), nm)
        self.assertEqual(self.column("home_again", "z-stage.fault-code")[-1], 6)
        self.assertFalse(self.column("home_again", "z-stage.armed")[-1])
        self.assertLess(np.ptp(self.z("homed_right")), nm)
        self.assertEqual(self.column("homed_right", "z-stage.fault-code")[-1], 0)

    def test_homing_disarms(self):
        homed = self.column("unhome", "motion.is-all-homed")
        lost = np.flatnonzero(homed == 0)
        self.assertFalse(self.column("unhome", "z-stage.armed")[lost[0] :].any())
        self.assertLess(np.ptp(self.z("unhome")[lost[0] :]), nm)
        self.assertAlmostEqual(np.ptp(self.z("cycle_after_homing")), 80 * um, delta=COUNT)

    def test_operator_gets_no_other_message(self):
        for error in self.errors:
            self.assertIn("G38.2", error)


class Guest(unittest.TestCase):
    """Another user of the external offsets of Z, through the stage; and at X, with LinuxCNC's external offsets to itself.

    programs/axis_offset_guest_scenario.py works through the scenes.
    """

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("three_axis", folder)
        ini = os.path.join(machine, "three_axis.ini")
        guest = ["newsig guest-scale float", "newsig guest-counts s32", "newsig guest-enable bit", "newsig guest-clear bit"]
        guest += ["net guest-%s z-stage.guest-%s axis.x.eoffset-%s" % ((pin,) * 3) for pin in ("scale", "counts")]
        guest += ["net guest-%s z-stage.guest-%s axis.x.eoffset-%s" % ((pin,) * 3) for pin in ("enable", "clear")]
        with open(os.path.join(machine, "stage.hal"), "w") as file:
            stage = ["loadrt axis_offset names=z-stage interlock=no", *wiring_of_the_manual()]
            file.write("\n".join([*stage, *guest]) + "\n")
        ini = own_ini(ini, AXIS_X=EXTERNAL_OFFSETS, AXIS_Z=EXTERNAL_OFFSETS, HAL=at_the_end("HALFILE = stage.hal"))
        told, _ = linuxcnc_runs.work(folder, ini, "axis_offset_guest_scenario.py")
        cls.errors = told["errors"]
        cls.shift = read_recording(os.path.join(machine, "guest.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, told["scenes"])

    def column(self, scene, name):
        return self.shift[name][self.rows[scene]]

    def assert_ends(self, scene, own, guest, tolerance=COUNT):
        """Own part, guest's part, their sum in force, and the guest as it is alone."""
        self.assertAlmostEqual(self.column(scene, "z-stage.applied-offset")[-1], own, delta=1.01 * COUNT)
        self.assertAlmostEqual(self.column(scene, "z-stage.guest-applied")[-1], guest, delta=tolerance)
        self.assertAlmostEqual(self.column(scene, "axis.z.eoffset")[-1], own + guest, delta=tolerance + COUNT)
        self.assertAlmostEqual(self.column(scene, "axis.x.eoffset")[-1], guest, delta=tolerance)

    def test_both_parts_together_are_in_force_in_every_servo_cycle(self):
        parts = self.shift["z-stage.applied-offset"] + self.shift["z-stage.guest-applied"]
        np.testing.assert_allclose(parts, self.shift["axis.z.eoffset"], rtol=0, atol=1e-3 * nm)

    def test_own_part_moves_by_max_rate_at_most_beside_the_guest(self):
        on = self.shift["motion.motion-enabled"] == 1
        steps = abs(np.diff(self.shift["z-stage.applied-offset"]))[on[1:] & on[:-1]]
        self.assertLess(steps.max(), 2 * um)  # where the parts are told apart anew
        windows = np.convolve(np.diff(self.shift["z-stage.applied-offset"]), np.ones(200), "valid")
        self.assertLess(np.sort(abs(windows))[: -200 * 3].max(), 0.2 * MAX_RATE + 2 * um)  # but when it is turned on

    def test_guest_moves_before_a_cycle_starts_and_nothing_else_does(self):
        self.assertLess(np.ptp(self.column("turn_on", "joint.2.motor-pos-cmd")), STILL)  # its counts changed while off
        self.assert_ends("turn_on", 0, 0)
        self.assert_ends("guest_alone", 0, 1)
        self.assertTrue(self.column("guest_alone", "z-stage.guest-active")[-1])
        self.assertFalse(self.column("guest_alone", "z-stage.armed").any())
        self.assertTrue(self.column("guest_alone", "z-stage.uncompensated").all())

    def test_cycle_start_adds_the_own_part(self):
        self.assert_ends("both", 50 * um, 1)
        self.assertFalse(self.column("both", "z-stage.uncompensated")[-1])

    def test_steps_of_fractions_of_a_count_add_up(self):
        self.assert_ends("fractions", 50 * um, 1 + 700 * 0.000037)

    def test_own_part_changes_beside_a_guest_that_moves(self):
        self.assert_ends("guest_beside_a_change", 70 * um, 1 + 700 * 0.000037 + (1000 - 2000) * um)

    def test_counts_of_a_machine_that_is_off_are_lost(self):
        self.assertLess(np.ptp(self.column("off_and_on", "joint.2.motor-pos-cmd")), nm)
        self.assert_ends("off_and_on", 0, 0)
        self.assertTrue(self.column("off_and_on", "z-stage.uncompensated")[-1])
        self.assertEqual(self.column("off_and_on", "z-stage.guest-request")[-1], 0)
        self.assert_ends("guest_before_the_cycle", 0, 0.5)
        self.assert_ends("cycle_after_it", 70 * um, 0.5)

    def test_each_is_cleared_without_the_other(self):
        self.assert_ends("guest_cleared", 70 * um, 0)
        self.assertFalse(self.column("guest_cleared", "z-stage.guest-active")[-1])
        self.assertFalse(self.column("guest_cleared", "z-stage.uncompensated").any())
        self.assert_ends("own_cleared", 0, -0.5)
        self.assertFalse(self.column("own_cleared", "z-stage.offset-clear").any())
        self.assert_ends("guest_beside_clear", 0, 0.5)

    def test_disabled_the_guest_stops_in_mid_move_and_loses_counts(self):
        held = self.column("guest_held", "z-stage.guest-applied")[-1]
        self.assertTrue(1 < held < 39)
        self.assertAlmostEqual(self.column("guest_held", "axis.x.eoffset")[-1], held, delta=0.2)  # some cycles later
        self.assertAlmostEqual(self.column("guest_held", "z-stage.applied-offset")[-1], 70 * um, delta=1.01 * COUNT)
        self.assertAlmostEqual(self.column("guest_again", "z-stage.guest-applied")[-1], held - 1, delta=COUNT)
        self.assertAlmostEqual(self.column("guest_again", "z-stage.applied-offset")[-1], 70 * um, delta=1.01 * COUNT)

    def test_emergency_stop_amid_its_move_leaves_nothing(self):
        self.assertGreater(np.ptp(self.column("emergency_stop", "joint.2.motor-pos-cmd")), 0.1)
        self.assert_ends("after_emergency_stop", 0, 0)
        self.assertLess(np.ptp(self.column("after_emergency_stop", "joint.2.motor-pos-cmd")[-400:]), nm)

    def test_nobody_is_told_of_a_fault(self):
        self.assertEqual(self.shift["z-stage.fault-code"].max(), 0)
        self.assertEqual(self.errors, [])


class InchMachine(unittest.TestCase):
    """LinuxCNC of a machine in inches, which loads the stage and ends."""

    def started_with(self, loading):
        folder = own_folder(self)
        machine = linuxcnc_runs.copy_configuration("three_axis", folder)
        ini = own_ini(os.path.join(machine, "three_axis.ini"), TRAJ=["LINEAR_UNITS = inch"], HAL=at_the_end("HALFILE = stage.hal"))
        with open(os.path.join(machine, "stage.hal"), "w") as file:
            file.write(loading + "\nloadusr -w halcmd getp z-stage.max-offset\nloadusr -w false\n")
        status, output = linuxcnc_runs.finish(linuxcnc_runs.start(folder, ini))
        self.assertNotEqual(status, 0)
        return output

    def test_defaults_in_millimetres_are_refused_and_the_message_tells_what_to_write(self):
        output = self.started_with("loadrt axis_offset names=z-stage interlock=no")
        self.assertRegex(output, r"axis_offset: \[TRAJ\]LINEAR_UNITS is inch in .*, and the defaults are in mm")
        self.assertIn("add unit=[TRAJ]LINEAR_UNITS to the loadrt line", output)

    def test_defaults_are_converted_by_the_unit_of_the_ini_file(self):
        output = self.started_with("loadrt axis_offset names=z-stage interlock=no unit=[TRAJ](LINEAR_UNITS)")
        self.assertIn("\n%.9f\n" % (0.15 / 25.4), output)


if __name__ == "__main__":
    linuxcnc_runs.main(Shift, __doc__)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of portal_linuxcnc_test: works a machine whose tilts are corrected through a shift."""

import contextlib
import sys

import linuxcnc
from plumb_linuxcnc import OperatorError, Overdue
from scenario import Scenario, run

COLUMNS = ["scene", "motion.is-all-homed", "motion.digital-out-01", "motion.tooloffset.z", "iocontrol.0.tool-number"]
COLUMNS += ["square.ramping", "square.fault-code", "square.enabled", "square.axis-direction"]
COLUMNS += ["square.e%s0y-in-use" % rotation for rotation in "ac"]
for number, letter in enumerate("xyz"):
    COLUMNS += ["joint.%d.%s" % (number, pin) for pin in ("pos-cmd", "vel-cmd", "f-error")]
    COLUMNS += ["square.%s-%s" % (letter, pin) for pin in ("correction", "corrected-position", "corrected-velocity")]
    COLUMNS += ["%s-stage.%s" % (letter, pin) for pin in ("applied-offset", "drive-command", "limited", "fault-code")]
    COLUMNS += ["portal.truth-%s-error" % letter, "portal.%s-position" % letter]
CONTOUR = ["square.compensation-radius", "square.compensation-plane", "square.compensation-side", "square.unsettled-code"]
RAIL = ["joint.3.pos-cmd"]
RAIL += ["square.e%s0%s-in-use" % (rotation, letter) for letter in "wz" for rotation in "ab"]

STRAIGHT = "# machine: a lathe\nX,EYX\n-260,0\n260,0\n# end, 2 rows\n"
CROOKED = "X,EYX\n-260,-0.026\n0,0\n260,0.026\n"
LOST_MOTION = "X,EXX+,EXX-\n-260,-0.01,0.01\n260,-0.01,0.01\nY,EYY+,EYY-\n-260,-0.005,0.005\n260,-0.005,0.005\n# end, 4 rows\n"
SHORT = "W,EZW\n-200,0.1\n0,0\n10,-0.005\n"  # a scale that shows 0.5 mm/m too much

MOVES = (
    "G1 X100 Y120 Z-120 F9000",
    "G17 G2 X-60 Y20 I-80 J-50 F9000",
    "G18 G3 X60 Z-20 I60 K50 F9000",
    "G17 G0 X-120 Y-80 Z0",
)


class Shift(Scenario):
    def __init__(self, machine):
        super().__init__(machine)
        self.has_rail = machine.status.joints == 4
        self.columns = COLUMNS + (RAIL if self.has_rail else CONTOUR)

    def work(self):
        self.play(
            self.turn_on,
            self.choose_a_tool,
            self.disable,
            self.enable,
            self.edit_an_angle,
            self.change_modes,
            self.jog_joints,
            self.jog_axes,
            self.uncorrected_path,
            self.corrected_path,
            self.change_amid_a_move,
            self.change_the_tool,
            self.reload_a_table,
            self.off_and_on,
            self.change_while_off,
            self.emergency_stop,
            self.soft_limit,
            self.suspend,
            self.uncorrected_cube,
            self.uncorrected_box,
            self.resume,
            self.corrected_cube,
            self.corrected_box,
            *(() if self.has_rail else (self.contour_without, self.contour, self.contour_aborted, self.contour_stopped, self.contour_forgotten, self.contour_refused, self.contour_by_hand)),
            *(() if self.has_rail else (self.circles_without, self.circles)),
            self.unhome,
            self.home_again,
            self.home_too_early,
            self.home_once_more,
        )

    def turn_on(self):
        self.machine.turn_on()
        self.machine.home()

    def choose_a_tool(self):
        """And goes where there is much to correct."""
        self.machine.mdi("G10 L2 P1 X0 Y0 Z-170 R0")
        self.machine.mdi("T2 M6 G43 G54")
        self.to_a_far_place()

    def disable(self):
        self.host.set("interlock.function-switch-0", False)
        self.await_ramp()

    def enable(self):
        self.host.set("interlock.function-switch-0", True)
        self.await_ramp()

    def edit_an_angle(self):
        angle = self.host.get("square.ea0y")
        for value in (angle + 0.0005, angle):
            self.host.set("square.ea0y", value)
            self.await_ramp()

    def change_modes(self):
        for mode in (linuxcnc.MODE_MANUAL, linuxcnc.MODE_MDI, linuxcnc.MODE_AUTO, linuxcnc.MODE_MANUAL):
            self.machine.mode(mode)
            self.rest()
        for change in (self.machine.joint_mode, self.machine.axis_mode) * 2:
            change()
            self.rest()

    def jog_joints(self):
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.joint_mode()
        self.jog_each(True, -20)

    def jog_axes(self):
        self.machine.axis_mode()
        self.jog_each(False, 20)

    def jog_each(self, is_joint, way):
        for number in range(3):
            self.jog(number, way, 50, is_joint)
        self.rest()

    def uncorrected_path(self):
        self.host.set("interlock.function-switch-0", False)
        self.path()

    def corrected_path(self):
        self.host.set("interlock.function-switch-0", True)
        self.path()

    def path(self):
        """From rest to rest, so that each move comes out alike; digital output 1 is set as they go on."""
        self.machine.mdi(MOVES[-1])
        self.machine.mdi("M64 P1")
        for move in MOVES:
            self.await_ramp()
            self.rest()
            self.machine.mdi(move)
        self.rest()
        self.machine.mdi("M65 P1")

    def change_amid_a_move(self):
        """Enable, an angle and the readings, while it moves."""
        self.to_a_far_place()
        self.machine.mdi("G1 X-100 Y-100 Z0 F4500", wait=False)
        for pin, value in (("interlock.function-switch-0", False), ("interlock.function-switch-0", True), ("square.axis-direction", True)):
            self.machine.wait(0.8)
            self.host.set(pin, value)
        angle = self.host.get("square.ec0y")
        for value in (angle - 0.0005, angle):
            self.machine.wait(0.8)
            self.host.set("square.ec0y", value)
        self.machine.wait(0.8)
        self.host.set("square.axis-direction", False)
        self.machine.wait_until_idle()
        self.await_ramp()

    def change_the_tool(self):
        self.to_a_far_place()
        self.host.set("square.max-rate", 0.02)  # so that it would move meanwhile, however late a busy computer is
        self.machine.run("portal_tools.ngc")
        self.to_a_far_place()
        self.await_ramp()
        self.host.set("square.max-rate", 0.1)

    def reload_a_table(self):
        crooked = CROOKED + (SHORT + "# end, 6 rows\n" if self.has_rail else "# end, 3 rows\n")
        for serial, table in enumerate((crooked, STRAIGHT), start=self.host.get("square.serial") + 1):
            with open("errors.csv", "w") as file:
                file.write(table)
            self.host.set("square.reload", True)
            self.await_pin("square.serial", serial)
            self.await_ramp()
            self.host.set("square.reload", False)
            self.facts.setdefault("reloaded", []).append(self.host.get("square.y-correction"))
            if self.has_rail and table is crooked:
                self.rail_corrects()

    def rail_corrects(self):
        for corrects in (False, True, False):
            self.host.set("square.parallel-axis-corrects", corrects)
            self.await_ramp()
            self.rest()
            pins = ("square.z-correction", "square.w-correction", "w-stage.applied-offset", "joint.3.pos-cmd", "portal.w-position")
            self.facts.setdefault("rail", []).append([self.host.get(pin) for pin in pins])

    def off_and_on(self):
        for _ in range(2):
            self.machine.turn_off()
            self.rest()
            self.machine.turn_on()
            self.rest()

    def change_while_off(self):
        self.machine.turn_off()
        self.rest()
        self.host.set("interlock.function-switch-0", False)
        self.await_ramp()
        self.begin("on_again")
        self.set_ramps(0.04)  # so that the program comes before their end
        self.machine.turn_on()
        self.machine.mdi("M66 P5 L4 Q60")
        self.facts["waited for the stages"] = not self.stages_ramp()
        self.set_ramps(0.1)
        self.await_stages()
        self.host.set("interlock.function-switch-0", True)
        self.await_ramp()

    def emergency_stop(self):
        self.machine.mdi("G1 X-100 Y-100 Z0 F3000", wait=False)
        self.machine.wait(0.6)
        self.machine.emergency_stop()
        self.rest()
        self.machine.turn_on()
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.rest()

    def soft_limit(self):
        """At that end of X where the correction leads beyond it."""
        self.machine.mdi("G53 G0 X0 Y-190 Z-150")
        self.await_ramp()
        side = 1 if self.host.get("square.x-correction") > 0 else -1
        self.machine.mdi("G53 G0 X%d" % (250 * side))
        self.rest()
        self.facts["limited"] = self.host.get("x-stage.limited")
        self.machine.mdi("G53 G0 X0")

    def suspend(self):
        self.machine.run("uncorrected.ngc")
        self.await_ramp()

    def uncorrected_cube(self):
        self.machine.run(self.cube())

    def uncorrected_box(self):
        self.machine.run("box.ngc")

    def resume(self):
        self.machine.run("corrected.ngc")
        self.await_ramp()

    def corrected_cube(self):
        self.machine.run(self.cube())

    def corrected_box(self):
        self.machine.run("box.ngc")

    def contour_without(self):
        self.cut_contours()

    def contour(self):
        self.host.set("square.tip-on-contour", True)
        self.cut_contours()

    def cut_contours(self):
        for program in ("bored.ngc", "turned.ngc"):
            self.machine.run(program)
        self.await_ramp()

    def contour_aborted(self):
        self.end_in_the_bore(self.machine.abort)
        self.machine.mdi("G1 X0 Y0 F3000")
        self.rest()
        self.facts["after the abort"] = self.host.get(["joint.0.pos-cmd", "joint.1.pos-cmd"])
        self.await_ramp()

    def contour_stopped(self):
        self.end_in_the_bore(self.machine.emergency_stop)
        self.machine.turn_on()
        self.await_stages()
        self.machine.mdi("G0 X0 Y0")
        self.await_ramp()

    def end_in_the_bore(self, end):
        self.machine.start("bored.ngc")
        self.await_pin("square.compensation-radius", 25)
        self.machine.wait(2)
        end()
        self.rest()
        self.facts.setdefault("ended", []).append(self.host.get(["square.compensation-radius", "joint.0.pos-cmd", "joint.1.pos-cmd"]))

    def contour_forgotten(self):
        """G40 alone."""
        with contextlib.suppress(OperatorError):
            self.machine.run("portal_forgotten.ngc")
        self.machine.wait_until_idle()
        self.machine.mdi("M68 E2 Q0")
        self.await_ramp()

    def contour_refused(self):
        for words in ("T6 M6 G43", "o<contour_tip> call [43]", "T3 M6 G43", "o<contour_tip> call [42]"):
            with contextlib.suppress(OperatorError):
                self.machine.mdi(words)
            self.rest()

    def contour_by_hand(self):
        """In inches, and in another plane. LinuxCNC compensates a move when it knows the next one."""
        for side, plane, inches in ((42, 17, 2), (41, 18, 1)):
            self.machine.mdi("G20 G%d T6 M6 G43" % plane)
            for words in ("G0 X0 Y0", "o<contour_tip> call [%d] [%g]" % (side, inches), "G1 X2 F100", "o<contour_tip> call [40]", "G1 X0 F100"):
                self.machine.mdi(words)
        self.machine.mdi("G21 G17")
        self.await_ramp()
        self.host.set("square.tip-on-contour", False)

    def circles_without(self):
        """In both directions, by a machine that loses 20 and 10 um; then to a place from both sides."""
        self.host.set("portal.x-play", 0.02)
        self.host.set("portal.y-play", 0.01)
        self.cut_circles()

    def circles(self):
        self.read_table(LOST_MOTION)
        self.cut_circles()
        self.host.set("portal.x-play", 0)
        self.host.set("portal.y-play", 0)
        self.read_table(STRAIGHT)

    def cut_circles(self):
        self.machine.mdi("T2 M6 G43 G54")
        self.machine.mdi("G17 G0 X0 Y0 Z0")
        self.machine.mdi("G1 X20 F1000")
        self.await_ramp()
        self.machine.mdi("M64 P1")
        for circle in ("G3 I-20 F1000", "G2 I-20 F1000"):
            self.machine.mdi(circle)
        self.rest()
        self.machine.mdi("M65 P1")
        found = []
        for place in (-5, 5):
            for words in ("G1 X%d Y%d F1000" % (place, place), "G1 X0 Y0"):
                self.machine.mdi(words)
            self.rest()
            found.append(self.host.get(["portal.truth-x-error", "portal.truth-y-error"]))
        self.facts.setdefault("both sides", []).append(found)

    def read_table(self, text):
        with open("errors.csv", "w") as file:
            file.write(text)
        serial = self.host.get("square.serial") + 1
        self.host.set("square.reload", True)
        self.await_pin("square.serial", serial)
        self.await_ramp()
        self.host.set("square.reload", False)

    def unhome(self):
        self.to_a_far_place()
        self.await_ramp()
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.joint_mode()
        self.machine.command.unhome(-1)
        self.await_pin("motion.is-all-homed", False)
        self.await_stages()

    def home_again(self):
        self.machine.home()
        self.machine.mdi("G0 X50 Y60 Z-50")
        self.await_ramp()

    def home_too_early(self):
        """Where the joints stand, with an offset in force: LinuxCNC refuses, but for a mistake in the HAL files."""
        self.set_ramps(1e-4)  # however long this program takes
        for inhibited in (True, False):
            if not inhibited:
                self.host.halcmd("unlinkp", "motion.homing-inhibit")
                self.host.set("motion.homing-inhibit", False)
            with contextlib.suppress(OperatorError):
                self.machine.home()
            self.facts.setdefault("homed too early", []).append(any(self.machine.poll().homed))
        self.await_pin("motion.is-all-homed", True)
        with contextlib.suppress(OperatorError, Overdue):  # all messages of it
            self.machine.wait_for(lambda status: len(self.machine.errors) == 4, "messages", 10)
        self.facts["too early"] = [self.host.get("%s-stage.fault-code" % letter) for letter in "xyz"]
        self.set_ramps(0.1)
        self.await_stages()
        with contextlib.suppress(OperatorError, Overdue):
            self.machine.wait_for(lambda status: False, "more messages", 0.5)
        self.host.halcmd("net", "no-homing", "motion.homing-inhibit")

    def home_once_more(self):
        self.machine.home()
        self.machine.mdi("G0 X-50 Y-60 Z0")
        self.await_ramp()

    def cube(self):
        return "portal_cube.ngc" if self.has_rail else "cube.ngc"

    def to_a_far_place(self):
        self.machine.mdi("G53 G0 X150 Y150 Z-200")
        if self.has_rail:
            self.machine.mdi("G53 G0 W-20")

    def set_ramps(self, rate):
        for letter in "xyz":
            self.host.set("%s-stage.ramp-rate" % letter, rate)

    def await_ramp(self):
        """Waits until a change has shown, and the correction follows motion alone."""
        self.machine.wait(0.01)
        self.await_pin("square.ramping", False)

    def stages_ramp(self):
        return any(self.host.get("%s-stage.ramping" % letter) for letter in "xyz")

    def await_stages(self):
        self.machine.wait(0.01)
        self.await_condition(lambda: not self.stages_ramp(), "the end of the stages' ramps")


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

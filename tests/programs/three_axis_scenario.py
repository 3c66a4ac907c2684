#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of three_axis_test: works the machine through a shift, and leaves a recording of each scene."""

import sys

import linuxcnc
from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

COLUMNS = (
    ["axis.%s.pos-cmd" % letter for letter in "xyz"]
    + ["joint.%d.%s" % (joint, pin) for joint in range(3) for pin in ("motor-pos-cmd", "motor-pos-fb", "homed")]
    + ["motion.motion-enabled", "motion.current-vel", "motion.program-line", "motion.digital-out-00"]
    + ["motion.digital-out-01", "spindle.0.speed-out", "spindle.0.at-speed", "iocontrol.0.tool-number"]
)

X, Y, Z = 0, 1, 2


class Shift(Scenario):
    columns = COLUMNS

    def work(self):
        machine = self.machine
        with self.record("home"):
            machine.turn_on()
            machine.home()
            self.rest()
        with self.record("home_again"):
            machine.home()
        with self.record("rapid"):
            machine.mdi("G61 G0 X100")  # blended paths have but half the acceleration
            self.rest()
        with self.record("short_rapid"):
            machine.mdi("G0 Y5")
            self.rest()
        self.refusal()
        with self.record("program"):
            machine.run("three_axis_path.ngc")
            self.rest()
        self.override()
        self.pause()
        self.abort()
        self.off_and_on()
        self.emergency_stop()
        self.jog()

    def refusal(self):
        """The operator gets a message about the limit, and can go on."""
        try:
            self.machine.mdi("G0 X1000")
        except OperatorError as error:
            self.facts["refusal"] = str(error)
        self.machine.abort()

    def override(self):
        machine = self.machine
        machine.mdi("G0 X0 Y0 Z0")
        with self.record("override"):
            machine.command.feedrate(0.5)
            machine.mdi("G1 X20 F1200")
            self.rest()
        machine.command.feedrate(1)

    def pause(self):
        machine = self.machine
        machine.mdi("G0 X0")
        with self.record("pause"):
            machine.start("three_axis_line.ngc")
            self.await_x(30)
            machine.pause()
            self.rest()
            self.facts["paused_at"] = machine.poll().position[X]
            machine.resume()
            machine.wait_until_idle()
            self.rest()

    def abort(self):
        machine = self.machine
        machine.mdi("G0 X0")
        with self.record("abort"):
            machine.start("three_axis_line.ngc")
            self.await_x(30)
            machine.abort()
            self.rest()
        with self.record("after_abort"):
            machine.mdi("G0 X60")
            self.rest()

    def off_and_on(self):
        machine = self.machine
        with self.record("off_and_on"):
            self.rest()
            machine.turn_off()
            self.rest()
            machine.turn_on()
            self.rest()

    def emergency_stop(self):
        machine = self.machine
        machine.mdi("G0 X0")
        with self.record("emergency_stop"):
            machine.start("three_axis_line.ngc")
            self.await_x(30)
            machine.emergency_stop()
            self.rest()
            machine.turn_on()
            self.rest()
        with self.record("after_emergency_stop"):
            machine.mdi("G0 X20 Y20")
            self.rest()

    def jog(self):
        machine = self.machine
        machine.mode(linuxcnc.MODE_MANUAL)
        machine.axis_mode()
        with self.record("jog_increment"):
            machine.command.jog(linuxcnc.JOG_INCREMENT, False, Y, 50, 12.5)
            self.await_motion(Y, 20)
            machine.wait_until_still()
            self.rest()
        with self.record("jog"):
            machine.command.jog(linuxcnc.JOG_CONTINUOUS, False, Y, 50)
            machine.wait_for(lambda status: status.position[Y] > 60, "the jog")
            machine.command.jog(linuxcnc.JOG_STOP, False, Y)
            machine.wait_until_still()
            self.rest()
        machine.turn_off()

    def await_x(self, position):
        self.machine.wait_for(lambda status: status.position[X] > position, "X%g" % position)

    def await_motion(self, axis, start):
        self.machine.wait_for(lambda status: abs(status.position[axis] - start) > 1, "motion")


if __name__ == "__main__":
    sys.exit(run(Shift))

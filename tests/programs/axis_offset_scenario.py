#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of axis_offset_linuxcnc_test: works a machine with an offset in its Z axis through a shift.
"""

import contextlib
import sys

import linuxcnc
from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

COLUMNS = [
    "scene",
    "joint.0.motor-pos-cmd",
    "joint.2.motor-pos-cmd",
    "axis.z.pos-cmd",
    "axis.z.eoffset",
    "axis.z.eoffset-request",
    "motion.motion-enabled",
    "motion.is-all-homed",
    "motion.motion-type",
    "motion.current-vel",
    "motion.digital-out-00",
    "z-stage.applied-offset",
    "z-stage.armed",
    "z-stage.clear",
    "z-stage.limited",
    "z-stage.uncompensated",
    "z-stage.probing-refused",
    "z-stage.fault-code",
    "z-stage.counts",
]


class Shift(Scenario):
    columns = COLUMNS

    def work(self):
        self.play(
            self.turn_on,
            self.start_a_cycle,
            self.change_modes,
            self.run_a_program,
            self.pause,
            self.abort,
            self.soft_limit,
            self.touch_off,
            self.refused_probing,
            self.clear,
            self.probing,
            self.allowed_probing,
            self.joint_mode,
            self.off_and_on,
            self.emergency_stop,
            self.home_again,
            self.unhome,
        )

    def turn_on(self):
        self.set("offset-0", 0.05)
        self.machine.turn_on()
        self.machine.home()

    def start_a_cycle(self):
        self.arm()
        self.await_offset(0.05)

    def change_modes(self):
        for mode in (linuxcnc.MODE_MANUAL, linuxcnc.MODE_MDI, linuxcnc.MODE_AUTO, linuxcnc.MODE_MANUAL):
            self.machine.mode(mode)
            self.rest()
        self.machine.joint_mode()
        self.rest()
        self.machine.axis_mode()

    def run_a_program(self):
        self.machine.start("axis_offset_part.ngc")
        self.await_pin("motion.digital-out-01", True)  # while it cuts
        self.set("offset-0", 0.08)
        self.machine.wait_until_idle()

    def pause(self):
        self.machine.start("axis_offset_part.ngc")
        self.await_pin("motion.digital-out-01", True)
        self.machine.pause()
        self.rest()
        self.begin("paused")
        self.set("offset-0", 0.02)
        self.await_offset(0.02)
        self.rest()
        self.begin("resumed")
        self.machine.resume()
        self.machine.wait_until_idle()

    def abort(self):
        self.machine.start("axis_offset_part.ngc")
        self.await_pin("motion.digital-out-01", True)
        self.machine.abort()
        self.machine.mdi("M65 P1")  # which the program could not take back

    def soft_limit(self):
        self.machine.mdi("G0 Z50")
        self.await_pin("z-stage.limited", True)
        self.rest()
        self.begin("at_the_limit")
        self.set("offset-0", 0.05)
        self.machine.wait(0.5)
        self.begin("behind_the_limit")
        self.machine.mdi("G0 Z40")
        self.await_offset(0.05)

    def touch_off(self):
        self.machine.mdi("G0 Z10")
        self.machine.mdi("G10 L20 P1 Z0")
        self.machine.mdi("G0 Z5")
        self.rest()
        self.facts["touched_off"] = self.host.get("joint.2.motor-pos-cmd")
        self.machine.mdi("G10 L2 P1 Z0")
        self.machine.mdi("G0 Z0")

    def refused_probing(self):
        with contextlib.suppress(OperatorError):  # that the probe has found nothing
            self.probe()
        self.machine.abort()

    def clear(self):
        self.set("clear", True)
        self.await_offset(0)
        self.rest()
        self.set("clear", False)
        self.machine.mdi("G0 Z0")

    def probing(self):
        self.facts["probed"] = self.probe()
        self.machine.mdi("G0 Z0")

    def allowed_probing(self):
        self.arm()
        self.await_offset(0.05)
        self.set("allow-probing", True)
        self.machine.mdi("G38.2 Z-40 F300", wait=False)
        self.await_pin("motion.motion-type", 5)
        self.set("offset-0", 0.09)
        self.machine.wait_until_idle()
        self.facts["probed_with_offset"] = self.machine.poll().probed_position[2]
        self.machine.mdi("G0 Z0")
        self.await_offset(0.09)
        self.set("allow-probing", False)

    def joint_mode(self):
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.joint_mode()
        self.rest()
        self.begin("in_joint_mode")
        self.set("offset-0", 0.03)
        self.machine.wait(1)
        self.begin("out_of_joint_mode")
        self.machine.axis_mode()
        self.await_offset(0.03)

    def off_and_on(self):
        self.machine.turn_off()
        self.rest()
        self.machine.turn_on()
        self.rest()
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.begin("after_off_and_on")
        self.machine.mdi("G0 Z0")
        self.arm()
        self.await_offset(0.03)

    def emergency_stop(self):
        self.machine.start("axis_offset_part.ngc")
        self.await_pin("motion.digital-out-01", True)
        self.set("max-rate", 0.01)  # 5 s, so that the stop comes before the end
        self.set("offset-0", 0.08)
        self.await_condition(lambda: self.host.get("axis.z.eoffset") > 0.031, "a part of the change")
        self.machine.emergency_stop()
        self.set("max-rate", 0.1)
        self.rest()
        self.begin("after_emergency_stop")
        self.machine.turn_on()
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.wait(1)
        self.begin("after_all_that")
        self.machine.mdi("M65 P1")  # which the program could not take back
        self.machine.mdi("G0 X0 Z0")
        self.arm()
        self.await_offset(0.08)

    def home_again(self):
        """With an offset in force, which is a mistake."""
        self.machine.home()
        self.arm()
        self.machine.wait(0.5)
        self.begin("homed_right")
        self.machine.turn_off()
        self.machine.turn_on()
        self.machine.home()

    def unhome(self):
        self.arm()
        self.await_offset(0.08)
        self.set("clear", True)
        self.await_offset(0)
        self.set("clear", False)
        self.machine.home()
        self.machine.wait(0.5)
        self.begin("cycle_after_homing")
        self.arm()
        self.await_offset(0.08)

    def probe(self):
        self.machine.mdi("G38.2 Z-40 F300")
        return self.machine.poll().probed_position[2]

    def arm(self):
        """As a program does it at the start of a cycle."""
        self.machine.mdi("M64 P0")
        self.machine.wait(0.01)
        self.machine.mdi("M65 P0")

    def set(self, pin, value):
        self.host.set("z-stage." + pin, value)

    def await_offset(self, value):
        self.await_condition(lambda: abs(self.host.get("axis.z.eoffset") - value) < 1e-4, "the offset of %g" % value)


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

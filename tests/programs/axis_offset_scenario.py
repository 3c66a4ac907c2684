#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of axis_offset_linuxcnc_test: works a machine with an offset in its Z axis through a shift.

shift.csv has a row for each servo cycle of it, with the number of the scene; facts.json has their names, and what the
operator was told. The exit status, 42, is no one else's.
"""

import contextlib
import json
import sys

import linuxcnc
from plumb_linuxcnc import Machine, OperatorError

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


class Shift:
    def __init__(self, machine):
        self.machine = machine
        self.host = machine.host
        self.scenes = []
        self.facts = {}

    def work(self):
        for scene in (
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
            self.home_anew,
            self.unhome,
        ):
            self.begin(scene.__name__)
            scene()
            self.rest()

    def turn_on(self):
        self.set("offset", 0.05)
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
        self.set("offset", 0.08)
        self.machine.wait_until_idle()

    def pause(self):
        self.machine.start("axis_offset_part.ngc")
        self.await_pin("motion.digital-out-01", True)
        self.machine.pause()
        self.rest()
        self.begin("paused")
        self.set("offset", 0.02)
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
        self.set("offset", 0.05)
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
        self.set("offset", 0.09)
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
        self.set("offset", 0.03)
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
        self.set("offset", 0.08)
        self.machine.start("axis_offset_part.ngc")
        self.await_pin("motion.digital-out-01", True)
        self.machine.emergency_stop()
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

    def home_anew(self):
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

    def begin(self, scene):
        self.scenes.append(scene)
        self.host.set("scene", len(self.scenes))

    def arm(self):
        """As a program does it at the start of a cycle."""
        self.machine.mdi("M64 P0")
        self.machine.wait(0.01)
        self.machine.mdi("M65 P0")

    def set(self, pin, value):
        self.host.set("z-stage." + pin, value)

    def await_offset(self, value):
        self.await_condition(lambda: abs(self.host.get("axis.z.eoffset") - value) < 1e-4, "the offset of %g" % value)

    def await_pin(self, pin, value):
        self.await_condition(lambda: self.host.get(pin) == value, "%s %s" % (pin, value))

    def await_condition(self, condition, what):
        """Of pins; what the operator is told meanwhile is not looked at."""
        latest = self.host.time + 60
        while not condition():
            if self.host.time > latest:
                raise RuntimeError("%s did not come" % what)
            self.machine.wait(0.005)

    def rest(self):
        self.machine.wait(0.1)


def main():
    with Machine() as machine:
        shift = Shift(machine)
        with machine.recording("shift.csv", COLUMNS):
            shift.work()
        machine.turn_off()
    with open("facts.json", "w") as file:
        json.dump({"scenes": shift.scenes, "facts": shift.facts, "errors": machine.errors}, file)
    return 42


if __name__ == "__main__":
    sys.exit(main())

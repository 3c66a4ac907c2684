#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of axis_offset_linuxcnc_test for a stage with a guest: Z has both, X the same guest alone.
"""

import sys

from scenario import Scenario, run

COLUMNS = [
    "scene",
    "joint.0.motor-pos-cmd",
    "joint.2.motor-pos-cmd",
    "axis.x.eoffset",
    "axis.x.eoffset-request",
    "axis.z.eoffset",
    "motion.motion-enabled",
    "z-stage.applied-offset",
    "z-stage.guest-request",
    "z-stage.guest-applied",
    "z-stage.guest-active",
    "z-stage.armed",
    "z-stage.uncompensated",
    "z-stage.offset-clear",
    "z-stage.fault-code",
]


class Shift(Scenario):
    columns = COLUMNS

    def work(self):
        self.host.set("guest-scale", 0.001)
        self.host.set("guest-enable", True)
        self.host.set("z-stage.offset-0", 0.04)
        self.host.set("z-stage.offset-1", 0.01)
        self.play(
            self.turn_on,
            self.guest_alone,
            self.both,
            self.fractions,
            self.guest_beside_a_change,
            self.guest_off,
            self.off_and_on,
            self.guest_before_the_cycle,
            self.cycle_after_it,
            self.guest_cleared,
            self.own_cleared,
            self.guest_beside_clear,
            self.guest_held,
            self.guest_again,
            self.emergency_stop,
            self.after_emergency_stop,
        )

    def turn_on(self):
        self.guest(300)
        self.machine.wait(0.1)
        self.machine.turn_on()
        self.machine.home()

    def guest_alone(self):
        self.guest(1300)
        self.await_guest()

    def both(self):
        self.arm()
        self.await_own(0.05)

    def fractions(self):
        """700 steps of 0.37 counts of the stage."""
        self.host.set("guest-scale", 0.000037)
        for n in range(700):
            self.guest(1301 + n)
            self.machine.wait(0.001)
        self.await_guest()
        self.machine.wait(0.1)
        self.host.set("guest-scale", 0.001)

    def guest_beside_a_change(self):
        self.host.set("z-stage.offset-1", 0.03)
        self.guest(5000)
        self.machine.wait(0.05)
        self.guest(1000)
        self.await_guest()
        self.await_own(0.07)

    def guest_off(self):
        """Its counts change while the machine is off."""
        self.machine.turn_off()
        self.guest(4000)
        self.machine.wait(0.1)

    def off_and_on(self):
        self.machine.turn_on()
        self.rest()

    def guest_before_the_cycle(self):
        self.guest(4500)
        self.await_guest()

    def cycle_after_it(self):
        self.arm()
        self.await_own(0.07)

    def guest_cleared(self):
        self.host.set("guest-clear", True)
        self.guest(6000)
        self.await_guest()
        self.host.set("guest-clear", False)
        self.rest()

    def own_cleared(self):
        self.guest(5500)
        self.await_guest()
        self.host.set("z-stage.clear", True)
        self.await_own(0)

    def guest_beside_clear(self):
        self.guest(6500)
        self.await_guest()
        self.host.set("z-stage.clear", False)

    def guest_held(self):
        self.arm()
        self.await_own(0.07)
        self.guest(40500)
        self.machine.wait(0.15)
        self.host.set("guest-enable", False)
        self.guest(9000)
        self.machine.wait(0.2)

    def guest_again(self):
        self.host.set("guest-enable", True)
        self.rest()
        self.guest(8000)
        self.await_guest()
        self.machine.wait(0.1)

    def emergency_stop(self):
        self.guest(0)
        self.machine.wait(0.05)
        self.machine.emergency_stop()

    def after_emergency_stop(self):
        self.machine.turn_on()
        self.machine.wait(0.5)

    def guest(self, counts):
        self.host.set("guest-counts", counts)

    def arm(self):
        """As a program does it at the start of a cycle."""
        self.machine.mdi("M64 P0")
        self.machine.wait(0.01)
        self.machine.mdi("M65 P0")

    def await_guest(self):
        self.machine.wait(0.01)
        for axis, request in (("axis.x.eoffset", "axis.x.eoffset-request"), ("z-stage.guest-applied",) * 2):
            request = request.replace("applied", "request")
            self.await_condition(
                lambda a=axis, r=request: abs(self.host.get(a) - self.host.get(r)) < 1e-5, "%s of the guest" % axis
            )

    def await_own(self, value):
        self.await_condition(
            lambda: abs(self.host.get("z-stage.applied-offset") - value) < 1.5e-4, "the offset of %g" % value
        )
        self.machine.wait(0.05)


if __name__ == "__main__":
    sys.exit(run(Shift, recording="guest.csv"))

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of mill_both_linuxcnc_test: works configs/mill through a day, which is named in the command line.

On the first a part is made with neither function, with each alone and with both, and then much goes wrong. The short one
leaves out growth without squareness. Any other is a restart with what plumb-retain has kept. DAY.csv is the recording of a day, DAY.json has its facts.
"""

import contextlib
import os
import signal
import sys

import linuxcnc
from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

COLUMNS = (
    ["scene", "axis.z.eoffset", "growth.z-offset", "growth.enabled", "square.enabled", "mill.engagement", "mill.truth-growth"]
    + ["mill.truth-cuts", "mill.truth-cut-error", "mill.truth-cut-operation", "growth.contacts-accepted"]
    + ["interlock.feed-service-lost", "motion.motion-enabled", "motion.motion-type", "motion.digital-out-00", "motion.homing-inhibit"]
    + [axis + "-stage.drive-command" for axis in "xyz"]
    + ["portal.%s-position" % axis for axis in "xyz"]
    + ["portal.truth-%s-error" % axis for axis in "xyz"]
)
NAME = sys.argv[-1]  # of the day
GROWTH, SQUARE = "interlock.function-switch-0", "interlock.function-switch-1"
GROWN = 0.015  # mm
WORK = "G10 L2 P1 X0 Y0 Z-250"  # where it is, in this machine
PART = """M64 P4
M66 P4 L3 Q30
o<cycle_start> call
o<change> call [1] [6000]
o<plunge> call [10] [-200] [-150] [2] [100]
o<plunge> call [10] [200] [-150] [2] [100]
o<plunge> call [10] [200] [150] [2] [100]
o<change> call [2] [6000]
o<plunge> call [20] [-200] [150] [2] [150]
G53 G0 Z0
M5
o<cycle_end> call
M2
"""


class Day(Scenario):
    columns = COLUMNS

    def work(self):
        with open("both.ngc", "w") as file:
            file.write(PART)
        self.begin("setup")
        self.machine.turn_on()
        self.machine.home()
        self.machine.mdi(WORK)
        if NAME in ("first", "short"):
            if NAME == "first":
                self.growth_without_squareness()
            self.growth_with_squareness()
            self.trouble()
        else:
            self.facts["rows"] = self.host.get("growth.rows")
            self.grow(GROWN)
            self.part("after_restart")
            self.facts["errors"] = list(self.machine.errors)
            if NAME == "renamed":
                self.losses()

    def growth_without_squareness(self):
        self.switch(SQUARE, False)
        self.machine.run("learn.ngc")
        self.part("leaning")
        self.grow(GROWN)
        self.switch(GROWTH, False)
        self.part("neither")
        self.switch(GROWTH, True)
        self.part("growth_comes")  # as a step, which takes some contacts
        self.part("growth_stays")
        self.part("growth_alone")

    def growth_with_squareness(self):
        self.switch(SQUARE, True)
        self.grow(0)
        self.host.set("growth.forget", True)  # the tools meet the work at other heights now
        self.machine.wait(0.1)
        self.host.set("growth.forget", False)
        self.machine.run("learn.ngc")
        self.part("learnt")
        self.facts["learning failed"] = self.host.get("growth.learning-failed")
        self.grow(GROWN)
        self.switch(GROWTH, False)
        self.part("square_alone")
        self.switch(GROWTH, True)
        self.part("both_come")
        self.part("both_stay")
        self.part("both")

    def trouble(self):
        self.abort()
        self.part("after_abort")
        self.off_and_on()
        self.part("after_off_and_on")
        self.home()
        self.part("after_homing")
        self.probe()

    def abort(self):
        """In the second cut."""
        self.begin("aborted")
        cuts = self.host.get("mill.truth-cuts")
        self.machine.start("both.ngc")
        self.await_condition(
            lambda: self.host.get("mill.truth-cuts") > cuts and self.host.get("mill.engagement") > 0.5, "the second cut"
        )
        self.machine.abort()
        self.machine.wait(1)

    def off_and_on(self):
        """Where the correction is large, and with the offset in force."""
        self.machine.mdi("G53 G0 Z0")
        self.machine.mdi("G53 G0 X100 Y150")
        self.begin("off_and_on")
        self.rest()
        self.machine.turn_off()
        self.machine.wait(0.5)
        self.machine.turn_on()
        self.machine.wait(0.5)
        self.begin("on_again")
        self.facts["off and on"] = [self.host.get("axis.z.eoffset"), self.host.get("z-axis-stage.uncompensated")]

    def home(self):
        """First with both in force, which LinuxCNC refuses."""
        machine = self.machine
        machine.mdi("G53 G0 X100 Y150")
        self.begin("homed_too_early")
        machine.mode(linuxcnc.MODE_MANUAL)
        machine.joint_mode()
        self.rest()
        machine.command.home(-1)
        with contextlib.suppress(OperatorError):
            machine.wait_for(lambda _: False, "the refusal", 1)
        self.begin("taken_back")
        machine.axis_mode()
        machine.mdi("O <take_back> call")
        machine.mdi("G53 G0 X0 Y0 Z0")  # where this machine is at home
        machine.mode(linuxcnc.MODE_MANUAL)
        machine.joint_mode()
        machine.command.unhome(-1)
        self.await_pin("motion.homing-inhibit", False)
        self.begin("homed")
        machine.home()
        machine.wait(0.5)
        self.facts["homed"] = [self.host.get(letter + "-stage.fault") for letter in ("x", "y", "z", "z-axis")]

    def probe(self):
        """With the offset in force: refused; then at both ends of Y. And touches off, with the offset and without it."""
        machine = self.machine
        machine.mdi("T4 M6 G43")
        machine.mdi("G0 X0 Y150 Z3")
        self.begin("probing")
        with contextlib.suppress(OperatorError):
            machine.mdi("G38.2 Z-5 F100")
        machine.abort()
        self.facts["tops"] = []
        for y in (150, -150):
            self.begin("probed")
            machine.mdi("G0 Z5")
            machine.mdi("G0 X0 Y%d" % y)
            machine.mdi("O <probe_work> call [10]")
            self.facts["tops"].append(self.top())
        offset = self.facts["wanted"] = self.host.get("growth.z-offset")
        machine.mdi("G0 Z[3 + %.6f]" % offset)
        machine.mdi("O <touch_off> call [3]")
        self.facts["touched off"] = [self.top()]
        machine.mdi("M64 P4")
        machine.wait_for(lambda _: self.host.get("linuxcnc-link.identified"), "the program's identity")
        machine.wait(0.1)  # task reads its copy of the input
        machine.mdi("O <cycle_start> call")
        machine.mdi("M65 P0")
        machine.mdi("G0 Z3")
        machine.mdi("O <touch_off> call [3]")
        self.facts["touched off"].append(self.top())

    def top(self):
        """Z of G54."""
        return self.machine.poll().g5x_offset[2]

    def losses(self):
        """Task stops and plumb-retain dies while X is on its way; then task goes on, and the move is aborted."""
        for service in (0, 4):
            self.host.set("interlock.service-timeout-%d" % service, 1)
        self.machine.mdi("G53 G0 X-200")
        self.machine.mdi("G53 G1 X200 F600", wait=False)
        self.machine.wait(0.5)
        self.signal(signal.SIGSTOP, "lost", "inihal")
        os.kill(self.processes("plumb-retain")[0], signal.SIGKILL)
        self.await_pin("interlock.service-lost-0", 1)
        self.await_pin("interlock.feed-service-lost", 1)
        self.machine.wait(1)
        self.begin("returned")
        os.kill(self.processes("inihal")[0], signal.SIGCONT)
        self.await_message("plumb-retain (service 0) does not answer")
        self.machine.abort()
        self.await_pin("interlock.function-enable-0", 0)
        self.machine.wait(1)

    def switch(self, pin, on):
        self.host.set(pin, on)
        self.machine.wait(0.01)
        self.await_pin("interlock.ramping", False)

    def grow(self, growth):
        self.machine.mdi("M68 E1 Q%g" % growth)

    def part(self, scene):
        self.begin(scene)
        self.machine.run("both.ngc")
        self.rest()


if __name__ == "__main__":
    sys.exit(run(Day, recording=NAME + ".csv", facts=NAME + ".json"))

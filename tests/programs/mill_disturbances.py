#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of mill_linuxcnc_test: works configs/mill through a day, which is named in the command line.

On the first much goes wrong; any other begins where the first has ended, and one part is made. DAY.csv is the recording of
a day, DAY.json has its facts.
"""

import contextlib
import json
import os
import signal
import subprocess
import sys

import linuxcnc
from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

COLUMNS = [
    "scene",
    "joint.2.motor-pos-cmd",
    "axis.z.pos-cmd",
    "axis.z.eoffset",
    "motion.motion-enabled",
    "motion.motion-type",
    "motion.digital-out-00",
    "z-axis-stage.armed",
    "z-axis-stage.clear",
    "z-axis-stage.uncompensated",
    "z-axis-stage.counts",
    "growth.enabled",
    "square.enabled",
    "mill.z-position",
    "mill.truth-growth",
    "mill.engagement",
    "mill.truth-cuts",
    "mill.truth-cut-error",
    "mill.truth-cut-operation",
    "growth.contacts",
    "growth.contacts-accepted",
    "growth.doubt",
    "growth.status-code",
]
NAME = sys.argv[-1]  # of the day
WORK = "G10 L2 P1 X0 Y0 Z-250"  # where it is, in this machine
um = 1e-3


class Day(Scenario):
    columns = COLUMNS

    def __init__(self, machine):
        super().__init__(machine)
        self.growth = 0

    def work(self):
        if NAME == "first":
            self.first()
        else:
            with open("first.json") as file:
                self.other(json.load(file)["facts"]["growth"])
        self.facts["growth"] = self.host.get("mill.truth-growth")

    def first(self):
        machine = self.machine
        self.begin("setup")
        machine.turn_on()
        machine.home()
        machine.mdi(WORK)
        machine.run("learn.ngc")
        self.part("learnt")

        self.have_grown(10 * um)
        self.host.set("interlock.function-switch-0", False)
        self.part("uncompensated")
        self.host.set("interlock.function-switch-0", True)
        self.part("compensated")
        self.grow()
        self.part("compensated_again")
        self.idle("idle")

        self.begin("aborted")
        self.amid_a_cut()
        machine.abort()
        self.idle("idle_after_abort")
        self.grow()
        self.part("after_abort")

        self.begin("stopped")
        self.amid_a_cut()
        machine.emergency_stop()
        machine.wait(0.5)
        self.begin("on_after_stop")
        self.turn_on()
        machine.mdi("G53 G0 Z0")
        self.grow()
        self.part("after_stop")

        self.begin("off_and_on")
        machine.turn_off()
        machine.wait(0.5)
        self.turn_on()
        self.part("after_off_and_on")

        self.begin("homed_again")
        machine.mdi("O <take_back> call")
        machine.mdi("G53 G0 X0 Y0 Z0")  # where this machine is at home
        machine.mode(linuxcnc.MODE_MANUAL)
        machine.joint_mode()
        machine.command.unhome(-1)
        self.await_pin("motion.homing-inhibit", False)  # the correction of squareness is gone, too
        machine.home()
        machine.wait(0.5)
        self.part("after_homing")

        self.begin("probing")
        machine.mdi("T4 M6 G43")
        machine.mdi("G0 X0 Y0 Z3")
        self.refused(lambda: machine.mdi("G38.2 Z-5 F100"))
        machine.mdi("G53 G0 Z0")
        machine.turn_off()

    def other(self, growth):
        machine = self.machine
        self.begin("morning")
        machine.turn_on()
        machine.home()
        self.have_grown(growth)
        machine.mdi(WORK)
        self.begin("unidentified")
        with open("unidentified.ngc", "w") as file:
            file.write("M66 E0 L0\no<cycle_start> call\nM2\n")
        self.refused(lambda: machine.run("unidentified.ngc"))
        if self.host.get("growth.rows") > 0:
            self.reject_a_contact()
        self.part("after_restart")
        self.begin("retain_killed")
        retain = subprocess.check_output(["pgrep", "-f", "plumb-retain --file " + os.path.abspath("mill.toml")])
        self.host.set("interlock.service-timeout-0", 3)  # not to wait for 30 s
        os.kill(int(retain), signal.SIGKILL)
        with contextlib.suppress(OperatorError):
            machine.wait_for(lambda _: False, "the message")
        machine.wait(1)
        machine.turn_off()

    def reject_a_contact(self):
        """Cuts at another feed than was learned; and touches off."""
        machine = self.machine
        self.begin("rejected")
        machine.mode(linuxcnc.MODE_AUTO)
        machine.command.program_open(os.path.abspath("part.ngc"))
        machine.mdi("M64 P4")
        machine.wait_for(lambda _: self.host.get("linuxcnc-link.identified"), "the program's identity")
        machine.mdi("O <cycle_start> call")
        machine.mdi("O <change> call [1] [6000]")
        machine.mdi("O <plunge> call [10] [-30] [20] [1] [50]")
        self.begin("touch_off")
        self.refused(lambda: machine.mdi("O <touch_off> call [0]"))

    def idle(self, scene):
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.begin(scene)
        self.machine.wait(60)

    def part(self, scene):
        self.begin(scene)
        self.machine.run("part.ngc")
        self.machine.wait(0.1)
        self.begin("after " + scene)

    def have_grown(self, growth):
        """Since the last part."""
        self.growth = growth
        self.host.set("warming.in", growth)
        self.host.set("warming.load", True)
        self.machine.wait(0.01)
        self.host.set("warming.load", False)

    def refused(self, work):
        with contextlib.suppress(OperatorError):
            work()
        self.machine.abort()

    def grow(self):
        """Slowly, while the next parts are made."""
        self.growth += 8 * um
        self.host.set("warming.in", self.growth)

    def amid_a_cut(self):
        """In the second cut of a part."""
        cuts = self.host.get("mill.truth-cuts")
        self.machine.start("part.ngc")
        self.machine.wait_for(
            lambda _: self.host.get("mill.truth-cuts") > cuts and self.host.get("mill.engagement") > 0.5,
            "the second cut",
        )

    def turn_on(self):
        self.machine.turn_on()
        self.machine.wait(0.5)
        self.machine.mode(linuxcnc.MODE_MANUAL)


if __name__ == "__main__":
    sys.exit(run(Day, recording=NAME + ".csv", facts=NAME + ".json"))

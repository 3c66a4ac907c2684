#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of mill_attacks_linuxcnc_test: parts on a warming mill, and then an attack, which is named in the command line."""

import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

COLUMNS = ["scene", "axis.z.eoffset", "motion.digital-out-00", "motion.motion-enabled", "mill.engagement", "mill.truth-growth", "mill.truth-cuts"]
COLUMNS += ["mill.truth-cut-error", "mill.truth-cut-operation", "growth.offset-sigma", "growth.doubt"]
COLUMNS += ["growth.fault", "growth.reference-refused", "growth.learning-failed", "growth.contacts-accepted", "growth.authority"]
WORK = "G10 L2 P1 X0 Y0 Z-250"  # where it is, in this machine
ATTACKED = 3  # parts
NAME = sys.argv[-1]  # of the attack
um = 1e-3


class Attacked(Scenario):
    columns = COLUMNS

    def work(self):
        machine = self.machine
        self.begin("setup")
        machine.turn_on()
        machine.home()
        machine.mdi(WORK)
        machine.run("learn.ngc")
        self.part("learnt")
        self.warm(12 * um)
        machine.wait(60)
        self.part("warm_1")
        self.warm(20 * um)
        self.part("warm_2")
        self.begin("attack")
        getattr(self, NAME)()
        for number in range(1, ATTACKED + 1):
            self.warm((20 + 8 * number) * um)
            self.part("attacked_%d" % number)
        self.begin("end")
        machine.turn_off()

    def part(self, scene):
        """Messages to the operator end no part, but a refusal of LinuxCNC does."""
        self.begin(scene)
        try:
            self.machine.run("part.ngc")
        except OperatorError as error:
            self.facts.setdefault("refusals", []).append(str(error))
            self.machine.abort()
            self.machine.mdi("G53 G0 Z0")
        self.machine.wait(0.1)

    def warm(self, growth):
        self.host.set("warming.in", growth)

    def jump(self, growth):
        self.warm(growth)
        self.host.set("warming.load", True)
        self.machine.wait(0.01)
        self.host.set("warming.load", False)

    def instead(self, pin, value):
        """The pin loses its signal and keeps a value."""
        self.host.command("unlinkp " + pin)
        self.host.set(pin, value)

    # The attacks.

    def load_dead(self):
        self.instead("growth.load", 0)

    def load_frozen(self):
        self.instead("growth.load", 11.3)

    def load_not_a_number(self):
        self.instead("growth.load", float("nan"))

    def load_not_valid(self):
        self.instead("growth.load-valid", False)

    def load_noisy(self):
        self.host.set("drive.white-noise", 4)
        self.host.set("drive.flicker-noise", 2)

    def sister_tool(self):
        self.instead("growth.tool-number", 9)

    def tool_longer_than_its_table(self):
        """Both end mills of operations that are compared: 30 um."""
        self.host.set("mill.tool-deviation", 30 * um)

    def feed_override(self):
        self.machine.command.feedrate(0.7)

    def spindle_override(self):
        self.machine.command.spindleoverride(0.8)

    def step(self):
        self.jump(32 * um)

    def abort(self):
        """Three times in the first cut."""
        for _ in range(3):
            self.machine.start("part.ngc")
            self.await_condition(lambda: self.host.get("mill.engagement") > 0.5, "the first cut")
            self.machine.abort()
            self.machine.wait(0.2)
            self.machine.mdi("G53 G0 Z0")

    def off_and_on(self):
        for _ in range(3):
            self.machine.turn_off()
            self.machine.wait(0.5)
            self.machine.turn_on()
            self.machine.wait(0.5)


if __name__ == "__main__":
    sys.exit(run(Attacked, recording="shift.csv"))

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_linuxcnc_test: strokes on a machine in inches, by programs in inches and in millimetres."""

import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run


class Shift(Scenario):
    columns = [
        "scene",
        "joint.2.pos-cmd",
        "chop.active",
        "chop.command",
        "chop.offset",
        "chop.stroke-count",
        "grinder.truth-position",
        "z-stage.limited",
    ]

    def work(self):
        self.play(self.turn_on, self.contour, self.in_millimetres, self.refusals, self.learn)

    def turn_on(self):
        self.host.set("chop.learn", 0)
        self.machine.turn_on()
        self.machine.home()
        self.await_pin("chop.enabled", 1)  # plumb-retain has restored its values

    def contour(self):
        self.machine.run("inch.ngc")

    def words(self):
        return [self.host.get("chop." + name) for name in ("upper", "lower", "feed")]

    def in_millimetres(self):
        """The speed of the last G81.1 stays, whatever its unit was."""
        self.machine.mdi("G21")
        self.machine.mdi("M3 S1000 G81.1 Z5.08 Q-30.48 R5.08 P3600")
        self.facts["in_millimetres"] = self.words()
        self.machine.mdi("G80.1")
        self.machine.mdi("G20")
        self.machine.mdi("M3 S1000 G81.1 Z0.2 Q-1.2 R0.2")
        self.facts["in_inches"] = self.words()
        self.machine.mdi("G80.1")

    def refusals(self):
        self.facts["refused"] = []
        for block in ("G81.1 Z0.2 Q-1.2 R0.2 P481", "G81.1 Z1 Q-14 R0 P60", "G21 G81.1 Z5 Q-30 R5 P12193"):
            try:
                self.machine.mdi(block)
                self.machine.wait_until_idle()
            except OperatorError as error:
                self.facts["refused"].append(str(error))
        self.machine.mdi("G20")

    def learn(self):
        self.host.set("chop.learn", 1)
        self.machine.mdi("M3 S1000 G81.1 Z0.2 Q-1.2 R0.2 P140")
        self.await_pin("chop.learned", 1)
        last = self.host.get("chop.stroke-count")
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= last + 2, "strokes")
        self.facts["dead_points"] = [self.host.get("grinder.truth-" + name) for name in ("upper", "lower")]
        self.facts["code"] = self.host.get("chop.fault-code")
        self.machine.mdi("G80.1")


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

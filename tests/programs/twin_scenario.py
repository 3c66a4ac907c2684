#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of lathe_twin_linuxcnc_test: two tools that cut at once come on centre, and turn one bar together."""

import contextlib
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run


class Twin(Scenario):
    columns = ["scene", "lathe.truth-cutting", "second.truth-cutting", "lathe.truth-bend", "second.truth-bend", "centre.status-code"]

    def work(self):
        self.play(self.turn_on, self.together, self.finish, self.other_offsets, self.stations)

    def note(self, name, value):
        self.facts[name] = value

    def table(self):
        """The offsets of each tool."""
        with open("twin.tbl") as file:
            rows = [{word[0]: float(word[1:]) for word in line.split(";")[0].split()} for line in file]
        return {"T%d" % row["T"]: {axis: row.get(axis, 0) for axis in "XYUV"} for row in rows}

    def offsets(self):
        return self.host.get(["motion.tooloffset." + axis for axis in "xyuv"])

    def turn_on(self):
        self.machine.turn_on()
        self.machine.home()
        self.note("before", self.table())

    def together(self):
        self.machine.run("twin.ngc")
        self.note("after", self.table())
        self.note("in force", self.offsets())

    def finish(self):
        """Both tools turn fresh lands of the bar at once."""
        for block in ("T1 M6 G43", "G43.2 H3", "M3 S1000", "G0 X10 U-10 Y0 V0", "G0 Z6"):
            self.machine.mdi(block)
        for x in (4.6, 4.3, 4):
            for block in ("G1 X%g U%g F200" % (x, -x), "G1 Z4.2", "G0 X10 U-10", "G0 Z6"):
                self.machine.mdi(block)
        self.note("diameters", self.host.get(["lathe.truth-diameter", "second.truth-diameter"]))
        # Where tool 3 has cut, tool 1 meets a bar of 8 mm.
        for block in ("G0 Z32", "G1 X4.5 F200", "G1 Z30.2"):
            self.machine.mdi(block)
        self.note("behind the other", self.host.get("lathe.truth-cutting"))
        self.machine.mdi("G0 X10")

    def other_offsets(self):
        """G43 alone puts the tool of the second slide out of force, between M450 and the cut."""
        for block in ("M450 P1 Q2 D10 E10.6 J1 L3", "G43"):
            self.machine.mdi(block)
        known = len(self.machine.errors)
        with contextlib.suppress(OperatorError):
            self.machine.mdi("M451")
        self.note("other offsets", self.machine.errors[known:])
        self.machine.abort()

    def stations(self):
        """A bar that leans: another height at each Z."""
        self.host.set("tool-height.gain0", 0.0005)
        self.host.set("lathe.cutting-force", 0.5)
        for value in (False, True):
            self.host.set("lathe.new-stock", value)
            self.machine.wait(0.05)
        self.machine.mdi("G10 L1 P1 X-100 Y0")
        self.machine.run("stations.ngc")
        self.note("stations", self.table())


sys.exit(run(Twin, recording="twin.csv"))

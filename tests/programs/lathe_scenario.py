#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of lathe_linuxcnc_test: an operator brings the tools of configs/lathe on centre, by the gauge and by hand."""

import glob
import math
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

STORED = 0.05  # mm, the height of the tool in each conversation by hand


class Shift(Scenario):
    columns = ["scene", "joint.0.pos-cmd", "joint.1.pos-cmd", "joint.2.pos-cmd", "lathe.truth-height", "lathe.truth-cutting"]

    def work(self):
        if sys.argv[-1] == "restart":
            return self.play(self.turn_on, self.restarted)
        self.play(self.turn_on, self.centre_by_gauge, self.behind, self.thin_bar, self.refusals, self.by_hand, self.interrupted, self.second_tool)

    def note(self, name, value):
        self.facts[name] = value

    def table(self):
        """X and Y of each tool."""
        rows = {}
        with open("tool.tbl") as file:
            for line in file:
                words = {word[0]: word[1:] for word in line.split(";")[0].split()}
                rows["T" + words["T"]] = [float(words.get(letter, 0)) for letter in "XY"]
        return rows

    def turned(self, x, z):
        """The true diameter that the tool leaves at Z."""
        for block in ("G0 X12", "G0 Y0", "G0 Z%g" % z, "G1 X%g F300" % x, "G1 Z%g F300" % (z - 0.5), "G0 X12"):
            self.machine.mdi(block)
        return self.host.get("lathe.truth-diameter")

    def refused(self, *blocks):
        """The messages of a block that must fail, the last one."""
        for block in blocks[:-1]:
            self.machine.mdi(block)
        known = len(self.machine.errors)
        try:
            self.machine.mdi(blocks[-1])
            self.machine.wait(0.5)
            self.machine.poll()
        except OperatorError:
            pass
        self.machine.abort()
        return self.machine.errors[known:]

    # --- scenes ---

    def turn_on(self):
        self.machine.turn_on()
        self.machine.home()
        self.machine.mdi("T1 M6 G43")
        self.machine.mdi("M3 S1000")

    def centre_by_gauge(self):
        self.note("before", self.table())
        self.note("turned before", self.turned(4.9, 57))
        self.machine.run("centre.ngc")
        self.note("centred", self.table())
        self.note("copies", len(glob.glob("tool.tbl.*")))
        self.note("on centre", self.host.get("centre.on-centre"))
        self.machine.mdi("M3 S1000")
        self.note("turned after", self.turned(4, 10))

    def behind(self):
        """One program with the tools of two turrets."""
        self.machine.mdi("G10 L1 P1 X-100 Y0")
        self.host.set("lathe.new-stock", True)
        self.machine.run("both.ngc")
        for block in ("T3 M6 G43", "G0 X-10", "G0 Y0", "M3 S1000", "G0 Z20", "G1 X-4 F300", "G0 X-10"):
            self.machine.mdi(block)
        self.note("turned behind", self.host.get("lathe.truth-diameter"))
        self.note("behind", self.table())
        self.host.set("lathe.new-stock", False)
        self.machine.mdi("T1 M6 G43")

    def thin_bar(self):
        """A bar of 1 mm that must finish at 0.06 mm, in a guide bush."""
        host = self.host
        self.machine.mdi("G10 L1 P1 X-100 Y0")
        self.machine.mdi("G43")
        for pin, value in (("stock-diameter", 1.5), ("guide-bush", True), ("cutting-force", 0.01), ("built-up-edge", 0.001), ("new-stock", True)):
            host.set("lathe." + pin, value)
        for pin, value in (("land-step", 0.2), ("cut-repeatability", 0.0003)):
            host.set("centre." + pin, value)
        self.note("thin before", self.turned(0.03, 55))
        for z in (50, 25):
            self.machine.mdi("G0 X12")
            self.machine.mdi("G0 Y0")
            self.machine.mdi("M455 D1.2 Z%g K4 Q2 P100 R6" % z)
            if host.get("centre.move-allowed"):
                self.machine.mdi("M454")
        self.note("thin after", self.turned(0.03, 5))
        # A cone that ends in the axis: the tip passes X0.
        for block in ("G0 X12", "G0 Y0", "G0 Z2", "G1 X0 F100", "G0 X12"):
            self.machine.mdi(block)
        self.note("nib", host.get("lathe.truth-diameter"))

    def refusals(self):
        host = self.host
        self.machine.mdi("G0 X12")
        self.machine.mdi("G10 L1 P1 X-100 Y0")
        self.machine.mdi("G43")
        host.set("lathe.gauge-time", 5e4)  # nobody measures but the operator
        host.set("centre.land-step", 1)
        host.set("centre.cut-repeatability", 0.0012)
        before = self.table()
        self.note("nothing known", self.refused("M454"))
        self.note("compensated", self.refused("G18 G41 D1", "M450 P1 Q2 D10"))
        self.machine.mdi("G40")
        self.note("no cut", self.refused("M450 P1 Q2 D10", "M452 P10"))
        self.first_cut(1)
        self.note("radius", self.refused("M452 P5.1"))
        self.note("inch", self.refused("M450 P1 Q2 D10", "G0 X5 Y1", "M451", "M452 P0.4"))
        self.machine.mdi("M450 P0 Q2 D10")
        for x, diameter in ((5, 10.2), (3, 6.4)):
            self.machine.mdi("G0 X%g Y0" % x)
            self.machine.mdi("M451")
            self.machine.mdi("M452 P%g" % diameter)
        self.note("sign", self.refused("M454"))
        self.note("untouched", self.table() == before)

    def first_cut(self, y):
        self.machine.mdi("M450 P1 Q2 D10")
        self.machine.mdi("G0 X5 Y%g" % y)
        self.machine.mdi("M451")

    def by_hand(self):
        """The same conversation in all units of a program."""
        self.note("hand", [])
        for mode, length in (("G8", "G21"), ("G7", "G21"), ("G8", "G20"), ("G7", "G20")):
            u = 25.4 if length == "G20" else 1
            self.machine.mdi("G8 G21 G0 X12 Y0")
            self.machine.mdi("%s %s" % (mode, length))
            before = self.table()["T1"]
            self.machine.mdi("M450 P1 Q2 D%.6f" % (10 / u))
            for step in (1, -1):
                self.machine.mdi("G0 X%.6f Y%.6f" % ((10 if mode == "G7" else 5) / u, step / u))
                self.machine.mdi("M451")
                self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5.03, step + STORED) / u))
            self.machine.mdi("M454")
            after = self.table()["T1"]
            self.facts["hand"].append([mode, length, after[0] - before[0], after[1] - before[1]])
        self.machine.mdi("G8 G21 G0 X12 Y0")

    def interrupted(self):
        before = self.table()
        self.first_cut(1)
        self.machine.abort()
        self.await_pin("centre.state-code", 5)
        self.machine.mdi("M453")
        self.note("resumed", self.host.get("centre.measure"))
        self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5.03, 1 + STORED)))
        self.note("resumed cuts", self.host.get("centre.cut-number"))
        self.machine.mdi("G0 X5 Y-1")
        self.machine.mdi("M451")
        self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5.03, -1 + STORED)))
        self.note("resumed height", self.host.get("centre.height"))
        self.machine.abort()
        self.await_pin("centre.value-valid", False)
        self.note("after abort", self.refused("M454"))
        self.note("abort left the table", self.table() == before)

    def second_tool(self):
        before = self.table()
        self.machine.mdi("G0 X12 Y0")
        self.machine.mdi("T2 M6 G43")
        self.machine.mdi("M450 P1 Q2 D10")
        for step in (1, -1):
            self.machine.mdi("G0 X5 Y%g" % step)
            self.machine.mdi("M451")
            self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5.03, step + STORED)))
        self.machine.mdi("M454")
        self.note("second", [before, self.table()])

    def restarted(self):
        self.note("offset", self.host.get(["motion.tooloffset.x", "motion.tooloffset.y"]))


sys.exit(run(Shift, recording="shift.csv"))

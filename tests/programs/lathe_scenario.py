#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of lathe_linuxcnc_test: an operator brings the tools of configs/lathe on centre, by the gauge and by hand."""

import contextlib
import glob
import math
import os
import re
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

# Where the lands of M455 are aborted: the motion halts there, by a function of lut5 over its inputs.
TAKEN, CUTTING, MEASURE, VALID = 1, 2, 4, 8
STEPS = {"begun": 0, "first cut": CUTTING, "first measure": None, "between": TAKEN, "second cut": TAKEN | CUTTING}
STEPS |= {"second measure": TAKEN | CUTTING, "known": TAKEN | VALID}

LANDS = "M455 D10 Z58 K4 Q1 P600 R10"
README = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "configs", "lathe", "README.md")
STORED = 0.05  # mm, the height of the tool in each conversation by hand


class Shift(Scenario):
    columns = ["scene", "joint.0.pos-cmd", "joint.1.pos-cmd", "joint.2.pos-cmd", "lathe.truth-height", "lathe.truth-cutting", "lathe.truth-bend"]

    def work(self):
        if sys.argv[-1] == "restart":
            return self.play(self.turn_on, self.restarted)
        if sys.argv[-1] == "two":
            return self.play(self.turn_on, self.two_as_delivered)
        if sys.argv[-1] == "edited":
            return self.play(self.turn_on, self.edited)
        self.play(self.turn_on, self.centre_by_gauge, self.behind, self.thin_bar, self.refusals, self.by_hand, self.interrupted, self.second_tool, self.interrupted_lands, self.by_step, self.bend, self.interrupted_store,
                  self.gauge_stuck, self.not_shown, self.stored_meanwhile, self.from_elsewhere, self.by_readme, self.two_cuts, self.left_in_the_middle)

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
        with open("tool.tbl.copy-%d" % len(glob.glob("tool.tbl.copy-*"))) as last, open("tool.tbl") as table:
            self.note("last copy", last.read().partition("\n")[2] == table.read())
        self.note("on centre", self.host.get("centre.on-centre"))
        self.machine.mdi("M3 S1000")
        self.note("turned after", self.turned(4, 10))

    def behind(self):
        """One program with the tools of two turrets."""
        self.new_lathe()
        self.host.set("lathe.new-stock", True)
        self.machine.run("both.ngc")
        for block in ("T3 M6 G43", "G0 X-10", "G0 Y0", "M3 S1000", "G0 Z20", "G1 X-4 F300", "G1 Z19.5", "G0 X-10"):
            self.machine.mdi(block)
        self.note("turned behind", self.host.get("lathe.truth-diameter"))
        self.note("behind", self.table())
        self.machine.mdi("T4 M6 G43")
        self.note("standing work", self.refused("M5", "M3 S1000", "M455 D10 Z94 K-4 Q2 P200 R10 J2 I1"))
        self.note("no such spindle", self.refused("M455 D10 Z94 K-4 Q2 P200 R10 J2 I4"))
        self.note("incremental", self.refused("M3 $1 S1000", "G91", "M455 D10 Z94 K-4 Q2 P200 R10 J2 I1"))
        self.host.set("lathe.new-stock", False)
        self.machine.mdi("G90 T1 M6 G43 M3 S1000")

    def thin_bar(self):
        """A bar of 1 mm that must finish at 0.06 mm, in a guide bush."""
        host = self.host
        self.machine.mdi("G10 L1 P1 X-100 Y0")
        self.machine.mdi("G43")
        for pin, value in (("stock-diameter", 1.5), ("guide-bush", True), ("cutting-force", 0.001), ("built-up-edge", 0.001), ("new-stock", True)):
            host.set("lathe." + pin, value)
        for pin, value in (("land-step", 0.2), ("cut-repeatability", 0.0003)):
            host.set("centre." + pin, value)
        self.note("thin before", self.turned(0.03, 55))
        for z in (50, 25):
            self.machine.mdi("G0 X12")
            self.machine.mdi("G0 Y0")
            self.machine.mdi("M455 D1.2 Z%g K4 Q2 P100 R6" % z)
            if host.get("centre.move-allowed"):
                self.machine.mdi("M454 D0.4")
        self.note("thin after", self.turned(0.03, 5))
        # A cone that ends in the axis: the tip passes X0.
        for block in ("G0 X12", "G0 Y0", "G0 Z2", "G1 X0 F100", "G1 Z1.5", "G0 X12"):
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
        host.set("centre.largest-burr", 0)  # the operator deburrs
        before = self.table()
        self.note("nothing known", self.refused("M450 P1 Q2 D10", "M454"))
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
        self.machine.mdi("M450 P1 Q2 D10")
        self.machine.mdi("T2 M6 G43")
        self.note("other tool's cut", self.refused("M451"))
        self.machine.mdi("T1 M6 G43")
        self.first_cut(1)
        self.machine.mdi("T2 M6 G43")
        self.note("other tool's diameter", self.refused("M452 P10.2"))
        self.machine.mdi("T1 M6 G43")
        self.note("untouched", self.table() == before)

    def first_cut(self, y):
        self.machine.mdi("M450 P1 Q2 D10")
        self.machine.mdi("G0 X5 Y%g" % y)
        self.machine.mdi("M451")

    def check(self, tip_x, height, mode="G8", u=1):
        """The check that is due, by a tool that stands wrong by so much."""
        if not self.host.get("centre.check-due"):
            return
        x, y = self.host.get(["centre.next-x", "centre.next-y"])
        self.machine.mdi("G0 X%.6f Y%.6f" % (x * (2 if mode == "G7" else 1) / u, y / u))
        self.machine.mdi("M451")
        diameter = 2 * math.hypot(x + tip_x, y + height) / u
        if "one reading" not in self.facts:
            self.note("one reading", self.refused("M452 P%.8f" % diameter))
            self.machine.wait(2)
            self.facts["one reading"] += self.refused("G4 P0.1")  # what the panel shows of it comes later
        self.machine.mdi("M452 P%.8f R%.8f" % (diameter, diameter))

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
            self.check(0.03, STORED, mode, u)
            self.machine.mdi("M454")
            after = self.table()["T1"]
            self.facts["hand"].append([mode, length, after[0] - before[0], after[1] - before[1]])
        self.machine.mdi("G8 G21 G0 X12 Y0")
        self.note("small", [])
        for height in (0.001, 0.012):
            before = self.table()
            self.machine.mdi("G0 X12 Y0")
            self.machine.mdi("M450 P1 Q4 D10")
            for step in (1, -1, -1, 1):
                self.machine.mdi("G0 X5 Y%g" % step)
                self.machine.mdi("M451")
                self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5, step + height)))
            self.check(0, height)
            self.machine.mdi("M454")
            self.facts["small"].append([self.host.get("centre.on-centre"), self.host.get("centre.detail-code"), self.table() == before])
        # Only X is wrong.
        before = self.table()["T1"]
        self.machine.mdi("G0 X12 Y0")
        self.machine.mdi("M450 P1 Q2 D10 E10.6")
        for step in (1, -1):
            self.machine.mdi("G0 X5 Y%g" % step)
            self.machine.mdi("M451")
            self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5.06, step)))
        self.note("unproven", [self.refused("M454"), self.table()["T1"] == before])
        self.machine.mdi("M453")
        self.check(0.06, 0)
        self.machine.mdi("M454")
        self.note("only X", [before, self.table()["T1"]])
        # Not checked for air.
        self.host.set("centre.stock-diameter", 0)
        self.machine.mdi("G0 X12 Y0")
        self.machine.mdi("M450 P1 Q4 D10")
        for step in (1, -1, -1, 1):
            self.machine.mdi("G0 X5 Y%g" % step)
            self.machine.mdi("M451")
            self.machine.mdi("M452 P%.8f" % (2 * math.hypot(5, step)))
        self.check(0, 0)
        self.note("unchecked", self.host.get(["centre.status-code", "centre.on-centre"]))
        self.host.set("centre.stock-diameter", 10.6)
        self.machine.mdi("G0 X12 Y0")

    def interrupted(self):
        before = self.table()
        self.first_cut(1)
        self.machine.abort()
        self.await_pin("centre.status-code", 48)
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
        self.check(0.03, STORED)
        self.machine.mdi("M454")
        self.note("second", [before, self.table()])

    def halt(self, inputs):
        """Halts all motion while these inputs of lut5, and no others, are true; None: never."""
        self.host.set("lut5.0.function", 0 if inputs is None else 1 << inputs)

    def begin_lands(self, halt=None, words=LANDS):
        """Two lands of a new bar, which halt there."""
        self.machine.mdi("G8 G21 G0 X10 Y0 M3 S1000")
        for value in (False, True, False):
            self.host.set("lathe.new-stock", value)
            self.machine.wait(0.05)
        self.machine.mdi("M450 P1 Q2 D11")  # forgets the cuts before, which would halt it at once
        self.halt(halt)
        self.machine.mdi(words, wait=False)

    def interrupted_lands(self):
        """M455 is aborted at every step; M453 continues it, or M455 begins it again."""
        machine, host = self.machine, self.host
        host.command("loadrt conv_s32_bit names=taken")
        host.command("loadrt lut5")
        host.command("unlinkp motion.feed-inhibit")  # motion.feed-hold keeps that of interlock
        for line in ("centre.cut-number taken.in", "taken.out lut5.0.in-0", "lathe.truth-cutting lut5.0.in-1", "lut5.0.out motion.feed-inhibit"):
            host.command("net halt-%s %s" % (line.split()[0].replace(".", "-"), line))
        host.command("net height-measure lut5.0.in-2")
        host.command("net height-valid lut5.0.in-3")
        host.command("addf taken servo-thread")
        host.command("addf lut5.0 servo-thread")
        for pin, value in (("stock-diameter", 10.6), ("guide-bush", False), ("cutting-force", 5), ("built-up-edge", 0.001)):
            host.set("lathe." + pin, value)
        self.fresh_tool()
        table = self.table()
        self.note("steps", {})
        for step, inputs in STEPS.items():
            its = self.facts["steps"][step] = {}
            host.set("lathe.gauge-time", 5e4 if step == "first measure" else 0.05)
            self.begin_lands(inputs)
            self.await_condition(lambda: self.has_come(step), step)
            if step == "second measure":
                host.set("lathe.gauge-time", 5e4)
                self.halt(None)
                self.await_condition(lambda: host.get(["centre.measure", "centre.cut-number"]) == [True, 1], step)
            machine.abort()
            self.await_pin("centre.status-code", 48)
            self.halt(None)
            its["idle"] = host.get(["centre.value-valid", "centre.move-allowed", "centre.measure"])
            its["store"] = self.refused("M454")
            its["table"] = self.table() == table
            host.set("lathe.gauge-time", 0.05)
            if step in ("between", "known"):
                its["stopped spindle"] = self.refused("M5", "M453") if step == "between" else []
                machine.mdi("M3 S1000")
            if step == "second cut":
                self.begin_lands()
                machine.wait_until_idle()
            else:
                machine.mdi("M3 S1000")
                machine.mdi("M453")
            its["end"] = host.get(["centre.cut-number", "centre.height", "centre.move-allowed"])
        # In the operator's units.
        machine.mdi("G7 G20")
        self.halt(CUTTING)
        machine.mdi("M455 D0.39 Z2 K0.15 Q1 P20 R0.4", wait=False)
        self.await_pin("lathe.truth-cutting", True)
        machine.abort()
        self.halt(None)
        self.await_pin("centre.status-code", 48)
        self.note("units after an abort", [code / 10 for code in machine.poll().gcodes])
        machine.mdi("G8 G21")
        machine.mdi("T2 M6 G43 M3 S1000")
        self.note("other tool", self.refused("M453"))
        machine.mdi("T1 M6 G43 M3 S1000")

    def has_come(self, step):
        """Whether the machine waits at this step."""
        inputs = self.host.get(["centre.cut-number", "lathe.truth-cutting", "centre.measure", "centre.value-valid"])
        taken, *others = inputs
        wanted = MEASURE if STEPS[step] is None else STEPS[step]
        if step == "begun" and self.host.get(["centre.status-code", "motion.analog-out-12"]) != [41, 10]:  # D of M455, not of M450
            return False
        return sum(1 << k for k, bit in enumerate([taken > 0, *others]) if bit) in (wanted, wanted | CUTTING)

    def fresh_tool(self):
        """Tool 1 as at the beginning, and a new bar."""
        self.machine.mdi("T1 M6")
        self.machine.mdi("G10 L1 P1 X-100 Y0")
        self.machine.mdi("G43 G0 X10 Y0")
        for value in (False, True, False):
            self.host.set("lathe.new-stock", value)
            self.machine.wait(0.05)

    def by_step(self):
        self.new_lathe()
        self.host.set("centre.largest-burr", 0.04)  # as delivered
        self.machine.run("step.ngc")
        self.note("by step", self.table()["T1"])
        self.host.set("centre.largest-burr", 0)
        # A tool that is 0.4 mm wrong in X touches no bar.
        self.fresh_tool()
        for block in ("G10 L1 P1 X-99.6 Y0", "G43", "G0 X10 Y0", "M3 S1000"):
            self.machine.mdi(block)
        self.note("air", self.refused(LANDS + " E10.6"))
        self.note("air on centre", self.host.get("centre.on-centre"))
        self.fresh_tool()
        self.host.set("centre.least-load", 2.1)
        self.note("load", self.refused("M3 S1000", "M450 P1 Q2 D10 E10.6", "M451"))
        self.begin_lands()
        self.machine.wait_until_idle()
        self.note("load of a cut", self.host.get("centre.detail-code"))
        self.host.set("centre.least-load", 0)

    def bend(self):
        """The height under the cut, then by spring passes."""
        self.host.set("lathe.cutting-force", 10)
        self.fresh_tool()
        for words in ("", " H3"):
            self.begin_lands(None, LANDS + words)
            self.machine.wait_until_idle()
            self.facts["bend" + words] = self.host.get(["centre.height", "centre.bend", "centre.detail-code"])
            self.facts["known" + words] = self.host.get("centre.bend-known")
        self.note("at rest", self.refused("M454"))
        self.host.set("lathe.cutting-force", 5)

    def interrupted_store(self):
        """M454 is aborted at any moment: the table is the old one or the new one, and the height is never stored twice."""
        self.note("stores", [])
        for delay in (0, 0.02, 0.1, 0.3, None):
            self.fresh_tool()
            self.begin_lands()
            self.machine.wait_until_idle()
            before, x, y = self.table(), *self.host.get(["centre.x-correction", "centre.y-move"])
            self.machine.mdi("M454", wait=delay is None)
            self.machine.wait(delay or 0)
            self.machine.abort()
            self.machine.wait(0.2)
            for _ in range(2):
                self.refused("G43", "M453")
                self.refused("M454")
            self.facts["stores"].append([before["T1"], self.table()["T1"], x, y])

    def measured_bar(self):
        """A new bar and tool 1, by the gauge, as delivered."""
        self.new_lathe()
        self.host.set("centre.largest-burr", 0.04)
        self.host.set("lathe.gauge-time", 0.05)
        self.machine.mdi("M3 S1000")

    def gauge_stuck(self):
        """The gauge stands at the first land: each land has the same diameter, as by a tool on centre."""
        self.measured_bar()
        before = self.table()
        self.host.set("lathe.gauge-z", 57)
        texts, seen = [], []
        for z in (58, 45, 32):
            self.machine.mdi("G0 X10 Y0")
            texts += self.refused("M455 D10 E10.6 Z%d K3 Q2 P600 R10" % z)
            seen.append(self.host.get(["centre.on-centre", "centre.move-allowed", "centre.x-allowed", "centre.detail-code"]))
            self.refused("M454")
            self.machine.mdi("G0 X10 Y0 M3 S1000")
        self.note("stuck", [texts, seen, self.table() == before])
        self.host.set("lathe.gauge-z", -1)

    def not_shown(self):
        """The edge chips between the last land and the store, by 50 um."""
        self.measured_bar()
        before = self.table()
        self.machine.mdi("M455 D10 E10.6 Z58 K3 Q2 P600 R10")
        self.host.set("mux-gen.01.in-float-01", 0.15)
        known = len(self.machine.errors)
        self.machine.mdi("M454 D9.6", wait=False)
        self.await_condition(lambda: self.machine.poll() and any("former values again" in text for text in self.machine.errors[known:]), "the end of the take-back")
        for _ in range(2):  # errors that were told meanwhile
            with contextlib.suppress(OperatorError):
                self.machine.wait_until_idle()
        texts = self.machine.errors[known:]
        self.note("not shown", [texts, [before, self.table()], self.host.get(["motion.tooloffset.x", "motion.tooloffset.y", "joint.0.pos-cmd"])])
        self.host.set("mux-gen.01.in-float-01", 0.1)

    def stored_meanwhile(self):
        """Somebody corrects X after the lands."""
        self.measured_bar()
        self.machine.mdi("M455 D10 E10.6 Z58 K3 Q2 P600 R10")
        self.machine.mdi("G10 L1 P1 X-100.05")
        x, y = self.host.get(["centre.x-correction", "centre.y-move"])
        known = len(self.machine.messages)
        texts, between = self.refused("M454"), self.table()["T1"]
        texts += self.machine.messages[known:]
        self.machine.mdi("M453")
        self.machine.mdi("M454 P1")
        self.note("meanwhile", [texts, between, x, y, self.table()["T1"]])

    def from_elsewhere(self):
        """A height that was worked out elsewhere."""
        self.measured_bar()
        for block in ("M450 P4 Q1", "M452 P0.0321", "M454"):
            self.machine.mdi(block)
        self.note("elsewhere", self.table()["T1"])

    def lines_of_readme(self, heading):
        with open(README) as file:
            section = file.read().split("## " + heading, 1)[1].split("\n## ", 1)[0]
        return re.findall(r"^    (?!plumb)(.*)$", section, re.M)

    def follow(self, line):
        """A line of the README, word by word; only the diameter is the one that a micrometer shows."""
        if line.startswith("halcmd"):
            self.host.command(line.partition(" ")[2])
            self.machine.wait(0.05)
        elif line.startswith("M452 P"):
            self.machine.wait(0.3)
            self.facts["standing"].append(self.host.get("spindle.0.on"))
            self.machine.mdi(re.sub(r"[\d.]+", "%.3f" % self.host.get("lathe.truth-diameter"), line.replace("M452", "M_")).replace("M_", "M452"))
        else:
            self.machine.mdi(line)

    def new_lathe(self):
        """A cold machine, and a tool without wear."""
        for seed in (1, 0):
            self.host.set("lathe.seed", seed)
            self.machine.wait(0.05)
        self.fresh_tool()

    def by_readme(self):
        self.new_lathe()
        self.host.set("centre.largest-burr", 0.04)
        self.note("readme before", self.table()["T1"])
        self.note("standing", [])
        for line in self.lines_of_readme("By hand"):
            self.follow(line)
        self.note("readme", self.table()["T1"])

    def two_as_delivered(self):
        """two.ini starts with its bar, and nothing is typed."""
        self.machine.run("two.ngc")
        self.note("two as delivered", [self.table()["T1"], self.host.get("centre.shown")])

    def two_cuts(self):
        """A bar of 1 mm, a tool 0.03 mm low: claim 1 of the source."""
        self.new_lathe()
        self.host.set("lathe.gauge-time", 0.2)
        with open("two_machine.hal") as file:
            for line in re.findall(r"^setp .*", file.read(), re.M):
                self.host.command(line)
        self.machine.wait(0.05)
        self.machine.mdi("M3 S1000")
        self.note("two before", self.turned(0.03, 58))
        self.machine.run("two.ngc")
        self.note("two", self.table()["T1"])
        self.machine.mdi("T1 M6 G43 M3 S1000")
        self.note("two after", self.turned(0.03, 20))
        for side in (-1, 1):
            for block in ("G0 X4 Y0", "M450 P0 Q2 E1 K%d" % side):
                self.machine.mdi(block)
            self.note("word %d" % side, self.host.get(["centre.program-sign", "centre.fault", "axis.y.pos-cmd"]))
        self.note("axis word", [self.refused("M450 P0 Q2 E1 Y1"), self.host.get("axis.y.pos-cmd")])
        self.note("lands need D", self.refused("M450 P1 Q2"))

    def left_in_the_middle(self):
        self.host.set("lathe.gauge-time", 5e4)
        self.machine.mdi("G10 L1 P2 X-115.01")  # wear
        self.machine.wait(12)  # for the copy; tool_table_check looks every 0.5 s of the clock
        self.note("at the end", self.table())
        self.first_cut(1)

    def restarted(self):
        self.note("state", self.host.get(["centre.cut-number", "centre.value-valid", "centre.measure"]))
        self.turn_on()
        self.note("nothing to continue", self.refused("M453"))
        self.note("nothing to store", self.refused("M454"))
        self.note("asks", self.host.get(["tool-table.asks", "centre.status-code"]))
        self.note("restarted", self.table())
        self.note("offset", self.host.get(["motion.tooloffset.x", "motion.tooloffset.y"]))


    def edited(self):
        """An editor has written the table while LinuxCNC was off."""
        self.await_condition(lambda: self.machine.poll() and any("T2 was X-115.01, is X-115.02" in text for text in self.machine.errors), "the row, old and new")
        self.note("edited", self.host.get(["tool-table.asks", "centre.status-code"]))
        self.machine.mdi("M450 P4 Q1")
        self.machine.mdi("M452 P0.02")
        self.note("edited store", self.refused("M454"))
        self.machine.mdi("M159 P1")
        self.await_pin("tool-table.asks", False)
        self.note("edited table", self.table()["T2"])


sys.exit(run(Shift, recording="shift.csv"))

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of lathe_panel_linuxcnc_test: brings a tool on centre by the tab of AXIS and a micrometer, and ends AXIS."""

import json
import os
import subprocess
import sys
import traceback

import plumb
from plumb_linuxcnc import Machine
from screen import Finger

seen = {}


class Operator:
    def __init__(self, machine):
        self.machine, self.host = machine, machine.host
        self.finger = Finger(os.environ["DISPLAY"], "widgets.json", lambda: machine.wait(0.05))

    def positions(self):
        return self.host.get(["joint.%d.pos-cmd" % joint for joint in range(3)])

    def jogged(self, axis, key):
        """How far X, Y and Z move by a press of + or - in AXIS."""
        before = self.positions()
        self.finger.jog(axis, key)
        self.machine.wait(1)
        return [round(now - then, 6) for now, then in zip(self.positions(), before)]

    def jog_before_homing(self):
        self.finger.until(lambda: self.finger.fill("AXIS 2"), "AXIS")
        for on in (False, True):  # a screen that has just come loses keys
            self.finger.until(lambda on=on: self.host.get("motion.motion-enabled") == on or self.switch(), "the machine's power")
        self.finger.jog("i")  # by 1 mm
        seen["jogged unhomed"] = self.jogged("y", "equal")

    def switch(self):
        self.finger.jog("F2")
        self.machine.wait(2)

    def until(self, pin, value):
        self.finger.until(lambda: self.host.get(pin) == value, "%s = %s" % (pin, value))

    def work(self):
        self.finger.find_tab("AXIS 2", [(x, y) for y in (76, 90, 100, 64) for x in range(420, 1280, 36)])
        # The operator measures, and no gauge.
        self.host.command("unlinkp centre.value-ready")
        self.host.set("lathe.micrometer", True)
        self.host.set("lathe.micrometer-noise", 0)
        self.host.set("centre.largest-burr", 0)  # the operator deburrs: a pair alone shows no burr
        seen["before"] = self.tool()
        self.machine.mdi("T1 M6 G43")
        self.machine.mdi("M3 S1000")
        self.machine.mdi("G0 X12 Y0")
        self.finger.open("Centre height", "Two lands")
        self.count_presses()
        with self.finger.story("tool on centre: measure the height"):
            self.measure(58, 2)
        seen["height"] = self.host.get("centre.height")
        seen["truth"] = self.host.get("lathe.truth-height")
        self.finger.await_text("Store the height. Then move Y to 0")
        seen["off centre"] = self.finger.await_text("of the tool are wrong")
        seen["ticks"] = self.finger.find_text("\u2714")
        self.shot("lathe_known.png")
        with self.finger.story("tool on centre: store the height"):
            self.finger.press("Store the height: M454")
            self.finger.press("Store the height")
            self.finger.until(lambda: self.tool() != seen["before"], "the corrected tool table")
        self.enter_land()
        self.until("centre.status-code", 54)
        seen["shown"] = self.finger.await_text("A land shows the stored height.")
        seen["after"] = self.tool()
        self.machine.wait_until_idle()
        for value in (True, False):
            self.host.set("lathe.new-stock", value)
            self.machine.wait(0.1)
        self.presses = 0
        self.measure(58, 8)  # fewer do not know it well enough
        seen["verdict"] = self.finger.await_text("The tool is on centre.")
        seen["presses"] = self.presses
        self.interrupt()
        self.refuse()
        self.shot("lathe_centred.png")

    def interrupt(self):
        """In the middle of a measurement."""
        finger = self.finger
        self.machine.mdi("G0 X12 Y0")
        self.machine.mdi("G0 Z30")
        self.machine.mdi("M3 S1000")
        self.begin(2)
        finger.press("Interrupt")
        seen["interrupted"] = [finger.await_text("The measurement is interrupted."), "\u2714" in finger.texts()]

    def refuse(self):
        """A first land whose diameter is taken back, and lands and checks that have one diameter."""
        finger = self.finger
        for value in (True, False):
            self.host.set("lathe.new-stock", value)
            self.machine.wait(0.1)
        self.machine.mdi("G0 X12 Y0")
        self.machine.mdi("M3 S1000")
        self.begin(4)
        for cut in range(1, 9):
            self.until("centre.measure", True)
            self.machine.wait_until_idle()
            finger.press("Enter the diameter")
            self.type_diameter("10.2")
            finger.until(lambda cut=cut: self.host.get("centre.status-code") == 47 or self.host.get("centre.cut-number") == cut, "the entry")
            if self.host.get("centre.status-code") == 47:
                break
            self.machine.wait_until_idle()
            if cut == 1:
                self.take_first_back("10.2")
            finger.press("Turn the next land")
        self.machine.wait(2)  # for the abort by which LinuxCNC tells of it
        seen["no height"] = [finger.await_text("The cuts give no height."), "\u2714" in finger.texts()]

    def count_presses(self):
        """As an operator counts them: a press that a busy screen loses, or one within the keypad, is not another one."""
        self.presses, press, type_ = 0, self.finger.press, self.finger.type

        def count(presses, act, *words):
            before = self.presses
            act(*words)
            self.presses = before + presses

        self.finger.press = lambda *words: count(1, press, *words)
        self.finger.type = lambda text: count(len(text), type_, text)

    def begin(self, lands):
        finger = self.finger
        finger.press("Two lands")
        finger.press("%d cuts" % lands)
        finger.type("10")
        finger.press("Next")
        finger.type("10.6")
        finger.press("Begin")
        self.until("centre.status-code", 42)
        self.machine.wait_until_idle()

    def enter_land(self, off=0.0):
        """The land that stands: the spindle has stopped, and X is clear."""
        self.machine.wait_until_idle()
        diameter = self.micrometer()
        seen.setdefault("standing", []).append(self.host.get("spindle.0.on"))
        seen.setdefault("clear", []).append(self.host.get("joint.0.pos-cmd") + 100)
        self.finger.press("Enter the diameter")
        seen["before the entry"] = self.finger.find_text("which a tool on centre leaves")
        self.type_diameter("%.3f" % (diameter + off))
        return diameter

    def type_diameter(self, text):
        """Once, or for a check twice: at two angles."""
        twice = self.host.get("centre.reads-twice")
        self.finger.type(text)
        self.finger.press("Enter")
        if twice:
            seen.setdefault("second reading", self.finger.await_text("a quarter turn further"))
            self.finger.type(text)
            self.finger.press("Enter")

    def measure(self, z, lands):
        """Lands, each turned by the machine and measured by the micrometer, and the check."""
        finger = self.finger
        self.machine.mdi("G0 X12 Y0")
        self.machine.mdi("G0 Z%g" % z)
        self.machine.mdi("M3 S1000")
        self.begin(lands)
        for land in range(1, lands + 1):
            self.until("centre.measure", True)
            if land == 1 and lands == 2:
                finger.press("Enter the diameter")
                for key, words in (("5.1", "That is the radius"), ("0.4", "That is in inches")):
                    finger.type(key)
                    finger.press("Enter")
                    finger.await_text(words)
                    finger.press("Clear")
                finger.type("15")
                finger.press("Enter")
                seen["refused"] = finger.await_text("\"15\" was not entered")
                seen["state"] = self.host.get("centre.status-code")
                finger.press("Back")
            wrong = -0.1 if land == 1 and lands == 2 else 0  # 10.172 for 10.272
            first = self.enter_land(wrong) if land == 1 else self.enter_land() and first
            if land == 1:
                seen["one entry"] = finger.await_text("which a tool on centre leaves")
            elif land == 3:
                seen["twin"] = finger.await_text("at the same Y")
            self.until("centre.cut-number", land)
            self.machine.wait_until_idle()
            if land < lands:
                finger.press("Turn the next land")
        if lands == 2:
            with finger.story("wrong entry"):
                self.correct(1, round(first, 3) - 0.1, round(first, 3))
            self.take_back(round(first, 3) - 0.1)
        self.until("centre.status-code", 53)
        finger.press("Turn the next land")
        self.until("centre.measure", True)
        self.enter_land()
        self.until("centre.measure", False)
        self.until("centre.value-valid", True)

    def correct(self, cut, wrong, right):
        """The list of entries has the wrong one; the right one takes its place, and the height is another."""
        finger, before = self.finger, self.host.get("centre.height")
        finger.press("Correct cut %d" % cut)
        seen["entered before"] = finger.await_text("Entered before: %s" % ("%.6g" % round(wrong, 4)))
        finger.type("%.4f" % right)
        finger.press("Enter")
        finger.until(lambda: abs(self.host.get("centre.height") - before) > 0.02, "the height of the right diameter")
        self.machine.wait_until_idle()

    def take_back(self, wrong):
        """Undo of an accepted diameter, and of the undo."""
        finger, right = self.finger, self.host.get("centre.height")
        finger.press("Changes")
        finger.press("Undo MDI")
        seen["undo"] = finger.await_text("Undo by M452")
        finger.press("Undo")
        finger.until(lambda: abs(self.host.get("centre.height") - right) > 0.02, "the height of the wrong diameter")
        self.machine.wait_until_idle()
        finger.press("Centre height")
        self.correct(1, wrong + 0.1, wrong + 0.1)

    def take_first_back(self, diameter):
        """Undo of a diameter that had none before it: the cut waits for it again."""
        finger = self.finger
        finger.press("Changes")
        finger.press("Undo MDI")
        seen["undo of the first"] = finger.await_text("Undo by M452")
        finger.press("Undo")
        self.until("centre.measure", True)
        self.machine.wait_until_idle()
        finger.press("Centre height")
        finger.until(lambda: not finger.find("Correct cut 1"), "the list of diameters without it")
        finger.press("Enter the diameter")
        finger.type(diameter)
        finger.press("Enter")
        self.until("centre.cut-number", 1)
        self.machine.wait_until_idle()

    def micrometer(self):
        self.until("lathe.value-ready", True)
        return self.host.get("lathe.diameter")

    def tool(self):
        """X and Y of tool 1 in the table."""
        self.finger.until(self.tool_line, "tool 1 in the table, which LinuxCNC writes anew")
        words = self.tool_line().split(";")[0].split()
        return [float(next((word[1:] for word in words if word[0] == letter), 0)) for letter in "XY"]

    def tool_line(self):
        with open("tool.tbl") as file:
            return next((line for line in file if line.startswith("T1 ") and line.endswith("\n")), "")

    def shot(self, name):
        if "--shots" in sys.argv:
            self.finger.shot(name)


try:
    with Machine() as its:
        operator = Operator(its)
        its.turn_on()
        operator.jog_before_homing()
        its.home()
        seen["jogged homed"] = operator.jogged("y", "equal")
        its.mdi("G0 Y0")
        operator.work()
        seen["done"] = True
except (AssertionError, RuntimeError, plumb.Refused, subprocess.SubprocessError):
    seen["error"] = traceback.format_exc()
finally:
    with open("seen.json", "w") as file:
        json.dump(seen, file)
    subprocess.run(["axis-remote", "--quit"], check=False)
sys.exit(0)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of mill_panel_linuxcnc_test: works the mill by the tab of AXIS, and ends AXIS."""

import json
import os
import subprocess
import sys
import traceback

import plumb
from plumb_linuxcnc import Machine
from axis_popups import popups
from panel_traps import enter_an_incomplete_lean, lose_a_sensor, stop_in_the_form
from screen import Finger

TABS = range(40, 1280, 36)  # px, where the tab may be
seen = {}


class Operator:
    def __init__(self, machine):
        self.machine, self.host = machine, machine.host
        self.finger = Finger(os.environ["DISPLAY"], "widgets.json", lambda: machine.wait(0.05))

    def until(self, pin, value):
        self.finger.until(lambda: self.host.get(pin) == value, "%s = %s" % (pin, value))

    def open_tab(self):
        """Presses along the row of tabs, behind those of AXIS's left side, until the panel is seen."""
        self.finger.find_tab("AXIS 2", [(x, y) for y in (76, 90, 100, 64) for x in TABS if x > 400])

    def morning(self):
        """Squareness corrects nothing in the emergency stop, while the machine is off, and before it is homed."""
        finger = self.finger
        finger.open("Squareness", "Measure and set up")
        seen["asleep"] = [finger.await_text("The machine is off. Turn")]
        self.machine.turn_on()
        seen["asleep"].append(finger.await_text("The machine is not homed. Home"))
        seen["asleep ticks"] = "\u2714" in finger.texts()
        seen["asleep applied"] = self.host.get("x-stage.applied-offset")
        self.machine.home()

    def take_the_request_back(self):
        """A request to learn, by the list of changes."""
        finger = self.finger
        finger.press("Learn from the next part")
        finger.press("Learn")
        self.until("growth.learn", True)
        self.machine.wait_until_idle()
        finger.press("Changes")
        finger.press("Undo MDI")
        finger.press("Undo")
        self.until("growth.learn", False)
        self.machine.wait_until_idle()
        finger.press("Growth of Z")

    def first_day(self):
        finger = self.finger
        finger.open("Growth of Z", "Learn from the next part")
        self.take_the_request_back()
        with finger.story("teach and break the load"):
            self.teach()
        finger.press("Switch on / off")
        finger.press("Switch off")
        self.until("growth.enabled", False)
        finger.await_text("Switched off.")
        finger.press("Switch on / off")
        finger.press("Switch on")
        self.until("growth.enabled", True)
        finger.press("All components")
        finger.press("growth")
        finger.press("gate-floor")
        finger.press("Clear")
        finger.type("0.025")
        finger.press("Save")
        self.until("growth.gate-floor", 0.025)
        finger.until(lambda: "growth.gate-floor" in read("panel.retained"), "the saved setting")
        with finger.story("square a mill"):
            self.square()
        self.attack_a_paused_program()
        self.machine.turn_off()
        with finger.story("why does it not act"):
            finger.press("Overview")
            finger.await_text("The machine is off. Turn")
            finger.press("Squareness")
            seen["off"] = finger.await_text("The machine is off. Turn")
        finger.press("Growth of Z")
        finger.press("Switch on / off")
        finger.press("Switch off")
        self.until("growth.enabled", False)
        finger.press("Switch on / off")
        seen["refused"] = finger.await_text("Switch on: refused. The machine is off.")
        self.host.set("interlock.function-switch-0", True)

    def teach(self):
        """A reference on the cold machine; then the load is lost, and comes back."""
        finger = self.finger
        finger.press("Learn from the next part")
        finger.press("Learn")
        self.until("growth.learn", True)
        finger.await_text("Learns from the next part.")
        self.machine.run("setup.ngc")
        finger.until(self.learns_part, "the reference")
        self.until("growth.learn", False)
        seen["reference"] = finger.await_text("Valid, with")
        self.host.set("growth.load-valid", False)
        seen["load lost"] = finger.await_text("The load is lost: its sensor reports no valid value.")
        finger.press("Overview")
        finger.await_text("The load is lost: its sensor reports no valid value.")
        self.host.set("growth.load-valid", True)
        finger.press("Growth of Z")
        finger.until(lambda: not finger.find_text("The load is lost"), "the load")

    def learns_part(self):
        """AXIS may take the mode back as the program begins, and then no part is made."""
        self.machine.run("part.ngc")
        self.machine.wait(2)
        return self.host.get("growth.reference-valid") and not self.host.get("growth.learn")

    def square(self):
        """From the picture of the leaning machine to saved angles: one lean of Y, then the other, which remained."""
        finger = self.finger
        seen["leaning"] = self.errors_along_y()
        self.lean("Y EC0Y", "Y leans to +X", "0.048")
        finger.await_text("EC0Y  160 \u00b5m/m to +X")
        finger.press("Test move")
        finger.await_text("before: +48.0 \u00b5m   after: 0.0 \u00b5m")
        finger.await_text("if EC0Y has the wrong sign: +96.0 \u00b5m")
        self.save()
        self.until("square.ec0y", -0.00016)
        self.until("square.ea0y", 0)
        finger.await_text("Corrects the tilts that were measured.")
        self.lean("Y EA0Y", "Y leans to +Z", "0.036")
        finger.await_text("EA0Y  120 \u00b5m/m to +Z")
        finger.press("Test move")
        self.save()
        self.until("square.ea0y", 0.00012)
        self.until("square.ec0y", -0.00016)
        finger.until(lambda: '"square.ea0y" = 0.00012' in read("panel.retained"), "the saved angle")

    def lean(self, lean, direction, rise):
        """A lean of Y in mm over 300 mm, up to what it will do."""
        finger = self.finger
        finger.open("Squareness", "Measure and set up")
        finger.open("Measure and set up", "w-Z.b-X-Y-C-t")
        finger.open("w-Z.b-X-Y-C-t", lean)
        finger.open(lean, direction)
        finger.press(direction)
        finger.type(rise)
        finger.press("Enter")
        finger.press("What it will do")

    def save(self):
        self.finger.press("Save")
        self.finger.press("Save the angles")

    def attack_a_paused_program(self):
        """A setting that moves an axis, and its undo, are refused in a paused program; switching off works, says the moves, and holds the
        offset until the program ends."""
        finger, host = self.finger, self.host
        self.machine.mdi("G53 G0 Y100")
        self.machine.wait(2)
        with open("pause.ngc", "w") as file:
            file.write("M0\nM2\n")
        self.machine.start("pause.ngc")
        finger.until(lambda: host.get("halui.program.is-paused"), "the paused program")
        before = host.get("x-stage.applied-offset")
        finger.open("Squareness", "All pins and settings")
        finger.press("All pins and settings")
        finger.press("ec0y")
        finger.press("Clear")
        finger.type("0.001")
        finger.press("Save")
        seen["paused"] = finger.await_text("A program is paused.")
        self.correct_what_moves_nothing()
        finger.open("Squareness", "All pins and settings")
        finger.press("All pins and settings")
        finger.press("ec0y")
        finger.press("Undo the last change")
        finger.await_text("Undo: refused. A program is paused.")
        self.machine.wait(1)
        seen["moved in the pause"] = host.get("x-stage.applied-offset") - before
        finger.press("Squareness")
        finger.press("Switch on / off")
        seen["announced"] = finger.await_text("It moves: X ")
        finger.press("Switch off")
        self.until("interlock.function-switch-1", False)
        finger.await_text("Switched off: the offset holds until the tool is clear, and then returns.")
        self.machine.wait(1)
        seen["held"] = host.get("x-stage.applied-offset") - before
        self.machine.abort()
        self.until("square.enabled", False)
        finger.await_text("Switched off.")
        finger.until(lambda: abs(host.get("x-stage.applied-offset")) < 1e-6, "X without its correction")
        seen["moved"] = host.get("x-stage.applied-offset") - before
        finger.press("Switch on / off")
        finger.press("Switch on")
        self.until("square.enabled", True)
        finger.await_text("Corrects the tilts that were measured.")
        seen["waiting"] = finger.find_text("Homing waits")

    def correct_what_moves_nothing(self):
        """It always works."""
        finger = self.finger
        for name in ("All components", "growth", "gate-floor", "Clear"):
            finger.press(name)
        finger.type("0.03")
        finger.press("Save")
        self.until("growth.gate-floor", 0.03)
        finger.press("Undo the last change")
        self.until("growth.gate-floor", 0.025)

    def errors_along_y(self):
        """Change of the tip's error in X and Z from Y-150 to Y150, in um."""
        found = []
        for y in (-150, 150):
            self.machine.mdi("G53 G0 Y%d" % y)
            self.machine.wait(2)
            found.append(self.host.get(["portal.truth-x-error", "portal.truth-z-error"]))
        self.machine.mdi("G53 G0 Y0")
        return [1000 * (after - before) for before, after in zip(*found)]

    def residual(self):
        """A square machine with a residual of 1 um: its lean is saved, and the others stay."""
        finger, host = self.finger, self.host
        others = ["square.ea0z", "square.eb0z", "square.eb0x", "square.axis-direction", "square.ea0y"]
        before = host.get(others)
        self.lean("Y EC0Y", "Y leans to +X", "0.001")
        finger.press("Test move")
        self.save()
        finger.until(lambda: host.get("square.ec0y") != -0.00016, "the saved residual")
        seen["residual"] = host.get("square.ec0y")
        seen["others"] = [before, host.get(others)]
        seen["with residual"] = self.errors_along_y()
        finger.press("Changes")
        finger.press("Undo square.ec0y")  # without a question: at Y0 it moves nothing
        self.until("square.ec0y", -0.00016)

    def another_chain(self):
        """A table in X and Y: its lean of Y to X corrects nothing, and squares come first. Between the saved chain and the restart nothing is
        switched on."""
        finger, host = self.finger, self.host
        finger.open("Squareness", "Measure and set up")
        finger.open("Measure and set up", "w-X-Y.b-Z-C-t")
        finger.open("w-X-Y.b-Z-C-t", "Square and indicator")
        seen["why not"] = finger.await_text("Y turns all that it carries with it")
        seen["offered"] = bool(finger.find("Y EC0Y"))
        for name in ("Square and indicator", "Axis Y", "Plunger +X", "Indicator reads more, \u00b5m"):
            finger.press(name)
        finger.type("48")
        finger.press("Enter")
        finger.press("What it will do")
        seen["after"] = finger.await_text("straightness not included")
        finger.press("Test move")
        self.save()
        finger.await_text("LinuxCNC runs with w-Z.b-X-Y-C-t: start LinuxCNC again.")
        self.until("square.enabled", False)
        finger.press("Switch on / off")
        seen["new chain"] = finger.await_text("Switch on: refused. The chain w-X-Y.b-Z-C-t is saved")
        finger.press("Changes")
        finger.press("Undo [SQUARENESS]CHAIN")
        finger.press("Undo")
        finger.until(lambda: host.get(["square.ec0y", "square.ea0y"]) == [-0.00016, 0.00012], "the angles of before")
        self.until("square.enabled", True)  # which is part of the deed

    def hold_a_message_back(self):
        """What the panel shows waits behind the question of the panel, and comes when another tab is in front."""
        finger, host = self.finger, self.host
        host.command("loadusr -Wn lamp %s" % os.path.join(os.path.dirname(os.path.abspath(__file__)), "lamp.py"))
        finger.open("Growth of Z", "Learn from the next part")
        finger.press("Learn from the next part")
        finger.await_text("The machine must be cold")
        before = popups()

        def come():
            return [text for text in popups() if text not in before]

        host.set("lamp.status", 2)
        self.machine.wait(5)
        seen["in front"] = [bool(finger.find_text("The machine must be cold")), come()]
        finger.until(self.leaves_the_tab, "another tab in front")
        finger.until(lambda: any("The lamp flickers" in text for text in come()), "the message")
        host.set("lamp.status", 0)
        host.set("axisui.notifications-clear", True)  # it would lie over the panel
        finger.until(lambda: not popups(), "AXIS without messages")
        self.open_tab()
        finger.press("Cancel")

    def leaves_the_tab(self):
        for x in TABS:
            if x > 400 and self.finger.is_seen():
                self.finger.press_at(x, 76)
                self.machine.wait(0.5)
        return not self.finger.is_seen()

    def learn_and_undo(self):
        """A new reference takes the place of a good one, and is taken back."""
        finger, host = self.finger, self.host
        former = self.reference()
        finger.press("Learn from the next part")
        seen["replaces"] = finger.await_text("Learn from the next part?")
        finger.press("Learn")
        self.until("growth.learn", True)
        self.machine.run("setup.ngc")
        finger.until(self.learns_part, "the new reference")
        self.until("growth.learn", False)
        learnt = self.reference()
        self.machine.wait_until_idle()
        finger.press("Changes")
        finger.press("Undo growth reference")
        seen["former"] = finger.await_text("Put the former reference in force again (contacts: 5)?")
        finger.press("Undo")
        finger.await_text("The former reference is in force.")
        seen["references"] = [former, learnt, self.reference()]
        finger.press("Growth of Z")

    def reference(self):
        """Coordinates of the contacts. plumb-retain may walk through the rows meanwhile: two walks agree."""
        walks = [None]

        def agree():
            walks.append(self.walk())
            return walks[-1] == walks[-2]

        self.finger.until(agree, "the rows")
        return walks[-1]

    def walk(self):
        found = []
        for row in range(self.host.get("growth.rows")):
            def shown(row=row):
                self.host.set("growth.row", row)
                self.machine.wait(0.01)
                return self.host.get("growth.row-shown") == row
            self.finger.until(shown, "row %d" % row)
            found.append(self.host.get("growth.row-coordinate"))
        return found

    def second_day(self):
        finger = self.finger
        seen["angles"] = self.host.get(["square.ec0y", "square.ea0y"])
        seen["square"] = self.errors_along_y()
        self.residual()
        self.another_chain()
        seen["gate-floor"] = self.host.get("growth.gate-floor")
        finger.open("Growth of Z", "Learn from the next part")
        seen["morning"] = finger.await_text("A reference is kept, and waits for its program.")
        self.hold_a_message_back()
        self.learn_and_undo()
        self.machine.run("setup.ngc")
        self.machine.start("part.ngc")
        self.until("growth.reference-valid", True)
        self.machine.pause()
        seen["no contact yet"] = finger.await_text("No contact has counted since the start.")
        seen["ago"] = finger.find_text("ago")
        self.machine.abort()
        finger.open("All components", "growth")
        finger.press("growth")
        finger.press("gate-floor")
        seen["kept"] = finger.await_text("Saved by plumb-retain: this value wins over the HAL file.")
        seen["file"] = finger.await_text("In settings.hal: 0.02 mm")
        seen["change"] = finger.await_text("0.02 mm \u2192 0.025 mm")
        finger.press("Back to the HAL file, and keep no value")
        self.until("growth.gate-floor", 0.02)
        self.host.halcmd("unloadusr", "panel-settings")
        for name in ("All components", "growth", "gate-floor", "Clear"):
            finger.press(name)
        finger.type("0.03")
        finger.press("Save")
        finger.await_text("No plumb-retain keeps the settings of this screen")
        finger.rest()
        seen["promise"] = finger.find_text("Saved by plumb-retain")
        self.host.halcmd("unloadusr", "plumb-retain")
        finger.press("Growth of Z")
        seen["retain died"] = finger.await_text("plumb-retain (service 0) does not answer.")
        seen["switched off"] = finger.find_text("Switched off")
        finger.press("Overview")
        seen["overview"] = finger.await_text("plumb-retain (service 0) does not answer.")
        enter_an_incomplete_lean(finger, "w-Z.b-X-Y-C-t")
        stop_in_the_form(finger, self.machine, seen)
        lose_a_sensor(finger, self.host, seen)


def read(path):
    try:
        with open(path) as file:
            return file.read()
    except FileNotFoundError:
        return ""


def main():
    with Machine() as machine:
        operator = Operator(machine)
        operator.open_tab()
        if os.path.exists("seen.json"):  # of the first day, which has saved angles
            operator.morning()
        else:
            machine.turn_on()
            machine.home()
        (operator.second_day if os.path.exists("seen.json") else operator.first_day)()
        seen["done"] = True


try:
    main()
except (AssertionError, RuntimeError, plumb.Refused, subprocess.SubprocessError):
    seen["error"] = traceback.format_exc()
finally:
    with open("seen.json", "w") as file:
        json.dump(seen, file)
    subprocess.run(["axis-remote", "--quit"], check=False)
sys.exit(0)

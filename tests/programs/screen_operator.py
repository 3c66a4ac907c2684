#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of mill_screens_linuxcnc_test: presses the panel in a tab of gmoccapy or QtDragon, and ends the screen."""

import json
import os
import signal
import subprocess
import sys
import time
import traceback

import plumb
from plumb_linuxcnc import Machine
from panel_traps import enter_an_incomplete_lean, lose_a_sensor
from screen import Finger

# By the name of the screen's program: title of its window; points of which one is the panel's tab; its buttons of the emergency
# stop, of the machine, and of the exit, which QtDragon does without at SIGTERM.
SCREENS = {
    "gmoccapy": ("gmoccapy for", [(x, y) for y in (20, 42) for x in range(70, 400, 30)], (1230, 28), (1230, 154), (1227, 970)),
    "qtdragon": ("QTvcp-Screen", [(x, y) for y in (25, 44) for x in range(740, 900, 25)], (1137, 24), (1064, 24), None),
}
seen = {}


class Operator:
    def __init__(self, machine):
        self.machine, self.host = machine, machine.host
        self.finger = Finger(os.environ["DISPLAY"], "widgets.json", lambda: machine.wait(0.05))

    def until(self, pin, value):
        self.finger.until(lambda: self.host.get(pin) == value, "%s = %s" % (pin, value))

    def work(self, title, places, emergency_stop, power, _leave):
        finger = self.finger
        finger.find_tab(title, places)
        # By the buttons of the screen: gmoccapy undoes what another program does meanwhile.
        self.press_until(title, emergency_stop, "the end of the emergency stop", "iocontrol.0.user-enable-out")
        self.press_until(title, power, "the machine on", "halui.machine.is-on")
        self.machine.home()
        finger.open("Growth of Z", "Learn from the next part")
        if "--shots" in sys.argv:
            finger.shot("growth.png")
        finger.press("Learn from the next part")
        finger.press("Learn")
        self.until("growth.learn", True)
        seen["verdict"] = finger.await_text("Learns from the next part.")
        seen["ago"] = finger.find_text("ago")
        self.take_back()
        finger.press("All components")
        finger.press("growth")
        finger.press("gate-floor")
        finger.press("Clear")
        finger.type("0.025")
        finger.press("Save")
        self.until("growth.gate-floor", 0.025)
        finger.press("Changes")
        seen["changes"] = finger.await_text("0.02 mm \u2192 0.025 mm")
        finger.press("Growth of Z")
        finger.press("Learn from the next part")
        finger.await_text("The machine must be cold")
        finger.press("Squareness")
        finger.rest()
        seen["old question"] = finger.find_text("The machine must be cold")
        self.host.halcmd("unloadusr", "panel-settings")
        for name in ("All components", "growth", "gate-floor"):
            finger.press(name)
        finger.await_text("No plumb-retain keeps the settings of this screen")
        seen["promise"] = finger.find_text("Saved by plumb-retain")
        self.machine.turn_off()
        finger.press("Squareness")
        seen["off"] = finger.await_text("The machine is off. Turn")
        finger.press("Growth of Z")
        finger.press("Switch on / off")
        finger.press("Switch off")
        self.until("growth.enabled", False)
        finger.press("Switch on / off")
        seen["refused"] = finger.await_text("Switch on: refused. The machine is off.")
        enter_an_incomplete_lean(finger, "w-Z.b-X-Y-C-t")
        lose_a_sensor(finger, self.host, seen)

    def press_until(self, title, place, what, pin):
        """Presses a place of a window, which may give itself another size as it starts."""
        def pressed():
            self.finger.fill(title)
            self.finger.rest()
            self.finger.press_at(*place)
            self.finger.rest()
            self.finger.rest()
            return self.host.get(pin)

        self.finger.until(pressed, what)

    def take_back(self):
        """A line of MDI from the panel: its M64 P3 is kept by a flipflop."""
        for line in ("loadrt flipflop names=taken", "net take-back => taken.set", "addf taken servo-thread"):
            self.host.command(line)
        self.finger.press("Take the offset back")
        self.finger.press("Take back")
        self.until("taken.out", True)
        self.finger.until(lambda: not self.host.get("halui.program.is-running") and self.host.get("halui.mode.is-manual"), "manual mode")


def screen_process(word):
    """The number of the screen's process, which has the INI file of this folder."""
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/cmdline" % name) as file:
                words = file.read().split("\0")
        except OSError:
            continue
        ours = "-ini" in words and os.path.dirname(words[words.index("-ini") + 1]) == os.getcwd()
        if ours and word in map(os.path.basename, words):
            return int(name)
    return None


def window_of_errors():
    """The number of the process that shows LinuxCNC's errors until somebody closes it."""
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/cmdline" % name) as file:
                if "show_errors.tcl" in map(os.path.basename, file.read().split("\0")):
                    return int(name)
        except OSError:
            continue
    return None


def end(word):
    """Not by SIGKILL, which may find the screen with a lock of LinuxCNC.

    At SIGTERM qtvcp leaves HAL, and its timer then reads a pin of the memory that it has given back: it crashes.
    """
    process, leave = screen_process(word), SCREENS[word][-1]
    if process is not None and leave is None:
        os.kill(process, signal.SIGTERM)
        while window_of_errors() is None:  # unless the run ends, and this program with it
            time.sleep(0.1)
        os.kill(window_of_errors(), signal.SIGTERM)
    elif process is not None:
        finger = Finger(os.environ["DISPLAY"], "widgets.json")

        def pressed():
            finger.fill(SCREENS[word][0])
            finger.press_at(*leave)
            return screen_process(word) is None

        finger.until(pressed, "the end of " + word)


def main(word):
    with Machine() as machine:
        operator = Operator(machine)
        operator.work(*SCREENS[word])
        seen["done"] = True


screen = sys.argv[1]
try:
    main(screen)
except (AssertionError, RuntimeError, plumb.Refused, subprocess.SubprocessError):
    seen["error"] = traceback.format_exc()
finally:
    with open("seen.json", "w") as file:
        json.dump(seen, file)
    end(screen)
sys.exit(0)

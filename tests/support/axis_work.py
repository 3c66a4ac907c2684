# SPDX-License-Identifier: GPL-2.0-or-later
"""What an [APPLICATIONS]APP does that works plumb panel in a tab of AXIS: it writes seen.json, and ends AXIS."""

import json
import os
import subprocess
import sys
import time
import traceback

import plumb
from plumb_linuxcnc import Machine
from screen import Finger

TABS = [(x, y) for y in (76, 90, 100, 64) for x in range(400, 1280, 36)]  # where the tab of the panel may be


class Operator:
    """A finger on the panel, and the machine behind it; seen is for the test."""

    def __init__(self, machine):
        self.machine, self.host, self.seen = machine, machine.host, {}
        self.finger = Finger(os.environ["DISPLAY"], "widgets.json", lambda: machine.wait(0.05))

    def begin(self):
        """The machine on and homed, and the panel in front."""
        self.machine.turn_on()
        self.machine.home()
        self.finger.find_tab("AXIS 2", TABS)

    def until(self, pin, value):
        self.finger.until(lambda: self.host.get(pin) == value, "%s = %s" % (pin, value))

    def type_into(self, field, text):
        """A field of a form that shows its name and its text."""
        self.finger.press(field)
        self.finger.press("Clear")
        self.finger.type(text)


def work_axis(work):
    """Calls work(operator), and ends AXIS in any case."""
    seen = {}
    try:
        with Machine() as machine:
            operator = Operator(machine)
            operator.seen = seen
            try:
                work(operator)
                seen["done"] = True
            finally:
                machine.abort()  # AXIS does not end in a paused program
    except (AssertionError, RuntimeError, plumb.Refused, subprocess.SubprocessError):
        seen["error"] = traceback.format_exc()
    finally:
        with open("seen.json", "w") as file:
            json.dump(seen, file)
        quit_axis()
    sys.exit(0)


def quit_axis():
    """AXIS refuses to end while an abort is under way."""
    for _ in range(20):
        subprocess.run(["axis-remote", "--quit"], capture_output=True, check=False)
        time.sleep(1)

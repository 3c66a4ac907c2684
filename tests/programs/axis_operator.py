#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of axis_linuxcnc_test: homes the machine, waits for AXIS and for the panel in its tab, and ends AXIS."""

import json
import os
import subprocess
import sys
import traceback

import plumb
from plumb_linuxcnc import Machine
from screen import Finger

seen = {}


def work(machine, has_panel):
    finger = Finger(os.environ["DISPLAY"], "widgets.json", lambda: machine.wait(0.05))
    finger.until(lambda: subprocess.run(["axis-remote", "--ping"], capture_output=True).returncode == 0, "AXIS")
    finger.until(lambda: machine.poll().file, "the program of OPEN_FILE")
    machine.turn_on()
    machine.home()
    seen["program"] = os.path.basename(machine.poll().file)
    if has_panel:
        finger.until(finger.is_there, "the panel")
    seen["errors"] = machine.errors


try:
    with Machine() as linuxcnc:
        work(linuxcnc, "panel" in sys.argv)
        seen["done"] = True
except (AssertionError, RuntimeError, plumb.Refused, subprocess.SubprocessError):
    seen["error"] = traceback.format_exc()
finally:
    with open("seen.json", "w") as file:
        json.dump(seen, file)
    subprocess.run(["axis-remote", "--quit"], check=False)
sys.exit(0)

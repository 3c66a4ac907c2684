#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in its own window, beside a LinuxCNC that ends and starts again.

    panel_waits.py MACHINE.ini    of mill_panel_linuxcnc_test, within plumb run: starts the panel, then LinuxCNC twice
    panel_waits.py --shift        the shift of LinuxCNC, which ends when there is a file named end
"""

import json
import os
import subprocess
import sys
import time
import traceback

from screen import Finger

ON, END = "on", "end"  # files
VALUES = "values.json"  # of scripts/panel_with_values.py
ANSWER = 30  # a digital output that no configuration uses
SHIFTED = {"growth.shift-size": 0.03, "growth.doubt": True, "task.alive": True, "task.program": "idle"}


def shift():
    from plumb_linuxcnc import Machine

    with Machine() as machine:
        while not os.path.exists(END):
            if os.path.exists(ON):
                os.unlink(ON)
                machine.turn_on()
                machine.home()
            machine.wait(0.05)
    os.unlink(END)


def halcmd(*words):
    return subprocess.run(["halcmd", *words], stdout=subprocess.PIPE, text=True, check=False).stdout.strip()


def answer_by_an_output(finger, seen):
    """The answer about a shift of contacts, where the configuration has netted it to a digital output: M64 and M65 in MDI."""
    halcmd("unlinkp", "growth.shift-is-not-growth")
    halcmd("net", "test-answer", "motion.digital-out-%d" % ANSWER, "growth.shift-is-not-growth")
    for words in (("loadrt", "flipflop", "names=answered"), ("net", "test-answer", "answered.set"), ("addf", "answered", "servo-thread")):
        halcmd(*words)
    open(ON, "w").close()
    finger.until(lambda: halcmd("getp", "motion.is-all-homed") == "TRUE", "the homed machine")
    with open(VALUES + ".new", "w") as file:
        json.dump(SHIFTED, file)
    os.replace(VALUES + ".new", VALUES)
    finger.press("It is not growth")
    finger.await_text("Change the reference by +30.0 \u00b5m?")
    finger.press("Change the reference")
    finger.until(lambda: halcmd("getp", "answered.out") == "TRUE", "the answer")
    finger.until(lambda: halcmd("getp", "motion.digital-out-%d" % ANSWER) == "FALSE", "its end")
    finger.press("Changes")
    seen["answer"] = finger.await_text("M64 P%d" % ANSWER)


def start(ini):
    return subprocess.Popen(["linuxcnc", "-r", ini, os.path.abspath(__file__), "--shift"], stdin=subprocess.DEVNULL, stdout=sys.stderr)


def work(ini, seen):
    finger = Finger(os.environ["DISPLAY"], "widgets.json")
    with open(VALUES, "w") as file:
        json.dump({}, file)
    program = [sys.executable, os.path.join(os.environ["ROOT"], "scripts", "panel_with_values.py"), VALUES, os.environ["BUILD"]]
    with subprocess.Popen([*program, "--ini", ini, "--widgets", "widgets.json"]) as panel:
        try:
            seen["before"] = finger.await_text("LinuxCNC does not run here.")
            for name in ("first", "second"):
                with start(ini) as linuxcnc:
                    finger.until(lambda: finger.find("Growth of Z"), "the pages of the machine")
                    finger.press("Growth of Z")
                    seen[name] = finger.await_text("There is no reference: nothing is corrected.")
                    seen[name + " lowest"] = max(each["y"] + each["height"] for each in finger.widgets() if not each["scrolled"])
                    if name == "first":
                        answer_by_an_output(finger, seen)
                    open(END, "w").close()
                    seen[name + " end"] = finger.await_text("LinuxCNC has ended.")
                    linuxcnc.wait()
                seen[name + " wait"] = finger.await_text("LinuxCNC does not run here. This screen waits for it.")
                seen[name + " lives"] = panel.poll() is None
            began = time.monotonic()
            panel.terminate()
            panel.wait(20)
            seen["took"] = time.monotonic() - began
            seen["done"] = True
        finally:
            if panel.poll() is None:
                panel.kill()


if sys.argv[1:] == ["--shift"]:
    shift()
    sys.exit(0)
its = {}
try:
    work(sys.argv[1], its)
except (AssertionError, OSError, subprocess.SubprocessError):
    its["error"] = traceback.format_exc()
finally:
    with open("seen.json", "w") as file:
        json.dump(its, file)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of axis_linuxcnc_test: writes that move an axis, while a program runs or is paused and nobody has loaded halui."""

import os

import linuxcnc
from axis_work import work_axis


def work(operator):
    finger, host, machine, seen = operator.finger, operator.host, operator.machine, operator.seen
    operator.begin()
    seen["program"] = os.path.basename(machine.poll().file)
    seen["halui"] = "halui" in host.programs()
    with open("long.ngc", "w") as file:
        file.write("G4 P10000\nM2\n")
    with open("pause.ngc", "w") as file:
        file.write("M0\nM2\n")
    finger.open("Squareness", "All pins and settings")
    finger.press("All pins and settings")
    finger.press("ea0z")
    write(operator, "-0.0001")
    finger.press_answer("Save")
    operator.until("square.ea0z", -0.0001)
    machine.wait(2)
    before = applied(host)
    for name, program in (("running", "long.ngc"), ("paused", "pause.ngc")):
        machine.start(program)
        finger.until(lambda: machine.poll().interp_state == linuxcnc.INTERP_PAUSED or
                     name == "running" and machine.poll().interp_state != linuxcnc.INTERP_IDLE, "the program")
        finger.rest()
        write(operator, "0.001")
        seen[name] = finger.await_text("A program " + ("runs." if name == "running" else "is paused."))
        finger.press("Undo the last change")
        seen["undo, " + name] = finger.await_text("Undo: refused.")
        if name == "running":
            machine.abort()
    machine.wait(1)
    seen["moved"] = max(abs(now - then) for now, then in zip(applied(host), before))
    finger.press("Squareness")
    finger.press("All pins and settings")
    finger.press("max-rate")  # which moves no axis
    write(operator, "0.5")
    operator.until("square.max-rate", 0.5)
    seen["still"] = host.get("square.max-rate")
    finger.press("Squareness")
    finger.press("Switch on / off")
    finger.press("Switch off")  # always
    operator.until("interlock.function-switch-0", False)
    seen["on"] = host.get("interlock.function-switch-0")
    finger.await_text("Switched off: the offset holds until the tool is clear, and then returns.")
    seen["errors"] = machine.errors


def write(operator, text):
    operator.finger.press("Clear")
    operator.finger.type(text)
    operator.finger.press("Save")


def applied(host):
    return host.get([axis + "-stage.applied-offset" for axis in "xyz"])


work_axis(work)

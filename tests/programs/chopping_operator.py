#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of axis_linuxcnc_test: strokes, their ends and their sections by the finger, in the tab of AXIS."""

import contextlib
import os
import signal

from axis_work import work_axis

UPPER, LOWER, END, SPEED = "Upper dead point, mm", "Lower dead point, mm", "Point R, mm", "Largest speed, mm/min"


def work(operator):
    finger, host, machine, seen = operator.finger, operator.host, operator.machine, operator.seen
    operator.begin()
    host.set("chop.without-wheel", 1)
    seen["program"] = os.path.basename(machine.poll().file)
    finger.open("Chopping", "Ends and start")
    finger.press("Ends and start")
    machine.mdi("G21 G10 L20 P1 Z100")  # a work offset, which the positions of the joint do not have
    for field, text in ((UPPER, "-20"), (LOWER, "-10"), (SPEED, "3000")):
        operator.type_into(field, text)
    finger.press("Start the strokes")
    seen["swapped"] = finger.await_text("refused")
    operator.type_into(LOWER, "-40")
    operator.type_into(SPEED, "30000")
    finger.press("Start the strokes")
    seen["too fast"] = finger.await_text("The speed is above")
    with finger.story("chopping: start"):
        for field, text in ((UPPER, "-20"), (LOWER, "-40"), (SPEED, "3000"), (END, "-15")):
            operator.type_into(field, text)
        finger.press("Start the strokes")
        seen["question"] = finger.await_text("Stroke between")
        seen["before the answer"] = host.get("chop.stroking")
        finger.press_twice("Start")
        finger.until(lambda: host.get("chop.stroke-count") > 3, "strokes")
    seen["region"] = [round(host.get("chop." + pin), 6) for pin in ("upper", "lower", "end-position", "feed")]
    seen["mode"] = machine.poll().task_mode
    sections(operator)
    finger.press("Back")
    finger.press("Ends and start")
    operator.type_into(LOWER, "-35")
    finger.press("Start the strokes")  # which changes them now
    finger.press("Change now")
    operator.until("chop.lower", -35)
    finger.until(lambda: abs(host.get("chop.measured-lower") + 35) < 0.5, "strokes to the new end")
    seen["still strokes"] = host.get("chop.stroking")
    finger.press("Changes")
    finger.await_text("chop_change")
    seen["log"] = [text for text in finger.texts() if "G81.1" in text or "chop_change" in text]
    finger.press("Chopping")
    hold(operator)
    with finger.story("chopping: stop"):
        finger.press("Stop strokes")
        finger.until(lambda: host.get("chop.at-end"), "the axis at point R")
    seen["at rest"] = finger.await_text("At rest at point R.")
    away(operator)
    pause(operator)
    emergency_stop(operator)
    seen["errors"] = machine.errors


def sections(operator):
    """A section of half the speed; one that cannot be; and both are undone or refused."""
    finger, host, seen = operator.finger, operator.host, operator.seen
    with finger.story("chopping: a section"):
        finger.press("Sections")
        finger.press("Section 1")
        finger.press("Downward only")
        operator.type_into("From, mm", "-35")
        operator.type_into("To, mm", "-25")
        finger.press("Save")
        finger.press("Save the section")
        operator.until("chop.section-0-kind", 4)
    seen["section"] = [host.get("chop.section-0-" + part) for part in ("from", "to", "ratio")]
    seen["shown"] = finger.await_text("50 % of the speed, downward")
    finger.press("Section 2")
    finger.press("Downward only")
    operator.type_into("From, mm", "-30")
    operator.type_into("To, mm", "-22")
    finger.press("Save")
    finger.press("Save the section")
    seen["overlap"] = finger.await_text("two overlap")
    seen["second"] = host.get("chop.section-1-kind")
    seen["strokes on"] = host.get("chop.stroking")
    finger.press("Back")


def hold(operator):
    """A held axis does not look as if it strokes."""
    finger, host, seen = operator.finger, operator.host, operator.seen
    finger.press("Hold / go on")
    finger.until(lambda: host.get("chop.held"), "the hold")
    seen["held"] = finger.await_text("Held: the axis stands")
    seen["ticks"] = "\u2714" in finger.texts()
    finger.press("Hold / go on")
    finger.press("Go on")
    finger.until(lambda: not host.get("chop.held"), "the strokes")
    finger.await_text("The axis strokes.")


def away(operator):
    """With LinuxCNC's task stopped: a stop at once, an axis that rests beside point R, and the way there after a question."""
    finger, host, seen = operator.finger, operator.host, operator.seen
    host.set("chop.stop-kind", 2)
    finger.press("Ends and start")
    finger.press("Start the strokes")
    finger.press("Start")
    finger.until(lambda: host.get("chop.stroke-count") > 3, "strokes")
    finger.rest()
    task = number_of_task()
    os.kill(task, signal.SIGSTOP)
    try:
        finger.press("Stop strokes")
        finger.until(lambda: not host.get("chop.active"), "the stop")
        seen["away"] = finger.await_text("The axis stands away from point R.")
        before = host.get("chop.offset")
        finger.press("To point R")
        finger.await_text("Move the axis to point R? It moves: ")
        finger.press("Overview")
        finger.rest()
        seen["old question"] = finger.find_text("Move the axis to point R?")
        seen["moved unasked"] = host.get("chop.offset") - before
        finger.press("Chopping")
        finger.press("To point R")
        finger.press("Move the axis")
        finger.until(lambda: host.get("chop.at-end"), "the axis at point R")
    finally:
        os.kill(task, signal.SIGCONT)
    finger.await_text("At rest at point R.")


def number_of_task():
    """The process of this LinuxCNC's task."""
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError), open("/proc/%s/cmdline" % name) as file:
            words = file.read().split("\0")
            if os.path.basename(words[0]) == "milltask" and os.path.dirname(words[words.index("-ini") + 1]) == os.getcwd():
                return int(name)
    raise AssertionError("there is no task")


def emergency_stop(operator):
    """In the middle of an entry: it stays, and nothing starts."""
    finger, machine, seen = operator.finger, operator.machine, operator.seen
    machine.turn_on()
    operator.type_into(LOWER, "-47")
    machine.emergency_stop()
    finger.press("Start the strokes")
    seen["in emergency stop"] = finger.await_text("refused. The machine is off.")
    seen["entered"] = next(each["text"] for each in finger.widgets() if each["kind"] == "Entry")


def pause(operator):
    """A start is refused while a program is paused, and while the machine is off; a stop is not."""
    finger, host, machine, seen = operator.finger, operator.host, operator.machine, operator.seen
    with open("pause.ngc", "w") as file:
        file.write("M0\nM2\n")
    machine.start("pause.ngc")
    finger.until(lambda: host.get("halui.program.is-paused"), "the paused program")
    finger.press("Ends and start")
    finger.press("Start the strokes")
    seen["paused"] = finger.await_text("Start: refused. A program is paused.")
    machine.abort()
    machine.turn_off()
    finger.press("Start the strokes")
    seen["off"] = finger.await_text("Start: refused. The machine is off.")
    seen["strokes"] = host.get("chop.active")


work_axis(work)

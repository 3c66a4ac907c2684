#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of axis_linuxcnc_test: a growth test that is begun, stopped, lost and resumed by the finger, in the tab of AXIS."""

import os

from axis_work import work_axis

BEGIN, RESUME = "Start accelerated.ngc", "Start resume.ngc"


def first_day(operator):
    finger, host, machine, seen = operator.finger, operator.host, operator.machine, operator.seen
    seen["program"] = os.path.basename(machine.poll().file)
    finger.open("Growth test", BEGIN)
    seen["none"] = finger.await_text("No test runs.")
    finger.press(RESUME)
    seen["nothing to resume"] = finger.await_text("refused")
    lose_the_program(operator)
    with finger.story("growth test: start"):
        finger.press(BEGIN)
        finger.await_text("The axes move, and the probe touches.")
        seen["before the answer"] = host.get("growth-test.running")
        finger.press_answer(BEGIN)
        finger.await_text("The test runs.")
    finger.until(lambda: host.get("growth-test.visit") >= 1 and not host.get("growth-test.at-bore"), "a bore")
    guard(operator)
    finger.press("Growth test")
    with finger.story("growth test: stop"):
        finger.press("Stop the test")  # at once
        operator.until("growth-test.running", False)
    seen["interrupted"] = finger.await_text("The test was interrupted. resume.ngc is refused before a restart.")
    finger.press(RESUME)
    seen["not yet"] = finger.await_text("refused. The test was interrupted.")
    seen["errors"] = machine.errors


def lose_the_program(operator):
    """A program that ends without the end of its test."""
    finger, machine, seen = operator.finger, operator.machine, operator.seen
    with open("lost.ngc", "w") as file:
        file.write("M64 P24\nM64 P25\nG4 P1\nM2\n")
    machine.start("lost.ngc")
    finger.await_text("The test runs.")
    seen["lost"] = finger.await_text("The program of the test has ended without its end: nothing is probed.")
    seen["tick"] = "\u2714" in finger.texts()
    machine.mdi("O <on_abort> call")
    finger.await_text("interrupted")


def guard(operator):
    """While the program runs."""
    finger, seen = operator.finger, operator.seen
    finger.press(BEGIN)
    seen["runs"] = finger.await_text("refused. A program runs.")


def second_day(operator):
    """After a restart growth_log has given the test back."""
    finger, seen = operator.finger, operator.seen
    finger.open("Growth test", RESUME)
    seen["resumable"] = finger.await_text("Start resume.ngc to go on.")
    with finger.story("growth test: resume"):
        finger.press(RESUME)
        finger.await_text("The axes move, and the probe touches.")
        finger.press_answer(RESUME)
        seen["resumed"] = finger.await_text("The test runs.")
    operator.until("growth-test.pass-running", True)
    seen["pass"] = operator.host.get("growth-test.pass")


def work(operator):
    operator.begin()
    (second_day if os.path.exists("seen.json") else first_day)(operator)


work_axis(work)

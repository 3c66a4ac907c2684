#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares the contacts by their place and by their time, on the simulated mill.

    plumb run --speed 10 -- linuxcnc mill.ini by_time.py

For each way it forgets what it learned, learns from a part on the cold machine, and makes two more. Before each of these the spindle grows.
"""

import re
import sys

import plumb
from plumb_linuxcnc import Machine

GROWTH = 0.01  # mm, before each part
PARTS = 2
WAYS = {  # by-time, clock-from-program
    "place": (False, False),
    "time from a height": (True, False),
    "time from a mark": (True, True),
    "time from the cycle": (True, True),
}


def make_parts(machine, way):
    """The contacts that were accepted, those that were found, the offset and the growth in mm, and why the last one was rejected."""
    host = machine.host
    by_time, from_program = WAYS[way]
    host.set("growth.by-time", by_time)
    host.set("growth.clock-from-program", from_program)
    if way == "time from the cycle":
        host.halcmd("unlinkp", "growth.clock-start")
    machine.mdi("M68 E1 Q0")
    host.set("growth.forget", True)
    machine.wait(0.1)
    host.set("growth.forget", False)
    machine.run("learn.ngc")
    machine.run("part.ngc")
    before = host.get(["growth.contacts-accepted", "growth.contacts"])
    for part in range(1, PARTS + 1):
        machine.mdi("M68 E1 Q%g" % (part * GROWTH))
        machine.run("part.ngc")
    accepted, contacts = (now - then for now, then in zip(host.get(["growth.contacts-accepted", "growth.contacts"]), before))
    code = host.get("growth.detail-code") if accepted < contacts else 0
    return accepted, contacts, host.get("axis.z.eoffset"), host.get("mill.truth-growth"), code


def main():
    reasons = plumb.declarations("thermal_displacement")["codes"]["detail-code"]
    with Machine() as machine:
        machine.turn_on()
        machine.home()
        machine.run("setup.ngc")
        print("contacts by            accepted   offset of growth, um")
        for way in WAYS:
            accepted, contacts, offset, growth, code = make_parts(machine, way)
            reason = "  " + re.sub(r" \([^)]*\}\)", "", reasons[code]) if code else ""  # without the values of one contact
            print("%-20s %5d of %2d %8.1f of %.1f%s" % (way, accepted, contacts, 1e3 * offset, 1e3 * growth, reason), flush=True)


if __name__ == "__main__":
    sys.exit(main())

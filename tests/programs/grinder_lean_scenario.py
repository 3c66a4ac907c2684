#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_lean_linuxcnc_test: a wheel on a column that leans, moved and stroked, with the stroke in the position of squareness and without it."""

import subprocess
import sys

from scenario import Scenario, run

PROGRAM = """G90 G21
M3 S1000
G0 Z10
G81.1 Z0 Q-400 R10 P9000
G1 Y%d F60
G80.1
M2
"""


def halcmd(line):
    subprocess.run(["halcmd", *line.split()], check=True)


class Lean(Scenario):
    columns = ["scene", "joint.1.pos-cmd", "joint.2.pos-cmd", "x-drive.out", "z-drive.out", "chop.stroke-count", "chop.stroking", "square.status-code"]

    def work(self):
        self.play(self.home, self.moved, self.stroked, self.at_point_r, self.mended)

    def home(self):
        self.machine.turn_on()
        self.machine.home()
        self.await_pin("chop.enabled", 1)
        self.await_pin("square.enabled", 1)
        self.await_pin("square.ramping", 0)

    def moved(self):
        """By LinuxCNC, at the largest speed."""
        self.machine.mdi("G90 G21 G0 Z0")
        for _ in range(2):
            self.machine.mdi("G0 Z-400")
            self.machine.mdi("G0 Z0")

    def strokes(self, y):
        with open("lean.ngc", "w", encoding="ascii") as file:
            file.write(PROGRAM % y)
        self.machine.run("lean.ngc")

    def stroked(self):
        self.strokes(40)

    def at_point_r(self):
        for short in ("position", "velocity"):
            halcmd("unlinkp square.z-" + short)
            halcmd("net z-%s square.z-%s" % (short, short))
        # interlock looks once a second of the computer's clock, perhaps between the two nets.
        self.facts["told"] = "; ".join(self.message_of(lambda: self.machine.wait_for(lambda status: False, "a message", 15)) for _ in range(2))
        self.strokes(0)

    def mended(self):
        for short in ("position", "velocity"):
            halcmd("unlinkp square.z-" + short)
            halcmd("net z-stroked-%s square.z-%s" % (short, short))
        self.strokes(40)


if __name__ == "__main__":
    sys.exit(run(Lean, recording="lean.csv"))

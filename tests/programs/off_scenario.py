#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of portal_off_test: an operator switches squareness off amid a cut of a program."""

import sys

import linuxcnc
from scenario import Scenario, run

COLUMNS = ["scene", "motion.motion-type", "motion.current-vel", "interlock.function-enable-0", "interlock.function-status-0", "square.ramping"]
COLUMNS += ["square.%s-correction" % letter for letter in "xyz"] + ["portal.truth-%s-error" % letter for letter in "xyz"]
PROGRAM = "G54 G61 F3000\nT3 M6 G43\nG0 X200 Y150 Z0\nM66 P5 L4 Q60\nG1 X260\nG1 Y190\nG0 Z5\nG1 X200\nM2\n"


class Off(Scenario):
    columns = COLUMNS

    def work(self):
        self.machine.turn_on()
        self.machine.home()
        self.machine.mdi("G10 L2 P1 X0 Y0 Z-270 R0")
        self.host.set("square.max-rate", 0.02)  # the return takes longer than the rapid move
        with open("off.ngc", "w") as file:
            file.write(PROGRAM)
        self.begin("program")
        self.machine.start("off.ngc")
        self.machine.wait_for(lambda status: self.host.get("motion.motion-type") == linuxcnc.MOTION_TYPE_FEED
                              and self.host.get("motion.current-vel") > 49, "the cut")
        self.host.set("interlock.function-switch-0", False)
        self.machine.wait_until_idle()


if __name__ == "__main__":
    sys.exit(run(Off, recording="shift.csv"))

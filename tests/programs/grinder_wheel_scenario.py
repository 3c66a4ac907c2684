#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_linuxcnc_test: the wheel leaves the work at an abort, and where its spindle stops."""

import subprocess
import sys

from scenario import Scenario, run

STROKE, LOWER, R = "G81.1 Z5 Q-30 R5 P3600", -25, 10
PROGRAM = "G90 G21\nM3 S1000\n%s\nG1 X%d F60\nG80.1\nM2\n"
DEPTHS = (-2, -10, -20, -24)  # mm; the stroke is from 5 to -25


def halcmd(line):
    subprocess.run(["halcmd", *line.split()], check=True)


class Wheel(Scenario):
    columns = ["scene", "chop.command", "chop.withdrawing", "chop.active", "chop.feed-wait", "spindle.0.on", "chop.spindle-at-speed", "joint.0.pos-cmd",
               "motion.current-vel", "chop.fault-code"]

    def work(self):
        self.play(self.home, *(self.abort_at(kind, depth, down) for kind in (0, 2) for depth in DEPTHS for down in (True, False)), self.tripped, self.stands,
                  self.switched_off, self.without_wheel)

    def home(self):
        self.host.set("chop.learn", 0)
        self.machine.turn_on()
        self.machine.home()
        self.await_pin("chop.enabled", 1)

    def start(self):
        self.await_pin("linuxcnc-alive.part-program-running", 0)
        get = self.host.get
        with open("wheel.ngc", "w", encoding="ascii") as file:
            file.write(PROGRAM % (STROKE, 100 if get("joint.0.pos-cmd") < 50 else -100))
        self.machine.start("wheel.ngc")
        self.await_condition(lambda: get("chop.stroke-count") >= 2 and get("motion.current-vel") > 0, "the strokes")

    def abort_at(self, kind, depth, down):
        def scene():
            self.host.set("chop.abort-kind", kind)
            self.start()
            get = self.host.get
            self.await_condition(lambda: (get("chop.velocity") < 0) == down and abs(get("chop.command") - depth) < 2, "the depth")
            self.machine.abort()
            self.await_pin("chop.at-end", 1)

        scene.__name__ = "abort_%d_%d_%s" % (kind, -depth, "down" if down else "up")
        return scene

    def tripped(self):
        """The drive of the wheel trips: spindle.0.on stays true."""
        self.start()
        halcmd("unlinkp spindle-near.out")
        halcmd("sets spindle-at-speed 0")
        self.facts["tripped"] = self.message_of(lambda: self.await_pin("chop.at-end", 1))
        self.facts["spindle_on"] = self.host.get("spindle.0.on")
        self.await_pin("chop.at-end", 1)
        self.facts["path_holds"] = [self.host.get("chop.feed-wait"), self.host.get("motion.current-vel")]
        self.machine.abort()
        halcmd("net spindle-at-speed spindle-near.out")

    def stands(self):
        self.machine.mdi("M5")
        self.facts["stands"] = self.message_of(lambda: self.machine.mdi(STROKE))

    def switched_off(self):
        """By M5 in MDI."""
        self.machine.mdi("M3 S1000 " + STROKE)
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= 2, "the strokes")
        self.message_of(lambda: self.machine.mdi("M5"))
        self.await_pin("chop.at-end", 1)
        self.machine.abort()

    def without_wheel(self):
        self.await_pin("linuxcnc-alive.part-program-running", 0)
        self.host.set("chop.without-wheel", 1)
        self.machine.mdi("M5")
        self.machine.mdi(STROKE)
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= 2, "the strokes")
        self.machine.mdi("G80.1")


if __name__ == "__main__":
    sys.exit(run(Wheel, recording="shift.csv"))

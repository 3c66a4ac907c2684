#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of commission_wired_linuxcnc_test: an inch machine of plumb wire, commissioned, and started again.

    commission_wired_scenario.py first | again | moved | stays
"""

import contextlib
import os
import subprocess
import sys

from plumb_linuxcnc import OperatorError, Overdue
from scenario import Scenario, run

TILT = 0.00016  # rad, of Z, by which the tool moves to X+ when it rises


class Wired(Scenario):
    """The drives are the loops of the sample: the commands to them are the places of the machine."""

    ends = {"Z": (-80, -10)}

    def work(self):
        self.ready()
        getattr(self, sys.argv[1])()

    def ready(self):
        with contextlib.suppress(OperatorError, Overdue):  # a question about what passed
            self.machine.wait_for(lambda _: False, "no message", 3)
        self.machine.turn_on()
        self.machine.home()
        self.machine.wait(8)  # interlock looks at the wiring, and plumb-retain restores

    def before_on(self):
        """After the emergency stop, with the machine still off."""

    def square(self, direction):
        """What an indicator against the blade reads."""
        place = self.host.get("%s-stage.drive-command" % direction.lower())
        return place + (TILT * self.host.get("z-stage.drive-command") if direction == "X" else 0)

    def first(self):
        from commissioning_robot import Robot

        self.facts["before"] = self.acts()
        robot = Robot(self, {letter: "%s-stage.drive-command" % letter.lower() for letter in "XYZ"})
        self.facts["robot"] = robot.commission("squareness")
        self.facts["after"] = self.acts()

    def again(self):
        """What was retained; then the hands of an enemy."""
        self.facts["before"] = self.acts()
        self.facts["doctor"] = self.doctor()
        passed = self.host.get("interlock.function-passed-0")
        stage = self.host.get("interlock.stage-passed-0")

        self.host.set("interlock.stage-passed-0", stage + 1)
        self.facts["wrong identity"] = self.acts()
        self.host.set("interlock.stage-passed-0", stage)

        self.swap("y", "x")
        self.facts["swapped"] = self.acts()
        self.facts["doctor of swapped"] = self.doctor()
        self.host.set("interlock.function-passed-0", self.host.get("interlock.function-identity-0"))
        self.facts["by hand"] = self.acts()
        self.facts["doctor of by hand"] = self.doctor()

        self.host.set("interlock.function-passed-0", passed)
        self.swap("x", "y")
        self.facts["after"] = self.acts()

    def moved(self):
        """On another computer."""
        self.facts["before"] = self.acts()
        self.facts["doctor"] = self.doctor()
        self.facts["accept"] = self.plumb("commission", "--accept")
        self.facts["after"] = self.acts()

    def stays(self):
        self.facts["before"] = self.acts()

    def swap(self, first, second):
        for line in ("unlinkp x-stage.offset-0", "unlinkp y-stage.offset-0",
                     "net %s-correction x-stage.offset-0" % first, "net %s-correction y-stage.offset-0" % second):
            self.host.command(line)

    def acts(self):
        """Status of the function, switched on at a place of Z, and the correction of X."""
        self.host.set("interlock.function-switch-0", 1)
        try:
            self.machine.mdi("G53 G0 X0 Z-2")
        except OperatorError as error:
            self.facts.setdefault("errors", []).append(str(error))
        self.machine.wait(6)
        found = [self.host.get("interlock.function-status-0"), self.host.get("x-stage.applied-offset")]
        self.host.set("interlock.function-switch-0", 0)
        self.machine.wait(2)
        return found

    def doctor(self):
        return self.plumb("doctor", "--machine")

    @staticmethod
    def plumb(*words):
        done = subprocess.run([os.path.join(os.environ["BUILD"], "bin", "plumb"), *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, check=False)
        return done.stdout


if __name__ == "__main__":
    sys.exit(run(Wired))

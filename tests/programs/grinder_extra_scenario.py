#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_linuxcnc_test: strokes of an extra joint, which LinuxCNC does not watch."""

import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run


class Shift(Scenario):
    columns = ["scene", "joint.3.motor-pos-cmd", "motion.current-vel", "chop.active", "chop.command", "chop.fault-code"]

    def work(self):
        self.play(self.turn_on, self.cross_feed, self.beyond_a_limit, self.emergency_stop, self.on_again, self.lag)

    def turn_on(self):
        self.machine.turn_on()
        self.machine.home()

    def cross_feed(self):
        self.machine.run("extra.ngc")

    def message_of(self, action):
        """What the operator reads, during an action or after it."""
        try:
            action()
            self.machine.wait_for(lambda status: False, "a message")
        except OperatorError as error:
            return str(error)

    def beyond_a_limit(self):
        self.host.set("chop.upper", 270)
        self.facts["message"] = self.message_of(lambda: self.machine.mdi("M64 P16"))
        self.facts["beyond_a_limit"] = self.host.get("chop.fault-code")
        self.host.set("chop.upper", 200)
        self.machine.mdi("M65 P16")

    def start(self):
        self.machine.mdi("M64 P16")
        self.await_condition(lambda: self.host.get("chop.command") < -100, "the stroke")

    def emergency_stop(self):
        self.start()
        self.machine.emergency_stop()

    def on_again(self):
        self.machine.turn_on()
        self.machine.wait(0.5)

    def lag(self):
        self.machine.mdi("M65 P16")
        self.start()
        self.facts["lags"] = self.message_of(lambda: self.host.set("table.servo-gain", 4))
        self.await_pin("chop.active", 0)
        self.facts["lag"] = self.host.get("chop.fault-code")


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

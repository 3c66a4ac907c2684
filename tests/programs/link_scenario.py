#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The facts for linuxcnc_link_test.py, from a complete LinuxCNC with linuxcnc_link.py and plumb-retain.
"""

import contextlib
import os
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

FIELDS = {"operation": 10, "tool": 1, "occurrence": 1, "coordinate": -1.25, "feed": -2.0, "feed-override": 1.0}
FIELDS.update({"applied-offset": 0.0, "program-id": 4711, "cycles": 1, "time-constant": 0.1 + 0.2})


class Day(Scenario):
    def until(self, condition, what):
        self.machine.wait_for(lambda _: condition(), what)

    def identity(self):
        return self.host.get("linuxcnc-link.program-id")

    def write(self, name, text):
        with open(name, "w") as file:
            file.write(text)

    def work(self):
        self.until(lambda: self.host.get("linuxcnc-link.connected"), "the link")
        self.facts["without a program"] = self.host.get("linuxcnc-link.program-id")
        self.until(lambda: self.host.get("plumb-retain.restored"), "the kept values")
        pins = ["growth.window", "growth.rows", "plumb-retain.fault-code"]
        self.facts["in force"] = self.host.get(pins)
        if self.host.get("growth.rows") > 0:
            return  # the second day
        self.machine.turn_on()
        self.machine.home()
        self.programs()
        self.tools()
        self.messages()
        self.keep()

    def programs(self):
        self.machine.run("main.ngc")
        self.until(lambda: self.identity() != 0, "the identity of the program")
        known = self.identity()
        with open("second.ngc") as file:
            text = file.read()
        self.write("second.ngc", "".join("N%d %s (edited) ; \n" % (10 * number, line.upper()) for number, line in enumerate(text.splitlines())))
        self.machine.wait(10)
        self.facts["edited comments"] = [known, self.identity()]
        self.write("second.ngc", text + "G4 P0.5\n")
        self.until(lambda: self.identity() not in (0, known), "the identity of another program")
        self.write("second.ngc", text)
        self.until(lambda: self.identity() == known, "the identity of the first one")
        os.rename("test_three_axis.ini", "away.ini")
        self.machine.run("alone.ngc")
        self.until(lambda: self.identity() == 0, "a program in folders that are not known")
        os.rename("away.ini", "test_three_axis.ini")
        self.until(lambda: self.identity() not in (0, known), "the identity of alone.ngc")

    def tools(self):
        known = self.host.get("linuxcnc-link.tool-set-id")
        self.facts["tools"] = [known]
        self.machine.mdi("T1 M6")
        self.machine.wait(1)
        self.facts["tools"].append(self.host.get("linuxcnc-link.tool-set-id"))
        self.machine.mdi("G10 L1 P1 Z12.5")
        self.machine.wait(1)
        self.facts["tools"].append(self.host.get("linuxcnc-link.tool-set-id"))
        self.machine.mdi("G10 L1 P1 X0.5")
        self.until(lambda: self.host.get("linuxcnc-link.tool-set-id") != known, "the other tool set")

    def told(self, act=lambda: None, time=8):
        """The messages of LinuxCNC after an act. linuxcnc_link follows the computer's clock, ten times slower."""
        before = len(self.machine.errors), len(self.machine.messages)
        act()
        end = self.host.time + time
        while self.host.time < end:
            with contextlib.suppress(OperatorError):
                self.machine.wait_for(lambda _: self.host.time >= end, "messages")
        return self.machine.errors[before[0] :] + self.machine.messages[before[1] :]

    def messages(self):
        def set_pins(**pins):
            return lambda: [self.host.set("lamp." + name, value) for name, value in pins.items()]

        def beat():
            for count in range(1, 16):
                self.host.set("linuxcnc-link.panel-beat", count)
                self.machine.wait(1)

        its = self.facts["messages"] = {"of the start": self.told()}
        floor = self.host.get("growth.gate-floor")
        its["a fault"] = self.told(lambda: self.host.set("growth.gate-floor", -1))
        its["the same fault"] = self.told()
        self.host.set("growth.gate-floor", floor)
        its["late"] = self.told(lambda: self.host.load("late.hal"), 40)
        its["of the user"] = self.told(set_pins(detail=7, status=1))
        self.told(lambda: self.host.set("linuxcnc-link.panel-beat", 99), 2)
        its["behind the panel"] = [self.told(lambda: (set_pins(status=2)(), beat()), 0), self.told(time=60)]

    def keep(self):
        """A setting of today, and a record that growth has learned, as it were."""
        self.host.set("growth.window", 0.125)
        for name, value in FIELDS.items():
            self.host.set("growth.restore-" + name, value)
        saves = self.host.get("plumb-retain.saves")
        self.host.set("growth.restore", True)
        self.until(lambda: self.host.get("growth.rows") == 1, "the record")
        self.until(lambda: self.host.get("plumb-retain.saves") > saves, "the save")
        self.host.set("growth.restore", False)


if __name__ == "__main__":
    sys.exit(run(Day))

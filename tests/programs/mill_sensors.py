#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of mill_sensors_linuxcnc_test: a mill whose Modbus device goes and comes back, and that has no CAN."""

import contextlib
import os
import signal
import subprocess
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

SERVER = ["/usr/bin/python3", os.path.join(os.environ["ROOT"], "tests", "programs", "modbus_server.py"), "tcp", "1502"]
DEVICES = []  # processes
PATIENCE = 60  # s of the computer


class Sensors(Scenario):
    columns = ["axis.z.eoffset", "growth.load-valid", "growth.fault", "growth.doubt"]

    def work(self):
        machine = self.machine
        self.start_device()
        self.until("modbus-sensor.spindle-nose.valid", True)
        self.message("can-sensor.drives: ")
        machine.turn_on()
        machine.home()
        machine.mdi("G10 L2 P1 X0 Y0 Z-250")
        self.facts["nose"] = self.host.get("modbus-sensor.spindle-nose.value")
        self.facts["without CAN"] = self.host.get(["can-sensor.drives.connected", "can-sensor.spindle-load.valid", "growth.load-valid"])
        self.part(before="learn.ngc")
        told = self.told("modbus-sensor.cabinet: ")
        DEVICES[-1].kill()
        self.until("modbus-sensor.spindle-nose.valid", False)
        self.message("modbus-sensor.cabinet: ", told)
        self.until("modbus-sensor.cabinet.connected", False)
        self.part()
        self.start_device()
        self.until("modbus-sensor.spindle-nose.valid", True)
        self.until("modbus-sensor.shop.fault", False)
        self.facts["alive"] = self.host.get(["modbus-sensor.cabinet.connected", "interlock.service-lost-3"])
        self.link_dies()

    def link_dies(self):
        """With an answer that stays as it was."""
        self.machine.mdi("M64 P4")
        self.until("linuxcnc-link.identified", True)
        self.facts["link"] = [self.host.get("interlock.service-ok-1")]
        link = subprocess.check_output(["pgrep", "-f", "bin/linuxcnc_link"])
        self.host.set("interlock.service-timeout-1", 1)  # not to wait for 10 s
        os.kill(int(link), signal.SIGKILL)
        self.until("interlock.service-ok-1", False)
        self.facts["link"] += self.host.get(["linuxcnc-link.identified", "growth.enabled"])
        joints = ["joint.0.pos-cmd", "joint.2.pos-cmd"]
        self.facts["without link"] = [self.host.get(joints)]
        with contextlib.suppress(OperatorError):
            self.machine.run("part.ngc")
        self.message("linuxcnc_link has ended")
        self.facts["without link"].append(self.host.get(joints))

    def start_device(self):
        DEVICES.append(subprocess.Popen(SERVER, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))

    def part(self, before=None):
        """Messages to the operator end no part, but a refusal of LinuxCNC does."""
        if before:
            self.machine.run(before)
        self.despite_messages(lambda: self.machine.run("part.ngc"))

    def despite_messages(self, work):
        """The messages come when the devices do; LinuxCNC goes on."""
        try:
            work()
        except OperatorError:
            self.machine.abort()
            self.machine.wait(0.5)
            work()

    def until(self, pin, value):
        self.come(lambda: self.host.get(pin) == value, "%s = %s" % (pin, value))

    def told(self, text):
        return sum(one.startswith(text) for one in self.machine.errors)

    def message(self, text, before=0):
        """One more than before."""
        self.come(lambda: self.told(text) > before, text)

    def come(self, condition, what):
        """By the computer's clock: the devices' programs run on it. Messages do not end it."""
        while True:
            with contextlib.suppress(OperatorError):
                return self.machine.wait_for(lambda _: condition(), what, PATIENCE)


if __name__ == "__main__":
    try:
        status = run(Sensors, recording="shift.csv")
    finally:
        for device in DEVICES:
            device.kill()
            device.wait()
    sys.exit(status)

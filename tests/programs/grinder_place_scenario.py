#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_linuxcnc_test: an extra joint that stops amid a stroke, is pushed, or loses its encoder while off."""

import subprocess
import sys

from scenario import Scenario, run


def halcmd(line):
    subprocess.run(["halcmd", *line.split()], check=True)


class Off(Scenario):
    columns = ["scene", "motion.motion-enabled", "joint.3.homed", "chop.command", "table.position-cmd", "table.truth-position"]

    def work(self):
        self.play(self.home, self.stopped, self.on_after_stop, self.pushed, self.on_after_push, self.without_supply, self.on_without_supply,
                  self.on_with_supply, self.homed_again)

    def home(self):
        self.machine.turn_on()
        self.machine.home()
        self.machine.mdi("G80.1")

    def stop_amid_a_stroke(self):
        """Above 50 mm: the table is there for 5 s of a stroke, in which a busy computer comes to stop it, too."""
        self.machine.mdi("G81.1 Z200 Q-400 P6000")
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= 2 and self.host.get("chop.command") > 100, "the stroke")
        self.machine.emergency_stop()
        self.machine.wait(0.3)

    def turn_on(self):
        """And what is shown then."""
        self.machine.turn_on()
        self.machine.wait(0.5)
        self.facts[self.scenes[-1]] = [self.host.get("chop.fault-code"), self.host.get("chop.status-code")]

    def stopped(self):
        self.stop_amid_a_stroke()

    def on_after_stop(self):
        self.turn_on()
        self.machine.mdi("G80.1")
        self.facts["back"] = [self.host.get("chop.command"), self.host.get("chop.at-end")]

    def pushed(self):
        """120 mm by hand, in 0.4 s of the machine's time: on a busy computer this program would end the push beyond a soft limit."""
        self.machine.emergency_stop()
        self.await_pin("motion.motion-enabled", 0)
        with open("push.csv", "w", encoding="ascii") as file:
            file.write("time,table.push-speed\n0,300\n0.399,300\n0.4,0\n")
        self.host.replay("push.csv")
        self.machine.wait(0.5)

    def on_after_push(self):
        self.turn_on()
        self.machine.mdi("G80.1")

    def without_supply(self):
        """The encoder reads 0 amid the stroke."""
        self.stop_amid_a_stroke()
        halcmd("unlinkp joint.3.motor-pos-fb")
        self.host.set("joint.3.motor-pos-fb", 0)
        self.facts["told"] = self.message_of(lambda: self.machine.wait(0.3))

    def on_without_supply(self):
        self.turn_on()

    def on_with_supply(self):
        halcmd("net w-motor-fb joint.3.motor-pos-fb")
        self.machine.wait(0.5)
        self.facts["refused"] = self.message_of(lambda: self.machine.mdi("G81.1 Z200 Q-400 P24000"))

    def homed_again(self):
        self.machine.turn_off()
        self.machine.command.unhome(-1)
        self.machine.wait(0.2)
        self.turn_on()
        self.machine.home()
        self.machine.mdi("G81.1 Z40 Q-80 P6000")
        self.facts["strokes"] = [self.host.get("chop.stroking"), self.host.get("chop.fault-code")]
        self.machine.mdi("G80.1")


if __name__ == "__main__":
    sys.exit(run(Off, recording="shift.csv"))

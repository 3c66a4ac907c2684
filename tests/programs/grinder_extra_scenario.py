#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_linuxcnc_test: strokes of an extra joint, which LinuxCNC does not watch."""

import os
import subprocess
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run


def halcmd(line):
    subprocess.run(["halcmd", *line.split()], check=True)


def components():
    return subprocess.run(["halcmd", "list", "comp"], stdout=subprocess.PIPE, text=True, check=True).stdout.split()


class Shift(Scenario):
    columns = [
        "scene",
        "joint.3.motor-pos-cmd",
        "motion.current-vel",
        "joint.1.pos-cmd",
        "chop.active",
        "chop.command",
        "chop.fault-code",
        "chop.stroke-count",
        "chop.stroking",
        "chop.run",
        "motion.feed-inhibit",
        "motion.feed-hold",
    ]

    def work(self):
        self.play(
            self.turn_on,
            self.cross_feed,
            self.beyond_a_limit,
            self.program_ends,
            self.by_words,
            self.changed_settings,
            self.under_inhibit,
            self.lost_homed,
            self.learn,
            self.retain_again,
            self.emergency_stop,
            self.on_again,
            self.back_at_r,
            self.lag,
        )

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
        self.facts["message"] = self.message_of(lambda: self.machine.mdi("G81.1 Z270 Q-470 P24000"))
        self.facts["with_r"] = self.message_of(lambda: self.machine.mdi("G81.1 Z200 Q-400 R10 P24000"))

    def program_ends(self):
        """M2 without G80.1: the strokes end, and the move of the next program waits for R."""
        with open("strokes.ngc", "w") as file:
            file.write("G90 G21\nG81.1 Z200 Q-400 P24000\nG1 Y5 F600\nM2\n")
        self.machine.start("strokes.ngc")
        self.machine.wait_until_idle()
        self.await_pin("chop.stroking", 0)
        get = self.host.get
        self.machine.mdi("G1 Y0 F600")
        self.facts["after_its_move"] = [get("chop.at-end"), get("joint.1.pos-cmd")]
        self.machine.mdi("G80.1")

    def by_words(self):
        """Positions of the joint, whatever the work and the tool of Z; and the shift while it strokes."""
        self.machine.mdi("G10 L2 P1 Z-3")
        self.machine.mdi("M481 I-20 J20 P0.5 Q1")
        self.machine.mdi("G81.1 Z40 Q-80 P6000 I0.1")
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= 4, "strokes")
        self.machine.mdi("G81.1 Z60 Q-80")
        self.machine.mdi("G1 Y1 F600")
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= 9, "strokes")
        self.machine.mdi("G80.1")
        self.machine.mdi("G10 L2 P1 Z0")
        self.facts["z"] = self.host.get("joint.2.pos-cmd")

    def changed_settings(self):
        """Amid a stroke. Nothing of LinuxCNC bounds this joint."""
        self.start()
        for name, value in {"max-acceleration": 100, "jerk-time": 0.05, "max-output-accel": 10}.items():
            before = self.host.get("chop." + name)
            self.host.set("chop." + name, value)
            self.machine.wait(1)
            self.host.set("chop." + name, before)
            self.await_condition(lambda: self.host.get("chop.command") > 100, "a stroke upward")
            self.await_condition(lambda: self.host.get("chop.command") < -100, "a stroke downward")
        self.facts["hardest"] = self.host.get("chop.max-acceleration")
        self.machine.mdi("G80.1")

    def under_inhibit(self):
        """No code needs a move that waits."""
        get = self.host.get
        halcmd("unlinkp motion.feed-inhibit")
        self.host.set("motion.feed-inhibit", 1)
        self.machine.mdi("M481 I-20 J20 P0.5")
        self.machine.mdi("G81.1 Z40 Q-80 P6000")
        self.await_condition(lambda: get("chop.stroke-count") >= 2, "strokes")
        self.machine.mdi("M480")
        self.machine.mdi("G81.1 Z60 Q-100")
        self.await_condition(lambda: get("chop.command") > 59, "the shifted region")
        self.machine.mdi("G81.1 Z40 Q-80")
        last = get("chop.stroke-count")
        self.await_condition(lambda: get("chop.stroke-count") >= last + 3, "strokes")
        self.machine.mdi("G80.1 P2")
        self.facts["inhibited"] = [get("chop.command"), get("motion.feed-inhibit")]
        self.machine.mdi("G80.1")
        self.facts["inhibited_end"] = [get("chop.command"), get("chop.at-end"), get("motion.feed-inhibit")]
        self.host.set("motion.feed-inhibit", 0)
        halcmd("net chop-waits motion.feed-inhibit")

    def lost_homed(self):
        """For 8 ms amid a stroke: the table brakes and stands, and G80.1 returns it."""
        self.start()
        self.facts["homed_told"] = self.message_of(self.lose_homed)
        self.facts["lost_homed"] = [self.host.get("chop.command"), self.host.get("chop.active")]
        self.machine.mdi("G80.1")

    def lose_homed(self):
        halcmd("unlinkp chop.homed")
        self.host.set("chop.homed", 0)
        self.machine.wait(0.008)
        self.host.set("chop.homed", 1)
        halcmd("net w-homed chop.homed")
        self.machine.wait(1)

    def learn(self):
        """What plumb-retain keeps."""
        self.host.set("chop.learn", 1)
        self.machine.mdi("G81.1 Z40 Q-80 P6000")
        self.await_pin("chop.learned", 1)
        self.machine.mdi("G80.1")
        self.host.set("chop.learn", 0)

    def retain_again(self):
        """As after a restart: chopping has forgotten all. Until it is restored no stroke begins."""
        halcmd("unloadusr plumb-retain")  # which does not wait for its last look
        self.await_condition(lambda: "plumb-retain" not in components(), "the end of plumb-retain")
        self.host.set("chop.forget", 1)
        self.await_pin("chop.rows", 0)
        self.host.set("chop.forget", 0)
        self.facts["kept"] = open("extra.retained").read()
        halcmd("unlinkp chop.enable")
        self.host.set("chop.enable", 0)
        self.facts["before"] = self.message_of(lambda: self.machine.mdi("G81.1 Z200 Q-400 P24000"))
        if "enable is false" not in self.facts["before"]:  # which may come later
            self.facts["before"] += self.message_of(lambda: None)
        halcmd("loadusr -Wn plumb-retain plumb-retain --file %s" % os.path.abspath("extra.toml"))
        halcmd("net restored plumb-retain.restored chop.enable")
        self.await_pin("plumb-retain.restored", 1)
        self.facts["restored"] = self.host.get("chop.rows")

    def start(self):
        self.machine.mdi("G81.1 Z200 Q-400 P24000")
        self.await_condition(lambda: self.host.get("chop.command") < -100, "the stroke")

    def emergency_stop(self):
        self.start()
        self.machine.emergency_stop()

    def on_again(self):
        self.machine.turn_on()
        self.machine.wait(0.5)

    def back_at_r(self):
        """The axis has kept its offset: G80.1 returns it."""
        self.machine.mdi("G80.1")
        self.facts["back_at_r"] = [self.host.get("chop.command"), self.host.get("chop.at-end")]

    def lag(self):
        self.start()
        self.facts["lags"] = self.message_of(lambda: self.host.set("table.servo-gain", 4))
        self.await_pin("chop.active", 0)
        self.facts["lag"] = self.host.get("chop.fault-code")


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

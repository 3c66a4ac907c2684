#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of portal_settling_test: cuts behind changes of the tool, in all ways that LinuxCNC has to begin one."""

import sys

import linuxcnc
from scenario import Scenario, run

COLUMNS = ["scene", "motion.motion-type", "motion.current-vel", "motion.tooloffset.z", "spindle.0.revs"]
COLUMNS += ["motion.feed-inhibit", "motion.feed-hold", "motion.coord-mode"]
COLUMNS += ["square." + pin for pin in ("ramping", "settling", "unsettled-code", "fault-code")]
for number, letter in enumerate("xyz"):
    COLUMNS += ["joint.%d.pos-cmd" % number, "portal.truth-%s-error" % letter]

ENABLES = {  # name -> lines of a program before the change of the tool
    "plain": "",
    "m48": "M48",
    "m49": "M49",
    "m50": "M50 P0",
    "m51": "M51 P0",
    "m52": "M52 P1",
    "m53": "M53 P0",
    "m49_m53": "M49\nM53 P0",
    "m51_m53": "M51 P0\nM53 P0",
}
AS_BEFORE = "M48\nM50 P1\nM51 P1\nM52 P0\nM53 P1\n"
SLOWLY = 0.002  # mm/s: the change takes 6 s, in which a busy computer reaches the next events
BEGIN = "G54 G64 P0.01\nT1 M6 G43\nG0 X0 Y0 Z0\nM66 P5 L4 Q60\n"


class Shift(Scenario):
    columns = COLUMNS

    def __init__(self, machine):
        super().__init__(machine)
        self.messages = self.facts["messages"] = {}  # scene -> messages

    def work(self):
        self.begin("start")
        self.machine.turn_on()
        self.machine.home()
        self.machine.mdi("G10 L2 P1 X0 Y0 Z-270 R0")
        for name, words in ENABLES.items():
            # Both kinds of override come back in the middle of the cut, and must not stop it.
            cut = words + "\nT3 M6\nG43\nG1 X20\n" + AS_BEFORE + "G1 X40\n"
            self.scene(name, cut, rate=SLOWLY if name in ("m49_m53", "m51_m53") else 0.01)
        self.scene("g49", "G49\nG1 X20\n")
        self.scene("between_cuts", "G1 X10\nT3 M6\nG43\nG1 X20\n")
        self.scene("behind_a_rapid", "T3 M6\nG43\nG0 X10\nG1 X20\n")
        self.scene("arc", "T3 M6\nG43\nG0 X0\nG2 X10 Y10 I10\n")
        self.scene("no_longer", "T1 M6\nG43\nG1 X20\n")
        for scene in (self.mdi, self.abort, self.jog_in_both_modes, self.late, self.disable, self.in_a_cut):
            self.scene(scene.__name__, scene, rate=SLOWLY)
        for name, thread in (("thread", "G33 Z-20 K1"), ("tap", "G33.1 Z-20 K1")):
            words = "S600 M3\nG4 P1\nG43 H3\n%sG91 " + thread + "\nG90 M5\n"
            self.scene(name + "_settled", words % "M66 P5 L4 Q60\n", rate=0.1)
            self.scene(name, words % "", rate=SLOWLY)
        for pin in ("feed-inhibit", "feed-hold"):
            self.host.command("unlinkp motion." + pin)
        self.scene("without", "T3 M6\nG43\nG1 X40\n", rate=SLOWLY)

    def scene(self, name, what, rate=0.01):
        """From rest, with tool 1 in force: runs a program or a method, with this rate of the ramp."""
        self.begin(name)
        self.host.set("square.max-rate", 0.1)
        self.run(BEGIN)
        self.host.set("square.max-rate", rate)
        if callable(what):
            what()
        else:
            self.run(what)
        self.machine.poll()
        if self.host.get("square.unsettled"):
            self.machine.wait_for(lambda status: self.machine.messages, "the message", 60)
        self.messages[name] = self.machine.messages + self.machine.errors
        self.machine.messages.clear()

    def run(self, words):
        with open("settling.ngc", "w") as file:
            file.write("F3000\n" + words + "M2\n")
        self.machine.run("settling.ngc", timeout=100)

    def mdi(self):
        self.machine.mdi("T3 M6 G43")
        self.machine.mdi("G1 X20 F3000")

    def abort(self):
        """A cut that waits too long; then the next one waits for the rest."""
        self.machine.mdi("T3 M6 G43")
        self.machine.mdi("G1 X20 F3000", wait=False)
        self.machine.wait_for(lambda status: self.host.get("motion.motion-type") == linuxcnc.MOTION_TYPE_FEED, "G1")
        self.machine.abort()
        self.facts["aborted"] = [self.host.get("joint.0.pos-cmd"), self.host.get("square.settling")]
        self.machine.mdi("G1 X20 F3000")

    def jog_in_both_modes(self):
        self.machine.mdi("T3 M6 G43")
        self.machine.mode(linuxcnc.MODE_MANUAL)
        for is_joint, change in ((False, self.machine.axis_mode), (True, self.machine.joint_mode)):
            change()
            self.jog(1, 5, 50, is_joint)
            self.facts.setdefault("jogged while it ramps", []).append(self.host.get("square.ramping"))
        self.machine.axis_mode()

    def late(self):
        self.host.set("square.settling-time", 0.3)
        self.mdi()
        self.host.set("square.settling-time", 10)

    def disable(self):
        self.machine.mdi("T3 M6 G43")
        self.machine.mdi("G1 X20 F3000", wait=False)
        self.machine.wait_for(lambda status: self.host.get("motion.motion-type") == linuxcnc.MOTION_TYPE_FEED, "G1")
        self.host.command("unlinkp interlock.function-suspend-0")
        self.host.set("interlock.function-suspend-0", True)  # the switch would wait until the tool is clear
        self.machine.wait_until_idle()
        self.host.set("interlock.function-suspend-0", False)

    def in_a_cut(self):
        """Somebody sets another boring bar while it cuts."""
        self.machine.mdi("G1 X200 F3000", wait=False)
        self.machine.wait_for(lambda status: self.host.get("motion.current-vel") > 49.9, "the cut")
        self.host.set("square.radial-offset", 20)
        self.machine.wait_until_idle()
        self.host.set("square.radial-offset", 0)


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

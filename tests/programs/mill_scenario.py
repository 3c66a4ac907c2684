#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of mill_config_test: works configs/mill through a shift, and leaves a recording of each scene."""

import os
import sys

from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

COLUMNS = (
    ["motion.digital-out-%02d" % i for i in range(5)]
    + ["motion.analog-out-00", "motion.motion-type", "motion.analog-in-00", "axis.z.eoffset", "joint.2.motor-pos-cmd"]
    + ["mill.truth-growth", "mill.truth-contacts", "mill.engagement", "iocontrol.0.tool-number"]
    + ["mill.truth-cuts", "mill.truth-cut-error", "mill.truth-cut-operation", "growth.z-offset", "z-axis-stage.armed"]
    + ["growth.contacts", "growth.contacts-accepted", "growth.displacement", "growth.contact-coordinate"]
    + ["growth.answer", "growth.work-offset", "growth.tool-length"]
)
SMALL = 0.0025  # mm, of an origin


class Shift(Scenario):
    columns = COLUMNS

    def part(self, name):
        with self.record(name):
            self.machine.run("part.ngc")
            self.machine.wait(0.05)

    def work(self):
        machine = self.machine
        machine.turn_on()
        machine.home()
        self.facts["without setup"] = self.refused(lambda: machine.run("part.ngc"))
        machine.run("setup.ngc")
        self.facts["work"] = self.top()
        machine.run("learn.ngc")
        self.part("learnt")
        machine.run("grow.ngc")
        machine.host.set("interlock.function-switch-0", False)
        self.part("uncompensated")
        machine.host.set("interlock.function-switch-0", True)
        self.part("compensated")
        machine.run("grow.ngc")
        self.part("grown")
        self.abort()
        self.probe()
        self.learn_with_an_offset()
        self.compare_times()
        self.change_origins()
        self.check_growth()
        self.sum_up()

    def abort(self):
        """In the second plunge; the request to learn, which came meanwhile, is gone as well."""
        machine = self.machine
        with self.record("aborted"):
            machine.start("part.ngc")
            cuts = machine.host.get("mill.truth-cuts")
            machine.wait_for(
                lambda _: machine.host.get("mill.truth-cuts") > cuts and machine.host.get("mill.engagement") > 0.5,
                "the second plunge",
            )
            machine.abort()
            machine.wait(1)
        machine.run("learn.ngc")
        with self.record("aborted_before_learning"):
            machine.abort()
            machine.wait(0.2)

    def probe(self):
        """With an offset in force: refused; and after the offset was taken back."""
        machine = self.machine
        self.part("before_probing")
        machine.mdi("T4 M6 G43")
        machine.mdi("G0 X0 Y0 Z3")
        with self.record("refused"):
            self.facts["refusal"] = self.refused(lambda: machine.mdi("G38.2 Z-5 F100"))
            machine.wait(0.2)
        with self.record("probed"):
            machine.mdi("O <probe_work> call [20]")
            machine.wait(0.05)
        self.facts["probed"] = self.top()
        # Where the tip is now for a program that wants it at 3: with the offset in force, and without it.
        offset = self.facts["wanted"] = machine.host.get("growth.z-offset")
        machine.mdi("G0 Z[3 + %.6f]" % offset)
        machine.mdi("O <touch_off> call [3]")
        self.facts["touched off without the offset"] = self.top()
        machine.mdi("M64 P4")
        machine.wait_for(lambda _: machine.host.get("linuxcnc-link.identified"), "the program's identity")
        machine.mdi("O <cycle_start> call")
        machine.mdi("M65 P0")
        machine.mdi("G0 Z3")
        machine.mdi("O <touch_off> call [3]")
        self.facts["touched off with the offset"] = self.top()

    def learn_with_an_offset(self):
        """On a machine that grows as a spindle does: what it grows between two parts is an error of the new reference."""
        machine, host = self.machine, self.machine.host
        rate = host.get("growth.max-growth-rate")
        host.set("growth.max-growth-rate", 0.0002)
        for _ in range(3):
            machine.run("part.ngc")
        machine.mdi("M64 P2")
        self.part("learnt_again")
        self.facts["learnt again"] = host.get(["growth.learnt", "growth.learning-failed"])
        self.part("after_learning_again")
        host.set("growth.max-growth-rate", rate)

    def compare_times(self):
        """By the script of the configuration."""
        sys.path.insert(0, os.getcwd())
        import by_time

        self.facts["by time"] = {way: by_time.make_parts(self.machine, way) for way in ("time from a height", "time from a mark")}

    def change_origins(self):
        """Work, tools and zeros that change, on a machine that grows as a spindle does: by far less at once."""
        machine, host = self.machine, self.machine.host
        machine.mdi("M68 E1 Q0")  # cold
        host.set("growth.forget", True)
        machine.wait(0.1)
        host.set("growth.forget", False)
        machine.run("learn.ngc")  # no offset is wanted any more
        self.probe_work_at(0)
        host.set("growth.max-growth-rate", 0.0002)
        for _ in range(3):
            machine.run("part.ngc")
        self.probe_work_at(0.03)
        self.parts_after("higher table, probed", 1)
        host.set("work.in1", -250 + 0.06)
        self.parts_after("higher blanks", 2)
        machine.mdi("o<growth_answer> call [2]")
        self.parts_after("higher blanks, answered", 1)
        host.set("mux-gen.00.in-float-02", 62.53)
        self.parts_after("longer tool", 2)
        machine.mdi("o<growth_answer> call [2]")
        machine.mdi("G10 L2 P1 Z[#5223 - 0.008]")
        self.parts_after("another depth", 1)
        machine.mdi("o<growth_answer> call [5]")
        self.parts_after("another depth, answered", 1)
        self.touch_off("touched_off", "touch_off")
        host.set("work.in1", host.get("work.in1") + SMALL)
        self.parts_after("touched off", 1)
        self.touch_off("tool_touched_off", "touch_off_tool")
        host.set("mux-gen.00.in-float-01", host.get("mux-gen.00.in-float-01") + SMALL)
        self.parts_after("tool touched off", 1)

    def touch_off(self, scene, subroutine):
        """A change that is too small for the contacts to explain."""
        self.machine.mdi("T1 M6 G43")
        self.machine.mdi("G0 Z3")
        with self.record(scene):
            self.machine.mdi("O <%s> call [%.4f]" % (subroutine, 3 - SMALL))
            self.machine.wait(0.05)

    def check_growth(self):
        """The touch probe asks the tool setter: as it was learned, and after two shifts that look alike."""
        machine, host = self.machine, self.machine.host
        self.facts["due"] = host.get("growth.check-due")
        self.checked("at first")
        self.facts["due"] = self.facts["due"], host.get("growth.check-due")
        for name in ("checked_blanks", "checked_spindle"):
            if name == "checked_blanks":
                host.set("work.in1", host.get("work.in1") + 0.03)
            else:
                machine.mdi("M68 E1 Q0.03")
            for _ in range(2):
                machine.run("part.ngc")
            if name == "checked_blanks":
                self.facts["waits"] = self.wait_for_somebody()
            self.checked(name)
            with self.record(name):
                machine.run("part.ngc")

    def wait_for_somebody(self):
        """With at-doubt 1 the next part waits while a question is open. Returns its contacts, and then those of one that is acknowledged."""
        machine, host = self.machine, self.machine.host
        before = host.get("growth.contacts")
        host.set("growth.at-doubt", 1)
        machine.start("part.ngc")
        machine.wait(60)
        waited = host.get(["growth.wait", "growth.cycle-running"])
        contacts = [host.get("growth.contacts") - before]
        host.set("growth.acknowledge", True)
        machine.wait_until_idle()
        contacts.append(host.get("growth.contacts") - before)
        host.set("growth.acknowledge", False)
        host.set("growth.at-doubt", 0)
        return waited, contacts

    def checked(self, name):
        machine, host = self.machine, self.machine.host
        before, shift = len(machine.messages), host.get("growth.shift-size")
        machine.run("check.ngc")
        machine.wait(0.5)
        machine.poll()
        its = {pin: host.get("growth." + pin) for pin in ("check-code", "check-due", "shift-size", "growth-estimate", "surface")}
        its["messages"] = [text for text in machine.messages[before:] if "surface" in text]
        self.facts.setdefault("checked", {})[name] = {"shift": shift, **its}

    def sum_up(self):
        """A shift that ends with the next part."""
        before = len(self.machine.messages)
        self.machine.host.set("growth.summary-time", 1)
        self.machine.run("part.ngc")
        self.machine.wait(0.5)
        self.machine.poll()
        self.facts["summary"] = [text for text in self.machine.messages[before:] if "Last shift" in text]

    def probe_work_at(self, height):
        self.machine.host.set("work.in1", -250 + height)
        self.machine.run("setup.ngc")

    def parts_after(self, name, count):
        """Makes parts, and notes the growth that they show and the messages that come with them."""
        machine, host = self.machine, self.machine.host
        before, accepted = len(machine.messages), host.get("growth.contacts-accepted")
        for _ in range(count):
            machine.run("part.ngc")
            machine.wait(0.2)
        machine.poll()
        its = {pin: host.get("growth." + pin) for pin in ("doubt", "growth-estimate", "shift-size", "origin-change")}
        its["accepted"] = host.get("growth.contacts-accepted") - accepted
        its["messages"] = [text for text in machine.messages[before:] if text.startswith("Growth of Z")]
        self.facts.setdefault("origins", {})[name] = its

    def refused(self, work):
        """The message of LinuxCNC, which aborts."""
        try:
            work()
        except OperatorError as error:
            self.machine.abort()
            return str(error)
        raise AssertionError("it was carried out")

    def top(self):
        """Z of G54."""
        return self.machine.poll().g5x_offset[2]


if __name__ == "__main__":
    sys.exit(run(Shift))

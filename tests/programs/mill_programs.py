#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of mill_programs_linuxcnc_test: a shop that makes two parts in turn on configs/mill, on the first and on the second day.

Each part is a scene: what its cuts have missed, in mm, what was said, and the status after it.
"""

import contextlib
import json
import sys

import linuxcnc
from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

um = 1e-3
NAME = sys.argv[-1]  # of the day


class Day(Scenario):
    def work(self):
        self.facts["parts"] = []
        self.machine.turn_on()
        self.machine.home()
        getattr(self, NAME)()

    def first(self):
        machine, host = self.machine, self.machine.host
        machine.run("setup.ngc")
        machine.run("learn.ngc")
        self.part("part.ngc", "learns cold", 0)
        for growth in (3, 6, 9):
            self.part("part.ngc", "part, %d um" % growth, growth)
        self.part("other.ngc", "without a reference", 9)
        machine.run("learn.ngc")
        self.abort("other.ngc")
        self.part("part.ngc", "after a learning part that was aborted", 11)
        machine.run("learn.ngc")
        self.part("other.ngc", "learns warm", 11)
        self.part("other.ngc", "other, 13 um", 13)
        self.part("part.ngc", "part, 15 um", 15)
        self.comment("other.ngc")
        self.part("other.ngc", "with an edited comment", 17)
        machine.command.feedrate(0.8)
        self.part("other.ngc", "override of 80 %", 17)
        machine.command.feedrate(1)
        host.set("work.in1", -250 + 0.03)
        machine.run("setup.ngc")
        self.part("part.ngc", "higher table, probed", 17)
        self.part("other.ngc", "other on the higher table", 18)
        self.facts["zero"] = machine.poll().g5x_offset[2]

    def second(self):
        self.host.set("work.in1", -250 + 0.03)
        with open("first.json") as file:
            self.machine.mdi("G10 L2 P1 X0 Y0 Z%.6f R0" % json.load(file)["facts"]["zero"])
        for growth in (18, 18, 18):
            self.part("other.ngc", "other on the second day", growth)
        self.part("part.ngc", "part on the second day", 18)

    def part(self, program, name, growth):
        machine, host = self.machine, self.machine.host
        machine.mdi("M68 E1 Q%g" % (growth * um))
        said, made, errors = len(machine.messages), host.get("mill.truth-cuts"), []
        machine.start(program)
        while not errors or machine.poll().interp_state != linuxcnc.INTERP_IDLE:
            with contextlib.suppress(OperatorError):
                machine.wait(0.2)
            if host.get("mill.truth-cuts") > made:
                made = host.get("mill.truth-cuts")
                errors.append(host.get("mill.truth-cut-error"))
        machine.wait(1)
        machine.poll()
        texts = [text for text in machine.messages[said:] if text.startswith("Growth of Z")]
        pins = {pin: host.get("growth." + pin) for pin in ("status-code", "detail-code", "growth-estimate", "z-offset", "shift-size", "rows")}
        self.facts["parts"].append({"name": name, "growth": growth * um, "errors": errors, "said": texts, **pins})

    def abort(self, program):
        machine, host = self.machine, self.machine.host
        made = host.get("mill.truth-cuts")
        machine.start(program)
        machine.wait_for(lambda _: host.get("mill.truth-cuts") > made and host.get("mill.engagement") > 0.5, "the second plunge")
        machine.abort()
        machine.wait(1)

    def comment(self, program):
        with open(program) as file:
            lines = file.read()
        with open(program, "w") as file:
            file.write(lines.replace("; Another part", "; An edited comment of another part"))


if __name__ == "__main__":
    sys.exit(run(Day, facts=NAME + ".json"))

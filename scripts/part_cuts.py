#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of part_bench: cuts its parts without correction, with the tilts corrected, and with error tables.

Each cut leaves PROGRAM-RUN.csv, a row for each servo cycle, and says so.
"""

import argparse
import csv
import sys

import linuxcnc
from part_bench import COLUMNS, MACHINES, PARTS, RUNS
from plumb_linuxcnc import Machine

STEPS = 20  # of the instrument along each axis


class Cuts:
    def __init__(self, machine, kind, parts):
        self.machine = machine
        self.host = machine.host
        self.kind = kind
        self.parts = parts

    def make(self):
        self.machine.turn_on()
        self.machine.home()
        for run in RUNS:
            self.host.set("correct.in0", run != "without")
            if run == "with tables":
                self.gauge("errors.csv")
                self.reload()
            self.machine.wait(0.1)
            for part in self.parts:
                program = MACHINES[self.kind].prefix + part + ".ngc"
                with self.machine.recording(f"{part}-{run}.csv", COLUMNS):
                    self.machine.run(program)
                self.expect_no_fault()
                print(f"cut {program} {run}", flush=True)
        self.machine.turn_off()

    def expect_no_fault(self):
        for code in ["square.fault-code", "square.limited-code"] + [f"{letter}-stage.fault-code" for letter in "xyz"]:
            if self.host.get(code):
                raise RuntimeError(f"{code} is {self.host.get(code)}")

    def gauge(self, path):
        """Writes all error motions of all axes as error tables."""
        motions = ("ex", "ey", "ez", "ea", "eb", "ec")
        ini = linuxcnc.ini(self.machine.status.ini_filename)
        with open(path, "w", newline="", encoding="ascii") as file:
            writer = csv.writer(file)
            for number, letter in enumerate("XYZW"[: self.machine.status.joints]):
                low, high = (float(ini.find("JOINT_%d" % number, limit)) for limit in ("MIN_LIMIT", "MAX_LIMIT"))
                self.host.set("portal.gauge-axis", number)
                writer.writerow([letter] + [motion.upper() + letter for motion in motions])
                for step in range(STEPS + 1):
                    position = low + (high - low) * step / STEPS
                    self.host.set("portal.gauge-position", position)
                    self.machine.wait(0.01)
                    measured = self.host.get(["portal.truth-gauge-" + motion for motion in motions])
                    writer.writerow([repr(float(value)) for value in (position, *measured)])

    def reload(self):
        serial = self.host.get("square.serial")
        self.host.set("square.reload", True)
        for _ in range(200):
            self.machine.wait(0.05)
            if self.host.get("square.serial") == serial + 1:
                return
        raise RuntimeError("squareness did not take the tables over")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-ini", required=True, help=argparse.SUPPRESS)  # linuxcnc gives it to every DISPLAY
    parser.add_argument("parts", nargs="+", choices=PARTS)
    options = parser.parse_args()
    with Machine() as machine:
        Cuts(machine, "portal" if machine.status.joints == 4 else "column", options.parts).make()
    return 0


if __name__ == "__main__":
    sys.exit(main())

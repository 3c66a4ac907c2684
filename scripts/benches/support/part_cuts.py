#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of the bench part: cuts its parts, as often as there are RUNS.

Each cut leaves PROGRAM-RUN.csv, a row for each servo cycle, and prints its name.
"""

import argparse
import os
import re
import subprocess
import sys

import linuxcnc

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from support.part_inspection import lengths_of_diagonals
from support.part_machines import COLUMNS, FEED, MACHINES, PARTS, RUNS, read_recording
from support.portal_machine import CHAINS, LEANING
from support.recordings import write_error_tables
from support.simulations import BUILD
from plumb_linuxcnc import Machine  # found by `simulations`

# s since tilts and tables were measured, when a run begins, and when a part of it does. The machine drifts by these,
# so that neither the speed of the clock nor a busy computer changes a figure.
RUN_BEGINS = dict(zip(RUNS, (3611, 3774, 3952, 4122)))
PART_BEGINS = {"square": 0, "contour": 58}
STEPS = 20  # of the instrument along each axis


class Cuts:
    def __init__(self, machine, kind, parts, feed):
        self.machine = machine
        self.host = machine.host
        self.kind = kind
        self.parts = parts
        self.feed = feed
        self.expected = {}  # by the host's number of it

    def make(self):
        self.machine.turn_on()
        self.machine.home()
        if self.feed != FEED:
            self.machine.command.feedrate(self.feed / FEED)
        self.machine.wait(1)  # the correction comes
        self.expect_no_fault()
        tilts = {name: self.host.get("square." + name) for name in LEANING[self.kind]}
        for run in RUNS:
            self.host.set("interlock.function-switch-0", run != "without")
            if run == "by diagonals":
                self.set_tilts(self.tilts_by_diagonals(tilts))
            elif run == "with tables":
                self.set_tilts(tilts)
                self.gauge("errors.csv")
                self.reload()
            self.machine.wait(0.1)
            for part in self.parts:
                program = MACHINES[self.kind].prefix + part + ".ngc"
                self.drift_until(RUN_BEGINS[run] + PART_BEGINS[part])
                with self.machine.recording(f"{part}-{run}.csv", COLUMNS):
                    self.machine.run(program)
                for violation in self.host.violations():
                    raise RuntimeError(f"{self.expected[violation.id]} was {violation.values['code']:g} while {program} was cut {run}")
                print(f"cut {program} {run}", flush=True)
        self.machine.turn_off()

    def drift_until(self, seconds):
        """Has the machine drift as if its tilts had been measured so many seconds ago."""
        if self.host.get("portal.seed"):
            self.host.set("portal.drift-start", seconds - self.running_for())

    def running_for(self):
        """Seconds that the machine has run, by how far it has drifted in them and would drift in an hour more."""
        angle = LEANING[self.kind][0]
        drifts = []
        for start in (0, 3600):
            self.host.set("portal.drift-start", start)
            self.machine.wait(0.002)
            drifts.append(self.host.get("portal.truth-" + angle) - self.host.get("portal." + angle))
        return 3600 * drifts[0] / (drifts[1] - drifts[0])

    def expect_no_fault(self):
        """From now on, in every period."""
        codes = ["square.fault-code", "square.limited-code"]
        codes += [f"{letter}-stage.{pin}" for letter in "xyz" for pin in ("fault-code", "limited")]
        self.expected = {self.host.expect("code == 0", code=code): code for code in codes}

    def set_tilts(self, tilts):
        for name, angle in tilts.items():
            self.host.set("square." + name, angle)

    def tilts_by_diagonals(self, known):
        """The tilts that `plumb squareness` finds by the diagonals of the square cut without correction; the tilts that
        show in another plane are given."""
        kind, part = MACHINES[self.kind], self.parts[0]
        samples, _ = read_recording(f"{part}-without.csv", kind)
        rising, falling = lengths_of_diagonals(part, samples)
        words = [f"--iso={name.upper()}={angle!r}rad" for name, angle in known.items() if name != kind.shown]
        words.append(f"--diagonals=plane={kind.names},object=part,rising={rising:.4f}mm,falling={falling:.4f}mm,u=1um")
        command = [os.path.join(BUILD, "bin", "plumb"), "squareness", "--chain", CHAINS[self.kind], *words]
        printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        found = dict(re.findall(r"^ *setp square\.(e[abc]0\w) +(\S+)", printed, re.M))
        print("set " + ", ".join(f"{name} {found[name]}" for name in found), flush=True)
        return {name: float(found[name]) for name in known}

    def gauge(self, path):
        """Writes all error motions of all axes as error tables."""
        motions = ("ex", "ey", "ez", "ea", "eb", "ec")
        ini = linuxcnc.ini(self.machine.status.ini_filename)
        tables = []
        for number, letter in enumerate("XYZW"[: self.machine.status.joints]):
            low, high = (float(ini.find("JOINT_%d" % number, limit)) for limit in ("MIN_LIMIT", "MAX_LIMIT"))
            self.host.set("portal.gauge-axis", number)
            rows = []
            for step in range(STEPS + 1):
                position = low + (high - low) * step / STEPS
                self.host.set("portal.gauge-position", position)
                self.machine.wait(0.01)
                rows.append((position, *self.host.get(["portal.truth-gauge-" + motion for motion in motions])))
            tables.append((letter, [motion.upper() + letter for motion in motions], rows))
        write_error_tables(path, tables, f"simulated {self.kind} {self.host.get('portal.seed')}")

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
    parser.add_argument("--feed", type=float, default=FEED)
    parser.add_argument("parts", nargs="+", choices=PARTS)
    options = parser.parse_args()
    with Machine() as machine:
        Cuts(machine, "portal" if machine.status.joints == 4 else "column", options.parts, options.feed).make()
    return 0


if __name__ == "__main__":
    sys.exit(main())

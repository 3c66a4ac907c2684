# SPDX-License-Identifier: GPL-2.0-or-later
"""The machines that cut the parts of the bench part: configs/portal, a complete LinuxCNC in virtual time."""

import dataclasses
import os

import numpy as np

from support.part_inspection import Samples
from support.portal_machine import draw_tilts
from support.recordings import blank_table, read_columns, write_error_tables
from support.simulations import BENCHES, ROOT

CONFIGURATION = os.path.join(ROOT, "configs", "portal")

RUNS = ("without", "with tilts", "by diagonals", "with tables")
PARTS = ("square", "contour")
FEED = 2400  # mm/min, as in the G-code

COLUMNS = [f"portal.truth-{axis}-{what}" for what in ("nominal", "error", "beyond-tilts") for axis in "xyz"]


@dataclasses.dataclass(frozen=True)
class Kind:
    prefix: str  # of its G-code files
    plane: tuple  # numbers of the axes that draw the part: to the right and up
    into: int  # number of the axis that leads into the work
    way: int  # and whether by going up or down
    origin: tuple  # of the part, mm
    shown: str  # the tilt that diagonals in this plane show
    axes: tuple  # parts of its INI file

    @property
    def names(self):
        return "".join("XYZ"[axis] for axis in self.plane)


XYZ = ("common/x_axis", "common/y_axis", "common/z_axis")
MACHINES = {
    "column": Kind("", (0, 1), 2, -1, (0, 0, -340), "ec0y", ("common/xyz", *XYZ)),
    "portal": Kind("portal_", (0, 2), 1, 1, (0, 150, -275), "eb0z", ("xyzw", *XYZ, "w_axis")),
}


INI = """\
[EMC]
VERSION = 1.1
MACHINE = Plumb {kind}

#INCLUDE common/display.inc
DISPLAY = {display}

[TASK]
TASK = milltask
CYCLE_TIME = 0.001

# Task gives motion up after a time of the faster clock, which passes on a busy computer.
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
COMM_TIMEOUT = 300

#INCLUDE tools.inc

# The file of a run; the disk may keep LinuxCNC waiting.
#INCLUDE common/interpreter.inc
SUBROUTINE_PATH = .
PARAMETER_FILE = /dev/shm/linuxcnc.var

{axes}
#INCLUDE {kind}_hal.inc
HALFILE = part_machine.hal
"""


def prepare(kind, seed, folder):
    """Links to the files of the configuration, and beside them the bench's own; returns the INI file and the options of
    modules for machine `seed`."""
    machine = os.path.join(folder, "machine")
    os.mkdir(machine)
    for name in os.listdir(CONFIGURATION):
        os.symlink(os.path.join(CONFIGURATION, name), os.path.join(machine, name))
    at = lambda name: os.path.join(machine, name)
    axes = "".join(f"#INCLUDE {name}.inc\n" for name in MACHINES[kind].axes)
    with open(at("part.ini"), "x", encoding="utf-8") as file:
        file.write(INI.format(kind=kind, display=os.path.join(BENCHES, "support", "part_cuts.py"), axes=axes))
    tilts = draw_tilts(kind, seed) if seed else {}  # machine 0 is that of the configuration
    settings = [f"{part}.{name} {angle!r}" for name, angle in tilts.items() for part in ("square", "portal")]
    settings.append(f"portal.seed {seed}")
    with open(at("part_machine.hal"), "x", encoding="utf-8") as file:
        file.write("".join(f"setp {line}\n" for line in settings))
    letters = "XYZW" if kind == "portal" else "XYZ"
    write_error_tables(at("errors.csv"), [blank_table(letter, -1000, 1000) for letter in letters], f"ideal {kind}")
    return at("part.ini"), {"squareness.table": at("errors.csv")}


def read_recording(path, kind):
    """Samples as they are, and Samples with the errors only that no tilt describes."""
    column = read_columns(path)
    nominal, error, beyond = np.array([column[name] for name in COLUMNS]).reshape(3, 3, -1)
    axes, ways = [*kind.plane, kind.into], np.array((1, 1, kind.way))
    nominal = (nominal.T - kind.origin)[:, axes] * ways
    return tuple(Samples(nominal, its.T[:, axes] * ways) for its in (error, beyond))

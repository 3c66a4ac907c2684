# SPDX-License-Identifier: GPL-2.0-or-later
"""The machines of the bench volume: measured by simulated instruments, corrected by squareness, and judged in truth.

The truth is a product of poses in numpy. It shares nothing with the chain of squareness and of plumb volume.
"""

import contextlib
import csv
import dataclasses
import os
import random

import numpy as np

from support.programs import program

CHAIN = "w-X.b-Y-Z-C-t"
BOX = {"X": (0, 800), "Y": (0, 600), "Z": (-500, 0)}
TOOL = 200  # mm
UM, URAD = 1000, 1e6
READING, SQUARE = 0.0005, 3e-6  # mm of an indicator, rad of the square itself: standard
LASER, LASER_SCALE = 0.0003, 0.8e-6  # mm of a row, and 1 for all rows
STEP = 50  # mm between the rows of a table

# Tilt, how it is read: the axis that moves, the direction of the plunger, and the reading on 300 mm.
SQUARES = {"EC0Y": ("Y", "+X", -1), "EB0Z": ("Z", "+X", 1), "EA0Z": ("Z", "+Y", -1)}


@dataclasses.dataclass
class Machine:
    seed: int
    tilts: dict  # rad
    scales: dict  # axis -> (linear, quadratic, half of the lost motion in mm)

    def own(self, axis, position, direction):
        linear, quadratic, half = self.scales[axis]
        low, high = BOX[axis]
        u = (position - low) / (high - low)
        return linear * (position - low) + quadratic * u * (1 - u) - direction * half

    def tip(self, position, direction):
        """X, Y and Z of the tip in the work, the axes at a position, having moved in a direction: one for each, or of all."""
        x, y, z = (value + self.own(axis, value, way) for axis, value, way in zip("XYZ", position, np.broadcast_to(direction, 3)))
        in_head = turned(self.tilts, "Z") @ np.array([0, 0, z - TOOL])
        return turned(self.tilts, "Y") @ (np.array([0, y, 0]) + in_head) + np.array([x, 0, 0])


def turned(tilts, axis):
    a, b, c = (tilts.get(f"E{letter}0{axis}", 0) for letter in "ABC")
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def draw(seed):
    drawn = random.Random(f"volume {seed}")
    tilts = {name: drawn.gauss(0, 60e-6) for name in SQUARES}
    scales = {axis: (drawn.gauss(0, 15e-6), drawn.gauss(0, 0.01), drawn.uniform(0, 0.01)) for axis in BOX}
    return Machine(seed, tilts, scales)


def measure(machine, folder):
    """The tilts that plumb squareness gives, each with u, and the files of the tables."""
    drawn = random.Random(f"instruments {machine.seed}")
    own = drawn.gauss(0, SQUARE), drawn.gauss(0, SQUARE), drawn.gauss(0, SQUARE)
    tilts = {}
    for (name, (moved, plunger, sign)), square in zip(SQUARES.items(), own):
        top = sign * machine.tilts[name] * 300 + square * 300 + drawn.gauss(0, READING)
        bottom = drawn.gauss(0, READING)
        words = f"move={moved},plunger={plunger},at=0:300mm,reads={bottom * UM:.4f}:{top * UM:.4f}um,u={READING * UM}um,own-u={SQUARE * URAD}urad"
        found = program("plumb-squareness", "--json", "--chain", CHAIN, "--square", words)["quantities"]
        tilts[name] = found[0]["angle"], found[0]["uncertainty"]
    tables = []
    for axis, (low, high) in BOX.items():
        scale = drawn.gauss(0, LASER_SCALE)
        rows = []
        for position in range(low - STEP, high + STEP + 1, STEP):
            # Both directions in one run: each row has its own noise, and half of the difference another.
            mean, half = (machine.own(axis, position, 1) + machine.own(axis, position, -1)) / 2, -machine.scales[axis][2]
            mean += scale * (position - low) + drawn.gauss(0, LASER)
            half += drawn.gauss(0, LASER)
            rows.append((position, mean + half, mean - half))
        path = os.path.join(folder, axis + ".csv")
        error = f"E{axis}{axis}"
        with open(path, "w", encoding="ascii", newline="") as file:
            file.write(f"# u: {error} {LASER}, {error}+ {LASER}\n# u-common: {error} {LASER_SCALE} per {axis}\n")
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([axis, error + "+", error + "-"])
            writer.writerows(rows)
            file.write(f"# end, {len(rows)} rows\n")
        tables.append(path)
    return tilts, tables


def corrected(host, position, direction):
    """The correction of squareness, after motion to a position in a direction."""
    for way in (direction * 2, 0):
        for axis, value in zip("xyz", position):
            host.set(f"square.{axis}-position", value - way)
        host.run(0.1)
    return np.array(host.get([f"square.{axis}-correction" for axis in "xyz"]))


@dataclasses.dataclass
class Outcome:
    seed: int
    errors: np.ndarray  # um, of the distance of 8 corners to the reference place, by axis
    U_axis: np.ndarray  # um, as stated
    U: np.ndarray  # um
    without: float  # um, the largest error without correction
    shares: list


def simulate(seed, progress):
    import plumb
    from plumb_folder import TemporaryFolder

    machine = draw(seed)
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(TemporaryFolder())
        tilts, tables = measure(machine, folder)
        box = ",".join(f"{axis}={low}:{high}" for axis, (low, high) in BOX.items())
        options = [word for name, (angle, u) in tilts.items() for word in ("--tilt", f"{name}={angle!r}rad,u={u!r}rad")]
        options += [word for table in tables for word in ("--table", table)]
        stated = program("plumb-volume", "uncertainty", "--chain", CHAIN, "--box", box, "--tool", f"T1=0,0,{-TOOL}", "--json", *options)
        host = stack.enter_context(plumb.Host(options={"squareness.chain": CHAIN, "squareness.table": ":".join(tables)}))
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt squareness names=square interlock=no", "addf square.update servo-thread", "start"):
            host.command(line)
        pins = {"max-speed": 1e5, "max-rate": 10, "enable": True, "all-homed": True, "z-tool-offset": TOOL}
        pins.update({name.lower(): angle for name, (angle, _) in tilts.items()})
        for name, value in pins.items():
            host.set("square." + name, value)
        directions = random.Random(f"directions {seed}")
        reference = tuple(low for low, _ in BOX.values())

        def error(place):
            direction = directions.choice((-1, 1))
            there = np.array(place) + corrected(host, place, direction)
            return machine.tip(there, direction) - (np.array(place) + [0, 0, -TOOL])

        def bare(place):
            return machine.tip(place, 1) - (np.array(place) + [0, 0, -TOOL])

        zero = error(reference)
        errors, U_axis, U, without = [], [], [], 0
        for its in stated["places"]:
            if tuple(its["at"]) == reference or any(value not in BOX[axis] for axis, value in zip("XYZ", its["at"])):
                continue
            errors.append((error(its["at"]) - zero) * UM)
            U_axis.append(np.array(its["U_axis"]) * UM)
            U.append(its["U"] * UM)
            without = max(without, np.linalg.norm(bare(its["at"]) - bare(reference)) * UM)
        progress(1)
        return Outcome(seed, np.array(errors), np.array(U_axis), np.array(U), without, stated["shares"])

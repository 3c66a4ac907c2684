# SPDX-License-Identifier: GPL-2.0-or-later
"""Machines that have every error of the list of plumb volume, for the bench volume --list.

Their errors come from another distribution than the list's: one of five is drawn twice as wide. The truth is a product of poses in
numpy, with a second axis that bends the first one, lost motion that varies, warmth, and a drift while the machine is measured.
"""

import contextlib
import csv
import dataclasses
import io
import math
import os
import random
import subprocess

import numpy as np

from support.programs import program
from support.simulations import BUILD
from support.volume_machine import BOX, CHAIN, SQUARES, TOOL, UM, corrected

WAYS = ("assumed", "measured")
# Standard deviations of the drawn errors; the sheet has the same, as u.
CORNER, SCALE, STRAIGHT, ANGLE, LOST, REPEAT, SECOND, BEND = 20e-6, 0.004, 0.003, 10e-6, 0.005, 0.0005, 0.0015, 3e-6  # rad, mm, rad per K
GAUGE, LEVEL, SQUARE, LASER_SCALE = 0.0003, 0.5e-6, 3e-6, 0.8e-6  # of instruments: mm, rad, rad, 1
DRIFT = 0.0008  # mm from one run to the next, while an axis is measured
KELVIN, THERMOMETER, MEASURED_AT = 2, 0.2, 20
RUNS, STEP = 5, 100
TILTS = {"XY": "EC0Y", "XZ": "EB0Z", "YZ": "EA0Z"}


def wide(drawn):
    """Of standard deviation 1; one of five has twice the spread of the others."""
    return drawn.gauss(0, 2 if drawn.random() < 0.2 else 1) / math.sqrt(1.6)


@dataclasses.dataclass
class Machine:
    seed: int
    tilts: dict  # rad
    shapes: dict  # (axis, error) -> amplitudes of a line, a bow and a wave, in mm or rad
    lost: dict  # axis -> (mean in mm, its change along the travel)
    second: np.ndarray  # mm, of the tip at the far corner of each pair of axes
    warmed: float  # K
    growth: dict  # axis -> 1/K
    bending: dict  # tilt -> rad/K
    drift: float  # mm a run
    warm: bool = True

    def error(self, axis, position, way, drawn=None):
        """The six errors of an axis, after motion to an end; `drawn` varies the lost motion."""
        low, high = BOX[axis]
        t = (position - low) / (high - low)
        found = np.array([a * (2 * t - 1) + b * (4 * t * (1 - t)) + c * math.sin(5 * t) for a, b, c in (self.shapes[axis, e] for e in range(6))])
        mean, change = self.lost[axis]
        half = mean / 2 * (1 + change * (2 * t - 1)) * (1 + (drawn.gauss(0, 0.05) if drawn else 0))
        found["XYZ".index(axis)] -= way * half
        if self.warm:
            found["XYZ".index(axis)] += self.growth[axis] * self.warmed * (position - low)
        return found

    def tip(self, position, way):
        """In the work."""
        poses = {}
        for axis, value, its in zip("XYZ", position, np.broadcast_to(way, 3)):
            error = self.error(axis, value, its)
            move = np.eye(3)["XYZ".index(axis)] * value + error[:3]
            tilt = {name: self.tilts.get(name, 0) + (self.bending.get(name, 0) * self.warmed if self.warm else 0) for name in (f"E{about}0{axis}" for about in "ABC")}
            poses[axis] = rotation(*tilt.values()), (-1 if axis == "X" else 1) * move, rotation(*error[3:])
        in_y = poses["Y"][0] @ (poses["Y"][1] + poses["Y"][2] @ poses["Z"][0] @ (poses["Z"][1] + poses["Z"][2] @ np.array([0, 0, -TOOL])))
        out = in_y
        tilt, move, turn = poses["X"]
        tip = turn.T @ (tilt.T @ out - move)
        y, z = ((value - BOX[axis][0]) / (BOX[axis][1] - BOX[axis][0]) for axis, value in zip("YZ", position[1:]))
        return tip + self.second * 2 * y * z


def rotation(a, b, c):
    ca, sa, cb, sb, cc, sc = math.cos(a), math.sin(a), math.cos(b), math.sin(b), math.cos(c), math.sin(c)
    return np.array([[cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa], [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa], [-sb, cb * sa, cb * ca]])


def draw(seed):
    drawn = random.Random(f"list {seed}")
    shapes = {}
    for axis in "XYZ":
        for e in range(6):
            size = ANGLE if e > 2 else SCALE if e == "XYZ".index(axis) else STRAIGHT
            shapes[axis, e] = [part * size * wide(drawn) for part in (0.64, 0.8, 0.3)]
    return Machine(
        seed,
        {name: CORNER * wide(drawn) for name in TILTS.values()},
        shapes,
        {axis: (abs(LOST * wide(drawn)), drawn.uniform(-0.3, 0.3)) for axis in "XYZ"},
        np.array([SECOND * wide(drawn) for _ in range(3)]),
        KELVIN * wide(drawn),
        {axis: drawn.choice((11.5e-6, drawn.uniform(0, 11.5e-6))) for axis in "XYZ"},
        {name: BEND * wide(drawn) for name in TILTS.values()},
        DRIFT * wide(drawn),
    )


def sheet(folder, without=()):
    """All errors that the machine may have, with their source."""
    rows = [(corner, f"{CORNER * 1e6}urad") for corner in TILTS]
    for axis in "XYZ":
        rows += [(f"E{along}{axis}", f"{(SCALE if along == axis else STRAIGHT) * UM}um") for along in "XYZ"]
        rows += [(f"E{about}{axis}", f"{ANGLE * 1e6}urad") for about in "ABC"]
        rows += [(f"lost motion {axis}", f"{LOST * UM}um"), (f"repeatability {axis}", f"{REPEAT * UM}um")]
    rows += [("second axis", f"{SECOND * UM}um"), ("bending", f"{BEND * 1e6}urad/K")]
    path = os.path.join(folder, "sheet.csv")
    with open(path, "w", encoding="ascii", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerows([("error", "u", "source"), *((*row, "drawn machines") for row in rows if row[0] not in without)])
    return path


def measure(machine, folder):
    """Options of plumb volume for the tilts and tables, measured with the machine at its first temperature; and those for squareness."""
    drawn = random.Random(f"list instruments {machine.seed}")
    cold = dataclasses.replace(machine, warm=False)
    options, tilts, tables = [], {}, []
    for name, (moved, plunger, sign) in SQUARES.items():
        own = drawn.gauss(0, SQUARE)
        bottom, top = drawn.gauss(0, GAUGE), sign * machine.tilts[name] * 300 + own * 300 + drawn.gauss(0, GAUGE)
        words = f"move={moved},plunger={plunger},at=0:300mm,reads={bottom * UM:.4f}:{top * UM:.4f}um,u={GAUGE * UM}um,own-u={SQUARE * 1e6}urad"
        found = program("plumb-squareness", "--json", "--chain", CHAIN, "--square", words)["quantities"][0]
        tilts[name] = found["angle"]
        options += ["--tilt", f"{name}={found['angle']!r}rad,u={found['uncertainty']!r}rad,by=square"]
    for axis, (low, high) in BOX.items():
        places = range(low, high + 1, STEP)
        scale, run_drift, own = drawn.gauss(0, LASER_SCALE), machine.drift, "XYZ".index(axis)
        readings = {}
        for run in range(RUNS):
            for way, order in ((1, places), (-1, reversed(places))):
                for nth, place in enumerate(order):
                    time = run + (0 if way > 0 else 0.5) + 0.5 * nth / len(places)
                    value = cold.error(axis, place, way, drawn)[own] + scale * (place - low) + run_drift * time + drawn.gauss(0, math.hypot(REPEAT, GAUGE))
                    readings[place, way, run] = value
        names = [f"{way}{run + 1}" for way in ("up", "down") for run in range(RUNS)]
        path = os.path.join(folder, axis + "_readings.csv")
        with open(path, "w", encoding="ascii") as file:
            file.write("position," + ",".join(names) + "\n")
            for place in places:
                file.write(f"{place}," + ",".join(f"{readings[place, way, run]:.6f}" for way in (1, -1) for run in range(RUNS)) + "\n")
        scales = os.path.join(folder, axis + "_scale.csv")
        done = subprocess.run([os.path.join(BUILD, "bin", "plumb-volume"), "reversal", path, "--axis", axis, "--scale", "--scale-u", f"{LASER_SCALE * 1e6}um/m", "--leads", "--output", scales], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stderr)
        with open(scales, encoding="ascii") as file:
            lines = [line for line in file.read().splitlines() if line and not line.startswith("# end")]
        heads = [line for line in lines if line.startswith("#")] + [f"# temperature: {MEASURED_AT} degC"]
        names, *rows = list(csv.reader(io.StringIO("\n".join(line for line in lines if not line.startswith("#")))))
        for e in range(6):
            if e == own:
                continue
            u = LEVEL if e > 2 else GAUGE
            name = "E" + "XYZABC"[e] + axis
            heads.append(f"# u: {name} {u}")
            names.append(name)
            for row in rows:
                row.append(repr(cold.error(axis, float(row[0]), 0)[e] + drawn.gauss(0, u)))
        table = os.path.join(folder, axis + ".csv")
        with open(table, "w", encoding="ascii") as file:
            file.write("\n".join([*heads, ",".join(names), *map(",".join, rows), f"# end, {len(rows)} rows"]) + "\n")
        tables.append(table)
    return options + [word for table in tables for word in ("--table", table)], tilts, tables


@dataclasses.dataclass
class Outcome:
    seed: int
    errors: dict  # way -> um, of distances to the reference place, by axis
    U_axis: dict
    U: dict
    along: dict  # way -> um, of the length of the distance
    open_states: list  # of a statement without one line: at_least, and whether the line is unknown


def stated(folder, machine, options):
    drawn = random.Random(f"list thermometer {machine.seed}")
    now = MEASURED_AT + machine.warmed + drawn.gauss(0, THERMOMETER)
    box = ",".join(f"{axis}={low}:{high}" for axis, (low, high) in BOX.items())
    return program("plumb-volume", "uncertainty", "--chain", CHAIN, "--box", box, "--tool", f"T1=0,0,{-TOOL}", "--temperature", f"{now:.3f}degC", "--json", *options)


def simulate(seed, progress):
    import plumb
    from plumb_folder import TemporaryFolder

    machine = draw(seed)
    outcome = Outcome(seed, {}, {}, {}, {}, [])
    directions = random.Random(f"list directions {seed}")
    reference = np.array([low for low, _ in BOX.values()])
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(TemporaryFolder())
        measured, tilts, tables = measure(machine, folder)
        whole = sheet(folder)
        statements = {"assumed": stated(folder, machine, ["--assume", whole]), "measured": stated(folder, machine, [*measured, "--assume", whole])}
        missing = directions.choice([*TILTS, "EYX", "EAZ", "EZZ", "lost motion Y", "repeatability X", "second axis", "bending"])
        without = stated(folder, machine, ["--assume", sheet(folder, (missing,))])
        outcome.open_states = [without["at_least"], [its["name"] for its in without["errors"] if its["state"] == "unknown"] == [missing]]
        host = stack.enter_context(plumb.Host(options={"squareness.chain": CHAIN, "squareness.table": ":".join(tables)}))
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt squareness names=square interlock=no", "addf square.update servo-thread", "start"):
            host.command(line)
        host.set({"square." + name: value for name, value in {"max-speed": 1e5, "max-rate": 10, "enable": True, "all-homed": True, "z-tool-offset": TOOL, **{name.lower(): angle for name, angle in tilts.items()}}.items()})
        for way in WAYS:
            if statements[way]["at_least"]:
                raise RuntimeError(f"machine {seed}, {way}: a line of the list is open")

            def error(place, way=way):
                direction = directions.choice((-1, 1))
                moved = corrected(host, tuple(map(float, place)), direction) if way == "measured" else 0
                return machine.tip(place + moved, direction) - (place + [0, 0, -TOOL]) + np.array([directions.gauss(0, REPEAT) for _ in range(3)])

            zero = error(reference)
            rows = [its for its in statements[way]["places"] if not np.allclose(its["at"], reference)]
            errors = np.array([error(np.array(its["at"])) - zero for its in rows]) * UM
            lines = np.array([np.array(its["at"]) - reference for its in rows], dtype=float)
            outcome.errors[way] = errors
            outcome.along[way] = (errors * lines).sum(axis=1) / np.linalg.norm(lines, axis=1)
            outcome.U_axis[way] = np.array([its["U_axis"] for its in rows]) * UM
            outcome.U[way] = np.array([its["U"] for its in rows]) * UM
    progress(1)
    return outcome


def figures(outcomes):
    """Lines, and whether all is within its bounds."""
    lines, good = [], True
    for way in WAYS:
        errors, U_axis, U, along = (np.concatenate([getattr(its, name)[way] for its in outcomes]) for name in ("errors", "U_axis", "U", "along"))
        covered, lengths = 100 * np.mean(np.abs(errors) <= U_axis), 100 * np.mean(np.abs(along) <= U)
        median, most = np.median(U_axis), np.percentile(np.abs(errors), 95)
        kept = 93 <= covered <= 99 and median <= 1.3 * most
        good &= kept
        lines.append(f"{way:9} {len(outcomes)} machines: {covered:.1f} % of the components within their U, {lengths:.1f} % of the lengths within U; median U {median:.1f} um, p95 of the errors {most:.1f} um, ratio {median / most:.2f}{'' if kept else ', missed'}")
        none = 100 * np.mean(np.abs(errors) <= 2 * np.std(errors))
        lines.append(f"{'':9} rival, one U for all, twice the spread of these very errors: {none:.1f} %")
    said = np.mean([all(its.open_states) for its in outcomes])
    lines.append(f"one line left out: {100 * said:.0f} % state \"at least\", and name it")
    return lines, bool(good and said == 1)

# SPDX-License-Identifier: GPL-2.0-or-later
"""The machines of the bench circle: configs/portal/bench.hal with play in its drives, on circles in both directions."""

import dataclasses
import math
import os
import random

import numpy as np

from support.portal_machine import AXES, CONFIG, LEANING, UM
from support.programs import program
from support.recordings import read_columns, write_rows

CHAIN = "w-X.b-W-Y-Z-C-t"
PLANES = ("xy", "zx", "yz")
CENTRES = {"x": 500, "y": 500, "z": -500, "w": 0}  # mm
PLACES = {axis: [CENTRES[axis] + step for step in range(-240, 241, 80)] for axis in "xyz"}  # of the indicator
TIMES = 5  # at each place, from either side
OVERRUN = 1.0  # mm
MOTION = {"maxv": 200, "maxa": 2000}  # mm/s, mm/s2; circles need less
NOISE = 0.0003  # mm, of indicator and ballbar
ACCELERATION = 125  # mm/s2, reversal-acceleration: the default
DISTANCE = 0.0005  # mm, reversal-distance: the default
RUNS = ("without", "with tables")


@dataclasses.dataclass(frozen=True)
class Drawn:
    seed: int
    plane: str
    feed: float  # mm/min
    radius: float  # mm
    gain: float  # 1/s
    play: dict  # mm, by axis
    stick: dict  # mm
    opening: float  # rad, of the corner of X and Y

    @property
    def speed(self):
        return self.feed / 60


def draw(seed):
    drawn = random.Random(f"circle {seed}")
    return Drawn(
        seed,
        drawn.choice(PLANES),
        round(math.exp(drawn.uniform(math.log(500), math.log(5000)))),
        round(drawn.uniform(25, 150)),
        drawn.uniform(17, 60),
        {axis: drawn.uniform(0, 0.020) for axis in "xyz"},
        {axis: drawn.uniform(0, 0.0002) for axis in "xyz"},
        drawn.choice((-1, 1)) * drawn.uniform(20e-6, 100e-6),
    )


def kept(play, machine):
    """The error that lost motion leaves on a circle, by the law of the turn, in mm: volume model of play, without drive."""
    a, an = ACCELERATION, machine.speed**2 / machine.radius
    if an > a:
        return max(play * an / (an + a), kept_below(play, a, a))
    return kept_below(play, a, an)


def kept_below(play, a, an):
    return 0.5 * ((math.sqrt(2 * DISTANCE * a) + 2 * math.sqrt(play * an)) / (math.sqrt(a) + math.sqrt(an))) ** 2


class Circling:
    """The configuration in a host."""

    def __init__(self, machine, tables=()):
        import plumb

        options = {"squareness.chain": CHAIN}
        if tables:
            options["squareness.table"] = ":".join(tables)
        self.machine = machine
        self.host = plumb.Host(options=options)
        host = self.host
        host.load(CONFIG)
        zero = {f"{axis}-{error}": 0 for axis in AXES for error in ("straightness", "pitch-yaw")}
        zero.update({name: 0 for name in LEANING["portal"]})
        self.set("portal", {**zero, "ram-sag": 0, "tilt-drift": 0, "seed": machine.seed, "servo-gain": machine.gain, "tool-length": 0, "radial-offset": 0, "ec0y": machine.opening, "gauge-noise": NOISE})
        self.set("square", {**{name: 0 for name in LEANING["portal"]}, "max-speed": 1e5, "z-tool-offset": 0, "radial-offset": 0})
        self.set("square", {"max-rate": 10, "ec0y": machine.opening if tables else 0})
        for axis in "xyz":
            self.set("portal", {f"{axis}-play": machine.play[axis], f"{axis}-play-variation": 0.3, f"{axis}-stick": machine.stick[axis]})
            host.command(f"net {axis}-feed-forward square.{axis}-corrected-velocity => portal.{axis}-feed-forward")
            self.set(f"{axis}-stage", {"max-rate": 1, "ramp-rate": 10})
        for axis in AXES:
            self.set(f"{axis}-path", {"amplitude": 0, "offset": CENTRES[axis]})
            self.set(f"{axis}-motion", MOTION)
        first, second = machine.plane
        host.command(f"unlinkp {first}-path.sine")
        host.command(f"net {first}-path {first}-path.cosine")
        host.command("start")
        host.run(8)  # to the centre

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.host.close()

    def set(self, part, values):
        for name, value in values.items():
            self.host.set(f"{part}.{name}", value)

    def indicator(self, axis, place, side):
        """The reading of an indicator at rest, the place reached from the - side (-1) or the + side (1), and the truth."""
        for at in (place + side * OVERRUN, place):
            self.go(axis, at)
        return self.host.get([f"portal.{axis}-indicator", f"portal.truth-{axis}-error"])

    def go(self, axis, place):
        """At rest there."""
        way = abs(place - self.host.get(f"{axis}-motion.out"))
        self.host.set(f"{axis}-path.offset", place)
        self.host.run(0.2 + way / MOTION["maxv"] + 12 / self.machine.gain)

    def circle(self, clockwise, folder):
        """Angles in rad and radii in mm of the tip, over one turn, as a ballbar without noise sees them."""
        its = self.machine
        first, second = its.plane
        period = 2 * math.pi * its.radius / its.speed
        for axis, sign in ((first, 1), (second, -1 if clockwise else 1)):
            self.set(f"{axis}-path", {"frequency": 1 / period, "amplitude": sign * its.radius, "reset": True})
        self.host.run(0.002)
        for axis in its.plane:
            self.host.set(f"{axis}-path.reset", False)
        self.host.run(max(2.0, period / 4))
        path = os.path.join(folder, "circle.csv")
        names = [f"portal.truth-{axis}-tip" for axis in its.plane]
        recording = self.host.record(path, names, 0.001)
        self.host.run(period)
        self.host.stop_recording(recording)
        for axis in its.plane:
            self.set(f"{axis}-path", {"amplitude": 0, "frequency": 0})
        self.host.run(2)
        columns = read_columns(path)
        a, b = (columns[name] - CENTRES[axis] for name, axis in zip(names, its.plane))
        return np.arctan2(b, a), np.hypot(a, b)


def centred(angles, radii):
    """The deviation from the circle of least squares, in mm."""
    design = np.column_stack([np.ones_like(angles), np.cos(angles), np.sin(angles)])
    return radii - design @ np.linalg.lstsq(design, radii, rcond=None)[0]


@dataclasses.dataclass
class Outcome:
    machine: Drawn
    traces: dict  # run -> [(angles, deviation in um), of CCW and CW]
    peaks: dict  # run -> largest deviation by lost motion, um
    law: float  # um, of the law of the turn
    rest: float  # um, largest difference of both sides at rest, corrected, by an indicator without noise
    rest_allowed: float  # um, 0.5 and the U of the measurement
    ballbar: dict  # quantity -> (value, U, truth): in um, urad
    roundness: dict  # run -> G, the larger one of both directions, um


def simulate(seed, progress):
    from plumb_folder import TemporaryFolder

    machine = draw(seed)
    with TemporaryFolder() as folder:
        traces, tables, measured = {}, [], {}
        with Circling(machine) as running:
            traces["without"] = [running.circle(clockwise, folder) for clockwise in (False, True)]
            for axis in "xyz":
                rows = []
                for place in PLACES[axis]:
                    sides = [[running.indicator(axis, place, side)[0] for _ in range(TIMES)] for side in (-1, 1)]
                    rows.append([place, *(f"{value:.5f}" for value in sides[0] + sides[1])])
                running.go(axis, CENTRES[axis])
                readings, table = (os.path.join(folder, f"{axis}-{name}.csv") for name in ("readings", "table"))
                names = [f"{way}{n}" for way in ("up", "down") for n in range(1, TIMES + 1)]
                write_rows(readings, ["position", *names], rows)
                measured[axis] = program("plumb-volume", "reversal", readings, "--axis", axis.upper(), "--json", "--output", table)
                tables.append(table)
            progress(1)
        ballbar = read_ballbar(machine, traces["without"], folder)
        with Circling(machine, tables) as running:
            traces["with tables"] = [running.circle(clockwise, folder) for clockwise in (False, True)]
            rest, allowed = 0, 0
            for axis in "xyz":
                for place in (PLACES[axis][0] + 40, CENTRES[axis] + 10, PLACES[axis][-1] - 50):
                    low, high = (running.indicator(axis, place, side)[1] for side in (-1, 1))
                    row = min(measured[axis]["rows"], key=lambda its: abs(its["position"] - place))
                    if abs(high - low) * UM - (0.5 + row["U"] * UM) > rest - allowed or not allowed:
                        rest, allowed = abs(high - low) * UM, 0.5 + row["U"] * UM
                running.go(axis, CENTRES[axis])
        progress(1)
    plays = [max(row["lost_motion"] for row in measured[axis]["rows"]) for axis in machine.plane]
    peaks, shown, roundness = {}, {}, {}
    for run in RUNS:
        shown[run] = [(angles, centred(angles, radii) * UM) for angles, radii in traces[run]]
        of_corner = machine.opening if run == "without" and machine.plane == "xy" else 0
        by_play = [deviation + of_corner * machine.radius * UM * np.sin(angles) * np.cos(angles) for angles, deviation in shown[run]]
        peaks[run] = max(np.abs(deviation).max() for deviation in by_play)
        roundness[run] = max(np.ptp(deviation) for deviation in by_play)
    return Outcome(machine, shown, peaks, max(kept(max(play, 0), machine) for play in plays) * UM, rest, allowed, ballbar, roundness)


def read_ballbar(machine, traces, folder):
    """Opening and lost motion as plumb volume circle reads them from a noisy path, each with U and truth."""
    noise = np.random.default_rng(machine.seed)
    files = []
    for direction, (angles, radii) in zip(("CCW", "CW"), traces):
        path = os.path.join(folder, direction + ".csv")
        step = max(1, len(angles) // 2000)
        with open(path, "w", encoding="ascii") as file:
            file.write(f"# plane: {machine.plane.upper()}\n# radius: {machine.radius}\n# feed: {machine.feed}\n# direction: {direction}\n# object: part\nangle,radius\n")
            for angle, radius in zip(angles[::step], radii[::step] + NOISE * noise.standard_normal(len(radii[::step]))):
                file.write(f"{math.degrees(angle):.5f},{radius:.6f}\n")
        files.append(path)
    found = program("plumb-volume", "circle", *files, "--json")
    opening = found["opening"]
    truth = machine.opening if machine.plane == "xy" else 0
    return {"opening, urad": (opening["value"] * 1e6, opening["U"] * 1e6, truth * 1e6)}

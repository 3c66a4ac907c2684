# SPDX-License-Identifier: GPL-2.0-or-later
"""The machines of the bench portal: configs/portal/bench.hal in the virtual-time host, stopped at the points of a cube."""

import contextlib
import dataclasses
import itertools
import math
import os
import random
import re

import numpy as np

from support.recordings import blank_table, write_error_tables
from support.simulations import ROOT

CONFIG = os.path.join(ROOT, "configs", "portal", "bench.hal")

CHAINS = {"column": "w-Z.b-X-Y-C-t", "portal": "w-X.b-W-Y-Z-C-t"}
LOADED = {**CHAINS, "column": "w-W-Z.b-X-Y-C-t"}  # the configuration nets W, which stands at 0 on the column
LEANING = {"column": ("ea0y", "ec0y"), "portal": ("ea0w", "eb0w", "ea0z", "eb0z")}  # set by the operator
RUNS = ("without", "with tilts", "with tables")
CAUSES = ("straightness", "pitch and yaw", "ram sag", "drift")  # errors that no tilt describes

MISTAKES = {  # in the operator's settings
    "first angle with the wrong sign": lambda machine: {LEANING[machine.kind][0]: -machine.angles[LEANING[machine.kind][0]]},
    "tool length left out": lambda machine: {"z-tool-offset": 0},
    "diameter taken for a radius": lambda machine: {"radial-offset": 2 * machine.tool.radial},
    "the other reading": lambda machine: {"axis-direction": True},
    "bed taken for rail": lambda machine: {"to-bed": machine.kind == "portal"},
}

AXES = "xyzw"
SPANS = {"x": (0, 1000), "y": (0, 1000), "z": (-1000, 0), "w": (0, 600)}  # mm, as in the configuration
DRIFT_HOURS = 1
ARCSEC = math.pi / 648000
UM = 1000  # per mm

FAST = {"maxv": 5e4, "maxa": 1e7}  # mm/s, mm/s2: nothing here depends on the time that a move takes
ONE_PERIOD = 0.001  # s
STOP = 0.04  # s, which the longest move takes


# --- the machine ---


@dataclasses.dataclass(frozen=True)
class Tool:
    length: float
    radial: float = 0.0
    direction: float = 0.0  # deg


LONGEST = Tool(400, 50, 60)


def draw_tools(seed, count=4):
    """Tools of 50 to 400 mm, the longest two boring bars."""
    drawn = random.Random(f"tools {seed}")
    lengths = sorted(round(drawn.uniform(50, 400)) for _ in range(count))
    tools = [Tool(length) for length in lengths[: count - 2]]
    return tools + [Tool(l, round(drawn.uniform(10, 50)), round(drawn.uniform(0, 360))) for l in lengths[count - 2 :]]


def draw_tilts(machine, seed):
    """20 to 100 um on a metre, either way; those of the configuration for machine 0."""
    if seed == 0:
        with open(CONFIG, encoding="utf-8") as file:
            known = dict(re.findall(r"^setp portal\.(e[abc]0\w) +(\S+)", file.read(), re.M))
        known.update({"ea0y": "60e-6", "ec0y": "-80e-6"})
        return {name: float(known[name]) for name in LEANING[machine]}
    drawn = random.Random(f"tilts {seed}")
    return {name: drawn.choice((-1, 1)) * drawn.uniform(20e-6, 100e-6) for name in LEANING[machine]}


def cube(machine, steps):
    """Points X, Y, Z, W of a cube of a metre; on the portal with the rail down and up."""
    along = [np.linspace(*SPANS[axis], steps) for axis in "xyz"]
    rails = SPANS["w"] if machine == "portal" else (0,)
    return [(x, y, z, w) for w in rails for x in along[0] for y in along[1] for z in along[2]]


def new_host(kind, table=None):
    """A host that loads squareness with the chain of this kind of machine, and with a file of error tables."""
    import plumb

    options = {"squareness.chain": LOADED[kind]}
    if table:
        options["squareness.table"] = table
    return plumb.Host(options=options)


class Machine:
    """The configuration in a host, its axes where they are sent."""

    READ = [f"portal.truth-{axis}-{what}" for what in ("error", "beyond-tilts") for axis in "xyz"]
    READ += [f"square.{axis}-error" for axis in "xyz"]
    READ += ["square.fault-code", "square.limited-code", "square.ramping"] + [f"{axis}-motion.out" for axis in AXES]

    def __init__(self, host, kind):
        self.host, self.kind = host, kind
        self.place = dict.fromkeys(AXES, 0)
        self.angles, self.tool = {}, Tool(0)
        host.load(CONFIG)
        if kind == "column":
            host.set("portal.portal", False)
            self.set({f"square.{name}": 0 for name in LEANING["portal"]})
            self.set({f"portal.{name}": 0 for name in LEANING["portal"]})
        host.set("portal.servo-gain", 6000)
        self.set({"square.max-speed": 1e5, "square.max-rate": 10, "square.max-correction": 10})
        for axis in AXES:
            self.set({f"{axis}-path.amplitude": 0, f"{axis}-path.offset": 0, **{f"{axis}-motion.{name}": v for name, v in FAST.items()}})
            if axis != "w":
                self.set({f"{axis}-stage.max-rate": 1e4, f"{axis}-stage.ramp-rate": 1e4, f"{axis}-stage.max-offset": 100, f"{axis}-stage.offset-acceleration": 1e9})
        host.command("start")

    def set(self, values):
        for name, value in values.items():
            self.host.set(name, value)

    def tilt(self, angles):
        """In truth, and as the operator sets it."""
        self.angles = angles
        for name, angle in angles.items():
            self.set({f"portal.{name}": angle, f"square.{name}": angle})

    def mount(self, tool):
        """In truth, and as the operator sets it."""
        self.tool = tool
        self.set({"portal.tool-length": tool.length, "square.z-tool-offset": tool.length})
        for part in ("portal", "square"):
            self.set({f"{part}.radial-offset": tool.radial, f"{part}.radial-direction": tool.direction})

    def go(self, point):
        """To X, Y, Z, W; there the tip error, the part of it without tilts, and the error that squareness reports without
        correction, in um, as nine values."""
        for axis, place in zip(AXES, point):
            if self.place.get(axis) != place:
                self.host.set(f"{axis}-path.offset", place)
                self.place[axis] = place
        return self.settled()

    def settled(self):
        """The same where the axes are, when nothing moves or ramps any more."""
        for _ in range(1000):
            self.host.run(STOP)
            *errors, fault, limited, ramping, x, y, z, w = self.host.get(self.READ)
            if not ramping and all(abs(at - self.place[axis]) < 1e-12 for axis, at in zip(AXES, (x, y, z, w))):
                if fault or limited:
                    raise RuntimeError(f"squareness reports fault-code {fault}, limited-code {limited}")
                return [UM * error for error in errors]
        raise RuntimeError(f"the axes do not come to rest at {self.place}")


@dataclasses.dataclass
class Visit:
    """The errors of each tool at each point, in um: arrays of tools x points x 3."""

    error: np.ndarray
    beyond: np.ndarray

    @property
    def lengths(self):
        return np.linalg.norm(self.error, axis=2)

    @property
    def left_by_tilts(self):
        return np.linalg.norm(self.error - self.beyond, axis=2).max()


def visit(machine, points, tools):
    rows = []
    for tool in tools:
        machine.mount(tool)
        for point in points:
            rows.append(machine.go(point)[:6])
    rows = np.array(rows).reshape(len(tools), len(points), 6)
    return Visit(rows[:, :, :3], rows[:, :, 3:])


def travel(axis):
    """Further than the cube: a table is to reach where a correction leads."""
    return SPANS[axis][0] - 20, SPANS[axis][1] + 20


def gauge(machine, path, steps=20):
    """Writes the error motions of all axes, measured at steps + 1 positions each, as error tables."""
    host = machine.host
    outputs = [f"portal.truth-gauge-{error}" for error in ("ex", "ey", "ez", "ea", "eb", "ec")]
    tables = []
    for number, axis in enumerate(AXES if machine.kind == "portal" else AXES[:3]):
        host.set("portal.gauge-axis", number)
        rows = []
        for position in np.linspace(*travel(axis), steps + 1):
            host.set("portal.gauge-position", position)
            host.run(ONE_PERIOD)
            rows.append((position, *host.get(outputs)))
        letter = axis.upper()
        tables.append((letter, [error + letter for error in ("EX", "EY", "EZ", "EA", "EB", "EC")], rows))
    write_error_tables(path, tables, f"simulated {machine.kind} {host.get('portal.seed')}")


def blank_tables(machine, path):
    axes = AXES if machine == "portal" else AXES[:3]
    write_error_tables(path, [blank_table(axis.upper(), *travel(axis)) for axis in axes], f"ideal {machine}")


def reload_tables(machine):
    before = machine.host.get("square.serial")
    for value in (True, False):
        machine.host.set("square.reload", value)
        machine.host.run(0.1)
    if machine.host.get("square.serial") != before + 1:
        raise RuntimeError("squareness did not take the tables over")


def only(machine, cause):
    """Leaves one of CAUSES in the machine, or none of them for None; drift as after DRIFT_HOURS."""
    pins = {f"{axis}-straightness": "straightness" for axis in AXES}
    pins.update({f"{axis}-pitch-yaw": "pitch and yaw" for axis in AXES})
    pins.update({"ram-sag": "ram sag", "tilt-drift": "drift"})
    for pin, its in pins.items():
        machine.host.set("portal." + pin, -1 if cause == its else 0)
    machine.host.set("portal.drift-start", DRIFT_HOURS * 3600 if cause == "drift" else 0)


@dataclasses.dataclass
class Outcome:
    """The result of one machine, in um."""

    machine: str
    tools: list
    points: list
    visits: dict  # of RUNS
    causes: dict  # cause -> the largest tip error that it leaves with tilts corrected, at the corners, longest tool
    mistakes: dict  # mistake -> the same, with no error but tilts


def mistaken(machine, points, wrong):
    """The largest tip error where something is not set as it is, in um."""
    settings = {f"square.{name}": value for name, value in wrong(machine).items()}
    right = dict(zip(settings, machine.host.get(list(settings))))
    machine.set(settings)
    machine.settled()
    largest = max(math.hypot(*machine.go(point)[:3]) for point in points)
    machine.set(right)
    machine.settled()
    return largest


def duration(kind, steps):
    """About, in simulated seconds, of simulate()."""
    return len(RUNS) * len(draw_tools(0)) * len(cube(kind, steps)) * STOP


def simulate(kind, seed, steps, progress):
    """The Outcome of machine `seed` of a kind."""
    from plumb_folder import TemporaryFolder

    with contextlib.ExitStack() as stack:
        table = os.path.join(stack.enter_context(TemporaryFolder()), "errors.csv")
        blank_tables(kind, table)
        host = stack.enter_context(new_host(kind, table))
        machine = Machine(host, kind)
        host.set("portal.seed", seed)
        host.set("portal.tilt-drift", 0)  # which comes as a cause of its own
        machine.tilt(draw_tilts(kind, seed))
        tools, points = draw_tools(seed), cube(kind, steps)
        visits, causes = {}, {}
        for run in RUNS:
            host.set("square.enable", run != "without")
            if run == "with tables":
                gauge(machine, table)
                reload_tables(machine)
            machine.settled()
            visits[run] = visit(machine, points, tools)
            progress(len(visits) * len(tools) * len(points) * STOP)
        blank_tables(kind, table)
        reload_tables(machine)
        corners = cube(kind, 2)
        for cause in CAUSES:
            only(machine, cause)
            causes[cause] = visit(machine, corners, tools[-1:]).lengths.max()
        only(machine, None)
        mistakes = {name: mistaken(machine, corners, wrong) for name, wrong in MISTAKES.items()}
        return Outcome(kind, tools, points, visits, causes, mistakes)


# --- every direction in which the members of a machine can lean ---


@dataclasses.dataclass
class Worst:
    """The largest tip error with compensation, in um, and where."""

    machine: str
    cases: int
    points: int
    without: float
    compensated: float
    where: str


def cases(kind):
    """All combinations of directions in both readings, against rail and bed: (axis-direction, to-bed, signs)."""
    signs = [s for s in itertools.product((-1, 0, 1), repeat=len(LEANING[kind])) if any(s)]
    return list(itertools.product((False, True), (False, True) if kind == "portal" else (False,), signs))


def case_text(kind, case, angle):
    axis_direction, to_bed, signs = case
    leaning = [f'{name.upper()} {sign * angle / ARCSEC:+.0f}"' for name, sign in zip(LEANING[kind], signs) if sign]
    words = [" ".join(leaning), ("axis direction" if axis_direction else "component") + " reading"]
    return ", ".join(words + (["against the bed" if to_bed else "against the rail"] if kind == "portal" else []))


def every_direction(kind, angle, steps, progress):
    """The Worst of all cases over a cube, with 400 mm of tool and 50 mm of radial offset."""
    points = cube(kind, steps)
    worst = Worst(kind, len(cases(kind)), len(points), 0, -1, "")
    with new_host(kind) as host:
        machine = Machine(host, kind)
        machine.mount(LONGEST)
        for done, case in enumerate(cases(kind)):
            axis_direction, to_bed, signs = case
            for part in ("portal", "square"):
                machine.set({f"{part}.axis-direction": axis_direction, f"{part}.to-bed": to_bed})
            machine.tilt({name: sign * angle for name, sign in zip(LEANING[kind], signs)})
            machine.settled()
            for point in points:
                errors = machine.go(point)
                error = math.hypot(*errors[:3])
                worst.without = max(worst.without, math.hypot(*errors[6:]))
                if error > worst.compensated:
                    worst.compensated = error
                    worst.where = f"{case_text(kind, case, angle)}, at {point}"
            if progress((done + 1) * len(points) * STOP) is False:
                break
    return worst

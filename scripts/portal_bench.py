# SPDX-License-Identifier: GPL-2.0-or-later
"""Cubes visited by machines with tilted columns and rails, without and with squareness.

configs/portal/bench.hal runs in the virtual-time host.  Its axes stop at the points of a cube of a metre, with tools of
different length; at each point the tip error is read: as the machine is, with its tilts corrected, and with tables of
all that an instrument finds on its axes.  What straightness, pitch, yaw, sag and drift leave is told apart from what
tilts leave.
"""

import argparse
import csv
import dataclasses
import itertools
import math
import os
import random
import re
import sys
import tempfile

import numpy as np

from simulations import BUILD, ROOT, simulate_all

CONFIG = os.path.join(ROOT, "configs", "portal", "bench.hal")

CHAINS = {"column": "w-Z.b-X-Y-C-t", "portal": "w-X.b-W-Y-Z-C-t"}
LEANING = {"column": ("ea0y", "ec0y"), "portal": ("ea0w", "eb0w", "ea0z", "eb0z")}  # what the operator sets
RUNS = ("without", "with tilts", "with tables")
CAUSES = ("straightness", "pitch and yaw", "ram sag", "drift")  # of what no tilt describes

MISTAKES = {  # in what the operator sets
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


class Machine:
    """The configuration in a host, its axes where they are sent."""

    READ = [f"portal.truth-{axis}-{what}" for what in ("error", "beyond-tilts") for axis in "xyz"]
    READ += [f"square.{axis}-error" for axis in "xyz"]
    READ += ["square.fault-code", "square.limited-code", "square.ramping"] + [f"{axis}-motion.out" for axis in AXES]

    def __init__(self, host, kind, folder, table=None):
        self.host, self.kind = host, kind
        self.place = dict.fromkeys(AXES, 0)
        self.angles, self.tool = {}, Tool(0)
        options = f"chain={CHAINS[kind]}" + (f" table={table}" if table else "")
        with open(CONFIG, encoding="utf-8") as file:
            text = file.read().replace("chain=" + CHAINS["portal"], options)
        path = os.path.join(folder, "bench.hal")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        host.load(path)
        if kind == "column":
            host.set("portal.portal", False)
            self.set({f"square.{name}": 0 for name in LEANING["portal"]})
            self.set({f"portal.{name}": 0 for name in LEANING["portal"]})
        host.set("portal.servo-gain", 6000)
        self.set({"square.max-speed": 1e5, "square.max-rate": 10, "square.max-correction": 10})
        for axis in AXES:
            self.set({f"{axis}-path.amplitude": 0, f"{axis}-path.offset": 0, **{f"{axis}-motion.{name}": v for name, v in FAST.items()}})
            if axis != "w":
                self.set({f"{axis}-stage.max-rate": 1e4, f"{axis}-stage.ramp-rate": 1e4, f"{axis}-stage.max-offset": 100})
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
        """To X, Y, Z, W; there the tip error, what of it no tilt makes, and what squareness says it is without
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
    """Of each tool at each point, in um: arrays of tools x points x 3."""

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
    with open(path, "w", newline="", encoding="ascii") as file:
        writer = csv.writer(file)
        for number, axis in enumerate(AXES if machine.kind == "portal" else AXES[:3]):
            host.set("portal.gauge-axis", number)
            letter = axis.upper()
            writer.writerow([letter] + [error + letter for error in ("EX", "EY", "EZ", "EA", "EB", "EC")])
            for position in np.linspace(*travel(axis), steps + 1):
                host.set("portal.gauge-position", position)
                host.run(ONE_PERIOD)
                writer.writerow([repr(float(value)) for value in (position, *host.get(outputs))])


def blank_tables(machine, path):
    with open(path, "w", encoding="ascii") as file:
        for axis in AXES if machine == "portal" else AXES[:3]:
            letter = axis.upper()
            file.write(f"{letter},EX{letter}\n" + "".join(f"{place},0\n" for place in travel(axis)))


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
    """Of one machine, in um."""

    machine: str
    tools: list
    points: list
    visits: dict  # of RUNS
    causes: dict  # cause -> the largest tip error that it leaves with tilts corrected, at the corners, longest tool
    mistakes: dict  # mistake -> likewise, where nothing is wrong but tilts


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


def simulate(kind, seed, steps, told):
    """The Outcome of machine `seed` of a kind."""
    import plumb

    with tempfile.TemporaryDirectory() as folder, plumb.Host() as host:
        table = os.path.join(folder, "errors.csv")
        blank_tables(kind, table)
        machine = Machine(host, kind, folder, table)
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
            told(len(visits) * len(tools) * len(points) * STOP)
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


def every_direction(kind, angle, steps, told):
    """The Worst of all cases over a cube, with 400 mm of tool and 50 mm of radial offset."""
    import plumb

    points = cube(kind, steps)
    worst = Worst(kind, len(cases(kind)), len(points), 0, -1, "")
    with tempfile.TemporaryDirectory() as folder, plumb.Host() as host:
        machine = Machine(host, kind, folder)
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
            if told((done + 1) * len(points) * STOP) is False:
                break
    return worst


# --- what is printed ---


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def tool_text(tool):
    bar = f", tip {tool.radial:.0f} mm off" if tool.radial else ""
    return f"tool of {tool.length:.0f} mm{bar}"


def cube_table(outcome):
    """The lines of the table of tip errors of one machine."""
    visits = [outcome.visits[run] for run in RUNS]
    lines = [
        f"{'Tip error over the ' + outcome.machine + ', um':40}" + "".join(f"{run:>20}" for run in RUNS),
        f"{'':40}" + f"{'rms':>10}{'max':>10}" * len(RUNS),
    ]
    rows = [(tool_text(tool), [v.lengths[i] for v in visits]) for i, tool in enumerate(outcome.tools)]
    for name, lengths in rows + [("all tools", [v.lengths for v in visits])]:
        lines.append(f"{name:40}" + "".join(f"{micrometres(f(l)):>10}" for l in lengths for f in (rms, np.max)))
    return lines


def cause_text(cause):
    return f"drift in {DRIFT_HOURS} h" if cause == "drift" else cause


def micrometres(um):
    return "< 1e-6" if um < 1e-6 else f"{um:.1g}" if um < 0.05 else f"{um:.1f}"


def remainder_lines(outcome):
    """What of the error the tilts leave, what else there is, each cause by itself, and what mistakes would cost."""
    lines = [f"    {'left by the tilts':40}{micrometres(outcome.visits['with tilts'].left_by_tilts):>10}"]
    lines += [f"    {'left by ' + cause_text(cause):40}{micrometres(outcome.causes[cause]):>10}" for cause in CAUSES]
    return lines + [f"    {mistake:40}{micrometres(um):>10}" for mistake, um in outcome.mistakes.items() if um >= 1e-6]


def percentile_table(outcomes):
    """The lines of the table over many machines of one kind, of the largest tip error of each."""
    rows = {run: [outcome.visits[run].lengths.max() for outcome in outcomes] for run in RUNS}
    rows["with tilts, left by tilts"] = [outcome.visits["with tilts"].left_by_tilts for outcome in outcomes]
    for cause in CAUSES:
        rows[f"with tilts, left by {cause_text(cause)}"] = [outcome.causes[cause] for outcome in outcomes]
    kind = outcomes[0].machine
    lines = [f"{'Largest tip error over the ' + kind + ', um':44}" + "".join(f"{p:>10}" for p in ("p10", "p50", "p90", "worst"))]
    for name, values in rows.items():
        cells = "".join(f"{micrometres(v):>10}" for v in np.percentile(values, (10, 50, 90, 100)))
        lines.append(f"{name:44}{cells}")
    return lines


def worst_lines(worst):
    return [
        f"{worst.machine + ':':8} {worst.cases} cases at {worst.points} points: "
        f"{worst.without:.0f} um without, {micrometres(worst.compensated)} um with compensation, with",
        f"         {worst.where}",
    ]


# --- what is written ---


def write_points(path, outcomes):
    """One row for each tool at each point."""
    with open(path, "w", newline="", encoding="ascii") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["machine", "run", "tool_length_mm", "radial_offset_mm", "radial_direction_deg"]
            + [f"{axis}_mm" for axis in AXES]
            + [f"{axis}_error_um" for axis in "xyz"]
            + [f"{axis}_beyond_tilts_um" for axis in "xyz"]
        )
        for outcome in outcomes:
            for run, its in outcome.visits.items():
                for t, tool in enumerate(outcome.tools):
                    for p, point in enumerate(outcome.points):
                        measured = [f"{value:.4f}" for value in (*its.error[t][p], *its.beyond[t][p])]
                        writer.writerow([outcome.machine, run, tool.length, tool.radial, tool.direction, *point, *measured])


# Colours that the colour-blind tell apart, from Okabe and Ito.
COLOURS = {"without": "#d55e00", "with tilts": "#0072b2", "with tables": "#009e73"}
ENLARGED = 2000
FINEST = 0.01  # um, where the axis of errors begins


def draw(paths, outcomes, title):
    """The cube as the tip of the longest tool goes round it, errors enlarged; and all errors, sorted."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"svg.hashsalt": "plumb", "font.size": 10, "axes.spines.top": False, "axes.spines.right": False})
    figure = pyplot.figure(figsize=(11, 4.6 * len(outcomes)), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
    for row, outcome in enumerate(outcomes):
        view = figure.add_subplot(len(outcomes), 2, 2 * row + 1, projection="3d")
        _draw_cube(view, outcome)
        errors = figure.add_subplot(len(outcomes), 2, 2 * row + 2)
        for run in RUNS:
            lengths = np.sort(outcome.visits[run].lengths.ravel())
            share = np.arange(1, len(lengths) + 1) / len(lengths) * 100
            shown = np.maximum(lengths, FINEST)
            errors.plot(shown, share, color=COLOURS[run], linewidth=2, label=f"{run}: rms {micrometres(rms(lengths))} µm")
        errors.set_xscale("log")
        errors.set_xlim(FINEST, 300)
        errors.set_ylim(0, 101)
        errors.set_ylabel("points and tools with less (%)")
        errors.set_xlabel("tip error (µm)")
        errors.xaxis.set_major_formatter("{x:g}")
        errors.set_title(outcome.machine, loc="left")
        errors.legend(loc="center", bbox_to_anchor=(0.38, 0.6), frameon=False)
        errors.grid(color="#dddddd", linewidth=0.6)
    for path in paths:
        figure.savefig(path, dpi=120, metadata={"Date": None} if path.endswith(".svg") else None)
    pyplot.close(figure)


def _draw_cube(view, outcome):
    tool = len(outcome.tools) - 1
    places = np.array([point[:3] for point in outcome.points])
    rail = np.array([point[3] for point in outcome.points])
    here = np.flatnonzero(rail == rail.max())  # the rail up, where the lever is longest
    for run, colour in {**COLOURS, None: "black"}.items():
        at = places if run is None else places + outcome.visits[run].error[tool] / UM * ENLARGED
        for i, k in itertools.combinations(here, 2):
            if not _on_one_edge(places[i], places[k], places[here]):
                continue
            style = ":" if run is None else "-"
            view.plot(*zip(at[i], at[k]), color=colour, linestyle=style, linewidth=1 if run is None else 1.6, zorder=5 if run is None else 3)
    for name in "xyz":
        getattr(view, f"set_{name}label")(name.upper() + " (mm)", labelpad=10)
        getattr(view, f"set_{name}ticks")(np.linspace(*SPANS[name], 3))
    view.set_box_aspect((1, 1, 1), zoom=0.9)
    view.view_init(22, -55)
    view.set_title(f"{outcome.machine}, {tool_text(outcome.tools[tool])}, errors × {ENLARGED}; dotted: as drawn", fontsize=10)


def _on_one_edge(a, b, points):
    """Whether a and b follow each other on an edge of the cube."""
    differs = np.flatnonzero(a != b)
    ends = [set((points[:, i].min(), points[:, i].max())) for i in range(3)]
    if len(differs) != 1 or any(a[i] not in ends[i] for i in range(3) if i != differs[0]):
        return False
    along = np.unique(points[:, differs[0]])
    return abs(np.searchsorted(along, a[differs[0]]) - np.searchsorted(along, b[differs[0]])) == 1


# --- the command ---


def bench_one(seed, steps, output):
    jobs = [(kind, seed, steps) for kind in CHAINS]
    outcomes = simulate_all(simulate, jobs, sum(duration(kind, steps) for kind in CHAINS))
    for outcome in outcomes:
        print("\n".join(cube_table(outcome)))
        print("With tilts, largest; each cause, and each mistake, by itself:")
        print("\n".join(remainder_lines(outcome)) + "\n")
    paths = [os.path.join(output, name) for name in ("cubes.png", "cubes.svg", "points.csv")]
    machine = f"machine {seed}" if seed else "machine 0, which has nothing wrong but its tilts"
    draw(paths[:2], outcomes, f"A cube of a metre on {machine}")
    write_points(paths[2], outcomes)
    print("Written: " + "  ".join(os.path.relpath(path) for path in paths))


def bench_directions():
    """Whether all is below the 0.01 um that squareness promises."""
    print(f"Every direction in which they can lean, by 100 arcsec each, with a {tool_text(LONGEST)}:")
    jobs = [(kind, 100 * ARCSEC, 3) for kind in CHAINS]
    expected = sum(len(cases(kind)) * len(cube(kind, 3)) * STOP for kind in CHAINS)
    worst = simulate_all(every_direction, jobs, expected)
    for its in worst:
        print("\n".join(worst_lines(its)))
    return all(its.compensated < 0.01 for its in worst)


def bench_many(seeds, steps):
    print(f"{len(seeds)} machines, {seeds[0]} to {seeds[-1]}\n")
    for kind in CHAINS:
        outcomes = simulate_all(simulate, [(kind, seed, steps) for seed in seeds], duration(kind, steps) * len(seeds))
        print("\n".join(percentile_table(outcomes)) + "\n")


def whole(least, most):
    """A type for argparse: a whole number from least to most."""

    def number(text):
        if not re.fullmatch(r"\d{1,10}", text) or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from {least} to {most}")
        return int(text)

    return number


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench portal", description=__doc__.splitlines()[0])
    seed, many = whole(0, 2**31 - 1), whole(1, 100000)
    parser.add_argument("--seed", type=seed, default=1, metavar="N", help="draw machine N (default: 1); 0 has nothing wrong but its tilts")
    parser.add_argument("--seeds", type=many, metavar="N", help="N drawn machines, from --seed on, and a table of percentiles")
    parser.add_argument("--directions", action="store_true", help="every direction in which they can lean, both readings, against rail and bed")
    parser.add_argument("--cube", type=whole(2, 11), default=3, metavar="N", help="N points along each side (default: 3)")
    parser.add_argument("--output", default=os.path.join(BUILD, "bench", "portal"), metavar="DIR", help="where the files go (default: build/bench/portal)")
    options = parser.parse_args()
    try:
        if options.directions:
            sys.exit(0 if bench_directions() else 1)
        if options.seeds:
            bench_many(range(options.seed, options.seed + options.seeds), options.cube)
            return
        os.makedirs(options.output, exist_ok=True)
        try:
            tempfile.TemporaryFile(dir=options.output).close()
        except OSError as error:  # now, and not when all is done
            raise OSError(f"cannot write into {options.output}: {error.strerror}") from error
        bench_one(options.seed, options.cube, options.output)
    except KeyboardInterrupt:
        sys.exit(130)
    except (RuntimeError, OSError, ValueError) as error:
        sys.exit(f"scripts/bench: {error}")


if __name__ == "__main__":
    main()

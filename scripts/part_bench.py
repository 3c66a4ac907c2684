# SPDX-License-Identifier: GPL-2.0-or-later
"""Two parts, cut by machines with tilted columns and rails, and measured: without and with squareness.

configs/portal, a complete LinuxCNC with its G-code, runs in virtual time; sim_portal says in each servo cycle where the
tip truly is.  What it cuts is measured as an inspector would: straight lines and circles of least squares through the
points of each side (ISO 1101, ISO 4291), against the bottom side as the datum.  What straightness, pitch, yaw, sag and
drift make is told apart from what tilts make.

The parts are cut without correction; with the tilts of the guides as they were; with the tilt that `plumb squareness` makes of
the diagonals of the square that was cut without; and with tables of all that an instrument finds on the axes.
"""

import argparse
import csv
import dataclasses
import math
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

from portal_bench import COLOURS, draw_tilts, micrometres, whole
from simulations import BUILD, ROOT

CONFIGURATION = os.path.join(ROOT, "configs", "portal")

RUNS = ("without", "with tilts", "by diagonals", "with tables")
PARTS = ("square", "contour")
FEED = 2400  # mm/min, as in the G-code
SPEED = 20  # times real time
DRIFT_HOURS = 1  # since tilts and tables were measured
UM = 1000  # per mm

COLUMNS = [f"portal.truth-{axis}-{what}" for what in ("nominal", "error", "beyond-tilts") for axis in "xyz"]


@dataclasses.dataclass(frozen=True)
class Kind:
    prefix: str  # of its G-code files
    plane: tuple  # numbers of the axes that draw the part: to the right and up
    into: int  # number of the axis that leads into the work
    way: int  # and whether by going up or down
    origin: tuple  # of the part, mm
    shown: str  # the tilt that diagonals in this plane tell of

    @property
    def names(self):
        return "".join("XYZ"[axis] for axis in self.plane)


MACHINES = {
    "column": Kind("", (0, 1), 2, -1, (0, 0, -340), "ec0y"),
    "portal": Kind("portal_", (0, 2), 1, 1, (0, 150, -275), "eb0z"),
}


# --- the parts ---


@dataclasses.dataclass(frozen=True)
class Line:
    """A side, cut from start to end with the air on its left."""

    start: tuple
    end: tuple

    @property
    def length(self):
        return math.dist(self.start, self.end)

    @property
    def along(self):
        return np.subtract(self.end, self.start) / self.length

    @property
    def outwards(self):
        along = self.along
        return np.array((-along[1], along[0]))

    @property
    def middle(self):
        return np.add(self.start, self.end) / 2


@dataclasses.dataclass(frozen=True)
class Feature:
    depth: float
    cutter: float  # mm from the centre of the tool to the surface that counts
    sides: tuple = ()  # clockwise, of a square from the bottom left upwards; the last one is the bottom
    radius: float = 0  # of a circle


def rotated(points, degrees):
    angle = math.radians(degrees)
    c, s = math.cos(angle), math.sin(angle)
    return [(c * u - s * v, s * u + c * v) for u, v in points]


def polygon(corners):
    return tuple(Line(start, end) for start, end in zip(corners, corners[1:] + corners[:1]))


def square_of(side):
    half = side / 2
    return [(-half, -half), (-half, half), (half, half), (half, -half)]


FEATURES = {
    "square": {
        "square": Feature(0.5, 0, polygon(square_of(300))),
        "diagonals": Feature(0.5, 0, (Line((-150, -150), (150, 150)), Line((-150, 150), (150, -150)))),
    },
    "contour": {
        "square": Feature(40, 5, polygon(square_of(300))),
        "turned square": Feature(30, 5, polygon(rotated(square_of(280), 3))),
        "diamond": Feature(20, 5, polygon(rotated(square_of(190), 45))),
        "circle": Feature(10, 5, radius=85),
    },
}


# --- what an inspector measures ---


@dataclasses.dataclass
class Samples:
    """Of a cut, row by row: where the tip should have been in the part, and where it was instead, in mm.

    Columns: to the right, up, into the work."""

    nominal: np.ndarray
    error: np.ndarray


EDGE = 0.005  # of the length of a side, at both ends, which nobody measures
NEAR = 0.02  # mm, to where the tool should be for a side


def on_line(samples, feature, line, edge=EDGE):
    """Where along a side the tool cut it, and the rows."""
    place = samples.nominal[:, :2] - (line.middle + feature.cutter * line.outwards)
    along, across = place @ line.along, place @ line.outwards
    near = (abs(across) < NEAR) & (abs(samples.nominal[:, 2] - feature.depth) < NEAR)
    rows = np.flatnonzero(near & (abs(along) <= (0.5 - edge) * line.length))
    rows = max(np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1), key=len)  # others touch or cross this one
    if len(rows) < 10 or np.ptp(along[rows]) < 0.9 * line.length:
        raise ValueError(f"the side from {line.start} to {line.end} has not been cut")
    return along[rows], rows


@dataclasses.dataclass
class Side:
    """A side as measured: points, how far along it and how far too far outwards; and the line through them."""

    line: Line
    along: np.ndarray
    deviation: np.ndarray

    def __post_init__(self):
        design = np.column_stack((np.ones_like(self.along), self.along))
        self.offset, self.slope = np.linalg.lstsq(design, self.deviation, rcond=None)[0]

    def zone(self, slope):
        """Width of the zone between two lines of this slope that has all points."""
        return np.ptp(self.deviation - slope * self.along)

    def point(self, along):
        return self.line.middle + along * self.line.along + (self.offset + self.slope * along) * self.line.outwards

    def meets(self, other):
        """The corner, where the two lines of least squares intersect."""
        ways = [side.line.along + side.slope * side.line.outwards for side in (self, other)]
        t, _ = np.linalg.solve(np.column_stack((ways[0], -ways[1])), other.point(0) - self.point(0))
        return self.point(0) + t * ways[0]


def measure_side(samples, feature, line):
    _, rows = on_line(samples, feature, line)
    place = samples.nominal[rows, :2] + samples.error[rows, :2] - line.middle
    return Side(line, place @ line.along, place @ line.outwards - feature.cutter)


def on_circle(samples, feature):
    """At which angle the tool cut a circle that begins at the left, and the rows."""
    reach = feature.radius + feature.cutter
    right, up, into = samples.nominal.T
    near = (abs(np.hypot(right, up) - reach) < NEAR) & (abs(into - feature.depth) < NEAR)
    rows = np.flatnonzero(near)
    begins = np.flatnonzero((right[rows[:-1]] < 0) & (up[rows[:-1]] < 0) & (up[rows[1:]] >= 0))
    rows = rows[begins[0] + 1 : begins[-1] + 1] if len(begins) else rows[:0]  # without the tangents in and out
    angles = np.arctan2(up[rows], right[rows])
    if len(rows) < 36 or np.diff(np.sort(angles)).max() > math.radians(10):
        raise ValueError("the circle has not been cut")
    return angles, rows


def measure_circle(samples, feature):
    """Centre and radius of the circle of least squares, and how far outside of it each point is."""
    _, rows = on_circle(samples, feature)
    points = samples.nominal[rows, :2] + samples.error[rows, :2]
    centre, radius = np.zeros(2), feature.radius + feature.cutter
    for _ in range(5):
        radii = np.hypot(*(points - centre).T)
        design = np.column_stack(((points - centre) / radii[:, None], np.ones(len(rows))))
        step = np.linalg.lstsq(design, radii - radius, rcond=None)[0]
        centre, radius = centre + step[:2], radius + step[2]
    return centre, radius - feature.cutter, np.hypot(*(points - centre).T) - radius


def size(side, opposite):
    """How much too far apart two sides are, in their middle."""
    return side.offset + opposite.offset


def corners_of(sides):
    """From the bottom left, clockwise."""
    left, top, right, bottom = sides
    return [a.meets(b) for a, b in ((bottom, left), (left, top), (top, right), (right, bottom))]


def diagonals_of(sides):
    """How much too long the diagonals / and \\ are."""
    left, top = sides[:2]
    corners = corners_of(sides)
    nominal = math.hypot(left.line.length, top.line.length)
    return np.linalg.norm(corners[2] - corners[0]) - nominal, np.linalg.norm(corners[3] - corners[1]) - nominal


def lengths_of_diagonals(part, samples):
    """Of the square, / and \\, in mm."""
    feature = FEATURES[part]["square"]
    corners = corners_of([measure_side(samples, feature, line) for line in feature.sides])
    return [np.linalg.norm(corners[2] - corners[0]), np.linalg.norm(corners[3] - corners[1])]


def measure_square(sides):
    """Its bottom is the datum."""
    left, top, right, bottom = sides
    up, down = diagonals_of(sides)
    return {
        "width": size(left, right),
        "height": size(top, bottom),
        "straightness of the sides": max(side.zone(side.slope) for side in sides),
        "squareness of left and right to the bottom": max(side.zone(bottom.slope) for side in (left, right)),
        "parallelism of opposite sides": max(top.zone(bottom.slope), left.zone(right.slope)),
        "diagonal /": up,
        "diagonal \\": down,
        "difference of the diagonals": up - down,
    }


def measure_diagonals(lines, datum):
    return {
        "straightness of both": max(line.zone(line.slope) for line in lines),
        "angularity, to 45 degrees": max(line.zone(datum.slope) for line in lines),
        "squareness to each other": lines[1].zone(lines[0].slope),
    }


def measure_turned(sides, datum, degrees, pairs):
    left, top, right, bottom = sides
    return {
        "width between " + pairs[0]: size(left, right),
        "width between " + pairs[1]: size(top, bottom),
        "straightness of the sides": max(side.zone(side.slope) for side in sides),
        "squareness of the sides": max(a.zone(b.slope) for a, b in zip(sides, sides[1:] + sides[:1])),
        f"angularity of the sides, to {degrees} degrees": max(side.zone(datum.slope) for side in sides),
        "largest error of an angle, um/m": UM * max((side.slope - datum.slope for side in sides), key=abs),
    }


def measure_part(part, samples):
    """Rows (feature, what, value in um) of a part."""
    features = FEATURES[part]
    sides = {
        name: [measure_side(samples, feature, line) for line in feature.sides] for name, feature in features.items()
    }
    datum = sides["square"][-1]
    found = {"square": measure_square(sides["square"])}
    if part == "square":
        found["diagonals"] = measure_diagonals(sides["diagonals"], datum)
    else:
        found["turned square"] = measure_turned(sides["turned square"], datum, 3, ("left and right", "top and bottom"))
        found["diamond"] = measure_turned(sides["diamond"], datum, 45, ("\\ and \\", "/ and /"))
        centre, radius, profile = measure_circle(samples, features["circle"])
        found["circle"] = {
            "circularity": np.ptp(profile),
            "diameter": 2 * (radius - features["circle"].radius),
            "centre, to that of the square": np.linalg.norm(centre - np.mean(corners_of(sides["square"]), axis=0)),
        }
    depths = [samples.error[on_line(samples, features["square"], side.line)[1], 2] for side in sides["square"]]
    found["square"]["depth, parallel to the table"] = np.ptp(np.concatenate(depths))
    return [(feature, what, UM * value) for feature, rows in found.items() for what, value in rows.items()]


# --- cutting ---


def change(path, old, new):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    if old not in text:
        raise RuntimeError(f"{path} has no {old!r}")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text.replace(old, new))


def prepare(kind, seed, feed, folder):
    """A copy of the configuration that cuts the parts on machine `seed`; returns its INI file."""
    machine = shutil.copytree(CONFIGURATION, os.path.join(folder, "machine"))
    at = lambda *names: os.path.join(machine, *names)
    ini = at(kind + ".ini")
    change(ini, "common/headless.py", os.path.join(ROOT, "scripts", "part_cuts.py"))
    # Task gives motion up after a time of the faster clock, which passes on a busy computer.
    change(at("common", "controller.inc"), "COMM_TIMEOUT = 30\n", "COMM_TIMEOUT = 300\n")
    change(at("compensation.hal"), "chain=[SQUARENESS]CHAIN", "chain=[SQUARENESS]CHAIN table=" + at("errors.csv"))
    with open(at("errors.csv"), "w", encoding="ascii") as file:
        for letter in "XYZW" if kind == "portal" else "XYZ":
            file.write(f"{letter},EX{letter}\n-1000,0\n1000,0\n")
    tilts = draw_tilts(kind, seed) if seed else {}  # machine 0 is that of the configuration
    settings = [f"square.{name} {angle!r}" for name, angle in tilts.items()]
    truth = [f"portal.{name} {angle!r}" for name, angle in tilts.items()]
    truth += [f"portal.seed {seed}", f"portal.drift-start {DRIFT_HOURS * 3600 if seed else 0}"]
    for name, lines in (("settings", settings), ("machine", truth)):
        with open(at(f"{kind}_{name}.hal"), "a", encoding="utf-8") as file:
            file.write("".join(f"setp {line}\n" for line in lines))
    for part in PARTS:
        change(at(MACHINES[kind].prefix + part + ".ngc"), f"F{FEED}\n", f"F{feed}\n")
    return ini


def cut(kind, seed, feed, parts=PARTS):
    """What read_recording() says of each (run, part) on machine `seed`."""
    with tempfile.TemporaryDirectory(prefix="plumb-part-") as folder:
        ini = prepare(kind, seed, feed, folder)
        command = [os.path.join(BUILD, "bin", "plumb"), "run", "--speed", f"{SPEED}", "--", "linuxcnc", "-r", ini, *parts]
        environment = {**os.environ, "HOME": folder, "PLUMB_BUILD": BUILD}
        said = []
        process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        with process:
            try:
                for line in process.stdout:
                    said.append(line)
                    if line.startswith(("cut ", "set ")):
                        print(f"{kind}: {line.rstrip()}", file=sys.stderr, flush=True)
            except BaseException:  # Ctrl-C
                process.terminate()
                raise
        if process.returncode:
            raise RuntimeError(f"linuxcnc ended with {process.returncode}:\n" + "".join(said[-30:]))
        return {
            (run, part): read_recording(os.path.join(folder, "machine", f"{part}-{run}.csv"), MACHINES[kind])
            for run in RUNS
            for part in parts
        }


def read_recording(path, kind):
    """Samples as they are, and Samples as they were if nothing but what no tilt describes were wrong."""
    with open(path, encoding="ascii") as file:
        header = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",", ndmin=2)
    nominal, error, beyond = rows[:, [header.index(name) for name in COLUMNS]].T.reshape(3, 3, -1)
    axes, ways = [*kind.plane, kind.into], np.array((1, 1, kind.way))
    nominal = (nominal.T - kind.origin)[:, axes] * ways
    return tuple(Samples(nominal, its.T[:, axes] * ways) for its in (error, beyond))


# --- what is printed ---


def part_table(kind, part, cuts):
    """The lines of the table of what is measured at a part, of cuts as cut() returns them."""
    measured = [cuts["with tilts", part][1] if run == "beyond" else cuts[run, part][0] for run in HEADINGS]
    columns = [measure_part(part, samples) for samples in measured]
    titles = (f"{TITLES[part]} on the {kind}, um", f"against nominal, in the plane {MACHINES[kind].names}")
    lines = [title + " " * (50 - len(title)) + "".join(f"{words[i]:>12}" for words in HEADINGS.values()) for i, title in enumerate(titles)]
    feature = ""
    for rows in zip(*columns):
        if rows[0][0] != feature:
            feature = rows[0][0]
            lines.append(feature)
        lines.append(f"    {rows[0][1]:46}" + "".join(f"{figure(rows[0][1], value):>12}" for _, _, value in rows))
    return lines


HEADINGS = {
    "without": ("without", "correction"),
    "with tilts": ("tilts of", "the guides"),
    "beyond": ("of it not", "by tilts"),
    "by diagonals": ("tilt by its", "diagonals"),
    "with tables": ("tilts and", "tables"),
}
TITLES = {"square": "Square of 300 mm with its diagonals", "contour": "Test piece after ISO 10791-7"}
SIGNED = ("width", "height", "diagonal", "difference", "diameter", "largest")


def figure(what, value):
    text = f"{value:{'+' if what.startswith(SIGNED) else ''}.2f}"
    return "0.00" if float(text) == 0 else text


def left_by_tilts(cuts):
    """The largest distance of the tip from where it were without tilts, along all sides, in um."""
    return max(
        UM * np.linalg.norm(is_.error[rows] - beyond.error[rows], axis=1).max()
        for (run, part), (is_, beyond) in cuts.items()
        if run == "with tilts"
        for feature in FEATURES[part].values()
        for line in feature.sides
        for rows in [on_line(is_, feature, line)[1]]
    )


# --- what is written ---


def outline(part, samples, every=1.0):
    """(feature, nominal points, deviations, too deep by) of each side and circle, in mm: as an inspector has the part before
    him, aligned to the bottom side and the middle of the square."""
    square = [measure_side(samples, FEATURES[part]["square"], line) for line in FEATURES[part]["square"].sides]
    shift, slope = np.mean(corners_of(square), axis=0), square[-1].slope
    found = []
    for name, feature in FEATURES[part].items():
        for line in feature.sides:
            along, rows = on_line(samples, feature, line, edge=0)
            at = np.linspace(-line.length / 2, line.length / 2, round(line.length / every) + 1)
            found.append([name, line.middle + np.outer(at, line.along), _between(at, along, samples.error[rows])])
        if feature.radius:
            angles, rows = on_circle(samples, feature)
            at = np.linspace(-math.pi, math.pi, 4 * round(math.pi * feature.radius / every) + 1)
            order = np.argsort(angles)
            nominal = feature.radius * np.column_stack((np.cos(at), np.sin(at)))
            found.append([name, nominal, _between(at, angles[order], samples.error[rows][order])])
    return [
        (name, nominal, its[:, :2] - shift - slope * np.column_stack((-nominal[:, 1], nominal[:, 0])), its[:, 2])
        for name, nominal, its in found
    ]


def _between(at, places, values):
    return np.column_stack([np.interp(at, places, column) for column in values.T])


def write_points(path, machines):
    """One row for each mm that was cut."""
    with open(path, "w", newline="", encoding="ascii") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["machine", "run", "part", "feature", "right_mm", "up_mm", "right_error_um", "up_error_um", "depth_error_um"]
        )
        for kind, cuts in machines.items():
            for (run, part), (samples, _) in cuts.items():
                for feature, nominal, deviation, depth in outline(part, samples):
                    rows = np.column_stack((nominal, UM * deviation, UM * depth))
                    writer.writerows([kind, run, part, feature, *(f"{value:.3f}" for value in row)] for row in rows)


GREY = "#777777"
ENLARGED = 2000
BAR = 10  # um
DRAWN = {  # of RUNS
    "without": ("without correction", COLOURS["without"]),
    "by diagonals": ("tilt set by diagonals", COLOURS["with tilts"]),
    "with tables": ("tilts and tables", COLOURS["with tables"]),
}


def draw(paths, part, machines, seed):
    """A row for each machine, a column for each of DRAWN: the nominal contour, and the deviation from it enlarged."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"svg.hashsalt": "plumb", "font.size": 10})
    sheet, views = pyplot.subplots(
        len(machines), len(DRAWN), figsize=(11, 3.9 * len(machines) + 0.3), squeeze=False, layout="constrained"
    )
    title = f"{TITLES[part]}, machine {seed}: deviation from nominal, enlarged {ENLARGED} times"
    sheet.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
    caption = "Grey: nominal."
    if seed:
        caption += " No tilt straightens what is bent; tables of an hour ago do not know of the drift since."
    sheet.supxlabel(caption, x=0.01, ha="left", fontsize=10, color=GREY)
    for row, (kind, cuts) in zip(views, machines.items()):
        for view, (run, (label, colour)) in zip(row, DRAWN.items()):
            samples = cuts[run, part][0]
            _draw_part(view, part, samples, colour)
            found = {(feature, what): value for feature, what, value in measure_part(part, samples)}
            told = f"squareness {found['square', 'squareness of left and right to the bottom']:.1f}, "
            if part == "contour":
                told += f"circularity {found['circle', 'circularity']:.1f} µm"
            else:
                told += f"diagonals {found['square', 'difference of the diagonals']:+.1f} µm"
            view.set_title(f"{kind}, {label}\n{told}", fontsize=10, color=colour)
            view.text(-170, -185, f"plane {MACHINES[kind].names}", va="center", color=GREY)
    for path in paths:
        sheet.savefig(path, dpi=120, metadata={"Date": None} if path.endswith(".svg") else None)
    pyplot.close(sheet)


def _draw_part(view, part, samples, colour):
    paths = []  # of what is cut in one go
    for name, nominal, deviation, _ in outline(part, samples, every=20.0):
        its = np.array((nominal, nominal + ENLARGED * deviation))
        if paths and paths[-1][0] == name != "diagonals":
            its = np.concatenate((paths.pop()[1], its), axis=1)
        paths.append((name, its))
    for name, (nominal, deviating) in paths:
        if name != "diagonals":
            deviating = np.vstack((deviating, deviating[:1]))
        view.plot(*nominal.T, color=GREY, linewidth=0.8)
        view.plot(*deviating.T, color=colour, linewidth=1.4)
    view.set_aspect("equal")
    view.set_xlim(-195, 195)
    view.set_ylim(-195, 165)
    view.axis("off")
    length = ENLARGED * BAR / UM
    view.plot((110 - length, 110), (-185, -185), color="black", linewidth=1.5, solid_capstyle="butt")
    view.text(116, -185, f"{BAR} µm", va="center")


# --- the command ---


def bench(kinds, parts, seed, feed, output):
    machines = {}
    for kind in kinds:
        machines[kind] = cut(kind, seed, feed, parts)
        for part in parts:
            print("\n".join(part_table(kind, part, machines[kind])) + "\n")
        print(f"What the guides' tilts leave where they are corrected: {micrometres(left_by_tilts(machines[kind]))} um\n", flush=True)
    written = []
    for part in parts:
        charts = [os.path.join(output, f"{part}.{end}") for end in ("png", "svg")]
        draw(charts, part, machines, seed)
        written += charts
    written.append(os.path.join(output, "points.csv"))
    write_points(written[-1], machines)
    print("Written: " + "  ".join(os.path.relpath(path) for path in written))


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench part", description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=whole(0, 2**31 - 1), default=1, metavar="N", help="draw machine N (default: 1); 0 has nothing wrong but the tilts of configs/portal")
    parser.add_argument("--machine", choices=list(MACHINES), help="one of them (default: both)")
    parser.add_argument("--part", choices=PARTS, help="one of them (default: both)")
    parser.add_argument("--feed", type=whole(100, 12000), default=FEED, metavar="F", help=f"mm/min (default: {FEED})")
    parser.add_argument("--output", default=os.path.join(BUILD, "bench", "part"), metavar="DIR", help="where the files go (default: build/bench/part)")
    options = parser.parse_args()
    try:
        os.makedirs(options.output, exist_ok=True)
        try:
            tempfile.TemporaryFile(dir=options.output).close()
        except OSError as error:  # now, and not when all is done
            raise OSError(f"cannot write into {options.output}: {error.strerror}") from error
        kinds = [options.machine] if options.machine else list(MACHINES)
        bench(kinds, [options.part] if options.part else PARTS, options.seed, options.feed, options.output)
    except KeyboardInterrupt:
        sys.exit(130)
    except (RuntimeError, OSError, ValueError) as error:
        sys.exit(f"scripts/bench: {error}")


if __name__ == "__main__":
    main()

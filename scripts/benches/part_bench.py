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

from bench_command import errors_told, make_writable, whole
from error_tables import blank_table, write_error_tables
from part_inspection import FEATURES, UM, Samples, corners_of, measure_part, measure_side, on_circle, on_line
from portal_bench import COLOURS, micrometres
from portal_machine import draw_tilts
from simulations import BUILD, ROOT
from plumb_run import plumb_run

CONFIGURATION = os.path.join(ROOT, "configs", "portal")

RUNS = ("without", "with tilts", "by diagonals", "with tables")
PARTS = ("square", "contour")
FEED = 2400  # mm/min, as in the G-code
SPEED = 20  # times real time
DRIFT_HOURS = 1  # since tilts and tables were measured

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
    change(ini, "common/headless.py", os.path.join(ROOT, "scripts", "benches", "part_cuts.py"))
    change(ini, "PARAMETER_FILE = ", "PARAMETER_FILE = /dev/shm/")  # of a run; the disk may keep LinuxCNC waiting
    # Task gives motion up after a time of the faster clock, which passes on a busy computer.
    change(at("common", "controller.inc"), "COMM_TIMEOUT = 30\n", "COMM_TIMEOUT = 300\n")
    change(at("compensation.hal"), "chain=[SQUARENESS]CHAIN", "chain=[SQUARENESS]CHAIN table=" + at("errors.csv"))
    letters = "XYZW" if kind == "portal" else "XYZ"
    write_error_tables(at("errors.csv"), [blank_table(letter, -1000, 1000) for letter in letters], f"ideal {kind}")
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
        command = [*plumb_run(BUILD, "--speed", f"{SPEED}"), "linuxcnc", "-r", ini, *parts]
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
    with errors_told():
        make_writable(options.output)
        kinds = [options.machine] if options.machine else list(MACHINES)
        bench(kinds, [options.part] if options.part else PARTS, options.seed, options.feed, options.output)


if __name__ == "__main__":
    main()

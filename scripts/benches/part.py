# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts two parts in a complete LinuxCNC on tilted machines and measures them, without and with squareness.

configs/portal, a complete LinuxCNC with its G-code, runs in virtual time; sim_portal has the true position of the
tip in each servo cycle. The cut is measured as an inspector would: straight lines and circles of least squares through the
points of each side (ISO 1101, ISO 4291), against the bottom side as the datum. The error from straightness, pitch, yaw, sag and
drift is reported separately from the error from tilts.

The parts are cut without correction; with the tilts of the guides as they were; with the tilt that `plumb squareness` makes of
the diagonals of the square that was cut without; and with tables of all that an instrument finds on the axes.
"""

import concurrent.futures
import math
import os
import subprocess
import sys
import threading

import numpy as np

from support import charts
from support.command import add_output, errors_reported, make_writable, new_parser, whole, written_line
from support.figures import micrometres
from support.part_inspection import FEATURES, UM, corners_of, measure_part, measure_side, on_circle, on_line
from support.part_machines import FEED, MACHINES, PARTS, RUNS, prepare, read_recording
from support.recordings import write_rows
from support.simulations import BUILD
from plumb_run import plumb_run

TARGETS = "product"
SPEEDS = (30, 15, 5)

# --- cutting ---


def cut_all(kinds, seed, feed, parts):
    """The results of cut() for each kind, all at a time where each has a HAL of its own."""
    at_once = len(kinds) if "--no-namespaces" not in plumb_run(BUILD) else 1
    stop = threading.Event()
    with concurrent.futures.ThreadPoolExecutor(at_once) as pool:
        cuts = [pool.submit(cut_at_some_speed, kind, seed, feed, parts, stop) for kind in kinds]
        try:
            return {kind: its.result() for kind, its in zip(kinds, cuts)}
        finally:
            stop.set()  # after an error or Ctrl-C
            pool.shutdown(cancel_futures=True)


def cut_at_some_speed(kind, seed, feed, parts, stop):
    """Slower where LinuxCNC fails: on a busy computer its programs do not keep up with a fast clock."""
    for speed, slower in zip(SPEEDS, (*SPEEDS[1:], None)):
        try:
            return cut(kind, seed, feed, parts, speed, stop)
        except RuntimeError as error:
            if slower is None or stop.is_set():
                raise
            print(f"{kind}: {error}\nAgain at {slower} times real time, not {speed}.", file=sys.stderr, flush=True)


def cut(kind, seed, feed, parts, speed, stop):
    """The results of read_recording() for each (run, part) on machine `seed`."""
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        ini, options = prepare(kind, seed, folder)
        words = [word for name, value in options.items() for word in ("--option", f"{name}={value}")]
        command = [*plumb_run(BUILD, "--speed", f"{speed}", *words), "linuxcnc", "-r", ini, f"--feed={feed}", *parts]
        environment = {**os.environ, "HOME": folder, "PLUMB_BUILD": BUILD}
        said = []
        process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        with process:
            ended = threading.Event()
            threading.Thread(target=terminate_at, args=(stop, ended, process)).start()
            try:
                for line in process.stdout:
                    said.append(line)
                    if line.startswith(("cut ", "set ")):
                        print(f"{kind}: {line.rstrip()}", file=sys.stderr, flush=True)
            finally:
                ended.set()
        if process.returncode:
            raise RuntimeError(f"linuxcnc ended with {process.returncode}:\n" + "".join(said[-30:]))
        return {
            (run, part): read_recording(os.path.join(folder, "machine", f"{part}-{run}.csv"), MACHINES[kind])
            for run in RUNS
            for part in parts
        }


def terminate_at(stop, ended, process):
    while not ended.wait(0.2):
        if stop.is_set():
            process.terminate()
            return


# --- print ---


def part_table(kind, part, cuts):
    """The lines of the table of measurements of a part; cuts as cut() returns them."""
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


# --- write ---


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
    header = ["machine", "run", "part", "feature", "right_mm", "up_mm", "right_error_um", "up_error_um", "depth_error_um"]
    write_rows(path, header, (row for kind, cuts in machines.items() for row in point_rows(kind, cuts)))


def point_rows(kind, cuts):
    for (run, part), (samples, _) in cuts.items():
        for feature, nominal, deviation, depth in outline(part, samples):
            for row in np.column_stack((nominal, UM * deviation, UM * depth)):
                yield [kind, run, part, feature, *(f"{value:.3f}" for value in row)]


ENLARGED = 2000
BAR = 10  # um
DRAWN = {  # of RUNS
    "without": ("without correction", charts.ORANGE),
    "by diagonals": ("tilt set by diagonals", charts.BLUE),
    "with tables": ("tilts and tables", charts.GREEN),
}


def draw(paths, part, machines, seed):
    """A row for each machine, a column for each of DRAWN: the nominal contour, and the deviation from it enlarged."""
    pyplot = charts.prepared_pyplot()
    sheet, views = pyplot.subplots(
        len(machines), len(DRAWN), figsize=(11, 3.9 * len(machines) + 0.3), squeeze=False, layout="constrained"
    )
    title = f"{TITLES[part]}, machine {seed}: deviation from nominal, enlarged {ENLARGED} times"
    charts.write_title(sheet, title)
    caption = "Grey: nominal."
    if seed:
        caption += " No tilt straightens what is bent; tables of an hour ago do not know of the drift since."
    sheet.supxlabel(caption, x=0.01, ha="left", fontsize=10, color=charts.LIGHT_GREY)
    for row, (kind, cuts) in zip(views, machines.items()):
        for view, (run, (label, colour)) in zip(row, DRAWN.items()):
            samples = cuts[run, part][0]
            _draw_part(view, part, samples, colour)
            found = {(feature, what): value for feature, what, value in measure_part(part, samples)}
            summary = f"squareness {found['square', 'squareness of left and right to the bottom']:.1f}, "
            if part == "contour":
                summary += f"circularity {found['circle', 'circularity']:.1f} µm"
            else:
                summary += f"diagonals {found['square', 'difference of the diagonals']:+.1f} µm"
            view.set_title(f"{kind}, {label}\n{summary}", fontsize=10, color=colour)
            view.text(-170, -185, f"plane {MACHINES[kind].names}", va="center", color=charts.LIGHT_GREY)
    charts.save(sheet, paths)


def _draw_part(view, part, samples, colour):
    paths = []  # each is cut in one go
    for name, nominal, deviation, _ in outline(part, samples, every=20.0):
        its = np.array((nominal, nominal + ENLARGED * deviation))
        if paths and paths[-1][0] == name != "diagonals":
            its = np.concatenate((paths.pop()[1], its), axis=1)
        paths.append((name, its))
    for name, (nominal, deviating) in paths:
        if name != "diagonals":
            deviating = np.vstack((deviating, deviating[:1]))
        view.plot(*nominal.T, color=charts.LIGHT_GREY, linewidth=0.8)
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
    machines = cut_all(kinds, seed, feed, parts)
    for kind in kinds:
        for part in parts:
            print("\n".join(part_table(kind, part, machines[kind])) + "\n")
        print(f"Error from the guides' tilts that correction leaves: {micrometres(left_by_tilts(machines[kind]))} um\n", flush=True)
    written = []
    for part in parts:
        charts = [os.path.join(output, f"{part}.{end}") for end in ("png", "svg")]
        draw(charts, part, machines, seed)
        written += charts
    written.append(os.path.join(output, "points.csv"))
    write_points(written[-1], machines)
    print(written_line(written))


def main():
    parser = new_parser("part", __doc__)
    parser.add_argument("--seed", type=whole(0, 2**31 - 1), default=1, metavar="N", help="draw machine N (default: 1); 0 has nothing wrong but the tilts of configs/portal")
    parser.add_argument("--machine", choices=list(MACHINES), help="one of them (default: both)")
    parser.add_argument("--part", choices=PARTS, help="one of them (default: both)")
    parser.add_argument("--feed", type=whole(100, 12000), default=FEED, metavar="F", help=f"mm/min (default: {FEED})")
    add_output(parser, "part")
    options = parser.parse_args()
    with errors_reported():
        make_writable(options.output)
        kinds = [options.machine] if options.machine else list(MACHINES)
        bench(kinds, [options.part] if options.part else PARTS, options.seed, options.feed, options.output)


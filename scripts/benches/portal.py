# SPDX-License-Identifier: GPL-2.0-or-later
"""Drives tilted machines through a 1 m cube and measures the tip error, without and with squareness.

configs/portal/bench.hal runs in the virtual-time host. Its axes stop at the points of a cube of a metre, with tools of
different length; at each point the tip error is read: as the machine is, with its tilts corrected, and with tables of
all that an instrument finds on its axes. The error from straightness, pitch, yaw, sag and drift is reported separately
from the error from tilts.
"""

import itertools
import os
import sys

import numpy as np

from support import charts
from support.command import add_output, add_place, errors_reported, make_writable, new_parser, place_of, whole, written_line
from support.figures import micrometres, percentile_lines, rms
from support.portal_machine import ARCSEC, AXES, CAUSES, CHAINS, DRIFT_HOURS, LONGEST, RUNS, SPANS, STOP, UM
from support.portal_machine import cases, cube, duration, every_direction, simulate
from support.recordings import write_rows
from support.simulations import simulate_all

TARGETS = "simulation_portal"
PACKAGES = "python3-matplotlib"

# --- print ---


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


def remainder_lines(outcome):
    """The error that the tilts leave, the rest, each cause by itself, and the cost of mistakes."""
    lines = [f"    {'left by the tilts':40}{micrometres(outcome.visits['with tilts'].left_by_tilts):>10}"]
    lines += [f"    {'left by ' + cause_text(cause):40}{micrometres(outcome.causes[cause]):>10}" for cause in CAUSES]
    return lines + [f"    {mistake:40}{micrometres(um):>10}" for mistake, um in outcome.mistakes.items() if um >= 1e-6]


def percentile_table(outcomes):
    """The lines of the table over many machines of one kind, of the largest tip error of each."""
    rows = {run: [outcome.visits[run].lengths.max() for outcome in outcomes] for run in RUNS}
    rows["with tilts, left by tilts"] = [outcome.visits["with tilts"].left_by_tilts for outcome in outcomes]
    for cause in CAUSES:
        rows[f"with tilts, left by {cause_text(cause)}"] = [outcome.causes[cause] for outcome in outcomes]
    title = f"Largest tip error over the {outcomes[0].machine}, um"
    return percentile_lines(title, rows.items(), 10, micrometres, 44)


def worst_lines(worst):
    return [
        f"{worst.machine + ':':8} {worst.cases} cases at {worst.points} points: "
        f"{worst.without:.0f} um without, {micrometres(worst.compensated)} um with compensation, with",
        f"         {worst.where}",
    ]


# --- write ---


def write_points(path, outcomes):
    """One row for each tool at each point."""
    header = ["machine", "run", "tool_length_mm", "radial_offset_mm", "radial_direction_deg"]
    header += [f"{axis}_mm" for axis in AXES]
    header += [f"{axis}_{what}_um" for what in ("error", "beyond_tilts") for axis in "xyz"]
    write_rows(path, header, (row for outcome in outcomes for row in point_rows(outcome)))


def point_rows(outcome):
    for run, its in outcome.visits.items():
        for t, tool in enumerate(outcome.tools):
            for p, point in enumerate(outcome.points):
                measured = [f"{value:.4f}" for value in (*its.error[t][p], *its.beyond[t][p])]
                yield [outcome.machine, run, tool.length, tool.radial, tool.direction, *point, *measured]


COLOURS = {"without": charts.ORANGE, "with tilts": charts.BLUE, "with tables": charts.GREEN}
ENLARGED = 2000
FINEST = 0.01  # um, where the axis of errors begins


def draw(paths, outcomes, title):
    """The cube as the tip of the longest tool goes round it, errors enlarged; and all errors, sorted."""
    pyplot = charts.prepared_pyplot()
    figure = pyplot.figure(figsize=(11, 4.6 * len(outcomes)), layout="constrained")
    charts.write_title(figure, title)
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
        errors.grid(color=charts.GRID, linewidth=0.6)
    charts.save(figure, paths)


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


def bench_one(seed, steps, output, place):
    tasks = [(kind, seed, steps) for kind in CHAINS]
    outcomes = simulate_all(simulate, tasks, sum(duration(kind, steps) for kind in CHAINS), place)
    for outcome in outcomes:
        print("\n".join(cube_table(outcome)))
        print("With tilts, largest; each cause, and each mistake, by itself:")
        print("\n".join(remainder_lines(outcome)) + "\n")
    paths = [os.path.join(output, name) for name in ("cubes.png", "cubes.svg", "points.csv")]
    machine = f"machine {seed}" if seed else "machine 0, which has nothing wrong but its tilts"
    draw(paths[:2], outcomes, f"A cube of a metre on {machine}")
    write_points(paths[2], outcomes)
    print(written_line(paths))


def bench_directions(place):
    """Whether all is below the 0.01 um that squareness promises."""
    print(f"Every direction in which they can lean, by 100 arcsec each, with a {tool_text(LONGEST)}:")
    tasks = [(kind, 100 * ARCSEC, 3) for kind in CHAINS]
    expected = sum(len(cases(kind)) * len(cube(kind, 3)) * STOP for kind in CHAINS)
    worst = simulate_all(every_direction, tasks, expected, place)
    for its in worst:
        print("\n".join(worst_lines(its)))
    return all(its.compensated < 0.01 for its in worst)


def bench_many(seeds, steps, place):
    print(f"{len(seeds)} machines, {seeds[0]} to {seeds[-1]}\n")
    for kind in CHAINS:
        tasks = [(kind, seed, steps) for seed in seeds]
        outcomes = simulate_all(simulate, tasks, duration(kind, steps) * len(seeds), place)
        print("\n".join(percentile_table(outcomes)) + "\n")


def main():
    parser = new_parser("portal", __doc__)
    seed, many = whole(0, 2**31 - 1), whole(1, 100000)
    parser.add_argument("--seed", type=seed, default=1, metavar="N", help="draw machine N (default: 1); 0 has nothing wrong but its tilts")
    parser.add_argument("--seeds", type=many, metavar="N", help="N drawn machines, from --seed on, and a table of percentiles")
    parser.add_argument("--directions", action="store_true", help="every direction in which they can lean, both readings, against rail and bed")
    parser.add_argument("--cube", type=whole(2, 11), default=3, metavar="N", help="N points along each side (default: 3)")
    add_place(parser)
    add_output(parser, "portal")
    options = parser.parse_args()
    place = place_of(options)
    with errors_reported():
        if options.directions:
            sys.exit(0 if bench_directions(place) else 1)
        if options.seeds:
            bench_many(range(options.seed, options.seed + options.seeds), options.cube, place)
            return
        make_writable(options.output)
        bench_one(options.seed, options.cube, options.output, place)


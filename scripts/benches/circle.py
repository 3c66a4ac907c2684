# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts circles on machines with lost motion, without and with direction columns of squareness.

configs/portal/bench.hal runs in the virtual-time host, its drives with play that varies along the travel and sticks. The
lost motion is measured with a noisy indicator from both sides, and `plumb volume reversal` makes the tables. A ballbar
reads the same paths.
"""

import os
import sys

import numpy as np

from support import charts
from support.circle_machine import NOISE, RUNS, simulate
from support.command import add_output, add_place, errors_reported, make_writable, new_parser, place_of, whole, written_line
from support.figures import micrometres, percentile_lines
from support.portal_machine import UM
from support.recordings import write_rows
from support.simulations import simulate_all

TARGETS = "simulation_portal plumb-volume"
PACKAGES = "python3-matplotlib"

ENLARGED = 1000


def machine_text(its):
    plays = ", ".join(f"{axis.upper()} {its.play[axis] * UM:.1f}" for axis in its.plane)
    return f"machine {its.seed}: plane {its.plane.upper()}, F{its.feed:.0f} R{its.radius:.0f}, Kv {its.gain:.0f}/s, play {plays} um"


def report(outcomes):
    """The table, and whether all limits are kept."""
    rows = {f"peak {run}": [its.peaks[run] for its in outcomes] for run in RUNS}
    rows["kept by the law of the turn"] = [its.law for its in outcomes]
    rows.update({f"G {run}": [its.roundness[run] for its in outcomes] for run in RUNS})
    rows["both sides at rest, with tables"] = [its.rest for its in outcomes]
    print("\n".join(percentile_lines(f"{len(outcomes)} machines, um", rows.items(), 10, micrometres, 40)))
    peaks = [its.peaks["with tables"] <= 1.2 * its.law + 0.3 for its in outcomes]
    rests = [its.rest <= its.rest_allowed for its in outcomes]
    openings = [abs(value - truth) <= max(U, 1.5) for its in outcomes for value, U, truth in [its.ballbar["opening, urad"]]]
    print(f"peak at most 1.2 times the law and 0.3 um:    {sum(peaks)} of {len(peaks)}")
    print(f"at rest at most 0.5 um and U of the indicator: {sum(rests)} of {len(rests)}")
    print(f"opening by ballbar within 1.5 urad or its U:   {sum(openings)} of {len(openings)}, noise {NOISE * UM:.1f} um")
    for its, good in zip(outcomes, peaks):
        if not good:
            print(f"  {machine_text(its.machine)}: {its.peaks['with tables']:.2f} um, law {its.law:.2f} um")
    return all(peaks) and all(rests) and all(openings)


def draw_circles(paths, outcome):
    pyplot = charts.prepared_pyplot()
    figure, views = pyplot.subplots(1, 2, figsize=(11, 5.4), layout="constrained", sharex=True, sharey=True)
    charts.write_title(figure, f"Circles in both directions, {machine_text(outcome.machine)}; deviation × {ENLARGED}")
    for view, run in zip(views, RUNS):
        radius = outcome.machine.radius
        around = np.linspace(0, 2 * np.pi, 361)
        view.plot(radius * np.cos(around), radius * np.sin(around), color=charts.GREY, linewidth=0.8, linestyle=":")
        for (angles, deviation), colour, name in zip(outcome.traces[run], (charts.BLUE, charts.ORANGE), ("counter-clockwise", "clockwise")):
            order = np.argsort(angles)
            shown = radius + deviation[order] / UM * ENLARGED
            view.plot(shown * np.cos(angles[order]), shown * np.sin(angles[order]), color=colour, linewidth=1.4, label=name)
        view.set_aspect("equal")
        view.set_title(f"{run}: largest {micrometres(outcome.peaks[run])} µm", loc="left")
        view.set_xlabel(outcome.machine.plane[0].upper() + " (mm)")
        view.set_ylabel(outcome.machine.plane[1].upper() + " (mm)")
        view.grid(color=charts.GRID, linewidth=0.6)
    views[0].legend(loc="center", frameon=False)
    charts.save(figure, paths)


def main():
    parser = new_parser("circle", __doc__)
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="first machine (default: 1)")
    parser.add_argument("--seeds", type=whole(1, 100000), default=4, metavar="N", help="number of drawn machines (default: 4)")
    add_place(parser)
    add_output(parser, "circle")
    options = parser.parse_args()
    with errors_reported():
        make_writable(options.output)
        seeds = range(options.seed, options.seed + options.seeds)
        outcomes = simulate_all(simulate, [(seed,) for seed in seeds], 2 * len(seeds), place_of(options))
        good = report(outcomes)
        paths = [os.path.join(options.output, name) for name in ("circles.png", "circles.svg", "machines.csv")]
        draw_circles(paths[:2], max(outcomes, key=lambda its: its.peaks["without"]))
        header = ["seed", "plane", "feed_mm_min", "radius_mm", "peak_without_um", "peak_with_um", "G_without_um", "G_with_um", "law_um", "rest_um", "opening_urad", "opening_U_urad", "opening_truth_urad"]
        write_rows(paths[2], header, ([o.machine.seed, o.machine.plane, o.machine.feed, o.machine.radius, *(f"{v:.4f}" for v in (*o.peaks.values(), *o.roundness.values(), o.law, o.rest, *o.ballbar["opening, urad"]))] for o in outcomes))
        print(written_line(paths))
        sys.exit(0 if good else 1)

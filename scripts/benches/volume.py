# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures machines with noisy instruments, corrects them, and checks the uncertainty that plumb volume states.

Each drawn machine leans, and its axes have scale errors and lost motion. A square, an indicator and a laser measure it,
each with its own error. squareness corrects it by these measurements in the virtual-time host.
"""

import os
import sys

import numpy as np

from support import charts, volume_files, volume_list, volume_machine
from support.command import add_output, add_place, errors_reported, make_writable, new_parser, place_of, whole, written_line
from support.figures import micrometres, percentile_lines
from support.recordings import write_rows
from support.simulations import simulate_all
from support.volume_methods import agreement, corners

TARGETS = "squareness plumb-squareness plumb-volume plumb-host"
PACKAGES = "python3-matplotlib"


def simulate(seed, progress):
    """A machine, and its corners by four methods."""
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        found = corners(volume_machine.draw(seed), folder)
    return volume_machine.simulate(seed, progress), found


def coverage(outcomes):
    """The part of the components inside their own U, and inside U of the worst direction, in %."""
    parts = np.concatenate([np.abs(its.errors) <= its.U_axis for its in outcomes])
    worst = np.concatenate([np.abs(its.errors) <= its.U[:, None] for its in outcomes])
    return 100 * parts.mean(axis=0), 100 * parts.mean(), 100 * worst.mean()


def report(outcomes, its_corners):
    rows = {
        "largest error without correction": [its.without for its in outcomes],
        "largest error with correction": [np.linalg.norm(its.errors, axis=1).max() for its in outcomes],
        "largest U, as stated": [its.U.max() for its in outcomes],
    }
    print("\n".join(percentile_lines(f"{len(outcomes)} machines, corners of 800 x 600 x 500 mm, um", rows.items(), 10, micrometres, 54)))
    axes, all_of_them, worst = coverage(outcomes)
    print("components inside their U: " + ", ".join(f"{name} {part:.1f} %" for name, part in zip("XYZ", axes)) + f"; all {all_of_them:.1f} %")
    print(f"components inside U of the worst direction: {worst:.1f} %")
    agree, contradict, pairs = agreement(its_corners)
    print(f"corners by square, diagonals, body diagonals and ballbar: {agree:.1f} % of {pairs} pairs agree within 2 u, {contradict} of contrary sign")
    return 93 <= all_of_them <= 97.5 and agree >= 93 and contradict == 0


def report_files(seeds):
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        outcomes = [volume_files.simulate(seed, folder) for seed in seeds]
    good = True
    for kind, (_options, resolution) in volume_files.KINDS.items():
        largest = max(its.differences[kind] for its in outcomes)
        kept = largest <= 0.1 + resolution * volume_files.UM
        good &= kept
        print(f"{kind:18} {len(outcomes)} tables there and back: largest difference {largest:.6f} um{'' if kept else ', too much'}")
    spoiled = [(its.seed, kind, way, ended) for its in outcomes for (kind, way), ended in its.spoiled.items()]
    print(f"files spoiled, or told to be of the other sign: {sum(not its[3] for its in spoiled)} of {len(spoiled)} taken rightly, or refused with file and reason")
    for seed, kind, way, ended in [its for its in spoiled if its[3]][:20]:
        print(f"  table {seed}, {kind}, {way}: {ended.strip()}")
    return good and not any(its[3] for its in spoiled)


def draw_scatter(paths, outcomes):
    pyplot = charts.prepared_pyplot()
    figure, (view, sizes) = pyplot.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    charts.write_title(figure, f"Error of distances after correction, and its stated uncertainty: {len(outcomes)} machines")
    ratios = np.concatenate([(its.errors / its.U_axis).ravel() for its in outcomes])
    view.hist(ratios, bins=np.linspace(-2, 2, 61), color=charts.BLUE)
    for side in (-1, 1):
        view.axvline(side, color=charts.ORANGE, linewidth=1.6)
    view.set_xlabel("error of a component over its U")
    view.set_ylabel("components")
    for values, colour, name in (
        ([its.without for its in outcomes], charts.ORANGE, "without correction"),
        ([np.linalg.norm(its.errors, axis=1).max() for its in outcomes], charts.BLUE, "with correction"),
        ([its.U.max() for its in outcomes], charts.GREEN, "U, as stated"),
    ):
        sizes.plot(np.sort(values), np.arange(1, len(values) + 1) / len(values) * 100, color=colour, linewidth=2, label=name)
    sizes.set_xscale("log")
    sizes.set_xlabel("largest of a machine (µm)")
    sizes.set_ylabel("machines with less (%)")
    sizes.legend(frameon=False)
    for its in (view, sizes):
        its.grid(color=charts.GRID, linewidth=0.6)
    charts.save(figure, paths)


def main():
    parser = new_parser("volume", __doc__)
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="first machine (default: 1)")
    parser.add_argument("--seeds", type=whole(1, 100000), default=40, metavar="N", help="number of drawn machines (default: 40)")
    parser.add_argument("--files", action="store_true", help="instead: tables through the files of other controls and back, one for each seed")
    parser.add_argument("--list", action="store_true", help="instead: machines that have every error of the list, with the lines assumed, measured, and one left out")
    add_place(parser)
    add_output(parser, "volume")
    options = parser.parse_args()
    with errors_reported():
        make_writable(options.output)
        seeds = range(options.seed, options.seed + options.seeds)
        if options.files:
            sys.exit(0 if report_files(seeds) else 1)
        if options.list:
            lines, good = volume_list.figures(simulate_all(volume_list.simulate, [(seed,) for seed in seeds], len(seeds), place_of(options)))
            print("\n".join(lines))
            sys.exit(0 if good else 1)
        found = simulate_all(simulate, [(seed,) for seed in seeds], len(seeds), place_of(options))
        outcomes = [outcome for outcome, _ in found]
        good = report(outcomes, [corner for _, corners_of_one in found for corner in corners_of_one])
        paths = [os.path.join(options.output, name) for name in ("coverage.png", "coverage.svg", "corners.csv")]
        draw_scatter(paths[:2], outcomes)
        header = ["seed", *(f"{axis}_error_um" for axis in "xyz"), *(f"{axis}_U_um" for axis in "xyz"), "U_um"]
        write_rows(paths[2], header, ([its.seed, *(f"{value:.4f}" for value in (*error, *own, U))] for its in outcomes for error, own, U in zip(its.errors, its.U_axis, its.U)))
        print(written_line(paths))
        sys.exit(0 if good else 1)

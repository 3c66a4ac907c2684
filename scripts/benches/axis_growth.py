# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares no compensation, thermal_displacement, axis_growth and both, on drawn machines.

A growth test of each machine gives its law (plumb growth identify). On another day, with drawn spindle speeds, the machine of
configs/mill/bench.hal cuts parts while it grows as sim_artifact does. An error is that of the tip at a cut less that at the
last cut of the learning cycle, for each axis; thermal_displacement corrects Z only. One more column has the law of machine 1,
which is another one of the same kind.

--days takes measured days of one machine instead, as CSV: a law is learned on each day and used on every other one.
"""

import os

import numpy as np

from support import growth_days, growth_machines
from support.command import add_place, duration_of, errors_reported, new_parser, place_of, whole
from support.figures import largest, rms
from support.growth_tests import DEVIATIONS, add_axis_growth, law_of, run_test
from support.mill_machine import same_inputs, start_mill
from support.recordings import read_columns
from support.simulations import duration_text, simulate_all

TARGETS = "simulation_mill simulation_growth axis_growth plumb-growth"
PERIOD = 0.004  # s, of the thread
EVERY = 0.4  # s between two rows of a recording; a cut dwells for longer
INSTANCES = {"axis_growth": "axis-growth", "its law": "another-growth"}
WAYS = ("off", "thermal_displacement", "axis_growth", "both", "law of machine 1")
OPTIONS = {"threads.period1": round(PERIOD * 1e9), "thermal_displacement.names": "growth,both"}
COLUMNS = ["program.learn", "mill.truth-cuts", "growth.z-offset", "growth.contacts-accepted", "both.z-offset", "both.contacts-accepted"]
COLUMNS += DEVIATIONS
COLUMNS += ["%s.%s-offset" % (instance, axis) for instance in INSTANCES.values() for axis in "xyz"]


def add_both(host):
    """A second thermal_displacement, which sees Z less the offset of axis_growth: LinuxCNC's feedback before joint_offset."""
    same_inputs(host, "growth", "both", without=("z-position",))
    host.command("loadrt sum2 names=less")
    host.set("less.gain1", -1)
    host.command("net z-position less.in0")
    host.command("net z-axis-growth axis-growth.z-offset less.in1")
    host.command("net z-without less.out both.z-position")
    host.command("addf less servo-thread")
    host.command("addf both.update servo-thread")
    host.set("both.enable", True)
    for pin in ("expected-growth", "unexplained-growth"):  # little is left for it
        host.set("both." + pin, 0.2 * host.get("both." + pin))


def work(folder, seed, laws, duration, progress):
    """The recording of a day of one machine."""
    import plumb

    path = os.path.join(folder, "recording.csv")
    with plumb.Host(options=OPTIONS) as host:
        start_mill(host, seed)
        growth_machines.load_machine(host, seed, {}, INSTANCES.values())
        host.command("net spindle-speed-cmd => artifact.spindle-speed-cmd axis-growth.spindle-speed another-growth.spindle-speed")
        host.command("net z-growth artifact.truth-z-deviation => mill.growth-replay")
        host.set("mill.use-replay", True)
        host.command("addf artifact.update servo-thread 1")
        host.run(1)
        for instance, law in zip(INSTANCES.values(), laws):
            add_axis_growth(host, law["lines"].replace("axis-growth.", instance + "."), instance)
        add_both(host)
        host.record(path, COLUMNS, EVERY)
        growth_machines.run_day(host, "program.sides-speed", seed, duration, progress)
        return read_columns(path)


def judge(column):
    """By way: errors in um, a row for each cut after the second warm contact of both, a column for each axis."""
    cuts = np.flatnonzero(np.diff(column["mill.truth-cuts"])) + 1
    learnt = cuts[column["program.learn"][cuts] > 0]
    known = (column["growth.contacts-accepted"] >= 2) & (column["both.contacts-accepted"] >= 2)
    warm = cuts[(column["program.learn"][cuts] == 0) & known[cuts - 1]]
    growth = np.column_stack([column[name] for name in DEVIATIONS])
    by_law = {
        name: np.column_stack([column["%s.%s-offset" % (instance, axis)] for axis in "xyz"]) for name, instance in INSTANCES.items()
    }
    only_z = np.array([0, 0, 1])
    offsets = {
        "off": 0 * growth,
        "thermal_displacement": column["growth.z-offset"][:, None] * only_z,
        "axis_growth": by_law["axis_growth"],
        "both": by_law["axis_growth"] + column["both.z-offset"][:, None] * only_z,
        "law of machine 1": by_law["its law"],
    }
    errors = {}
    for way in WAYS:
        left = growth - offsets[way]
        errors[way] = 1e3 * (left[warm] - left[learnt[-1]])
    return errors


def simulate(seed, duration, progress):
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        laws = [law_of(run_test(folder, number)) for number in (seed, 1)]
        errors = judge(work(folder, seed, laws, duration, progress))
    return {way: ([rms(values[:, axis]) for axis in range(3)], [largest(values[:, axis]) for axis in range(3)]) for way, values in errors.items() if len(values)}


def figures(outcomes):
    judged = [outcome for outcome in outcomes if outcome]
    lines = ["%d machines, of which %d had a cut after a second warm contact" % (len(outcomes), len(judged)), ""]
    lines.append("%-22s%s" % ("error at the cuts, um", "".join("%24s" % ("%s: median, p90, max" % axis) for axis in "XYZ")))
    for way in WAYS:
        cells = ""
        for axis in range(3):
            sizes = [outcome[way][0][axis] for outcome in judged]
            worst = max(outcome[way][1][axis] for outcome in judged)
            cells += "%12.1f%6.1f%6.1f" % (np.median(sizes), np.percentile(sizes, 90), worst)
        lines.append("%-22s%s" % (way, cells))
    return lines + ["", "median and p90 are of the rms of a machine, max is the worst cut of all"]


def pair_of_days(learnt, used, progress):
    found = growth_days.pair(learnt, used)
    progress(1)
    return found


def days_lines(paths, place):
    pairs = [(first, second) for first in range(len(paths)) for second in range(len(paths)) if first != second]
    found = simulate_all(pair_of_days, [(paths[first], paths[second]) for first, second in pairs], len(pairs), place)
    return growth_days.figures(paths, dict(zip(pairs, found)))


def machines_lines(options, place):
    seeds = range(options.seed, options.seed + options.seeds)
    structures = range(len(growth_machines.STRUCTURES))
    tasks = [(structure, seed, options.duration, options.hours) for structure in structures for seed in seeds]
    found = simulate_all(growth_machines.simulate, tasks, options.duration * len(tasks), place)
    outcomes = {structure: [each for task, each in zip(tasks, found) if task[0] == structure] for structure in structures}
    lines = growth_machines.figures(outcomes)
    return lines + ["", *growth_machines.expectations(outcomes, options.hours)] if options.hours else lines


def main():
    parser = new_parser("axis_growth", __doc__)
    parser.add_argument("--seeds", type=whole(1, 10000), default=100, metavar="N", help="machines of each structure (default: 100)")
    parser.add_argument("--seed", type=whole(2, 2**31 - 1), default=1001, metavar="N", help="the first of them")
    parser.add_argument("--for", type=duration_of, default="2h", dest="duration", metavar="TIME", help="length of the day (default: 2h)")
    parser.add_argument("--hours", type=whole(3, 24), metavar="H", help="growth tests by plumb growth plan, of this length")
    parser.add_argument("--days", nargs="+", metavar="FILE", help="measured days: a law of each, used on each other")
    parser.add_argument("--contacts", action="store_true", help="compare with thermal_displacement while parts are milled")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        if options.days:
            print("\n".join(days_lines([os.path.abspath(path) for path in options.days], place_of(options))))
            return
        if not options.contacts:
            lines = machines_lines(options, place_of(options))
            print("a day of %s, %d machines of each structure\n" % (duration_text(options.duration), options.seeds) + "\n".join(lines))
            return
        tasks = [(seed, options.duration) for seed in range(options.seed, options.seed + options.seeds)]
        outcomes = simulate_all(simulate, tasks, options.duration * options.seeds, place_of(options))
    print("a day of %s\n" % duration_text(options.duration) + "\n".join(figures(outcomes)))

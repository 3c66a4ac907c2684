# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs growth tests on drawn machines: are drift, gain and faults of the compensation found?

Each machine of configs/growth/bench.hal is tested once with each fault of its compensation. The log goes through plumb growth
report, and its results are compared with the truth of the machine. The compensation of a machine is not perfect without a fault:
with a factor of 1, 0.8 or 1.3 the right name is that of its true gain, below 0.9 too weak and above 1.15 too strong.
"""

import collections
import csv
import os

import numpy as np

from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.figures import largest, rms
from support.growth_tests import DEVIATIONS, results_of, run_test
from support.simulations import simulate_all

TARGETS = "simulation_growth plumb-growth"
FAULTS = ("none", "absent", "wrong sign", "0.8", "1.3", "swapped axes", "frozen sensor", "sensor offset", "swapped sensors")
NAMED = (0, 2, 3, 4, 5, 6, 7, 8, 9)  # CompensationFault, by the fault of the machine
GOOD, WEAK, STRONG = 0, 4, 5
FACTORS = (0, 3, 4)  # faults of the machine that are a factor, and none
ROOM = 0.03  # of a true gain that is so close to a limit that both names are right


def main():
    parser = new_parser("growth_faults", __doc__)
    parser.add_argument("--seeds", type=whole(1, 10000), default=20, metavar="N", help="machines (default: 20)")
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first of them")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        seeds = range(options.seed, options.seed + options.seeds)
        tasks = [(seed, fault) for fault in range(len(FAULTS)) for seed in seeds]
        found = simulate_all(simulate, tasks, len(tasks), place_of(options))
        print("\n".join(figures(seeds, dict(zip(tasks, found)))))


def simulate(seed, fault, progress):
    """(named fault, whether it is right, errors) of one test."""
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        log = run_test(folder, seed, {"artifact.compensation-fault": fault}, truth=fault in FACTORS)
        results = results_of(log)
        truth = os.path.join(folder, "truth.csv")
        errors = errors_of(results, log, truth) if fault == 0 else None
        names = names_of(true_gain(results, log, truth)) if fault in FACTORS else {NAMED[fault]}
    progress(1)
    named = results["compensation"]["fault"]
    return named, named in names, errors


def names_of(gain):
    """The names that are right for a factor."""
    weak, strong = gain < 0.9 + ROOM, gain > 1.15 - ROOM
    return {name for name, holds in ((GOOD, 0.9 - ROOM < gain < 1.15 + ROOM), (WEAK, weak), (STRONG, strong)) if holds}


def visits_of(log):
    """Number of the visit by bore, turned, compensated and pass; the second one of a pass is under another key."""
    found = {}
    with open(log, encoding="ascii") as file:
        for line in csv.reader(file):
            if line[0] == "event" and line[9] == "measured":
                key = (int(line[5]), line[6] == "1", line[7] == "1", int(line[3]))
                found[key + ((1,) if key + (0,) in found else (0,))] = int(line[4])
    return found


def truth_of(path):
    """Time and deviation of each visit, in the mean."""
    rows = collections.defaultdict(list)
    with open(path, encoding="ascii") as file:
        names = file.readline().strip().split(",")
        at = [names.index(name) for name in ["growth-test.elapsed"] + DEVIATIONS]
        probed, number = names.index("growth-test.at-bore"), names.index("growth-test.visit")
        for line in csv.reader(file):
            if float(line[probed]):
                rows[int(float(line[number]))].append([float(line[index]) for index in at])
    return {visit: np.mean(values, axis=0) for visit, values in rows.items()}


def by_pass(results, visits, truth, axis):
    """Compensation and true drift of each pass along an axis, in the mean of all bores with compensation."""
    found = collections.defaultdict(list)
    for series in results["series"]:
        if not series["compensated"]:
            continue
        points = series["points"]
        start = truth[visits[(series["bore"], series["turned"], True, points[0]["pass"], 0)]]
        for point in points:
            here = truth[visits[(series["bore"], series["turned"], True, point["pass"], 0)]]
            offset = point["compensation_mm"][axis] - points[0]["compensation_mm"][axis]
            found[point["pass"]].append((offset, here[1 + axis] - start[1 + axis]))
    return np.array([np.mean(values, axis=0) for values in found.values()]).T


def true_gain(results, log, truth_path):
    """Over all axes together."""
    visits, truth = visits_of(log), truth_of(truth_path)
    pairs = [by_pass(results, visits, truth, axis) for axis in range(3)]
    return sum(c @ d for c, d in pairs) / sum(d @ d for _, d in pairs)


def errors_of(results, log, truth_path):
    """Errors in um of deviations, half-sums and half-differences; gains with their truth and 2 u; drift and its truth."""
    visits, truth = visits_of(log), truth_of(truth_path)

    def true(bore, turned, number, time):
        """The deviation at the time of the pass: the drift within it is that of the bore that was visited twice."""
        first, again = truth[visits[(1, False, False, number, 0)]], truth.get(visits.get((1, False, False, number, 1)))
        rate = (again[1:] - first[1:]) / (again[0] - first[0]) if again is not None else 0
        here = truth[visits[(bore, turned, False, number, 0)]]
        return here[1:] - rate * (here[0] - time)

    both = {}
    deviations = []
    for series in results["series"]:
        if series["compensated"]:
            continue
        points = series["points"]
        start = true(series["bore"], series["turned"], points[0]["pass"], points[0]["time_s"])
        for point in points[1:]:
            error = np.array(point["deviation_mm"]) - (true(series["bore"], series["turned"], point["pass"], point["time_s"]) - start)
            deviations.append(error)
            both.setdefault((series["bore"], point["pass"]), {})[series["turned"]] = error
    pairs = [errors for errors in both.values() if len(errors) == 2]
    gains = []
    for axis, name in enumerate("XYZ"):
        gain = results["axes"][name]["gain"]
        if not gain["determined"]:
            continue
        c, d = by_pass(results, visits, truth, axis)
        gains.append((gain["value"] - c @ d / (d @ d), 2 * gain["uncertainty"], 1e3 * results["axes"][name]["off"]["largest_mm"]))
    return (
        1e3 * np.array(deviations).ravel(),
        1e3 * np.array([(errors[False] + errors[True]) / 2 for errors in pairs]).ravel(),
        1e3 * np.array([(errors[False] - errors[True]) / 2 for errors in pairs]).ravel(),
        gains,
    )


def figures(seeds, found):
    lines = ["%d drawn machines" % len(seeds), "", "Fault of the compensation   named rightly   called good wrongly"]
    for fault, name in enumerate(FAULTS):
        tests = [found[seed, fault] for seed in seeds]
        good = "%13d" % sum(named == GOOD and not right for named, right, _ in tests)
        lines.append("%-25s %9d %%%s" % (name, 100 * sum(right for _, right, _ in tests) // len(seeds), good))
    errors = [found[seed, 0][2] for seed in seeds]
    lines += ["", "Error, um                       rms   largest"]
    for place, name in enumerate(("deviation of a bore", "half-sum", "half-difference")):
        values = np.concatenate([each[place] for each in errors])
        lines.append("%-28s %6.2f %9.2f" % (name, rms(values), largest(values)))
    gains = [gain for each in errors for gain in each[3]]
    large = [abs(error) for error, _, drift in gains if drift > 50]
    inside = sum(abs(error) <= room for error, room, _ in gains)
    lines += ["", "Gain: within 2 u on %d %% of %d axes" % (100 * inside // len(gains), len(gains))]
    if large:
        lines.append("Gain, drifts above 50 um: largest error %.3f" % max(large))
    return lines

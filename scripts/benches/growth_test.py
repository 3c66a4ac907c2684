# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs growth tests on drawn machines: are drift, gain and faults of the compensation found?

Each machine of configs/growth/bench.hal is tested once with each fault of its compensation. The log goes through plumb growth
report, and its results are compared with the truth of the machine.
"""

import collections
import csv
import os
import tempfile

import numpy as np

from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.figures import largest, rms
from support.growth_tests import results_of, run_test
from support.simulations import simulate_all

FAULTS = ("none", "absent", "wrong sign", "0.8", "1.3", "swapped axes", "frozen sensor", "sensor offset", "swapped sensors")
NAMED = (0, 2, 3, 4, 5, 6, 7, 8, 9)  # CompensationFault, by the fault of the machine
GOOD = 0


def main():
    parser = new_parser("growth_test", __doc__)
    parser.add_argument("--seeds", type=whole(1, 10000), default=20, metavar="N", help="machines (default: 20)")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        tasks = [(seed, fault) for fault in range(len(FAULTS)) for seed in range(1, options.seeds + 1)]
        found = simulate_all(simulate, tasks, len(tasks), place_of(options))
        print("\n".join(figures(options.seeds, dict(zip(tasks, found)))))


def simulate(seed, fault, progress):
    """(named fault, errors) of one test."""
    with tempfile.TemporaryDirectory() as folder:
        log = run_test(folder, seed, {"artifact.compensation-fault": fault}, truth=fault == 0)
        results = results_of(log, folder)
        errors = errors_of(results, log, os.path.join(folder, "truth.csv")) if fault == 0 else None
    progress(1)
    return results["compensation"]["fault"], errors


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
        at = [names.index(name) for name in ["growth-test.elapsed"] + ["artifact.truth-%s-deviation" % axis for axis in "xyz"]]
        probed, number = names.index("growth-test.at-bore"), names.index("growth-test.visit")
        for line in csv.reader(file):
            if float(line[probed]):
                rows[int(float(line[number]))].append([float(line[index]) for index in at])
    return {visit: np.mean(values, axis=0) for visit, values in rows.items()}


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
        compensations, drifts = [], []
        for series in results["series"]:
            if not series["compensated"]:
                continue
            start = truth[visits[(series["bore"], series["turned"], True, series["points"][0]["pass"], 0)]]
            for point in series["points"]:
                here = truth[visits[(series["bore"], series["turned"], True, point["pass"], 0)]]
                drifts.append((point["pass"], here[1 + axis] - start[1 + axis]))
                compensations.append((point["pass"], point["compensation_mm"][axis] - series["points"][0]["compensation_mm"][axis]))
        by_pass = {number: [np.mean([v for n, v in values if n == number]) for values in (compensations, drifts)] for number, _ in drifts}
        c, d = np.array(list(by_pass.values())).T
        gains.append((gain["value"] - c @ d / (d @ d), 2 * gain["uncertainty"], 1e3 * results["axes"][name]["off"]["largest_mm"]))
    return (
        1e3 * np.array(deviations).ravel(),
        1e3 * np.array([(errors[False] + errors[True]) / 2 for errors in pairs]).ravel(),
        1e3 * np.array([(errors[False] - errors[True]) / 2 for errors in pairs]).ravel(),
        gains,
    )


def figures(seeds, found):
    lines = ["%d drawn machines" % seeds, "", "Fault of the compensation   named rightly   called good"]
    for fault, name in enumerate(FAULTS):
        named = [found[seed, fault][0] for seed in range(1, seeds + 1)]
        good = "" if fault == 0 else "%13d" % named.count(GOOD)
        lines.append("%-25s %9d %%%s" % (name, 100 * named.count(NAMED[fault]) // seeds, good))
    errors = [found[seed, 0][1] for seed in range(1, seeds + 1)]
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

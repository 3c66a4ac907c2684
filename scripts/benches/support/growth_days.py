# SPDX-License-Identifier: GPL-2.0-or-later
"""Measured days of one machine: a law learned on one, used by axis_growth on another, beside least squares on one temperature."""

import csv
import os
import re

import numpy as np

from support.figures import rms
from support.growth_tests import law_of
from support.recordings import read_columns, write_rows

PERIOD = 1  # s, of the thread
SETTLE = 600  # s at the first row of a day, before the work zero is set
UNITS = {"_s": 1, "_min": 60, "_h": 3600}


class Day:
    """The columns of a CSV file, named as plumb growth identify wants them; a missing value is the last one."""

    def __init__(self, path):
        self.path, self.name = path, os.path.splitext(os.path.basename(path))[0]
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
        names = [name.strip() for name in rows[0]]
        columns = {name: filled([number(row[index]) for row in rows[1:]]) for index, name in enumerate(names)}
        lower = {name: name.lower() for name in names}
        time = next(name for name in names if lower[name].startswith("time") or lower[name] == "t")
        unit = next((seconds for end, seconds in UNITS.items() if lower[time].endswith(end)), 60)
        self.time = (columns[time] - columns[time][0]) * unit
        speed = next((name for name in names if lower[name] in ("s", "rpm", "speed") or lower[name].endswith("_rpm")), None)
        self.speed = columns[speed] if speed else 0 * self.time
        self.temperatures = {name: columns[name] for name in names if re.fullmatch(r"t\d+|.+_degc", lower[name])}
        self.growth = {axis: columns[name] for axis in "xyz" for name in names if lower[name] in (axis, axis + "_um")}  # um


def number(text):
    try:
        return float(text)
    except ValueError:
        return np.nan


def filled(values):
    """Without gaps: the last value holds, and before the first one that one."""
    values = np.array(values, dtype=float)
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return 0 * values
    return values[known[np.clip(np.searchsorted(known, np.arange(len(values)), side="right") - 1, 0, None)]]


def one_temperature(learnt, used, axis):
    """Growth in um on another day by a line over the temperature that explains the first day best."""
    growth, best = learnt.growth[axis], None
    for name, values in learnt.temperatures.items():
        if name not in used.temperatures or np.ptp(values) == 0:
            continue
        line = np.polyfit(values, growth, 1)
        left = np.sum((growth - np.polyval(line, values)) ** 2)
        if best is None or left < best[0]:
            best = left, name, line[0]
    return best[2] * (used.temperatures[best[1]] - used.temperatures[best[1]][0]) if best else 0 * used.time


def use(law, day):
    """Time, and by axis offset and its sigma in um since the zero, and when axis_growth was in doubt."""
    import plumb
    from plumb_folder import TemporaryFolder

    pins, values = ["axis-growth.spindle-speed"], [day.speed]
    for index, name in enumerate(law["sensors"]):
        if name:
            pins.append("axis-growth.temperature-%d" % index)
            values.append(day.temperatures[name])
    with TemporaryFolder() as folder, plumb.Host() as host:
        replay, recording = os.path.join(folder, "day.csv"), os.path.join(folder, "offsets.csv")
        write_rows(replay, ["time", *pins], np.column_stack([day.time, *values]))
        host.command("loadrt threads name1=servo-thread period1=%d" % (PERIOD * 10**9))
        host.command("loadrt axis_growth names=axis-growth interlock=no sensors=4")
        host.command("addf axis-growth.update servo-thread")
        host.set("axis-growth.all-homed", True)
        host.set("axis-growth.enable", True)
        for pin, column in zip(pins, values):
            host.set(pin, column[0] if "temperature" in pin else 0)
        for line in law["lines"].split("\n"):
            if line and not line.startswith("#"):
                host.command(line)
        host.command("start")
        host.run(SETTLE)
        host.set("axis-growth.zero-set", True)
        host.run(1)
        names = ["axis-growth.doubt", "axis-growth.authority"]
        names += ["axis-growth.%s-%s" % (axis, pin) for axis in day.growth for pin in ("offset", "growth-sigma")]
        host.record(recording, names, 60)
        host.run(host.replay(replay))
        column = read_columns(recording)
    time = column["time"] - column["time"][0]
    offsets = {axis: 1e3 * (column["axis-growth.%s-offset" % axis] - column["axis-growth.%s-offset" % axis][0]) for axis in day.growth}
    sigmas = {axis: 1e3 * column["axis-growth.%s-growth-sigma" % axis] for axis in day.growth}
    return time, offsets, sigmas, column["axis-growth.doubt"] > 0.5


def pair(learnt_path, used_path):
    """By axis: the rms of growth since the zero, and what axis_growth and one temperature leave of it, in um; and its doubts."""
    learnt, used = Day(learnt_path), Day(used_path)
    law = law_of(learnt_path)
    time, offsets, sigmas, doubt = use(law, used)
    found = {}
    for axis, growth in used.growth.items():
        if axis not in learnt.growth:
            continue
        none = np.interp(time, used.time, growth) - growth[0]
        left = none - offsets[axis]
        single = none - np.interp(time, used.time, one_temperature(learnt, used, axis))
        harmed = np.abs(left) > np.abs(none) + 1
        found[axis] = {
            "none": rms(none),
            "left": rms(left),
            "single": rms(single),
            "doubt": float(np.mean(doubt)),
            "announced": bool(np.mean(doubt[harmed]) >= 0.5) if harmed.any() else False,
            "covered": float(np.mean(np.abs(left) <= 2 * sigmas[axis])),
            "sigma": float(np.median(sigmas[axis])),
        }
    return found


def figures(paths, pairs):
    """`pairs`: what pair() found, by (learnt, used) as indices of `paths`."""
    names = [os.path.splitext(os.path.basename(path))[0] for path in paths]
    width = max(map(len, names)) + 2
    head = "%-*s%-*s%5s%12s%12s%12s%12s%10s%10s" % (width, "learned on", width, "used on", "axis", "none, um", "one T, um", "left, um", "one T, %", "left, %", "doubt, %")
    lines, rows = [head + "%12s%12s" % ("<= 2 sigma", "sigma, um")], []
    for (learnt, used), found in pairs.items():
        for axis, its in found.items():
            removed = [100 * (1 - its[way] / its["none"]) for way in ("single", "left")]
            rows.append((*removed, its))
            lines.append(
                "%-*s%-*s%5s%12.1f%12.1f%12.1f%12.0f%10.0f%10.0f%11.0f%%%12.1f%s"
                % (width, names[learnt], width, names[used], axis.upper(), its["none"], its["single"], its["left"], *removed, 100 * its["doubt"], 100 * its["covered"], its["sigma"], "" if its["left"] <= its["none"] else "  worse")
            )
    if not rows:
        return lines + ["no axis was measured on two days"]
    single, left = ([row[way] for row in rows] for way in (0, 1))
    worse = [row[2] for row in rows if row[2]["left"] > row[2]["none"]]
    lines += [
        "",
        "removed, median: %.0f %% by axis_growth, %.0f %% by a line over one temperature; mean %.0f and %.0f %%; least %.0f and %.0f %%"
        % (np.median(left), np.median(single), np.mean(left), np.mean(single), min(left), min(single)),
        "worse than without: %d of %d by axis_growth, of which %d unannounced; %d by one temperature"
        % (len(worse), len(rows), sum(not its["announced"] for its in worse), sum(way < 0 for way in single)),
        "rms of all pairs: none %.1f um, one temperature %.1f um, axis_growth %.1f um" % tuple(rms([row[2][way] for row in rows]) for way in ("none", "single", "left")),
        "within 2 sigma: %.0f %% of the time, mean of the pairs; sigma %.1f um, median of the pairs, beside %.1f um that were left, median"
        % (100 * np.mean([row[2]["covered"] for row in rows]), np.median([row[2]["sigma"] for row in rows]), np.median([row[2]["left"] for row in rows])),
        "in doubt for more than a tenth of the time: %d of %d" % (sum(row[2]["doubt"] > 0.1 for row in rows), len(rows)),
    ]
    return lines

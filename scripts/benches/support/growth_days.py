# SPDX-License-Identifier: GPL-2.0-or-later
"""Measured days of one machine: a law learned on one, used by axis_growth on another, beside least squares on one temperature."""

import json
import os
import random
import subprocess

import numpy as np

from support.figures import rms
from support.growth_tests import law_of
from support.recordings import read_columns, write_rows
from support.simulations import BUILD
from support.touches import SIGMA, touch

PERIOD = 1  # s, of the thread
SETTLE = 600  # s at the first row of a day, before the work zero is set
TOUCHES = 7200  # s from two touches of the reference to the next two
ZERO = 1.5 * TOUCHES  # s, of another work zero, between touches
INSTANCES = ("axis-growth", "touched", "zeroed")  # touches correct the second and the third; the third gets the other work zero, too


class Day:
    """A table of gauges, as plumb growth reads it; a missing value is the last one."""

    def __init__(self, path, *heads):
        self.path, self.name = path, os.path.splitext(os.path.basename(path))[0]
        read = table_of(path, *heads)
        series, self.taken = read["series"], read["taken"]
        self.time = np.unique(np.concatenate([its["time_s"] for its in all_series(series)]))
        begin, self.time = self.time[0], self.time - self.time[0]

        def at_rows(its):
            values = np.full(len(self.time), np.nan)
            values[np.searchsorted(self.time, np.array(its["time_s"]) - begin)] = its["value"]
            return filled(values)

        self.speed = at_rows(series["speed_rpm"])
        self.temperatures = {name: at_rows(its) for name, its in series.get("temperature_degc", {}).items()}
        self.growth = {axis.lower(): 1e3 * at_rows(its) for axis, its in series["growth_mm"].items()}  # um


def table_of(path, *heads):
    """What plumb growth reads in a table of gauges. A refusal is an OSError with its sentence."""
    command = [os.path.join(BUILD, "bin", "plumb-growth"), "report", path, "--json"]
    done = subprocess.run([*command, *(word for head in heads for word in ("--head", head))], capture_output=True, text=True)
    if done.returncode:
        raise OSError(done.stderr.strip())
    return json.loads(done.stdout)


def all_series(series):
    return [series["speed_rpm"], *series.get("temperature_degc", {}).values(), *series["growth_mm"].values()]


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
    """Time, and by instance and axis offset and its sigma in um since the zero, and when axis_growth was in doubt."""
    import plumb
    from plumb_folder import TemporaryFolder

    pins, values = ["spindle-speed"], [day.speed]
    for index, name in enumerate(law["sensors"]):
        if name and name not in day.temperatures:
            raise OSError("%s: there is no sensor '%s', which the law of the other day reads" % (day.path, name))
        if name:
            pins.append("temperature-%d" % index)
            values.append(day.temperatures[name])
    draw = random.Random(day.name)
    with TemporaryFolder() as folder, plumb.Host() as host:
        replay, recording = os.path.join(folder, "day.csv"), os.path.join(folder, "offsets.csv")
        names = ["%s.%s" % (instance, pin) for instance in INSTANCES for pin in pins]
        write_rows(replay, ["time", *names], np.column_stack([day.time, *values * len(INSTANCES)]))
        host.command("loadrt threads name1=servo-thread period1=%d" % (PERIOD * 10**9))
        host.command("loadrt axis_growth names=%s interlock=no sensors=4" % ",".join(INSTANCES))
        for instance in INSTANCES:
            host.command("addf %s.update servo-thread" % instance)
            host.set(instance + ".all-homed", True)
            host.set(instance + ".enable", True)
            for pin, column in zip(pins, values):
                host.set("%s.%s" % (instance, pin), column[0] if "temperature" in pin else 0)
            for line in law["lines"].split("\n"):
                if line and not line.startswith("#"):
                    host.command(line.replace("axis-growth.", instance + "."))
        host.command("start")
        host.run(SETTLE)
        for instance in INSTANCES[1:]:
            touch(host, instance, {axis: growth[0] for axis, growth in day.growth.items()}, draw)
        for instance in INSTANCES:
            host.set(instance + ".zero-set", True)
        host.run(1)
        host.set("zeroed.zero-set", False)
        names = ["axis-growth.doubt"]
        names += ["%s.%s-%s" % (instance, axis, pin) for instance in INSTANCES for axis in day.growth for pin in ("offset", "growth-sigma")]
        host.record(recording, names, 60)
        left, now = host.replay(replay), 0
        while left > TOUCHES:
            host.run(TOUCHES / 2)
            host.set("zeroed.zero-set", now + TOUCHES / 2 >= ZERO)
            host.run(TOUCHES / 2)
            now += TOUCHES
            for _ in range(2):
                for instance in INSTANCES[1:]:
                    touch(host, instance, {axis: np.interp(now, day.time, growth) for axis, growth in day.growth.items()}, draw)
            spent = 8 * len(day.growth) * PERIOD
            now, left = now + spent, left - TOUCHES - spent
        host.run(left)
        column = read_columns(recording)
    time = column["time"] - column["time"][0]

    def of(instance):
        offsets = {axis: 1e3 * (column["%s.%s-offset" % (instance, axis)] - column["%s.%s-offset" % (instance, axis)][0]) for axis in day.growth}
        return offsets, {axis: 1e3 * column["%s.%s-growth-sigma" % (instance, axis)] for axis in day.growth}

    return time, {instance: of(instance) for instance in INSTANCES}, column["axis-growth.doubt"] > 0.5


def held(time, growth):
    """The growth at the last touch, without a law and without the noise of the touch."""
    return growth[np.searchsorted(time, time // TOUCHES * TOUCHES)]


def pair(learnt_path, used_path):
    """By axis: the rms of growth since the zero, and what axis_growth and one temperature leave of it, in um; and its doubts."""
    learnt, used = Day(learnt_path), Day(used_path)
    law = law_of(learnt_path)
    time, by_instance, doubt = use(law, used)
    offsets, sigmas = by_instance["axis-growth"]
    found = {}
    for axis, growth in used.growth.items():
        if axis not in learnt.growth:
            continue
        none = np.interp(time, used.time, growth) - growth[0]
        left = none - offsets[axis]
        single = none - np.interp(time, used.time, one_temperature(learnt, used, axis))
        touched, zeroed = (none - by_instance[instance][0][axis] for instance in INSTANCES[1:])
        warm = time > min(ZERO + 60, time[-1] / 2)
        harmed = np.abs(left) > np.abs(none) + 1
        found[axis] = {
            "none": rms(none),
            "left": rms(left),
            "single": rms(single),
            "touched": rms(touched),
            "touched covered": float(np.mean(np.abs(touched) <= 2 * by_instance["touched"][1][axis])),
            "touched sigma": float(np.median(by_instance["touched"][1][axis])),
            "since zero": {name: rms((its - its[warm][0])[warm]) for name, its in (("law", left), ("zeroed", zeroed), ("touched", touched))},
            "held": rms(none - held(time, none)),
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
        "touched twice every %g h, %g um a touch: %.1f um; removed, median: %.0f %%; worse than without: %d, than without touches by 1 um: %d; the last touch held: %.1f um"
        % (
            TOUCHES / 3600,
            SIGMA,
            rms([row[2]["touched"] for row in rows]),
            np.median([100 * (1 - row[2]["touched"] / row[2]["none"]) for row in rows]),
            sum(row[2]["touched"] > row[2]["none"] for row in rows),
            sum(row[2]["touched"] > row[2]["left"] + 1 for row in rows),
            rms([row[2]["held"] for row in rows]),
        ),
        "of it since a work zero after %g h: %.1f um; counted from the first reference: %.1f um; without touches: %.1f um"
        % (ZERO / 3600, *(rms([row[2]["since zero"][name] for row in rows]) for name in ("zeroed", "touched", "law"))),
        "within 2 sigma: %.0f %% of the time, mean of the pairs; sigma %.1f um, median of the pairs, beside %.1f um that were left, median"
        % (100 * np.mean([row[2]["covered"] for row in rows]), np.median([row[2]["sigma"] for row in rows]), np.median([row[2]["left"] for row in rows])),
        "the same with touches: %.0f %%, sigma %.1f um" % (100 * np.mean([row[2]["touched covered"] for row in rows]), np.median([row[2]["touched sigma"] for row in rows])),
        "in doubt for more than a tenth of the time: %d of %d" % (sum(row[2]["doubt"] > 0.1 for row in rows), len(rows)),
    ]
    return lines

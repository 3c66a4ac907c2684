#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""growth_gauges.py PROGRAM DISTANCE [FOLDER] < TABLE: measures a record of displacement sensors at a mandrel, as ISO 230-3 has it.

plumb growth report gives it the table as it was read, and PROGRAM, itself, which fits the curves. FOLDER gets results.json and
report.html; without it the results are printed. DISTANCE is that between the two sensors of X and of Y in mm, 0 without a tilt.
"""

import json
import math
import os
import subprocess
import sys

import numpy as np

HOUR, QUARTER = 3600, 900
TURNING = 1  # rpm
LONGEST_INTERVAL = 300  # s, between two values
WANTED_TIME = 4 * HOUR  # of the warm-up
SETTLED = 0.15  # change in the last hour, of that in the first
FITTED = 150  # values of a curve
DRAWN = 400  # values of a chart
COLUMNS = [("1 h", "at_1_hour"), ("4 h", "at_4_hours"), ("warm", "warm"), ("range", "range"), ("rate per h", "rate_per_h"), ("U", "expanded")]
OF_ENVIRONMENT = ("range", "rate_per_h", "expanded")
OF_COOLING = [("after rest", "left"), ("its rate", "cooling_rate_per_h")]


class Quantity:
    """A displacement along an axis or a tilt about one, from its first value on; times in s since the first row."""

    def __init__(self, name, unit, time, value):
        self.name, self.unit, self.time, self.value, self.curve = name, unit, np.array(time), np.array(value) - value[0], None

    def at(self, time):
        return math.nan if time > self.time[-1] else float(np.interp(time, self.time, self.value))

    def range(self, begin, end):
        inside = self.value[(self.time >= begin) & (self.time <= end)]
        return float(np.ptp(inside)) if len(inside) else 0.0

    def rate(self, begin, end):
        """The largest change in a quarter of an hour, per h."""
        ends = self.time[(self.time - QUARTER >= begin) & (self.time <= end)]
        rates = (np.interp(ends, self.time, self.value) - np.interp(ends - QUARTER, self.time, self.value)) * HOUR / QUARTER
        return float(rates[np.argmax(np.abs(rates))]) if len(rates) else 0.0

    def thinned(self, begin, end):
        """Its values for a curve."""
        found, after = {"time_s": [], "value": []}, begin
        for time, value in zip(self.time.tolist(), self.value.tolist()):
            if after <= time <= end:
                found["time_s"].append(time)
                found["value"].append(value)
                after = time + (end - begin) / FITTED
        return found


def quantities_of(series, begin, distance):
    found = []
    for axis, its in series["growth_mm"].items():
        found.append(Quantity(axis, "um", np.array(its["time_s"]) - begin, 1e3 * np.array(its["value"])))
    for axis, name, sign in (("Y", "tilt about X", -1), ("X", "tilt about Y", 1)):  # about Y, X rises with Z; about X, Y falls with Z
        lower = dict(zip(*series["growth_mm"].get(axis, {}).values()))
        upper = [(time, value - lower[time]) for time, value in zip(*series["upper_mm"].get(axis, {}).values()) if time in lower] if distance else []
        if upper:
            time, apart = np.array(upper).T
            found.append(Quantity(name, "um/m", time - begin, sign * apart / distance * 1e6))
    return found


def spindle_of(series, length, begin):
    """Whether it stood, whether it had one duty, and the times of work and of rest."""
    time, speed = (np.array(its) for its in series["speed_rpm"].values())
    turns = np.flatnonzero(np.abs(speed) >= TURNING)
    if not len(turns):
        return True, True, 0.0, 0.0
    sizes = np.abs(speed[turns[0] : turns[-1] + 1])
    warmed = float(time[turns[-1]] - begin)
    return False, bool(sizes.min() >= TURNING and sizes.min() >= 0.8 * sizes.max()), warmed, length - warmed


def missing_of(test, quantities):
    """For a test after ISO 230-3."""
    names = [its.name for its in quantities]
    missing = ["no sensor of " + axis for axis in "XYZ" if axis not in names]
    if "tilt about X" not in names or "tilt about Y" not in names:
        missing.append("no tilt: it needs the columns X1, X2, Y1, Y2 and --distance")
    if "temperature_ranges_k" not in test:
        missing.append("no temperature")
    if test["interval_s"] > LONGEST_INTERVAL:
        missing.append("values further apart than 5 min")
    if test["environment"]:
        return missing
    warmed = test["warmed_s"]
    stands = warmed >= 2 * HOUR and all(its.range(warmed - HOUR, warmed) <= SETTLED * its.range(0, HOUR) + (expanded(its) or 0) for its in quantities)
    if warmed < WANTED_TIME and not stands:
        missing.append("a warm-up of less than 4 h whose last hour changes by more than 15 % of the first")
    if test["cooled_s"] < HOUR:
        missing.append("no cool-down of an hour")
    return missing


def expanded(its):
    """U of a change, by the scatter about a smooth curve."""
    return 2 * math.sqrt(2) * its.curve["noise"] if its.curve else None


def prediction(environment, steady_duty, its, warm):
    if environment or not its.curve:
        return ""
    if not steady_duty:
        return "not determined: the spindle speed changed"
    steady, low, high = (its.curve[name] for name in ("steady", "low", "high"))
    if its.curve["shorter"]:
        bound = "at least %.1f" % max(low, warm) if steady > warm else "at most %.1f" % min(high, warm)
        return bound + ", as the record is shorter than two of the slowest time constant"
    return ("%.1f, " % steady if its.curve["determined"] else "not determined, ") + "between %.1f and %.1f" % (low, high)


def measured(table, program, distance):
    times, series = np.array(table.pop("time_s")), table["series"]
    begin, length = times[0], float(times[-1] - times[0])
    quantities = quantities_of(series, begin, distance)
    environment, steady_duty, warmed, cooled = spindle_of(series, length, begin)
    end = length if environment else warmed
    fitted = json.dumps([its.thinned(0, end) for its in quantities])
    curves = json.loads(subprocess.run([program, "curve"], input=fitted, capture_output=True, text=True, check=True).stdout)
    for its, curve in zip(quantities, curves):
        its.curve = curve
    test = {**table, "environment": environment, "length_s": length, "warmed_s": warmed, "cooled_s": cooled, "interval_s": float(np.diff(times).max())}
    test["times"] = "%.1f h, the spindle stood" % (length / HOUR) if environment else "%.1f h of work, %.1f h of rest" % (warmed / HOUR, cooled / HOUR)
    if series["temperature_degc"]:
        test["temperature_ranges_k"] = {name: max(its["value"]) - min(its["value"]) for name, its in series["temperature_degc"].items()}
    test["missing"] = missing_of(test, quantities)
    clause = "Environmental temperature variation error" if environment else "Thermal distortion caused by rotating spindle"
    test["clause"] = clause + ", after ISO 230-3" + (". Not a whole test after it: " + "; ".join(test["missing"]) if test["missing"] else "") + "."
    columns = [column for column in COLUMNS if not environment or column[1] in OF_ENVIRONMENT] + (OF_COOLING if cooled > 0 else [])
    test["columns"] = [{"title": title, "key": key} for title, key in columns]
    test["quantities"] = {}
    for its in quantities:
        values = {
            "at_1_hour": its.at(HOUR) if end >= HOUR else math.nan,
            "at_4_hours": its.at(4 * HOUR) if end >= 4 * HOUR else math.nan,
            "warm": its.at(min(end, its.time[-1])),
            "range": its.range(0, end),
            "rate_per_h": its.rate(0, end),
            "expanded": expanded(its),
            "left": float(its.value[-1]),
            "cooling_rate_per_h": its.rate(warmed, length),
        }
        found = test["quantities"][its.name] = {"unit": its.unit, **{name: None if value is None or math.isnan(value) else value for name, value in values.items()}}
        found["prediction"] = prediction(environment, steady_duty, its, values["warm"])
        step = len(its.time) // DRAWN + 1
        found["time_s"], found["value"] = its.time[::step].tolist(), its.value[::step].tolist()
        if its.curve and not environment:
            found["steady"] = {"determined": its.curve["determined"] and steady_duty, "value": its.curve["steady"], "low": its.curve["low"], "high": its.curve["high"]}
            found["steady"]["shorter_than_two_time_constants"] = its.curve["shorter"]
    return test


def text_of(test):
    lines = [test["file"], *("  " + test[name] for name in ("taken", "clause", "times")), ""]
    lines.append("%-16s" % "" + "".join("%11s" % column["title"] for column in test["columns"]))
    for name, its in test["quantities"].items():
        cells = ("-" if its[column["key"]] is None else "%.1f" % its[column["key"]] for column in test["columns"])
        lines.append("%-16s" % ("  " + name) + "".join("%11s" % cell for cell in cells) + "  " + its["unit"])
    if not test["environment"]:
        lines += ["  Steady state of %s, %s: %s" % (name, its["unit"], its["prediction"]) for name, its in test["quantities"].items()]
    return "\n".join(lines + ["  %s changed by %.1f K" % each for each in test.get("temperature_ranges_k", {}).items()])


def main(program, distance, folder=None):
    table = json.load(sys.stdin)
    version = table.pop("version_of_plumb")
    test = measured(table, program, float(distance))
    if folder is None:
        print(json.dumps(test))
        return
    import growth_page  # takes longer than the measuring

    os.makedirs(folder, exist_ok=True)
    growth_page.replace(os.path.join(folder, "results.json"), json.dumps({"gauges": test, "version_of_plumb": version}).encode())
    print(text_of(test))
    growth_page.main(folder)
    print("Report: " + os.path.join(folder, "report.html"))


if __name__ == "__main__":
    main(*sys.argv[1:])

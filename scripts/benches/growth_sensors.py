# SPDX-License-Identifier: GPL-2.0-or-later
"""Spoils a temperature sensor of drawn machines: does axis_growth announce it before an axis moves by 10 um?

A growth test of each machine gives its law. On another day, with other speeds, one axis_growth has the true temperatures, and one
more for each fault has a sensor that is wrong. The effect of a fault is the largest difference of their offsets. A fault is found if
the doubt names a sensor before the effect exceeds 10 um, and harmless if the effect never does. The clean axis_growth counts false
doubts. The rival stands beside it: a temperature is wrong if its rise leaves that of the growth test by a fifth of its span.
"""

import os
import re

import numpy as np

from support import growth_machines
from support.command import add_place, duration_of, errors_reported, new_parser, place_of, whole
from support.growth_tests import PLAN, law_of, run_test
from support.recordings import read_columns, write_rows
from support.simulations import simulate_all

TARGETS = "simulation_growth axis_growth plumb-growth"
STEP = 10  # s, between two values of the spoilt sensors
BEGIN = 1800  # s, of the faults that begin in work
HARM = 10  # um
NAMES_A_SENSOR = range(5, 9)  # of doubt-code
SPINDLE, BED, AIR = range(3)


class Faults:
    """By name: the temperatures in degC that a spoilt sensor makes of the true ones, a step at a time."""

    def __init__(self):
        self.frozen, self.cooled = {}, 0.0

    def _frozen(self, which, true, time):
        if time >= BEGIN:
            return {which: self.frozen.setdefault(which, true[which])}
        return {}

    def _coolant(self, true, time):
        self.cooled += ((5 if time >= BEGIN else 0) - self.cooled) * STEP / 120
        return {BED: true[BED] - self.cooled}

    def spoilt(self, true, time):
        on = time >= BEGIN
        changed = {
            "spindle +4 K": {SPINDLE: true[SPINDLE] + 4 * on},
            "bed +20 K": {BED: true[BED] + 20 * on},
            "air +80 K": {AIR: true[AIR] + 80 * on},
            "spindle and bed swapped": {SPINDLE: true[BED], BED: true[SPINDLE]},
            "bed and air swapped": {BED: true[AIR], AIR: true[BED]},
            "spindle frozen": self._frozen(SPINDLE, true, time),
            "bed frozen": self._frozen(BED, true, time),
            "spindle drifts 3 K/h": {SPINDLE: true[SPINDLE] + 3 * max(0, time - BEGIN) / 3600},
            "coolant on the bed's, -5 K": self._coolant(true, time),
            "spindle's loose, half": {SPINDLE: true[SPINDLE] - on * (true[SPINDLE] - true[AIR]) / 2},
        }
        return {name: [values.get(index, true[index]) for index in range(3)] for name, values in changed.items()}


NAMES = tuple(Faults().spoilt([20, 20, 20], 0))


def simulate(structure, seed, duration, progress):
    """By fault: the effect in um when it was named, or at most, and whether it was named; the same of the rival; false doubts."""
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        law = law_of(run_test(folder, seed, growth_machines.STRUCTURES[structure], plan=PLAN))
        day = true_day(folder, structure, seed, duration)
        if not progress(duration):
            return None
        effects, named = work(folder, law, day)
    pins = {name: float(value) for name, value in re.findall(r"setp axis-growth\.(\S+) +(\S+)", law["lines"])}
    spans = np.array([[beyond(pins, moment[name]) for name in ("clean", *NAMES)] for moment in day["temperatures"]])
    found = {}
    for way, told in (("named", named), ("span", spans)):
        found[way] = [before(effects[:, index], told[:, index + 1]) for index in range(len(NAMES))]
        found[way + " falsely"] = float(np.mean(told[:, 0]))
    return found


def true_day(folder, structure, seed, duration):
    """Time, speed, and for each moment the temperatures by fault and of the clean machine."""
    import plumb

    path, settings = os.path.join(folder, "true.csv"), growth_machines.STRUCTURES[structure]
    with plumb.Host() as host:
        host.command("loadrt threads name1=servo-thread period1=1000000000")
        host.set("artifact.air-day", growth_machines.load_machine(host, seed, settings, ["unused"]).uniform(0.5, 2))
        host.command("addf artifact.update servo-thread")
        host.command("start")
        host.run(growth_machines.SETTLE)
        host.record(path, ["artifact.spindle-speed", *("artifact.temperature-%d" % sensor for sensor in range(3))], STEP)
        growth_machines.run_day(host, "artifact.spindle-speed-cmd", seed, duration, lambda _: True)
    column, spoilt = read_columns(path), Faults()
    time = column["time"] - column["time"][0]
    true = np.column_stack([column["artifact.temperature-%d" % sensor] for sensor in range(3)]).tolist()
    moments = [{"clean": its, **spoilt.spoilt(its, moment)} for its, moment in zip(true, time)]
    return {"time": time, "speed": column["artifact.spindle-speed"], "temperatures": moments}


def work(folder, law, day):
    """The effect of each fault in um, a row a moment, and whether each axis_growth, first the clean one, names a sensor."""
    import plumb

    instances = ["clean"] + ["spoilt%d" % index for index in range(len(NAMES))]
    replay, recording = os.path.join(folder, "spoilt.csv"), os.path.join(folder, "offsets.csv")
    pins = [pin for name in instances for pin in (name + ".spindle-speed", *("%s.temperature-%d" % (name, sensor) for sensor in range(3)))]
    rows = [[time, *(value for name in ("clean", *NAMES) for value in (speed, *moment[name]))] for time, speed, moment in zip(day["time"], day["speed"], day["temperatures"])]
    write_rows(replay, ["time", *pins], np.array(rows))
    with plumb.Host() as host:
        host.command("loadrt threads name1=servo-thread period1=1000000000")
        host.command("loadrt axis_growth names=%s interlock=no sensors=%s" % (",".join(instances), ",".join(["4"] * len(instances))))
        for index, name in enumerate(instances):
            host.command("addf %s.update servo-thread" % name)
            for pin, value in (("all-homed", True), ("enable", True), ("y-position", -60), ("z-position", -140)):
                host.set("%s.%s" % (name, pin), value)
            for line in law["lines"].split("\n"):
                if line and not line.startswith("#"):
                    host.command(line.replace("axis-growth.", name + "."))
            for sensor in range(3):
                host.set("%s.temperature-%d" % (name, sensor), rows[0][2 + 4 * index + sensor])
        host.command("start")
        outputs = ["%s.%s" % (name, pin) for name in instances for pin in ("x-offset", "y-offset", "z-offset", "doubt-code")]
        host.record(recording, outputs, STEP)
        host.run(host.replay(replay))
        column = read_columns(recording)
    count = min(len(column["time"]), len(rows))
    offsets = np.array([[1e3 * column["%s.%s-offset" % (name, axis)][:count] for axis in "xyz"] for name in instances])
    effects = np.abs(offsets[1:] - offsets[0]).max(axis=1).T
    return effects, np.array([np.isin(column[name + ".doubt-code"][:count], NAMES_A_SENSOR) for name in instances]).T


def beyond(pins, temperatures):
    """Whether the rise of a temperature leaves that of the growth test by a fifth of its span."""
    for sensor, value in enumerate(temperatures):
        low, high = (pins.get("rise-%s-%d" % (end, sensor)) for end in ("low", "high"))
        if low is None:
            continue
        rise, room = value - pins["reference-%d" % sensor], 0.2 * (high - low)
        if not low - room <= rise <= high + room:
            return True
    return False


def before(effect, told):
    """(the largest effect until it was told, whether it was told)"""
    count = min(len(effect), len(told))
    effect, told = effect[:count], told[:count]
    if not told.any():
        return float(effect.max()), False
    return float(effect[: int(np.argmax(told)) + 1].max()), True


def figures(outcomes):
    lines = ["%-30s%24s%10s%12s%12s" % ("", "named before %d um, of" % HARM, "harmless", "effect, p95", "by span")]
    good, all_of, span_good = 0, 0, 0
    for index, name in enumerate(NAMES):
        its = [outcome["named"][index] for outcome in outcomes]
        rival = [outcome["span"][index] for outcome in outcomes]
        harmless = sum(not told and effect <= HARM for effect, told in its)
        named = sum(told and effect <= HARM for effect, told in its)
        by_span = sum(told and effect <= HARM for effect, told in rival)
        counted = len(its) - harmless
        good, all_of, span_good = good + named, all_of + counted, span_good + min(by_span, counted)
        lines.append("%-30s%15d%9d%10d%12.1f%12d" % (name, named, counted, harmless, np.percentile([effect for effect, _ in its], 95), by_span))
    lines += ["", "named before %d um: %.1f %% of the faults that are not harmless; by span alone %.1f %%" % (HARM, 100 * good / max(all_of, 1), 100 * span_good / max(all_of, 1))]
    lines.append("false doubt: %.1f %% of the clean time; by span alone %.1f %%" % tuple(100 * np.mean([outcome[way + " falsely"] for outcome in outcomes]) for way in ("named", "span")))
    return lines


def main():
    parser = new_parser("growth_sensors", __doc__)
    parser.add_argument("--seeds", type=whole(1, 10000), default=50, metavar="N", help="machines of each structure (default: 50)")
    parser.add_argument("--seed", type=whole(2, 2**31 - 1), default=1001, metavar="N", help="the first of them")
    parser.add_argument("--for", type=duration_of, default="2h", dest="duration", metavar="TIME", help="length of the day (default: 2h)")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        seeds = range(options.seed, options.seed + options.seeds)
        tasks = [(structure, seed, options.duration) for structure in range(len(growth_machines.STRUCTURES)) for seed in seeds]
        found = simulate_all(simulate, tasks, options.duration * len(tasks), place_of(options))
        print("%d machines of each structure\n" % options.seeds + "\n".join(figures(found)))

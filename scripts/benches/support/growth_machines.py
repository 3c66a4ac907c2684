# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawn machines of two structures: a growth test gives the law of each, which axis_growth uses on another day with another duty."""

import os
import random

import numpy as np

from support.figures import rms
from support.growth_tests import DEVIATIONS, FASTEST, PLAN, add_axis_growth, law_of, plan_of, run_test
from support.recordings import read_columns
from support.touches import SIGMA, touch

PERIOD = 1  # s
EVERY = 20  # s
SETTLE = 900  # s until the work zero is set
WORSE = 1  # um rms
AIR = 3  # K, of the air alone
HARMLESS = 5  # um
STRUCTURES = (
    {"artifact.structure": 0},  # the plant of configs/growth
    # A head against the spindle, a column that bends, a probe with lobes, and sensors of 1/16 K.
    {"artifact.structure": 1, "artifact.sensor-quantum": 0.0625, "artifact.probe-pre-travel": 0.015},
)


def draw_duty(seed, duration):
    """(rpm, s) until the end of the day: another duty than that of the growth test."""
    draw, speeds, left = random.Random(seed), [], duration
    while left > 0:
        time = min(left, draw.uniform(600, 3600))
        speeds.append((draw.choice((0, draw.uniform(2000, 8000), draw.uniform(2000, 8000))), time))
        left -= time
    return speeds


def load_machine(host, seed, settings, instances):
    """sim_artifact on another day than that of its growth test, and instances of axis_growth. Returns the draw of the day."""
    host.command("loadrt sim_artifact names=artifact")
    host.command("loadrt axis_growth names=%s interlock=no sensors=4" % ",".join(instances))
    draw = random.Random(-seed)
    for name, value in {"artifact.seed": seed, **settings, "artifact.air-start": draw.uniform(1, 86400)}.items():
        host.set(name, value)
    return draw


def run_day(host, pin, seed, duration, progress, after=lambda: None):
    """The speed of the spindle by its duty, until `progress` wants no more; `after` each part of it."""
    for speed, time in draw_duty(seed, duration):
        host.set(pin, speed)
        host.run(time)
        after()
        if not progress(time):
            return


def simulate(structure, seed, duration, hours, progress):
    """By axis: what is left without and with the law, the share within two sigma, whether it was announced, and the terms."""
    from plumb_folder import TemporaryFolder

    settings = STRUCTURES[structure]
    plan = [cycle["rpm"] / FASTEST for cycle in plan_of(hours)["cycles"]] if hours else PLAN
    with TemporaryFolder() as folder:
        law = law_of(run_test(folder, seed, settings, plan=plan))
        column = work(folder, seed, settings, law, duration, progress)
    doubt = column["axis-growth.doubt"] > 0.5
    found = []
    for axis in "xyz":
        growth, offset, sigma = (1e3 * column[name % axis] for name in ("artifact.truth-%s-deviation", "axis-growth.%s-offset", "axis-growth.%s-growth-sigma"))
        growth, offset = growth - growth[0], offset - offset[0]
        left = growth - offset
        touched = 1e3 * column["touched.%s-offset" % axis]
        harmed = np.abs(left) > np.abs(growth) + 1
        found.append(
            {
                "none": growth,
                "left": left,
                "touched": growth - (touched - touched[0]),
                "touched covered": float(np.mean(np.abs(growth - (touched - touched[0])) <= 2e3 * column["touched.%s-growth-sigma" % axis])),
                "sigmas": (float(np.median(sigma)), float(np.median(1e3 * column["touched.%s-growth-sigma" % axis]))),
                "covered": float(np.mean(np.abs(left) <= 2 * sigma)),
                "announced": bool(harmed.any() and np.mean(doubt[harmed]) >= 0.5),
                "doubt": float(np.mean(doubt)),
                "air": 1e3 * AIR * sum(abs(term["value_mm"]) for term in law["axes"][axis.upper()]["terms"] if term["name"] == "air"),
                "terms": {term["name"]: 1e3 * term["uncertainty_mm"] for term in law["axes"][axis.upper()]["terms"]},
            }
        )
    return found


def work(folder, seed, settings, law, duration, progress):
    import plumb

    path = os.path.join(folder, "day.csv")
    with plumb.Host() as host:
        host.command("loadrt threads name1=servo-thread period1=%d" % (PERIOD * 10**9))
        host.set("artifact.air-day", load_machine(host, seed, settings, ["axis-growth", "touched"]).uniform(0.5, 2))
        host.command("addf artifact.update servo-thread")
        add_axis_growth(host, law["lines"])
        add_axis_growth(host, law["lines"].replace("axis-growth.", "touched."), "touched")
        host.command("net speed artifact.spindle-speed => axis-growth.spindle-speed touched.spindle-speed")
        draw = random.Random(seed)

        def touches(count):
            for _ in range(count):
                touch(host, "touched", {axis: 1e3 * host.get("artifact.truth-%s-deviation" % axis) for axis in "xyz"}, draw)

        host.command("start")
        host.run(SETTLE)
        touches(1)
        for instance in ("axis-growth", "touched"):
            host.set(instance + ".zero-set", True)
        host.run(PERIOD)
        names = ["axis-growth.doubt"] + DEVIATIONS
        names += ["axis-growth.%s-%s" % (axis, pin) for axis in "xyz" for pin in ("offset", "growth-sigma")]
        names += ["touched.%s-%s" % (axis, pin) for axis in "xyz" for pin in ("offset", "growth-sigma")]
        host.record(path, names, EVERY)
        run_day(host, "artifact.spindle-speed-cmd", seed, duration, progress, lambda: touches(2))
        return read_columns(path)


def expectations(outcomes, hours):
    """The uncertainties of the terms in Z that the plan expects, beside those that the tests gave."""
    names = {"temperature of the spindle": "spindle", "temperature of the structure": "bed", "spindle speed": "speed"}
    lines = ["%-28s%10s%26s%18s" % ("in Z", "expected", "test: median, p10, p90", "machines with it")]
    machines = [machine[2] for found in outcomes.values() for machine in found]
    for term in plan_of(hours)["terms"]:
        if term["name"] in names:
            given = [its["terms"][names[term["name"]]] for its in machines if names[term["name"]] in its["terms"]]
        else:
            given = [rms(its["left"]) for its in machines]
        quantiles = "%10.2f%8.2f%8.2f" % tuple(np.percentile(given, (50, 10, 90))) if given else ""
        lines.append("%-28s%10.2f%26s%18d  %s" % (term["name"], term["after"], quantiles, len(given), term["unit"]))
    return lines + ["", "growth on another day: of the tests it is the rms that was left, which contains what the law cannot follow"]


def figures(outcomes):
    """`outcomes`: what simulate() found, by structure a list over machines."""
    lines = ["%-14s%6s%24s%24s%14s%10s%10s%12s" % ("structure", "axis", "without, um", "with axis_growth, um", "worse by 1", "unannou.", "doubt", "<= 2 sigma")]
    lines.append("%-14s%6s%24s%24s" % ("", "", "median   p90   max", "median   p90   max"))
    spaces = {"none": [], "left": [], "touched": []}
    for structure, found in outcomes.items():
        for axis in range(3):
            its = [machine[axis] for machine in found]
            sizes = {way: [rms(each[way]) for each in its] for way in ("none", "left")}
            worse = [each for each, none, left in zip(its, sizes["none"], sizes["left"]) if left > none + WORSE]
            cells = "".join("%10.1f%6.1f%6.1f  " % (np.median(values), np.percentile(values, 90), max(values)) for values in (sizes["none"], sizes["left"]))
            lines.append(
                "%-14d%6s%s%14d%10d%9.0f%%%11.1f%%"
                % (structure + 1, "XYZ"[axis], cells, len(worse), sum(not each["announced"] for each in worse), 100 * np.mean([each["doubt"] for each in its]), 100 * np.mean([each["covered"] for each in its]))
            )
        for way, values in spaces.items():
            values += [rms(np.linalg.norm([axis[way] for axis in machine], axis=0)) for machine in found]
    lines.append("")
    moved = [axis["air"] for found in outcomes.values() for machine in found for axis in machine]
    lines.append("%g K of the air alone move %d of %d axes by more than %g um, %.1f um at most" % (AIR, sum(by > HARMLESS for by in moved), len(moved), HARMLESS, max(moved)))
    lines.append("in space, rms over all machines: %.1f um without, %.1f um with axis_growth" % (rms(spaces["none"]), rms(spaces["left"])))
    axes = [(rms(axis["touched"]), rms(axis["left"]), rms(axis["none"])) for found in outcomes.values() for machine in found for axis in machine]
    worse = sum(touched > none + WORSE for touched, _, none in axes), sum(touched > left + WORSE for touched, left, _ in axes)
    lines.append(
        "touched twice at each change of duty, %g um a touch: %.1f um in space; worse by %g um than without: %d, than without touches: %d of %d axes"
        % (SIGMA, rms(spaces["touched"]), WORSE, *worse, len(axes))
    )
    all_axes = [axis for found in outcomes.values() for machine in found for axis in machine]
    lines.append(
        "within 2 sigma: %.1f %% without touches, %.1f %% with touches; median sigma %.1f and %.1f um"
        % (*(100 * np.mean([axis[name] for axis in all_axes]) for name in ("covered", "touched covered")), *np.median([axis["sigmas"] for axis in all_axes], axis=0))
    )
    return lines

# SPDX-License-Identifier: GPL-2.0-or-later
"""Growth tests on drawn machines: runs configs/growth/bench.hal, writes the log, and reads the results of plumb growth."""

import csv
import json
import os
import subprocess
import zlib

from support.simulations import BUILD, ROOT

PERIOD = 0.5  # s, of the bench
LONGEST = 14 * 3600  # s
SENSORS = ("spindle", "bed", "air", "artifact")
# The bores of the simulated artifact, from the centre of its table, and the faces towards the spindle at 0 deg, in mm.
BORES = ((0, -60, 60), (0, 60, 60), (-80, -60, 60), (80, 60, 60), (-80, 60, 110), (80, -60, 110), (-160, 0, 110), (160, 0, 110))
FIELDS = ("kind", "time", "pass", "visit", "bore", "item", "turned", "compensated", "cooled", "x", "y", "z", "x-offset", "y-offset", "z-offset")
EVENTS = ("begin", "pass-begin", "pass-end", "cycle-end", "stop", "resumed", "rejected", "fault", "end", "measured")
SIDES = {-3: "-Z", -2: "-Y", -1: "-X", 1: "+X", 2: "+Y", 3: "+Z"}
DEVIATIONS = ["artifact.truth-%s-deviation" % axis for axis in "xyz"]  # the growth
TRUTH = ["growth-test.visit", "growth-test.at-bore", "growth-test.elapsed"] + DEVIATIONS


# Parts of the highest speed, a cycle of work each: steps, a rest and a cool-down tell the terms of a law apart.
PLAN = (1, 1, 0, 0.5, 0.5, 1, 0.25, 0)
FASTEST = 8000  # rpm


def run_test(folder, seed, settings=None, sensors=SENSORS, truth=False, replay=None, plan=None, head=()):
    """The path of the log of one test; with `truth`, a recording truth.csv lies beside it.

    `plan`: the speeds of the cycles, as parts of the highest; else all are equal, and the test ends when the machine is warm.
    `head`: more lines for the head of the log.
    """
    import plumb

    with plumb.Host() as host:
        host.load(os.path.join(ROOT, "configs", "growth", "bench.hal"))
        host.set("artifact.seed", seed)
        for name, value in (settings or {}).items():
            host.set(name, value)
        host.command("start")
        if truth:
            recording = host.record(os.path.join(folder, "truth.csv"), TRUTH, 5)
        if replay:
            host.replay(replay)
        if plan:
            follow(host, plan)
        while not host.get("artifact.finished") and host.time < LONGEST:
            host.run(600)
        if truth:
            host.stop_recording(recording)
        records = read_records(host, folder)
    path = os.path.join(folder, "growth-%d.csv" % seed)
    with open(path, "w", encoding="ascii") as file:
        file.write(log_text(seed, records, sensors, head))
    return path


def follow(host, plan):
    """A cycle of work at each speed of the plan; the test ends with the pass after the last one."""
    # No warmth ends it before. A minimum time above the maximum time would be refused.
    host.set("growth-test.maximum-time", LONGEST)
    host.set("growth-test.minimum-time", LONGEST)
    for index, share in enumerate(plan):
        host.set("artifact.work-speed", share * FASTEST)
        while host.get("growth-test.cycle-index") <= index:
            if host.get("artifact.finished") or host.time > LONGEST:
                raise RuntimeError("the growth test ended in cycle %d of its plan" % (index + 1))
            host.run(60)
            if index == len(plan) - 1:
                for pin in ("minimum-time", "maximum-time"):
                    host.set("growth-test." + pin, max(host.time - 60, 1))


def read_records(host, folder, period=PERIOD):
    """All records of the component, a period each."""
    count = host.get("growth-test.rows")
    walk, rows = os.path.join(folder, "walk.csv"), os.path.join(folder, "rows.csv")
    with open(walk, "w", encoding="ascii") as file:
        file.write("time,growth-test.row\n")
        file.writelines("%r,%d\n" % (period * index, index) for index in range(count))
    recording = host.record(rows, ["growth-test.row-shown"] + ["growth-test.row-" + field for field in FIELDS], period)
    host.replay(walk)
    host.run(period * (count + 2))
    host.stop_recording(recording)
    found = {}
    with open(rows, newline="", encoding="ascii") as file:
        for row in csv.reader(file):
            if row[0] == "time" or float(row[1]) < 0:
                continue
            found[int(float(row[1]))] = dict(zip(FIELDS, map(float, row[2:])))
    return [found[index] for index in range(count)]


def log_text(seed, records, sensors, head=()):
    lines = ["growth-log,2", "machine,simulated %d" % seed, "begun,2026-01-01T08:00:00Z", "unit,1", "ball,6", "table,B"]
    lines += ["tolerance,0.01,0.01,0.015", "warming,spindle", "compensation,by temperatures"]
    lines += ["sensor,%d,%s" % (index + 1, name) for index, name in enumerate(SENSORS) if name in sensors]
    lines += ["bore,%d,%g,%g,%g" % (index + 1, *place) for index, place in enumerate(BORES)]
    lines += ["sphere,9,0,0,80", *head]
    number = 0
    for r in records:
        kind, item = int(r["kind"]), int(r["item"])
        if kind == 2 and SENSORS[item - 1] not in sensors:
            continue
        number += 1
        if kind == 2:
            lines.append("temperature,%d,%r,%d,%r,%d,%r" % (number, r["time"], item, r["x"], r["y"], r["z"]))
            continue
        if kind == 4:
            lines.append("speed,%d,%r,%r" % (number, r["time"], r["x"]))
            continue
        where = ",".join("%d" % r[name] for name in ("pass", "visit", "bore", "turned", "compensated", "cooled"))
        if kind == 3:
            lines.append("event,%d,%r,%s,%s,%r" % (number, r["time"], where, EVENTS[item - 1], r["x"]))
        else:
            values = ",".join("%r" % r[name] for name in ("x", "y", "z", "x-offset", "y-offset", "z-offset"))
            lines.append("touch,%d,%r,%s,%s,%s" % (number, r["time"], where, SIDES[item], values))
    return with_checksums(lines)


def with_checksums(lines):
    """The text of a log."""
    text, so_far = "", 0
    for line in lines:
        so_far = zlib.crc32(line.encode() + b"\n", so_far)
        text += "%s,%08x\n" % (line, so_far)
    return text


def lines_of(log):
    """The lines of a log, without their checksums."""
    with open(log, encoding="utf-8") as file:
        return [line.rpartition(",")[0] for line in file.read().splitlines()]


def law_of(log, *options):
    """What plumb growth identify finds in a log."""
    program = os.path.join(BUILD, "bin", "plumb-growth")
    done = subprocess.run([program, "identify", log, "--json", *options], check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def plan_of(hours):
    """What plumb growth plan offers the simulated machine, whose passes over four bores are long."""
    program = os.path.join(BUILD, "bin", "plumb-growth")
    command = [program, "plan", "--hours", "%g" % hours, "--work", "25", "--pass", "25", "--fastest", "%d" % FASTEST, "--json"]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


def add_axis_growth(host, lines, instance="axis-growth", place=(0, -60, -140)):
    """axis_growth beside sim_artifact, with these setp lines, at a place in mm. Nothing applies its offsets."""
    for number in range(4):
        for pin in ("temperature-%d", "temperature-valid-%d", "temperature-age-%d"):
            host.command("net artifact-%s artifact.%s => %s.%s" % (pin % number, pin % number, instance, pin % number))
    host.command("addf %s.update servo-thread" % instance)
    host.set(instance + ".all-homed", True)
    host.set(instance + ".enable", True)
    for axis, position in zip("xyz", place):
        host.set("%s.%s-position" % (instance, axis), position)
    for line in lines.split("\n"):
        if line and not line.startswith("#"):
            host.command(line)


def results_of(log, folder=None):
    """The first test in the results of plumb growth report; in a folder, which then has its page, too."""
    program = os.path.join(BUILD, "bin", "plumb-growth")
    if folder is None:
        done = subprocess.run([program, "report", log, "--json"], check=True, stdout=subprocess.PIPE, text=True)
        return json.loads(done.stdout)["tests"][0]
    subprocess.run([program, "report", log, "--output", folder], check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(folder, "results.json"), encoding="utf-8") as file:
        return json.load(file)["tests"][0]

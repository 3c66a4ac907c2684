# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares two ways to follow the growth between contacts: by spindle speed, and holding the last contact.

configs/mill/bench.hal runs with two thermal_displacement in one host, one of which follows the speed; that one is
applied. A part is made every 100 s, its last operation is the gauge, and every third part its contact counts: a contact
every 5 minutes, and the cuts lie between. Blanks scatter so that a contact, compared with its reference, is 1 um in
doubt, and nothing else blurs it; the figures show how much it was. Between the parts the sides are milled, at one
speed, or in steps of 10 to 40 min that a spindle at rest may be among.

An error is the offset less the growth at the bottom of a cut, which counts from that at the contact of the reference;
those after the second accepted contact are printed.
"""

import os
import random

import numpy as np

from support.command import add_place, duration_of, errors_reported, new_parser, place_of, whole
from support import growth_curves
from support.figures import largest, rms
from support.mill_machine import same_inputs, start_mill
from support.recordings import read_columns
from support.simulations import ROOT, duration_text, simulate_all

TARGETS = "simulation_mill"
MEASURED = os.path.join(ROOT, "configs", "mill", "measured_growth.csv")
PERIOD = 0.004  # s, of the thread: four times that of the bench, which costs a quarter of the time
EVERY = 0.4  # s between two rows of a recording; a cut dwells for longer
PART = 100  # s
PARTS_PER_CONTACT = 3
GAUGE = 40  # operation
CONTACT_NOISE = 0.001  # mm, of each contact; that of the reference has it too
WAYS = {"hold": "hold", "by speed": "growth"}  # and the instance that goes it
OPTIONS = {"threads.period1": round(PERIOD * 1e9), "thermal_displacement.names": "growth,hold"}
KINDS = ("constant speed", "speed steps")

IDEAL = {  # of the machine: nothing but the blank blurs a contact, and no tool gets shorter
    "program.blank-repeatability": CONTACT_NOISE,
    "mill.seating": 0,
    "mill.backlash": 0,
    "mill.encoder-step": 0.0001,
    "mill.wear-length": 0,
    "drive.sample-time": 0,
    "drive.lag": 0.02,
    "drive.white-noise": 0.05,
    "drive.flicker-noise": 0,
    "drive.quantum": 0,
    "drive.tooth-ripple": 0,
    "drive.runout-ripple": 0,
}
COLUMNS = ["program.learn", "mill.truth-cuts", "mill.truth-cut-growth", "mill.truth-contacts", "mill.truth-contact-operation"]
COLUMNS += ["mill.truth-contact-growth", "growth.displacement"]
COLUMNS += [f"{instance}.{pin}" for instance in WAYS.values() for pin in ("z-offset", "contacts-accepted")]


def add_hold(host):
    """A second thermal_displacement, hold, that sees the same signals as the first one; nothing applies its offset."""
    same_inputs(host, "growth", "hold")
    host.command("addf hold.update servo-thread")
    host.set("hold.enable", True)
    host.set("hold.follow-speed", False)


def draw_speeds(seed, kind, duration):
    """rpm between the parts, for each of them."""
    draw = random.Random(f"{seed} {kind}")
    speeds = []
    while len(speeds) * PART < duration:
        speed = draw.uniform(4000, 8000) if kind == "constant speed" else draw.uniform(1000, 8000)
        if speeds and draw.random() < 0.15:
            speed = 0
        time = duration if kind == "constant speed" else draw.uniform(600, 2400)
        speeds += [speed] * round(time / PART)
    return speeds


def simulate(seed, speeds, duration, progress):
    """(errors of each way, errors of the contacts) in um of one run; without speeds, of the measured curve."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options=OPTIONS) as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        add_hold(host)
        for pin, value in IDEAL.items():
            host.set(pin, value)
        host.set("program.cycle-interval", PART)
        for instance in WAYS.values():
            for index, operation in enumerate((10, 20, 30)):
                host.set(f"{instance}.exclude-operation-{index}", operation)
        if not speeds:
            host.set("mill.use-replay", True)
            host.replay(MEASURED)
        host.record(path, COLUMNS, EVERY)
        for part in range(round(duration / PART)):
            if speeds:
                host.set("program.sides-speed", speeds[part])
            for instance in WAYS.values():
                host.set(f"{instance}.exclude-operation-3", 0 if part % PARTS_PER_CONTACT == 0 else GAUGE)
            host.run(PART)
            if not progress((part + 1) * PART):
                break
        column = read_columns(path)
    return judge(column)


def judge(column):
    """See simulate(); column: name of a pin -> its values."""
    contacts = np.flatnonzero(np.diff(column["mill.truth-contacts"])) + 1
    gauge = contacts[column["mill.truth-contact-operation"][contacts] == GAUGE]
    reference = column["mill.truth-contact-growth"][gauge[column["program.learn"][gauge] > 0][0]]
    cuts = np.flatnonzero(np.diff(column["mill.truth-cuts"])) + 1
    errors = {}
    for way, instance in WAYS.items():
        counted = cuts[column[instance + ".contacts-accepted"][cuts - 1] >= 2]
        growth = column["mill.truth-cut-growth"][counted] - reference
        errors[way] = 1000 * (column[instance + ".z-offset"][counted - 1] - growth)  # as it was in the work
    accepted = np.flatnonzero(np.diff(column["growth.contacts-accepted"])) + 1
    growth = column["mill.truth-contact-growth"][accepted] - reference
    return errors, 1000 * (column["growth.displacement"][accepted] - growth)


def table(outcomes):
    """Its lines; outcomes: kind -> list of results of simulate()."""
    lines = [f"{'error at the cuts, um':34}{'median rms':>12}{'p90':>8}{'worst':>8}{'p95 of max':>12}{'max':>8}{'max <= 15':>11}"]
    for kind, runs in outcomes.items():
        for way in WAYS:
            judged = [errors[way] for errors, _ in runs if errors[way].size]
            if not judged:
                lines.append(f"{kind + ', ' + way:34} not one machine had a cut after a second contact")
                continue
            sizes = [rms(errors) for errors in judged]
            most = [largest(errors) for errors in judged]
            within = np.count_nonzero(np.array(most) <= 15) / len(runs)  # a machine without such a cut is none of them
            figures = (np.median(sizes), np.percentile(sizes, 90), max(sizes), np.percentile(most, 95), max(most))
            cells = "".join(f"{value:{width}.1f}" for value, width in zip(figures, (12, 8, 8, 12, 8)))
            silent = f", {len(runs) - len(judged)} without a cut after a second contact" if len(judged) < len(runs) else ""
            lines.append(f"{kind + ', ' + way:34}{cells}{within:11.0%}{silent}")
    return lines


def bench(count, first, duration, measured, place=None):
    tasks = [(seed, draw_speeds(seed, kind, duration), duration) for kind in KINDS for seed in range(first, first + count)]
    if measured:
        tasks.append((0, None, 166600))
    found = simulate_all(simulate, tasks, sum(task[-1] for task in tasks), place)
    outcomes = {kind: found[i * count : (i + 1) * count] for i, kind in enumerate(KINDS)}
    if measured:
        outcomes["measured curve"] = found[-1:]
    return outcomes


def curves(options):
    """The lines of a table of the measured curves."""
    names, units = (options.time, options.growth, options.speed), (options.time_unit, options.growth_unit)
    read = [growth_curves.read_curve(path, names, units) for path in options.curve]
    outcomes = simulate_all(
        growth_curves.simulate, [(curve, 0, options.rate) for curve in read], sum(curve.times[-1] for curve in read), place_of(options)
    )
    files = [os.path.basename(path) for path in options.curve]
    lines = [f"{file}: {curve.taken}" for file, curve in zip(files, read)]
    return [*lines, "", growth_curves.HEAD, *(growth_curves.line(file, outcome) for file, outcome in zip(files, outcomes))]


def main():
    parser = new_parser("growth", __doc__)
    parser.add_argument("--seeds", type=whole(1, 100000), default=200, metavar="N", help="drawn machines (default: 200)")
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first of them")
    parser.add_argument("--for", type=duration_of, default="4h", dest="duration", metavar="TIME", help="such as 90min or 4h (default: 4h)")
    parser.add_argument("--curve", action="append", metavar="FILE", help="a measured curve as the growth of the mill; may be repeated")
    for what in ("time", "growth", "speed"):
        parser.add_argument(f"--{what}", metavar="COLUMN", help=f"the column of the {what} in FILE (default: by its name)")
    parser.add_argument("--time-unit", choices=growth_curves.SECONDS, help="of that column (default: by name and values)")
    parser.add_argument("--growth-unit", choices=growth_curves.MILLIMETRES, help="of that column (default: by name and values)")
    parser.add_argument("--rate", type=whole(100, 10000), default=1000, metavar="HZ", help="of the thread, with --curve (default: 1000)")
    add_place(parser)
    options = parser.parse_args()
    if options.curve:
        with errors_reported():
            print("\n".join(curves(options)))
        return
    with errors_reported():
        outcomes = bench(options.seeds, options.seed, options.duration, True, place_of(options))
    print(f"{duration_text(options.duration)} on each of {options.seeds} machines, twice; a contact every 5 min\n")
    print("\n".join(table(outcomes)))
    for kind, runs in outcomes.items():
        contacts = np.concatenate([contacts for _, contacts in runs])
        print(f"{kind}: {len(contacts)} contacts, their error {rms(contacts):.2f} um (rms)")


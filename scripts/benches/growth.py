# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares two ways to follow the growth between contacts: by spindle speed, and holding the last contact.

configs/mill/bench.hal runs with two thermal_displacement in one host, one of which follows the speed; that one is
applied. A part is made every 100 s, its last operation is the gauge, and every third part its contact counts: a contact
every 5 minutes, and the cuts lie between. Blanks scatter so that a contact, compared with its reference, is 1 um in
doubt, and nothing else blurs it; the figures show how much it was. Between the parts the sides are milled, at one
speed, or in steps of 10 to 40 min that a spindle at rest may be among.

An error is the offset less the growth at the bottom of a cut, which counts from that at the contact of the reference;
those after the second accepted contact are printed. Hold and Simple3 are the rivals of support/rivals.py on the same contacts.
"""

import os
import random

import numpy as np

from support.command import add_place, duration_of, errors_reported, new_parser, place_of, whole
from support import contacts, growth_curves
from support.figures import largest, rms
from support.mill_machine import same_inputs, start_mill
from support.recordings import read_columns
from support.rivals import SIMPLE
from support.simulations import ROOT, duration_text, simulate_all

TARGETS = "simulation_mill plumb-growth"
MEASURED = os.path.join(ROOT, "configs", "mill", "measured_growth.csv")
PERIOD = 0.004  # s, of the thread: four times that of the bench, which costs a quarter of the time
EVERY = 0.4  # s between two rows of a recording; a cut dwells for longer
PART = 100  # s
PARTS_PER_CONTACT = 3
GAUGE = 40  # operation
CONTACT_NOISE = 0.001  # mm, of each contact; that of the reference has it too
APPLIED = "by speed"
WAYS = {"hold": "hold", APPLIED: "growth"}  # and the instance that goes it
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
COLUMNS = [*contacts.COLUMNS, "mill.truth-cut-growth", "mill.truth-contact-operation", "mill.truth-contact-growth"]
COLUMNS += ["hold.z-offset", "hold.contacts-accepted"]


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
    """Errors of each way and errors of the contacts, in um, and the contact lines of one run; without speeds, of the measured curve."""
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
        return judge(read_columns(path), contacts.reference_sigmas(host))


def judge(column, references=None):
    """See simulate(); column: name of a pin -> its values."""
    met = contacts.rises(column["mill.truth-contacts"])
    gauge = met[column["mill.truth-contact-operation"][met] == GAUGE]
    reference = column["mill.truth-contact-growth"][gauge[column["program.learn"][gauge] > 0][0]]
    rows = contacts.rises(column["mill.truth-cuts"])
    growth = 1000 * (column["mill.truth-cut-growth"] - reference)
    errors = {}
    for way, instance in WAYS.items():
        counted = rows[column[instance + ".contacts-accepted"][rows - 1] >= 2]
        offset = 1000 * column[instance + ".z-offset"][counted - 1]  # as it was in the work
        errors[way] = offset - growth[counted]
    cuts = contacts.cuts_at(column, counted, errors[APPLIED], offset)
    lines = contacts.ask_rivals(column, cuts, references or {})
    errors["none"] = -growth[counted]
    errors.update((name, contacts.error_of(cuts, name)) for name in SIMPLE)
    accepted = contacts.rises(column["growth.contacts-accepted"])
    true = column["mill.truth-contact-growth"][accepted] - reference
    return errors, 1000 * (column["growth.displacement"][accepted] - true), lines


def table(outcomes):
    """Its lines; outcomes: kind -> list of results of simulate()."""
    lines = [f"{'error at the cuts, um':34}{'median rms':>12}{'p90':>8}{'worst':>8}{'p95 of max':>12}{'max':>8}{'max <= 15':>11}"]
    for kind, runs in outcomes.items():
        for way in runs[0][0]:
            judged = [errors[way] for errors, *_ in runs if errors[way].size]
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
    read = [growth_curves.read_curve(path, *options.head) for path in options.curve]
    names = [os.path.basename(path) for path in options.curve]
    phases = options.phase or [0]
    tasks = [(curve, 0, options.rate, phase, options.no_speed) for curve in read for phase in phases]
    outcomes = simulate_all(growth_curves.simulate, tasks, sum(curve.times[-1] for curve, *_ in tasks), place_of(options))
    runs = [(name, phase) for name in names for phase in phases]
    lines = [f"{name}: {curve.taken}" for name, curve in zip(names, read)] + ["", growth_curves.HEAD]
    for (name, phase), outcome in zip(runs, outcomes):
        contacts.write(options.contacts, os.path.splitext(name)[0], phase, outcome.lines)
        lines += growth_curves.lines(f"{name}, {phase} s" if options.phase else name, outcome)
    return lines


def main():
    parser = new_parser("growth", __doc__)
    parser.add_argument("--seeds", type=whole(1, 100000), default=200, metavar="N", help="drawn machines (default: 200)")
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first of them")
    parser.add_argument("--for", type=duration_of, default="4h", dest="duration", metavar="TIME", help="such as 90min or 4h (default: 4h)")
    parser.add_argument("--curve", action="append", metavar="FILE", help="a measured curve as the growth of the mill; may be repeated")
    parser.add_argument("--head", action="append", default=[], metavar="HEAD=HEAD", help="reads a head of FILE as another one, such as 'ch2=Z (um)'; may be repeated")
    parser.add_argument("--rate", type=whole(100, 10000), default=1000, metavar="HZ", help="of the thread, with --curve (default: 1000)")
    parser.add_argument("--phase", type=whole(0, 299), action="append", metavar="S", help="from the start of a curve to the first part; may be repeated (default: 0)")
    parser.add_argument("--no-speed", action="store_true", help="with --curve: the component does not see the speed of the spindle")
    contacts.add_option(parser)
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
        found = np.concatenate([its for _, its, _ in runs])
        print(f"{kind}: {len(found)} contacts, their error {rms(found):.2f} um (rms)")
        for number, (*_, lines) in enumerate(runs):
            contacts.write(options.contacts, kind, number, lines)


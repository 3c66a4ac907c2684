# SPDX-License-Identifier: GPL-2.0-or-later
"""How wrong thermal_displacement is on bad days, and whether it announces it before the cut.

configs/mill/bench.hal runs on drawn machines with slow threads and poor loads, and on the typical machine under attacks: a
load event that the program causes, a dead sensor, a longer tool, a chip after a pause and others. The error of each cut is
compared with the error that it would have had without compensation: the same less the offset in force, which adds to Z.
"worse by" is |error with| - |error without|. A cut is announced if growth.doubt, growth.fault, growth.reference-refused or
growth.learning-failed was true LEAD s before its end, when the tool was still above the work. Only the operations that are not
excluded show the growth and the wear of their tools; the cuts of the other tools have a count of their own.
"""

import dataclasses
import math
import os
import random
import sys

import numpy as np

from support.command import add_output, add_place, duration_of, errors_reported, make_writable, new_parser, place_of, whole
from support.command import written_line
from support.figures import largest, rms
from support.mill_machine import every_end_mill_is_a_gauge, start_mill
from support.recordings import read_columns, write_rows
from support import load_events, second_mill
from support.simulations import duration_text, simulate_all

TARGETS = "simulation_mill"
EVERY = 0.1  # s between two rows of a recording
LEAD = 3  # s
UNKNOWN = 51  # status-code: of the first part after a start
RATES = (500, 1000, 4000)  # Hz, of the servo thread
WORSE = 5  # um
CLEAN = 2  # um, most standard deviation of the reference by a load that is clean
TEACH = 1800  # s from the start of an attack's run to its begin

ANNOUNCING = ("doubt", "fault", "reference-refused", "learning-failed")
COLUMNS = ["mill.truth-cuts", "mill.truth-cut-error", "mill.truth-cut-operation", "mill.truth-cut-occurrence"]
COLUMNS += ["mill.applied-offset", "program.learn", "program.cycle", "growth.offset-sigma", "growth.contacts-accepted"]
COLUMNS += ["growth.contacts", "growth.contacts-rejected", "growth.detail-code"]
COLUMNS += ["growth.reference-sigma", "growth.z-offset", "growth.status-code", "growth.authority", "growth.gate", *("growth." + pin for pin in ANNOUNCING)]


# --- attacks ---


def unlink(host, pin, value):
    """A sensor that is gone: the pin keeps a value."""
    host.command(f"unlinkp {pin}")
    host.set(pin, value)


def program_event(host, jitter=0.0):
    """Coolant comes on 1.5 mm above the work, and the load rises as by a cut."""
    host.set("drive.coolant-load", 6)
    host.set("program.coolant-height", 1.5)
    host.set("program.coolant-jitter", jitter)


def force(host, number, **values):
    """The event of that number in every cycle from now on."""
    for name, value in values.items():
        host.set("program.event-" + name, value)
    host.set("program.event", number)


CHIP, STOCK, LONGER, OVERRIDE, SPEED_CHANGE = 2, 3, 5, 6, 10


def replay(host, height):
    host.set("mill.growth-replay", height)
    host.set("mill.use-replay", True)


@dataclasses.dataclass
class Attack:
    """`prepare(host)` before the learning cycle; `events`: (s since the attack began, function of the host)."""

    name: str
    prepare: object = lambda host: None
    events: tuple = ()


def steps(times, function):
    return tuple((time, lambda host, time=time: function(host, time)) for time in times)


def chip_after_a_pause():
    return (
        (0, lambda host: host.set("program.run", False)),
        (5400, lambda host: (force(host, CHIP, height=0.04, operation=10), host.set("program.run", True))),
        (5700, lambda host: host.set("program.event", 0)),
    )


def one_gauge(host):
    """Operation 40 alone."""
    host.set("growth.exclude-operation-1", 10)


def every_gauge(host):
    every_end_mill_is_a_gauge(host)


def chiller(host):
    """The spindle's chiller holds its growth at 12 um, then at 17 um at another speed."""
    host.set("program.sides-speed", 3000)
    replay(host, 0)


def short_filter(host):
    host.set("drive.lag", 0.02)


def stock(height):
    return ((0, lambda host: force(host, STOCK, height=height)),)


ATTACKS = [
    Attack("none"),
    Attack("event of the program", program_event),
    Attack("event of the program, jitter 10 ms", lambda host: program_event(host, 0.01)),
    Attack("event of the program at one of two tools", lambda host: (every_gauge(host), program_event(host, 0.001), host.set("drive.coolant-load", 3))),
    Attack("poor reference", lambda host: (host.set("drive.white-noise", 4), host.set("drive.flicker-noise", 2)),
           ((-TEACH + 290, lambda host: (host.set("drive.white-noise", 0.3), host.set("drive.flicker-noise", 0.1))),)),
    Attack("load dead at 0", events=((0, lambda host: unlink(host, "growth.load", 0)),)),
    Attack("load frozen", events=((0, lambda host: unlink(host, "growth.load", 11.3)),)),
    Attack("load not a number", events=((0, lambda host: unlink(host, "growth.load", float("nan"))),)),
    Attack("gauge tool 30 um longer", one_gauge, ((0, lambda host: force(host, LONGER, height=0.03, operation=40)),)),
    Attack("two gauges 37 um apart", every_gauge, ((0, lambda host: force(host, LONGER, height=0.037, operation=40)),)),
    Attack("sister tool", events=((0, lambda host: unlink(host, "growth.tool-number", 9)),)),
    Attack("chiller, another speed", chiller,
           (*steps(range(-1500, 0, 60), lambda host, time: replay(host, 0.012 * (1 - np.exp(-(time + 1500) / 600)))),
            (0, lambda host: host.set("program.sides-speed", 20000)),
            *steps(range(0, 3600, 60), lambda host, time: replay(host, 0.012 + 0.005 * (1 - np.exp(-time / 600)))))),
    Attack("chip after a pause", events=chip_after_a_pause()),
    Attack("override of 70 % on the only gauge", one_gauge, ((0, lambda host: force(host, OVERRIDE, factor=0.7, operation=40)),)),
    Attack("speed changes on the approach", one_gauge, ((0, lambda host: force(host, SPEED_CHANGE, factor=0.9, operation=40)),)),
    Attack("interrupted surface", events=((0, lambda host: host.set("program.blank-repeatability", 0.012)),)),
    Attack("step of 20 um", every_gauge, (*steps([-900], lambda host, time: replay(host, 0.01)), (0, lambda host: replay(host, 0.03)))),
]

SHIFTS = [  # of all contacts, on machines that grow by little
    Attack("the only tool 30 um longer", short_filter, ((0, lambda host: force(host, LONGER, height=0.03, operation=10)),)),
    Attack("blanks 25 um higher", short_filter, stock(0.025)),
    Attack("a chamfer, 25 um lower", short_filter, stock(-0.025)),
    Attack("a fixture 50 um higher", short_filter, stock(0.05)),
    Attack("15 ms more latency of the load", lambda host: (short_filter(host), host.set("growth.load-latency", 0.015)),
           ((0, lambda host: host.set("growth.load-latency", 0)),)),
    Attack("filter of the drive 20 to 50 ms", short_filter, ((0, lambda host: host.set("drive.lag", 0.05)),)),
]


def attack_named(name):
    return next(attack for attack in ATTACKS + SHIFTS if attack.name == name)


DAY = 7200  # s, of a machine with two drawn attacks
NOTICE = 600  # s that an attack may last before it must be announced: two cycles


def drawn_attacks(number):
    """Two attacks, and the time of each in a day."""
    draw = random.Random(f"day {number}")
    possible = [attack for attack in ATTACKS if all(after >= 0 for after, _ in attack.events)]
    return list(zip(draw.sample(possible, 2), (draw.uniform(1500, 3000), draw.uniform(3600, 5400))))


# --- one run ---


CUT = [("error", float), ("worse", float), ("sigma", float), ("announced", bool), ("code", int), ("authority", float), ("known", bool), ("gate", float), ("gauge", bool)]


def excluded_operations(host):
    return {host.get(f"growth.exclude-operation-{index}") for index in range(4)}


def find_cuts(column, excluded=()):
    """The cuts after learning that have a reference cut. `excluded`: operations whose contacts do not count."""
    rows = np.flatnonzero(np.diff(column["mill.truth-cuts"])) + 1
    key = list(zip(column["mill.truth-cut-operation"][rows], column["mill.truth-cut-occurrence"][rows]))
    tip = 1000 * column["mill.truth-cut-error"][rows]
    learnt = column["program.learn"][rows] > 0
    reference = {k: error for k, error, of_learning in zip(key, tip, learnt) if of_learning}
    early = np.maximum(rows - round(LEAD / EVERY), 0)
    announced = sum(column["growth." + pin][early] for pin in ANNOUNCING) > 0
    counted = [i for i in range(len(rows)) if not learnt[i] and key[i] in reference]
    cuts = np.zeros(len(counted), CUT)
    for cut, i in zip(cuts, counted):
        offset = 1000 * column["mill.applied-offset"][rows[i] - 1]
        cut["error"] = tip[i] - reference[key[i]]
        cut["worse"] = abs(cut["error"]) - abs(cut["error"] - offset)
        cut["sigma"] = 1000 * column["growth.offset-sigma"][early[i]]
        cut["announced"] = announced[i]
        cut["code"] = column["growth.status-code"][early[i]]
        cut["authority"] = column["growth.authority"][early[i]]
        cut["gate"] = 1000 * column["growth.gate"][early[i]]
        cut["gauge"] = column["mill.truth-cut-operation"][rows[i]] not in excluded
        cut["known"] = column["growth.contacts-accepted"][early[i]] >= 2
    return cuts, column["program.cycle"][rows[counted]], column["time"][rows[counted]]


def record(host, folder, seed, attacks, duration, progress, growth=None, second=False):
    """attacks: pairs of an Attack and the time at which it begins; `second`: a mill of the other structure."""
    path = os.path.join(folder, "recording.csv")
    start_mill(host, seed)
    of_plant = second_mill.prepare(host, seed, (growth or 40) / 1000, duration, folder) if second else []
    if growth is not None and not second:
        host.set("mill.spindle-growth", growth / 1000)
    host.command("net learn-again growth.learning-failed => program.relearn")  # as an operator who reads the message
    for attack, _ in attacks:
        attack.prepare(host)
    host.record(path, COLUMNS, EVERY)
    done = 0
    events = [*of_plant, *((begin + after, change) for attack, begin in attacks for after, change in attack.events)]
    for due, change in sorted(events, key=lambda event: event[0]):
        if due > done and due < duration:
            host.run(due - done)
            done = due
        if due < duration:
            change(host)
        if not progress(done):
            break
    host.run(duration - done)
    progress(duration)
    return read_columns(path)


UNCERTAIN = (55, 61, 62)  # status-code: the growth is uncertain, or authority holds a part of it back. The panel shows it, without a message
NOTICES = (*UNCERTAIN, UNKNOWN)


def simulate_growth(seed, rate, growth, second, duration, progress):
    return simulate(seed, rate, "none", duration, progress, growth, second)


def simulate(seed, rate, name, duration, progress, growth=None, second=False):
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        column = record(host, folder, seed, [(attack_named(name), TEACH)], duration, progress, growth, second)
        excluded = excluded_operations(host)
    cuts, _, times = find_cuts(column, excluded)
    code = column["growth.status-code"]
    messages = begins(column["growth.doubt"] * ~np.isin(code, NOTICES) + column["growth.fault"])
    return cuts, times, messages, begins(column["growth.doubt"] * np.isin(code, UNCERTAIN)), 1000 * column["growth.reference-sigma"][-1]


def begins(signal):
    """How often it becomes true."""
    return np.count_nonzero(np.diff((signal > 0).astype(int)) > 0)


def simulate_shift(seed, rate, name, duration, growth, second, progress):
    return simulate(seed, rate, name, duration, progress, growth, second)[:2]


def simulate_event(seed, rate, name, duration, growth, progress):
    """The load_events.Outcome of a machine."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        host.set("mill.spindle-growth", growth / 1000)
        host.command("net learn-again growth.learning-failed => program.relearn")
        event = load_events.event_named(name)
        event.prepare(host)
        host.record(path, COLUMNS, EVERY)
        event.run(host, duration, progress)
        excluded = excluded_operations(host)
        column = read_columns(path)
    cuts, cycles, _ = find_cuts(column, excluded)
    return load_events.judge(column, cuts, cycles)


def together(outcomes):
    """The cuts, and their times, of several machines."""
    return [np.concatenate(parts) for parts in zip(*outcomes)]


def simulate_day(number, rate, progress):
    """The findings of a day of drawn attacks, as lines; and the number of its cuts."""
    import plumb
    from plumb_folder import TemporaryFolder

    attacks = drawn_attacks(number)
    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        column = record(host, folder, 0, attacks, DAY, progress)
        most, fastest = host.get("growth.max-offset"), host.get("growth.max-rate")
    cuts, _, times = find_cuts(column)
    return broken(column, cuts, times, attacks, most, fastest, number), len(cuts)


def broken(column, cuts, times, attacks, most, fastest, number):
    names = " and ".join(f"{attack.name} at {begin:.0f} s" for attack, begin in attacks)
    offset = column["growth.z-offset"]
    found = []
    if largest(offset) > most * (1 + 1e-9):
        found.append(f"day {number}, {names}: an offset of {largest(offset):.4f} mm")
    if largest(np.diff(offset)) > 1.001 * fastest * EVERY:
        found.append(f"day {number}, {names}: an offset that moves by {largest(np.diff(offset)) / EVERY:.4f} mm/s")
    begins = [begin for attack, begin in attacks if attack.events]
    for cut, time in zip(cuts, times):
        fresh = any(begin <= time < begin + NOTICE for begin in begins)
        if cut["worse"] > 3 + cut["sigma"] and not cut["announced"] and not fresh:
            found.append(f"day {number}, {names}: a cut at {time:.0f} s is worse by {cut['worse']:.1f} um, and not announced")
    return found


# --- tables ---


def honest(cuts):
    """Part of the cuts with a known growth whose error is within two sigma."""
    known = cuts[cuts["known"]]
    return np.mean(abs(known["error"]) <= 2 * known["sigma"]) if len(known) else np.nan


def attack_table(attacks, outcomes):
    width = max(len(attack.name) for attack in attacks)
    lines = [f"{'from the attack on, um':{width}}{'with':>7}{'without':>9}{'worse by':>10}{'beyond':>8}{'unannounced':>13}  status-codes"]
    for attack, (cuts, times, *_) in zip(attacks, outcomes):
        since = cuts[times >= TEACH]
        if not len(since):  # nothing was learned
            lines.append(f"{attack.name:{width}}  no cut with a reference")
            continue
        without = np.abs(since["error"]) - since["worse"]
        beyond = since["worse"] - 3 - since["sigma"]
        silent = np.count_nonzero((since["worse"] > 3) & ~since["announced"])
        codes = ",".join(str(code) for code in np.unique(since["code"][since["announced"]]))
        lines.append(
            f"{attack.name:{width}}{rms(since['error']):7.1f}{rms(without):9.1f}{since['worse'].max():10.1f}"
            f"{max(beyond.max(), 0):8.1f}{silent:6d} of {len(since):<4d} {np.mean(since['announced']):4.0%} announced; status-codes {codes or '-'}"
        )
    return lines


def most_likely(found, of):
    """Upper 95 % limit of the part of which `found` of so many are a sample (C. J. Clopper and E. S. Pearson, Biometrika 26, 1934)."""
    low, high = found / of, 1.0
    for _ in range(60):
        part = (low + high) / 2
        terms = [math.lgamma(of + 1) - math.lgamma(k + 1) - math.lgamma(of - k + 1) + k * math.log(part) + (of - k) * math.log1p(-part) for k in range(found + 1)]
        low, high = (part, high) if sum(math.exp(term) for term in terms) > 0.05 else (low, part)
    return high


def machine_row(cuts, messages, statuses, reference_sigma):
    without = np.abs(cuts["error"]) - cuts["worse"]
    worse = cuts["worse"] > WORSE
    beyond = cuts["worse"] > cuts["gate"] + 3 * cuts["sigma"]
    return {
        "rms with": rms(cuts["error"]),
        "rms without": rms(without),
        "cuts": len(cuts),
        "worse": np.count_nonzero(worse),
        "gauge cuts": np.count_nonzero(cuts["gauge"]),
        "gauge worse": np.count_nonzero(worse & cuts["gauge"]),
        "beyond": np.count_nonzero(worse & beyond),
        "silent beyond": np.count_nonzero(worse & beyond & ~cuts["announced"]),
        "silent": np.count_nonzero(worse & ~cuts["announced"]),
        "largest worse": cuts["worse"].max() if len(cuts) else np.nan,
        "within 2 sigma": honest(cuts),
        "announced": np.mean(cuts["announced"]) if len(cuts) else np.nan,
        "told": np.mean(cuts["announced"] & (cuts["code"] != UNKNOWN)) if len(cuts) else np.nan,
        "by status": np.mean(cuts["announced"] & np.isin(cuts["code"], UNCERTAIN)) if len(cuts) else np.nan,
        "messages": messages,
        "statuses": statuses,
        "reference sigma": reference_sigma,
        "applied": np.mean(np.abs(cuts["error"]) != without) if len(cuts) else np.nan,
    }


def machine_table(rate, rows, hours):
    benefit = [1 - row["rms with"] / row["rms without"] for row in rows]
    worse = [row["rms with"] - row["rms without"] for row in rows]
    cuts, bad, silent, beyond, silent_beyond = (sum(row[name] for row in rows) for name in ("cuts", "worse", "silent", "beyond", "silent beyond"))
    of_gauges, gauge_cuts = (sum(row[name] for row in rows) for name in ("gauge worse", "gauge cuts"))
    within = [row["within 2 sigma"] for row in rows]
    return [
        f"{rate} Hz, {len(rows)} machines, {cuts} cuts",
        f"  rms with compensation: median {np.median([r['rms with'] for r in rows]):.1f} um, without {np.median([r['rms without'] for r in rows]):.1f} um",
        f"  part of the rms that is removed: median {np.median(benefit):.0%}, p10 {np.percentile(benefit, 10):.0%}",
        f"  machines whose rms is worse by more than 1 um: {sum(w > 1 for w in worse)}; the worst by {max(worse):.1f} um",
        f"  cuts more than {WORSE} um worse: {limit_text(bad, cuts)}",
        f"  ... with tools whose contacts count: {limit_text(of_gauges, gauge_cuts)}; with the other tools: {limit_text(bad - of_gauges, cuts - gauge_cuts)}",
        f"  of these within the gate and 3 sigma: {bad - beyond}, not announced {silent - silent_beyond}; beyond: {beyond}, not announced {silent_beyond}",
        f"  |error| <= 2 sigma: {np.nanmean(within):.0%} of the cuts, lowest machine {np.nanmin(within):.0%}",
        f"  announced: {np.mean([row['announced'] for row in rows]):.0%} of the cuts",
        clean_line([row for row in rows if row["reference sigma"] <= CLEAN], hours),
    ]


def limit_text(found, of):
    return f"{found} of {of} ({found / of:.2%}, at most {most_likely(found, of):.2%} with 95 %)" if of else "no cut"


def clean_line(rows, hours):
    if not rows:
        return f"  no machine has a clean load (reference-sigma <= {CLEAN} um)"
    announced, told, by_status = (np.mean([row[name] for row in rows]) for name in ("announced", "told", "by status"))
    messages, statuses = (100 * sum(row[name] for row in rows) / (hours * len(rows)) for name in ("messages", "statuses"))
    return (
        f"  {len(rows)} machines with a clean load (reference-sigma <= {CLEAN} um): announced {announced:.1%} of the cuts, {told:.1%} after the first part, "
        f"{by_status:.1%} by the panel's status alone (status-code 55, 61, 62)\n"
        f"  in 100 h: {messages:.1f} messages, {statuses:.1f} times a doubt by the status alone"
    )


def report_events(options):
    events, rate = load_events.EVENTS, (options.rate or [1000])[0]
    seeds = range(options.seed, options.seed + options.seeds)
    tasks = [(seed, rate, event.name, options.duration, options.growth or 30) for event in events for seed in seeds]
    outcomes = simulate_all(simulate_event, tasks, len(tasks) * options.duration, place_of(options))
    outcomes = [outcomes[i : i + len(seeds)] for i in range(0, len(tasks), len(seeds))]
    clean = [i for i, machine in enumerate(outcomes[0]) if machine.reference_sigma <= CLEAN]
    print(f"{len(seeds)} machines at {rate} Hz that grow by {options.growth or 30} um, {duration_text(options.duration)} each")
    print("\n".join(load_events.table(events, outcomes)))
    if clean and len(clean) < len(seeds):
        print(f"\n{len(clean)} of them with a clean load (reference-sigma <= {CLEAN} um)")
        print("\n".join(load_events.table(events, [[machines[i] for i in clean] for machines in outcomes])))


def main():
    parser = new_parser("trust", __doc__)
    parser.add_argument("--attacks", action="store_true", help="only the attacks on the typical machine")
    parser.add_argument("--shifts", action="store_true", help="only shifts of all contacts, on the drawn machines together; use --growth")
    parser.add_argument("--events", action="store_true", help="only events of the load around the contacts, on drawn machines")
    parser.add_argument("--days", type=whole(1, 100000), metavar="N", help="N machines for two hours each, with two drawn attacks")
    parser.add_argument("--seeds", type=whole(1, 100000), default=200, metavar="N", help="drawn machines for each rate (default: 200)")
    parser.add_argument("--seed", type=whole(0, 2**31 - 1), default=1, metavar="N", help="the first of them")
    parser.add_argument("--rate", type=whole(100, 10000), action="append", metavar="HZ", help="of the servo thread; may be repeated (default: 500, 1000, 4000)")
    parser.add_argument("--growth", type=whole(1, 200), metavar="UM", help="growth of the spindle of each machine (default: drawn, 20 to 70)")
    parser.add_argument("--plant", type=int, choices=(1, 2), default=1, help="2: a mill of another structure (default: 1)")
    parser.add_argument("--for", type=duration_of, default="2h", dest="duration", metavar="TIME", help="such as 90min or 4h (default: 2h)")
    add_place(parser)
    add_output(parser, "trust")
    options = parser.parse_args()
    for name in ("attacks", "events", "days"):
        if getattr(options, name) and options.plant == 2:
            parser.error(f"--{name} changes the mill of the first structure: it does not go with --plant 2")
    with errors_reported():
        make_writable(options.output)
        if options.attacks:
            rate = (options.rate or [500])[0]
            duration = TEACH + 9000
            tasks = [(0, rate, attack.name, duration) for attack in ATTACKS]
            outcomes = simulate_all(simulate, tasks, len(tasks) * duration, place_of(options))
            print("\n".join(attack_table(ATTACKS, outcomes)))
            return
        if options.shifts:
            seeds, rate = range(options.seed, options.seed + options.seeds), (options.rate or [500])[0]
            tasks = [(seed, rate, shift.name, options.duration, options.growth, options.plant == 2) for shift in SHIFTS for seed in seeds]
            outcomes = simulate_all(simulate_shift, tasks, len(tasks) * options.duration, place_of(options))
            print("\n".join(attack_table(SHIFTS, [together(outcomes[i : i + len(seeds)]) for i in range(0, len(tasks), len(seeds))])))
            return
        if options.events:
            report_events(options)
            return
        if options.days:
            tasks = [(number, (options.rate or [500])[0]) for number in range(options.seed, options.seed + options.days)]
            outcomes = simulate_all(simulate_day, tasks, len(tasks) * DAY, place_of(options))
            lines = [line for found, _ in outcomes for line in found]
            print("\n".join(lines))
            print(f"{duration_text(len(tasks) * DAY)} with drawn attacks, {sum(count for _, count in outcomes)} cuts: {len(lines)} findings")
            sys.exit(1 if lines else 0)
        rates = options.rate or RATES
        seeds = range(options.seed, options.seed + options.seeds)
        tasks = [(seed, rate, options.growth, options.plant == 2, options.duration) for rate in rates for seed in seeds]
        outcomes = simulate_all(simulate_growth, tasks, len(tasks) * options.duration, place_of(options))
        rows = [machine_row(cuts, *found) for cuts, _, *found in outcomes]
        print(f"{duration_text(options.duration)} of milling on each machine\n")
        for i, rate in enumerate(rates):
            print("\n".join(machine_table(rate, rows[i * len(seeds) : (i + 1) * len(seeds)], options.duration / 3600)))
        path = os.path.join(options.output, "machines.csv")
        write_rows(path, ["rate_hz", "machine", *rows[0]], ([task[1], task[0], *row.values()] for task, row in zip(tasks, rows)))
        print(written_line([path]))

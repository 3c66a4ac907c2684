# SPDX-License-Identifier: GPL-2.0-or-later
"""How wrong thermal_displacement is on bad days, and whether it announces it before the cut.

configs/mill/bench.hal runs on drawn machines with slow threads and poor loads, and on the typical machine under attacks: a
load event that the program causes, a dead sensor, a longer tool, a chip after a pause and others. The error of each cut is
compared with the error that it would have had without compensation: the same less the offset in force, which adds to Z.
"worse by" is |error with| - |error without|. A cut is announced if growth.doubt, growth.fault, growth.reference-refused or
growth.learning-failed was true LEAD s before its end, when the tool was still above the work. Only the operations that are not
excluded show the growth and the wear of their tools; the cuts of the other tools have a count of their own.
"""

import os
import random
import sys

import numpy as np

from support import contacts, load_events, second_mill
from support.attacks import ATTACKS, SHIFTS, TEACH, attack_named
from support.command import add_output, add_place, duration_of, errors_reported, make_writable, new_parser, place_of, whole
from support.command import written_line
from support.contacts import UNKNOWN, error_of, worse_by
from support.figures import largest, most_likely, rms
from support.mill_machine import learn_until_good, run_events, start_mill
from support.recordings import write_rows
from support.replay import of_machines
from support.rivals import SIMPLE
from support.simulations import duration_text, simulate_all

TARGETS = "simulation_mill"
EVERY = 0.1  # s between two rows of a recording
RATES = (500, 1000, 4000)  # Hz, of the servo thread
WORSE = 5  # um
CLEAN = 2  # um, most standard deviation of the reference by a load that is clean

DAY = 7200  # s, of a machine with two drawn attacks
NOTICE = 600  # s that an attack may last before it must be announced: two cycles


def drawn_attacks(number):
    """Two attacks, and the time of each in a day."""
    draw = random.Random(f"day {number}")
    possible = [attack for attack in ATTACKS if all(after >= 0 for after, _ in attack.events)]
    return list(zip(draw.sample(possible, 2), (draw.uniform(1500, 3000), draw.uniform(3600, 5400))))


# --- one run ---


def record(host, folder, seed, attacks, duration, progress, growth=None, second=False):
    """attacks: pairs of an Attack and the time at which it begins; `second`: a mill of the other structure."""
    path = os.path.join(folder, "recording.csv")
    start_mill(host, seed)
    of_plant = second_mill.prepare(host, seed, (growth or 40) / 1000, duration, folder) if second else []
    if growth is not None and not second:
        host.set("mill.spindle-growth", growth / 1000)
    learn_until_good(host)
    for attack, _ in attacks:
        attack.prepare(host)
    host.record(path, contacts.COLUMNS, EVERY)
    events = [*of_plant, *((begin + after, change) for attack, begin in attacks for after, change in attack.events)]
    run_events(host, events, duration, progress)
    return contacts.judge(host, path)


UNCERTAIN = (55, 61, 62)  # status-code: the growth is uncertain, or authority holds a part of it back. The panel shows it, without a message
NOTICES = (*UNCERTAIN, UNKNOWN)


def simulate_growth(seed, rate, growth, second, duration, progress):
    return simulate(seed, rate, "none", duration, progress, growth, second)


def simulate(seed, rate, name, duration, progress, growth=None, second=False):
    """The cuts, the contact lines, messages, times of a doubt by the status alone, and um of the reference's sigma."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        its = record(host, folder, seed, [(attack_named(name), TEACH)], duration, progress, growth, second)
    column, code = its.column, its.column["growth.status-code"]
    messages = begins(column["growth.doubt"] * ~np.isin(code, NOTICES) + column["growth.fault"])
    statuses = begins(column["growth.doubt"] * np.isin(code, UNCERTAIN))
    return its.cuts, its.lines, messages, statuses, 1000 * column["growth.reference-sigma"][-1]


def begins(signal):
    """How often it becomes true."""
    return np.count_nonzero(np.diff((signal > 0).astype(int)) > 0)


def simulate_shift(seed, rate, name, duration, growth, second, progress):
    return simulate(seed, rate, name, duration, progress, growth, second)


def simulate_event(seed, rate, name, duration, growth, progress):
    """The load_events.Outcome of a machine."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        host.set("mill.spindle-growth", growth / 1000)
        learn_until_good(host)
        event = load_events.event_named(name)
        event.prepare(host)
        host.record(path, contacts.COLUMNS, EVERY)
        event.run(host, duration, progress)
        its = contacts.judge(host, path)
    return load_events.judge(its.column, its.cuts), its.lines


def simulate_day(number, rate, progress):
    """The findings of a day of drawn attacks, as lines; and the number of its cuts."""
    import plumb
    from plumb_folder import TemporaryFolder

    attacks = drawn_attacks(number)
    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        its = record(host, folder, 0, attacks, DAY, progress)
        most, fastest = host.get("growth.max-offset"), host.get("growth.max-rate")
    return broken(its.column, its.cuts, attacks, most, fastest, number), len(its.cuts)


def broken(column, cuts, attacks, most, fastest, number):
    names = " and ".join(f"{attack.name} at {begin:.0f} s" for attack, begin in attacks)
    offset = column["growth.z-offset"]
    found = []
    if largest(offset) > most * (1 + 1e-9):
        found.append(f"day {number}, {names}: an offset of {largest(offset):.4f} mm")
    if largest(np.diff(offset)) > 1.001 * fastest * EVERY:
        found.append(f"day {number}, {names}: an offset that moves by {largest(np.diff(offset)) / EVERY:.4f} mm/s")
    begins = [begin for attack, begin in attacks if attack.events]
    for cut in cuts:
        time = cut["time"]
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
    """outcomes: the cuts under each attack."""
    width = max(len(attack.name) for attack in attacks)
    ways = "".join(f"{name:>9}" for name in SIMPLE)
    lines = [
        f"{'from the attack on, um':{width}}{'rms of the error':>{25 + len(ways)}}{'worse by, at most':>{17 + len(ways)}}",
        f"{'':{width}}{'with':>7}{'without':>18}{ways}{'with':>17}{ways}{'beyond':>8}{'unannounced':>13}  status-codes",
    ]
    for attack, cuts in zip(attacks, outcomes):
        since = cuts[cuts["time"] >= TEACH]
        if not len(since):  # nothing was learned
            lines.append(f"{attack.name:{width}}  no cut with a reference")
            continue
        beyond = since["worse"] - 3 - since["sigma"]
        silent = np.count_nonzero((since["worse"] > 3) & ~since["announced"])
        codes = ",".join(str(code) for code in np.unique(since["code"][since["announced"]]))
        cells = f"{rms(since['error']):7.1f}{rms(since['error'] - since['offset']):18.1f}" + "".join(f"{rms(error_of(since, way)):9.1f}" for way in SIMPLE)
        cells += f"{since['worse'].max():17.1f}" + "".join(f"{worse_by(since, way).max():9.1f}" for way in SIMPLE)
        lines.append(
            f"{attack.name:{width}}{cells}{max(beyond.max(), 0):8.1f}{silent:6d} of {len(since):<4d} "
            f"{np.mean(since['announced']):4.0%} announced; status-codes {codes or '-'}"
        )
    return lines


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


def kept(options, names, found):
    """Writes the contact lines of all machines, as --contacts wants; names: a class and a number for each."""
    for (group, number), lines in zip(names, found):
        contacts.write(options.contacts, group, number, lines)


def report_events(options):
    events, rate = load_events.EVENTS, (options.rate or [1000])[0]
    seeds = range(options.seed, options.seed + options.seeds)
    tasks = [(seed, rate, event.name, options.duration, options.growth or 30) for event in events for seed in seeds]
    found = simulate_all(simulate_event, tasks, len(tasks) * options.duration, place_of(options))
    kept(options, [(name, seed) for seed, _, name, *_ in tasks], [lines for _, lines in found])
    outcomes = [outcome for outcome, _ in found]
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
    contacts.add_option(parser)
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
            kept(options, [(attack.name, 0) for attack in ATTACKS], [lines for _, lines, *_ in outcomes])
            print("\n".join(attack_table(ATTACKS, [cuts for cuts, *_ in outcomes])))
            return
        if options.shifts:
            seeds, rate = range(options.seed, options.seed + options.seeds), (options.rate or [500])[0]
            tasks = [(seed, rate, shift.name, options.duration, options.growth, options.plant == 2) for shift in SHIFTS for seed in seeds]
            outcomes = simulate_all(simulate_shift, tasks, len(tasks) * options.duration, place_of(options))
            kept(options, [(name, seed) for seed, _, name, *_ in tasks], [lines for _, lines, *_ in outcomes])
            groups = [outcomes[i : i + len(seeds)] for i in range(0, len(tasks), len(seeds))]
            print("\n".join(attack_table(SHIFTS, [np.concatenate([cuts for cuts, *_ in machines]) for machines in groups])))
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
        kept(options, [(f"{rate} Hz", seed) for seed, rate, *_ in tasks], [lines for _, lines, *_ in outcomes])
        rows = [machine_row(cuts, *found) for cuts, _, *found in outcomes]
        print(f"{duration_text(options.duration)} of milling on each machine\n")
        for i, rate in enumerate(rates):
            its = slice(i * len(seeds), (i + 1) * len(seeds))
            print("\n".join(machine_table(rate, rows[its], options.duration / 3600)))
            print("\n" + "\n".join(of_machines(f"{rate} Hz", [lines for _, lines, *_ in outcomes[its]])))
        path = os.path.join(options.output, "machines.csv")
        write_rows(path, ["rate_hz", "machine", *rows[0]], ([task[1], task[0], *row.values()] for task, row in zip(tasks, rows)))
        print(written_line([path]))

# SPDX-License-Identifier: GPL-2.0-or-later
"""Simulates hours of milling and compares the errors of the cuts without and with thermal_displacement.

configs/mill/bench.hal runs in the virtual-time host, once with growth.enable false and once with it true. Each cut
is judged by its error: the tip error at its bottom minus the tip error of the reference cut, which the same operation made in
the learning cycle. From the second warm contact on, thermal_displacement can know something; the cuts before it are
counted in a line of their own.
"""

import collections
import dataclasses
import functools
import os
import sys
import time

import numpy as np

from support import charts, mill_cycles, mill_events
from support.charts import BLUE, GREEN, GREY, ORANGE, PURPLE
from support.command import add_output, add_place, duration_of, errors_reported, make_writable, new_parser, place_of, whole
from support.command import written_line
from support.figures import largest, percentile_lines, rms
from support.mill_machine import start_mill
from support.recordings import read_columns, write_rows
from support.simulations import duration_text, simulate_all

TARGETS = "simulation_mill"
PACKAGES = "python3-matplotlib"
RUNS = ("without", "with")  # compensation
EVERY = 0.1  # s between two rows of a recording; cuts are seconds apart
SERIES_EVERY = 1  # s between two rows of the series that are kept

LENGTHS = {  # recorded in mm, in um from here on
    "growth": "mill.truth-growth",
    "offset": "mill.applied-offset",
    "cut-error": "mill.truth-cut-error",
    "cut-growth": "mill.truth-cut-growth",
}
NUMBERS = {
    "cuts": "mill.truth-cuts",
    "cut-operation": "mill.truth-cut-operation",
    "cut-occurrence": "mill.truth-cut-occurrence",
    "cut-tool": "mill.truth-cut-tool",
    "cycle": "program.cycle",
    "learning": "program.learn",
    "speed": "program.spindle-speed-cmd",
    "accepted": "growth.contacts-accepted",
    "missed": "growth.contacts-missed",
    "unexpected": "growth.contacts-unexpected",
    "rejected": "growth.contacts-rejected",
    "rejection": "growth.detail-code",
}
VERDICTS = ("accepted", "missed", "unexpected", "rejected")  # of thermal_displacement on a contact


# --- read a recording ---


def read_recording(path):
    """The columns of a recording, as arrays under their short names, and "time"."""
    column = read_columns(path)
    recording = {"time": column["time"]}
    recording.update((name, 1000 * column[pin]) for name, pin in LENGTHS.items())
    recording.update((name, column[pin]) for name, pin in NUMBERS.items())
    return recording


CUT = [(name, float) for name in ("time", "error", "tip_error", "growth", "offset")]
CUT += [(name, int) for name in ("cycle", "operation", "occurrence", "tool", "learning")]


def find_cuts(recording):
    """One row of type CUT for each cut. Its error is NaN where the operation made no reference cut."""
    increments = np.diff(recording["cuts"])
    if np.any(increments > 1):
        raise ValueError("two cuts fall into one row of the recording")
    rows = np.flatnonzero(increments) + 1
    cuts = np.zeros(len(rows), CUT)
    for name in ("time", "offset", "cycle", "learning"):
        cuts[name] = recording[name][rows]
    for name in ("growth", "operation", "occurrence", "tool"):
        cuts[name] = recording["cut-" + name][rows]
    cuts["tip_error"] = recording["cut-error"][rows]

    references = {}
    for cut in cuts[cuts["learning"] == 1]:
        references[cut["operation"], cut["occurrence"]] = cut["tip_error"]
    for cut in cuts:
        cut["error"] = cut["tip_error"] - references.get((cut["operation"], cut["occurrence"]), np.nan)
    return cuts


def warm_cuts(cuts):
    """The cuts after learning that can be judged."""
    return cuts[(cuts["learning"] == 0) & np.isfinite(cuts["error"])]


def find_verdicts(recording):
    """(time, verdict, detail-code of a rejection or 0) of each contact that thermal_displacement judged."""
    found = []
    for verdict in VERDICTS:
        increments = np.diff(recording[verdict])
        for row in np.flatnonzero(increments > 0) + 1:
            code = int(recording["rejection"][row]) if verdict == "rejected" else 0
            found += [(recording["time"][row], verdict, code)] * int(increments[row - 1])
    return sorted(found)


@dataclasses.dataclass
class Outcome:
    """The result of one run: um, s."""

    peak_growth: float  # largest departure of the growth from its start
    cuts: np.ndarray  # of type CUT
    verdicts: list  # as find_verdicts() returns them
    series: dict  # time, growth, offset and speed, every SERIES_EVERY


def judge(recording):
    growth = recording["growth"]
    step = round(SERIES_EVERY / EVERY)
    return Outcome(
        peak_growth=largest(growth - growth[0]),
        cuts=find_cuts(recording),
        verdicts=find_verdicts(recording),
        series={name: recording[name][::step] for name in ("time", "growth", "offset", "speed")},
    )


# --- running the mill ---


def simulate(seed, compensated, duration, progress, load_every=None, constant_in_part=False):
    """The Outcome of one run; progress(seconds done) is called meanwhile. load_every is in s; None leaves it to the drive."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host() as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        host.set("growth.enable", compensated)
        host.set("growth.constant-in-part", constant_in_part)
        if load_every is not None:
            host.set("drive.sample-time", load_every)
        host.record(path, [*LENGTHS.values(), *NUMBERS.values()], EVERY)
        host.run(duration, progress)
        return judge(read_recording(path))


# --- print ---


def error_table(without, compensated):
    """The lines of the table of errors, of two Outcomes of one machine."""
    before, after = warm_cuts(without.cuts), warm_cuts(compensated.cuts)
    rows = [
        ("from the second warm contact on", before["error"][1:], after["error"][1:]),
        ("all cuts after learning", before["error"], after["error"]),
        ("the same, against the drawing", before["tip_error"], after["tip_error"]),
        ("first cut of each cycle", first_of_each_cycle(before)[1:], first_of_each_cycle(after)[1:]),
        ("range within a part", ranges_of_cycles(before)[1:], ranges_of_cycles(after)[1:]),
        ("the same, of the offset", ranges_of_cycles(before, "offset")[1:], ranges_of_cycles(after, "offset")[1:]),
    ]
    for operation in np.unique(after["operation"]):
        rows.append(
            (f"operation {operation}",)
            + tuple(cuts["error"][1:][cuts["operation"][1:] == operation] for cuts in (before, after))
        )
    lines = [
        f"{'Error at the cuts, um (% of peak growth)':40}{'without compensation':>34}{'with compensation':>34}",
        f"{'':40}" + f"{'rms':>17}{'max':>17}" * 2,
    ]
    peak = without.peak_growth
    for name, *errors in rows:
        cells = [f(values) for values in errors for f in (rms, largest)]
        lines.append(f"{name:40}" + "".join(_figure(value, peak) for value in cells))
    return lines


def _figure(value, peak):
    return f"{value:>8.1f} ({value / peak:6.1%})" if np.isfinite(value) else f"{'-':>8}{'':9}"


def first_of_each_cycle(cuts):
    return cuts["error"][np.unique(cuts["cycle"], return_index=True)[1]]


def ranges_of_cycles(cuts, name="error"):
    """Of the values of each cycle, the largest minus the smallest."""
    return np.array([np.ptp(cuts[name][cuts["cycle"] == cycle]) for cycle in np.unique(cuts["cycle"])])


def contact_lines(outcome, sentences):
    """Lines about the contacts: how many were accepted, missed, unexpected and rejected, and why."""
    counts = collections.Counter(verdict for _, verdict, _ in outcome.verdicts)
    codes = collections.Counter(code for _, verdict, code in outcome.verdicts if verdict == "rejected")
    lines = ["Contacts: " + ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS)]
    return lines + [f"  {count} rejected: {sentences.get(code, f'code {code}')}" for code, count in codes.most_common()]


def percentile_table(machines):
    """The lines of the table over many machines, of pairs of Outcomes without and with compensation."""
    figures = {
        "rms of the error, um": lambda outcome, peak: rms(warm_cuts(outcome.cuts)["error"][1:]),
        "the same, % of peak growth": lambda outcome, peak: 100 * rms(warm_cuts(outcome.cuts)["error"][1:]) / peak,
        "largest error, um": lambda outcome, peak: largest(warm_cuts(outcome.cuts)["error"][1:]),
        "rms of the range within a part, um": lambda outcome, peak: rms(ranges_of_cycles(warm_cuts(outcome.cuts))[1:]),
        "the same of the offset, um": lambda outcome, peak: rms(ranges_of_cycles(warm_cuts(outcome.cuts), "offset")[1:]),
    }
    rows = [
        (f"{name}, {run} compensation", [figure(pair[i], pair[0].peak_growth) for pair in machines])
        for name, figure in figures.items()
        for i, run in enumerate(RUNS)
    ]
    return percentile_lines("At the cuts, from the second warm contact on", rows, 8, "{:.1f}".format, 50)


# --- write ---


def write_cuts(path, outcomes):
    """outcomes: run -> Outcome. One row for each cut."""
    names = [name for name, _ in CUT]
    header = ["compensation"] + [{"time": "time_s"}.get(n, n + "_um" if t is float else n) for n, t in CUT]
    cuts = [(run, cut) for run, outcome in outcomes.items() for cut in outcome.cuts]
    write_rows(path, header, ([run] + [_cell(cut[name]) for name in names] for run, cut in cuts))


def write_series(path, outcomes):
    """One row for each SERIES_EVERY."""
    without, compensated = (outcomes[run].series for run in RUNS)
    columns = [without["time"], without["speed"], without["growth"], compensated["offset"]]
    header = ["time_s", "spindle_speed_rpm", "growth_um", "offset_um"]
    write_rows(path, header, ([_cell(value) for value in row] for row in zip(*columns)))


def _cell(value):
    return f"{value:.4f}".rstrip("0").rstrip(".") if isinstance(value, float) else int(value)


def draw(paths, outcomes, title):
    """Errors above, growth, offset and contacts below; in the format that the end of each path names."""
    pyplot = charts.prepared_pyplot()
    without, compensated = (outcomes[run] for run in RUNS)
    figure, (errors, offsets) = pyplot.subplots(
        2, 1, figsize=(10, 7), sharex=True, height_ratios=(3, 2), layout="constrained"
    )
    charts.write_title(figure, title)

    errors.axhline(0, color=GREY, linewidth=0.8)
    for outcome, colour, marker, label in (
        (without, ORANGE, "o", "without compensation"),
        (compensated, BLUE, "D", "with compensation"),
    ):
        cuts = warm_cuts(outcome.cuts)
        label = f"{label}: rms {rms(cuts['error'][1:]):.1f} µm"
        errors.plot(cuts["time"] / 3600, cuts["error"], marker, color=colour, markersize=3.5, label=label)
    errors.set_ylabel("error at the cuts (µm)")
    errors.legend(loc="upper right", frameon=False, ncols=2, bbox_to_anchor=(1, 1.12))
    errors.grid(axis="y", color=charts.GRID, linewidth=0.6)

    hours = compensated.series["time"] / 3600
    offsets.plot(hours, compensated.series["growth"], color=GREY, linewidth=2.5, alpha=0.6, label="growth of the machine")
    offsets.plot(hours, compensated.series["offset"], color=BLUE, linewidth=1.2, label="offset of the Z origin")
    marks = {"accepted": (GREEN, "|"), "missed": (PURPLE, "v"), "unexpected": (ORANGE, "s"), "rejected": (ORANGE, "x")}
    bottom = min(np.min(compensated.series["growth"]), np.min(compensated.series["offset"]), 0)
    span = max(np.ptp(compensated.series["growth"]), 1)
    for verdict, (colour, marker) in marks.items():
        times = [time for time, found, _ in compensated.verdicts if found == verdict]
        if times:
            level = np.full(len(times), bottom - 0.12 * span)
            label = f"contact {verdict} ({len(times)})"
            offsets.plot(np.array(times) / 3600, level, marker, color=colour, markersize=6, label=label)
    offsets.set_ylabel("growth and offset (µm)")
    offsets.set_xlabel("time (h)")
    offsets.set_xlim(0, hours[-1] + SERIES_EVERY / 3600)
    offsets.legend(loc="upper right", frameon=False, ncols=4, bbox_to_anchor=(1, 1.18), fontsize=9)
    offsets.grid(axis="y", color=charts.GRID, linewidth=0.6)
    charts.save(figure, paths)


# --- the command ---


def bench_one(seed, duration, output, place, work):
    began = time.monotonic()
    tasks = [(seed, compensated, duration) for compensated in (False, True)]
    outcomes = dict(zip(RUNS, simulate_all(work, tasks, 2 * duration, place)))
    elapsed = time.monotonic() - began
    without, compensated = (outcomes[run] for run in RUNS)
    machine = f"machine {seed}" if seed else "the typical machine"
    print(f"{duration_text(duration)} of milling on {machine}, peak growth {without.peak_growth:.1f} um\n")
    print("\n".join(error_table(without, compensated)))
    print("\n" + "\n".join(contact_lines(compensated, mill_cycles.rejections())))
    print(f"2 x {duration_text(duration)} in {elapsed:.1f} s: {2 * duration / elapsed:.0f} simulated seconds per second")

    paths = [os.path.join(output, name) for name in ("errors.png", "errors.svg", "cuts.csv", "series.csv")]
    draw(paths[:2], outcomes, f"Z errors of {duration_text(duration)} of milling on {machine}")
    write_cuts(paths[2], outcomes)
    write_series(paths[3], outcomes)
    print(written_line(paths))


def bench_many(seeds, duration, output, place, work):
    tasks = [(seed, compensated, duration) for seed in seeds for compensated in (False, True)]
    outcomes = simulate_all(work, tasks, len(tasks) * duration, place)
    machines = list(zip(outcomes[::2], outcomes[1::2]))
    print(f"{duration_text(duration)} of milling on each of {len(machines)} machines, {seeds[0]} to {seeds[-1]}\n")
    print("\n".join(percentile_table(machines)))

    path = os.path.join(output, "machines.csv")
    header = ["machine", "peak_growth_um"] + [f"{figure}_{run}_um" for run in RUNS for figure in ("rms", "max")] + list(VERDICTS)
    write_rows(path, header, (machine_row(seed, *pair) for seed, pair in zip(seeds, machines)))
    print(written_line([path]))


def machine_row(seed, without, compensated):
    errors = [warm_cuts(outcome.cuts)["error"][1:] for outcome in (without, compensated)]
    counts = collections.Counter(verdict for _, verdict, _ in compensated.verdicts)
    figures = [without.peak_growth] + [f(values) for values in errors for f in (rms, largest)]
    return [seed] + [_cell(value) for value in figures] + [counts[verdict] for verdict in VERDICTS]


def main():
    parser = new_parser("mill", __doc__)
    seed, many = whole(0, 2**31 - 1), whole(1, 100000)
    parser.add_argument("--seed", type=seed, default=None, metavar="N", help="draw machine N; 0 is the typical one")
    parser.add_argument("--seeds", type=many, metavar="N", help="N drawn machines, from --seed or 1 on, and a table of percentiles")
    parser.add_argument("--events", type=many, metavar="N", help="N drawn programs that something upsets, instead of the run of hours")
    parser.add_argument("--cycles", type=many, metavar="N", help="N drawn cycles with an event each, 100 a machine: whether all counts agree")
    parser.add_argument("--for", type=duration_of, default="4h", dest="duration", metavar="TIME", help="such as 600, 10min or 4h (default: 4h)")
    parser.add_argument("--load-every", type=duration_of, metavar="TIME", help="time between two values of the load, such as 0.1 over Modbus (default: as the drive)")
    parser.add_argument("--constant-in-part", action="store_true", help="the offset changes at the start of a part only")
    add_place(parser)
    add_output(parser, "mill")
    options = parser.parse_args()
    for name in ("events", "cycles"):
        if getattr(options, name) and (options.seed is not None or options.seeds):
            parser.error(f"--{name} draws its own programs: it does not go with --seed or --seeds")
    if options.events and options.cycles:
        parser.error("--events and --cycles are two benches: one at a time")
    for name in ("load_every", "constant_in_part"):
        if getattr(options, name) and (options.events or options.cycles):
            parser.error("--%s goes with the run of hours only" % name.replace("_", "-"))
    place = place_of(options)
    work = functools.partial(simulate, load_every=options.load_every, constant_in_part=options.constant_in_part)
    with errors_reported():
        make_writable(options.output)
        if options.events:
            mill_events.report(options.events, place)
        elif options.cycles:
            sys.exit(0 if mill_cycles.report(options.cycles, place) else 1)
        elif options.seeds:
            first = 1 if options.seed is None else options.seed
            bench_many(range(first, first + options.seeds), options.duration, options.output, place, work)
        else:
            bench_one(options.seed or 0, options.duration, options.output, place, work)


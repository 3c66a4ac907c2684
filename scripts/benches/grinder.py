# SPDX-License-Identifier: GPL-2.0-or-later
"""Strokes drawn axes between two dead points: errors there by each kind of command, learned and not; cycle times; a chart.

sim_grinder is the axis; its truth pins have the dead points of the load. The commands have the same stroke and the same cycle
time: constant speed to the dead point, a trapezoid of speed, and chopping without and with learning.
"""

import csv
import os

import numpy as np

from support import charts, drives, ends, integral, proven, way_out
from support.command import add_output, add_place, errors_reported, make_writable, new_parser, place_of, whole, written_line
from support.figures import percentile_lines
from support.recordings import write_rows
from support.simulations import ROOT, simulate_all

TARGETS = "simulation_grinder sim_elastic_axis"
PACKAGES = "python3-matplotlib"
CONFIG = os.path.join(ROOT, "configs", "grinder", "bench.hal")
COMMANDS = {
    "constant": "constant speed",
    "trapezoid": "trapezoid of speed",
    "crank": "chopping, not learned",
    "learned": "chopping, learned",
}
LEARNED = {
    "learned": "scale at the load",
    "motor": "scale at the motor",
    "strong": "half of the largest force of the drive",
}
STROKE, FEED, ACCELERATION = 30.0, 80.0, 500.0  # mm, mm/s, mm/s2
UM = 1000  # per mm
CYCLES = 8  # until the dead points are to be right
SETTLED = 12  # s, in which an axis that does not learn settles
DURATION = 45  # s, in which the slowest one has learned

# --- one axis ---


def simulate(command, seed, progress):
    """Error at the dead points (outside positive, um), largest distance beyond them, cycles to learn: of one drawn axis."""
    import plumb

    with plumb.Host() as host:
        prepare(host, command, seed)
        host.command("start")
        if command == "strong":
            strengthen(host)
        if command not in LEARNED:
            host.run(SETTLED, progress)
            progress(DURATION)
            errors = dead_point_errors(host)
            return errors, max(errors)
        worst, beyond, silent = learn(host)
        progress(DURATION)
        return worst, beyond, silent


def learn(host):
    """Largest error at each dead point in the cycles after the first CYCLES at full speed, farthest beyond until then, and whether
    chopping showed learned and no fault while an error was larger than 2 um."""
    beyond, silent = -np.inf, False
    host.run(2)
    while host.get("chop.speed-factor") < 1 and not host.get("chop.fault") and host.time < 100:
        host.run(0.2)
        beyond = max(beyond, *dead_point_errors(host))
    # The present stroke and the next one are still slower.
    begin, worst, errors = host.get("chop.stroke-count") + 2, [0, 0], dead_point_errors(host)
    names = ["chop.stroke-count", "chop.active", "chop.learned", "chop.fault"]
    count, active, *_ = host.get(names)
    while count < begin + 2 * CYCLES + 10 and active:
        host.run(0.05)  # each dead point lasts for a cycle
        errors = dead_point_errors(host)
        beyond = max(beyond, *errors)
        count, active, learned, fault = host.get(names)
        if count > begin + 2 * CYCLES:
            worst = [max(old, new, key=abs) for old, new in zip(worst, errors)]
            silent |= max(map(abs, errors)) > 2 and learned and not fault
    return worst if active else errors, beyond, silent


def dead_point_errors(host):
    upper, lower = host.get(["grinder.truth-upper", "grinder.truth-lower"])
    return [UM * (upper - STROKE), UM * -lower]


def prepare(host, command, seed):
    """The configuration with this command."""
    host.load(CONFIG)
    settings = {
        "grinder.seed": seed,
        "grinder.wheel-force": 0,
        "grinder.load-resonance": 0,
        "chop.section-0-kind": 0,
        "chop.upper": STROKE,
        "chop.feed": FEED,
        "chop.max-acceleration": ACCELERATION,
        "chop.learn": command in LEARNED,
        "grinder.scale-at-load": command != "motor",
    }
    if command in ("crank", "trapezoid"):
        settings["chop.jerk-time"] = 0
    if command == "trapezoid":
        # Every speed is far too fast, so that speed and acceleration alone bound the stroke.
        settings.update({"chop.section-0-kind": 1, "chop.section-0-to": 360, "chop.section-0-ratio": 1000})
        settings["chop.max-feed"] = settings["chop.feed"] = trapezoid_speed()
    for name, value in settings.items():
        host.set(name, value)
    if command == "constant":
        host.command("loadrt siggen names=saw")
        host.command("addf saw.update servo-thread 1")
        host.command("unlinkp grinder.position-cmd")
        host.command("net saw saw.triangle => grinder.position-cmd")
        for name, value in {"frequency": 1 / crank_time(), "amplitude": STROKE / 2, "offset": STROKE / 2}.items():
            host.set("saw." + name, value)


def strengthen(host):
    """A stroke that takes half of the largest force of this axis at its dead points."""
    host.set("chop.run", False)
    host.run(3)
    acceleration = host.get("grinder.truth-force-limit") / 2
    settings = {
        "chop.max-acceleration": acceleration,
        "chop.feed": np.sqrt(acceleration * STROKE / 2),
        "chop.max-feed": 1000,
        "chop.max-rate": 1000,
        "chop.max-correction": 5,
        "chop.jerk-time": 0.02,
        "z-stage.max-rate": 2000,
        "z-stage.offset-acceleration": 200000,
    }
    for name, value in settings.items():
        host.set(name, value)
    host.set("chop.run", True)


def crank_time():
    return np.pi * STROKE / FEED


def trapezoid_speed():
    """With the acceleration of the crank's dead points it would take the same time: a t^2 - t T/2 a + S = 0."""
    half, acceleration = crank_time() / 2, ACCELERATION
    ramp = half / 2 - np.sqrt(half**2 / 4 - STROKE / acceleration)
    return acceleration * ramp


# --- cycle times ---

CONTACT = 0.5  # of the stroke, in its middle
RATIOS = (1, 2, 4, 8)
ACCELERATIONS = (500, 1000, 2000, 5000)
GRINDING = 50.0  # mm/s, peak in contact
ALONG = 10.0  # mm/s, of the contour


def planned_times(progress):
    """Cycle time by (acceleration, ratio of the speed in air to that in contact)."""
    import plumb

    times = {}
    with plumb.Host() as host:
        host.load(CONFIG)
        host.set("chop.learn", False)
        host.set("chop.jerk-time", 0)
        host.set("chop.max-feed", 500)
        host.set("chop.feed", GRINDING)
        for section, (low, high) in enumerate(((0, 10), (30, 40))):
            host.set(f"chop.section-{section}-kind", 2)
            host.set(f"chop.section-{section}-from", low)
            host.set(f"chop.section-{section}-to", high)
        host.command("start")
        for acceleration in ACCELERATIONS:
            for ratio in RATIOS:
                host.set("chop.max-acceleration", acceleration)
                host.set("chop.section-0-ratio", ratio)
                host.set("chop.section-1-ratio", ratio)
                host.run(10)
                times[acceleration, ratio] = host.get("chop.planned-cycle-time")
    return times


def time_lines(times):
    lines = [f"Cycle time, s, of a stroke of 40 mm with {GRINDING:g} mm/s in contact on 20 mm, by the speed in air;"]
    lines.append(f"in brackets the spacing of scratches, mm, at {ALONG:g} mm/s along the contour")
    lines.append(f"{'max-acceleration, mm/s2':28}" + "".join(f"{f'x {ratio}':>16}" for ratio in RATIOS))
    for acceleration in ACCELERATIONS:
        cells = (times[acceleration, ratio] for ratio in RATIOS)
        lines.append(f"{acceleration:<28}" + "".join(f"{f'{time:.3f} ({ALONG * time / 2:.1f})':>16}" for time in cells))
    return lines


# --- phase drift ---

DRIFT_LINES = """
loadrt threads name1=servo-thread period1=1000000
loadrt chopping names=chop interlock=no sections=4
setp chop.upper            30
setp chop.speed-kind        3
setp chop.cycle-time        1.1781234
setp chop.max-acceleration 500
setp chop.min-limit       -50
setp chop.max-limit        50
setp chop.homed             1
setp chop.motion-enabled    1
setp chop.run               1
addf chop.update servo-thread
start
"""


def drift(hours, progress):
    """Strokes in so many hours, and by how many seconds they are late then, by the set cycle time and the periods of the thread."""
    import plumb
    from plumb_folder import TemporaryFolder

    with plumb.Host() as host, TemporaryFolder() as folder:
        for line in filter(None, DRIFT_LINES.splitlines()):
            host.command(line)
        host.run(10)
        begin = upward_crossing(host, os.path.join(folder, "begin.csv"))
        host.run(3600 * hours, progress)
        end = upward_crossing(host, os.path.join(folder, "end.csv"))
        cycle = host.get("chop.cycle-time")
        return host.get("chop.stroke-count"), end - begin - round((end - begin) / cycle) * cycle


def upward_crossing(host, path):
    """The next time at which the command passes the middle upward, where it is fastest."""
    since, record = host.time, host.record(path, ["chop.command"], 0.001)
    host.run(3)
    host.stop_recording(record)
    time, place = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    i = np.flatnonzero((place[:-1] < STROKE / 2) & (place[1:] >= STROKE / 2))[0]
    return since + time[i] - time[0] + 0.001 * (STROKE / 2 - place[i]) / (place[i + 1] - place[i])


def drift_line(hours, strokes, seconds):
    cycles = strokes / 2
    return f"After {hours:g} h, {cycles:.0f} cycles of a set time: {1e6 * abs(seconds):.2f} us from it, {1e9 * abs(seconds) / cycles:.1f} ns a cycle."


# --- print, write ---


def error_lines(results):
    rows = [(words, [max(map(abs, errors)) for errors, *_ in results[command]]) for command, words in COMMANDS.items()]
    title = "Error of the farther dead point, um"
    return percentile_lines(title, rows, 10, lambda value: f"{value:.1f}", 40)


def promise_lines(results):
    lines = [f"Learned, after {CYCLES} cycles at full speed{'':26}within 2 um   worst, um   farthest beyond, um   silent"]
    for command, words in LEARNED.items():
        errors = [max(map(abs, its)) for its, *_ in results[command]]
        good, beyond = sum(error <= 2 for error in errors), max(beyond for _, beyond, _ in results[command])
        silent = sum(silent for *_, silent in results[command])
        lines.append(f"{words:65}{f'{good} of {len(errors)}':>11}{max(errors):>12.1f}{beyond:>22.1f}{silent:>9}")
    return lines


def record_cycle(folder):
    """The columns of one cycle of the configuration, learned."""
    import plumb

    path = os.path.join(folder, "cycle.csv")
    names = ["chop.command", "chop.velocity", "chop.acceleration", "chop.phase", "grinder.truth-position"]
    with plumb.Host() as host:
        host.load(CONFIG)
        host.command("start")
        host.run(80)
        while host.get("chop.phase") < 350:
            host.run(0.005)
        record = host.record(path, names, 0.001)
        host.run(host.get("chop.planned-cycle-time") + 0.3)
        host.stop_recording(record)
    with open(path) as lines:
        header = next(csv.reader(lines))
        table = np.loadtxt(lines, delimiter=",")
    cycle = {name: table[:, column] for column, name in enumerate(header)}
    begin = np.flatnonzero(np.diff(cycle["chop.phase"]) < -180)
    rows = slice(begin[0] + 1, begin[1] + 1) if len(begin) > 1 else slice(begin[0] + 1, None)
    return {name: values[rows][::6] for name, values in cycle.items()}


def draw(paths, cycle, results):
    pyplot = charts.prepared_pyplot()
    sheet, views = pyplot.subplots(5, 1, figsize=(9, 11), layout="constrained", height_ratios=(1, 1, 1, 1, 1.3))
    charts.write_title(sheet, "One cycle with a slow section, and the dead points of drawn axes")
    time = cycle["time"] - cycle["time"][0]
    slow = (cycle["chop.command"] >= 10) & (cycle["chop.command"] <= 30)
    rows = ("chop.command", "position (mm)"), ("chop.velocity", "speed (mm/s)"), ("chop.acceleration", "acceleration (mm/s²)"), ("chop.phase", "phase (°)")
    for view, (name, label) in zip(views, rows):
        view.fill_between(time, 0, 1, where=slow, transform=view.get_xaxis_transform(), color=charts.GRID, label="section, ratio 0.25")
        view.plot(time, cycle[name], color=charts.BLUE, label="command")
        view.set_ylabel(label)
        view.set_xlim(0, time[-1])
        view.grid(color=charts.GRID, linewidth=0.6)
    views[0].plot(time, cycle["grinder.truth-position"], color=charts.ORANGE, linestyle="--", label="load")
    views[0].legend(loc="upper right", fontsize=8)
    views[3].set_xlabel("time (s)")
    colours = (charts.GREY, charts.PURPLE, charts.ORANGE, charts.GREEN)
    for (command, words), colour in zip(COMMANDS.items(), colours):
        errors = np.sort([max(map(abs, its)) for its, *_ in results[command]])
        views[4].plot(np.maximum(errors, 1e-2), np.linspace(0, 100, len(errors)), color=colour, label=words)
    views[4].set_xscale("log")
    views[4].set_xlabel("error of the farther dead point (µm)")
    views[4].set_ylabel("axes (%)")
    views[4].grid(color=charts.GRID, linewidth=0.6)
    views[4].legend(fontsize=8)
    charts.save(sheet, paths)


def write_axes(path, seeds, results):
    header = ["seed"] + [f"{command}_{end}_um" for command in COMMANDS for end in ("upper", "lower")] + ["learned_beyond_um"]
    rows = zip(seeds, *(results[command] for command in COMMANDS))
    write_rows(path, header, ([seed, *(f"{error:.2f}" for errors, *_ in its for error in errors), f"{its[-1][1]:.2f}"] for seed, *its in rows))


# --- tables ---


def errors_of_commands(seeds, options):
    from plumb_folder import TemporaryFolder

    commands = list(dict.fromkeys([*COMMANDS, *LEARNED]))
    tasks = [(command, seed) for command in commands for seed in seeds]
    outcomes = simulate_all(simulate, tasks, DURATION * len(tasks), place_of(options))
    results = {command: outcomes[i * len(seeds) : (i + 1) * len(seeds)] for i, command in enumerate(commands)}
    paths = [os.path.join(options.output, name) for name in ("grinder.png", "grinder.svg", "axes.csv")]
    with TemporaryFolder() as folder:
        draw(paths[:2], record_cycle(folder), results)
    write_axes(paths[2], seeds, results)
    return [*error_lines(results), "", *promise_lines(results), "", written_line(paths)]


def axes_by_force(seeds, options):
    axes = [(plant, seed, weak) for plant in drives.PLANTS for weak in drives.WEAK for seed in seeds]
    found = simulate_all(drives.simulate, axes, drives.DURATION * len(axes), place_of(options))
    by_drive = {}
    for (plant, _, weak), outcome in zip(axes, found):
        by_drive.setdefault((plant, weak), []).append(outcome)
    path = os.path.join(options.output, "force.csv")
    write_rows(path, *drives.rows(axes, found))
    return [*drives.table(by_drive), "", written_line([path])]


def proven_axes(seeds, options):
    axes = [(plant, seed) for plant in drives.PLANTS for seed in seeds]
    found = simulate_all(proven.simulate, axes, proven.DURATION * len(axes), place_of(options))
    path = os.path.join(options.output, "proven.csv")
    write_rows(path, *proven.rows(axes, found))
    by_plant = {plant: [outcome for (its, _), outcome in zip(axes, found) if its == plant] for plant in drives.PLANTS}
    return [*proven.table(by_plant), "", written_line([path])]


def ways_to_the_end(seeds, options):
    axes = ends.drawn_axes(seeds)
    found = simulate_all(ends.simulate, axes, ends.DURATION * len(axes), place_of(options))
    path = os.path.join(options.output, "ends.csv")
    write_rows(path, *ends.rows(axes, found))
    by_strength = {its: [outcome for (*_, strength), outcome in zip(axes, found) if strength == its] for its in ends.STRENGTHS}
    return [*ends.table(by_strength), "", written_line([path])]


def ways_out(seeds, options):
    axes = way_out.drawn_axes(seeds)
    found = simulate_all(way_out.simulate, axes, way_out.DURATION * len(axes), place_of(options))
    path = os.path.join(options.output, "way_out.csv")
    write_rows(path, *way_out.rows(axes, found))
    return [*way_out.table(axes, found), "", written_line([path])]


def first_strokes(seeds, options):
    axes = integral.drawn_axes(seeds)
    found = simulate_all(integral.simulate, axes, integral.DURATION * len(axes), place_of(options))
    path = os.path.join(options.output, "integral.csv")
    write_rows(path, *integral.rows(axes, found))
    by_loop = {its: [outcome for (_, loop), outcome in zip(axes, found) if loop == its] for its in integral.LOOPS}
    return [*integral.table(by_loop), "", written_line([path])]


def times_and_drift(_, options):
    [late] = simulate_all(drift, [(options.hours,)], 3600 * options.hours, place_of(options))
    return [*time_lines(planned_times(None)), "", drift_line(options.hours, *late)]


TABLES = {
    "errors": errors_of_commands,
    "force": axes_by_force,
    "integral": first_strokes,
    "proven": proven_axes,
    "ends": ways_to_the_end,
    "way-out": ways_out,
    "times": times_and_drift,
}

# --- the command ---


def main():
    parser = new_parser("grinder", __doc__)
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first axis (default: 1)")
    parser.add_argument("--seeds", type=whole(2, 100000), default=200, metavar="N", help="N drawn axes (default: 200)")
    parser.add_argument("--hours", type=whole(1, 1000), default=24, metavar="N", help="look for drift in N hours (default: 24)")
    add_place(parser)
    add_output(parser, "grinder")
    parser.add_argument("--tables", nargs="+", choices=TABLES, default=list(TABLES), metavar="TABLE", help="only these: " + ", ".join(TABLES))
    options = parser.parse_args()
    with errors_reported():
        make_writable(options.output)
        seeds = range(options.seed, options.seed + options.seeds)
        print(f"{len(seeds)} axes, {seeds[0]} to {seeds[-1]}: a stroke of {STROKE:g} mm in {crank_time() / 2:.2f} s", flush=True)
        for name in options.tables:
            print("\n" + "\n".join(TABLES[name](seeds, options)), flush=True)

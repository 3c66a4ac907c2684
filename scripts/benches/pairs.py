# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures the scatter between two equal contacts: thermal_displacement, and thresholds on the same load.

In each pair the tool meets the same work twice at 100 mm/min, at moments that have nothing to do with the samples of
the drive: in a learning cycle, and in a cycle in which the cut takes 20 % less. The growth is 0, so that the
displacement between the two is the error. The load comes from sim_drive_load, the contacts from the
thermal_displacement that is shipped, in the virtual-time host.
"""

import dataclasses
import os
import random
import sys

import numpy as np

from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.figures import rms
from support.recordings import read_columns
from support.simulations import simulate_all

TARGETS = "simulation_mill"
PERIOD = 0.001  # s, of servo-thread
FEED = 100 / 60  # mm/s
RATED = 3700  # W, 100 % of the load
STEP = 8  # %
SOFTER = 0.8  # part of the step, in the second run
NOISE = 0.3  # %, standard deviation
LAG = 0.03  # s
SPEED = 6000  # rpm
REVOLUTION = 60 / SPEED

APPROACH = 0.8  # s that Z feeds before the contact, and then in the work
IN_WORK = 0.4
ABOVE = 0.4  # s between two contacts that Z is clear of the work; the fit ends in it
CYCLE = APPROACH + IN_WORK + ABOVE
RESULTS = ("growth.contacts", "growth.displacement", "growth.displacement-sigma")
RESULTS_EVERY = 0.05  # s
WINDOW = 0.3  # s before and after the contact that are fitted


@dataclasses.dataclass
class Case:
    name: str
    sample_time: float = 0  # s; 0 for each period
    quantum: float = 0  # %
    ripple: bool = False
    limit: float = np.inf  # um, for the rms


CASES = (
    Case("load at 1 kHz", limit=1.2),
    Case("load each 8 ms, to 0.5 %", 0.008, 0.5, limit=3),
    Case("1 kHz, with ripple", ripple=True),
    Case("8 ms, with ripple", 0.008, 0.5, ripple=True),
)

FIT, MIDDLE, LOW = "fit", "middle", "low"  # how a contact is found


def setup(host, case):
    for line in (
        "loadrt threads name1=servo-thread period1=1000000",
        "loadrt sim_drive_load names=drive",
        "loadrt thermal_displacement names=growth interlock=no",
        "net load drive.load => growth.load",
        "addf drive.update servo-thread",
        "addf growth.update servo-thread",
        "start",
    ):
        host.command(line)
    settings = {
        "seed": 1,
        "spindle-speed-cmd": SPEED,
        "rated-power": RATED,
        "idle-speed": 0,
        "warm-decline": 0,
        "pulse": 0,
        "part-spread": 0,
        "wear-rise": 0,
        "tooth-ripple": 0.2 if case.ripple else 0,
        "runout-ripple": 0.1 if case.ripple else 0,
        "lag": LAG,
        "sample-time": case.sample_time,
        "white-noise": NOISE,
        "flicker-noise": 0,
        "quantum": case.quantum,
    }
    for pin, value in settings.items():
        host.set("drive." + pin, value)
    host.set("growth.spindle-speed-cmd", SPEED)
    for pin in ("enable", "dry-run", "operation", "tool-number"):
        host.set("growth." + pin, 1)


def write_signals(path, pairs, ripple):
    """Simulates a program and its mill: two cycles for each pair. Returns the times of the contacts and the end."""
    draw = random.Random(1)
    # The chip of an end mill grows over its first revolution; a step takes the period in which it comes.
    grows = REVOLUTION if ripple else PERIOD
    pins = ["drive.cutting-power", "drive.idle"]
    pins += ["growth." + pin for pin in ("cycle-running", "cycle-complete", "learn", "forget", "motion-type", "z-velocity-cmd", "z-position")]
    rapid, feed = 1, 2
    contacts = []
    begin = 3.0  # when the load of the start is forgotten
    with open(path, "w", encoding="ascii") as file:
        file.write(",".join(["time", *pins]) + "\n")
        for number in range(2 * pairs):
            learn = number % 2 == 0
            power = STEP / 100 * RATED * (1 if learn else SOFTER)
            idle = draw.uniform(4, 5)
            contact = begin + APPROACH + draw.uniform(0, 0.1)
            end = contact + IN_WORK
            for time, cut, running, motion in (
                (begin - 0.1, 0, False, rapid),
                (begin, 0, True, feed),
                (contact, 0, True, feed),
                (contact + grows, power, True, feed),
                (end, power, True, feed),
                (end + PERIOD, 0, True, rapid),
                (end + ABOVE, 0, False, rapid),
            ):
                z = FEED * (contact - time) if motion == feed else 1
                row = (cut, idle, int(running), int(not running), int(learn), int(learn and time < begin), motion, -FEED if motion == feed else 0, z)
                file.write(f"{time:.9f}," + ",".join(f"{value:.12g}" for value in row) + "\n")
            contacts.append(contact)
            begin = end + ABOVE + 0.2
    return np.array(contacts), begin


def simulate(case, pairs, progress):
    """The Scatter of so many pairs."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host() as host:
        signals, loads, results = (os.path.join(folder, name) for name in ("signals.csv", "loads.csv", "results.csv"))
        setup(host, case)
        contacts, end = write_signals(signals, pairs, case.ripple)
        host.replay(signals)
        host.record(loads, ["drive.load"], PERIOD)
        host.record(results, RESULTS, RESULTS_EVERY)
        host.run(end - 0.2, progress)
        load, column = read_columns(loads)["drive.load"], read_columns(results)
    found, displacement, sigma = (column[name] for name in RESULTS)
    rows = np.floor((contacts[1::2] + IN_WORK + ABOVE) / RESULTS_EVERY).astype(int)
    if not np.array_equal(found[rows], np.arange(2, 2 * pairs + 1, 2)):
        raise ValueError(f"{case.name}: thermal_displacement has found {found[-1]:.0f} of {2 * pairs} contacts")
    errors = {FIT: 1000 * displacement[rows]}
    for name, find in ((MIDDLE, crosses_middle), (LOW, crosses_low)):
        moments = np.array([find(*around(load, contact)) for contact in contacts])
        errors[name] = 1000 * FEED * -(moments[1::2] - moments[::2])
    return Scatter(errors, 1000 * sigma[rows])


@dataclasses.dataclass
class Scatter:
    errors: dict  # um, of each pair, by how the contacts were found
    sigma: np.ndarray  # um, of each pair, reported by thermal_displacement


# --- thresholds on the same load ---


def around(load, contact):
    """The loads about a contact, over their mean before it, and the time of the first of them since the contact."""
    first = round((contact - WINDOW) / PERIOD)
    before = load[first : round((contact - 0.01) / PERIOD)]
    return load[first : round((contact + IN_WORK) / PERIOD)] - np.mean(before), first * PERIOD - contact


def crosses_middle(load, begins):
    """As in the source: the first sample at half the height of the usual step."""
    return begins + PERIOD * np.argmax(load >= STEP / 2)


def crosses_low(load, begins):
    """As before the fit: the smoothed load crosses 1 % between two samples, and is not below 0.5 % within 20 ms."""
    threshold, release, smoothing, debounce = 1, 0.5, 0.01, 0.02
    gain = 1 - np.exp(-PERIOD / smoothing)
    smooth = np.zeros(len(load))
    for i in range(1, len(load)):
        smooth[i] = smooth[i - 1] + gain * (load[i] - smooth[i - 1])
    lasts = round(debounce / PERIOD)
    for i in range(1, len(load)):
        if smooth[i - 1] < threshold <= smooth[i] and np.all(smooth[i : i + lasts] >= release):
            return begins + PERIOD * (i - (smooth[i] - threshold) / (smooth[i] - smooth[i - 1]))
    return np.nan


# --- the possible accuracy ---


def bound(case):
    """The least rms of a pair, in um, that an unbiased estimate can have: white noise, baseline and gain not known."""
    spacing = case.sample_time or PERIOD
    noise = np.hypot(NOISE, case.quantum / np.sqrt(12))
    variance = 0
    for step in (STEP, SOFTER * STEP):
        phases = (np.arange(100) + 0.5) / 100 * spacing
        information = 0
        for phase in phases:
            time = np.arange(-WINDOW + phase, WINDOW, spacing)
            e = np.where(time > 0, np.exp(-time / LAG), 0)
            by = np.stack([step / LAG * e, (time > 0) - e, np.ones_like(time)])  # moment, gain, baseline
            information += 1 / np.linalg.inv(by @ by.T)[0, 0] / noise**2 / len(phases)
        variance += 1 / information
    return 1000 * FEED * np.sqrt(variance)


# --- the command ---


def table(cases, scatters):
    heads = ("fit rms", "mean", "sigma", "limit", "bound", "middle rms", "mean", "low rms", "mean")
    lines = [f"{'Error of the displacement, um':30}" + "".join(f"{head:>12}" for head in heads)]
    for case, scatter in zip(cases, scatters):
        fit, middle, low = (scatter.errors[name] for name in (FIT, MIDDLE, LOW))
        limit = case.limit if np.isfinite(case.limit) else np.nan
        figures = (rms(fit), fit.mean(), rms(scatter.sigma), limit, np.nan if case.ripple else bound(case))
        figures += (rms(middle), middle.mean(), rms(low), low.mean())
        cells = ("" if np.isnan(figure) else f"{figure:.2f}" for figure in figures)
        lines.append(f"{case.name:30}" + "".join(f"{cell:>12}" for cell in cells))
    return lines


def main():
    parser = new_parser("pairs", __doc__)
    parser.add_argument("--pairs", type=whole(1, 100000), default=500, metavar="N", help="pairs of contacts in each case (default: 500)")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        tasks = [(case, options.pairs) for case in CASES]
        duration = len(tasks) * 2 * options.pairs * (CYCLE + 0.25)
        scatters = simulate_all(simulate, tasks, duration, place_of(options))
    print(f"{options.pairs} pairs of contacts each; step {STEP} %, {SOFTER:.0%} of it in the second; white noise {NOISE} %,")
    print(f"filter {1000 * LAG:.0f} ms, {60 * FEED:.0f} mm/min, {SPEED} rpm\n")
    print("\n".join(table(CASES, scatters)))
    missed = [case.name for case, scatter in zip(CASES, scatters) if rms(scatter.errors[FIT]) > case.limit]
    if missed:
        sys.exit("Beyond the limit: " + ", ".join(missed))


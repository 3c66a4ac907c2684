#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Reports what compensation would have done on a machine, from a recording of it. See plumb-contacts(1)."""

import argparse
import importlib.util
import os
import re
import sys

import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "python"))  # of a build
import plumb  # noqa: E402
import plumb_program  # noqa: E402
from plumb_folder import TemporaryFolder  # noqa: E402

SUMMARY = "reports the contacts of a recording, and whether to compensate"

# The columns of record.hal, and where replay.hal takes them.
COLUMNS = {
    "load": "growth.load",
    "z": "growth.z-position",
    "velocity": "growth.z-velocity-cmd",
    "speed": "growth.spindle-speed-cmd",
    "override": "growth.feed-override",
    "applied": "growth.applied-offset",
    "operation": "growth.operation",
    "motion": "growth.motion-type",
    "tool": "growth.tool-number",
    "running": "growth.cycle-running",
    "complete": "growth.cycle-complete",
    "learn": "learn.in0",
}
LEARN_TOO = "learn.in1"  # of replay.hal: learn from this cycle, whatever was recorded

RAPID, FEED = 1, 2  # LinuxCNC's motion.motion-type

BLANKED, FEED_DIFFERS, TOO_LARGE, BEYOND_GATE = 31, 34, 37, 38  # of detail-code

OUTPUTS = [
    "contacts",
    "contacts-accepted",
    "contacts-rejected",
    "contacts-unexpected",
    "contacts-missed",
    "detail-code",
    "contact-coordinate",
    "displacement",
    "displacement-sigma",
    "z-offset",
    "learning",
    "reference-valid",
    "fault",
]
SETTINGS = ["threshold", "release", "smoothing", "debounce", "blanking-time", "max-rate", "tolerance", "gate-floor"]
GROWTH_OVER_NOISE = 3  # how many times sigma and scatter growth must be for compensation to be worth it
LOOK = 0.01  # seconds from one look at the outputs to the next


class Unusable(RuntimeError):
    """A recording that says nothing."""


def unwired(recording):
    """The signals that are missing, by what the others say."""

    def constant(column):
        return np.ptp(getattr(recording, column)) == 0

    moves, feeds = bool(recording.velocity.any()), bool(recording.approaches)
    if constant("z") and moves:
        yield "Z is %g all the time although its command moves: net z-joint-fb to joint.2.motor-pos-fb" % recording.z[0]
    if not moves and not constant("z"):
        yield "the velocity of Z is 0 although Z moves: net z-velocity to joint.2.vel-cmd"
    if constant("motion") and moves:
        yield "the type of motion is %d although Z moves: net motion-type to motion.motion-type" % recording.motion[0]
    if not feeds:
        return
    if constant("load"):
        yield "the load is %g %% all the time: net spindle-load to the load of the drive" % recording.load[0]
    if constant("speed"):
        yield "the speed is %g all the time: net spindle-speed-cmd to spindle.0.speed-out" % recording.speed[0]
    if not recording.override.any():
        yield "the feed override is 0 although Z feeds: net feed-override to halui.feed-override.value"
    if not recording.tool.any():
        yield "the tool is 0 all the time: net tool-number to iocontrol.0.tool-number"


def complete_lines(file):
    """The last one may break off, where halsampler was killed."""
    with open(file) as lines:
        yield from (line for line in lines if line.endswith("\n"))


class Recording:
    """What record.hal has written: a column of numbers for each name in COLUMNS."""

    def __init__(self, file, period):
        self.file, self.period = file, period
        if os.path.exists(file) and not os.path.isfile(file):
            raise Unusable("%s is no regular file" % file)
        try:
            rows = np.loadtxt(complete_lines(file), ndmin=2)
        except ValueError as error:
            raise Unusable("%s: %s" % (file, self._complaint(error))) from None
        if rows.size == 0 or rows.shape[1] not in (len(COLUMNS), len(COLUMNS) + 1):
            raise Unusable(
                "%s: %d columns instead of the %d of record.hal, and the number of the sample"
                % (file, rows.shape[1] if rows.size else 0, len(COLUMNS))
            )
        if rows.shape[1] > len(COLUMNS):
            lost = np.flatnonzero(np.diff(rows[:, 0]) != 1)
            if len(lost):
                raise Unusable("%s: samples are missing after sample %d" % (file, rows[lost[0], 0]))
            rows = rows[:, 1:]
        for column, name in enumerate(COLUMNS):
            setattr(self, name, rows[:, column])
        self.operation = np.rint(self.operation).astype(int)
        self.tool = self.tool.astype(int)
        self.duration = len(rows) * period
        self.cycles = self._cycles()
        self.approaches = self._approaches()

    def _complaint(self, error):
        with open(self.file) as lines:
            if any(line.startswith("overrun") for line in lines):
                return "halsampler lost samples ('overrun'): record again, with a larger depth in record.hal"
        return "is no recording of record.hal: %s" % error

    def _cycles(self):
        running = np.concatenate(([0], self.running, [0])) > 0
        edges = np.flatnonzero(running[1:] != running[:-1])
        cycles = []
        for number, (begin, end) in enumerate(zip(edges[::2], edges[1::2]), 1):
            ended = end < len(self.running)
            complete = bool(ended and self.complete[end])
            cycles.append(Cycle(number, begin, end, ended, complete, bool(self.learn[begin])))
        return cycles

    def _approaches(self):
        """The descents to the work, each with its cycle and occurrence, as thermal_displacement counts them."""
        clear = (self.motion == RAPID) | (self.velocity > 0)
        towards = (self.motion == FEED) & (self.velocity < 0) & (self.operation != 0)
        approaches = []
        for cycle in self.cycles:
            counted = {}
            at = cycle.begin
            while True:
                found = np.flatnonzero(towards[at : cycle.end])
                if not len(found):
                    break
                begin = at + found[0]
                ends = np.flatnonzero(clear[begin : cycle.end])
                end = begin + (ends[0] if len(ends) else cycle.end - begin)
                fed = begin + np.flatnonzero(towards[begin:end])[-1] + 1  # a dwell at depth follows, without load
                key = (self.operation[begin], self.tool[begin])
                counted[key] = counted.get(key, 0) + 1
                approaches.append(Approach(self, cycle, begin, fed, *key, counted[key]))
                at = end
        return approaches


class Cycle:
    def __init__(self, number, begin, end, ended, complete, learn):
        self.number, self.begin, self.end = number, begin, end  # rows
        self.ended, self.complete, self.learn = ended, complete, learn


class Approach:
    """A descent, and the step of the load in it: where a step divides it best into two levels."""

    def __init__(self, recording, cycle, begin, end, operation, tool, occurrence):
        self.cycle, self.begin, self.end = cycle, begin, end
        self.operation, self.tool, self.occurrence = operation, tool, occurrence
        self.period = recording.period
        load = recording.load[begin:end]
        changed = np.flatnonzero(np.abs(np.diff(recording.speed[:begin])) > 1)
        self.speed_changed = changed[-1] + 1 if len(changed) else None
        settled = max(0, int(0.5 / self.period) - (begin - self.speed_changed)) if len(changed) else 0
        self.onset = None
        least = int(0.1 / self.period)
        if len(load) - settled < 3 * least:
            return
        count = np.arange(1, len(load) - settled)
        sums = np.cumsum(load[settled:])
        before, after = sums[:-1] / count, (sums[-1] - sums[:-1]) / (count[-1] + 1 - count)
        gain = count * (count[-1] + 1 - count) * (after - before) ** 2
        best = least + int(np.argmax(gain[least:-least]))
        self.onset = begin + settled + best
        self.air = slice(max(begin + settled, self.onset - int(1 / self.period)), self.onset - least // 2)
        self.cut = slice(self.onset + least, max(end, self.onset + 2 * least))
        self.noise = detrended(recording.load[self.air]).std()
        self.base = np.median(recording.load[self.air])
        self.rise = recording.load[self.cut].mean() - self.base

    def meets_work(self):
        return self.onset is not None and self.rise > 4 * self.noise

    def name(self):
        return "operation %d, tool %d" % (self.operation, self.tool)


def detrended(values):
    if len(values) < 3:
        return values - values.mean()
    time = np.linspace(-1, 1, len(values))
    return values - np.polyval(np.polyfit(time, values, 1), time)


def smoothed(values, time_constant, period):
    """What the component's filter makes of values."""
    if not time_constant:
        return values
    share = 1 - np.exp(-period / time_constant)
    result = np.empty(len(values))
    level = values[0]
    for i, value in enumerate(values):
        level += share * (value - level)
        result[i] = level
    return result


class Load:
    """What the recorded load is worth."""

    smoothings = (0, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)

    def __init__(self, recording, excluded):
        period = recording.period
        levels = np.unique(recording.load)
        self.quantum = np.diff(levels).min()
        changes = np.flatnonzero(np.diff(recording.load))
        self.interval = max(1, np.percentile(np.diff(changes), 10)) * period if len(changes) > 10 else np.inf
        self.met = [a for a in recording.approaches if a.meets_work() and a.operation not in excluded]
        if not self.met:
            raise Unusable(
                "in none of %d descents does the load rise; it lies between %g and %g %%"
                % (len(recording.approaches), recording.load.min(), recording.load.max())
            )
        airs = [recording.load[a.air] for a in self.met]
        self.noises = {
            tau: np.median([detrended(smoothed(air, tau, period)).std() for air in airs]) for tau in self.smoothings
        }
        self.noise = self.noises[0]
        self.rises = {}
        for approach in self.met:
            self.rises.setdefault(approach.name(), []).append(approach.rise)
        self.lightest = min(self.rises, key=lambda name: np.median(self.rises[name]))
        self.least = np.median(self.rises[self.lightest])
        self.largest = max(np.median(rises) for rises in self.rises.values())
        self.spread = max(np.ptp(rises) / np.mean(rises) for rises in self.rises.values())
        self.rise_time = self._rise_time(recording)
        self.settling = self._settling(recording)

    def _rise_time(self, recording):
        """From 10 to 90 % of the rise, in the mean over all contacts."""
        period, reach = recording.period, int(0.3 / recording.period)
        curves = []
        for a in self.met:
            if a.onset - reach >= 0 and a.onset + reach <= min(a.end, len(recording.load)):
                curves.append((recording.load[a.onset - reach : a.onset + reach] - a.base) / a.rise)
        if not curves:
            return np.nan
        curve = np.mean(curves, axis=0)
        above = np.flatnonzero(curve > 0.9)
        below = np.flatnonzero(curve[: above[0]] < 0.1) if len(above) else []
        return (above[0] - below[-1]) * period if len(below) else np.nan

    def _settling(self, recording):
        """The longest time for which a change of speed disturbs the load before a contact."""
        longest = 0
        window = max(1, int(0.02 / recording.period))
        for a in self.met:
            if a.speed_changed is None or any(a.speed_changed < b.begin < a.begin for b in recording.approaches):
                continue  # another cut lies between
            stretch = recording.load[a.speed_changed : a.air.stop]
            if len(stretch) <= window:
                continue
            mean = np.convolve(stretch, np.ones(window) / window, "valid")
            off = np.flatnonzero(np.abs(mean - a.base) > max(5 * self.noise / np.sqrt(window / 4), self.quantum))
            if len(off):
                longest = max(longest, (off[-1] + window) * recording.period)
        return longest

    def suggestions(self):
        """Settings and why."""
        quiet = [tau for share in (8, 3) for tau in self.smoothings if 5 * self.noises[tau] <= self.least / share]
        smoothing = quiet[0] if quiet else self.smoothings[-1]
        noise = self.noises[smoothing]
        wanted = max(5 * noise, self.least / 8, 1.5 * self.quantum)
        threshold = round_up(min(wanted, self.least / 3))
        debounce = max(0.02, 2 * self.interval)
        return [
            ("smoothing", smoothing, "leaves %.2g %% of noise" % noise),
            (
                "threshold",
                threshold,
                "%.1f times that noise, %.0f %% of the lightest cut" % (threshold / noise, 100 * threshold / self.least),
            ),
            ("release", threshold / 2, "half of it"),
            ("debounce", round_up(debounce), "longer than noise lasts, two values of the load at least"),
            ("blanking-time", round_up(self.settling + 0.2), "the load was disturbed for %.2g s" % self.settling),
        ]

    def warnings(self):
        step = self.quantum
        if step > self.least / 4:
            yield "The load comes in steps of %.3g %%, more than a quarter of the lightest cut: ask the drive for a finer value." % step
        if self.interval > 0.02:
            yield "The load changes every %.0f ms only: at 100 mm/min Z moves %.0f um meanwhile. Read it faster, or feed slower." % (
                self.interval * 1e3,
                self.interval * 100 / 60 * 1e3,
            )
        if self.rise_time > 0.25:
            yield "The load takes %.2f s to rise. Let the drive filter it less." % self.rise_time
        if 5 * self.noises[self.smoothings[-1]] > self.least / 3:
            yield "The load is too noisy for %s: no smoothing makes its rise of %.2g %% stand out. Exclude that operation." % (
                self.lightest,
                self.least,
            )


def round_up(value):
    """To two digits."""
    if value <= 0:
        return 0.0
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / step - 1e-9) * step)


class Replay:
    """What thermal_displacement makes of a recording."""

    def __init__(self, recording, files, settings):
        texts = plumb.declarations("thermal_displacement")["codes"]["detail-code"]
        self.rejections = {code: re.sub(r" \([^)]*\}\)", "", text) for code, text in texts.items()}  # without the values of one contact
        learnt = [c for c in recording.cycles if c.learn]
        self.chosen = None if learnt else next((c for c in recording.cycles if c.complete), None)
        with TemporaryFolder() as folder, plumb.Host() as host:
            for file in files:
                host.load(file)
            host.command("start")
            for name, value in list(settings) + [("dry-run", False), ("enable", True)]:
                host.set("growth." + name, value)
            self.settings = {name: host.get("growth." + name) for name in SETTINGS}
            self.excluded = [host.get("growth.exclude-operation-%d" % i) for i in range(4)]
            host.replay(recording.file, list(COLUMNS.values()), recording.period)
            outputs = os.path.join(folder, "outputs.csv")
            host.record(outputs, ["growth." + name for name in OUTPUTS], LOOK)
            done = 0
            if self.chosen:
                for row, value in ((self.chosen.begin - 1, True), (self.chosen.end + 2, False)):
                    done += host.run(max(0, row * recording.period - done)).ran
                    host.set(LEARN_TOO, value)
            host.run(recording.duration)
            table = np.loadtxt(outputs, delimiter=",", skiprows=1, converters=None, dtype=float, ndmin=2)
        self.time = table[:, 0]
        for column, name in enumerate(OUTPUTS, 1):
            setattr(self, name.replace("-", "_"), table[:, column])
        self.found = [self._contact(row, recording) for row in np.flatnonzero(np.diff(self.contacts)) + 1]

    def _contact(self, row, recording):
        contact = Contact()
        contact.time = self.time[row]
        contact.coordinate = self.contact_coordinate[row]
        contact.growth, contact.sigma = self.displacement[row], self.displacement_sigma[row]
        contact.learnt = bool(self.learning[row])
        contact.accepted = self.contacts_accepted[row] > self.contacts_accepted[row - 1]
        code = int(self.detail_code[row])
        refused = (self.contacts_rejected + self.contacts_unexpected)[[row - 1, row]]
        contact.code = code if refused[1] > refused[0] else 0
        contact.rejection = self.rejection(code)
        contact.compared = not contact.learnt and (contact.accepted or contact.code in (TOO_LARGE, BEYOND_GATE))
        # It is reported when it has been fitted, up to 0.75 s late: perhaps in the next descent, but not yet in its cut.
        at = contact.time / recording.period
        met = [a for a in recording.approaches if (a.begin if a.onset is None else a.onset) < at]
        contact.approach = met[-1] if met else None
        return contact

    def rejection(self, code):
        """Its sentence."""
        return self.rejections.get(code, "code %d" % code)

    def accepted(self):
        return sum(c.accepted and not c.learnt for c in self.found)

    def sigma(self):
        """The median, in um, of what was compared."""
        return 1e3 * np.median([c.sigma for c in self.found if c.compared] or [np.inf])

    def better_than(self, other):
        """No worse in accepted contacts and sigma, to 0.1 um, and better in one of them."""
        more = self.accepted() - other.accepted()
        finer = round(other.sigma(), 1) - round(self.sigma(), 1) if self.accepted() and other.accepted() else more
        return more >= 0 and finer >= 0 and (more > 0 or finer > 0)

    def offset_at(self, row, period):
        return self.z_offset[min(int(row * period / LOOK) + 1, len(self.z_offset) - 1)]


class Contact:
    def verdict(self):
        if self.code:
            return "rejected: " + self.rejection
        return "learned" if self.learnt else "accepted" if self.accepted else "seen"


def counted(number, thing):
    return "%d %s%s" % (number, thing, "" if number == 1 else "s")


def table(header, rows):
    widths = [max(len(row[i]) for row in [header] + rows) for i in range(len(header))]
    for row in [header] + rows:
        cells = [cell.rjust(width) for cell, width in zip(row[:-1], widths)]
        print("  " + "  ".join(cells + [row[-1]]).rstrip())


def show_recording(recording):
    print(
        "%s: %.1f s, %s, %s to the work"
        % (
            os.path.basename(recording.file),
            recording.duration,
            counted(len(recording.cycles), "cycle"),
            counted(len(recording.approaches), "descent"),
        )
    )


def show_load(load, recording):
    print("\nThe load")
    print("  new value every   %.3g ms, in steps of %.2g %%" % (load.interval * 1e3, load.quantum))
    print("  noise             %.2g %%, standard deviation as the tool feeds through air" % load.noise)
    for name, rises in load.rises.items():
        print("  rise of the cut   %.2g %% in %s, %d times" % (np.median(rises), name, len(rises)))
    print("  10 to 90 %% of it  in %.0f ms" % (load.rise_time * 1e3))
    print("  change of speed   disturbs it for %.2g s" % load.settling)


def show_suggestions(load, replay, tried):
    """tried is the replay with what is suggested."""
    print("\nOther settings, tried as well")
    for name, value, reason in load.suggestions():
        now = replay.settings[name]
        print("  setp growth.%-14s %-6.4g # %s; now %.4g" % (name, value, reason, now))
    print()
    rows = [[name, str(r.accepted()), "%.1f" % r.sigma()] for name, r in (("now", replay), ("these", tried))]
    for row in [["settings", "accepted", "median sigma, um"]] + rows:
        print("  %-8s  %8s  %s" % tuple(row))


def show_contacts(replay):
    print("\nContacts, in mm")
    rows = []
    for c in replay.found:
        a = c.approach
        keys = [a.cycle.number, a.operation, a.tool, a.occurrence] if a else ["-"] * 4
        growth = ["%+.4f" % c.growth, "%.4f" % c.sigma] if c.compared else ["", ""]
        cells = ["%.2f" % c.time] + [str(key) for key in keys] + ["%.4f" % c.coordinate] + growth
        rows.append(cells + [c.verdict()])
    table(["time", "cycle", "operation", "tool", "occurrence", "coordinate", "growth", "sigma", "verdict"], rows)


def show_cycles(recording, replay):
    print("\nCycles: the offset that compensation would have applied with dry-run 0, in mm")
    rows = []
    for cycle in recording.cycles:
        begin, end = (replay.offset_at(row, recording.period) for row in (cycle.begin, cycle.end))
        recorded = recording.applied[min(cycle.end, len(recording.applied) - 1)]
        inside = [c for c in replay.found if c.approach and c.approach.cycle is cycle]
        accepted = sum(c.accepted and not c.learnt for c in inside)
        kind = "" if cycle.complete else "not complete"
        if cycle.learn:
            kind = "learned from"
        elif cycle is replay.chosen:
            kind = "taken as learned by this report"
        rows.append(
            [
                str(cycle.number),
                "%.2f" % (cycle.begin * recording.period),
                "%d" % len(inside),
                "%d" % accepted,
                "%+.4f" % begin,
                "%+.4f" % end,
                "%+.4f" % recorded,
                kind,
            ]
        )
    table(["cycle", "from", "contacts", "accepted", "at its start", "at its end", "recorded", ""], rows)


def show_summary(replay):
    refused = {}
    for contact in replay.found:
        if contact.code:
            refused[contact.code] = refused.get(contact.code, 0) + 1
    learnt = sum(c.learnt for c in replay.found)
    print("\nContacts: %d learned, %d accepted, %d missed" % (learnt, replay.accepted(), replay.contacts_missed[-1]))
    for code in sorted(refused):
        print("  %d rejected: %s" % (refused[code], replay.rejection(code)))
    print("Largest offset %+.4f mm" % replay.z_offset[np.argmax(abs(replay.z_offset))])


def show_judgement(replay):
    print("\nWorth it, in um")
    print("  growth seen       %5.1f  from cycle to cycle" % growth_of(replay))
    print("  median sigma      %5.1f  of a contact, by the load" % replay.sigma())
    print("  scatter           %5.1f  of the contacts within a cycle" % scatter_of(replay))
    print("  growth must be %d times both at least" % GROWTH_OVER_NOISE)


def problems(recording, replay, load):
    """What hinders compensation, and what to do about it."""
    open_cycles = [c.number for c in recording.cycles if not c.complete]
    if open_cycles:
        yield "Not complete: cycle %s. Either it was aborted, or the program does not set M64 P1 before M65 P0." % (
            ", ".join(map(str, open_cycles))
        )
    if replay.chosen and not recording.applied.any():
        yield "No cycle asked to be learned from: run learn.ngc, or press the button, before the first part. Cycle %d was taken." % (
            replay.chosen.number
        )
    threshold = replay.settings["threshold"]
    if load.largest < threshold:
        yield "No rise reaches the threshold of %.3g %%; the largest is %.2g %%: is the load in percent of the rating?" % (
            threshold,
            load.largest,
        )
    elif not any(c.complete and (c.learn or c is replay.chosen) for c in recording.cycles):
        yield "Nothing was learned: a cycle that is complete, on a settled machine, must come first."
    elif not any(c.learnt for c in replay.found):
        yield "Nothing was learned: the rises of the load were no contacts. See debounce, smoothing and exclude-operation."
    yield from load.warnings()
    codes = [c.code for c in replay.found]
    if codes.count(BLANKED):
        yield "Contacts come too soon after a change of speed: let the spindle settle (G4), or shorten blanking-time."
    if codes.count(FEED_DIFFERS):
        yield "The feed at a contact was not that of the reference: no override while the tool comes down."
    if codes.count(BEYOND_GATE) + codes.count(TOO_LARGE) > len(codes) / 10:
        yield "Many contacts were beyond the gate: machine a part more often, or see whether blanks are alike."
    if replay.contacts_missed[-1]:
        yield "Contacts of the reference did not come: a threshold that is too high, or an operation to be excluded."
    growth = growth_of(replay)
    for name, found in by_operation(replay).items():
        sigma = 1e3 * np.median([c.sigma for c in found])
        if sigma * GROWTH_OVER_NOISE > growth:
            yield "The load leaves %s uncertain by %.1f um, of %.1f um that were seen to grow: a finer or quicker load, a wider tool, or exclude it." % (
                name,
                sigma,
                growth,
            )
    scatter = scatter_of(replay)
    if scatter * GROWTH_OVER_NOISE > growth:
        yield "Contacts within a cycle scatter by %.1f um, of %.1f um that were seen to grow: blanks, seats of the tools, or chips? Or record until the machine is warm." % (
            scatter,
            growth,
        )
    for fault in sorted(set(replay.detail_code[replay.fault > 0].astype(int))):
        yield "thermal_displacement had a fault: %s" % replay.rejection(fault)


def by_operation(replay):
    """The contacts that were compared, by the name of their operation."""
    groups = {}
    for contact in replay.found:
        if contact.compared and contact.approach:
            groups.setdefault(contact.approach.name(), []).append(contact)
    return groups


def accepted_growth(replay):
    """In um, cycle by cycle."""
    groups = {}
    for contact in replay.found:
        if contact.accepted and not contact.learnt and contact.approach:
            groups.setdefault(contact.approach.cycle.number, []).append(1e3 * contact.growth)
    return list(groups.values())


def growth_of(replay):
    """The span of the means of all cycles and of the reference, which is 0, in um."""
    return np.ptp([0] + [np.mean(cycle) for cycle in accepted_growth(replay)])


def scatter_of(replay):
    """Standard deviation of the growth among the accepted contacts of a cycle, in um."""
    cycles = accepted_growth(replay)
    freedom = sum(len(cycle) - 1 for cycle in cycles)
    squares = sum(np.square(cycle - np.mean(cycle)).sum() for cycle in cycles)
    return np.sqrt(squares / freedom) if freedom else 0.0


def draw(file, recording, replay):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (loads, offsets) = pyplot.subplots(2, 1, sharex=True, figsize=(10, 7))
    time = np.arange(len(recording.load)) * recording.period
    thin = max(1, len(time) // 20000)
    loads.plot(time[::thin], recording.load[::thin], linewidth=0.5, color="grey")
    loads.set_ylabel("load, %")
    loads.set_ylim(*np.percentile(recording.load, [0.1, 95]) + np.array([-2, 10]))
    offsets.plot(replay.time, replay.z_offset * 1e3, label="offset that would have been applied")
    for accepted, mark, label in ((True, "o", "contact, accepted"), (False, "x", "contact, rejected")):
        shown = [c for c in replay.found if c.compared and c.accepted == accepted]
        if shown:
            growth = [c.growth * 1e3 for c in shown]
            offsets.errorbar([c.time for c in shown], growth, [c.sigma * 1e3 for c in shown], fmt=mark, label=label)
    offsets.set_ylabel("growth, µm")
    offsets.set_xlabel("time, s")
    offsets.legend()
    figure.tight_layout()
    save(figure, os.path.realpath(file))


def save(figure, file):
    """The whole chart, or the one of before."""
    if os.path.exists(file) and not os.path.isfile(file):  # a device
        figure.savefig(file)
        return
    fresh = os.path.join(os.path.dirname(file), ".%d-%s" % (os.getpid(), os.path.basename(file)))
    try:
        figure.savefig(fresh)
        os.replace(fresh, file)
    except OSError:
        if os.path.lexists(fresh):
            os.unlink(fresh)
        raise


def setting(text):
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError("'%s' is not NAME=VALUE" % text)
    return name, float(value)


def main():
    parser = argparse.ArgumentParser(prog="plumb contacts", description=SUMMARY)
    parser.add_argument("recording", metavar="load.txt", help="file that record.hal has written")
    parser.add_argument("--configuration", default=".", metavar="DIR",
                        help="folder of settings.hal and replay.hal (default: the current folder)")
    parser.add_argument("--settings", metavar="FILE.hal", help="settings instead of settings.hal")
    parser.add_argument("--set", type=setting, action="append", default=[], metavar="NAME=VALUE",
                        help="another value of a setting; may be given many times")
    parser.add_argument("--period", type=float, default=0.001, metavar="S", help="period of the servo thread, in s")
    parser.add_argument("--chart", metavar="FILE.png", help="draws the contacts")
    parser.add_argument("--summary", action="version", version=SUMMARY, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    try:
        if arguments.chart and importlib.util.find_spec("matplotlib") is None:
            raise Unusable("--chart needs python3-matplotlib: sudo apt install python3-matplotlib")
        recording = Recording(arguments.recording, arguments.period)
        show_recording(recording)
        missing = list(unwired(recording))
        if missing:
            raise Unusable("not wired:\n  - " + "\n  - ".join(missing))
        if not recording.cycles:
            raise Unusable("cycle-running is never true: the program must set M64 P0 at the start of a cycle")
        if not recording.approaches:
            raise Unusable("Z never feeds down in an operation: the program must name it by M68 E0")
        settings = arguments.settings or os.path.join(arguments.configuration, "settings.hal")
        files = [os.path.join(arguments.configuration, "replay.hal"), settings]
        replay = Replay(recording, files, arguments.set)
        load = Load(recording, replay.excluded)
    except (Unusable, plumb.Refused, OSError) as error:
        print("plumb contacts: %s" % error, file=sys.stderr)
        return 2
    show_load(load, recording)
    fraction = load.largest < replay.settings["threshold"] and recording.load.max() < 2
    suggested = [] if fraction else [(name, value) for name, value, _ in load.suggestions()]
    tried = None
    if any(replay.settings[name] != value for name, value in suggested):
        tried = Replay(recording, files, arguments.set + suggested)
        show_suggestions(load, replay, tried)
    show_contacts(replay)
    show_cycles(recording, replay)
    show_summary(replay)
    if replay.accepted():
        show_judgement(replay)
    print("\nNext")
    found = list(problems(recording, replay, load))
    for problem in found:
        print("  - " + problem)
    if tried and tried.better_than(replay):
        print("  - Take the other settings over, and replay again: they do better.")
    elif tried:
        print("  - Keep the settings that you have: the others do no better.")
    if not found and replay.accepted():
        print("  - Nothing hinders compensation: let the machine run with it.")
    elif not found:
        print("  - Record more parts: nothing was compared yet.")
    if arguments.chart:
        draw(arguments.chart, recording, replay)
    return 0 if replay.accepted() and not found else 1


if __name__ == "__main__":
    plumb_program.run("plumb contacts", main)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Thousands of cycles, each upset by something: is a contact accepted beyond the gate, and do all counts agree?

Each drawn machine makes a part a minute; every cycle but those that are learned from has an event, of any kind. Where
an edited program has no reference, the next cycle is learned from, as an operator would
have it. The truth pins of the mill and the program show for each approach whether the tool met the work; from that
and the reference follow the right verdict on each contact, and the right value of every counter. Lengths are in um,
times in s.
"""

import collections
import dataclasses
import functools
import os

import numpy as np

from support.mill_events import event_names
from support.mill_machine import every_end_mill_is_a_gauge, start_mill
from support.recordings import read_columns
from support.simulations import simulate_all

EVERY = 0.1  # s between two rows of a recording; contacts are seconds apart
INTERVAL = 60  # s from one cycle to the next
MACHINE_CYCLES = 100  # of each machine
DRILLS = (20,)  # operations that thermal_displacement leaves out
BLANKING = 2.5  # s after a change of spindle speed, as thermal_displacement has it
SEEING = 0.3  # s of feed into the work; with less no rise of the load is clear of noise
REPORTING = 0.6  # s until it reports a contact; a cycle that ends meanwhile takes it away
UNKNOWN = "for no known reason"
MOST_UNKNOWN = 0.001  # of the contacts that were met
EDITED = 11  # the event; a program that has been edited stays so, but that is no event any more

# Of detail-code
REFUSED_LEARNING = (14, 15)  # a poor load, and contacts that disagree
PROGRAMS = 8  # that have references
UNEXPECTED = 33  # of a contact that is counted as unexpected, and not as rejected
BLANKED = 31
BEFORE_PAIRING = (31, 39, 40)  # a contact that is rejected so may have no partner as well
HIDING = range(1, 30)  # a fault, a learning that failed, a refusal: the reason of a rejection is not seen

NUMBERS = {
    "cycle": "program.cycle",
    "running": "program.cycle-running",
    "complete": "program.cycle-complete",
    "learn": "program.learn",
    "program": "program.program-id",
    "operation": "program.operation",
    "occurrence": "program.truth-occurrence",
    "speed": "program.spindle-speed-cmd",
    "feeding": "program.z-velocity-cmd",
    "event": "program.truth-event",
    "chip": "program.chip-height",
    "from_side": "program.from-side",
    "met": "mill.truth-contacts",
    "found": "growth.contacts",
    "accepted": "growth.contacts-accepted",
    "rejected": "growth.contacts-rejected",
    "unexpected": "growth.contacts-unexpected",
    "missed": "growth.contacts-missed",
    "code": "growth.detail-code",
    "refused": "growth.reference-refused",
    "failed": "growth.learning-failed",
    "rows": "growth.rows",
}
LENGTHS = {
    "growth": "mill.truth-growth",
    "offset": "mill.applied-offset",
    "estimate": "growth.growth-estimate",
    "sigma": "growth.displacement-sigma",
    "gate": "growth.gate",
}
COUNTS = ("met", "found", "accepted", "rejected", "unexpected", "missed")


@dataclasses.dataclass
class Approach:
    """One way of a tool down to the work, in an operation that is looked at."""

    cycle: int
    key: tuple  # operation and occurrence
    event: int = 0  # under way; 0 for none
    learning: bool = False
    met: bool = False  # the tool met the work, or a chip on it
    met_at: float = np.nan  # s
    unseen: str = ""  # why a contact was not found; UNKNOWN for example when it was lost in the noise
    found: int = 0  # contacts that thermal_displacement found
    verdict: str = ""  # on the last one: learnt, accepted, rejected, unexpected
    code: int = 0  # of a rejection
    error: float = 0  # of the growth that is applied, when it was accepted: it minus the true growth
    excess: float = -np.inf  # by how much more than gate + 3 sigma the correction went wrong


@dataclasses.dataclass
class Outcome:
    """The result of one machine."""

    approaches: list
    cycles: int
    learnt: int  # cycles that gave a reference
    complaints: list  # of counters that do not agree with the truth


@functools.cache
def rejections():
    """The sentence of each detail-code."""
    import plumb

    return plumb.declarations("thermal_displacement")["codes"]["detail-code"]


def judge(recording):
    """The Outcome in a recording, a dictionary of columns: each approach, and all that does not add up."""
    return Ledger(recording).outcome()


class Ledger:
    def __init__(self, recording):
        self._recording = recording
        self._approaches = {}  # by cycle and key
        self._complaints = []
        self._growth = {}  # at the contacts of each program's reference, by key: where the growth counts from
        self._rows = {}  # references of each program, the one first that has not run for the longest time
        self._draft = {}  # ... of the cycle that is being learned from
        self._learnt = 0
        self._blanked = 0  # contacts before another one in their approach
        self._dropped = 0  # contacts of the reference that were not learned
        self._speed_changed = -np.inf  # s
        self._meetings = 0  # of tools with the work

    def outcome(self):
        columns = self._recording
        changes = np.zeros(len(columns["cycle"]), bool)
        for name in (*COUNTS, "running", "cycle", "operation", "chip", "speed", "feeding"):
            changes[1:] |= np.diff(columns[name]) != 0
        before = self._row(0)
        for i in np.flatnonzero(changes):
            now = self._row(i)
            now["before"] = self._row(i - 1)  # the period of the change has overwritten it
            self._step(now, before)
            before = now
        for name in ("met", "found", "accepted", "rejected", "unexpected"):
            if any(np.diff(columns[name]) > 1):
                self._complain(before, f"two {name} within {EVERY} s")
        last = self._row(-1)
        if self._meetings != last["met"]:
            self._complain(last, f"{last['met']:.0f} contacts with the work in {self._meetings} approaches")
        verdicts = collections.Counter(a.verdict for a in self._approaches.values())
        verdicts["rejected"] += self._blanked
        for name in ("accepted", "rejected", "unexpected"):
            if verdicts[name] != last[name]:
                self._complain(last, f"{last[name]:.0f} {name}, of which {verdicts[name]} are accounted for")
        return Outcome(list(self._approaches.values()), int(last["cycle"]), self._learnt, self._complaints)

    def _row(self, i):
        return {name: column[i] for name, column in self._recording.items()}

    def _complain(self, now, what):
        self._complaints.append(f"cycle {now['cycle']:.0f}, operation {now['operation']:.0f}: {what}")

    def _approach(self, now):
        key = int(now["operation"]), int(now["occurrence"])
        approach = self._approaches.setdefault((now["cycle"], key), Approach(int(now["cycle"]), key))
        event = int(now["event"])
        approach.event = approach.event or (0 if event == EDITED and now["program"] in self._growth else event)
        approach.learning = bool(now["learn"])
        return approach

    def _step(self, now, before):
        if now["speed"] != before["speed"]:
            self._speed_changed = now["time"]
        self._meetings += now["met"] > before["met"]
        ends = before["running"] and not now["running"]
        task = before if ends else now  # a contact found in the row of the end belongs to the cycle
        looked_at = task["operation"] not in (0, *DRILLS)
        if looked_at and task["running"]:
            approach = self._approach(task)
            on_chip = now["chip"] > 0 and not now["from_side"]
            approach.met = approach.met or now["met"] > before["met"] or on_chip
            if now["met"] > before["met"]:
                approach.met_at = now["time"]
                if not approach.found:
                    approach.unseen = "blanked" if now["time"] - self._speed_changed < BLANKING else UNKNOWN
            if before["feeding"] and not now["feeding"]:
                self._end_feed(approach, now)
            if now["found"] > before["found"]:
                self._find(approach, now, before)
        elif now["found"] > before["found"]:
            self._complain(now, "a contact where none is looked for")
        if ends:
            self._end(now)
        if now["running"] and not before["running"]:
            self._begin(now)

    def _begin(self, now):
        self._draft = {}
        refused = bool(self._growth) and not now["learn"] and now["program"] not in self._growth
        if now["program"] in self._rows:
            self._rows[now["program"]] = self._rows.pop(now["program"])
        if refused != bool(now["refused"]):
            self._complain(now, "the reference is refused" if now["refused"] else "the reference is not refused")

    def _find(self, approach, now, before):
        approach.found += 1
        approach.unseen = ""
        if approach.found > 1 and approach.code not in (BLANKED, *HIDING):  # after a pulse of the spindle another may come
            self._complain(now, "a second contact in one approach")
        self._blanked += approach.found > 1
        rises = [name for name in ("accepted", "rejected", "unexpected") if now[name] > before[name]]
        approach.verdict = rises[0] if rises else "learnt"
        approach.code = int(now["code"]) if approach.verdict == "rejected" else 0
        if len(rises) > 1:
            self._complain(now, "one contact, counted twice")
        if (approach.verdict == "learnt") and not now["learn"]:
            self._complain(now, "a contact that is counted nowhere")
        if now["learn"]:
            if approach.verdict == "learnt":
                self._draft[approach.key] = now["growth"]
            return
        if now["refused"] and approach.verdict != "rejected":
            self._complain(now, f"{approach.verdict} though the reference is refused")
        judged_before = approach.code in (*BEFORE_PAIRING, *HIDING)
        reference = self._growth.get(now["program"], {})
        expected = approach.key not in reference and not judged_before
        dropped = self._dropped > 0 and approach.verdict == "unexpected"
        if not now["refused"] and not dropped and (approach.verdict == "unexpected") != expected:
            self._complain(now, f"{approach.verdict}, which contradicts the reference")
        if approach.verdict == "rejected" and approach.code not in set(rejections()) - {UNEXPECTED}:
            self._complain(now, f"rejected by a code without a name, {approach.code}")
        if approach.verdict == "accepted":
            growth = now["growth"] - reference.get(approach.key, np.nan)
            approach.error = now["estimate"] - growth
            worse = abs(approach.error) - abs(now["before"]["offset"] - growth)
            approach.excess = worse - now["before"]["gate"] - 3 * now["sigma"]
            if np.isnan(growth) or not approach.met:  # a correction from nothing is as wrong as can be
                approach.excess = np.inf

    def _end_feed(self, approach, now):
        if approach.unseen == UNKNOWN and now["time"] - approach.met_at < SEEING:
            approach.unseen = "the feed ended"

    # A complete cycle has missed the contacts of the reference that were not found; of others it is unknown.
    def _end(self, now):
        approaches = [approach for (n, _), approach in self._approaches.items() if n == now["cycle"]]
        for approach in approaches:
            self._end_feed(approach, now)
            if approach.unseen == UNKNOWN and now["time"] - approach.met_at < REPORTING:
                approach.unseen = "the cycle ended"
        found = {approach.key for approach in approaches if approach.found}
        compared = now["complete"] and not now["learn"] and not now["before"]["refused"]
        expected = len(set(self._growth.get(now["program"], {})) - found) if compared else 0
        missed = now["missed"] - now["before"]["missed"]
        if not expected - self._dropped <= missed <= expected:
            self._complain(now, f"{missed:.0f} contacts missed, not {expected}")
        if not now["learn"]:
            return
        if now["failed"] and now["code"] in REFUSED_LEARNING:
            return  # the load decides this, and not the program
        if bool(now["failed"]) != (not now["complete"] or not self._draft):
            self._complain(now, "learning failed" if now["failed"] else "learning did not fail")
        if not now["failed"]:
            self._learnt += 1
            program, first = now["program"], next(iter(self._growth.values()), None)
            # Later references are less by the growth that is known: they count from where the first one does.
            self._growth[program] = self._draft if first is None else dict.fromkeys(self._draft, np.mean(list(first.values())))
            self._rows.pop(program, None)
            if len(self._rows) == PROGRAMS:
                self._growth.pop(next(iter(self._rows)))
                self._rows.pop(next(iter(self._rows)))
            rows = now["rows"] - sum(self._rows.values())
            self._rows[program] = rows
            self._dropped = len(self._draft) - rows  # too poor to be learned, which the recording does not show
            if self._dropped < 0:
                self._complain(now, f"{rows:.0f} references of {len(self._draft)} contacts learned")


def simulate(seed, cycles, progress):
    """The Outcome of one machine."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host() as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        host.command("net refused growth.reference-refused => program.relearn")
        every_end_mill_is_a_gauge(host)
        host.set("program.cycle-interval", INTERVAL)
        host.set("program.event-rate", 1)
        host.record(path, [*NUMBERS.values(), *LENGTHS.values()], EVERY)
        host.run(cycles * INTERVAL, progress)
        column = read_columns(path)
    recording = {name: column[pin] for name, pin in NUMBERS.items()}
    recording.update((name, 1000 * column[pin]) for name, pin in LENGTHS.items())
    recording["feeding"] = recording["feeding"] < 0
    recording["time"] = column["time"]
    return judge(recording)


def run_cycles(cycles, place=None):
    """An Outcome for each hundred cycles."""
    machines = -(-cycles // MACHINE_CYCLES)
    tasks = [(seed, min(MACHINE_CYCLES, cycles - MACHINE_CYCLES * (seed - 1))) for seed in range(1, machines + 1)]
    return simulate_all(simulate, tasks, cycles * INTERVAL, place)


def wrong(approaches):
    return [a for a in approaches if a.verdict == "accepted" and a.excess > 0]


def table(outcomes):
    """Its lines: the verdicts on the approaches under each event."""
    names = event_names()
    groups = collections.defaultdict(list)
    for outcome in outcomes:
        for approach in outcome.approaches:
            groups[approach.event].append(approach)
    seen = {approach.code for outcome in outcomes for approach in outcome.approaches}
    sentences = {code: sentence for code, sentence in rejections().items() if code in seen}
    heads = ["approaches", "met", "unseen", "phantom", "learnt", "accepted", "wrong", "unexpected"]
    heads += [f"code {code}" for code in sentences]
    width = 2 + max(map(len, names.values()))
    lines = [f"{'event':{width}}" + "".join(f"{head:>11}" for head in heads)]
    for event, approaches in sorted(groups.items()):
        verdicts = collections.Counter(a.verdict for a in approaches)
        codes = collections.Counter(a.code for a in approaches)
        figures = [
            len(approaches),
            sum(a.met for a in approaches),
            sum(a.met and not a.found for a in approaches),
            sum(a.found and not a.met for a in approaches),
            verdicts["learnt"],
            verdicts["accepted"],
            len(wrong(approaches)),
            verdicts["unexpected"],
            *(codes[code] for code in sentences),
        ]
        lines.append(f"{names[event]:{width}}" + "".join(f"{n:11}" for n in figures))
    return lines + [""] + [f"Rejected, code {code}: {sentence}" for code, sentence in sentences.items()]


def report(cycles, place):
    """Runs so many cycles and prints their outcome; False if anything was wrong, lost or did not add up."""
    outcomes = run_cycles(cycles, place)
    print(f"{sum(o.cycles for o in outcomes)} cycles of {len(outcomes)} machines, each upset by something but those ", end="")
    print(f"that were learned from; references: {sum(o.learnt for o in outcomes)}\n")
    print("\n".join(table(outcomes)))
    complaints = [f"machine {seed}, {c}" for seed, o in enumerate(outcomes, 1) for c in o.complaints]
    unseen = collections.Counter(a.unseen for o in outcomes for a in o.approaches if a.unseen)
    print("\nMet and not seen: " + (", ".join(f"{reason} {n}" for reason, n in sorted(unseen.items())) or "none"))
    corrections = sum(len(wrong(o.approaches)) for o in outcomes)
    print(f"Wrong corrections: {corrections}.  Counts that do not agree with the truth: {len(complaints)}")
    for complaint in complaints[:20]:
        print("  " + complaint)
    met = sum(a.met for o in outcomes for a in o.approaches)
    return not corrections and not complaints and unseen[UNKNOWN] <= MOST_UNKNOWN * met

# SPDX-License-Identifier: GPL-2.0-or-later
"""Events of the load around a contact, on the mill of configs/mill/bench.hal: coolant, a dip, a resonance.

Coolant comes on at a height above the work, and has its load through the filter of the drive. In a dip it is off for a while. The
program gives the height of an event. The tool of a warm machine meets the work earlier: then an event is nearer to the contact
than in the learning cycle.
"""

import collections
import dataclasses

import numpy as np

from support.contacts import error_of
from support.figures import largest
from support.rivals import SIMPLE

FEED = 2.0  # mm/s, of the approach on every machine
GAIN = 30.0  # 1/s, of the position loop: it lags behind its command by feed / gain
CYCLE = 300  # s from the start of a part to the next one
LEARN = 250  # s from the start to the end of the first cycle, which is learned from
OFF, ALWAYS = -1000.0, 1000.0  # mm above the work


@dataclasses.dataclass(frozen=True)
class LoadEvent:
    """`size`: % of load; `ends`: s before the contact at which it stands for good; `lasts`: s, of a dip. A resonance has a size of 0."""

    name: str
    size: float = 0
    ends: float = 0
    lasts: float = 0
    in_learning: bool = False
    later: bool = False
    resonance: bool = False

    def prepare(self, host):
        """Between the program and the drive; a resonance behind the drive. Nothing happens yet."""
        host.set("program.contact-feed", FEED)
        host.set("growth.exclude-operation-2", 30)  # comes down beside the work
        host.set("mill.servo-gain", GAIN)
        host.command("delf drive.update servo-thread")
        host.command("delf growth.update servo-thread")
        for line in EVENT_LINES:
            host.command(line)
        host.set("height.gain1", -1)
        host.set("coolant-comes.in1", self.lasts > 0)  # it is on, and is off in the dip
        host.set("drive.coolant-load", self.size)
        host.set("ringing.type", 1)  # a low pass
        host.set("ringing.f0", 25)
        host.set("ringing.Q", 1.5)
        self.happen(host, False)

    def happen(self, host, happens):
        """From now on it comes in each plunge, or in none."""
        above = FEED * (self.ends - 1 / GAIN)  # of the command, when the tool is `ends` before the work
        host.set("is-near.max", (above if self.lasts == 0 else above + FEED * self.lasts) if happens and self.size else OFF)
        host.set("is-near.min", 2 * OFF if self.lasts == 0 else above)
        host.set("ringing.enable", happens and self.resonance)

    def run(self, host, duration, progress):
        """The first cycle, repeated until a reference is learned, then the others."""
        self.happen(host, self.in_learning)
        host.run(LEARN)
        if self.in_learning and not self.later:
            self.happen(host, False)
        while not host.get("growth.rows") and host.time < min(duration, LEARN + 4 * CYCLE) - CYCLE:
            host.run(CYCLE)
        if self.later:
            self.happen(host, True)
        while host.time < duration and progress(host.time):
            host.run(min(2 * CYCLE, duration - host.time))


EVENT_LINES = (
    "loadrt sum2 names=height", "loadrt wcomp names=is-near", "loadrt xor2 names=coolant-comes", "loadrt biquad names=ringing",
    "net z-position-cmd => height.in0", "net work-top => height.in1", "net height height.out => is-near.in",
    "net near is-near.out => coolant-comes.in0", "unlinkp drive.coolant", "net coolant-comes coolant-comes.out => drive.coolant",
    "unlinkp growth.load", "net load => ringing.in", "net ringing ringing.out => growth.load",
    "addf height servo-thread", "addf is-near servo-thread", "addf coolant-comes servo-thread", "addf drive.update servo-thread",
    "addf ringing servo-thread", "addf growth.update servo-thread",
)  # fmt: skip


def coolant(size, before, **when):
    cycles = "learning and later" if len(when) == 2 else "learning" if "in_learning" in when else "later"
    return LoadEvent(f"coolant {size} %, {1000 * before:.0f} ms before, {cycles}", size, before, **when)


def dip(size, before, **when):
    cycles = "learning" if "in_learning" in when else "later"
    return LoadEvent(f"dip {size} %, ends {1000 * before:.0f} ms before, {cycles}", size, before, 0.1, **when)


NONE = LoadEvent("none")
EVENTS = (
    NONE,
    *(coolant(2, before, in_learning=True) for before in (0.01, 0.02, 0.06, 0.09)),
    *(coolant(4, before, in_learning=True) for before in (0.01, 0.02, 0.06)),
    *(coolant(6, before, in_learning=True) for before in (0.02, 0.06)),
    *(coolant(size, before, later=True) for size, before in ((4, 0.01), (6, 0.01), (2, 0.06), (6, 0.06))),
    *(coolant(size, 0.06, in_learning=True, later=True) for size in (2, 6)),
    *(dip(4, before, in_learning=True) for before in (0.02, 0.05)),
    dip(4, 0.02, later=True),
    LoadEvent("resonance, later", later=True, resonance=True),
)


def event_named(name):
    return next(event for event in EVENTS if event.name == name)


@dataclasses.dataclass
class Outcome:
    """Of one machine. `cuts`: of the tools whose contacts count, as contacts.CUT."""

    cuts: np.ndarray
    learnt: int  # the last cycle that was to be learned from
    refused: bool  # nothing was learned from the first cycle, and the component reported it
    contacts: int  # after learning
    rejections: dict  # code -> number, of these contacts
    reference_sigma: float  # um


def judge(column, cuts):
    """The Outcome of a recording whose cuts these are."""
    time = column["time"]
    refused = np.any(column["growth.learning-failed"][time < LEARN + CYCLE - 1] > 0)
    learning = np.flatnonzero(column["program.learn"])
    since = learning[-1] if len(learning) else 0
    rejected = np.diff(column["growth.contacts-rejected"][since:])
    codes = column["growth.detail-code"][since + 1 :]
    found = {int(code): int(rejected[codes == code].sum()) for code in np.unique(codes[rejected > 0])}
    contacts = int(column["growth.contacts"][-1] - column["growth.contacts"][since])
    counted = cuts["gauge"]
    return Outcome(cuts[counted], int(column["program.cycle"][since]), bool(refused), contacts, found,
                   1000 * column["growth.reference-sigma"][-1])  # fmt: skip


def caused(machine, healthy):
    """um by which the event changed the error of each silent cut: `healthy` is the same machine without the event."""
    if machine.learnt != healthy.learnt or len(machine.cuts) != len(healthy.cuts):
        return np.empty(0)  # another reference: the operator knows
    silent = ~machine.cuts["announced"]
    return abs(machine.cuts["error"] - healthy.cuts["error"])[silent]


WAYS = ("with", "none", *SIMPLE)
HEAD = f"{'first cycle':>15}{'error of all cuts, median and worst':>{15 * len(WAYS)}}{'silent':>8}{'caused in silent cuts':>23}{'within':>9}{'rejected':>10}"
UNITS = f"{'refused':>15}{''.join(f'{way:>15}' for way in WAYS)}{'':>8}{'median':>14}{'worst':>9}{'2 sigma':>9}{'contacts':>10}"


def table(events, outcomes):
    """Its lines. outcomes: a list of Outcomes of the same machines for each event, of which the first is NONE."""
    width = max(len(event.name) for event in events)
    lines = [f"{'um':{width}}{HEAD}", f"{'':{width}}{UNITS}  codes"]
    for event, machines in zip(events, outcomes):
        cuts = np.concatenate([machine.cuts for machine in machines])
        contacts = sum(machine.contacts for machine in machines)
        rejections = collections.Counter()
        for machine in machines:
            rejections.update(machine.rejections)
        differ = np.concatenate([caused(*pair) for pair in zip(machines, outcomes[0])])
        known = cuts[cuts["known"]]
        errors = [abs(its) for its in (cuts["error"], cuts["error"] - cuts["offset"], *(error_of(cuts, way) for way in SIMPLE))]
        cells = [f"{sum(machine.refused for machine in machines)} of {len(machines)}".rjust(15)]
        cells += [f"{middle(its):8.1f}{largest(its):7.1f}" for its in errors]
        cells += [f"{np.mean(~cuts['announced']):8.0%}" if len(cuts) else f"{'-':>8}"]
        cells += [f"{middle(differ):14.1f}{largest(differ):9.1f}", f"{np.mean(abs(known['error']) <= 2 * known['sigma']) if len(known) else np.nan:9.0%}"]
        cells += [f"{sum(rejections.values()) / max(contacts, 1):10.1%}"]
        codes = ", ".join(f"{code}: {count}" for code, count in sorted(rejections.items()))
        lines.append(f"{event.name:{width}}{''.join(cells)}  {codes or '-'}")
    return lines


def middle(values):
    return np.median(values) if len(values) else np.nan

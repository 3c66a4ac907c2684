# SPDX-License-Identifier: GPL-2.0-or-later
"""How thermal_displacement judges a chip, odd stock, a wrong tool, a feed hold and all else that upsets a program.

Each program is drawn with its machine and runs three times: the first is learned from, in the third something happens.
A correction is wrong when it leaves |offset - growth| larger than before by more than gate + 3 sigma; growth counts
from that at the reference contact. Nothing distinguishes events that displace a contact by less than the gate from
growth: their effect is shown in a table of its own. Lengths are in um here, times in s.
"""

import collections
import dataclasses
import os
import random

import numpy as np

from support.figures import largest, rms
from support.mill_machine import every_end_mill_is_a_gauge, start_mill
from support.recordings import read_columns
from support.simulations import simulate_all

EVERY = 0.05  # s between two rows of a recording; contacts are seconds apart
PROGRAM_TIME = 60  # s, at most
SMALL = 60  # um, largest height of the events that are to lie within the gate
WITH_HEIGHT = (2, 3, 4, 5)  # chip, stock, wrong part, wrong tool length

COLUMNS = {
    "cycle": "program.cycle",
    "contacts": "mill.truth-contacts",
    "operation": "mill.truth-contact-operation",
    "event": "mill.truth-contact-event",
    "growth": "mill.truth-contact-growth",
    "happening": "program.truth-event",
    "offset": "mill.applied-offset",
    "estimate": "growth.growth-estimate",
    "sigma": "growth.displacement-sigma",
    "gate": "growth.gate",
    "found": "growth.contacts",
    "accepted": "growth.contacts-accepted",
}
LENGTHS = ("growth", "offset", "estimate", "sigma", "gate")


@dataclasses.dataclass
class Contact:
    """A contact that thermal_displacement found, or one that it did not."""

    cycle: int
    event: int  # under way; 0 for none
    found: bool = False
    accepted: bool = False
    error: float = 0  # of the growth that is applied, when it was accepted: it minus the true growth
    excess: float = 0  # by how much more than gate + 3 sigma the correction went wrong; negative is well


def read_contacts(recording):
    """The Contacts in a recording, a dictionary of columns."""
    contacts = []
    reference = {}  # growth at the contact of the learning cycle, by operation and occurrence
    seen = collections.Counter()
    true_contact = None
    for row in range(1, len(recording["cycle"])):
        now = {name: column[row] for name, column in recording.items()}
        before = {name: column[row - 1] for name, column in recording.items()}
        cycle = int(now["cycle"])
        if now["contacts"] > before["contacts"]:
            seen[cycle, now["operation"]] += 1
            key = now["operation"], seen[cycle, now["operation"]]
            if cycle == 1:
                reference[key] = now["growth"]
            growth = now["growth"] - reference.get(key, np.nan)
            true_contact = Contact(cycle, int(now["event"]))
            contacts.append(true_contact)
        if now["found"] > before["found"]:
            if true_contact is None or true_contact.found:  # the tool met nothing there
                growth = np.nan
                true_contact = Contact(cycle, int(now["happening"]))
                contacts.append(true_contact)
            true_contact.found = True
            if now["accepted"] > before["accepted"]:
                true_contact.accepted = True
                true_contact.error = now["estimate"] - growth
                worse = abs(true_contact.error) - abs(before["offset"] - growth)
                true_contact.excess = worse - before["gate"] - 3 * now["sigma"]
                if np.isnan(growth):  # a correction from nothing is as wrong as can be
                    true_contact.excess = np.inf
    return [contact for contact in contacts if contact.cycle > 1]


def simulate(seed, event, small, interval, progress):
    """The Contacts of one program after learning; `event` upsets the third time it runs."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host() as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        every_end_mill_is_a_gauge(host)
        host.set("program.cycle-interval", interval)
        host.set("program.event", event)
        host.set("program.event-cycle", 3)
        if small:
            host.set("program.event-smallest", 0)
            host.set("program.event-largest", SMALL / 1000)
        host.record(path, COLUMNS.values(), EVERY)
        host.run(2 * interval + PROGRAM_TIME, progress)
        column = read_columns(path)
    return read_contacts(
        {name: column[pin] * (1000 if name in LENGTHS else 1) for name, pin in COLUMNS.items()}
    )


def draw_programs(count, small):
    """Arguments of simulate(): machines from 1 on, every kind of event in turn, 1 to 5 minutes between the parts."""
    kinds = WITH_HEIGHT if small else range(1, len(event_names()))
    programs = []
    for seed in range(1, count + 1):
        interval = round(PROGRAM_TIME * 5 ** random.Random(seed).random(), 3)
        programs.append((seed, kinds[seed % len(kinds)], small, interval))
    return programs


def run_programs(programs, place=None):
    duration = sum(2 * interval + PROGRAM_TIME for _, _, _, interval in programs)
    return simulate_all(simulate, programs, duration, place)


def event_names():
    """The sentence of each event, by its number; 0 is none."""
    import plumb

    return {0: "None.", **plumb.declarations("sim_part_program")["codes"]["truth-event"]}


def table(programs, outcomes):
    """Its lines: the verdicts on the contacts under each event, and without one."""
    names = event_names()
    groups = collections.defaultdict(list)
    for contacts in outcomes:
        for contact in contacts:
            groups[contact.event].append(contact)
    counts = collections.Counter(event for _, event, _, _ in programs)
    heads = ("programs", "contacts", "found", "accepted", "wrong", "error rms", "max, um")
    width = 2 + max(map(len, names.values()))
    lines = [f"{'event':{width}}" + "".join(f"{head:>10}" for head in heads)]
    for event in sorted(set(counts) | set(groups)):
        contacts = groups[event]
        errors = [contact.error for contact in contacts if contact.accepted]
        figures = [
            counts[event] or len(programs),
            len(contacts),
            sum(contact.found for contact in contacts),
            len(errors),
            len(wrong(contacts)),
        ]
        sizes = (rms(errors), largest(errors)) if errors else ()
        lines.append(f"{names[event]:{width}}" + "".join(f"{n:10}" for n in figures) + "".join(f"{x:10.1f}" for x in sizes))
    return lines


def wrong(contacts):
    return [contact for contact in contacts if contact.accepted and contact.excess > 0]


def report(count, place):
    """Runs `count` programs with events of the usual size, and a fifth as many with smaller ones; prints tables."""
    for small, number, title in (
        (False, count, "programs with an event each; heights of 0.1 mm and more"),
        (True, max(1, count // 5), f"programs with an event within the gate; heights up to {SMALL} um"),
    ):
        programs = draw_programs(number, small)
        outcomes = run_programs(programs, place)
        print(f"{number} {title}\n")
        print("\n".join(table(programs, outcomes)) + "\n")

# SPDX-License-Identifier: GPL-2.0-or-later
"""The contacts that thermal_displacement found on a simulated mill, and the cuts with their truth, as a text file of events.

One event a line, sorted by time; times in s, lengths in um, speeds in rpm:

    speed T RPM        as the component sees it: at the start, and when it has changed by more than 20 rpm, or from or to 0
    part T 1           a part begins; 0: it ends
    contact T KEY TOOL CYCLE GROWTH SIGMA FEED REFERENCE_SIGMA
                       GROWTH: since the reference, as the contact shows it; KEY: 100 * operation + occurrence; SIGMA: of the
                       contact by its noise; FEED: um/s, negative; REFERENCE_SIGMA: of the reference, 0 if it is not known
    cut T NEEDED OFFSET SIGMA TOLD
                       NEEDED: the offset that would have made the cut right; OFFSET: in force; SIGMA: growth.offset-sigma;
                       TOLD: 1 if a doubt was announced

A contact counts that could be compared with its reference, accepted or not. The T of a cut is LEAD s before its end, when the tool is
above the work: what is known then makes the cut, as nothing moves in it. The contact is compared in the machine less the
applied offset: it shows the growth whatever offset is in force.
"""

import dataclasses
import os

import numpy as np

from support.recordings import read_columns
from support.rivals import SIMPLE, answers

LEAD = 3  # s
UNKNOWN = 51  # status-code: of the first part after a start
ANNOUNCING = ("doubt", "fault", "reference-refused", "learning-failed")
SPEED_CHANGE = 20  # rpm

COLUMNS = ["mill.truth-cuts", "mill.truth-cut-error", "mill.truth-cut-operation", "mill.truth-cut-occurrence", "mill.truth-contacts"]
COLUMNS += ["mill.applied-offset", "program.learn", "program.cycle", "program.cycle-running", "program.truth-occurrence"]
COLUMNS += ["program.z-velocity-cmd", "growth.spindle-speed-cmd"]
COLUMNS += ["growth.contacts", "growth.contacts-accepted", "growth.contacts-rejected", "growth.contact-tool", "growth.contact-operation"]
COLUMNS += ["growth.displacement", "growth.displacement-sigma", "growth.offset-sigma", "growth.reference-sigma", "growth.z-offset"]
COLUMNS += ["growth.detail-code", "growth.status-code", "growth.authority", "growth.gate", *("growth." + pin for pin in ANNOUNCING)]

CUT = [("time", float), ("error", float), ("offset", float), ("worse", float), ("sigma", float), ("announced", bool), ("code", int)]
CUT += [("authority", float), ("known", bool), ("gate", float), ("gauge", bool), ("cycle", int), *((name, float) for name in SIMPLE)]


def rises(signal):
    """The rows at which it has risen."""
    return np.flatnonzero(np.diff(signal) > 0) + 1


def find_cuts(column, excluded=()):
    """The cuts after learning that have a reference cut. `excluded`: operations whose contacts do not count."""
    rows = rises(column["mill.truth-cuts"])
    key = list(zip(column["mill.truth-cut-operation"][rows], column["mill.truth-cut-occurrence"][rows]))
    tip = 1000 * column["mill.truth-cut-error"][rows]
    learnt = column["program.learn"][rows] > 0
    reference = {k: error for k, error, of_learning in zip(key, tip, learnt) if of_learning}
    counted = [i for i in range(len(rows)) if not learnt[i] and key[i] in reference]
    rows = rows[counted]
    error = np.array([tip[i] - reference[key[i]] for i in counted])
    cuts = cuts_at(column, rows, error, 1000 * column["mill.applied-offset"][rows - 1])
    cuts["gauge"] = ~np.isin(column["mill.truth-cut-operation"][rows], list(excluded))
    return cuts


def cuts_at(column, rows, error, offset):
    """Cuts that end in these rows, by their errors and the offset in force in um."""
    early = np.maximum(rows - round(LEAD / (column["time"][1] - column["time"][0])), 0)
    cuts = np.zeros(len(rows), CUT)
    cuts["time"], cuts["cycle"] = column["time"][rows], column["program.cycle"][rows]
    cuts["error"], cuts["offset"] = error, offset
    cuts["worse"] = worse_by(cuts)
    cuts["sigma"] = 1000 * column["growth.offset-sigma"][early]
    cuts["announced"] = sum(column["growth." + pin][early] for pin in ANNOUNCING) > 0
    cuts["code"] = column["growth.status-code"][early]
    cuts["authority"] = column["growth.authority"][early]
    cuts["known"] = column["growth.contacts-accepted"][early] >= 2
    cuts["gate"] = 1000 * column["growth.gate"][early]
    return cuts


def worse_by(cuts, way=None):
    """um by which each cut is worse than without compensation; `way`: with the offset of this rival."""
    without = abs(cuts["error"] - cuts["offset"])
    return abs(error_of(cuts, way)) - without


def error_of(cuts, way=None):
    return cuts["error"] - cuts["offset"] + cuts[way] if way else cuts["error"]


def reference_sigmas(host):
    """um, by key, of the references that the component has now."""
    found = {}
    for row in range(host.get("growth.rows")):
        host.set("growth.row", row)
        host.run(0.1)
        found[100 * host.get("growth.row-operation") + host.get("growth.row-occurrence")] = 1000 * host.get("growth.row-sigma")
    return found


def speeds(time, speed):
    found = []
    for now, its in zip(time, speed):
        if not found or abs(its - found[-1][1]) > SPEED_CHANGE or (its == 0) != (found[-1][1] == 0):
            found.append((now, its))
    return found


def events(column, cuts, references):
    """The lines of a recording, without an end of line; references: as reference_sigmas()."""
    time = column["time"]
    found = [(now, f"speed {now:.1f} {speed:.0f}") for now, speed in speeds(time, column["growth.spindle-speed-cmd"])]
    running = column["program.cycle-running"] > 0
    found += [(time[row], f"part {time[row]:.1f} {running[row]:d}") for row in np.flatnonzero(np.diff(running)) + 1]
    met = rises(column["mill.truth-contacts"])
    for row in rises(column["growth.contacts"]):
        if column["program.learn"][row] or column["growth.displacement"][row] == column["growth.displacement"][row - 1]:
            continue  # each has noise: the same displacement is none
        key = 100 * int(column["growth.contact-operation"][row]) + int(column["program.truth-occurrence"][row])
        sigma, of_reference = 1000 * column["growth.displacement-sigma"][row], references.get(key, 0)
        own = np.sqrt(max(sigma**2 - of_reference**2, 0.01)) if of_reference else sigma
        feed = 1000 * column["program.z-velocity-cmd"][met[max(np.searchsorted(met, row, side="right") - 1, 0)]]
        found.append((
            time[row],
            f"contact {time[row]:.1f} {key} {column['growth.contact-tool'][row]:.0f} {column['program.cycle'][row]:.0f} "
            f"{1000 * column['growth.displacement'][row]:.3f} {own:.3f} {feed:.1f} {of_reference:.3f}",
        ))  # fmt: skip
    for cut in cuts:
        told = cut["announced"] and cut["code"] != UNKNOWN
        now = cut["time"] - LEAD
        found.append((now, f"cut {now:.1f} {cut['offset'] - cut['error']:.3f} {cut['offset']:.3f} {cut['sigma']:.3f} {told:d}"))
    return [line for _, line in sorted(found, key=lambda each: each[0])]


@dataclasses.dataclass
class Judged:
    column: dict  # of the recording
    cuts: np.ndarray  # of type CUT; Hold and Simple3 are the offsets in um that these rivals would have had
    lines: list


def judge(host, path):
    """What a recording of COLUMNS shows that has ended, while the host still has the references."""
    excluded = {host.get(f"growth.exclude-operation-{index}") for index in range(4)}
    column = read_columns(path)
    cuts = find_cuts(column, excluded)
    return Judged(column, cuts, ask_rivals(column, cuts, reference_sigmas(host)))


def ask_rivals(column, cuts, references):
    """Writes their offsets into the cuts. Returns the lines of the contacts."""
    lines = events(column, cuts, references)
    for name, rival in SIMPLE.items():
        cuts[name] = answers(lines, rival())["offset"]
    return lines


def add_option(parser):
    parser.add_argument("--contacts", metavar="DIR", help="keep the contacts of each machine in a file, for scripts/bench rivals")


def write(folder, group, number, lines):
    """FOLDER/GROUP/NUMBER.txt; without a folder nothing."""
    if not folder:
        return
    group = "-".join("".join(letter if letter.isalnum() or letter in "+-_" else " " for letter in group).split())
    os.makedirs(os.path.join(folder, group), exist_ok=True)
    with open(os.path.join(folder, group, f"{number}.txt"), "w", encoding="ascii") as file:
        file.write("".join(line + "\n" for line in lines))

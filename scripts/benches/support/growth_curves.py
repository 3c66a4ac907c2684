# SPDX-License-Identifier: GPL-2.0-or-later
"""A measured growth curve of any machine as the growth of the simulated mill, and how much of it is removed.

The curve is a CSV file with a header, a column of times, one of the growth, and one of spindle speeds. The mill of
configs/mill/bench.hal makes a part every five minutes; operation 10 is its gauge. An error is the tip error of a cut less
that of the same cut in the learning cycle. Ideal holding would know the true growth at each contact of the gauge, and hold it.
"""

import csv
import dataclasses
import os

import numpy as np

from support.figures import largest, rms
from support.mill_machine import start_mill
from support.recordings import read_columns, write_rows

GAUGE = 10  # operation
EVERY = 0.4  # s between two rows of a recording; a cut dwells for longer
LEAD = 3  # s before the end of a cut at which a doubt announces it
TIMES, GROWTHS, SPEEDS = ("time", "t"), ("growth", "displacement", "z"), ("speed", "rpm", "s", "n")
SECONDS = {"s": 1, "min": 60, "h": 3600}
MILLIMETRES = {"um": 1e-3, "mm": 1}
SHORT = 2400  # s: no curve of growth is shorter, so these are minutes

COLUMNS = ["mill.truth-cuts", "mill.truth-cut-error", "mill.truth-cut-operation", "mill.truth-cut-occurrence"]
COLUMNS += ["mill.truth-contacts", "mill.truth-contact-operation", "mill.truth-contact-growth", "mill.applied-offset"]
COLUMNS += ["program.learn", "growth.doubt", "growth.status-code", "growth.fault", "growth.reference-refused", "growth.growth-known"]


@dataclasses.dataclass
class Curve:
    times: np.ndarray  # s, from 0
    growth: np.ndarray  # mm
    speeds: np.ndarray  # rpm
    taken: str  # as what the columns were taken


def read_curve(path, names=(None, None, None), units=(None, None)):
    """names: of the columns of time, growth and speed; units: of time and growth. None: by their heads and values."""
    with open(path, newline="", encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    if len(rows) < 3:
        raise OSError(f"{path}: a header and two rows at least")
    header = [name.strip() for name in rows[0]]
    indices = [_column(path, header, name, known) for name, known in zip(names, (TIMES, GROWTHS, SPEEDS))]
    try:
        values = np.array([[float(row[index]) for index in indices] for row in rows[1:]])
    except (ValueError, IndexError) as error:
        raise OSError(f"{path}: {error}") from error
    times, growth, speeds = values.T
    if not np.all(np.isfinite(values)) or np.any(np.diff(times) <= 0):
        raise OSError(f"{path}: the times do not rise, or a value is not finite")
    time_name, growth_name = (header[index] for index in indices[:2])
    time_unit = units[0] or _unit(time_name, SECONDS) or ("min" if times[-1] - times[0] < SHORT else "s")
    growth_unit = units[1] or _unit(growth_name, MILLIMETRES) or ("um" if np.ptp(growth) > 0.5 else "mm")
    taken = f"{time_name} in {time_unit}, {growth_name} in {growth_unit}, {header[indices[2]]} in rpm"
    return Curve((times - times[0]) * SECONDS[time_unit], growth * MILLIMETRES[growth_unit], speeds, taken)


def _column(path, header, name, known):
    if name is not None:
        if name not in header:
            raise OSError(f"{path}: no column '{name}'; it has {', '.join(header)}")
        return header.index(name)
    words = [set(head.lower().replace(".", "_").replace("-", "_").split("_")) for head in header]
    for word in known:
        found = [index for index, its in enumerate(words) if word in its]
        if len(found) == 1:
            return found[0]
    raise OSError(f"{path}: which column is the {known[0]}? Give its name; it has {', '.join(header)}")


def _unit(name, units):
    last = name.lower().replace(".", "_").replace("-", "_").split("_")[-1]
    return last if last in units and last != name.lower() else None


def simulate(curve, seed, rate, progress):
    """The recording of a mill with this growth."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        replayed, path = os.path.join(folder, "curve.csv"), os.path.join(folder, "recording.csv")
        rows = zip(curve.times, curve.growth, curve.speeds)
        write_rows(replayed, ["time", "mill.growth-replay", "program.sides-speed"], rows)
        start_mill(host, seed)
        host.set("mill.use-replay", True)
        host.replay(replayed)
        host.record(path, COLUMNS, EVERY)
        host.run(curve.times[-1], progress)
        return judge(read_columns(path))


@dataclasses.dataclass
class Outcome:
    without: np.ndarray  # um, at the cuts
    with_it: np.ndarray
    holding: np.ndarray
    codes: np.ndarray  # status-code of a doubt before each cut, 0 for none
    known: np.ndarray  # before each cut
    hours: float
    messages: int


def judge(column):
    cuts = np.flatnonzero(np.diff(column["mill.truth-cuts"])) + 1
    contacts = np.flatnonzero(np.diff(column["mill.truth-contacts"])) + 1
    learnt = column["program.learn"] > 0
    tip = 1000 * column["mill.truth-cut-error"][cuts]
    key = list(zip(column["mill.truth-cut-operation"][cuts], column["mill.truth-cut-occurrence"][cuts]))
    reference = {k: error for k, error, row in zip(key, tip, cuts) if learnt[row]}
    gauge = contacts[column["mill.truth-contact-operation"][contacts] == GAUGE]
    growth = 1000 * column["mill.truth-contact-growth"]
    zero = np.mean(growth[gauge[learnt[gauge]]])
    counted = [i for i in range(len(cuts)) if not learnt[cuts[i]] and key[i] in reference]
    error = np.array([tip[i] - reference[key[i]] for i in counted])
    rows = cuts[counted]
    without = error - 1000 * column["mill.applied-offset"][rows - 1]
    own = contacts[np.searchsorted(contacts, rows, side="right") - 1]  # the contact of this cut
    before = gauge[np.maximum(np.searchsorted(gauge, own, side="left") - 1, 0)]
    early = np.maximum(rows - round(LEAD / EVERY), 0)
    refused = column["growth.fault"] + column["growth.reference-refused"] > 0
    codes = np.where(refused + column["growth.doubt"] > 0, column["growth.status-code"], 0)
    told = codes != 0
    return Outcome(
        without, error, without + growth[before] - zero, codes[early], column["growth.growth-known"][early] > 0,
        column["time"][-1] / 3600, int(np.count_nonzero(np.diff(told.astype(int)) > 0)),
    )  # fmt: skip


def removed(errors, without):
    return 1 - rms(errors) / rms(without)


def line(name, outcome):
    worse = np.abs(outcome.with_it) - np.abs(outcome.without)
    told = outcome.codes != 0
    codes = " ".join(f"{code:.0f}: {np.mean(outcome.codes == code):.0%}" for code in np.unique(outcome.codes[told]))
    return (
        f"{name:24}{len(worse):6d}{rms(outcome.without):9.1f}{rms(outcome.with_it):7.1f}{removed(outcome.with_it, outcome.without):10.1%}"
        f"{removed(outcome.holding, outcome.without):10.1%}{np.mean(told):8.1%}{outcome.messages:6d}"
        f"{np.count_nonzero(worse > 5):7d}{np.count_nonzero((worse > 5) & ~told):7d}{largest(outcome.with_it):8.1f}  {codes}"
    )


HEAD = f"{'um':24}{'cuts':>6}{'without':>9}{'with':>7}{'removed':>10}{'holding':>10}{'told':>8}{'mess.':>6}{'> 5':>7}{'silent':>7}{'max':>8}  codes told"

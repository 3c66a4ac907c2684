# SPDX-License-Identifier: GPL-2.0-or-later
"""A measured growth curve of any machine as the growth of the simulated mill, and how much of it is removed.

The curve is a table of times, growth and spindle speeds, as plumb growth reads it. The mill of
configs/mill/bench.hal makes a part every five minutes; operation 10 is its gauge. An error is the tip error of a cut less
that of the same cut in the learning cycle. Ideal holding would know the true growth at each contact of the gauge, and hold it.
"""

import dataclasses
import os

import numpy as np

from support.figures import largest, rms
from support.growth_days import Day
from support.mill_machine import begin_at, replay_growth, run_events, start_mill, unlink
from support.rivals import SIMPLE
from support import contacts

GAUGE = 10  # operation
EVERY = 0.4  # s between two rows of a recording; a cut dwells for longer

REPLAYED = ["time", "mill.growth-replay", "program.sides-speed"]
COLUMNS = [*contacts.COLUMNS, "mill.truth-contact-operation", "mill.truth-contact-growth"]


@dataclasses.dataclass
class Curve:
    times: np.ndarray  # s, from 0
    growth: np.ndarray  # mm
    speeds: np.ndarray  # rpm
    taken: str  # how the columns were taken


def read_curve(path, *heads):
    """`heads`: as of plumb growth, which reads the table, such as "ch2=Z (um)"."""
    day = Day(path, *heads)
    if len(day.growth) > 1:
        raise OSError(f"{path}: which column is the growth of the mill? There are {', '.join(day.growth)}; the mill grows in Z")
    return Curve(day.time, next(iter(day.growth.values())) / 1000, day.speed, day.taken)


def simulate(curve, seed, rate, phase, blind, progress):
    """The Outcome of a mill with this growth, whose first part begins `phase` s after its start. `blind`: to the spindle's speed."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / rate)}) as host:
        path = os.path.join(folder, "recording.csv")
        start_mill(host, seed)
        replay_growth(host, folder, curve.times, curve.growth, curve.speeds)
        event = begin_at(host, phase)
        if blind:
            unlink(host, "growth.spindle-speed-cmd", 0)
        host.record(path, COLUMNS, EVERY)
        run_events(host, [event], curve.times[-1], progress)
        return judge(contacts.judge(host, path))


@dataclasses.dataclass
class Outcome:
    cuts: np.ndarray  # of type contacts.CUT
    holding: np.ndarray  # um, the error of each
    hours: float
    messages: int
    lines: list  # of the contacts


def judge(judged):
    column, cuts = judged.column, judged.cuts
    met = contacts.rises(column["mill.truth-contacts"])
    gauge = met[column["mill.truth-contact-operation"][met] == GAUGE]
    growth = 1000 * column["mill.truth-contact-growth"]
    zero = np.mean(growth[gauge[column["program.learn"][gauge] > 0]])
    own = met[np.searchsorted(column["time"][met], cuts["time"], side="right") - 1]  # the contact of this cut
    before = gauge[np.maximum(np.searchsorted(gauge, own, side="left") - 1, 0)]
    told = sum(column["growth." + pin] for pin in contacts.ANNOUNCING) > 0
    return Outcome(
        cuts, contacts.error_of(cuts) - cuts["offset"] + growth[before] - zero, column["time"][-1] / 3600,
        int(np.count_nonzero(np.diff(told.astype(int)) > 0)), judged.lines,
    )  # fmt: skip


def removed(errors, without):
    return 1 - rms(errors) / rms(without)


def lines(name, outcome):
    """The row of the component, and one of each rival."""
    cuts = outcome.cuts
    without, told = cuts["error"] - cuts["offset"], cuts["announced"]
    codes = " ".join(f"{code}: {np.mean(told & (cuts['code'] == code)):.0%}" for code in np.unique(cuts["code"][told]))
    found = []
    for way in (None, *SIMPLE):
        error, worse = contacts.error_of(cuts, way), contacts.worse_by(cuts, way) > 5
        figures = f"{rms(error):7.1f}{removed(error, without):10.1%}"
        if way:
            found.append(f"  {way:45}{figures}{'':24}{np.count_nonzero(worse):7d}{'':7}{largest(error):8.1f}")
        else:
            found.append(
                f"{name:32}{len(cuts):6d}{rms(without):9.1f}{figures}{removed(outcome.holding, without):10.1%}{np.mean(told):8.1%}"
                f"{outcome.messages:6d}{np.count_nonzero(worse):7d}{np.count_nonzero(worse & ~told):7d}{largest(error):8.1f}  {codes}"
            )
    return found


HEAD = f"{'um':32}{'cuts':>6}{'without':>9}{'with':>7}{'removed':>10}{'holding':>10}{'told':>8}{'mess.':>6}{'> 5':>7}{'silent':>7}{'max':>8}  codes told"

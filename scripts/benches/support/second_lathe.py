# SPDX-License-Identifier: GPL-2.0-or-later
"""A second lathe for the bench lathe, of another structure than sim_lathe, and an operator who enters its diameters.

It shares no law with sim_lathe or centre_height. The bend is solved with the depth that it changes, and follows a power of the
depth. Spindle and slide warm by two time constants. The axis is tilted, so that the bar becomes a cone. The built-up edge grows from
cut to cut and breaks off. The work is oval. A burr stands on some of the lands.
"""

import dataclasses
import math
import os
import random

import numpy as np

from support.lathe_machine import METHODS, UM, WORKS
from support.recordings import read_columns, write_rows

CONFIG = ("loadrt threads name1=servo-thread period1=1000000", "loadrt centre_height names=centre keyed_cuts=16 interlock=no", "addf centre.update servo-thread", "start")
RESULTS = ["value-valid", "move-allowed", "x-allowed", "on-centre", "fault", "detail-code", "status-code", "height", "sigma", "within", "x-correction", "x-sigma", "rejected-cuts"]
BURRS = 0.08  # of the cuts
FURTHER = 1.5  # mm, from land to land
PERIOD = 0.001  # s
SLIPS = {
    "air": "the tool stands 0.9 mm too far out and meets no stock",
    "standing": "the spindle stands",
    "tool": "the second pair is cut by another tool",
    "swapped": "the first two diameters are swapped",
    "radius": "radii for diameters",
    "inch": "inches for millimetres",
    "depth": "the lands of one side are 0.3 mm less deep",
    "burr": "a burr of 0.02 mm on one land",
    "one wrong": "one diameter is 0.1 mm wrong",
}


@dataclasses.dataclass(frozen=True)
class SecondCase:
    diameter: int
    method: str
    burrs: bool = False
    near: bool = False  # tools close to the tolerance
    slip: str = ""


def draw_between(drawn, low, high):
    """Uniform in the logarithm."""
    return math.exp(drawn.uniform(math.log(low), math.log(high)))


class SecondLathe:
    """One lathe with its tool and bar; mm, s, N."""

    def __init__(self, work, seed, near):
        drawn = self._drawn = random.Random("second lathe %g %d" % (work.diameter, seed))
        self._work = work
        reach = 2 * work.tolerance
        self.height = drawn.uniform(-1, 1) * (reach if near else work.highest)
        self.x_error = drawn.uniform(-1, 1) * (reach if near else 0.05)
        # The bend for a cut of 0.1 mm, its direction from the tangent, and its power of the depth.
        self._bend, self._direction, self._power = draw_between(drawn, 0.0001, 0.001), drawn.uniform(0.2, 0.7), drawn.uniform(0.6, 1)
        self._growths = [(drawn.uniform(0, 0.004), drawn.uniform(200, 900)), (drawn.uniform(0, 0.02), drawn.uniform(3000, 9000))]
        self._lifts = [(drawn.uniform(0, 0.002), drawn.uniform(200, 900)), (drawn.uniform(0, 0.01), drawn.uniform(3000, 9000))]
        self._time = drawn.uniform(0, 7200)
        self._taper, self._tilt = drawn.uniform(-1e-4, 1e-4), drawn.uniform(-5e-5, 5e-5)
        self._edge, self._largest_edge, self._wear = drawn.uniform(0, 0.003), drawn.uniform(0.001, 0.006), 0.0
        self._oval = drawn.uniform(0, 0.0005)
        self._gauge_scale, self._y_scale, self._x_scale = drawn.gauss(0, 1e-4), drawn.gauss(0, 2e-5), drawn.gauss(0, 1e-5)
        self._y_backlash = drawn.uniform(0, 0.001)
        self.spindle_turns = True

    def _warmth(self, parts):
        return sum(size * (1 - math.exp(-self._time / constant)) for size, constant in parts)

    def cut(self, x, y, z, before, depth):
        """The land that the tool leaves from this radius at these positions, in passes of this depth: its radius, its effective
        height, and the effective x of the tip. None if the tool touches nothing. Height and x are those of the next cut, too:
        without the scatter of the positions, which each cut has anew."""
        drawn = self._drawn
        self._time += draw_between(drawn, 20, 90)
        if drawn.random() < 0.4:
            self._edge = 0
        self._edge = min(self._edge + drawn.uniform(0, 0.8) * self._largest_edge, self._largest_edge)
        tip_x = x * (1 + self._x_scale) + self.x_error - self._warmth(self._growths) - self._edge + self._wear + self._taper * z
        tip_y = y * (1 + self._y_scale) + self.height - self._warmth(self._lifts) + self._tilt * z + self._y_backlash / 2
        scatter_x, scatter_y = drawn.gauss(0, 0.0006), drawn.uniform(-0.5, 0.5) * self._y_backlash + drawn.gauss(0, 0.001)
        tip_x, tip_y = tip_x + scatter_x, tip_y + scatter_y
        left = math.hypot(tip_x, tip_y)
        if not self.spindle_turns or left >= before:
            return None
        self._wear += drawn.uniform(0, 0.0006)
        # The last pass takes what is left of this depth; the bend leaves more, and lessens the depth.
        start = min(before, left + depth) if depth else before
        its_x, its_y = tip_x, tip_y
        for _ in range(30):
            bend = self._bend * max((start - left) / 0.1, 0) ** self._power
            its_x, its_y = tip_x + bend * math.sin(self._direction), tip_y - bend * math.cos(self._direction)
            left = math.hypot(its_x, its_y)
        return left, its_y - y - scatter_y, its_x - x - scatter_x

    def measured(self, radius, burrs):
        drawn = self._drawn
        diameter = 2 * radius + self._gauge_scale * (2 * radius - self._work.diameter) + self._oval * math.cos(drawn.uniform(0, 2 * math.pi)) + drawn.gauss(0, 0.0003)
        if burrs and drawn.random() < BURRS:
            diameter += drawn.uniform(0.004, 0.04)
        return diameter


def checked(work, method):
    """The plan, and behind it the check that it needs: deeper into the last land."""
    plan = plan_of(work, method)
    x, y, _, depth = plan[-1]
    deeper = min(0.1, 0.3 * x)
    if METHODS[method].plan == 1:
        radius = math.hypot(x, work.step) - deeper
        y = 2 * work.step if 2 * work.step <= 0.6 * radius else work.step / 2
        return [*plan, (math.sqrt(radius**2 - y**2), y, True, depth)]
    return plan if METHODS[method].plan == 3 else [*plan, (x - deeper, y, True, depth)]


def plan_of(work, method):
    """X and Y of each cut, whether it is on the land of the one before, and the depth of its passes; 0 is one pass."""
    x, step = work.diameter / 2, work.step
    its = METHODS[method]
    second = (work.diameter - its.share * (work.diameter - work.deepest)) / 2
    deep = work.pass_depth
    if its.plan == 0:
        return [(x, 0, False, deep), (second, 0, True, deep)]
    if its.plan == 2:
        return [(x, 0, False, deep), ((x + second) / 2, 0, True, deep), (second, 0.75 * step, True, deep)]
    if its.plan == 3:
        return [(x if k in (0, 1) else second, step if k in (0, 2) else -step, False, deep) for k in (0, 3, 2, 1, 1, 2, 3, 0)]
    return [(x, step if k % 4 in (0, 3) else -step, False, 0) for k in range(2 * its.pairs)]


class Operator:
    """Enters diameters into centre_height, in a host."""

    def __init__(self, host):
        self.host = host
        for line in CONFIG:
            host.command(line)

    def set(self, values):
        for name, value in values.items():
            self.host.set("centre." + name, value)

    def set_up(self, case):
        work, its = WORKS[case.diameter], METHODS[case.method]
        self.set(
            {
                "keyed": True,
                "method": its.plan,
                "air-cut-check": its.plan in (0, 2),
                "gauge-sigma": 0.0005,
                "land-step": work.step,
                "land-diameter": work.diameter,
                "x-is-radius": True,
                "enable": True,
                "pass-depth": 0 if its.plan == 1 else work.pass_depth,
                "tolerance": work.tolerance,
                "largest-burr": 0.04 if case.burrs else 0,
                "max-sigma": 0.05,
                "max-move": 1.1 * work.highest,
                "max-x-correction": 0.5,
            }
        )
        return checked(work, case.method)

    def enter(self, procedures, stock):
        """The RESULTS of procedures, arrays. Each has the sign by word, and X, Y and diameter of each cut."""
        from plumb_folder import TemporaryFolder

        cuts = len(procedures[0][1])
        self.set({"cuts": cuts, "stock-diameter": stock})
        pins = ["sign"] + ["cut-%s-%d" % (what, i) for i in range(cuts) for what in ("x", "y", "diameter")]
        with TemporaryFolder() as folder:
            entries, results = (os.path.join(folder, name) for name in ("entries.csv", "results.csv"))
            header = ["time"] + ["centre." + pin for pin in pins + ["compute"]]
            write_rows(entries, header, self._rows(procedures))
            recording = self.host.record(results, ["centre." + name for name in RESULTS], PERIOD)
            self.host.run(self.host.replay(entries))
            self.host.stop_recording(recording)
            columns = read_columns(results)
        return {name: columns["centre." + name][1::2] for name in RESULTS}  # those of the periods in which it computed

    def _rows(self, procedures):
        for i, (sign, cuts) in enumerate(procedures):
            for compute in (1, 0):
                yield [PERIOD * (2 * i + 2 - compute), sign, *(value for cut in cuts for value in cut), compute]


@dataclasses.dataclass
class SecondOutcome:
    """Of many lathes, arrays; um. The truth is the mean of the cuts, of X the error of the programmed radius."""

    truth: np.ndarray
    truth_x: np.ndarray
    met: np.ndarray  # whether each tool met the stock
    values: dict  # of RESULTS


def slipped(slip, diameters):
    """The diameters as the operator enters them."""
    its = list(diameters)
    if slip == "swapped":
        its[0], its[1] = its[1], its[0]
    elif slip in ("radius", "inch"):
        its = [diameter / (2 if slip == "radius" else 25.4) for diameter in its]
    elif slip in ("burr", "one wrong"):
        its[1] += 0.02 if slip == "burr" else -0.1
    return its


def procedure_on(lathe, work, plan, case):
    """The entries of one procedure and the truth of Y and X: cuts, height, error of X, and whether all cuts met the stock."""
    radius, heights, errors, entries, met, land = work.stock / 2, [], [], [], True, 0
    before = lowest = radius
    lathe.x_error += 0.9 if case.slip == "air" else 0
    lathe.spindle_turns = case.slip != "standing"
    for i, (x, y, same_land, depth) in enumerate(plan):
        if METHODS[case.method].plan == 1 and same_land:  # the check: where centre_height asks for it, by the height that it has found
            x = math.sqrt(max((lowest - 0.1) ** 2 - (y + lathe.height) ** 2, 0)) - lathe.x_error
        if not same_land:
            before, land = radius, land + 1
            if case.slip == "depth" and i in (1, 2):
                before -= 0.3
        if case.slip == "tool" and i == 2:
            lathe.height, lathe.x_error = -lathe.height, lathe.x_error + 0.03
        result = lathe.cut(x, y, 25 - FURTHER * land, before, depth)
        if result is None:
            met = False
        else:
            before = result[0]
            lowest = min(lowest, before)
            if i < len(plan_of(work, case.method)):
                heights.append(result[1])
                errors.append(result[2])
        entries.append((x, y, lathe.measured(before, case.burrs)))
    diameters = slipped(case.slip, [entry[2] for entry in entries])
    entries = [(x, y, diameter) for (x, y, _), diameter in zip(entries, diameters)]
    return entries, np.mean(heights or [np.nan]), np.mean(errors or [np.nan]), met


def simulate_second(case, seeds, progress):
    """The SecondOutcome of all lathes of a case."""
    import plumb

    procedures, truths = [], []
    with plumb.Host() as host:
        operator, work = Operator(host), WORKS[case.diameter]
        plan = operator.set_up(case)
        for done, seed in enumerate(seeds):
            lathe = SecondLathe(work, seed, case.near)
            entries, height, x_error, met = procedure_on(lathe, work, plan, case)
            sign = 0 if METHODS[case.method].plan else 1 if lathe.height > 0 else -1
            procedures.append((sign, entries))
            truths.append((UM * height, UM * x_error, met))
            if not progress((done + 1) * 0.002):
                break
        values = operator.enter(procedures, work.stock - 0.002)
    truth, truth_x, met = np.array(truths, float).T
    for name in ("height", "sigma", "within", "x-correction", "x-sigma"):
        values[name] = UM * values[name]
    return SecondOutcome(truth, truth_x, met > 0, values)

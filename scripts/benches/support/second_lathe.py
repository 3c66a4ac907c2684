# SPDX-License-Identifier: GPL-2.0-or-later
"""A second lathe for the bench lathe, of another structure than sim_lathe, and an operator who enters its diameters.

It shares no law with sim_lathe or centre_height. The bend is solved with the depth that it changes, and follows a power of the
depth. Spindle and slide warm by two time constants. The axis is tilted, so that the bar becomes a cone. The built-up edge grows from
cut to cut and breaks off. The work is oval. A burr stands on some of the lands.
"""

import dataclasses
import math
import random

import numpy as np

from support import lathe_hall
from support.lathe_machine import METHODS, UM, WORKS

RESULTS = ["value-valid", "move-allowed", "x-allowed", "on-centre", "fault", "detail-code", "status-code", "height", "sigma", "within", "x-correction", "x-sigma", "rejected-cuts"]
BURRS = 0.08  # of the cuts
FURTHER = 1.5  # mm, from land to land
MOST_CHECKS = 3  # a check, and two more if it does not fit
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


def settings(case):
    work, its = WORKS[case.diameter], METHODS[case.method]
    return lathe_hall.settings(
        {
            "air-cut-check": its.plan in (0, 2),
            "gauge-sigma": 0.0005,
            "land-step": work.step,
            "land-diameter": work.diameter,
            "pass-depth": 0 if its.plan == 1 else work.pass_depth,
            "tolerance": work.tolerance,
            "largest-burr": 0.04 if case.burrs else 0,
            "max-sigma": 0.05,
            "max-move": 1.1 * work.highest,
            "stock-diameter": work.stock - 0.002,
        }
    )


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


class Cuts:
    """What an operator cuts on a lathe: the truth of Y and X, and whether all cuts met the stock."""

    def __init__(self, lathe, work, case):
        self.lathe, self._work, self._case = lathe, work, case
        self.heights, self.errors, self.met = [], [], True
        self._before, self._land, self._number = work.stock / 2, 0, 0

    def cut(self, x, y, same_land, depth):
        """The measured diameter."""
        if not same_land:
            self._before, self._land = self._work.stock / 2, self._land + 1
            if self._case.slip == "depth" and self._number in (1, 2):
                self._before -= 0.3
        if self._case.slip == "tool" and self._number == 2:
            self.lathe.height, self.lathe.x_error = -self.lathe.height, self.lathe.x_error + 0.03
        self._number += 1
        result = self.lathe.cut(x, y, 25 - FURTHER * self._land, self._before, depth)
        if result is None:
            self.met = False
        else:
            self._before = result[0]
            self.heights.append(result[1])
            self.errors.append(result[2])
        return self.measured(self._case.burrs)

    def measured(self, burrs=False):
        return self.lathe.measured(self._before, burrs)


def procedure_on(lathe, work, case):
    """An operator of the hall, who cuts the plan of his method, and then what centre_height asks for. Returns the truth of Y and X of the plan,
    whether all cuts met the stock, and the RESULTS."""
    plan = plan_of(work, case.method)
    lathe.x_error += 0.9 if case.slip == "air" else 0
    lathe.spindle_turns = case.slip != "standing"
    sign = 0 if METHODS[case.method].plan else 1 if lathe.height > 0 else -1
    cuts = Cuts(lathe, work, case)
    diameters = slipped(case.slip, [cuts.cut(*each) for each in plan])
    truth = [UM * np.mean(its or [np.nan]) for its in (cuts.heights, cuts.errors)]
    yield settings(case), ()
    yield from lathe_hall.begin({"program-method": METHODS[case.method].plan + 1, "program-cuts": len(plan), "program-sign": sign, "y-position-0": 0})
    for (x, y, _, _), diameter in zip(plan, diameters):
        yield from lathe_hall.end_of_cut(x, y)
        yield from lathe_hall.enter(diameter)
    for _ in range(MOST_CHECKS):
        due, check, x, y = yield from lathe_hall.get("cut-due", "check-due", "next-x", "next-y")
        if not due:
            break
        diameter = cuts.cut(x, y, check, plan[-1][3])
        yield from lathe_hall.end_of_cut(x, y)
        yield from lathe_hall.enter(diameter, cuts.measured())
    return [*truth, cuts.met, *(yield from lathe_hall.get(*RESULTS))]


def simulate_second(case, seeds, progress):
    """The SecondOutcome of all lathes of a case."""
    work = WORKS[case.diameter]
    operators = (procedure_on(SecondLathe(work, seed, case.near), work, case) for seed in seeds)
    rows = lathe_hall.results(operators, lambda done: progress(done * 0.002))
    truth, truth_x, met, *values = np.array(rows, float).T
    values = dict(zip(RESULTS, values))
    for name in ("height", "sigma", "within", "x-correction", "x-sigma"):
        values[name] = UM * values[name]
    return SecondOutcome(truth, truth_x, met > 0, values)

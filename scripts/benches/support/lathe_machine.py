# SPDX-License-Identifier: GPL-2.0-or-later
"""The lathes of the bench lathe: configs/lathe/bench.hal in the virtual-time host."""

import dataclasses
import os
import random

import numpy as np

from support.simulations import ROOT

CONFIG = os.path.join(ROOT, "configs", "lathe", "bench.hal")
UM = 1000  # per mm
LONGEST = 3.0  # s, a procedure of twelve lands
AT_A_TIME = 0.25  # s


@dataclasses.dataclass(frozen=True)
class Work:
    """A bar, the lands that are cut of it, and the largest force of a cut; mm, N."""

    diameter: float
    deepest: float  # of two cuts
    step: float  # of lands
    highest: float  # error of the tool's height, either way
    tolerance: float  # of a tool on centre
    force: float
    pass_depth: float
    bush: bool

    @property
    def stock(self):
        return self.diameter + 2 * self.step * (1 if self.diameter < 5 else 0.6)


WORKS = {1: Work(1.0, 0.2, 0.2, 0.1, 0.005, 5, 0.01, True), 10: Work(10.0, 5.0, 1.0, 0.5, 0.01, 50, 0.05, False)}


@dataclasses.dataclass(frozen=True)
class Method:
    plan: int
    pairs: int
    share: float  # of the infeed of two cuts, where the method does not need it whole


METHODS = {
    "two cuts": Method(0, 0, 1),
    "one pair of lands": Method(1, 1, 1),
    "lands ABBA": Method(1, 2, 1),
    "lands ABBA x 3": Method(1, 6, 1),
    "step of Y": Method(2, 0, 0.75),
    "eight cuts": Method(3, 0, 0.2),
}

RESULTS = ["trial.done", "trial.moved", "centre.value-valid", "centre.fault", "centre.detail-code", "centre.height"]
RESULTS += ["centre.sigma", "centre.within", "centre.on-centre", "trial.truth-effective-height"]


@dataclasses.dataclass(frozen=True)
class Case:
    """How the lathes of a row of the table are set up."""

    diameter: int
    method: str
    clearance: float = 0  # deg
    edge: float = 0.005  # mm, the largest built-up edge
    micrometer: bool = False
    near: bool = False  # the tool is close to the tolerance, and the cut light

    @property
    def repeatability(self):
        return 0.0012 if self.edge else 0


@dataclasses.dataclass
class Outcome:
    """Of many lathes of a case, arrays; um."""

    truth: np.ndarray  # effective height before
    height: np.ndarray  # measured; NaN if the cuts were refused
    sigma: np.ndarray
    within: np.ndarray
    moved: np.ndarray
    fault: np.ndarray
    detail: np.ndarray
    centred: np.ndarray  # on-centre was said

    @property
    def residual(self):
        return self.height - self.truth


class Lathe:
    """The configuration in a host."""

    def __init__(self, host):
        self.host = host
        host.load(CONFIG)
        host.command("start")
        self.set({"trial.start": False, "lathe.gauge-time": 0.001})

    def set(self, values):
        for name, value in values.items():
            self.host.set(name, value)

    def set_up(self, case):
        work, method = WORKS[case.diameter], METHODS[case.method]
        second = work.diameter - method.share * (work.diameter - work.deepest)
        gauge = 0.002 if case.micrometer else 0.0003
        self.set(
            {
                "trial.plan": method.plan,
                "trial.pairs": method.pairs,
                "trial.diameter": work.diameter,
                "trial.second-diameter": second,
                "trial.finish-diameter": min(0.8 * work.diameter, second),
                "trial.stock-diameter": work.stock,
                "trial.pass-depth": work.pass_depth,
                "trial.first-z": 25,
                "trial.spacing": 1.5,
                "lathe.stock-diameter": work.stock,
                "lathe.guide-bush": work.bush,
                "lathe.built-up-edge": case.edge,
                "lathe.laser-noise": 0.0003,
                "lathe.micrometer-noise": 0.002,
                "lathe.micrometer": case.micrometer,
                "lathe.x-error": 0,
                "centre.gauge-sigma": gauge,
                "centre.gauge-scale-sigma": 0 if case.micrometer else 0.0003,
                "centre.cut-repeatability": case.repeatability,
                "centre.travel-sigma": 0.0002,
                "centre.step-sigma": 0.0001,
                "centre.land-step": work.step,
                "centre.land-diameter": work.diameter,
                "centre.clearance-angle": case.clearance,
                "centre.stock-diameter": work.stock - 0.002,
                "centre.pass-depth": work.pass_depth,
                "centre.tolerance": work.tolerance,
                "centre.x-is-radius": not case.near,  # X is not asked
                "centre.max-sigma": 0.05,
                "centre.max-move": 1.1 * work.highest,
            }
        )

    def draw(self, case, seed):
        """The height of the tool and the force of a cut; the seed of the lathe draws the rest."""
        work, drawn = WORKS[case.diameter], random.Random(f"lathe {case.diameter} {seed}")
        highest = 2 * work.tolerance if case.near else work.highest
        height = drawn.uniform(-highest, highest)
        self.set(
            {
                "lathe.seed": seed,
                "lathe.height-error": abs(height),
                "lathe.side": 1 if height > 0 else -1,
                "lathe.cutting-force": drawn.uniform(work.force / 50, work.force / (10 if case.near else 1)),
                "centre.sign": 0 if METHODS[case.method].plan else 1 if height > 0 else -1,
            }
        )

    def run(self):
        """One procedure; the values of RESULTS."""
        self.host.set("trial.start", True)
        for _ in range(round(LONGEST / AT_A_TIME)):
            self.host.run(AT_A_TIME)
            values = self.host.get(RESULTS)
            if values[0]:
                self.host.set("trial.start", False)
                self.host.run(0.004)
                return values
        raise RuntimeError("the trial cuts do not end")


def simulate(case, seeds, progress):
    """The Outcome of all lathes of a case."""
    import plumb

    rows = []
    with plumb.Host() as host:
        lathe = Lathe(host)
        lathe.set_up(case)
        host.run(0.002)  # so that centre_height shows where the lands are
        for done, seed in enumerate(seeds):
            lathe.draw(case, seed)
            rows.append(lathe.run())
            if not progress((done + 1) * AT_A_TIME):
                break
    _, moved, valid, fault, detail, height, sigma, within, centred, truth = np.array(rows, float).T
    known = np.where(valid > 0, UM * height, np.nan)
    return Outcome(UM * truth, known, UM * sigma, UM * within, moved > 0, fault, detail, centred > 0)


@dataclasses.dataclass
class Procedure:
    """One procedure, cut by cut: arrays."""

    y: np.ndarray  # mm
    diameter: np.ndarray  # mm
    height: np.ndarray  # um, of the cuts so far; NaN of one cut
    sigma: np.ndarray  # um
    truth: float  # um


def procedure(case, seed):
    """The Procedure of lathe `seed`: its cuts, and what centre_height makes of the first 2, 3, ... of them."""
    import plumb

    with plumb.Host(options={"centre_height.keyed_cuts": "16"}) as host:
        lathe = Lathe(host)
        lathe.set_up(case)
        host.run(0.002)
        lathe.draw(case, seed)
        host.set("trial.start", True)
        cuts, done = [], False
        while not done:
            host.run(0.001)
            number, done, x, y, diameter = host.get(["centre.cut-number", "trial.done", "trial.x-position", "trial.y-position", "lathe.diameter"])
            if number == len(cuts) + 1:
                cuts.append((x, y, diameter))
        truth = UM * host.get("trial.truth-effective-height")
        for i, (x, y, diameter) in enumerate(cuts):
            for pin, value in (("x", x), ("y", y), ("diameter", diameter)):
                host.set(f"centre.cut-{pin}-{i}", value)
        host.set("centre.keyed", True)
        host.command("unlinkp centre.cuts")
        heights = [(np.nan, np.nan)]
        for count in range(2, len(cuts) + 1):
            host.set("centre.cuts", count)
            for value in (True, False):
                host.set("centre.compute", value)
                host.run(0.002)
            heights.append(host.get(["centre.height", "centre.sigma"]))
        return Procedure(*np.array([cut[1:] for cut in cuts]).T, *(UM * np.array(heights)).T, truth)

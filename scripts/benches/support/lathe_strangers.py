# SPDX-License-Identifier: GPL-2.0-or-later
"""Strangers who bring a lathe tool on centre by hand, and make one slip each: the rows of `scripts/bench lathe --strangers`.

A stranger follows the panel: he turns the cut that centre_height asks for, types its diameter, stores what may be stored, and turns the
land that must show it. What is refused he reads again; what gives no height he begins again, three times in all. Two machines: sim_lathe, and
the lathe of second_lathe.py, which shares no law with it.
"""

import dataclasses
import math
import random

from support import lathe_hall
from support.lathe_machine import Work
from support.second_lathe import SecondLathe

WORK = Work(10.0, 5.0, 1.0, 0.5, 0.01, 50, 0.05, False)
STOCK = 10.6  # mm
ROUNDS = 3
MOST = 18  # cuts of a round
REFUSED = 47  # status-code
NEAR = 0.04  # mm, of every second tool
CLEAR = 6.5  # mm, radius
ZERO = 0.02  # mm, of a micrometer

# A slip, and the cut of the first round, from 0, at which it is made; 4 is the check, 5 the land after the store.
SLIPS = {
    "none": "no slip",
    "radius": "one radius for a diameter",
    "radii": "radii for all diameters",
    "inch": "one diameter in inches",
    "turn": "a turn of the micrometer too much, 0.5 mm",
    "turn less": "a turn of the micrometer too little",
    "digit": "one digit wrong, 0.1 mm",
    "small digit": "one digit wrong, 0.01 mm",
    "swapped": "the diameters of the first two lands are swapped",
    "swapped all": "upper and lower lands are swapped throughout",
    "same land": "always the first land is measured",
    "land before": "always the land before is measured",
    "bar": "another bar after two lands, 0.2 mm thicker",
    "stock": "the diameter of the stock is typed 0.5 mm too large",
    "deeper": "X is 0.1 mm deeper at the second cut",
    "depth": "the bar is 0.3 mm thinner below two lands",
    "tool": "the second pair is cut by another tool",
    "chip 2": "the edge chips before land 2",
    "chip 3": "the edge chips before land 3",
    "chip 4": "the edge chips before land 4",
    "chip check": "the edge chips before the check",
    "chip store": "the edge chips before the land after the store",
    "slip 4": "the insert slips inward before land 4",
    "chatter": "chatter: each radius scatters by 6 um",
    "burr": "a burr of 10 to 40 um on one land",
    "oval": "an oval bar, one reading a land",
    "oval twice": "an oval bar, two readings a land",
    "zero": "the micrometer's zero is 20 um off: X as it shows it",
    "backlash": "Y comes from above at every second cut",
    "operators": "another operator corrects X before the store",
    "power": "the power fails at some step",
    "warming": "a cold machine: X grows by 30 um",
}
FIRST = {"chip 2": 1, "chip 3": 2, "chip 4": 3, "slip 4": 3, "chip check": 4, "chip store": 5}


@dataclasses.dataclass(frozen=True)
class StrangerCase:
    plant: int  # 1 sim_lathe, 2 the second lathe
    slip: str


# Each machine and each stranger is a generator of periods: it yields what it sets before a period, and the pins whose values it gets behind it.


class SimPlant:
    """sim_lathe, moved as a program would."""

    FIXED = {"stock-length": 100, "gauge-time": 0, "laser-noise": 0, "linearity": 0, "coolant-film": 0, "work-warmth": 0}

    def draw(self, seed, height, x_error, growth):
        drawn = random.Random("stranger %d" % seed)
        self.elapsed, self._shift = 0.0, (0.0, 0.0)
        self._height, self._x_error = height, x_error
        yield from self._set(self.FIXED)
        yield from self._set({"seed": seed, "stock-diameter": STOCK, "elapsed": 0, "cutting-force": drawn.uniform(1, 30), "x-growth": growth or drawn.uniform(0.005, 0.03)})
        yield from self._tip()
        yield from self.new_bar(STOCK)

    def _set(self, values):
        yield {"lathe." + name: value for name, value in values.items()}, ()

    def new_bar(self, diameter):
        yield from self._set({"x-position": CLEAR, "stock-diameter": diameter, "new-stock": True})
        yield from self._set({"new-stock": False})

    def change(self, radial, height):
        """Another edge: further out by so much, and higher."""
        self._shift = (self._shift[0] + radial, self._shift[1] + height)
        yield from self._tip()

    def _tip(self):
        height = self._height + self._shift[1]
        yield from self._set({"height-error": abs(height), "side": 1 if height >= 0 else -1, "x-error": self._x_error + self._shift[0]})

    def cut(self, x, y, z, _before, from_above):
        """The radius that is left, the effective height of the tip against Y, and its x against X."""
        self.elapsed += 60
        yield from self._set({"elapsed": self.elapsed, "y-position": y + (0.2 if from_above else -0.2), "x-position": CLEAR})
        yield from self._set({"y-position": y, "z-position": z})
        yield from self._set({"x-position": x + WORK.pass_depth})
        yield from self._set({"x-position": x})
        effective, diameter = yield {}, ("lathe.truth-effective-height", "lathe.truth-diameter")
        yield from self._set({"x-position": CLEAR})
        radius = diameter / 2
        return radius, effective - y, math.sqrt(max(radius**2 - effective**2, 0)) - x


class SecondPlant:
    """The lathe of second_lathe.py."""

    def draw(self, seed, height, x_error, growth):
        self._lathe = SecondLathe(WORK, seed, False)
        self._lathe.height, self._lathe.x_error = height, x_error
        if growth:
            self._lathe._growths = [(growth, 900)]
            self._lathe._time = 0
        yield from ()

    def new_bar(self, diameter):
        yield from ()

    def change(self, radial, height):
        self._lathe.x_error += radial
        self._lathe.height += height
        yield from ()

    def cut(self, x, y, z, before, from_above):
        yield from ()
        if from_above:
            y += self._lathe._y_backlash
        left = self._lathe.cut(x, y, z, before, WORK.pass_depth)
        return left if left else (before, self._lathe.height, self._lathe.x_error)


class Stranger:
    """One stranger at one lathe: what he has stored, and what became of it."""

    def __init__(self, plant, case, seed):
        self.plant, self.slip = plant, case.slip
        drawn = self.drawn = random.Random("slip %s %d %d" % (case.slip, case.plant, seed))
        reach = WORK.highest if drawn.random() < 0.5 else NEAR
        growth = 0.03 if case.slip == "warming" else 0
        self.drawing = (seed, drawn.uniform(-1, 1) * reach, drawn.uniform(-0.05, 0.05), growth)
        self.x_offset = self.y_offset = 0.0  # of the tool table
        self.chip = drawn.uniform(0.01, 0.06)
        self.oval, self.noise = drawn.uniform(0.005, 0.03), drawn.uniform(0.001, 0.002)
        self.power = drawn.randrange(7)
        self.counts = dict.fromkeys(("moves", "worse", "worse x", "claims", "wrong", "back"), 0)
        self.truth = None  # height and x of the tip, at the axes' zero, of the last cut

    def work(self):
        yield lathe_hall.settings(SETTINGS), ()
        yield from self.plant.draw(*self.drawing)
        for round_ in range(ROUNDS):
            self.first = round_ == 0  # the slip is made once
            self.z = 60
            if (yield from self.measure()):
                break
        return self.counts

    def begin(self, show=False):
        values = {"program-method": 6 if show else 2, "program-cuts": 1 if show else 4, "x-zero-0": self.x_offset, "y-position-0": self.y_offset}
        yield from lathe_hall.begin(values | {"x-position-0": self.x_offset + CLEAR, "entered-diameter": 0})

    def measure(self):
        """A round. Returns whether the stranger has done."""
        self.radii, self.true, self.read = [], [], []
        if not self.first:
            yield from self.plant.new_bar(STOCK)
        stock = STOCK + (0.5 if self.slip == "stock" and self.first else 0)
        yield {"centre.stock-diameter": stock - 0.002}, ()
        yield from self.begin()
        while len(self.true) < MOST:
            if self.slip == "power" and self.first and len(self.true) == self.power:
                self.first = False
                return False
            due, check, x, y, needed, status = yield from lathe_hall.get("cut-due", "check-due", "next-x", "next-y", "cuts-needed", "status-code")
            if not due:
                if not needed > len(self.true) or needed > 16:
                    return False
                x, y, check = WORK.diameter / 2, (1 if len(self.true) % 4 in (0, 3) else -1) * WORK.step, False
            if not (yield from self.cut(x, y, check)):
                return False
            move, x_moves, centred, status = yield from lathe_hall.get("move-allowed", "x-allowed", "on-centre", "status-code")
            if centred:
                height, x_error = self.errors()
                self.counts["claims"] += 1
                self.counts["wrong"] += max(abs(height), abs(x_error)) > WORK.tolerance
                return True
            if move or x_moves:
                return (yield from self.store())
            if status == REFUSED:
                return False
        return False

    def errors(self):
        """Of the tool as it is stored: height on Y0, and the programmed radius, as the micrometer shows it: no cut shows its zero."""
        return self.truth[0] + self.y_offset, self.truth[1] + self.x_offset + (ZERO / 2 if self.slip == "zero" else 0)

    def cut(self, x, y, again):
        """Turns, measures and types one cut. Returns False if the stranger gives up."""
        k, slip, first = len(self.true), self.slip, self.first
        stock = STOCK / 2
        if first and FIRST.get(slip) == k and slip != "chip store":
            yield from self.chip_now()
        if first and slip == "tool" and k == 2:
            yield from self.plant.change(0.03, -0.12)
        if first and slip == "bar" and k == 2:
            yield from self.plant.new_bar(STOCK + 0.2)
        if first and slip == "bar" and k >= 2:
            stock += 0.1
        if slip == "depth" and k in (1, 2):
            stock -= 0.15
        before = self.radii[-1] if again and self.radii else stock
        deeper = 0.1 if first and slip == "deeper" and k == 1 else 0
        place = (x + self.x_offset, y + self.y_offset)
        scatter = self.drawn.gauss(0, 0.006) if slip == "chatter" else 0
        z = self.z - 1.5 * (k - 1 if again else k)
        left, height, x_tip = yield from self.plant.cut(place[0] - deeper + scatter, place[1], z, before, slip == "backlash" and k % 2 == 1)
        self.truth = (height, x_tip)
        self.radii.append(left)
        self.true.append(2 * left)
        yield from lathe_hall.end_of_cut(place[0] - deeper, place[1])
        for attempt in range(3):
            diameter, second = self.reading(k, attempt, again)
            if attempt:
                yield {"centre.entered": False}, ()
            yield from lathe_hall.enter(diameter, second)
            waits, = yield from lathe_hall.get("measure")
            if not waits:
                return True
        return False

    def chip_now(self):
        out = -1 if self.slip.startswith("slip") else 1
        yield from self.plant.change(out * self.chip, -out * self.chip / 2)

    def reading(self, k, attempt, again):
        """What he reads of the cut, at one angle and, where he is asked for it, at another; what is refused he reads again, and now rightly
        unless it is a habit."""
        true, drawn, slip = list(self.true), self.drawn, self.slip
        noise = lambda: drawn.gauss(0, self.noise)  # noqa: E731
        which, habit = k, self.first
        if slip == "same land":
            which = 0
        elif slip == "land before":
            which = max(k - 1, 0)
        elif slip == "swapped all" and k < 4:
            return self.swap(k) + noise(), 0
        value, second = true[which] + noise(), true[which] + noise() if again or slip == "oval twice" else 0
        if slip.startswith("oval"):
            lobe = self.oval * math.cos(drawn.uniform(0, 2 * math.pi))
            return value + lobe, second - lobe if second else 0
        if slip == "zero":
            value, second = value + ZERO, second + ZERO if second else 0
        if slip == "radii" and habit and attempt < 2:
            return value / 2, 0
        if attempt or not habit:
            return value, second
        if slip == "swapped" and k in (0, 1):
            return self.swap(k) + noise(), 0
        at = {"radius": 1, "inch": 2, "turn": 0, "turn less": 1, "digit": 2, "small digit": 2, "burr": 3}
        if at.get(slip) == k:
            factor = {"radius": 0.5, "inch": 1 / 25.4}.get(slip, 1)
            off = {"turn": 0.5, "turn less": -0.5, "digit": 0.1, "small digit": 0.01, "burr": drawn.uniform(0.01, 0.04)}.get(slip, 0)
            return value * factor + off, second
        return value, second

    def swap(self, k):
        """The diameter of the land on the other side: of this one, as if Y had been the other way."""
        x, height = self.radii[k], self.truth[0] + self.y_offset
        y = WORK.step * (1 if k % 4 in (0, 3) else -1)
        tip = math.sqrt(max(x**2 - (y + height) ** 2, 0))
        return 2 * math.hypot(tip, -y + height)

    def store(self):
        """Stores what may be stored, and turns the land that must show it. Returns whether the stranger has done: never, he measures again."""
        old = self.x_offset, self.y_offset
        move, y_move, x_moves, x_correction = yield from lathe_hall.get("move-allowed", "y-move", "x-allowed", "x-correction")
        if self.first and self.slip == "operators":
            self.x_offset += 0.03  # M454 asks, and adds the correction to it
        self.y_offset += y_move if move else 0
        self.x_offset += x_correction if x_moves else 0
        for value in (True, False):
            yield {"centre.stored": value}, ()
        if self.slip == "power" and self.first and self.power == 5:
            self.count(move, old)
            return False
        if self.first and self.slip == "chip store":
            yield from self.chip_now()
        yield from self.begin(show=True)
        x, y = yield from lathe_hall.get("next-x", "next-y")
        yield from self.cut(x, y, True)
        shown, = yield from lathe_hall.get("shown")
        if shown:
            self.count(move, old)
        else:
            self.counts["back"] += 1
            self.x_offset, self.y_offset = old
        return False

    def count(self, move, old):
        height, x_error = self.errors()
        self.counts["moves"] += 1
        self.counts["worse"] += bool(move) and abs(height) > abs(self.truth[0] + old[1])
        self.counts["worse x"] += abs(x_error) > abs(x_error - self.x_offset + old[0]) + 0.001


SETTINGS = {"land-step": WORK.step, "land-diameter": WORK.diameter, "largest-burr": 0.04, "tolerance": WORK.tolerance, "pass-depth": WORK.pass_depth}


def simulate_strangers(case, seeds, progress):
    """The counts of all lathes of a row."""
    return lathe_hall.results((Stranger((SimPlant if case.plant == 1 else SecondPlant)(), case, seed).work() for seed in seeds), progress)


def cases():
    return [StrangerCase(plant, slip) for plant in (1, 2) for slip in SLIPS]


def upper(wrong, claims):
    """The largest share with which so few come in one of 20 cases: Clopper and Pearson."""
    low, high = wrong / max(claims, 1), 1.0
    for _ in range(50):
        share = (low + high) / 2
        few = sum(math.comb(claims, k) * share**k * (1 - share) ** (claims - k) for k in range(wrong + 1))
        low, high = (share, high) if few > 0.05 else (low, share)
    return high


def total(counts):
    return {name: sum(each[name] for each in counts) for name in counts[0]}

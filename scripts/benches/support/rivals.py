# SPDX-License-Identifier: GPL-2.0-or-later
"""Simple rivals of thermal_displacement's estimator, replayed over recorded contacts. Lengths in um, times in s, speeds in rpm.

A rival hears speed(time, rpm) and contact(time, key, tool, cycle, growth, sigma), in the order of time. out(time) returns its offset,
the sigma of it, and what it tells: 0 for nothing, 4 a question about one tool, 6 a question about all, 9 that it is uncertain.

They are references, and stay as they are: a figure is compared with theirs over years.
"""

import math

import numpy as np

ANSWER = [("offset", float), ("sigma", float), ("told", float)]


class Hold:
    """The last contact, if it lies within a gate that opens with time; else two contacts of other cycles that agree.

    It has no sigma and asks no question.
    """

    def __init__(self):
        self.growth, self.time, self.known, self.claim = 0.0, 0.0, False, None

    def speed(self, time, rpm):
        """It has no use for it."""

    def contact(self, time, key, tool, cycle, growth, sigma):
        gate = min(max(0.2 * (time - self.time), 15), 60) if self.known else 15
        if abs(growth - self.growth) > gate and (self.claim is None or abs(growth - self.claim) > 15):
            self.claim = growth
            return
        self.growth, self.time, self.known, self.claim = growth, time, True, None

    def out(self, time):
        return self.growth, 2.0, 0


class Simple3:
    """One Kalman filter, one outlier test, one question.

    The state is a growth, a gain by which the growth follows the speed through a lag, and an error of each reference. A jump beyond
    the test waits for a second contact that agrees. Which tools share it decides: a jump of one tool while another one stands is
    that tool's, a jump of all is the work's; both are left out and asked about, one at a time. Growth is a jump that the gain or the
    rate seen so far explains, and each jump after a question: such a machine is lively, and if it goes back, the first jump was
    growth, too. The rate of growth that the speed does not explain, and the scatter of the contacts, are learned on the way.
    """

    REPEATABILITY = 1.0  # um, of a contact by seat and blank
    GAIN = 15.0  # um of growth to expect at 5000 rpm
    TEST = 3.5  # sigma, of the outlier test
    TOLERANCE = 10.0  # um of the work: half of it matters in a question, a larger sigma is told
    LAG = 600.0  # s, of the growth behind a turning spindle; four times that at rest
    RATE = 0.05  # um/s of growth that is never a shift
    MOST = 60.0  # um that the growth moves unforeseen between two contacts
    HARM = 5.0  # um of offset that are applied although they may be noise
    TRANSIENT = 0.5  # part of the gain's way to its balance that a jump may be
    ROBUST = 2.5  # sigma, beyond which a contact does not show the scatter

    def __init__(self):
        self.x = [0.0, self.GAIN]
        self.covariance = [[4.0, 0.0], [0.0, self.GAIN**2]]
        self.index = {}  # of a key in the state
        self.driven = self.driven_then = self.heat = self.mean_heat = 0.0
        self.rest = 4
        self.time = self.last = None  # now, and at the last contact that counted
        self.known = False
        self.rate2, self.rates = 0.01**2, 3.0  # (um/s)², and the contacts that it is a mean of
        self.scatter2, self.scatters = (1.5 * self.REPEATABILITY) ** 2, 5.0  # um²
        self.pending = []  # outliers: error, variance, tool, cycle, key
        self.ask = None  # the question: 4 or 6, and the size of the jump
        self.shift = {}  # left out: by tool, and 0 for all
        self.tools = {}  # the last cycle of each

    def speed(self, time, rpm):
        self._advance(time)
        self.heat = (abs(rpm) / 5000.0) ** 1.7
        self.rest = 1 if abs(rpm) > 1 else 4

    def _advance(self, time):
        if self.time is not None and time > self.time:
            self.driven += (self.heat - self.driven) * (1 - math.exp(-(time - self.time) / (self.LAG * self.rest)))
            self.mean_heat += (self.heat - self.mean_heat) * (1 - math.exp(-(time - self.time) / 200.0))
        self.time = time if self.time is None else max(self.time, time)

    def _unforeseen(self, time):
        """Variance of the growth since the last contact that counted, s since then, and the s² of a rate that changes."""
        since = max(time - (self.last if self.last is not None else time - 60), 1.0)
        squared = since * min(since, 300.0)
        of_speed = (0.35 * self.x[1] * (self.driven - self.driven_then)) ** 2
        return min(self.rate2 * squared + of_speed + 36.0 * since / 3600, self.MOST**2), since, squared

    def _row(self, key):
        """How the state shows in a contact."""
        if key not in self.index:
            self.index[key] = len(self.x)
            self.x.append(0.0)
            for row in self.covariance:
                row.append(0.0)
            self.covariance.append([0.0] * len(self.x))
            self.covariance[-1][-1] = 2 * self.REPEATABILITY**2
        return [1.0, self.driven] + [1.0 if i == self.index[key] else 0.0 for i in range(2, len(self.x))]

    def contact(self, time, key, tool, cycle, growth, sigma):
        self._advance(time)
        row = self._row(key)
        unforeseen, since, squared = self._unforeseen(time)
        growth -= self.shift.get(0, 0.0) + self.shift.get(tool, 0.0)
        self.tools[tool] = cycle
        gain = [sum(a * b for a, b in zip(its, row)) for its in self.covariance]
        noise = sigma * sigma + self.scatter2
        variance = sum(a * b for a, b in zip(gain, row)) + noise + unforeseen
        error = growth - sum(a * b for a, b in zip(self.x, row))
        if abs(error) > self.TEST * math.sqrt(variance) and abs(error) > 4:
            found = self._jump(error, noise, tool, cycle, key, since, squared)
            if found is None:
                return
            error = found
            variance += error * error
            self.covariance[0][0] += error * error
            gain[0] += error * error
        elif self.pending and len(self.pending) > 1 and not self.ask and all(its[2] != tool for its in self.pending):
            self._leave_out(self.pending[0][2], sum(its[0] for its in self.pending) / len(self.pending), 4)
        elif any(its[3] < cycle for its in self.pending) and any(its[2] == tool for its in self.pending):
            self.pending = []  # it did not come again
        self._learn(error, variance, unforeseen, squared)
        self.covariance[0][0] += unforeseen
        gain[0] += unforeseen
        weights = [its / variance for its in gain]
        for i, weight in enumerate(weights):
            self.x[i] += weight * error
        for i, weight in enumerate(weights):
            for j, its in enumerate(gain):
                self.covariance[i][j] -= weight * its
        self.last, self.driven_then, self.known = time, self.driven, True

    def _jump(self, error, noise, tool, cycle, key, since, squared):
        """The error that counts as growth, or None."""
        alike = [its for its in self.pending if abs(error - its[0]) <= self.TEST * math.sqrt(noise + its[1])]
        confirmed = any((its[2], its[3]) != (tool, cycle) or its[4] != key for its in alike)
        if not confirmed:
            self.pending = [(error, noise, tool, cycle, key)]
            return None
        self.pending = alike + [(error, noise, tool, cycle, key)]
        tools = {its[2] for its in self.pending}
        others = [its for its, last in self.tools.items() if its not in tools and last >= cycle - 1]
        size = sum(its[0] / its[1] for its in self.pending) / sum(1 / its[1] for its in self.pending)
        usual = max(self.RATE * since, 3 * math.sqrt(self.rate2 * squared))
        lively = self.ask is not None or abs(size) <= usual + self.TRANSIENT * abs(self.x[1]) * abs(self.mean_heat - self.driven)
        if not lively:
            if len(tools) > 1 or not others:
                self._leave_out(0, size, 6)
            elif len(self.pending) > 2 or len({its[3] for its in self.pending}) > 1:
                self._leave_out(tool, size, 4)
            return None
        if self.ask and size * self.ask[1] < 0 and abs(size + self.ask[1]) < abs(self.ask[1]):  # it goes back: that was growth, too
            error += self.ask[1]
            self.shift, self.ask = {}, None
        return error

    def _leave_out(self, tool, size, question):
        self.shift[tool], self.ask, self.pending = self.shift.get(tool, 0.0) + size, (question, size), []

    def _learn(self, error, variance, unforeseen, squared):
        """The rate of growth, and the scatter of the contacts."""
        rest = variance - unforeseen
        shows = (1 / (1 + rest / max(self.rate2 * squared, 1e-9))) ** 2
        self.rates = min(self.rates + shows, 20)
        step = min((error * error - rest) / squared, 16 * self.rate2) - self.rate2
        self.rate2 = max(self.rate2 + shows / self.rates * step, 0.002**2)
        shows = (self.scatter2 / variance) ** 2 if error * error < self.ROBUST**2 * variance else 0.0
        self.scatters = min(self.scatters + shows, 20)
        step = min(error * error - (variance - self.scatter2), 16 * self.scatter2) - self.scatter2
        self.scatter2 = max(self.scatter2 + shows / self.scatters * step, (0.5 * self.REPEATABILITY) ** 2)

    def estimate(self, time):
        """Growth and its sigma."""
        self._advance(time)
        driven, covariance = self.driven, self.covariance
        variance = covariance[0][0] + 2 * driven * covariance[0][1] + driven * driven * covariance[1][1]
        return self.x[0] + self.x[1] * driven, math.sqrt(max(variance + self._unforeseen(time)[0], 0.0))

    def out(self, time):
        """A growth that may be noise is applied in part."""
        if not self.known:
            return 0.0, 99.0, 0
        growth, sigma = self.estimate(time)
        sigma = math.hypot(sigma, math.sqrt(3 * self.scatter2))
        sure = self.HARM + 2 * (abs(growth) - 3 * sigma)
        offset = math.copysign(min(abs(growth), max(sure, self.HARM * min(max(abs(growth) / sigma - 1, 0), 1))), growth)
        expected = math.hypot(sigma, growth - offset)
        asks = self.ask and abs(self.ask[1]) > 0.5 * self.TOLERANCE
        return offset, expected, self.ask[0] if asks else 9 if expected > self.TOLERANCE else 0


class Both(Simple3):
    """Simple3, with an open question as two hypotheses.

    While it is open, the offset is the mean of both answers, moved to where neither answer makes a cut much worse than no
    compensation does. Its price: a large growth is held back until somebody answers.
    """

    GROWTH = 0.5  # probability that the jump is growth
    WORSE = 3.0  # um by which a cut may be worse than without compensation

    def out(self, time):
        if not self.known:
            return 0.0, 99.0, 0
        offset, sigma, told = super().out(time)
        size = self.shift.get(0, 0.0)
        if not self.ask or abs(size) <= 1:
            return offset, sigma, told
        if_shift, sigma = self.estimate(time)
        if_growth = if_shift + size
        low = max(if_shift - abs(if_shift), if_growth - abs(if_growth)) - self.WORSE
        high = min(if_shift + abs(if_shift), if_growth + abs(if_growth)) + self.WORSE
        mean = self.GROWTH * if_growth + (1 - self.GROWTH) * if_shift
        offset = min(max(mean, low), high) if low <= high else (low + high) / 2
        return offset, math.hypot(sigma, abs(size) / 2), told


SIMPLE = {"Hold": Hold, "Simple3": Simple3}  # beside thermal_displacement in each table


def answers(lines, rival):
    """What a rival answers at each cut of a file of support/contacts.py, as rows of ANSWER."""
    found = []
    for line in lines:
        kind, time, *values = line.split()
        if kind == "cut":
            found.append(rival.out(float(time)))
        elif kind == "contact":
            key, tool, cycle, growth, sigma = values[:5]
            rival.contact(float(time), int(key), int(tool), int(cycle), float(growth), float(sigma))
        elif kind == "speed":
            rival.speed(float(time), float(values[0]))
    return np.array(found, ANSWER)

# SPDX-License-Identifier: GPL-2.0-or-later
"""How long a test of thermal growth still runs, and how far its bores have moved. Without a screen."""

import math

FEWEST = 6  # values for a line
WIDTH = 3  # of the uncertainty, in sigmas: a few values scatter more than their sigma shows


INTERRUPTED = 5  # state-code


def resumable(machine, values):
    """Whether growth_log has given an interrupted test back."""
    return any(log.value(values, "resumable") for log in machine.of("growth_log"))


class LiveDrift:
    """Drift of each bore at each orientation since the first visit that was seen: {(bore, turned): (x, y, z)}."""

    def __init__(self):
        self.now = {}
        self._first, self._visits, self._probed = {}, 0, None

    def observe(self, visits, at_bore, counts, key, position):
        """A look at the pins. visits is the number of the present visit, and key that of its bore, while at_bore; when that ends, position
        is the centre of the bore, and counts is whether it counts."""
        if visits < self._visits:  # another test
            self.now, self._first = {}, {}
        self._visits = visits
        if at_bore:
            self._probed = visits, key
            return
        if self._probed and self._probed[0] == visits and counts and all(map(math.isfinite, position)):
            key = self._probed[1]
            first = self._first.setdefault(key, position)
            self.now[key] = tuple(now - then for now, then in zip(position, first))
        self._probed = None


def remaining(changes, threshold, elapsed, shortest, longest):
    """Shortest, likely and longest time to go in s.

    changes    pairs of time in s and temperature-change in K, the oldest first; 1000 K and more is unknown
    threshold  in K; the machine is warm when the change stays below it
    elapsed    time of the test in s; it takes at least `shortest`, at most `longest`

    A machine that warms towards its end changes less and less, by the same part in the same time. So the logarithm of the change
    is a line over time, fitted by least squares to the later half; its scatter gives the uncertainty.
    """
    least, most = max(0.0, shortest - elapsed), max(0.0, longest - elapsed)
    points = [(when, math.log(change)) for when, change in changes if 0 < change < 1000]
    points = points[-max(FEWEST, len(points) // 2):]
    if threshold <= 0 or len(points) < FEWEST:
        return least, None, most
    count = len(points)
    middle, level = sum(when for when, _ in points) / count, sum(value for _, value in points) / count
    spread = sum((when - middle) ** 2 for when, _ in points)
    if spread == 0:
        return least, None, most
    slope = sum((when - middle) * (value - level) for when, value in points) / spread
    scatter = math.sqrt(sum((value - level - slope * (when - middle)) ** 2 for when, value in points) / (count - 2))
    sigma = scatter / math.sqrt(spread)  # of the slope
    now = points[-1][0]

    def crossing(its):
        """Time to go until the line with this slope is at the threshold; it goes through the middle of the points."""
        if level + its * (now - middle) <= math.log(threshold):
            return 0.0
        return (math.log(threshold) - level) / its - (now - middle) if its < 0 else math.inf

    low, likely, high = (min(most, max(least, crossing(slope + by * WIDTH * sigma))) for by in (-1, 0, 1))
    return low, likely, high

# SPDX-License-Identifier: GPL-2.0-or-later
"""How long a test of thermal growth still runs, and how far its bores have moved. Without a screen."""

import itertools
import math
import os

from panel.texts import _

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
        """A look at the pins. visits is the number of the present visit, and key the number of its bore, while at_bore; when that ends, position
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


def plan_in_words(plan):
    """Lines of what `plumb growth plan --json` gives: the cycles, equal ones together, and the terms with their uncertainty in Z."""
    def of(cycle):
        words = "%.0f rpm" % cycle["rpm"] if cycle["rpm"] else _("rest")
        return words + (", " + _("shop door open") if cycle["door"] else "")
    cycles = ["%d \u00d7 %s" % (len(list(same)), words) for words, same in itertools.groupby(map(of, plan["cycles"]))]
    lines = [_("{count} cycles of {work} min work and a pass:").format(count=len(plan["cycles"]), work="%g" % plan["work_min"]), "   ".join(cycles)]
    names = {"temperature of the spindle": _("temperature of the spindle"), "temperature of the structure": _("temperature of the structure"),
             "spindle speed": _("spindle speed"), "growth on another day": _("growth on another day")}
    lines += [_("{term}: \u00b1{after} {unit}, after another hour \u00b1{more}").format(
        term=names.get(term["name"], term["name"]), after="%.1f" % term["after"], unit=term["unit"].replace("u", "\u00b5", 1), more="%.1f" % term["hour_more"])
        for term in plan["terms"]]
    log = plan["machine"]["log"]
    return [*lines, _("For the machine of {log}.").format(log=os.path.basename(log)) if log else _("For a usual machine: there is no log that shows this one.")]

# SPDX-License-Identifier: GPL-2.0-or-later
"""Ways to R of axes that have learned, by the force of their drive: how far the axis goes beyond R and beyond the region."""

import random

from support.drives import PATIENCE, PLANTS, SETTINGS_IN_FORCE, UM, Drawn, forget_farthest, prepare

STRENGTHS = (1.02, 1.1, 1.3)  # times the force that the stroke needs
PLACES = (0, 1, -0.3, 1.4)  # of the stroke: R at a dead point and outside
WAYS = 6
DURATION = 150  # s, of a typical axis
UNTOLD = 6.0  # um: max-beyond, and a step of the scale


class Outcome:
    def __init__(self):
        self.beyond, self.seconds, self.told = [], [], 0  # um and s of each way; those that were told
        self.silent = 0  # ways


def simulate(plant, seed, strength, progress):
    """The ways of one axis, at drawn moments of the stroke; None if it has not learned the stroke."""
    import plumb

    drawn, outcome = Drawn(plant, seed), Outcome()
    draw = random.Random(f"end {plant} {seed} {strength}")
    drawn.limit = strength * drawn.acceleration
    end, cycle = draw.choice(PLACES) * drawn.stroke, 3.1416 * drawn.stroke / drawn.feed
    low, high = min(end, 0), max(end, drawn.stroke)
    with plumb.Host() as host:
        prepare(host, plant, seed, drawn, run=False)
        host.set("chop.position", end)
        host.run(5)
        host.set("chop.run", True)
        host.run(SETTINGS_IN_FORCE)
        while host.time < PATIENCE and host.get("chop.active") and not host.get("chop.learned"):
            host.run(cycle)
        host.run(4 * cycle)
        if not host.get("chop.learned"):
            progress(DURATION)
            return None
        for way in range(WAYS):
            host.run(draw.uniform(3, 4) * cycle)
            forget_farthest(host)
            host.set("chop.enable" if way % 2 else "chop.run", False)
            since = host.time
            while host.get("chop.active"):
                host.run(0.02)
            outcome.seconds.append(host.time - since)
            host.run(0.7)  # the axis stands
            fault = host.get("chop.fault-code") in (13, 24)
            outcome.beyond.append(UM * max(host.get("far.max") - high, low - host.get("far.min")))
            outcome.told += fault
            outcome.silent += outcome.beyond[-1] > UNTOLD and not fault
            host.set("chop.run", False)
            host.set("chop.enable", True)
            host.run(SETTINGS_IN_FORCE)
            host.set("chop.run", True)
    progress(DURATION)
    return outcome


def table(found):
    """The figures of {strength: outcomes}; None for an axis that had not learned."""
    lines = ["Ways to R at a dead point and up to 0.4 of the stroke outside; beyond R and the region in um"]
    lines.append(f"{'':42}{'axes':>6}{'ways':>6}{'beyond p50':>12}{'p95':>7}{'worst':>8}{'told':>6}{'silent':>8}{'time, s, p50':>14}{'p95':>7}")
    for strength, outcomes in found.items():
        its = [each for each in outcomes if each]
        beyond = sorted(way for each in its for way in each.beyond)
        seconds = sorted(way for each in its for way in each.seconds)
        cells = (
            f"{strength:g} times the force of the stroke".ljust(42),
            f"{len(its):6}{len(beyond):6}{max(beyond[len(beyond) // 2], 0):12.1f}{beyond[int(0.95 * len(beyond))]:7.1f}{beyond[-1]:8.1f}",
            f"{sum(each.told for each in its):6}{sum(each.silent for each in its):8}",
            f"{seconds[len(seconds) // 2]:14.2f}{seconds[int(0.95 * len(seconds))]:7.2f}",
        )
        lines.append("".join(cells))
    return lines


def rows(axes, found):
    """The header and a row for each way."""
    return ["plant", "seed", "strength", "beyond", "seconds"], [
        [*axis, f"{beyond:.2f}", f"{seconds:.2f}"] for axis, outcome in zip(axes, found) if outcome for beyond, seconds in zip(outcome.beyond, outcome.seconds)
    ]


def drawn_axes(seeds):
    return [(plant, seed, strength) for plant in PLANTS for strength in STRENGTHS for seed in seeds]

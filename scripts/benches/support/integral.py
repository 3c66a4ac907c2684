# SPDX-License-Identifier: GPL-2.0-or-later
"""The first strokes of new axes, whose position loops have an integral or none: how far they pass their dead points, and what is told."""

import random

from support.drives import LINES, SETTINGS_IN_FORCE, UM, Drawn, beyond, forget_farthest

LOOPS = {False: "without an integral", True: "with an integral"}
EARLY = 12  # strokes
PATIENCE = 200  # s, for an axis to learn
DURATION = 150  # s, of a typical axis
UNTOLD = 6.0  # um: max-beyond, and a step of the scale


class Outcome:
    def __init__(self):
        self.early = []  # um, beyond in each of the first strokes
        self.later = 0.0  # um, beyond in all others
        self.silent = 0  # strokes beyond without a fault
        self.fault = 0
        self.seconds = None  # until learned
        self.cycles = None

    first = property(lambda self: max(self.early))


def simulate(seed, integral, progress):
    """One axis of sim_elastic_axis, from its first stroke until it has learned."""
    import plumb

    drawn, outcome = Drawn("ram", seed), Outcome()
    draw = random.Random(f"integral {seed}")
    drawn.limit = draw.uniform(1.5, 3) * drawn.acceleration
    gain, ratio = draw.uniform(15, 60), draw.uniform(2, 20)
    settings = {
        "ram.seed": seed,
        "ram.force-limit": drawn.limit,
        "ram.friction": draw.uniform(0.05, 0.3) * drawn.limit,
        "ram.servo-gain": gain,
        "ram.integral-time": ratio / gain if integral else 0,
        "ram.feed-forward": draw.choice((0, draw.uniform(0, 1))),
        "chop.upper": drawn.stroke,
        "chop.feed": drawn.feed,
    }
    with plumb.Host() as host:
        for line in LINES.format(plant="ram", module="sim_elastic_axis").strip().splitlines():
            host.command(line)
        for name, value in settings.items():
            host.set(name, value)
        host.command("start")
        host.run(SETTINGS_IN_FORCE)
        host.set("chop.run", True)
        host.run(SETTINGS_IN_FORCE)
        forget_farthest(host)
        while host.time < PATIENCE and host.get("chop.active") and not host.get("chop.learned"):
            stroke(host, drawn, outcome)
        if host.get("chop.learned"):
            outcome.seconds, outcome.cycles = host.time, host.get("chop.stroke-count") / 2
    progress(DURATION)
    return outcome


def stroke(host, drawn, outcome):
    """Until the middle of the next stroke: the axis has turned then."""
    count, upward = host.get("chop.stroke-count"), host.get("chop.velocity") >= 0
    while host.get("chop.active") and (host.get("chop.stroke-count") == count or not middle(host, not upward)) and host.time < PATIENCE:
        host.run(0.02)
    far, fault = beyond(host, drawn), host.get("chop.fault-code")
    forget_farthest(host)
    if len(outcome.early) < EARLY:
        outcome.early.append(far)
    else:
        outcome.later = max(outcome.later, far)
    outcome.silent += far > UNTOLD and not fault
    outcome.fault = outcome.fault or fault


def middle(host, upward):
    return abs(host.get("chop.phase") - (90 if upward else 270)) < 45


def table(found):
    """The figures of {integral: outcomes}."""
    lines = [f"New axes of sim_elastic_axis with friction, until they have learned; beyond in um, in their first {EARLY} strokes and later"]
    lines.append(f"{'the position loop':24}{'axes':>6}{'learned':>9}{'told':>6}{'silent':>8}{'pass first':>12}{'worst':>8}{'pass later':>12}{'worst':>8}{'s, p50':>9}{'p95':>7}")
    for integral, outcomes in found.items():
        seconds = sorted(its.seconds if its.seconds is not None else PATIENCE for its in outcomes)
        cells = [
            f"{LOOPS[integral]:24}{len(outcomes):6}{sum(its.seconds is not None for its in outcomes):9}{sum(its.fault != 0 for its in outcomes):6}",
            f"{sum(its.silent > 0 for its in outcomes):8}{sum(its.first > UNTOLD for its in outcomes):12}{max(its.first for its in outcomes):8.1f}",
            f"{sum(its.later > UNTOLD for its in outcomes):12}{max(its.later for its in outcomes):8.1f}",
            f"{seconds[len(seconds) // 2]:9.1f}{seconds[int(0.95 * len(seconds))]:7.1f}",
        ]
        lines.append("".join(cells))
    return lines


def rows(axes, found):
    """The header and a row for each axis."""
    header = ["seed", "integral", *(f"stroke_{i + 1}" for i in range(EARLY)), "later", "silent", "fault", "seconds", "cycles"]
    return header, [
        [*axis, *(f"{far:.1f}" for far in its.early + [0] * (EARLY - len(its.early))), f"{its.later:.1f}", its.silent, its.fault, its.seconds, its.cycles]
        for axis, its in zip(axes, found)
    ]


def drawn_axes(seeds):
    return [(seed, integral) for integral in LOOPS for seed in seeds]

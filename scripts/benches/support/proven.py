# SPDX-License-Identifier: GPL-2.0-or-later
"""Strokes below the acceleration that an axis has proven: another feed, region or section, and the same one after a restart."""

import random

from support.drives import PATIENCE, PLANTS, SETTINGS_IN_FORCE, UM, WITHIN, Drawn, beyond, forget_farthest, prepare

KINDS = {"feed": "another feed", "region": "another region", "section": "a section", "restart": "after a restart"}
STROKES = 40  # that are watched
DURATION = 150  # s, of a typical axis
SOON = 3  # cycles
ROW = "lower upper speed acceleration sections lower-offset upper-offset lower-first upper-first reversal proven lower-slow upper-slow lower-shown upper-shown".split()


class Outcome:
    def __init__(self):
        self.cycles = None  # until both dead points stay within WITHIN
        self.beyond = self.beyond_later = self.error = 0.0  # um; later: once it was a twentieth of the stroke inside
        self.factor = 0.0  # of the speed, in the second cycle
        self.fault = 0

    soon = property(lambda self: self.cycles is not None and self.cycles <= SOON)


def simulate(plant, seed, progress):
    """By kind: the way of one axis that has learned another stroke before; None if that was not learned."""
    import plumb

    drawn, outcomes = Drawn(plant, seed), {}
    draw = random.Random(f"proven {plant} {seed}")
    with plumb.Host() as host:
        prepare(host, plant, seed, drawn)
        cycle = 3.1416 * drawn.stroke / drawn.feed
        while host.time < PATIENCE and not host.get("chop.learned") and not host.get("chop.fault"):
            host.run(cycle)
        if host.get("chop.fault") or not host.get("chop.learned"):
            return None
        host.run(4 * cycle)
        row = {name: host.get("chop.row-" + name) for name in ROW}
        for kind in KINDS:
            if kind != "restart":
                outcomes[kind] = another(host, plant, drawn, draw, kind)
    with plumb.Host() as host:
        prepare(host, plant, seed, drawn, run=False)
        for name, value in row.items():
            host.set("chop.restore-" + name, value)
        host.set("chop.restore", True)
        host.run(SETTINGS_IN_FORCE)
        outcomes["restart"] = watch(host, plant, 0, drawn.stroke, 3.1416 * drawn.stroke / drawn.feed)
    progress(DURATION)
    return outcomes


def another(host, plant, drawn, draw, kind):
    """A stroke that needs at most the proven acceleration, from the same R."""
    host.set("chop.run", False)
    while host.get("chop.active"):
        host.run(0.1)
    lower, upper, feed = 0.0, drawn.stroke, drawn.feed
    settings = {"chop.section-0-kind": 0, "chop.max-acceleration": 20000}
    if kind == "feed":
        feed *= draw.choice((1.01, draw.uniform(0.3, 1)))
    elif kind == "region":
        length = drawn.stroke * draw.uniform(0.5, 1.5)
        lower = -draw.uniform(0, 1) * length  # R is within
        upper = lower + length
        feed = (draw.uniform(0.3, 1) * drawn.acceleration * length / 2) ** 0.5
    else:  # slow in contact, amid the stroke
        low = draw.uniform(0.1, 0.5)
        settings.update({"chop.section-0-kind": 2, "chop.section-0-from": low * upper, "chop.section-0-to": (low + draw.uniform(0.1, 0.4)) * upper})
        settings.update({"chop.section-0-ratio": draw.uniform(0.2, 0.7), "chop.max-acceleration": drawn.acceleration})
    settings.update({"chop.lower": lower, "chop.upper": upper, "chop.feed": feed})
    for name, value in settings.items():
        host.set(name, value)
    host.run(SETTINGS_IN_FORCE)
    return watch(host, plant, lower, upper, 3.1416 * (upper - lower) / feed)


def watch(host, plant, lower, upper, cycle):
    outcome, last_bad = Outcome(), 0
    host.run(3)
    outcome.beyond = way_inside(host, plant, lower, upper)
    names = ["chop.stroke-count", "chop.active", "chop.speed-factor", f"{plant}.truth-upper", f"{plant}.truth-lower"]
    count, active, _, *seen = host.get(names)
    while count < STROKES and active:
        host.run(cycle / 10)  # each dead point lasts for a cycle
        count, active, factor, *now = host.get(names)
        for i, error in enumerate((now[0] - upper, lower - now[1])):
            if count and now[i] != seen[i] and UM * abs(error) > WITHIN:
                last_bad = max(last_bad, count)
        if count in (2, 3):
            outcome.factor = factor
        seen = now
        outcome.error = UM * max(abs(now[0] - upper), abs(lower - now[1]))
    outcome.fault = host.get("chop.fault-code")
    outcome.beyond_later = farthest(host, lower, upper)
    outcome.beyond = max(outcome.beyond, outcome.beyond_later)
    if active and outcome.error <= WITHIN:
        outcome.cycles = (last_bad + 1) // 2
    return outcome


def way_inside(host, plant, lower, upper):
    """Starts the strokes, and waits until the axis is a twentieth of the stroke inside. Returns how far it was beyond meanwhile, um.

    Friction lets an axis stand beyond R, which can be a dead point. No stroke has taken it there: until it has first been inside
    only what it goes farther out counts. From then on all counts.
    """
    stood = max(0, UM * (host.get(f"{plant}.truth-position") - upper), UM * (lower - host.get(f"{plant}.truth-position")))
    forget_farthest(host)
    host.set("chop.run", True)
    beyond = 0
    for within, allowed in ((0, stood), (0.05 * (upper - lower), 0)):
        while not lower + within <= host.get(f"{plant}.truth-position") <= upper - within and not host.get("chop.fault"):
            host.run(0.001)
        beyond = max(beyond, farthest(host, lower, upper) - allowed)
        forget_farthest(host)
    return beyond


def farthest(host, lower, upper):
    return UM * max(host.get("far.max") - upper, lower - host.get("far.min"))


def table(found):
    """The figures of {plant: outcomes by kind}; None for an axis that had not learned its first stroke."""
    lines = ["Axes that have learned one stroke, and make another one within the proven acceleration; beyond in um"]
    lines.append(f"{'':42}{'axes':>6}{'full speed in cycle 2':>23}{f'right in {SOON} cycles':>19}{'cycles p50':>12}{'p95':>6}{'worst':>7}{'beyond':>8}{'told':>6}{'silent':>8}")
    for plant, outcomes in found.items():
        for kind, words in KINDS.items():
            its = [each[kind] for each in outcomes if each]
            cycles = sorted(each.cycles if each.cycles is not None else STROKES for each in its)
            cells = (
                f"{PLANTS[plant]}, {words}"[:42].ljust(42),
                f"{len(its):6}{sum(each.factor == 1 for each in its):23}{sum(each.soon for each in its):19}",
                f"{cycles[len(its) // 2]:12}{cycles[int(0.95 * len(its))]:6}{cycles[-1]:7}{max(each.beyond for each in its):8.1f}",
                f"{sum(each.fault != 0 for each in its):6}{sum(each.cycles is None and not each.fault for each in its):8}",
            )
            lines.append("".join(cells))
    return lines


def rows(axes, found):
    """The header and a row for each stroke of the axes that had learned their first one."""
    names = "cycles factor beyond beyond_later error fault".split()
    learned = [(axis, outcomes) for axis, outcomes in zip(axes, found) if outcomes]
    return ["plant", "seed", "kind", *names], [
        [*axis, kind, *(getattr(its, name) for name in names)] for axis, outcomes in learned for kind, its in outcomes.items()
    ]

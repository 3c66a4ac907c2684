# SPDX-License-Identifier: GPL-2.0-or-later
"""Aborts at each phase, upward and downward, while an axis learns its stroke and after: seconds until the wheel is out of the work for good, by kind of abort."""

import random

from support.drives import PATIENCE, PLANTS, SETTINGS_IN_FORCE, UM, Drawn, beyond, forget_farthest, prepare

LOWER = 1  # of abort-kind
KINDS = {"by the dead point nearest R": 0, "by the upper one, which is clear": 2, "by the lower one, which is clear": LOWER}
STAGES = ("learning", "learned")
PHASES = 32  # even, half of them upward
ABORTS = 8  # of each axis and stage: four axes have each phase once
DURATION = 200  # s, of a typical axis
CLEAR = 0.5  # mm inside the dead point that is clear: a stroke that is not learned ends up to 0.3 mm inside
RETRACT = 10  # mm from the upper dead point to R
UNTOLD = 6.0  # um: max-beyond, and a step of the scale
LOOK = 0.005  # s


class Outcome:
    def __init__(self):
        self.phases, self.seconds, self.beyond, self.silent, self.promises = [], [], [], 0, []  # deg, s and um of each abort; s of way-out-time


def await_phase(host, phase):
    """Until the stroke passes it."""
    before = 0
    while host.get("chop.active"):
        after = (host.get("chop.phase") - phase) % 360
        if after < before - 180:
            return
        before = after
        host.run(LOOK)


def simulate(plant, seed, kind, stage, progress):
    """The aborts of one axis; None if it has not learned the stroke."""
    import plumb

    drawn, outcome = Drawn(plant, seed), Outcome()
    draw = random.Random(f"way out {plant} {seed} {stage}")  # the same cycles for each kind
    cycle = 3.1416 * drawn.stroke / drawn.feed
    with plumb.Host() as host:
        prepare(host, plant, seed, drawn, run=False)
        host.set("chop.abort-kind", kind)
        host.set("chop.position", drawn.stroke + RETRACT)
        host.run(5)
        for number in range(ABORTS):
            if number == 0 or stage == "learning":
                host.set("chop.forget", stage == "learning")
                host.run(0.01)
                host.set("chop.forget", False)
            host.set("chop.run", True)
            host.run(SETTINGS_IN_FORCE)
            while stage == "learned" and host.time < PATIENCE and host.get("chop.active") and not host.get("chop.learned"):
                host.run(cycle)
            if stage == "learned" and not host.get("chop.learned"):
                progress(DURATION)
                return outcome if outcome.seconds else None
            host.run(draw.uniform(*((2, 12) if stage == "learning" else (3, 5))) * cycle)
            outcome.phases.append((seed % 4 + 4 * number) * 360 / PHASES)
            await_phase(host, outcome.phases[-1])
            forget_farthest(host)
            outcome.promises.append(host.get("chop.way-out-time"))
            host.set("chop.enable", False)
            since = last = host.time
            while host.get("chop.active"):
                host.run(LOOK)
                place = host.get(f"{plant}.truth-position")
                if place > CLEAR if kind == LOWER else place < drawn.stroke - CLEAR:
                    last = host.time
            outcome.seconds.append(last - since)
            host.run(0.7)  # the axis stands
            outcome.beyond.append(beyond(host, drawn) if kind == LOWER else UM * -host.get("far.min"))
            outcome.silent += outcome.beyond[-1] > UNTOLD and host.get("chop.fault-code") not in (13, 24)
            host.set("chop.run", False)
            host.set("chop.enable", True)
            host.run(SETTINGS_IN_FORCE)
    progress(DURATION)
    return outcome


def table(axes, found):
    lines = [f"Aborts at {PHASES // 2} phases upward and as many downward: seconds until the wheel is clear of the work for good; R is above. Beyond a dead point in um"]
    lines.append(f"{'':12}{'way':36}{'aborts':>7}{'s, p50':>9}{'p95':>7}{'worst':>8}{'at, deg':>9}{'beyond p95':>12}{'worst':>8}{'silent':>8}{'late':>6}")
    for stage in STAGES:
        for name, kind in KINDS.items():
            its = [outcome for axis, outcome in zip(axes, found) if outcome and axis[2:] == (kind, stage)]
            seconds = sorted(each for outcome in its for each in zip(outcome.seconds, outcome.phases))
            far = sorted(each for outcome in its for each in outcome.beyond)
            if not seconds:
                continue
            late = sum(took > promised + 0.1 for outcome in its for took, promised in zip(outcome.seconds, outcome.promises))
            lines.append(
                f"{stage:12}{name:36}{len(seconds):7}{seconds[len(seconds) // 2][0]:9.2f}{seconds[int(0.95 * len(seconds))][0]:7.2f}"
                f"{seconds[-1][0]:8.2f}{seconds[-1][1]:9.0f}{far[int(0.95 * len(far))]:12.1f}{far[-1]:8.1f}{sum(outcome.silent for outcome in its):8}{late:6}"
            )
    return lines


def rows(axes, found):
    """The header and a row for each abort."""
    return ["plant", "seed", "kind", "stage", "phase", "seconds", "beyond"], [
        [*axis, f"{phase:.2f}", f"{seconds:.3f}", f"{far:.2f}"]
        for axis, outcome in zip(axes, found)
        if outcome
        for phase, seconds, far in zip(outcome.phases, outcome.seconds, outcome.beyond)
    ]


def drawn_axes(seeds):
    return [(plant, seed, kind, stage) for plant in PLANTS for stage in STAGES for kind in KINDS.values() for seed in seeds]

# SPDX-License-Identifier: GPL-2.0-or-later
"""Axes of two structures with 1.02 to 3 times the force that their stroke needs, or less than that later: learned, or told."""

import random

PLANTS = {"grinder": "sim_grinder", "ram": "sim_elastic_axis"}
UM = 1000  # per mm
WITHIN = 2.0  # um, of a learned dead point
PATIENCE = 400  # s, for an axis to learn
DURATION = 150  # s, of a typical axis
SETTINGS_IN_FORCE = 0.1  # s
WEAK = {False: "1.02 to 3 times the force", True: "0.4 to 1 times the force"}

LINES = """
loadrt threads name1=servo-thread period1=1000000
loadrt chopping names=chop interlock=no sections=4
loadrt {module} names={plant}
loadrt minmax names=far
net z-command chop.command => {plant}.position-cmd
net z-measured {plant}.position => chop.joint-feedback
net z-truth {plant}.truth-position => far.in
addf chop.update servo-thread
addf {plant}.update servo-thread
addf far servo-thread
setp chop.homed 1
setp chop.motion-enabled 1
setp chop.min-limit -300
setp chop.max-limit 500
setp chop.max-feed 2000
setp chop.max-rate 2000
setp chop.max-acceleration 20000
setp chop.max-output-accel 100000
setp chop.max-correction 8
setp chop.jerk-time 0.02
setp chop.learn 1
"""


class Drawn:
    """The stroke of an axis, and how strong its drive is against it."""

    def __init__(self, plant, seed, weak=False):
        draw = random.Random(f"{plant} {seed}")
        self.stroke = draw.uniform(10, 100)
        self.acceleration = draw.uniform(300, 3000) if plant == "ram" else draw.uniform(300, 6000)
        self.strength = draw.uniform(0.4, 1) if weak else draw.uniform(1.02, 3)
        self.later = draw.choice(("jam", "brown-out"))
        self.part = draw.uniform(0.1, 0.8)  # of the force that the stroke needs
        self.wait = draw.uniform(0, 1)  # cycles, until then
        self.limit = self.strength * self.acceleration
        self.feed = (self.acceleration * self.stroke / 2) ** 0.5


class Outcome:
    def __init__(self):
        self.error = self.beyond = self.beyond_later = 0.0  # um
        self.fault = self.fault_later = 0
        self.cycles = None  # to full speed
        self.strokes_until_told = None
        self.can = self.learned = self.affected = False

    silent = property(lambda self: not (self.learned or self.fault))
    late = property(lambda self: self.affected and (not self.fault_later or self.strokes_until_told > 1.1))  # samples of 0.02 strokes


def simulate(plant, seed, weak, progress):
    """One axis: it learns or is told, and later it jams or loses force."""
    import plumb

    drawn, outcome = Drawn(plant, seed, weak), Outcome()
    with plumb.Host() as host:
        prepare(host, plant, seed, drawn)
        learn(host, plant, drawn, outcome)
        if outcome.learned and not outcome.fault:
            fail(host, plant, drawn, outcome)
    progress(DURATION)
    return outcome


def prepare(host, plant, seed, drawn, run=True):
    for line in LINES.format(plant=plant, module=PLANTS[plant]).strip().splitlines():
        host.command(line)
    settings = {f"{plant}.seed": seed, f"{plant}.force-limit": drawn.limit, "chop.lower": 0, "chop.upper": drawn.stroke, "chop.feed": drawn.feed}
    if plant == "grinder":
        settings.update({"grinder.wheel-force": 0, "grinder.load-resonance": 0})
    for name, value in settings.items():
        host.set(name, value)
    host.command("start")
    host.run(SETTINGS_IN_FORCE)
    host.set("chop.run", run)
    host.run(SETTINGS_IN_FORCE)


def beyond(host, drawn):
    return UM * max(host.get("far.max") - drawn.stroke, -host.get("far.min"))


def forget_farthest(host):
    host.set("far.reset", True)
    host.run(0.001)
    host.set("far.reset", False)


def learn(host, plant, drawn, outcome):
    cycle = 3.1416 * drawn.stroke / drawn.feed
    forget_farthest(host)
    while host.time < PATIENCE and host.get("chop.active"):
        host.run(cycle / 4)
        if outcome.cycles is None and host.get("chop.speed-factor") == 1:
            outcome.cycles = host.get("chop.stroke-count") / 2
        fault = host.get("chop.fault-code")
        if fault and not outcome.fault:
            outcome.fault = fault
        if host.get("chop.learned") or outcome.fault not in (0, 13):
            break
    host.run(10 * cycle)
    outcome.fault = outcome.fault or host.get("chop.fault-code")
    outcome.beyond = beyond(host, drawn)
    outcome.error = max(abs(host.get(f"{plant}.truth-upper") - drawn.stroke), abs(host.get(f"{plant}.truth-lower"))) * UM
    outcome.learned = bool(host.get("chop.learned")) and outcome.error <= WITHIN
    friction = host.get("ram.truth-friction") if plant == "ram" else 0.3 * drawn.limit
    outcome.can = drawn.limit >= 1.1 * (drawn.acceleration + friction)


def fail(host, plant, drawn, outcome):
    cycle = 3.1416 * drawn.stroke / drawn.feed
    host.run(cycle * drawn.wait)
    forget_farthest(host)
    before = host.time
    if drawn.later == "jam":
        host.set("ram.jammed" if plant == "ram" else "grinder.friction", True if plant == "ram" else 30)
    else:
        part = drawn.part / drawn.strength
        host.set(f"{plant}." + ("force-part" if plant == "ram" else "force-limit"), part if plant == "ram" else part * drawn.limit)
    while host.time < before + 4 * cycle and not host.get("chop.fault"):
        host.run(cycle / 100)
    outcome.fault_later = host.get("chop.fault-code")
    outcome.strokes_until_told = (host.time - before) / (cycle / 2)
    host.run(cycle)
    outcome.beyond_later = beyond(host, drawn)
    errors = [abs(host.get(f"chop.{end}-error")) for end in ("upper", "lower")]
    outcome.affected = outcome.fault_later != 0 or max(outcome.beyond_later, UM * max(errors)) > 5


def table(results):
    """The figures of {(plant, weak): outcomes}."""
    lines = ["Axes by the force of their drive against the acceleration of the stroke; beyond in um, on the way to learned or told"]
    lines.append(f"{'':42}{'axes':>6}{'learned':>9}{'told':>6}{'silent':>8}{'beyond, able':>14}{'others':>8}{'cycles p50':>12}{'p95':>6}{'failed later':>14}{'late':>6}")
    for (plant, weak), outcomes in results.items():
        able = sorted(its.beyond for its in outcomes if its.can)
        others = sorted(its.beyond for its in outcomes if not its.can)
        cycles = sorted(its.cycles for its in outcomes if its.cycles is not None)
        failed = [its for its in outcomes if its.strokes_until_told is not None]
        cells = [
            f"{PLANTS[plant]}, {WEAK[weak]:24}"[:42].ljust(42),
            f"{len(outcomes):6}{sum(its.learned for its in outcomes):9}{sum(its.fault != 0 for its in outcomes):6}{sum(its.silent for its in outcomes):8}",
            f"{shown(able, -1):>14}{shown(others, -1):>8}{shown(cycles, len(cycles) // 2):>12}{shown(cycles, int(0.95 * len(cycles))):>6}",
            f"{len(failed):14}{sum(its.late for its in failed):6}",
        ]
        lines.append("".join(cells))
    return lines


def rows(axes, found):
    """The header and a row for each axis."""
    names = "learned fault beyond error cycles fault_later beyond_later strokes_until_told".split()
    return ["plant", "seed", "weak", *names], [[*axis, *(getattr(outcome, name) for name in names)] for axis, outcome in zip(axes, found)]


def shown(values, place):
    """One of the sorted values as text, "-" if there is none."""
    return "%.1f" % values[place] if values else "-"

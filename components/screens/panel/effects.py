# SPDX-License-Identifier: GPL-2.0-or-later
"""How far a write moves the axes, before it is written. Without a screen.

An effect has a Move for each axis that moves at once; without one the write moves nothing.
"""

import collections
import math

from panel import squareness_program as program, texts
from panel.settings import parsed
from panel.squareness_state import ANGLE, corrections
from panel.texts import _, in_micrometres, with_unit

Move = collections.namedtuple("Move", "axis by exact")
Move.__doc__ = "by is in machine units; if it is not exact, it is the largest distance either way."

ANNOUNCED = 0.001  # mm by which a move may differ from the announced one
LONG = 1  # mu, that is not shown in micrometres
SMALLEST = 5e-8  # mu, that counts as a move

# Settings of functions that move no axis when they are written: they act on contacts to come, or on rates and messages.
STILL = {
    "thermal_displacement": {
        "learn", "cycle-running", "cycle-complete", "acknowledge", "threshold", "release", "smoothing", "debounce", "baseline-time",
        "blanking-time", "load-latency", "reference-cycles", "window", "feed-tolerance", "feed-range", "lost-time-tolerance", "steady-time",
        "gate-floor", "gate-cap", "confirm-contacts", "max-correction", "verify", "verify-step", "max-rate", "tool-number", "operation",
        "wait-for-answer", "shift-is-not-growth", "change-is-zero", "change-is-depth", "date", "start-height", "clock-start", *("exclude-operation-%d" % place for place in range(8))},
    "squareness": {"max-rate", "settling-time", "stages-ramping", "coordinated", "motion-type", "path-velocity"},
    "axis_growth": {"max-rate", "cycle-running"},
    "axis_offset": {"max-rate", "allow-probing", "arm"},
    "joint_offset": {"ramp-rate", "max-rate", "joint-acceleration", "offset-acceleration"},
}


def effect(machine, writes, values, chain_program=None):
    """The moves of settings that are written together; `chain_program` is (chain, path of plumb-squareness)."""
    found = []
    by_instance = collections.defaultdict(dict)
    for write in writes:
        instance, short = write.instance, write.short
        switched, on = machine.switching(write)
        if switched is not None:
            by_instance[switched.name]["enable"] = on
        else:
            by_instance[instance.name][short] = parsed(write.name, instance.pins[short].kind, write.text)
    for name, changes in by_instance.items():
        instance = machine.named(name)
        changes = {short: value for short, value in changes.items() if short == "enable" or value != instance.value(values, short)}
        changes = {short: value for short, value in changes.items() if short not in STILL.get(instance.module, ())}
        of_module = OF_MODULE.get(instance.module, _of_declared)
        if changes:
            found += of_module(machine, instance, changes, values, chain_program)
    return [move for move in found if not abs(move.by) < SMALLEST]


def changes_path(writes, values):
    """Whether an axis moves otherwise than before as soon as the machine moves, wherever it stands now."""
    def acts(write):
        instance = write.instance
        changed = parsed(write.name, instance.pins[write.short].kind, write.text) != instance.value(values, write.short)
        return changed and instance.value(values, "enable") and instance.value(values, "all-homed")

    return any(write.instance.module == "squareness" and write.short not in STILL["squareness"] and acts(write) for write in writes)


def are_same(moves, announced):
    """Whether a finger that allowed the announced moves has allowed these."""
    now, then = ({(move.axis, move.exact): float(move.by) for move in each} for each in (moves, announced))
    most = ANNOUNCED / (25.4 if texts.MACHINE_UNIT[0] == "in" else 1)
    return all(abs(now.get(key, 0.0) - then.get(key, 0.0)) <= most for key in now.keys() | then.keys())


def in_words(moves):
    """A sentence for a question; '' if nothing moves."""
    exact = ", ".join("%s %s" % (move.axis, _by(float(move.by))) for move in moves if move.exact)
    bounds = ", ".join("%s \u00b1%s" % (move.axis, with_unit(abs(float(move.by)), "mu")) for move in moves if not move.exact)
    return " ".join(text for text in (_("It moves: {moves}.").format(moves=exact) if exact else "",
                                      _("It may move, at most: {moves}.").format(moves=bounds) if bounds else "") if text)


def _by(distance):
    """A distance with its sign: in micrometres, or in the machine unit where it is long."""
    return ("+" if distance > 0 else "") + with_unit(round(distance, 4), "mu") if abs(distance) >= LONG else in_micrometres(distance)


def _of_squareness(machine, instance, changes, values, chain_program):
    now = corrections(machine, instance, values)
    if "enable" in changes:
        if not changes["enable"]:
            return [Move(axis, -by, True) for axis, by in now.items()]
        if instance.value(values, "enable"):
            return []
        # The error without correction, which the correction takes away.
        return [Move(axis, -instance.value(values, axis.lower() + "-error", 0.0) - by, True) for axis, by in now.items()]
    if not instance.value(values, "enable") or not instance.value(values, "all-homed"):
        return []
    if chain_program and all(ANGLE.match(short) for short in changes) and not instance.value(values, "axis-direction"):
        try:
            return _of_angles(instance, changes, values, chain_program)
        except program.Refused:
            pass
    bound = abs(instance.value(values, "max-correction", 1.0))
    return [Move(axis, abs(by) + bound, False) for axis, by in now.items()]


def _of_angles(instance, changes, values, chain_program):
    """To first order: the correction is the negative of the error that the change of an angle makes here."""
    largest = abs(instance.value(values, "max-angle", 0.0))

    def bounded(angle):
        return max(-largest, min(largest, angle))

    moved = dict.fromkeys("XYZ", 0.0)
    for lean in program.leans(*chain_program):
        if lean["pin"] not in changes:
            continue
        by = bounded(changes[lean["pin"]]) - bounded(instance.value(values, lean["pin"], 0.0))
        for each in lean["corrects"]:
            letter = each["moved"].lower()
            travel = instance.value(values, letter + "-position", 0.0) - instance.value(values, letter + "-pivot", 0.0)
            moved[each["error"]] -= by * each["factor"] * travel
        for each in lean["corrects_tool"]:
            moved[each["error"]] -= by * each["factor"] * _tool(instance, values, each["tool"])
    return [Move(axis, by, True) for axis, by in moved.items()]


def _tool(instance, values, axis):
    """The part of the tool along an axis, from the gauge point to the tip."""
    def get(short):
        return instance.value(values, short, 0.0)

    letter = axis.lower()
    radial = get("radial-offset") / (2 if instance.value(values, "radial-is-diameter") else 1)
    direction = math.radians(get("radial-direction"))
    along = {"X": radial * math.cos(direction), "Y": radial * math.sin(direction), "Z": 0.0}[axis]
    return along - get(letter + "-tool-offset") + get(letter + "-reference-tool-offset")


def _of_growth(machine, instance, changes, values, _chain_program):
    """Z returns at once; it follows the growth with the next cycle, or at once if its stage is armed."""
    applied = instance.value(values, "applied-offset", 0.0)
    on = {"enable": instance.value(values, "enable"), "dry-run": instance.value(values, "dry-run"), **changes}
    wanted = bool(on["enable"]) and not on["dry-run"] and bool(instance.value(values, "growth-known"))
    if not wanted:
        return [Move("Z", -applied, True)]
    if set(changes) <= {"enable", "dry-run"}:
        if not _follows_at_once(machine, instance, values):
            return []
        growth = instance.value(values, "growth-estimate", 0.0)
        bound = abs(instance.value(values, "max-offset", 0.0))
        return [Move("Z", max(-bound, min(bound, growth)) - applied, True)]
    return [Move("Z", abs(applied) + max(abs(instance.value(values, "max-offset", 0.0)), abs(changes.get("max-offset", 0.0))), False)]


def of_more_growth(machine, instance, values, by):
    """The moves that come at once if thermal_displacement takes so much more growth."""
    acts = instance.value(values, "enable") and not instance.value(values, "dry-run")
    return [Move("Z", by, True)] if acts and _follows_at_once(machine, instance, values) else []


def _follows_at_once(machine, instance, values):
    """Without an armed stage a function waits for the next cycle."""
    armed = [stage.value(values, "armed", True) for stage in machine.stages_of(instance).values()]
    return not armed or any(armed)


def _of_axis_growth(_machine, instance, changes, values, _chain_program):
    found = []
    for axis in "XYZ":
        now = instance.value(values, axis.lower() + "-offset", 0.0)
        if changes.get("enable") is False:
            found.append(Move(axis, -now, True))
        elif instance.value(values, "enable") or changes.get("enable"):
            found.append(Move(axis, abs(now) + abs(instance.value(values, "max-offset", 0.0)), False))
    return found


def _of_stage(_machine, instance, changes, values, _chain_program):
    now = instance.value(values, "applied-offset", 0.0)
    axis = instance.name
    if changes == {"enable": False}:
        return [Move(axis, -now, True)]
    sources = [instance.value(values, "offset-%d" % place, 0.0) for place in range(4)]
    if now == 0 and not any(sources) and not any(short.startswith("offset-") for short in changes):
        return []
    bound = max(abs(instance.value(values, "max-offset", 0.0)), abs(changes.get("max-offset", 0.0)))
    return [Move(axis, abs(now) + bound, False)]


def _of_chopping(_machine, instance, changes, values, _chain_program):
    if changes.get("go-to-end") or changes.get("enable") is False:
        return [Move(_("the stroking axis"), -instance.value(values, "offset", 0.0), True)]
    if "run" in changes and changes["run"]:
        away = [abs(instance.value(values, short, 0.0) - instance.value(values, "position", 0.0)) for short in ("upper", "lower")]
        return [Move(_("the stroking axis"), max(away), False)]
    return []


def _of_declared(_machine, instance, changes, values, _chain_program):
    """A function about which nothing else is known here moves its axes within the bounds that it declares."""
    if "enable" in instance.pins and "enable" not in changes and not instance.value(values, "enable"):
        return []
    found = []
    for short, its in instance.declared.moves.items():
        now = instance.value(values, short, 0.0)
        axis = short[0].upper() if short[1:2] == "-" and short[0] in "abcuvwxyz" else instance.name
        if changes.get("enable") is False:
            found.append(Move(axis, -now, True))
        else:
            bounds = instance.value(values, its["bound"], 0.0), changes.get(its["bound"], 0.0)
            found.append(Move(axis, abs(now) + max(map(abs, bounds)), False))
    return found


OF_MODULE = {
    "squareness": _of_squareness, "thermal_displacement": _of_growth, "axis_growth": _of_axis_growth, "axis_offset": _of_stage,
    "joint_offset": _of_stage, "chopping": _of_chopping,
}

# SPDX-License-Identifier: GPL-2.0-or-later
"""How far a write moves the axes, before it is written, by the effects that the components declare (hal/effect.hpp). Without a screen.

An effect has a Move for each axis that moves at once; without one the write moves nothing.
"""

import collections

from panel import squareness_program as program, texts
from panel.machine import is_on
from panel.settings import parsed
from panel.texts import _, in_micrometres, with_unit

Move = collections.namedtuple("Move", "axis by exact")
Move.__doc__ = "by is in machine units; if it is not exact, it is the largest distance either way."

AT_ONCE, NEXT_CYCLE, IN_NO_CYCLE = "at once", "at the next cycle", "refused while a cycle runs"
APPLIES, WITHHOLDS = "applies", "withholds"  # which of the two states returns the offset
ANNOUNCED = 0.001  # mm by which a move may differ from the announced one
LONG = 1  # mu, that is not shown in micrometres
SMALLEST = 5e-8  # mu, that counts as a move


def effect(machine, writes, values, chain_program=None):
    """The moves of settings that are written together; `chain_program` is (chain, axes that turn, path of plumb-squareness)."""
    found = [move for instance, changes in _changes(machine, writes, values) for move in _moves(machine, instance, changes, values, chain_program)]
    return [move for move in found if not abs(move.by) < SMALLEST]


def needs_rest(machine, writes, values):
    """Whether a program must not run meanwhile, wherever the axes stand now."""
    return any(_kind(instance, short) == IN_NO_CYCLE or (_kind(instance, short) == AT_ONCE and _follows(instance, values, {}))
               for instance, changes in _changes(machine, writes, values) for short in changes)


def waits_for_cycle(machine, writes, values):
    """Whether what is written takes effect with the next cycle."""
    return any(_kind(instance, short) == NEXT_CYCLE or (_turns_on(instance, values, changes) and _outputs(instance, at_next_cycle=True))
               for instance, changes in _changes(machine, writes, values) for short in changes)


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


def of_more_growth(instance, values, by):
    """The moves that come at once if thermal_displacement takes so much more growth: those of a cycle that runs."""
    at_once = instance.value(values, "cycle-running") and not instance.value(values, "constant-in-part")
    return [Move("Z", by, True)] if at_once and _follows(instance, values, {}) else []


# --- what is declared ---

def _kind(instance, short):
    return instance.declared.pins.get(short, {}).get("effect", APPLIES if short == "enable" else "")


def is_permitted(instance, values):
    """Whether the permit of interlock enables it; true of one that is loaded with interlock=no."""
    return bool(int(instance.value(values, "permit")) >> 8 & 1) if "permit" in instance.pins else True


def _changes(machine, writes, values):
    """(instance, new values by short name) of what changes. A switch is an enable."""
    found = collections.defaultdict(dict)
    for write in writes:
        switched = machine.switched_by(write.name)
        instance, short = (switched, "enable") if switched is not None else (write.instance, write.short)
        value = is_on(write) if switched is not None else parsed(write.name, instance.pins[short].kind, write.text)
        if short == "enable" or value != instance.value(values, short):
            found[instance.name][short] = value
    return [(machine.named(name), changes) for name, changes in found.items()]


def _follows(instance, values, changes):
    """Whether interlock and its settings let the offset follow."""
    if not changes.get("enable", is_permitted(instance, values)):
        return False
    kinds = ((short, _kind(instance, short)) for short in instance.pins)
    return all(bool(changes.get(short, instance.value(values, short))) == (kind == APPLIES) for short, kind in kinds if kind in (APPLIES, WITHHOLDS))


def _turns_on(instance, values, changes):
    return _follows(instance, values, changes) and not _follows(instance, values, {})


def _outputs(instance, at_next_cycle=None):
    """Outputs that move an axis, with their declarations: the netted ones, or all where none is."""
    its = {short: each for short, each in instance.declared.moves.items()
           if short in instance.pins and (at_next_cycle is None or bool(each.get("at_next_cycle")) == at_next_cycle)}
    netted = {short: each for short, each in its.items() if instance.pins[short].signal}
    return netted or its


def _axis(instance, short):
    return short[0].upper() if short[1:2] == "-" and short[0] in "abcuvwxyz" else instance.name


def applied(machine, instance, values, short):
    """The offset in force of an output: of its stage, where the stage has no other source."""
    stage = machine.stages_of(instance).get(_axis(instance, short)) if instance.declared.role == "compensation" else None
    if stage is not None and len(machine.sources_of(stage)) == 1:
        return stage.value(values, "applied-offset", 0.0)
    shown = "applied-offset" if instance.declared.role == "stage" else short
    return instance.value(values, shown, 0.0)


# --- the moves ---

def _moves(machine, instance, changes, values, chain_program):
    kinds = {_kind(instance, short) for short in changes}
    if not kinds & {AT_ONCE, APPLIES, WITHHOLDS}:
        return []
    if not _follows(instance, values, changes):
        returns = kinds & {APPLIES, WITHHOLDS} and _acts(instance, values, changes)
        return [Move(_axis(instance, short), -applied(machine, instance, values, short), True) for short in _outputs(instance)] if returns else []
    if instance.declared.role == "stage":
        return _of_stage(instance, changes, values)
    if instance.module == "squareness" and chain_program:
        try:
            return _of_squareness(machine, instance, changes, values, chain_program)
        except program.Refused:
            pass
    outputs = _outputs(instance, at_next_cycle=False) if _turns_on(instance, values, changes) else _outputs(instance)
    return [Move(_axis(instance, short), abs(applied(machine, instance, values, short)) + _bound(instance, its, changes, values), False)
            for short, its in outputs.items()]


def _bound(instance, its, changes, values):
    return max(abs(instance.value(values, its["bound"], 0.0)), abs(changes.get(its["bound"], 0.0)))


def _acts(instance, values, changes):
    """A stage that waits for a cycle holds its offset, as strokes at rest do, unless it is taken back."""
    return any(_kind(instance, short) == WITHHOLDS for short in changes) or all(
        instance.value(values, each["follows_while"]) for each in instance.declared.moves.values() if each.get("follows_while"))


def _of_stage(instance, changes, values):
    """The sum of its sources within its bound; a limit of the joint that is near takes at most all of it away, or gives it back."""
    def get(short):
        return changes.get(short, instance.value(values, short, 0.0))

    if not _acts(instance, values, changes):
        return []
    (short, its), *_rest = instance.declared.moves.items()
    now, bound = instance.value(values, "applied-offset", 0.0), abs(get(its["bound"]))
    sources = [each for each in instance.pins if each.startswith("offset-") and each[len("offset-"):].isdigit()]
    wanted = max(-bound, min(bound, sum(map(get, sources))))
    limits = "min-limit" in instance.pins
    room = (get("max-limit") - get("position") if max(now, wanted) > 0 else get("position") - get("min-limit")) if limits else 0
    share = 0.75 * get("offset-acceleration") / get("joint-acceleration") if limits and get("joint-acceleration") else 0
    if not limits or min(share, 1) * room >= abs(wanted):
        return [Move(_axis(instance, short), wanted - now, True)]
    return [Move(_axis(instance, short), max(abs(now), abs(wanted)), False)]


def _of_squareness(machine, instance, changes, values, chain_program):
    """What plumb squareness computes for the settings now and then."""
    chain, rotary, path = chain_program
    now = {short: instance.value(values, short) for short, pin in instance.pins.items() if not pin.output}
    now.setdefault("enable", is_permitted(instance, values))
    before, after = program.corrections(chain, rotary, [now, {**now, **changes}], path)
    moving = {_axis(instance, short) for short in _outputs(instance)}
    return [Move(axis, after[axis] - before[axis], True) for axis in after if axis in moving]

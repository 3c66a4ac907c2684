# SPDX-License-Identifier: GPL-2.0-or-later
"""The way of one function through its steps. The command line and the panel show the steps, and give the answers."""

import importlib
import math
import time

from commissioning import steps
from commissioning.judging import SHOWN, Verdict
from commissioning.rig import NotReady
from panel.texts import _, number

TOLERANCE = 0.0025  # mm, of a reading: what the indicator can show


class Session:
    """`records` is Records; `who` signs; `tolerance` is the tolerance of a reading, in machine units. With a `stage` it tries this stage alone,
    by its function's wiring; with `again` all that it tries has not passed any more."""

    def __init__(self, rig, function, records, who, tolerance=None, stage=None, again=False):
        if rig.identity(function) == 0 and rig.is_required():
            rig.await_condition(lambda: rig.identity(function) != 0)
        if not rig.is_required():
            raise NotReady(" ".join(rig.unready()[:1]))
        rig.must_be_answered()
        self.rig, self.function, self.records, self.who = rig, function, records, who
        self.tolerance = TOLERANCE * rig.unit if tolerance is None else tolerance
        if not 0 < self.tolerance <= steps.LARGER[-1] / SHOWN * rig.unit:
            raise NotReady(_("A tolerance of {tolerance} tries nothing: it must be above 0, and at most {most}.").format(
                tolerance=number(self.tolerance), most=number(steps.LARGER[-1] / SHOWN * rig.unit)))
        self.log = []  # a dictionary for each answer
        self._first, self._changed, self._untried, self._tried = {}, set(), [], set()
        self._identity = None  # of all steps
        self.began = time.time()
        self.stage, self.place = stage, stage or function
        if again:
            records.take_back(rig, [stage] if stage else [function, *rig.stages_of(function)])
        self.give_back()
        self._left = self._plan()
        self.step = self._left.pop(0)
        self.done = False
        self.step.begin()

    def _plan(self):
        its = importlib.import_module("commissioning.functions." + self.function.module)
        todo = [self.stage] if self.stage else [stage for stage in self.rig.stages_of(self.function) if not self.rig.is_commissioned(stage)]
        plan = [steps.Wiring(self), steps.AtRest(self), *(steps.StageMoves(self, stage) for stage in todo)]
        if self.stage:
            return plan
        plan += its.steps(self)
        if not its.MOVES_NOTHING:
            return [*plan, steps.InAir(self), steps.OffAndOn(self), steps.EmergencyStop(self), steps.OnAgain(self), steps.Undo(self)]
        return [*plan, steps.Off(self)]

    def in_inches(self, size):
        """A length in mm for the user of an inch machine."""
        return "" if self.rig.unit == 1 else " (%.5f in)" % (size * self.rig.unit)

    @property
    def count(self):
        """Number of the present step, and of all that are known."""
        done = len({entry["title"] for entry in self.log if not entry["fault"]})
        return done + 1, done + 1 + len(self._left)

    def answer(self, values):
        """Judges the present step; goes on if it passed. Returns its Verdict."""
        step = self.step
        self.look()
        if self._is_another():
            return self._begin_again()
        wrong = next((name for name, value in values.items() if not math.isfinite(value)), None)
        verdict = Verdict("state", _("{value} is no reading.").format(value=values[wrong]), _("Enter it again.")) if wrong else step.finish(values)
        self.log.append({"title": step.title, "read": dict(values), "fault": verdict.fault, "sentence": verdict.sentence, "remedy": verdict.remedy,
                         "when": _now()})
        more = step.following(verdict)
        if more:
            self._left[:0] = [*more, *([] if isinstance(step, steps.OtherJoint) else [])]
            self._next()
            return verdict
        if not verdict.passed:
            return verdict
        if self._left:
            if self._identity is None:
                self._identity = self.rig.identity(self.place)
            self._next()
            return verdict
        stages = [self.stage] if self.stage else self.rig.stages_of(self.function)
        if self._is_another() or not all(self.rig.is_commissioned(stage) for stage in stages):
            return self._begin_again()
        self._pass()
        return verdict

    def _is_another(self):
        """Whether the wiring or a sign is not that of the steps before."""
        return self._identity not in (None, self.rig.identity(self.place))

    @staticmethod
    def _begin_again():
        return Verdict("state", _("The wiring or a sign changed meanwhile."), _("Begin again."))

    def look(self):
        """Notes which inputs of the function have changed: one that never did was not tried."""
        for name, value in self.rig.inputs(self.function).items():
            if self._first.setdefault(name, value) != value:
                self._changed.add(name)

    def not_tried(self, what):
        """A line for the sheet."""
        self._untried.append(what)

    def has_tried(self, pin):
        """An input of which a reading has shown scale and sign, or an output that a program needed."""
        self._tried.add(pin)

    def _all_untried(self):
        still = sorted(self._first.keys() - self._changed)
        through = sorted(pair for pair in self.rig.through_others(self.function).items() if pair[0] not in self._tried)
        return self._untried + [_("{pin}: its value did not change").format(pin=name) for name in still] + [
            _("{pin}: scale and sign of {other}").format(pin=name, other=other) for name, other in through] + [
            _("{pin}: a program reads it by {other}").format(pin=name, other=other)
            for name, other in sorted(self.rig.read_by_programs(self.function).items()) if name not in self._tried]

    def _next(self):
        self.step = self._left.pop(0)
        self.step.begin()

    def _pass(self):
        if not self.stage:
            self._let_pass(self.function, minutes=(time.time() - self.began) / 60, untried=self._all_untried())
        self.done = True

    def pass_stage(self, stage):
        self._let_pass(stage)

    def _let_pass(self, place, **more):
        """The record comes first: nothing acts whose record could not be written."""
        self.records.note(self.rig, place, self.who, self.log, self.tolerance, **more)
        self.rig.let_pass(place)

    def lend(self, instance, short, value):
        """A setting for one step: it is as before after give_back(), and after a kill when the next session begins. Returns None, or a
        Verdict where the pin did not take the value."""
        pin = instance.full(short)
        if not self.rig.machine.pins[pin].signal:
            self.records.lend(self.rig.hal.memory, pin, self.rig.hal.get(pin))
            self.rig.set(instance, short, value)
        found = self.rig.hal.get(pin)
        if abs(float(found) - float(value)) <= 1e-9:
            return None
        return Verdict("state", _("{pin} is {found}, and this step needs {value}.").format(pin=pin, found=number(float(found)), value=number(float(value))),
                       _("Your signal {signal} drives it: set it there.").format(signal=self.rig.machine.pins[pin].signal or "?"))

    def give_back(self):
        for pin, value in self.records.lent(self.rig.hal.memory).items():
            if self.rig.has(pin):
                self.rig.hal.set(pin, str(int(value) if isinstance(value, bool) else value))
        self.records.lend_nothing()

    def close(self):
        """Takes back what is not finished."""
        self.rig.close()
        self.give_back()
        if not self.done and self.rig.await_condition(lambda: self.rig.back_at_0(self.function, self.tolerance / 10), 2):
            self.rig.switch(self.function, False)


def _now():
    return time.strftime("%Y-%m-%d %H:%M:%S")

# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps of a commissioning. A step says what to do and where the indicator goes, asks for readings, and judges them."""

import typing

from commissioning.judging import SHOWN, Verdict, good, judge_press
from panel.texts import _, number

PRESS = 0.010  # mm, or more for an indicator that shows less
LARGER = (0.050, 0.250)  # mm, one after the other where nothing was seen to move
TRAVEL = 5.0  # mm, of an axis in air


class Field(typing.NamedTuple):
    """A value that the user enters."""

    key: str
    label: str
    unit: str = "mu"


class Step:
    """`session` has rig, function, tolerance, unit. A subclass has texts, fields, and finish().

    title     a line
    look      what to do, and what to look at
    back      the way back
    picture   (name, letter) of a drawing in pictures.py; None without one
    fields    Fields
    holds     whether the user presses: begin_press(), beat() at least five times a second, and end_press() are called then
    watches   whether beat() is called as long as the step is shown
    hint      a sentence to show while the user presses
    """

    title = look = back = hint = ""
    picture = None
    fields = ()
    holds = watches = False
    minutes = 1

    def __init__(self, session):
        self.session, self.rig, self.function = session, session.rig, session.function

    @property
    def unit(self):
        return self.session.rig.unit

    def begin(self):
        """Called when the step is shown."""

    def begin_press(self):
        """None, or a Verdict where it may not begin."""

    def beat(self):
        self.rig.beat()

    def end_press(self):
        self.rig.end_press()

    def finish(self, values):
        """A Verdict on what was entered."""
        raise NotImplementedError

    def following(self, verdict):
        """Steps that a verdict asks for, before the next one."""
        return []


class Wiring(Step):
    minutes = 1

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Wiring")
        self.look = _("The program looks at the order of the functions, at the nets and at the joints. It switches the function off: an offset of the "
                      "function returns to 0. {name} has not passed until it passes again.").format(name=session.place.name)
        self.back = _("Correct the HAL files, and start LinuxCNC again.")

    def finish(self, values):
        fault = self.rig.wiring_verdict(self.function)
        if fault:
            return fault
        self.rig.take_back(self.session.place)
        self.rig.switch(self.function, False)
        if not self.rig.await_condition(lambda: not self.rig.is_on(self.function), 1):
            return Verdict("state", _("The function is switched on."), _("Turn its switch off."))
        self.rig.end_cycle()
        stays = Verdict("state", _("A stage still applies an offset, with the function off."), _("Switch off all functions, and take their offsets back."))
        return unreturned(self.rig, self.rig.stages_of(self.function), 1e-6, stays) or good(_("The nets and the order are right, and the stages are at 0."))


class AtRest(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("At rest")
        self.look = _("Home all axes. The spindle stands, the tool is clear of everything, and no program runs. Keep a hand at the emergency stop.")
        self.back = _("Press the emergency stop: offsets hold, and nothing moves.")
        self.picture = ("rest", "")

    def finish(self, values):
        return unready(self.rig) or good(_("The machine is on, homed and at rest."))


def unreturned(rig, stages, within, stays):
    """None where the offsets of stages come to 0; `stays`, or that they still return: a function may be slow."""

    def largest():
        return max((abs(rig.applied(stage)) for stage in stages), default=0.0)

    before = largest()
    if rig.await_condition(lambda: largest() < within):
        return None
    if not largest() < before:
        return stays
    return Verdict("returns", _("An offset still returns: {left} is left.").format(left=number(largest(), 4)), _("Wait until it is 0, and go on."))


def unready(rig, measures=False):
    """None, or a Verdict."""
    found = rig.unready(measures)
    return Verdict("state", " ".join(found), found[-1]) if found else None


def where_to_put_it(letter):
    """The place of the indicator for an axis: it reads more when the spindle goes to + against the work."""
    if letter == "Z":
        return _("The base of the indicator stands on the table, and its plunger points down onto an arm or the face of the spindle from above, so that it "
                 "reads more when the spindle rises to Z+.")
    return _("Clamp the base of the indicator to the table. Its plunger touches the spindle from the {axis}+ side, so that it reads more when the spindle "
             "moves to {axis}+ against the work.").format(axis=letter)


class StageMoves(Step):
    """A stage moves its joint by +0.010 mm while somebody presses."""

    holds = True
    minutes = 3

    def __init__(self, session, stage, size=None):
        super().__init__(session)
        self.stage, self.size = stage, size or max(PRESS, SHOWN * session.tolerance / session.rig.unit)
        size = self.size
        letter = session.rig.letter_of(stage)
        self.title = _("{stage} moves {axis} by {size} mm").format(stage=stage.name, axis=letter or stage.name, size="+%.3f" % size) + session.in_inches(size)
        self.look = where_to_put_it(letter) + " " + _("Set it to 0. Press and hold; read it; let go; read it again.")
        self.back = _("Letting go returns to 0. So does the end of this program. The emergency stop holds the offset.")
        self.picture = ("stage", letter)
        self.fields = (Field("pressed", _("Reading while pressed")), Field("released", _("Reading after letting go")))
        self.most = 0.0

    @property
    def asked(self):
        return self.size * self.unit

    def begin_press(self):
        refused, self.most = unready(self.rig) or self.untried(), 0.0
        if refused is None:
            self.rig.begin_press(self.stage, self.asked)
        return refused

    def untried(self):
        """None, or a Verdict where the stage cannot move so far, or would move by itself once it has passed."""
        for short in (short for short in self.stage.instance.pins if short.startswith("offset-") and short[7:].isdigit()):
            other = float(self.rig.get(self.stage.instance, short))
            if not abs(other) < self.session.tolerance / 10:
                return Verdict("state", _("{pin} asks for {other}, which would come as soon as the stage has passed.").format(
                    pin=self.stage.instance.full(short), other=number(other, 4)), _("Switch off its source, or take the net away."))
        for instance, short in ((self.stage.instance, "max-offset"), (self.rig.lock, "trial-limit")):
            if not float(self.rig.get(instance, short)) * 1.000001 >= self.asked:
                return Verdict("untried", _("Not tried: the indicator needs {asked}, and {pin} is {value}.").format(
                    asked=number(self.asked), pin=instance.full(short), value=number(float(self.rig.get(instance, short)))),
                    _("Use an indicator that shows less, and give its --tolerance."))
        return None

    def beat(self):
        super().beat()
        self.most = max(self.most, abs(self.rig.applied(self.stage)))

    def finish(self, values):
        refused = unready(self.rig) or self.untried()
        if refused is not None:
            return refused
        if self.most < 0.9 * self.asked:
            why = _("The stage itself applied {applied} of {asked}.").format(applied=number(self.most, 4), asked=number(self.asked, 4))
            return Verdict("nothing", why, _("Hold longer, and look at the faults of {stage}.").format(stage=self.stage.name))
        verdict = judge_press(self.asked, values["pressed"], values["released"], self.session.tolerance)
        if verdict.passed:
            self.session.pass_stage(self.stage)
        return verdict

    def following(self, verdict):
        if verdict.fault != "nothing" or self.most < 0.9 * self.asked:
            return []
        possible = min(float(self.rig.get(self.stage.instance, "max-offset")), float(self.rig.get(self.rig.lock, "trial-limit")))
        larger = [size for size in LARGER if size > self.size and size * self.unit < possible * 1.000001]
        if larger:
            return [StageMoves(self.session, self.stage, larger[0])]
        letters = [letter for letter in self.rig.axes if letter in "XYZ" and letter != self.rig.letter_of(self.stage)]
        return [OtherJoint(self.session, self.stage, letter) for letter in letters]


class OtherJoint(StageMoves):
    """The indicator at another axis, which moves perhaps in the place of the one that should."""

    def __init__(self, session, stage, letter):
        super().__init__(session, stage, LARGER[0])
        self.letter = letter
        its = session.rig.letter_of(stage)
        self.title = _("Does {other} move in the place of {axis}?").format(other=letter, axis=its)
        self.look = " ".join((_("Nothing moved at {axis}.").format(axis=its), where_to_put_it(letter),
                              _("Set it to 0. Press and hold; read it; let go; read it again.")))
        self.picture = ("stage", letter)

    def finish(self, values):
        tolerance = self.session.tolerance
        if abs(values["pressed"]) > tolerance and self.most >= 0.9 * self.asked:
            return Verdict("joint", _("The joints are swapped: {stage} moves {other}.").format(stage=self.stage.name, other=self.letter),
                           _("Net command and feedback of {stage} to its own drive.").format(stage=self.stage.name))
        return Verdict("nothing", _("{other} does not move either.").format(other=self.letter), _("Check that {pin} reaches the drive.").format(
            pin=self.stage.instance.full("drive-command" if self.stage.module == "joint_offset" else "counts")))

    def following(self, verdict):
        return []


class OnTrial(Step):
    """The function acts while somebody presses: letting go, a dead program and the emergency stop end it in interlock. Its switch stays on:
    Off would take an axis that stands in a stroke to point R."""

    holds = True
    measures = False  # it moves no stage, and the spindle may turn
    minutes = 1
    status = 0
    fault = None
    acted = False

    def begin_press(self):
        refused = unready(self.rig, self.measures)
        if refused is not None:
            return refused
        self.fault, self.acted, self.hint = None, False, ""
        self.rig.begin_trial(self.function, self.measures)
        self.rig.switch(self.function, True)
        return None

    def beat(self):
        self.rig.beat()
        self.watch()

    def watch(self):
        self.acted = self._acts() or self.acted
        self.session.look()
        self.fault = self.fault or self._fault()

    def _acts(self):
        self.status = int(self.rig.get(self.rig.lock, "function-status-%d" % self.function.number))
        return self.status == 0

    def _fault(self):
        for instance in [self.function.instance, *(stage.instance for stage in self.rig.stages_of(self.function))]:
            if "fault" in instance.pins and self.rig.get(instance, "fault"):
                return "%s: %s" % (instance.name, _(instance.sentence(self.rig.hal.values(), instance.declared.fault_code)))
        return None

    def acting(self):
        """None, or a Verdict that it did not act, or had a fault."""
        if not self.acted:
            return Verdict("state", _("The function does not act: {why}").format(why=_(self.function.instance.declared.sentence("status-code", self.status))),
                           _("Remove this cause, and repeat the step."))
        if self.fault:
            return Verdict("state", self.fault, _("Remove the fault, and repeat the step."))
        return None

    def applied(self):
        """By the stages at the joints."""
        return {stage.name: self.rig.applied(stage) for stage in self.rig.joints_of(self.function)}


class InAir(OnTrial):
    """The axes move in air at 10 % feed."""

    minutes = 3

    def __init__(self, session):
        super().__init__(session)
        self.title = _("In air at 10 % feed")
        self.look = _("Set the feed override and the rapid override to 10 %. Press and hold: the function acts. With the other hand, start a program in air, or "
                      "jog all its axes through their work area. Watch the axes; there must be no jerk and no message. Let go at the end.")
        self.back = _("Letting go turns the function off. The emergency stop does it, too.")
        self.picture = ("air", "")

    def begin_press(self):
        self.fast = self.rig.too_fast()
        self.least = self.most = self.rig.places()
        return self._slower() if self.fast else super().begin_press()

    def watch(self):
        super().watch()
        self.fast = self.fast or self.rig.too_fast()
        places = self.rig.places()
        self.least, self.most = ({joint: choice(its[joint], place) for joint, place in places.items()} for choice, its in ((min, self.least), (max, self.most)))

    def _slower(self):
        return Verdict("state", self.fast, _("Set it to 10 % or less, and repeat the step."))

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        if self.fast:
            return self._slower()
        moved = {joint for joint, most in self.most.items() if most - self.least[joint] >= TRAVEL * self.unit}
        stand = [self.rig.letter_of(stage) for stage in self.rig.joints_of(self.function) if self.rig.joint_of(stage) not in moved]
        if stand or not moved:
            return Verdict("state", _("{axes} did not move by {travel} mm while you pressed.").format(axes=", ".join(stand) or ", ".join(self.rig.axes), travel=number(TRAVEL)),
                           _("Move the axes while you press."))
        return good(_("It acts, without a fault."))


class OffAndOn(OnTrial):
    """Off takes the offset back, and on brings it again: by the switch of the operator."""

    STEADY = 10  # beats

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Off and on")
        if session.rig.has_switch(session.function):
            self.look = _("The tool is clear. Press and hold. With the other hand, turn the switch of the function on, off and on again, as you are told.")
        else:
            self.look = _("The tool is clear. Press and hold until you are told to let go: the program turns the switch of the function off and on, and watches "
                          "its stages.")
        self.back = _("Letting go turns the function off.")
        self.phase, self.beats = "acts", 0

    def begin_press(self):
        self.phase, self.beats, self.last = "acts", 0, {}
        return super().begin_press()

    def watch(self):
        super().watch()
        rig, tolerance, now = self.rig, self.session.tolerance, self.applied()
        if self.phase == "acts":
            steady = all(abs(now[name] - self.last.get(name, now[name] + tolerance)) < tolerance / 10 for name in now)
            self.beats, self.last = self.beats + 1 if self.acted and steady else 0, now
            if self.beats >= self.STEADY:
                self.phase, self.hint = "off", _("Off.")
                rig.switch(self.function, False)
        elif self.phase == "off":
            if not rig.is_on(self.function) and rig.back_at_0(self.function, tolerance / 10):
                self.phase, self.hint = "on", _("On.")
                rig.switch(self.function, True)
        elif self.phase == "on":
            if rig.is_on(self.function) and self._acts() and all(abs(now[name] - self.last[name]) < tolerance for name in now):
                self.phase, self.hint = "done", _("Let go.")

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        if self.phase == "off":
            return Verdict("stayed", _("With the switch off, an offset stays."), _("Look at the faults of the stages."))
        if self.phase != "done":
            return Verdict("state", _("Switched on again, the function did not reach its offset."), _("Hold longer, and look at the faults of the stages."))
        return good(_("Off returned to 0, and on acts again."))


class EmergencyStop(OnTrial):
    """The offset holds, and nothing moves."""

    minutes = 2
    stopped, moved = False, ""

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Emergency stop")
        self.look = _("Press and hold: the function acts. With the other hand, press the emergency stop. Then let go. Nothing may move, and the drives must be "
                      "without power.")
        self.back = _("Release the emergency stop, turn the machine on, and go on.")
        self.picture = ("stop", "")

    def begin_press(self):
        self.stopped, self.moved, self.before = False, "", self.applied()
        return super().begin_press()

    def watch(self):
        now = self.applied()
        if self.rig.get(self.rig.lock, "motion-enabled"):
            super().watch()
            self.before = now
        else:
            self.stopped = True
            self.moved = self.moved or next((name for name in now if abs(now[name] - self.before[name]) > self.session.tolerance), "")

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        if self.rig.get(self.rig.lock, "motion-enabled") or not self.stopped:
            return Verdict("state", _("The machine stayed on as long as you pressed."),
                           _("Press the emergency stop while you hold the button. If you did, net the chain to iocontrol.0.emc-enable-in and motion.enable."))
        if self.moved:
            return Verdict("state", _("{stage} moved at the emergency stop.").format(stage=self.moved), _("Report this: an offset must hold."))
        return good(_("It stopped, and the offsets held."))


def stayed():
    return Verdict("stayed", _("An offset stays without the function."), _("Look at the faults of the stages."))


class OnAgain(AtRest):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("On again")
        self.look = _("Release the emergency stop, and turn the machine on. Home it if LinuxCNC asks for it. The offsets return to 0.")
        self.back = _("Press the emergency stop.")
        self.picture = None

    def finish(self, values):
        verdict = super().finish(values)
        return verdict.passed and unreturned(self.rig, self.rig.joints_of(self.function), self.session.tolerance / 10, stayed()) or verdict


class Off(Step):
    """Without a trial nothing is applied."""

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Undo")
        self.look = _("The program checks that interlock holds the function, and that each offset is 0.")
        self.back = _("plumb commission NAME --undo takes the function back at any time.")

    def finish(self, values):
        return self.is_off() or good(_("All is back at 0, and the function is off."))

    def is_off(self):
        """None, or a Verdict."""
        rig, function = self.rig, self.function
        rig.end_press()
        if not rig.await_condition(lambda: not rig.get(rig.lock, "function-enable-%d" % function.number), 3):
            return Verdict("stayed", _("interlock does not switch the function off."), _("Run plumb doctor --running."))
        left = unreturned(rig, rig.joints_of(function), self.session.tolerance / 10, stayed())
        if left is None:
            rig.switch(function, False)
        return left


class Undo(OnTrial, Off):
    """The same after it has acted."""

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Bypass and undo")
        self.look = _("Press and hold: the function acts. Let go: interlock holds it again. Each offset returns to 0.")

    def finish(self, values):
        return self.acting() or Off.finish(self, values)

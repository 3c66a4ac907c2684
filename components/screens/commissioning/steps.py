# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps of a commissioning. A step says what to do and where the indicator goes, asks for readings, and judges them."""

import typing

from commissioning.judging import Verdict, good, judge_press
from panel.texts import _, number

PRESS = 0.010  # mm
LARGER = 0.050  # mm, where nothing was seen to move


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
    holds     whether the user presses: begin_press(), beat() and end_press() are called then
    """

    title = look = back = ""
    picture = None
    fields = ()
    holds = False
    minutes = 1

    def __init__(self, session):
        self.session, self.rig, self.function = session, session.rig, session.function

    @property
    def unit(self):
        return self.session.rig.unit

    def begin(self):
        """Called when the step is shown."""

    def begin_press(self):
        pass

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
        self.look = _("Nothing moves. The program looks at the order of the functions, at the nets and at the joints. The function is switched off.")
        self.back = _("Correct the HAL files, and start LinuxCNC again.")

    def finish(self, values):
        fault = self.rig.wiring_verdict(self.function)
        if fault:
            return fault
        if self.rig.is_on(self.function):
            self.rig.switch(self.function, False)
        stages = self.rig.stages_of(self.function)
        if not self.rig.await_condition(lambda: all(abs(self.rig.applied(stage)) < 1e-6 for stage in stages)):
            return Verdict("state", _("A stage still applies an offset, with the function off."), _("Switch off all functions, and take their offsets back."))
        return good(_("The nets and the order are right, and the stages are at 0."))


class AtRest(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("At rest")
        self.look = _("Home all axes. The spindle stands, the tool is clear of everything, and no program runs. Keep a hand at the emergency stop.")
        self.back = _("Press the emergency stop: offsets hold, and nothing moves.")
        self.picture = ("rest", "")

    def finish(self, values):
        found = self.rig.unready()
        return Verdict("state", " ".join(found), found[-1]) if found else good(_("The machine is on, homed and at rest."))


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

    def __init__(self, session, stage, size=PRESS):
        super().__init__(session)
        self.stage, self.size = stage, size
        letter = session.rig.letter_of(stage)
        self.title = _("{stage} moves {axis} by {size} mm").format(stage=stage.name, axis=letter or stage.name, size="+%.3f" % size)
        self.look = where_to_put_it(letter) + " " + _("Set it to 0. Press and hold; read it; let go; read it again.")
        self.back = _("Letting go returns to 0. So does the end of this program. The emergency stop holds the offset.")
        self.picture = ("stage", letter)
        self.fields = (Field("pressed", _("Reading while pressed")), Field("released", _("Reading after letting go")))
        self.most = 0.0

    @property
    def asked(self):
        return self.size * self.unit

    def begin_press(self):
        self.rig.begin_press(self.stage, self.asked)

    def beat(self):
        super().beat()
        self.most = max(self.most, abs(self.rig.applied(self.stage)))

    def finish(self, values):
        found = self.rig.unready()
        if found:
            return Verdict("state", " ".join(found), found[-1])
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
        if self.size < LARGER:
            return [StageMoves(self.session, self.stage, LARGER)]
        letters = [letter for letter in self.rig.axes if letter in "XYZ" and letter != self.rig.letter_of(self.stage)]
        return [OtherJoint(self.session, self.stage, letter) for letter in letters]


class OtherJoint(StageMoves):
    """The indicator at another axis, which moves perhaps in the place of the one that should."""

    def __init__(self, session, stage, letter):
        super().__init__(session, stage, LARGER)
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


class InAir(Step):
    """The function acts on trial while the axes move in air at 10 % feed."""

    minutes = 3

    def __init__(self, session):
        super().__init__(session)
        self.title = _("In air at 10 % feed")
        self.look = _("The function acts now, on trial. Set the feed to 10 %, and move all its axes through their work area in air, by hand or by a program. "
                      "Watch the axes; there must be no jerk and no message.")
        self.back = _("Press the emergency stop, or end this program: the function goes off.")
        self.picture = ("air", "")

    def begin(self):
        self.rig.switch(self.function, True)
        self.rig.begin_trial(self.function)

    def finish(self, values):
        return _acts_without_fault(self)


def _acts_without_fault(step):
    rig, function = step.rig, step.function
    if not rig.on_trial:
        step.begin()
    rig.await_condition(lambda: not rig.get(rig.lock, "function-status-%d" % function.number), 2)
    status = rig.get(rig.lock, "function-status-%d" % function.number)
    if status:
        return Verdict("state", _("The function does not act: {why}").format(why=_(function.instance.declared.sentence("status-code", status))),
                       _("Remove this cause, and repeat the step."))
    for instance in [function.instance, *(stage.instance for stage in rig.stages_of(function))]:
        if "fault" in instance.pins and rig.get(instance, "fault"):
            return Verdict("state", "%s: %s" % (instance.name, _(instance.sentence(rig.hal.values(), "fault-code"))), _("Remove the fault, and repeat the step."))
    return good(_("It acts, without a fault."))


class OffAndOn(Step):
    """Off takes the offset back, and on brings it again: by the switch of the operator."""

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Off and on")
        self.look = _("The tool is clear. The program turns the switch of the function off and on, and watches its stages: off, each offset returns to 0.")
        self.back = _("The switch stays off if the step fails.")

    def finish(self, values):
        rig, function = self.rig, self.function
        stages = rig.stages_of(function)
        before = {stage.name: rig.applied(stage) for stage in stages}
        rig.switch(function, False)
        if not rig.await_condition(lambda: all(abs(rig.applied(stage)) < self.session.tolerance / 10 for stage in stages if stage.module == "joint_offset")):
            return Verdict("stayed", _("With the switch off, an offset stays."), _("Look at the faults of the stages."))
        rig.switch(function, True)
        rig.await_condition(lambda: all(abs(rig.applied(stage) - before[stage.name]) < self.session.tolerance for stage in stages), 3)
        return good(_("Off returned to 0, and on acts again."))


class EmergencyStop(Step):
    """The offset holds, and nothing moves."""

    fields = ()
    minutes = 2

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Emergency stop")
        self.look = _("Press the emergency stop now. Then go on here. Nothing may move, and the drives must be without power.")
        self.back = _("Release the emergency stop, turn the machine on, and go on.")
        self.picture = ("stop", "")

    def begin(self):
        self.before = {stage.name: self.rig.applied(stage) for stage in self.rig.stages_of(self.function)}

    def finish(self, values):
        rig = self.rig
        if rig.get(rig.lock, "motion-enabled"):
            return Verdict("state", _("The machine is still on: the emergency stop does not reach LinuxCNC."),
                           _("Net the chain to iocontrol.0.emc-enable-in and motion.enable."))
        for stage in rig.stages_of(self.function):
            if stage.module == "joint_offset" and abs(rig.applied(stage) - self.before[stage.name]) > self.session.tolerance and not self.strokes:
                return Verdict("state", _("{stage} moved at the emergency stop.").format(stage=stage.name), _("Report this: an offset must hold."))
        return good(_("It stopped, and the offsets held."))

    @property
    def strokes(self):
        return self.function.module == "chopping"


class OnAgain(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("On again")
        self.look = _("Release the emergency stop, and turn the machine on. Home it if LinuxCNC asks for it.")
        self.back = _("Press the emergency stop.")

    def finish(self, values):
        found = self.rig.unready()
        if found:
            return Verdict("state", " ".join(found), found[-1])
        return _acts_without_fault(self)


class Undo(Step):
    """Without a trial everything is back at 0."""

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Bypass and undo")
        self.look = _("The program ends the trial, as interlock does when somebody takes commissioning back. Each offset returns to 0.")
        self.back = _("plumb commission NAME --undo takes the function back at any time.")

    def finish(self, values):
        rig, function = self.rig, self.function
        rig.end_trial()
        stages = rig.stages_of(function)
        if not rig.await_condition(lambda: not rig.get(rig.lock, "function-enable-%d" % function.number), 3):
            return Verdict("stayed", _("interlock does not switch the function off."), _("Run plumb doctor --running."))
        if not rig.await_condition(lambda: all(abs(rig.applied(stage)) < self.session.tolerance / 10 for stage in stages if stage.module == "joint_offset")):
            return Verdict("stayed", _("An offset stays without the function."), _("Look at the faults of the stages."))
        rig.switch(function, False)
        return good(_("All is back at 0, and the function is off."))

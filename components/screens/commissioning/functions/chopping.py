# SPDX-License-Identifier: GPL-2.0-or-later
"""chopping: one slow stroke in air, its dead points against the indicator, hold, the way back to point R, and emergency stop."""

from commissioning.judging import Verdict, good, judge
from commissioning.steps import Field, OnAgain, OnTrial, Step, unready
from panel.texts import _, number

MOVES_NOTHING = True  # the steps here take the place of those in air
STROKE = 1.0  # mm
SPEED = 30.0  # mm a minute
MARGIN = 10.0  # mm, from each limit
HELD = 2.0  # s, for which the axis must stand


def steps(session):
    return [Stroke(session), Hold(session), Return(session), Stop(session), AgainAtRest(session)]


class Strokes(OnTrial):
    """The axis strokes while somebody presses. Letting go ends the stroke: the axis stands at once. The next press takes it to point R first."""

    def __init__(self, session):
        super().__init__(session)
        self.back = _("Letting go stops the axis at once, and so does the emergency stop. The next press takes it to point R.")
        self.picture = ("stroke", "Z")
        self.begun = self.stroked = False

    def begin_press(self):
        rig, instance = self.rig, self.function.instance
        self.begun = self.stroked = False
        place, lowest, highest = (float(rig.get(instance, short)) for short in ("position", "min-limit", "max-limit"))
        if place - STROKE * self.unit - lowest < MARGIN * self.unit or highest - place < MARGIN * self.unit:
            return Verdict("state", _("The axis is nearer than {margin} mm to a soft limit.").format(margin=number(MARGIN)), _("Move it to the middle of its travel."))
        # Learning begins inside the dead points, and the wheel stands.
        for short, value in (("learn", 0), ("without-wheel", 1)):
            unlent = self.session.lend(instance, short, value) if bool(rig.get(instance, short)) != bool(value) else None
            if unlent is not None:
                return unlent
        rig.await_condition(lambda: not rig.get(rig.lock, "program-running"))  # G81.1 of the last press
        refused = unready(rig)
        if refused is not None:
            return refused
        rig.mdi("G21")  # the words of G81.1 are in the unit of the program
        return super().begin_press()

    def watch(self):
        super().watch()
        if not self.begun and self._acts() and self.rig.back_at_0(self.function, self.session.tolerance):
            self.begun = True
            self.rig.mdi("G81.1 Z[#5422] Q%g R0 P%g" % (-STROKE, SPEED), stays=True)
        self.stroked = self.stroked or bool(self.rig.get(self.function.instance, "stroking"))

    def end_press(self):
        super().end_press()
        # A wheel that stands is no fault as long as the axis still slows down.
        self.rig.await_condition(lambda: not self.rig.get(self.function.instance, "active"), 2)
        self.session.give_back()

    def acting(self):
        if super().acting() is not None or self.stroked:
            return super().acting()
        if not self.begun:
            return Verdict("state", _("The axis does not return to point R."), _("Press longer, and look at the faults of the stage."))
        why = _(self.function.instance.sentence(self.rig.hal.values(), "fault-code")) or _("no fault.")
        return Verdict("state", _("The axis does not stroke: {why}").format(why=why), _("Repeat the step."))


class Stroke(Strokes):
    minutes = 5

    def __init__(self, session):
        super().__init__(session)
        self.title = _("One slow stroke in air")
        self.look = _("Move the axis to the middle of its travel, in air. Set up the indicator so that it reads more when the axis moves to +, with its plunger "
                      "in by 2 mm, and set it to 0. Press and hold: the axis strokes from here by {stroke} mm to - and back, at {speed} mm/min. Note the "
                      "largest and the smallest reading; let go.").format(stroke=number(STROKE), speed=number(SPEED))
        self.fields = (Field("upper", _("Largest reading")), Field("lower", _("Smallest reading")))

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        verdict = judge(STROKE * self.unit, values["upper"] - values["lower"], 3 * self.session.tolerance, _("Stroke"))
        if verdict.passed and abs(values["upper"]) > 3 * self.session.tolerance:
            if abs(values["lower"]) <= 3 * self.session.tolerance:
                return Verdict("sign", _("The axis strokes to + and not to -: from {lower} to {upper}.").format(
                    lower=number(values["lower"], 4), upper=number(values["upper"], 4)), _("Reverse the sign of the scale of the drive."))
            return Verdict("size", _("The upper dead point is {upper} from point R.").format(upper=number(values["upper"], 4)),
                           _("Check the following error, and lead."))
        return verdict


class Hold(Strokes):
    """At an override of 0 the axis stands at the next dead point."""

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Hold")
        self.look = _("Press and hold until you are told to let go: the axis strokes, and the program sets the override of the stroke to 0 and watches whether "
                      "the axis stands.")
        if self._has_override():
            self.look = _("Press and hold: the axis strokes. Hold the stroke by your own control of its override until you are told to let go.")

    def _has_override(self):
        return bool(self.rig.machine.pins[self.function.instance.full("override")].signal)

    def begin_press(self):
        self.began = self.stood = None
        self.places, self.held = [], False
        return super().begin_press()

    def watch(self):
        super().watch()
        if not self.stroked or self.held:
            return
        now, override = self.rig.clock(), float(self.rig.get(self.function.instance, "override"))
        if self.began is None:
            self.began = now
            self.session.lend(self.function.instance, "override", 0)  # else by the user, who is told so
        if override == 0 and now - self.began > 4 * STROKE / SPEED * 60:
            place = float(self.rig.get(self.function.instance, "offset"))
            self.places = [(when, where) for when, where in self.places if now - when < HELD] + [(now, place)]
            self.held = self.places[-1][0] - self.places[0][0] > 0.8 * HELD and self._stands()
            self.hint = _("Let go.") if self.held else ""

    def _stands(self):
        where = [place for _when, place in self.places]
        return max(where) - min(where) <= self.session.tolerance

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        if not self.held:
            return Verdict("state", _("The axis did not stand at an override of 0."), _("Hold for 20 s. If it still strokes, report this."))
        return good(_("It held."))


class Return(OnTrial):
    minutes = 1

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Back to point R")
        self.look = _("Press and hold until you are told to let go: the axis returns to point R. Enter the reading.")
        self.back = _("Letting go stops the axis at once. The emergency stop does it, too.")
        self.picture = ("stroke", "Z")
        self.fields = (Field("read", _("Reading at point R")),)

    def watch(self):
        super().watch()
        self.hint = _("Let go.") if self._is_there() else ""

    def _is_there(self):
        """G80.1 waits for strokes that have not come to their end."""
        return not self.rig.get(self.function.instance, "active") and self.rig.back_at_0(self.function, self.session.tolerance)

    def finish(self, values):
        rig = self.rig
        if not abs(values["read"]) <= 3 * self.session.tolerance:
            return Verdict("stayed", _("The axis is {read} from point R.").format(read=number(values["read"], 4)), _("Look for stick and backlash."))
        if not self._is_there():
            return Verdict("stayed", _("The stroke leaves an offset behind."), _("Hold longer. Else turn the machine off and on, and home the axis."))
        rig.mdi("G80.1")
        for short in ("active", "at-end"):
            self.session.has_tried(self.function.instance.full(short))
        return good(_("The stroke has ended, and its offset is 0."))


class Stop(Strokes):
    minutes = 2

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Emergency stop")
        self.look = _("Press and hold: the axis strokes again. With the other hand, press the emergency stop. The axis must stand at once. Let go.")
        self.back = _("Release the emergency stop, and turn the machine on.")
        self.picture = ("stop", "")

    def begin_press(self):
        self.stopped = False
        return super().begin_press()

    def watch(self):
        if self.rig.get(self.rig.lock, "motion-enabled"):
            super().watch()
        else:
            self.stopped = True

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        if self.acting() is not None:
            return self.acting()
        if rig.get(rig.lock, "motion-enabled") or not self.stopped:
            return Verdict("state", _("The machine stayed on as long as you pressed."),
                           _("Press the emergency stop while you hold the button. If you did, net the chain to iocontrol.0.emc-enable-in and motion.enable."))
        if rig.get(instance, "stroking"):
            return Verdict("state", _("The stroke goes on without the machine."), _("Press the emergency stop again; report this."))
        return good(_("It stopped."))


class AgainAtRest(OnAgain):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("On again")
        self.look = _("Release the emergency stop, and turn the machine on. The axis returns to point R, slowly.")

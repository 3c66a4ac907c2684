# SPDX-License-Identifier: GPL-2.0-or-later
"""chopping: one slow stroke in air, its dead points against the indicator, hold, emergency stop, and the way back to point R."""

from commissioning.judging import Verdict, good, judge
from commissioning.steps import AtRest, Field, OffAndOn, Step
from panel.texts import _, number

MOVES_NOTHING = True  # the steps here take the place of those in air
STROKE = 1.0  # mm
SPEED = 30.0  # mm a minute
MARGIN = 10.0  # mm, from each limit


def steps(session):
    return [Stroke(session), Hold(session), Return(session), Stop(session), AgainAtRest(session)]


def _start(step):
    """Starts the stroke. Returns a Verdict where it may not."""
    rig, function, instance = step.rig, step.function, step.function.instance
    place, lowest, highest = (float(rig.get(instance, short)) for short in ("position", "min-limit", "max-limit"))
    if place - STROKE * step.unit - lowest < MARGIN * step.unit or highest - place < MARGIN * step.unit:
        return Verdict("state", _("The axis is nearer than {margin} mm to a soft limit.").format(margin=number(MARGIN)), _("Move it to the middle of its travel."))
    if not rig.machine.pins[instance.full("learn")].signal and rig.get(instance, "learn"):
        step.session.learns = True
        rig.set(instance, "learn", 0)  # learning begins inside the dead points
    rig.switch(function, True)
    rig.begin_trial(function)
    if not rig.await_condition(lambda: rig.get(instance, "enable"), 3):
        return Verdict("state", _("The function is not permitted: {why}").format(
            why=_(instance.declared.sentence("status-code", rig.get(rig.lock, "function-status-%d" % function.number)))), _("Remove this cause, and repeat the step."))
    # The words of G81.1 are in the unit of the program: G20 and G21 choose it.
    rig.mdi("G21")
    rig.mdi("G81.1 Z[#5422] Q%g R0 P%g" % (-STROKE, SPEED), stays=True)
    return None


class Stroke(Step):
    minutes = 5

    def __init__(self, session):
        super().__init__(session)
        self.title = _("One slow stroke in air")
        self.look = _("Move the axis to the middle of its travel, in air. Set up the indicator so that it reads more when the axis moves to +, with its plunger "
                      "in by 2 mm, and set it to 0. Go on: the axis strokes from here by {stroke} mm to - and back, at {speed} mm/min. Enter the largest "
                      "and the smallest reading.").format(stroke=number(STROKE), speed=number(SPEED))
        self.back = _("Press the emergency stop, or end this program: the axis returns to point R.")
        self.picture = ("stroke", "Z")
        self.fields = (Field("upper", _("Largest reading")), Field("lower", _("Smallest reading")))

    def start(self):
        return _start(self)

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        if not rig.get(instance, "stroking"):
            return Verdict("state", _("The axis does not stroke: {why}").format(why=_(instance.sentence(rig.hal.values(), "fault-code")) or _("no fault.")),
                           _("Repeat the step."))
        verdict = judge(STROKE * self.unit, values["upper"] - values["lower"], 3 * self.session.tolerance, _("Stroke"))
        if verdict.passed and abs(values["upper"]) > 3 * self.session.tolerance:
            if abs(values["lower"]) <= 3 * self.session.tolerance:
                return Verdict("sign", _("The axis strokes to + and not to -: from {lower} to {upper}.").format(
                    lower=number(values["lower"], 4), upper=number(values["upper"], 4)), _("Reverse the sign of the scale of the drive."))
            return Verdict("size", _("The upper dead point is {upper} from point R.").format(upper=number(values["upper"], 4)),
                           _("Check the following error, and lead."))
        return verdict


class Hold(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("Hold")
        self.look = _("The program sets the override of the stroke to 0, watches whether the axis stands, and lets it go on.")
        self.back = _("Press the emergency stop.")

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        if rig.machine.pins[instance.full("override")].signal:
            return good(_("The override has a signal: hold by your own control and watch the axis."))
        rig.set(instance, "override", 0)
        rig.sleep(4 * STROKE / SPEED * 60)  # at the next dead point
        places = []
        for _turn in range(10):
            places.append(float(rig.get(instance, "offset")))
            rig.sleep(0.1)
        rig.set(instance, "override", 1)
        if max(places) - min(places) > self.session.tolerance:
            return Verdict("state", _("The axis goes on at an override of 0."), _("Report this."))
        return good(_("It held, and goes on."))


class Stop(Step):
    minutes = 2

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Emergency stop")
        self.look = _("Go on: the axis strokes again. While it does, press the emergency stop. The axis must stand at once.")
        self.back = _("Release the emergency stop, and turn the machine on.")
        self.picture = ("stop", "")

    def start(self):
        return _start(self)

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        if getattr(self.session, "learns", False):
            rig.set(instance, "learn", 1)
        if rig.get(rig.lock, "motion-enabled"):
            return Verdict("state", _("The machine is still on: the emergency stop does not reach LinuxCNC."),
                           _("Net the chain to iocontrol.0.emc-enable-in and motion.enable."))
        if rig.get(instance, "stroking"):
            return Verdict("state", _("The stroke goes on without the machine."), _("Press the emergency stop again; report this."))
        return good(_("It stopped."))


class AgainAtRest(AtRest):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("On again")
        self.look = _("Release the emergency stop, and turn the machine on. The axis must stand where it stopped.")


class Return(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("Back to point R")
        self.look = _("The program ends the stroke by G80.1: the axis returns to point R. Enter the reading.")
        self.back = _("Press the emergency stop.")
        self.picture = ("stroke", "Z")

        self.fields = (Field("read", _("Reading at point R")),)

    def begin(self):
        self.rig.mdi("G80.1")

    def finish(self, values):
        rig = self.rig
        if abs(values["read"]) > 3 * self.session.tolerance:
            return Verdict("stayed", _("The axis is {read} from point R.").format(read=number(values["read"], 4)), _("Look for stick and backlash."))
        if not rig.await_condition(lambda: all(abs(rig.applied(stage)) < self.session.tolerance for stage in rig.stages_of(self.function)), 10):
            return Verdict("stayed", _("The stroke leaves an offset behind."), _("Turn the machine off and on, and home the axis."))
        return good(_("The stroke has ended, and its offset is 0."))

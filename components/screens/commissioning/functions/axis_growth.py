# SPDX-License-Identifier: GPL-2.0-or-later
"""axis_growth: each temperature against a thermometer, warm, and what the law makes of it."""

from commissioning.judging import Verdict, judge
from commissioning.steps import Field, Step
from panel.texts import _, number

MOVES_NOTHING = False
NEAR = 3.0  # K


def _sensors(instance):
    """The numbers of its sensors."""
    return [int(short.rpartition("-")[2]) for short in instance.pins if short.startswith("reference-") and short[-1].isdigit()]


def steps(session):
    return [Warm(session, sensor) for sensor in _sensors(session.function.instance) if _is_used(session.rig, session.function.instance, sensor)] or [NoLaw(session)]


def unused(rig, instance):
    """Inputs that nobody needs to write: of sensors that the law does not read."""
    return [short % sensor for sensor in _sensors(instance) if not _is_used(rig, instance, sensor) for short in ("temperature-%d", "temperature-valid-%d", "temperature-age-%d")]


def _is_used(rig, instance, sensor):
    """Whether the law has a growth or a slope by this temperature, or judges others by it."""
    return float(rig.get(instance, "expected-limit-%d" % sensor)) > 0 or any(
        float(rig.get(instance, "%s-%s-%d" % (axis, kind, sensor))) for axis in "xyz" for kind in ("growth", "slope"))


class NoLaw(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("The law of the machine")
        self.look = _("No growth is set for any temperature.")
        self.back = _("Nothing is applied: the function is off.")

    def finish(self, values):
        return Verdict("missing", _("No growth is set, so that nothing can be tried."), _("Run a growth test, and set the lines of plumb growth identify."))


class Warm(Step):
    minutes = 4

    def __init__(self, session, sensor):
        super().__init__(session)
        self.sensor = sensor
        self.title = _("Temperature {number}").format(number=sensor)
        self.look = _("Warm the sensor of temperature {number} by hand by some kelvin, and measure the same place with a thermometer. Enter its temperature.").format(
            number=sensor)
        self.back = _("Nothing is applied: the function is off.")
        self.fields = (Field("shown", _("Temperature by the thermometer"), "degC"),)

    def begin(self):
        self.before = float(self.rig.get(self.function.instance, "temperature-%d" % self.sensor))

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        if not rig.get(instance, "temperature-valid-%d" % self.sensor):
            return Verdict("net", _("This temperature is not valid."), _("Check the sensor, and its net."))
        now = float(rig.get(instance, "temperature-%d" % self.sensor))
        verdict = judge(values["shown"], now, NEAR, _("Temperature {number}").format(number=self.sensor), kind="temperature")
        if verdict.passed and abs(now - self.before) < 1:
            return Verdict("nothing", _("It was {before} and is {now}: it does not follow your hand.").format(before=number(self.before, 4), now=number(now, 4)),
                           _("Find the sensor that has this number."))
        if not verdict.passed:
            return verdict
        self.session.has_tried(instance.full("temperature-%d" % self.sensor))
        grown = ", ".join("%s %s" % (axis.upper(), number(float(rig.get(instance, axis + "-growth")), 3)) for axis in "xyz")
        return verdict._replace(sentence=verdict.sentence + " " + _("Growth by the law: {grown}.").format(grown=grown))

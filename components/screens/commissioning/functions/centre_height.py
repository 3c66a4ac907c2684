# SPDX-License-Identifier: GPL-2.0-or-later
"""centre_height: a height, and the same one with a known shim below the tool."""

from commissioning.judging import Verdict, good, judge
from commissioning.steps import Field, Step
from panel.texts import _, number

MOVES_NOTHING = True  # a program moves Y, and only by its own block


def steps(session):
    return [First(session), WithShim(session)]


def _results(step):
    """Those of the last measurement."""
    return [step.rig.get(step.function.instance, short) for short in ("height", "height-size", "tip-x", "theta", "x-correction", "predicted-diameter", "value-valid")]


def _measured(step):
    """The height, or a Verdict that there is none."""
    rig, instance = step.rig, step.function.instance
    if rig.get(instance, "fault"):
        return Verdict("state", _(instance.sentence(rig.hal.values(), "detail-code")), _("Measure again."))
    if _results(step) == step.before:
        return Verdict("nothing", _("There is no new measurement since this step began."), _("Measure again."))
    if not rig.get(instance, "value-valid"):
        why = _(instance.sentence(rig.hal.values(), "detail-code"))
        return Verdict("nothing", " ".join(text for text in (_("There is no height yet."), why) if text), _("Measure again."))
    return float(rig.get(instance, "height"))


class First(Step):
    minutes = 6

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Height of a tool")
        self.look = _("Clamp a tool, and measure its height by trial cuts: M450, the cuts, M451 and M452, as height.ngc does. Nothing is moved. Go on when the "
                      "height is shown.")
        self.back = _("M453 forgets the measurement.")
        self.picture = ("cuts", "")

    def begin(self):
        self.before = _results(self)

    def finish(self, values):
        found = _measured(self)
        if isinstance(found, Verdict):
            return found
        self.session.first_height = found
        return good(_("Height: {height}.").format(height=number(found, 4)))


class WithShim(Step):
    minutes = 8

    def __init__(self, session):
        super().__init__(session)
        self.title = _("With a shim below the tool")
        self.look = _("Put a shim of known thickness below the tool, 0.05 to 0.2 mm, and measure again. The height must rise by the shim.")
        self.back = _("Take the shim out.")
        self.picture = ("shim", "")
        self.fields = (Field("shim", _("Thickness of the shim")),)

    def begin(self):
        self.before = _results(self)

    def finish(self, values):
        found = _measured(self)
        if isinstance(found, Verdict):
            return found
        if values["shim"] <= 0:
            return Verdict("state", _("The thickness must be above 0."), _("Enter it again."))
        sigma = float(self.rig.get(self.function.instance, "sigma"))
        rise = found - self.session.first_height
        return judge(values["shim"], rise, min(max(self.session.tolerance, 4 * sigma), 0.4 * values["shim"]), _("Rise of the height"))

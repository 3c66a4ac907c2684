# SPDX-License-Identifier: GPL-2.0-or-later
"""thermal_growth_test: one bore, probed twice, moved by a shim between the two."""

import re

from commissioning.judging import Verdict, good, judge
from commissioning.steps import Field, Step
from panel.texts import _, number

MOVES_NOTHING = True
BORE = ("bore-x", "bore-y", "bore-z")


def needs(_rig, instance):
    """Inputs that the HAL file of the function leaves to the user."""
    return [short for short in instance.pins if re.fullmatch(r"temperature-\d", short)]


def steps(session):
    instance = session.function.instance
    for short in needs(session.rig, instance):
        for other in ("valid", "age"):
            pin = instance.pins[short.replace("-", "-%s-" % other)]
            if not pin.signal:
                session.not_tried(_("{pin}: it has no net").format(pin=pin.name))
    return [Here(session), There(session), First(session), Moved(session)]


def _places(step):
    """The measured positions without compensation, and the positions of LinuxCNC's joints: X, Y and Z."""
    rig, instance = step.rig, step.function.instance
    measured = [float(rig.get(instance, letter + "-position")) - float(rig.get(instance, letter + "-offset")) for letter in "xyz"]
    return measured, [rig.place_of_joint(letter) for letter in "XYZ"]


class Here(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("The positions, here")
        self.look = _("Move X, Y and Z to the middle of the table, clear of everything. Then go on.")
        self.back = _("Nothing is applied: the test moves no offset.")

    def finish(self, values):
        self.session.places = _places(self)
        return good(_("The positions are noted."))


class There(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("The positions, elsewhere")
        self.look = _("Move X by 20 mm to +, Y by 30 mm to +, and Z by 10 mm to +. Then go on.")
        self.back = _("Nothing is applied: the test moves no offset.")

    def finish(self, values):
        measured, joints = _places(self)
        moved = [b - a for a, b in zip(self.session.places[0], measured)]
        asked = [b - a for a, b in zip(self.session.places[1], joints)]
        if min(abs(part) for part in asked) < 5 * self.unit:
            return Verdict("state", _("An axis did not move so far."), _("Move X, Y and Z, and go on."))
        tolerance = 0.1 * self.unit
        for i, letter in enumerate("XYZ"):
            if abs(moved[i] - asked[i]) <= tolerance:
                continue
            for k, other in enumerate("XYZ"):
                if k != i and abs(moved[i] - asked[k]) <= tolerance:
                    return Verdict("joint", _("{pin} follows {other}: the joints are swapped.").format(
                        pin=self.function.instance.full(letter.lower() + "-position"), other=other), _("Net the measured position of {letter}.").format(letter=letter))
            return judge(asked[i], moved[i], tolerance, self.function.instance.full(letter.lower() + "-position"))
        return good(_("The measured positions follow their axes."))


def _bore(step):
    """The place of the last bore, without the compensation; a Verdict where there is none."""
    rig, instance = step.rig, step.function.instance
    if rig.get(instance, "fault"):
        return Verdict("state", _(instance.sentence(rig.hal.values(), "fault-code")), _("Probe the bore again."))
    place = [float(rig.get(instance, short)) for short in BORE]
    if not any(place) or not rig.get(instance, "bore-diameter"):
        return Verdict("nothing", _("No bore has been probed yet."), _("Probe the bore, and check the nets of probe and positions."))
    return place


class First(Step):
    minutes = 5

    def __init__(self, session):
        super().__init__(session)
        self.title = _("One bore")
        self.look = _("Clamp the artifact against a stop at its X- side, and probe one bore by the first pass of the test, or by growth_touch. Then go on.")
        self.back = _("Nothing is applied: the test moves no offset.")
        self.picture = ("bore", "X")

    def finish(self, values):
        found = _bore(self)
        if isinstance(found, Verdict):
            return found
        self.session.first_bore = found
        return good(_("The bore is at {place}.").format(place=", ".join(number(each) for each in found)))


class Moved(Step):
    minutes = 6

    def __init__(self, session):
        super().__init__(session)
        self.title = _("The bore, moved by a shim")
        self.look = _("Put a shim of known thickness, 0.1 to 1 mm, between the stop and the artifact: it moves to X+. Probe the same bore again. Then go on.")
        self.back = _("Take the shim out.")
        self.picture = ("bore", "X")
        self.fields = (Field("shim", _("Thickness of the shim")),)

    def finish(self, values):
        found = _bore(self)
        if isinstance(found, Verdict):
            return found
        shim = values["shim"]
        if shim <= 0:
            return Verdict("state", _("The thickness must be above 0."), _("Enter it again."))
        moved = [b - a for a, b in zip(self.session.first_bore, found)]
        tolerance = max(2 * self.session.tolerance, 0.05 * shim)
        if abs(moved[0]) <= tolerance:
            for letter, part in zip("YZ", moved[1:]):
                if abs(abs(part) - shim) <= tolerance:
                    return Verdict("joint", _("The bore moved in {other} and not in X: the joints are swapped.").format(other=letter),
                                   _("Net the position of X to {pin}.").format(pin=self.function.instance.full("x-position")))
        return judge(shim, moved[0], tolerance, _("The bore moved"))

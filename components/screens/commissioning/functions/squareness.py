# SPDX-License-Identifier: GPL-2.0-or-later
"""squareness: a test move along a square, with the reading that each wrong sign would give."""

import re

from commissioning.judging import SHOWN, Verdict, good, judge
from commissioning.steps import Field, OnTrial, Step
from panel.texts import _, number

MOVES_NOTHING = False
SHORTEST = 20  # mm, of a test move
LEAST = 1e-4  # mm: a smaller error is the square of a tilt
ERRORS = ("x-error", "y-error", "z-error")
# The component of the error that a tilt about A, B or C gives along each axis of travel, and its sign.
LEVER = {"x": {"c": (1, 1), "b": (2, -1)}, "y": {"c": (0, -1), "a": (2, 1)}, "z": {"b": (0, 1), "a": (1, -1)}}
LIKE = {"u": "x", "v": "y", "w": "z"}


def steps(session):
    return [Begin(session, Move(letter)) for letter in session.rig.axes if letter in "XYZUVW"] + [AnyTilt(session)]


class Move:
    """A test move along one axis: where it begins and ends, and what the tilts make of it there."""

    def __init__(self, letter):
        self.letter = letter
        self.start = self.end = None

    def look(self, session):
        """Place and errors now, and the place of the joint; None where the kinematics do not say which one it is."""
        rig, instance = session.rig, session.function.instance
        return (float(rig.get(instance, self.letter.lower() + "-position")), [float(rig.get(instance, short)) for short in ERRORS],
                rig.place_of_joint(self.letter) if rig.ini.get("KINS", "KINEMATICS", "").startswith("trivkins") else None)

    @property
    def travel(self):
        return self.end[0] - self.start[0]

    @property
    def change(self):
        """Of the errors, from start to end."""
        return [b - a for a, b in zip(self.start[1], self.end[1])]


class Error:
    """The error along a travel in one direction, which its own reading shows."""

    here = None  # the corrected reading at the first end

    def __init__(self, move, component):
        self.letter, self.look, self.start, self.end, self.travel = move.letter, move.look, move.start, move.end, move.travel
        self.component, self.direction, self.expected = component, "XYZ"[component], move.change[component]

    @property
    def name(self):
        return _("{side} along {axis}, {error}").format(side=self.direction, axis=self.letter, error=number(self.expected, 4))

    def tilts(self, session):
        """The tilts of this axis and their parts of the error; empty where other axes carry it, too."""
        found = {}
        for about, (component, sign) in LEVER[LIKE.get(self.letter.lower(), self.letter.lower())].items():
            short = "e%s0%s" % (about, self.letter.lower())
            angle = float(session.rig.get(session.function.instance, short))
            if angle and component == self.component:
                found[short] = sign * angle * self.travel
        total = sum(found.values())
        for sense in (1, -1):  # the tool or the work moves
            if found and abs(sense * total - self.expected) < 0.05 * abs(self.expected):
                return {short: sense * part for short, part in found.items()}
        return {}

    def names(self, session):
        return ", ".join(self.tilts(session)) or _("the tilts")


class Begin(Step):
    def __init__(self, session, move):
        super().__init__(session)
        self.move = move
        self.title = _("One end of {axis}").format(axis=move.letter)
        self.look = _("Without an indicator yet: move {axis} to one end of the travel that your square can show, other axes in the middle. Then go on.").format(
            axis=move.letter)
        self.back = _("Nothing is applied: the function is off.")
        self.picture = ("square", move.letter)

    def finish(self, values):
        self.move.start = self.move.look(self.session)
        return good(_("{axis} is at {place}.").format(axis=self.move.letter, place=number(self.move.start[0])))

    def following(self, verdict):
        return [End(self.session, self.move)]


class End(Step):
    def __init__(self, session, move):
        super().__init__(session)
        self.move = move
        self.title = _("Other end of {axis}").format(axis=move.letter)
        self.look = _("Move {axis} to the other end of this travel, by at least {least} mm. Then go on.").format(axis=move.letter, least=SHORTEST)
        self.back = _("Nothing is applied: the function is off.")
        self.picture = ("square", move.letter)

    def finish(self, values):
        self.move.end = self.move.look(self.session)
        if abs(self.move.travel) < SHORTEST * self.unit:
            return Verdict("state", _("{axis} did not move so far.").format(axis=self.move.letter), _("Move it by at least {least} mm.").format(least=SHORTEST))
        if self.move.end[2] is not None:
            pin = self.function.instance.full(self.move.letter.lower() + "-position")
            verdict = judge(self.move.end[2] - self.move.start[2], self.move.travel, 0.1 * self.unit, pin)
            if not verdict.passed:
                return verdict
            self.session.has_tried(pin)
        return good(_("Errors by the tilts: {errors}.").format(errors="; ".join(error.name for error in self.errors()) or _("none")))

    def following(self, verdict):
        if not verdict.passed:
            return []
        more = []
        for error in self.errors():
            shown = abs(error.expected) >= SHOWN * self.session.tolerance
            (self.session.tried if shown else self.session.small).append(error.name)
            more += [WithoutIt(self.session, error), WithItHere(self.session, error), WithIt(self.session, error)] if shown else []
        return more

    def errors(self):
        return [Error(self.move, i) for i in range(3) if abs(self.move.change[i]) > LEAST * self.unit]


class WithoutIt(Step):
    """The error itself."""

    minutes = 4

    def __init__(self, session, move):
        super().__init__(session)
        self.move = move
        self.title = _("{axis} without the correction, {side}").format(axis=move.letter, side=move.direction)
        self.look = _("Set up the square along {axis}. The indicator is in the spindle; its plunger points to {side}+ and touches the blade, so that it reads "
                      "more when the tool moves to {side}+. Set it to 0 here, move {axis} back to {start}, and read it. Right: {right}. With the sign of "
                      "{names} wrong: {wrong}.").format(axis=move.letter, side=move.direction, start=number(move.start[0]), right=number(-move.expected, 4),
                                                        names=move.names(session), wrong=number(move.expected, 4))
        self.back = _("Nothing is applied: the function is off.")
        self.picture = ("square", move.letter)
        self.fields = (Field("read", _("Reading at the first end")),)

    def finish(self, values):
        place = self.move.look(self.session)[0]
        if abs(place - self.move.start[0]) > 0.05 * abs(self.move.travel):
            return Verdict("state", _("{axis} is not at the first end.").format(axis=self.move.letter), _("Move it there, and read again."))
        tolerance = max(self.session.tolerance, 0.15 * abs(self.move.expected))
        verdict = judge(-self.move.expected, values["read"], tolerance, _("Error by the tilts"), self.session.tolerance, "angle")
        if verdict.fault == "sign":
            tilts = self.move.tilts(self.session)
            if len(tilts) > 1:
                return verdict._replace(remedy=_("Reverse the signs of {names}, or measure again.").format(names=", ".join(tilts)))
            return verdict._replace(remedy=_("Reverse the sign of {names}.").format(names=self.move.names(self.session)))
        if not verdict.passed:
            for short, part in self.move.tilts(self.session).items():
                if abs(values["read"] + self.move.expected - 2 * part) <= tolerance:
                    return Verdict("sign", verdict.sentence, _("Reverse the sign of {names}.").format(names=short))
        return verdict


class WithItHere(OnTrial):
    """The corrected place at one end."""

    minutes = 1

    def __init__(self, session, move):
        super().__init__(session)
        self.move = move
        self.title = _("{axis} with the correction, {side}, here").format(axis=move.letter, side=move.direction)
        self.look = _("Leave {axis} and the indicator as they are. Press and hold: the function acts. Read the indicator; let go.").format(axis=move.letter)
        self.back = _("Letting go returns the correction to 0.")
        self.picture = ("square", move.letter)
        self.fields = (Field("read", _("Reading while pressed")),)

    @property
    def place(self):
        return self.move.start[0]

    def watch(self):
        super().watch()
        self.acted = self.acted and bool(self.rig.get(self.function.instance, "enabled"))

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        if abs(self.move.look(self.session)[0] - self.place) > 0.05 * abs(self.move.travel):
            return Verdict("state", _("{axis} is not at {place}.").format(axis=self.move.letter, place=number(self.place)), _("Move it there, and read again."))
        return self.judge(values["read"])

    def judge(self, read):
        self.move.here = read
        return good(_("Corrected, the indicator reads {reading} here.").format(reading=number(read, 4)))


class WithIt(WithItHere):
    """The corrected place at the other end: the reading stays."""

    minutes = 3

    def __init__(self, session, move):
        super().__init__(session, move)
        parts = ", ".join(_("{name} wrong: {reading} more").format(name=short, reading=number(2 * part, 4)) for short, part in move.tilts(session).items())
        self.title = _("{axis} with the correction, {side}").format(axis=move.letter, side=move.direction)
        self.look = _("Leave the indicator as it is, and move {axis} to {end}. Press and hold; read the indicator; let go. Right: the reading of the step "
                      "before. All signs wrong: {wrong} more. Not applied: {none} more.").format(
                          axis=move.letter, end=number(move.end[0]), wrong=number(2 * move.expected, 4), none=number(move.expected, 4)) + (
                              " " + parts + "." if parts else "")

    @property
    def place(self):
        return self.move.end[0]

    def judge(self, read):
        """The part that was corrected, of all that should be."""
        asked = self.move.expected
        return judge(asked, asked - (read - self.move.here), max(self.session.tolerance, 0.15 * abs(asked)), _("Correction"), self.session.tolerance)


class AnyTilt(Step):
    def __init__(self, session):
        super().__init__(session)
        session.tried, session.small = [], []
        self.title = _("All tilts tried")
        self.look = _("The program looks whether a travel has shown each tilt.")
        self.back = _("Nothing is applied: the function is off.")

    def finish(self, values):
        for small in self.session.small:
            self.session.not_tried(_("{error}: too small for the indicator").format(error=small))
        if self.session.tried:
            sentence = _("Tried, with the right sign: {errors}.").format(errors="; ".join(self.session.tried))
            return good(sentence + (" " + _("Not tried, too small: {errors}.").format(errors="; ".join(self.session.small)) if self.session.small else ""))
        tilts = [short for short, pin in self.function.instance.pins.items()
                 if re.fullmatch(r"e[abc]0[xyzuvw]", short) and self.rig.get(self.function.instance, short)]
        if tilts:
            return Verdict("missing", _("No travel was long enough to see {names}.").format(names=", ".join(tilts)), _("Repeat with longer travels."))
        return Verdict("missing", _("No tilt is set, so that nothing can be tried."), _("Measure a square, and set the lines of plumb squareness."))

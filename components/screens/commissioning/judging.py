# SPDX-License-Identifier: GPL-2.0-or-later
"""What a reading says about the wiring: nothing is wrong, or which fault it is."""

import typing

from panel.texts import _, number

NEAR = 0.12  # of a size, so far from it a reading may be
SHOWN = 4  # times the tolerance of a reading: the least that a step asks for
INCH, THOUSAND = 25.4, 1000.0


class Verdict(typing.NamedTuple):
    """`fault` is a word for programs: "", "sign", "inch", "millimetre", "twice", "half", "ten", "tenth", "thousand", "thousandth", "percent", "nothing",
    "stayed", "joint", "net", "order", "size", "state", "missing", "untried"."""

    fault: str
    sentence: str
    remedy: str = ""

    @property
    def passed(self):
        return not self.fault


def good(sentence):
    return Verdict("", sentence)


def sizes(kind):
    """Factors of a reading of a "length", "angle", "load" or "temperature", with their faults."""
    lengths = (
        (INCH, "inch", _("25.4 times too much: a millimetre is taken for an inch."), _("Check the scale of the drive and unit= in the loadrt lines.")),
        (1 / INCH, "millimetre", _("25.4 times too little: an inch is taken for a millimetre."),
         _("Check the scale of the drive and unit= in the loadrt lines.")),
        (2.0, "twice", _("Twice as much: a radius is taken for a diameter, or two stages add the offset."),
         _("Check for radius and diameter, and that one stage has this offset.")),
        (0.5, "half", _("Half as much: a diameter is taken for a radius."), _("Check for radius and diameter, and the scale of the drive.")),
    )
    angles = (
        (2.0, "twice", _("Twice as much: the angle that is set is half of the real one."), _("Check over which length the angle was measured, and measure it again.")),
        (0.5, "half", _("Half as much: the angle that is set is twice the real one."), _("Check over which length the angle was measured, and measure it again.")),
    )
    loads = ((10.0, "ten", _("10 times too much: 10 V is taken for 1 V."), _("Scale the signal: 100 is the rating of the drive.")),
             (0.1, "tenth", _("10 times too little: 1 V is taken for 10 V."), _("Scale the signal: 100 is the rating of the drive.")))
    units = (
        (THOUSAND, "thousand", _("1000 times too much: a unit is milli or micro of the other one."), _("Check the scale of the drive, and the reading.")),
        (1 / THOUSAND, "thousandth", _("1000 times too little: a unit is milli or micro of the other one."),
         _("Check the scale of the drive, and the reading.")),
        (100.0, "percent", _("100 times too much: a part is taken for percent."), _("Scale the signal: the pin expects percent.")),
        (0.01, "percent", _("100 times too little: percent is expected, and a part comes."), _("Scale the signal: the pin expects percent.")),
    )
    return {"length": lengths, "angle": angles, "load": loads, "temperature": ()}[kind] + units


def remedy_of_size(kind):
    """For a reading of a size that no usual mistake has."""
    return {
        "length": _("Check scale, backlash, stick, and the indicator itself."),
        "angle": _("Check the angle that is set, backlash, stick, and the indicator itself."),
        "load": _("Check the scale of the signal, the rating of the drive, and that both show the same load."),
        "temperature": _("Check the type and the scale of the sensor."),
    }[kind]


def judge(asked, read, tolerance, what="", smallest=None, kind="length"):
    """A reading against the value that it should have; both in one unit and of one kind. `smallest` is the size from which a reading is one."""
    smallest = tolerance if smallest is None else smallest
    shown = _("asked {asked}, read {read}").format(asked=number(asked, 4), read=number(read, 4))
    shown = "%s: %s" % (what, shown) if what else shown[:1].upper() + shown[1:]
    if not 2 * tolerance <= abs(asked):
        return Verdict("untried", _("Not tried: {asked} cannot be told from 0 within {tolerance}.").format(asked=number(asked, 4), tolerance=number(tolerance, 4)),
                       _("Use an indicator that shows less, or a larger travel."))
    if abs(read - asked) <= tolerance:
        return good(shown + ".")
    if abs(read + asked) <= tolerance:
        return Verdict("sign", shown + ". " + _("The sign is wrong."), _("Reverse the sign: of the scale of the drive, of the signal or of the setting."))
    for factor, fault, words, remedy in sizes(kind):
        for sign in (1, -1):
            expected = sign * factor * asked
            near = max(NEAR * abs(expected), min(smallest, abs(expected) / 3))
            if abs(expected) > smallest / 2 and abs(expected - asked) > tolerance and abs(read - expected) <= near:
                words_of_sign = " " + _("The sign is wrong, too.") if sign < 0 else ""
                return Verdict(fault, shown + ". " + words + words_of_sign, remedy)
    if abs(read) <= smallest:
        return Verdict("nothing", shown + ". " + _("Nothing moved."), _("Check that the signal reaches its drive or sensor."))
    return Verdict("size", shown + ". " + _("The size fits none of the usual mistakes."), remedy_of_size(kind))


def judge_press(asked, pressed, released, tolerance):
    """A joint that went by `asked` and should be back."""
    verdict = judge(asked, pressed, tolerance)
    if not verdict.passed:
        return verdict
    if not abs(released) <= tolerance:
        return Verdict("stayed", _("It moved, and stayed: {read} after letting go.").format(read=number(released, 4)),
                       _("Look for stick and backlash, and whether the drive takes its command back."))
    return verdict

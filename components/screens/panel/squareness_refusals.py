# SPDX-License-Identifier: GPL-2.0-or-later
"""The refusals of plumb squareness that a screen can meet, in the user's language and without the names of options. Without a screen."""

import re

from panel.texts import _, number


def in_words(reason):
    """What plumb squareness says if this module does not know it."""
    reason = re.sub(r"^plumb squareness: (standard input: )?", "", reason)
    reason = re.sub(r"^(leans|measurements|in_force)\[\d+\]: ", "", reason)
    for pattern, words in _known():
        found = re.search(pattern, reason)
        if found:
            given = {name: number(round(float(text), 6), 4) if name.startswith("number") else text.replace("-", "\u2212")
                     for name, text in found.groupdict().items()}
            return words.format(**given)
    return reason


def _known():
    return (
        (r"'(?P<text>[^']*)' does not begin with a number", _("\"{text}\" is no number.")),
        (r"'(?P<text>[^']*)' has an unknown unit", _("\"{text}\" is no number with a unit.")),
        (r"'(?P<text>[^']*)' is longer than 1 km", _("{text} is longer than 1 km.")),
        (r"axis (?P<axis>\w) cannot lean towards (?P<side>\S+) by (?P<number>\S+) rad",
         _("{axis} cannot lean to {side} by {number} rad: at most 0.1 rad. Check the unit.")),
        (r"^(?P<name>\w+) would be (?P<number>\S+) rad", _("{name} would be {number} rad: at most 0.1 rad. Check the readings and their units.")),
        (r"^(?P<name>\w+) is set and follows from measurements", _("{name} was entered, and follows from a measurement, too. Remove one of them.")),
        (r"the positions are all the same", _("The positions are all the same: move the axis between two readings.")),
        (r"less than anybody can measure",
         _("The uncertainty is smaller than anybody can measure. Enter the uncertainty of your indicator.")),
        (r"the readings rise too steeply", _("The readings rise too steeply. Check their units.")),
        (r"measurements of (?P<one>\w) and (?P<other>\w) contradict each other.* (?P<number>\S+) times their uncertainty",
         _("Two measurements of {one} and {other} contradict each other by {number} times their uncertainty. Remove the one with the wrong sign or unit.")),
        (r"a diagonal is not longer than 0", _("A diagonal must be longer than 0.")),
        (r"diagonals of (?P<number_a>\S+) and (?P<number_b>\S+) mm are not those of a rectangle",
         _("Diagonals of {number_a} and {number_b} mm are not those of a rectangle. Measure again.")),
        (r"(?P<file>[^/]*): No such file or directory", _("{file}: there is no such file.")),
        (r"(?P<file>[^/]*): there are no rows in it", _("{file}: there are no rows in it.")),
        (r"(?P<file>[^/]*): line (?P<line>\d+): '(?P<text>[^']*)' is no column",
         _("{file}, line {line}: \"{text}\" is no column of probed points.")),
    )

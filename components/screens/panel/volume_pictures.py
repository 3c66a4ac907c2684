# SPDX-License-Identifier: GPL-2.0-or-later
"""Charts of measured errors: an error of an axis along its travel, and circles."""

import math

from panel.chart import CURVES, Frame, signed
from panel.picture import Picture
from panel.texts import _

MICRO = 1e6  # of rad; of mm 1e3


class TableChart(Picture):
    """An error of an axis at the positions of its table, after motion to either end if they differ."""

    def __init__(self, panel, error, its):
        super().__init__(panel, _("Table of {error}").format(error=error), (300, 200))
        self._rows = its["rows"]
        self._scale, self._unit = (1e3, "\u00b5m") if its["unit"] == "mm" else (MICRO, "\u00b5rad")
        plus, minus = (_("to {direction}").format(direction=sign + error[2]) for sign in ("+", "\u2212"))
        self._names = (plus, minus) if its["directed"] else (error,)

    def draw(self, pen, width, height):
        curves = [[(row[0], row[place + 1] * self._scale) for row in self._rows] for place in range(len(self._names))]
        first, last = self._rows[0][0], self._rows[-1][0]
        values = [value for curve in curves for _at, value in curve]
        frame = Frame(pen, (width, height), values, 1, self._names, self._unit, (first, last))
        for place, at in enumerate((first, (first + last) / 2, last)):
            words = signed(round(at, 3)) + (" mm" if place == 2 else "")
            frame.mark(at, words, pen.advance_of(words, 14) * place / 2)
        for number, curve in enumerate(curves):
            frame.curve(number, curve)
            for at, value in curve if len(curve) < 30 else ():
                pen.disc(frame.x(at), frame.y(value), 3, CURVES[number][0])


class CirclePicture(Picture):
    """A circle that a ballbar read in one direction or in both, its deviation enlarged."""

    def __init__(self, panel, words, paths, largest):
        """`largest` is the deviation, in mm, that fills a quarter of the radius; the same before and after."""
        super().__init__(panel, _("Circle {words}").format(words=words), (260, 310))
        self._words, self._paths, self._largest = words, paths, largest

    def draw(self, pen, width, height):
        pen.paper()
        names = [_("clockwise") if path["clockwise"] else _("counter-clockwise") for path in self._paths]
        for place, (name, (colour, _dashes)) in enumerate(zip(names, CURVES)):
            pen.words(10, 40 + 18 * place, name, 14, colour)
        pen.words(10, 20, self._words, 14)
        top = 60  # below the words
        middle_x, middle_y = width / 2, (top + height) / 2
        size = min(width, height - top) / 2 / 1.27

        def place_of(angle, deviation):
            radius = size * (1 + 0.25 * deviation / self._largest)
            return middle_x + radius * math.cos(angle), middle_y - radius * math.sin(angle)

        pen.circle(middle_x, middle_y, size, "soft", 1.5, (4, 4))
        for path, (colour, dashes) in zip(self._paths, CURVES):
            points = [place_of(math.radians(angle), deviation) for angle, deviation in sorted(path["points"])]
            pen.lines([points], colour, 2.5, dashes, closed=True)

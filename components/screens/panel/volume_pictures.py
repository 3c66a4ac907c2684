# SPDX-License-Identifier: GPL-2.0-or-later
"""Charts of measured errors: an error of an axis along its travel, and circles."""

import math

from gi.repository import Gtk

from panel import style as styles
from panel.chart import DASHES, Frame, signed
from panel.texts import _
from panel.widgets import named

MICRO = 1e6  # of rad; of mm 1e3


class TableChart(Gtk.DrawingArea):
    """An error of an axis at the positions of its table, after motion to either end if they differ."""

    def __init__(self, panel, error, its):
        super().__init__()
        self._panel, self._its = panel, its
        self._scale, self._unit = (1e3, "\u00b5m") if its["unit"] == "mm" else (MICRO, "\u00b5rad")
        plus, minus = (_("to {direction}").format(direction=sign + error[2]) for sign in ("+", "\u2212"))
        self._names = (plus, minus) if its["directed"] else (error,)
        self.set_size_request(300, 200)
        self.connect("draw", self._draw)
        named(self, _("Table of {error}").format(error=error))

    def _draw(self, _area, cairo):
        rows = self._its["rows"]
        curves = [[(row[0], row[place + 1] * self._scale) for row in rows] for place in range(len(self._names))]
        first, last = rows[0][0], rows[-1][0]
        values = [value for curve in curves for _at, value in curve]
        frame = Frame(self, cairo, self._panel.dark, values, 1, self._names, self._unit, (first, last))
        for place, at in enumerate((first, (first + last) / 2, last)):
            words = signed(round(at, 3)) + (" mm" if place == 2 else "")
            frame.mark(at, words, cairo.text_extents(words).x_advance * place / 2)
        for number, curve in enumerate(curves):
            frame.curve(number, curve)
            for at, value in curve if len(curve) < 30 else ():
                cairo.arc(frame.x(at), frame.y(value), 3, 0, 2 * math.pi)
                cairo.fill()


class CirclePicture(Gtk.DrawingArea):
    """A circle that a ballbar read in one direction or in both, its deviation enlarged."""

    def __init__(self, panel, words, paths, largest):
        """`largest` is the deviation, in mm, that fills a quarter of the radius; the same before and after."""
        super().__init__()
        self._panel, self._words, self._paths, self._largest = panel, words, paths, largest
        self.set_size_request(260, 310)
        self.connect("draw", self._draw)
        named(self, _("Circle {words}").format(words=words))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        cairo.set_source_rgb(*styles.colour(dark, "card"))
        cairo.paint()
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(14)
        colours = [styles.colour(dark, name) for name in ("curve", "curve2")]
        names = [_("clockwise") if path["clockwise"] else _("counter-clockwise") for path in self._paths]
        for place, name in enumerate(names):
            cairo.set_source_rgb(*colours[place])
            cairo.move_to(10, 40 + 18 * place)
            cairo.show_text(name)
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(10, 20)
        cairo.show_text(self._words)
        top = 60  # below the words
        middle_x, middle_y = width / 2, (top + height) / 2
        size = min(width, height - top) / 2 / 1.27

        def place_of(angle, deviation):
            radius = size * (1 + 0.25 * deviation / self._largest)
            return middle_x + radius * math.cos(angle), middle_y - radius * math.sin(angle)

        cairo.set_source_rgb(*styles.colour(dark, "soft"))
        cairo.set_dash([4, 4])
        cairo.set_line_width(1.5)
        cairo.new_path()
        cairo.arc(middle_x, middle_y, size, 0, 2 * math.pi)
        cairo.stroke()
        for path, colour, dashes in zip(self._paths, colours, DASHES):
            cairo.set_source_rgb(*colour)
            cairo.set_dash(dashes)
            cairo.set_line_width(2.5)
            for angle, deviation in sorted(path["points"]):
                cairo.line_to(*place_of(math.radians(angle), deviation))
            cairo.close_path()
            cairo.stroke()
        cairo.set_dash([])

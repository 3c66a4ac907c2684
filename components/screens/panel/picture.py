# SPDX-License-Identifier: GPL-2.0-or-later
"""A picture in a widget, and the pen that draws it in the colours of the panel."""

import math

from gi.repository import Gtk

from panel import style as styles
from panel.widgets import named


class Picture(Gtk.DrawingArea):
    """A subclass draws itself in draw(pen, width, height)."""

    def __init__(self, panel, name, size):
        super().__init__()
        self.set_size_request(*size)
        self.connect("draw", lambda _area, cairo: self.draw(Pen(cairo, panel.dark), self.get_allocated_width(), self.get_allocated_height()))
        named(self, name)


class Pen:
    """Draws in pixels, Y downward. A colour is a name of style.py."""

    def __init__(self, cairo, dark):
        self.cairo, self._dark = cairo, dark
        cairo.select_font_face("DejaVu Sans")

    def _take(self, colour):
        self.cairo.set_source_rgb(*styles.colour(self._dark, colour))

    def paper(self, colour="card"):
        self._take(colour)
        self.cairo.paint()

    def line(self, *points, colour="text", width=2.0, dashes=()):
        self.lines([points], colour, width, dashes)

    def lines(self, lines, colour="text", width=2.0, dashes=(), closed=False):
        """Lines through points each."""
        self.cairo.new_path()
        for points in lines:
            self._path(points, closed)
        self._stroke(colour, width, dashes)

    def shape(self, *points, colour):
        self._path(points, closed=True)
        self._take(colour)
        self.cairo.fill()

    def box(self, x, y, width, height, fill, edge=None, edge_width=2.0):
        self.cairo.rectangle(x, y, width, height)
        self._fill(fill, edge, edge_width)

    def disc(self, x, y, radius, fill="text", edge=None, edge_width=2.0):
        self.cairo.new_path()
        self.cairo.arc(x, y, radius, 0, 2 * math.pi)
        self._fill(fill, edge, edge_width)

    def circle(self, x, y, radius, colour="text", width=2.0, dashes=()):
        self.cairo.new_path()
        self.cairo.arc(x, y, radius, 0, 2 * math.pi)
        self._stroke(colour, width, dashes)

    def arrow(self, start, end, width=3.0):
        angle = math.atan2(end[1] - start[1], end[0] - start[0])
        self.line(start, end, width=width)
        self.shape(end, *((end[0] + 14 * math.cos(angle + turn), end[1] + 14 * math.sin(angle + turn)) for turn in (2.6, -2.6)), colour="text")

    def words(self, x, y, words, size, colour="text"):
        """Begins at x, on the line y."""
        self.cairo.set_font_size(size)
        self._take(colour)
        self.cairo.move_to(x, y)
        self.cairo.show_text(words)

    def width_of(self, words, size):
        self.cairo.set_font_size(size)
        return self.cairo.text_extents(words).width

    def advance_of(self, words, size):
        """Width with the space after it."""
        self.cairo.set_font_size(size)
        return self.cairo.text_extents(words).x_advance

    def _path(self, points, closed):
        for number, point in enumerate(points):
            (self.cairo.line_to if number else self.cairo.move_to)(*point)
        if closed:
            self.cairo.close_path()

    def _fill(self, fill, edge, edge_width):
        self._take(fill)
        self.cairo.fill_preserve()
        if edge:
            self._stroke(edge, edge_width, ())
        self.cairo.new_path()

    def _stroke(self, colour, width, dashes):
        self._take(colour)
        self.cairo.set_line_width(width)
        self.cairo.set_dash(dashes)
        self.cairo.stroke()
        self.cairo.set_dash(())

# SPDX-License-Identifier: GPL-2.0-or-later
"""A chart of values over time, and the history that it shows."""

import collections
import math
import time

from gi.repository import Gtk

from panel import style as styles
from panel.texts import _
from panel.widgets import named


class History:
    """One row each `every` seconds, for `span` seconds; a row is a tuple of values."""

    def __init__(self, every=10, span=8 * 3600):
        self.every, self.rows, self.marks = every, collections.deque(maxlen=int(span / every)), collections.deque(maxlen=500)
        self._due = 0

    def add(self, *values):
        """Returns whether a row was due."""
        now = time.monotonic()
        if now < self._due:
            return False
        self._due = now + self.every
        self.rows.append((now, values))
        return True

    def mark(self, value, sigma, good):
        self.marks.append((time.monotonic(), value, sigma, good))


class Chart(Gtk.DrawingArea):
    """Curves of a History over the last hours; marks with their standard deviation as bars."""

    def __init__(self, panel, history, names, unit, scale=1.0):
        super().__init__()
        self._panel, self._history, self._names, self._unit, self._scale = panel, history, names, unit, scale
        self.set_size_request(300, 230)
        self.connect("draw", self._draw)
        named(self, ", ".join(names) or _("Chart"))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        colours = [styles.colour(dark, name) for name in ("curve", "curve2", "soft")]
        cairo.set_source_rgb(*styles.colour(dark, "card"))
        cairo.paint()
        rows = self._history.rows
        now = time.monotonic()
        start = rows[0][0] if rows else now
        span = next((each for each in (600, 1800, 3600, 2 * 3600, 4 * 3600, 8 * 3600) if each >= now - start), 8 * 3600)
        numbers = [value * self._scale for _when, values in rows for value in values if math.isfinite(value)]
        numbers += [value * self._scale for _when, value, _sigma, _good in self._history.marks if math.isfinite(value)]
        levels = levels_of(numbers, 5)
        low, high = levels[0], levels[-1]
        left, right, top, bottom = 62, width - 12, 34, height - 30

        def x(when):
            return right - (now - when) / span * (right - left)

        def y(value):
            return bottom - (value - low) / (high - low) * (bottom - top)

        draw_levels(cairo, dark, levels, y, left, right)
        for part in range(5):
            at = left + (right - left) * part / 4
            cairo.move_to(at - (12 if part == 0 else 40 if part == 4 else 22), height - 8)
            minutes = span * (4 - part) / 4 / 60
            cairo.show_text(_("now") if part == 4 else "\u2212%g h" % (minutes / 60) if span > 3600 else "\u2212%g min" % minutes)
        draw_names(cairo, self._names, colours, left)
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(right - cairo.text_extents(self._unit).x_advance, 21)
        cairo.show_text(self._unit)
        cairo.rectangle(left, top, right - left, bottom - top)
        cairo.clip()
        for place, (colour, dashes) in enumerate(zip(colours, DASHES)):
            if place >= len(self._names):
                break
            cairo.set_source_rgb(*colour)
            cairo.set_dash(dashes)
            cairo.set_line_width(2.5)
            drawing = False
            for when, values in rows:
                if place >= len(values) or not math.isfinite(values[place]):
                    drawing = False
                    continue
                (cairo.line_to if drawing else cairo.move_to)(x(when), y(values[place] * self._scale))
                drawing = True
            cairo.stroke()
        cairo.set_dash([])
        cairo.set_line_width(2)
        for when, value, sigma, good in self._history.marks:
            if not math.isfinite(value):
                continue
            cairo.set_source_rgb(*styles.colour(dark, "text" if good else "bad"))
            middle = y(value * self._scale)
            cairo.move_to(x(when), y((value - 2 * sigma) * self._scale))
            cairo.line_to(x(when), y((value + 2 * sigma) * self._scale))
            cairo.stroke()
            if good:
                cairo.arc(x(when), middle, 4, 0, 2 * math.pi)
                cairo.fill()
            else:
                for sign in (1, -1):
                    cairo.move_to(x(when) - 5, middle - 5 * sign)
                    cairo.line_to(x(when) + 5, middle + 5 * sign)
                cairo.stroke()


DASHES = ([], [8, 4], [2, 3])  # of the first curve and the others


def levels_of(numbers, least):
    """The levels of a scale from the lowest to the highest number; from -least to least at least."""
    low, high = min(numbers + [-least]), max(numbers + [least])
    step = _step((high - low) / 4)
    return [step * place for place in range(math.floor(low / step), math.ceil(high / step) + 1)]


def draw_levels(cairo, dark, levels, y, left, right):
    """Horizontal lines with their values on the left."""
    cairo.select_font_face("DejaVu Sans")
    cairo.set_font_size(14)
    cairo.set_line_width(1)
    for value in levels:
        cairo.set_source_rgb(*styles.colour(dark, "line"))
        cairo.move_to(left, y(value))
        cairo.line_to(right, y(value))
        cairo.stroke()
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(6, y(value) + 5)
        cairo.show_text(("%g" % round(value, 6)).replace("-", "\u2212"))


def draw_names(cairo, names, colours, left):
    """What each curve is, above the curves."""
    at = left
    for name, colour, dashes in zip(names, colours, DASHES):
        cairo.set_source_rgb(*colour)
        cairo.set_dash(dashes)
        cairo.set_line_width(3)
        cairo.move_to(at, 16)
        cairo.line_to(at + 30, 16)
        cairo.stroke()
        cairo.move_to(at + 36, 21)
        cairo.show_text(name)
        at += 52 + cairo.text_extents(name).x_advance
    cairo.set_dash([])


def _step(rough):
    """1, 2 or 5 times a power of ten, at least `rough`."""
    power = 10 ** math.floor(math.log10(max(rough, 1e-9)))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * 0.999)

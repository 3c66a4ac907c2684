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
        dark = self._panel.dark
        rows = self._history.rows
        now = time.monotonic()
        start = rows[0][0] if rows else now
        span = next((each for each in (600, 1800, 3600, 2 * 3600, 4 * 3600, 8 * 3600) if each >= now - start), 8 * 3600)
        numbers = [value * self._scale for _when, values in rows for value in values if math.isfinite(value)]
        numbers += [value * self._scale for _when, value, _sigma, _good in self._history.marks if math.isfinite(value)]
        frame = Frame(self, cairo, dark, numbers, 5, self._names, self._unit, (now - span, now))
        x, y = frame.x, frame.y
        for part in range(5):
            minutes = span * (4 - part) / 4 / 60
            words = _("now") if part == 4 else "\u2212%g h" % (minutes / 60) if span > 3600 else "\u2212%g min" % minutes
            frame.mark(now - minutes * 60, words, 12 if part == 0 else 40 if part == 4 else 22)
        cairo.rectangle(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top)
        cairo.clip()
        for place in range(len(self._names)):
            frame.curve(place, ((when, values[place] * self._scale if place < len(values) else math.nan) for when, values in rows))
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


class Frame:
    """The frame of a chart in a widget: horizontal lines with their values, the names of the curves, the unit, and the scales of both axes."""

    def __init__(self, area, cairo, dark, numbers, least, names, unit, span):
        """The scale has all numbers, and reaches from -least to least at least; `span` is its first and last place along X."""
        self._cairo, self._span = cairo, span
        self._colours = [styles.colour(dark, name) for name in ("curve", "curve2", "soft")]
        self.left, self.right, self.top, self.bottom = 62, area.get_allocated_width() - 12, 34, area.get_allocated_height() - 30
        self._levels = levels_of(numbers, least)
        cairo.set_source_rgb(*styles.colour(dark, "card"))
        cairo.paint()
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(14)
        cairo.set_line_width(1)
        for value in self._levels:
            cairo.set_source_rgb(*styles.colour(dark, "line"))
            cairo.move_to(self.left, self.y(value))
            cairo.line_to(self.right, self.y(value))
            cairo.stroke()
            cairo.set_source_rgb(*styles.colour(dark, "text"))
            cairo.move_to(6, self.y(value) + 5)
            cairo.show_text(signed(round(value, 6)))
        self._write_names(names)
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(self.right - cairo.text_extents(unit).x_advance, 21)
        cairo.show_text(unit)

    def _write_names(self, names):
        cairo, at = self._cairo, self.left
        for name, colour, dashes in zip(names, self._colours, DASHES):
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

    def x(self, place):
        first, last = self._span
        return self.left + (place - first) / (last - first) * (self.right - self.left)

    def y(self, value):
        low, high = self._levels[0], self._levels[-1]
        return self.bottom - (value - low) / (high - low) * (self.bottom - self.top)

    def mark(self, place, words, beside):
        """Words below a place along X, which begin this far beside it."""
        self._cairo.move_to(self.x(place) - beside, self.bottom + 22)
        self._cairo.show_text(words)

    def curve(self, number, points):
        """A line, with a gap where a value is not a number."""
        cairo = self._cairo
        cairo.set_source_rgb(*self._colours[number])
        cairo.set_dash(DASHES[number])
        cairo.set_line_width(2.5)
        cairo.new_path()
        drawing = False
        for place, value in points:
            if math.isfinite(value):
                (cairo.line_to if drawing else cairo.move_to)(self.x(place), self.y(value))
            drawing = math.isfinite(value)
        cairo.stroke()
        cairo.set_dash([])


def signed(value):
    return ("%g" % value).replace("-", "\u2212")


def levels_of(numbers, least):
    """The levels of a scale from the lowest to the highest number; from -least to least at least."""
    low, high = min(numbers + [-least]), max(numbers + [least])
    step = _step((high - low) / 4)
    return [step * place for place in range(math.floor(low / step), math.ceil(high / step) + 1)]


def _step(rough):
    """1, 2 or 5 times a power of ten, at least `rough`."""
    power = 10 ** math.floor(math.log10(max(rough, 1e-9)))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * 0.999)

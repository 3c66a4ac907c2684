# SPDX-License-Identifier: GPL-2.0-or-later
"""A chart of values over time, and the history that it shows."""

import collections
import math
import time

from panel.picture import Picture
from panel.texts import _


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


class Chart(Picture):
    """Curves of a History over the last hours; marks with their standard deviation as bars."""

    def __init__(self, panel, history, names, unit, scale=1.0):
        super().__init__(panel, ", ".join(names) or _("Chart"), (300, 230))
        self._history, self._names, self._unit, self._scale = history, names, unit, scale

    def draw(self, pen, width, height):
        rows = self._history.rows
        now = time.monotonic()
        start = rows[0][0] if rows else now
        span = next((each for each in (600, 1800, 3600, 2 * 3600, 4 * 3600, 8 * 3600) if each >= now - start), 8 * 3600)
        numbers = [value * self._scale for _when, values in rows for value in values if math.isfinite(value)]
        numbers += [value * self._scale for _when, value, _sigma, _good in self._history.marks if math.isfinite(value)]
        frame = Frame(pen, (width, height), numbers, 5, self._names, self._unit, (now - span, now))
        for part in range(5):
            minutes = span * (4 - part) / 4 / 60
            words = _("now") if part == 4 else "\u2212%g h" % (minutes / 60) if span > 3600 else "\u2212%g min" % minutes
            frame.mark(now - minutes * 60, words, 12 if part == 0 else 40 if part == 4 else 22)
        frame.clip()
        for place in range(len(self._names)):
            frame.curve(place, ((when, values[place] * self._scale if place < len(values) else math.nan) for when, values in rows))
        for when, value, sigma, good in self._history.marks:
            if not math.isfinite(value):
                continue
            x, low, middle, high = frame.x(when), *(frame.y(each * self._scale) for each in (value - 2 * sigma, value, value + 2 * sigma))
            colour = "text" if good else "bad"
            pen.line((x, low), (x, high), colour=colour)
            if good:
                pen.disc(x, middle, 4)
            else:
                pen.lines([((x - 5, middle - 5 * sign), (x + 5, middle + 5 * sign)) for sign in (1, -1)], colour)


CURVES = (("curve", ()), ("curve2", (8, 4)), ("soft", (2, 3)))  # colour and dashes of the first curve and the others


class Frame:
    """The frame of a chart: horizontal lines with their values, the names of the curves, the unit, and the scales of both axes."""

    def __init__(self, pen, size, numbers, least, names, unit, span):
        """The scale has all numbers, and reaches from -least to least at least; `span` is its first and last place along X."""
        self._pen, self._span = pen, span
        self.left, self.right, self.top, self.bottom = 62, size[0] - 12, 34, size[1] - 30
        self._levels = levels_of(numbers, least)
        pen.paper()
        for value in self._levels:
            pen.line((self.left, self.y(value)), (self.right, self.y(value)), colour="line", width=1)
            pen.words(6, self.y(value) + 5, signed(round(value, 6)), 14)
        at = self.left
        for name, (colour, dashes) in zip(names, CURVES):
            pen.line((at, 16), (at + 30, 16), colour=colour, width=3, dashes=dashes)
            pen.words(at + 36, 21, name, 14, colour)
            at += 52 + pen.advance_of(name, 14)
        pen.words(self.right - pen.advance_of(unit, 14), 21, unit, 14)

    def x(self, place):
        first, last = self._span
        return self.left + (place - first) / (last - first) * (self.right - self.left)

    def y(self, value):
        low, high = self._levels[0], self._levels[-1]
        return self.bottom - (value - low) / (high - low) * (self.bottom - self.top)

    def mark(self, place, words, beside):
        """Words below a place along X, which begin this far beside it."""
        self._pen.words(self.x(place) - beside, self.bottom + 22, words, 14)

    def clip(self):
        """Nothing is drawn outside the frame from here on."""
        self._pen.cairo.rectangle(self.left, self.top, self.right - self.left, self.bottom - self.top)
        self._pen.cairo.clip()

    def curve(self, number, points):
        """A line, with a gap where a value is not a number."""
        parts = [[]]
        for place, value in points:
            if math.isfinite(value):
                parts[-1].append((self.x(place), self.y(value)))
            elif parts[-1]:
                parts.append([])
        self._pen.lines(parts, CURVES[number][0], 2.5, CURVES[number][1])


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

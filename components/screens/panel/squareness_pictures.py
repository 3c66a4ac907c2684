# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of squareness: a machine by its chain, an axis that leans, and the working volume."""

import math

from gi.repository import Gtk

from panel import squareness_program as program, style as styles
from panel.texts import _
from panel.widgets import named


class ChainPicture(Gtk.DrawingArea):
    """A machine by its chain: the work on its axes on the left, the tool on its axes on the right, the bed below."""

    def __init__(self, panel, chain, lean=None):
        super().__init__()
        self._panel, self._chain, self._lean = panel, chain, lean
        self.set_size_request(220, 150)
        self.connect("draw", self._draw)
        named(self, _("Machine {chain}").format(chain=chain))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        text, line, fill = (styles.colour(dark, name) for name in ("text", "good", "pick"))
        work, tool = _sides(self._chain)
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(17)

        def block(x, y, w, h, words):
            cairo.rectangle(x, y, w, h)
            cairo.set_source_rgb(*fill)
            cairo.fill_preserve()
            cairo.set_source_rgb(*line)
            cairo.set_line_width(2)
            cairo.stroke()
            cairo.set_font_size(17)
            cairo.set_font_size(17 * min(1, (w - 4) / max(1, cairo.text_extents(words).width)))
            extents = cairo.text_extents(words)
            cairo.set_source_rgb(*text)
            cairo.move_to(x + (w - extents.width) / 2, y + h / 2 + 6)
            cairo.show_text(words)

        base = height - 26
        block(8, base, width - 16, 22, _("bed"))
        step = min(26, (base - 14) / max(len(work) + 1, len(tool) + 1))
        for place, axis in enumerate(work):
            block(14 + place * 5, base - (place + 1) * step, width * 0.42 - place * 10, step - 3, axis)
        block(14 + len(work) * 5 + 16, base - (len(work) + 1) * step, width * 0.42 - len(work) * 10 - 32, step - 3, _("work"))
        for place, axis in enumerate(tool):
            block(width * 0.55 + place * 5, base - (place + 1) * step, width * 0.42 - place * 10, step - 3, axis)
        block(width * 0.55 + len(tool) * 5 + 16, base - (len(tool) + 1) * step, width * 0.42 - len(tool) * 10 - 32, step - 3, _("tool"))


def _sides(chain):
    """Axes from the bed outwards: those that carry the work, and those that carry the tool."""
    before, after = (chain.split("b", 1) + [""])[:2] if "b" in chain else ("", chain)
    tool = program.axes_of(after)
    work = list(reversed(program.axes_of(before)))
    if not before:
        work = [axis for axis in "XYZ" if axis not in tool]
    return work, tool


class LeanPicture(Gtk.DrawingArea):
    """An axis, and dashed as it leans; the arrow at its + end shows to which side. X goes to the right, Y to the back, Z upward."""

    SIDES = {"X": (1, 0), "Y": (0.62, 0.5), "Z": (0, 1)}  # on the screen, to the right and upward
    LIKE = {"U": "X", "V": "Y", "W": "Z"}
    LEANS = 0.42  # of the length of the axis

    def __init__(self, panel, axis, direction, size=(260, 150)):
        super().__init__()
        self._panel, self._axis, self._direction = panel, axis, direction
        self.set_size_request(*size)
        self.connect("draw", self._draw)
        named(self, _("{axis} leans to {direction}").format(axis=axis, direction=direction))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        along = self.SIDES[self.LIKE.get(self._axis, self._axis)]
        sense = self.LEANS if self._direction[0] == "+" else -self.LEANS
        lean = tuple(sense * part for part in self.SIDES[self._direction[1]])
        points = [(0, 0), along, tuple(sum(pair) for pair in zip(along, lean))]
        left, right = min(x for x, _y in points), max(x for x, _y in points)
        low, high = min(y for _x, y in points), max(y for _x, y in points)
        size = min((width - 84) / max(right - left, 0.1), (height - 56) / max(high - low, 0.1), 150)

        def place(point):
            x, y = point
            return width / 2 + (x - (left + right) / 2) * size, height / 2 - (y - (low + high) / 2) * size

        foot, stands, leans = (place(point) for point in points)
        for end, colour, dashes in ((stands, "curve", []), (leans, "curve2", [10, 6])):
            cairo.set_source_rgb(*styles.colour(dark, colour))
            cairo.set_dash(dashes)
            cairo.set_line_width(4)
            cairo.move_to(*foot)
            cairo.line_to(*end)
            cairo.stroke()
        cairo.set_dash([])
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        _draw_arrow(cairo, stands, leans)
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(17)
        beside_line = along[1] == 0 and lean[0] != 0  # left or right of its + end there is the axis itself
        for point, words, other in ((stands, "+" + self._axis, leans), (leans, self._direction.replace("-", "\u2212"), stands)):
            extents = cairo.text_extents(words)
            away = (point[0] > other[0]) - (point[0] < other[0])
            x = point[0] - extents.width / 2 if beside_line else point[0] + 10 if away >= 0 else point[0] - extents.width - 10
            y = point[1] + (6 if not beside_line else 24 if point[1] > other[1] else -10)
            cairo.move_to(x, y)
            cairo.show_text(words)


def _draw_arrow(cairo, start, end):
    angle = math.atan2(end[1] - start[1], end[0] - start[0])
    cairo.set_line_width(3)
    cairo.move_to(*start)
    cairo.line_to(*end)
    cairo.stroke()
    cairo.move_to(*end)
    for turn in (2.6, -2.6):
        cairo.line_to(end[0] + 14 * math.cos(angle + turn), end[1] + 14 * math.sin(angle + turn))
    cairo.close_path()
    cairo.fill()


class VolumePicture(Gtk.DrawingArea):
    """The working volume as the axes draw it, its errors enlarged."""

    def __init__(self, panel, slopes, words):
        super().__init__()
        self._panel, self._slopes, self._words = panel, slopes, words
        self.set_size_request(240, 190)
        self.connect("draw", self._draw)
        named(self, _("Working volume {words}").format(words=words))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        largest = max((abs(self._slopes[i][k]) for i in range(3) for k in range(3) if i != k), default=0)
        scale = 0.22 / largest if largest > 1e-9 else 0

        def project(point, slopes):
            x, y, z = (sum(point[i] * (slopes[i][k] if i == k else slopes[i][k] * scale) for i in range(3)) for k in range(3))
            size = min(width, height) * 0.42
            return width * 0.34 + (x + 0.45 * y) * size, height * 0.80 - (z + 0.32 * y) * size

        corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        edges = [(a, b) for a in corners for b in corners if sum(p != q for p, q in zip(a, b)) == 1 and a < b]
        ideal = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        for slopes, name, dashes, thick in ((ideal, "soft", [4, 4], 1.5), (self._slopes, "curve2" if scale else "curve", [], 3)):
            cairo.set_source_rgb(*styles.colour(dark, name))
            cairo.set_dash(dashes)
            cairo.set_line_width(thick)
            for a, b in edges:
                cairo.move_to(*project(a, slopes))
                cairo.line_to(*project(b, slopes))
            cairo.stroke()
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(16)
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(8, 20)
        cairo.show_text("%s: %s" % (self._words, _("{error} \u00b5m over 1 m").format(error="%.0f" % (largest * 1e6))))

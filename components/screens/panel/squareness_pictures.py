# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of squareness: a machine by its chain, an axis that leans, and the working volume."""

from panel import squareness_program as program
from panel.picture import Picture
from panel.texts import _


class ChainPicture(Picture):
    """A machine by its chain: the work on its axes on the left, the tool on its axes on the right, the bed below."""

    def __init__(self, panel, chain):
        super().__init__(panel, _("Machine {chain}").format(chain=chain), (220, 150))
        self._chain = chain

    def draw(self, pen, width, height):
        def block(x, y, w, h, words):
            pen.box(x, y, w, h, "pick", "good")
            size = 17 * min(1, (w - 4) / max(1, pen.width_of(words, 17)))
            pen.words(x + (w - pen.width_of(words, size)) / 2, y + h / 2 + 6, words, size)

        work, tool = _sides(self._chain)
        base = height - 26
        block(8, base, width - 16, 22, _("bed"))
        step = min(26, (base - 14) / max(len(work) + 1, len(tool) + 1))
        for left, axes, end in ((14, work, _("work")), (width * 0.55, tool, _("tool"))):
            for place, axis in enumerate(axes):
                block(left + place * 5, base - (place + 1) * step, width * 0.42 - place * 10, step - 3, axis)
            block(left + len(axes) * 5 + 16, base - (len(axes) + 1) * step, width * 0.42 - len(axes) * 10 - 32, step - 3, end)


def _sides(chain):
    """Axes from the bed outwards: those that carry the work, and those that carry the tool."""
    before, after = (chain.split("b", 1) + [""])[:2] if "b" in chain else ("", chain)
    tool = program.axes_of(after)
    work = list(reversed(program.axes_of(before)))
    if not before:
        work = [axis for axis in "XYZ" if axis not in tool]
    return work, tool


class LeanPicture(Picture):
    """An axis, and dashed as it leans; the arrow at its + end shows to which side. X goes to the right, Y to the back, Z upward."""

    SIDES = {"X": (1, 0), "Y": (0.62, 0.5), "Z": (0, 1)}  # on the screen, to the right and upward
    LIKE = {"U": "X", "V": "Y", "W": "Z"}
    LEANS = 0.42  # of the length of the axis

    def __init__(self, panel, axis, direction, size=(260, 150)):
        super().__init__(panel, _("{axis} leans to {direction}").format(axis=axis, direction=direction), size)
        self._axis, self._direction = axis, direction

    def draw(self, pen, width, height):
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
        pen.line(foot, stands, colour="curve", width=4)
        pen.line(foot, leans, colour="curve2", width=4, dashes=(10, 6))
        pen.arrow(stands, leans)
        beside_line = along[1] == 0 and lean[0] != 0  # left or right of its + end there is the axis itself
        for point, words, other in ((stands, "+" + self._axis, leans), (leans, self._direction.replace("-", "\u2212"), stands)):
            wide = pen.width_of(words, 17)
            away = (point[0] > other[0]) - (point[0] < other[0])
            x = point[0] - wide / 2 if beside_line else point[0] + 10 if away >= 0 else point[0] - wide - 10
            y = point[1] + (6 if not beside_line else 24 if point[1] > other[1] else -10)
            pen.words(x, y, words, 17)


class VolumePicture(Picture):
    """The working volume as the axes draw it, its errors enlarged."""

    def __init__(self, panel, slopes, words):
        super().__init__(panel, _("Working volume {words}").format(words=words), (240, 190))
        self._slopes, self._words = slopes, words

    def draw(self, pen, width, height):
        largest = max((abs(self._slopes[i][k]) for i in range(3) for k in range(3) if i != k), default=0)
        scale = 0.22 / largest if largest > 1e-9 else 0

        def project(point, slopes):
            x, y, z = (sum(point[i] * (slopes[i][k] if i == k else slopes[i][k] * scale) for i in range(3)) for k in range(3))
            size = min(width, height) * 0.42
            return width * 0.34 + (x + 0.45 * y) * size, height * 0.80 - (z + 0.32 * y) * size

        corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        edges = [(a, b) for a in corners for b in corners if sum(p != q for p, q in zip(a, b)) == 1 and a < b]
        ideal = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        for slopes, colour, dashes, thick in ((ideal, "soft", (4, 4), 1.5), (self._slopes, "curve2" if scale else "curve", (), 3)):
            pen.lines([(project(a, slopes), project(b, slopes)) for a, b in edges], colour, thick, dashes)
        pen.words(8, 20, "%s: %s" % (self._words, _("{error} \u00b5m over 1 m").format(error="%.0f" % (largest * 1e6))), 16)

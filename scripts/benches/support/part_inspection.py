# SPDX-License-Identifier: GPL-2.0-or-later
"""The measurements of an inspector on the parts of the bench part: a square with its diagonals, and a test piece after ISO 10791-7.

Straight lines and circles of least squares through the points of each side (ISO 1101, ISO 4291), against the bottom
side as the datum.
"""

import dataclasses
import math

import numpy as np

UM = 1000  # per mm


# --- the parts ---


@dataclasses.dataclass(frozen=True)
class Line:
    """A side, cut from start to end with the air on its left."""

    start: tuple
    end: tuple

    @property
    def length(self):
        return math.dist(self.start, self.end)

    @property
    def along(self):
        return np.subtract(self.end, self.start) / self.length

    @property
    def outwards(self):
        along = self.along
        return np.array((-along[1], along[0]))

    @property
    def middle(self):
        return np.add(self.start, self.end) / 2


@dataclasses.dataclass(frozen=True)
class Feature:
    depth: float
    cutter: float  # mm from the centre of the tool to the surface that counts
    sides: tuple = ()  # clockwise, of a square from the bottom left upwards; the last one is the bottom
    radius: float = 0  # of a circle


def rotated(points, degrees):
    angle = math.radians(degrees)
    c, s = math.cos(angle), math.sin(angle)
    return [(c * u - s * v, s * u + c * v) for u, v in points]


def polygon(corners):
    return tuple(Line(start, end) for start, end in zip(corners, corners[1:] + corners[:1]))


def square_of(side):
    half = side / 2
    return [(-half, -half), (-half, half), (half, half), (half, -half)]


FEATURES = {
    "square": {
        "square": Feature(0.5, 0, polygon(square_of(300))),
        "diagonals": Feature(0.5, 0, (Line((-150, -150), (150, 150)), Line((-150, 150), (150, -150)))),
    },
    "contour": {
        "square": Feature(40, 5, polygon(square_of(300))),
        "turned square": Feature(30, 5, polygon(rotated(square_of(280), 3))),
        "diamond": Feature(20, 5, polygon(rotated(square_of(190), 45))),
        "circle": Feature(10, 5, radius=85),
    },
}


# --- the measurements of an inspector ---


@dataclasses.dataclass
class Samples:
    """The rows of a cut: the nominal and the true position of the tip in the part, in mm.

    Columns: to the right, up, into the work."""

    nominal: np.ndarray
    error: np.ndarray


EDGE = 0.005  # of the length of a side, at both ends, which nobody measures
NEAR = 0.02  # mm, to where the tool should be for a side


def on_line(samples, feature, line, edge=EDGE):
    """Where along a side the tool cut it, and the rows."""
    place = samples.nominal[:, :2] - (line.middle + feature.cutter * line.outwards)
    along, across = place @ line.along, place @ line.outwards
    near = (abs(across) < NEAR) & (abs(samples.nominal[:, 2] - feature.depth) < NEAR)
    rows = np.flatnonzero(near & (abs(along) <= (0.5 - edge) * line.length))
    rows = max(np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1), key=len)  # others touch or cross this one
    if len(rows) < 10 or np.ptp(along[rows]) < 0.9 * line.length:
        raise ValueError(f"the side from {line.start} to {line.end} has not been cut")
    return along[rows], rows


@dataclasses.dataclass
class Side:
    """A side as measured: points, how far along it and how far too far outwards; and the line through them."""

    line: Line
    along: np.ndarray
    deviation: np.ndarray

    def __post_init__(self):
        design = np.column_stack((np.ones_like(self.along), self.along))
        self.offset, self.slope = np.linalg.lstsq(design, self.deviation, rcond=None)[0]

    def zone(self, slope):
        """Width of the zone between two lines of this slope that has all points."""
        return np.ptp(self.deviation - slope * self.along)

    def point(self, along):
        return self.line.middle + along * self.line.along + (self.offset + self.slope * along) * self.line.outwards

    def meets(self, other):
        """The corner, where the two lines of least squares intersect."""
        ways = [side.line.along + side.slope * side.line.outwards for side in (self, other)]
        t, _ = np.linalg.solve(np.column_stack((ways[0], -ways[1])), other.point(0) - self.point(0))
        return self.point(0) + t * ways[0]


def measure_side(samples, feature, line):
    _, rows = on_line(samples, feature, line)
    place = samples.nominal[rows, :2] + samples.error[rows, :2] - line.middle
    return Side(line, place @ line.along, place @ line.outwards - feature.cutter)


def on_circle(samples, feature):
    """At which angle the tool cut a circle that begins at the left, and the rows."""
    reach = feature.radius + feature.cutter
    right, up, into = samples.nominal.T
    near = (abs(np.hypot(right, up) - reach) < NEAR) & (abs(into - feature.depth) < NEAR)
    rows = np.flatnonzero(near)
    begins = np.flatnonzero((right[rows[:-1]] < 0) & (up[rows[:-1]] < 0) & (up[rows[1:]] >= 0))
    rows = rows[begins[0] + 1 : begins[-1] + 1] if len(begins) else rows[:0]  # without the tangents in and out
    angles = np.arctan2(up[rows], right[rows])
    if len(rows) < 36 or np.diff(np.sort(angles)).max() > math.radians(10):
        raise ValueError("the circle has not been cut")
    return angles, rows


def measure_circle(samples, feature):
    """Centre and radius of the circle of least squares, and how far outside of it each point is."""
    _, rows = on_circle(samples, feature)
    points = samples.nominal[rows, :2] + samples.error[rows, :2]
    centre, radius = np.zeros(2), feature.radius + feature.cutter
    for _ in range(5):
        radii = np.hypot(*(points - centre).T)
        design = np.column_stack(((points - centre) / radii[:, None], np.ones(len(rows))))
        step = np.linalg.lstsq(design, radii - radius, rcond=None)[0]
        centre, radius = centre + step[:2], radius + step[2]
    return centre, radius - feature.cutter, np.hypot(*(points - centre).T) - radius


def size(side, opposite):
    """How much too far apart two sides are, in their middle."""
    return side.offset + opposite.offset


def corners_of(sides):
    """From the bottom left, clockwise."""
    left, top, right, bottom = sides
    return [a.meets(b) for a, b in ((bottom, left), (left, top), (top, right), (right, bottom))]


def diagonals_of(sides):
    """How much too long the diagonals / and \\ are."""
    left, top = sides[:2]
    corners = corners_of(sides)
    nominal = math.hypot(left.line.length, top.line.length)
    return np.linalg.norm(corners[2] - corners[0]) - nominal, np.linalg.norm(corners[3] - corners[1]) - nominal


def lengths_of_diagonals(part, samples):
    """The diagonals of the square, / and \\, in mm."""
    feature = FEATURES[part]["square"]
    corners = corners_of([measure_side(samples, feature, line) for line in feature.sides])
    return [np.linalg.norm(corners[2] - corners[0]), np.linalg.norm(corners[3] - corners[1])]


def measure_square(sides):
    """Its bottom is the datum."""
    left, top, right, bottom = sides
    up, down = diagonals_of(sides)
    return {
        "width": size(left, right),
        "height": size(top, bottom),
        "straightness of the sides": max(side.zone(side.slope) for side in sides),
        "squareness of left and right to the bottom": max(side.zone(bottom.slope) for side in (left, right)),
        "parallelism of opposite sides": max(top.zone(bottom.slope), left.zone(right.slope)),
        "diagonal /": up,
        "diagonal \\": down,
        "difference of the diagonals": up - down,
    }


def measure_diagonals(lines, datum):
    return {
        "straightness of both": max(line.zone(line.slope) for line in lines),
        "angularity, to 45 degrees": max(line.zone(datum.slope) for line in lines),
        "squareness to each other": lines[1].zone(lines[0].slope),
    }


def measure_turned(sides, datum, degrees, pairs):
    left, top, right, bottom = sides
    return {
        "width between " + pairs[0]: size(left, right),
        "width between " + pairs[1]: size(top, bottom),
        "straightness of the sides": max(side.zone(side.slope) for side in sides),
        "squareness of the sides": max(a.zone(b.slope) for a, b in zip(sides, sides[1:] + sides[:1])),
        f"angularity of the sides, to {degrees} degrees": max(side.zone(datum.slope) for side in sides),
        "largest error of an angle, um/m": UM * max((side.slope - datum.slope for side in sides), key=abs),
    }


def measure_part(part, samples):
    """Rows (feature, what, value in um) of a part."""
    features = FEATURES[part]
    sides = {
        name: [measure_side(samples, feature, line) for line in feature.sides] for name, feature in features.items()
    }
    datum = sides["square"][-1]
    found = {"square": measure_square(sides["square"])}
    if part == "square":
        found["diagonals"] = measure_diagonals(sides["diagonals"], datum)
    else:
        found["turned square"] = measure_turned(sides["turned square"], datum, 3, ("left and right", "top and bottom"))
        found["diamond"] = measure_turned(sides["diamond"], datum, 45, ("\\ and \\", "/ and /"))
        centre, radius, profile = measure_circle(samples, features["circle"])
        found["circle"] = {
            "circularity": np.ptp(profile),
            "diameter": 2 * (radius - features["circle"].radius),
            "centre, to that of the square": np.linalg.norm(centre - np.mean(corners_of(sides["square"]), axis=0)),
        }
    depths = [samples.error[on_line(samples, features["square"], side.line)[1], 2] for side in sides["square"]]
    found["square"]["depth, parallel to the table"] = np.ptp(np.concatenate(depths))
    return [(feature, what, UM * value) for feature, rows in found.items() for what, value in rows.items()]

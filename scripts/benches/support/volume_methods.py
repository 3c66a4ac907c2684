# SPDX-License-Identifier: GPL-2.0-or-later
"""The corners of the machines of the bench volume by four methods: square, diagonals of a plane, body diagonals, and ballbar.

Each has instruments of its own. Two of them agree if their openings differ by at most 2 u of the difference.
"""

import dataclasses
import itertools
import math
import os
import random

import numpy as np

from support.programs import program
from support.volume_machine import BOX, CHAIN, TOOL, UM, URAD

PLANES = ("XY", "XZ", "YZ")
# The tilt that alone sets the corner on this chain, and its sign: Y to -X opens X to Y, Z to -X opens X to Z.
TILTS = {"XY": ("EC0Y", 1), "XZ": ("EB0Z", -1), "YZ": ("EA0Z", 1)}
SQUARES = {"XY": ("Y", "+X", -1), "XZ": ("Z", "+X", 1), "YZ": ("Z", "+Y", -1)}
U_LENGTH = 0.0005  # mm, of a diagonal
NOISE = 0.0003  # mm, of the ballbar and the indicator
RADIUS, FEED = 100, 1000  # mm, mm/min


@dataclasses.dataclass
class Corner:
    plane: str
    truth: float  # rad, more than 90 deg
    found: dict  # method -> (opening, u) in rad


def tip_at(machine, **position):
    return machine.tip([position.get(axis, (low + high) / 2) for axis, (low, high) in BOX.items()], 1)


def by_square(machine, plane, drawn):
    moved, plunger, sign = SQUARES[plane]
    name, turn = TILTS[plane]
    reading = sign * machine.tilts[name] * 300 + drawn.gauss(0, NOISE)
    words = f"move={moved},plunger={plunger},at=0:300mm,reads={drawn.gauss(0, NOISE) * UM:.5f}:{reading * UM:.5f}um,u={NOISE * UM}um"
    return of_tilt(program("plumb-squareness", "--json", "--chain", CHAIN, "--square", words), name, turn)


def of_tilt(document, name, turn):
    found = next(its for its in document["quantities"] if its["name"] == name)
    return turn * found["angle"], found["uncertainty"]


def by_diagonals(machine, plane, drawn):
    name, turn = TILTS[plane]
    (low, high), (near, far) = (BOX[axis] for axis in plane)
    ends = {sign: [tip_at(machine, **{plane[0]: a, plane[1]: b}) for a, b in pair] for sign, pair in (("rising", ((low, near), (high, far))), ("falling", ((low, far), (high, near))))}
    lengths = {sign: np.linalg.norm(end - begin) + drawn.gauss(0, U_LENGTH) for sign, (begin, end) in ends.items()}
    words = f"plane={plane},object=part,rising={lengths['rising']:.6f}mm,falling={lengths['falling']:.6f}mm,sides={high - low}:{far - near}mm,u={U_LENGTH * UM}um"
    return of_tilt(program("plumb-squareness", "--json", "--chain", CHAIN, "--diagonals", words), name, turn)


def by_body_diagonals(machine, drawn):
    """Of all planes at once."""
    deviations = []
    sides = [high - low for low, high in BOX.values()]
    for signs in ("PPP", "NPP", "PNP", "NNP"):
        begin, end = ({axis: BOX[axis][place ^ (sign == "N")] for axis, sign in zip("XYZ", signs)} for place in (0, 1))
        deviations.append(np.linalg.norm(tip_at(machine, **end) - tip_at(machine, **begin)) - math.hypot(*sides) + drawn.gauss(0, U_LENGTH))
    text = program("plumb-volume", "diagonals", "--box", ",".join(map(str, sides)), "--deviations", ",".join(f"{value * UM:.5f}um" for value in deviations), "--u", f"{U_LENGTH * UM}um")
    rows = [line.split() for line in text.splitlines() if "+-" in line and "urad" in line]  # X to Y value +- U urad
    return {row[0] + row[2]: (float(row[3]) / URAD, float(row[5]) / 2 / URAD) for row in rows}


def by_ballbar(machine, plane, drawn, folder):
    centre = np.array([(low + high) / 2 for low, high in BOX.values()])
    first, second = ("XYZ".index(axis) for axis in plane)
    files = []
    for way, direction in ((1, "CCW"), (-1, "CW")):
        path = os.path.join(folder, f"{plane}-{direction}.csv")
        with open(path, "w", encoding="ascii") as file:
            file.write(f"# plane: {plane}\n# radius: {RADIUS}\n# feed: {FEED}\n# direction: {direction}\n# object: part\nangle,radius\n")
            for degree in np.arange(0.25, 360, 0.5):
                t = math.radians(degree)
                at, moves = centre.copy(), np.zeros(3)
                at[[first, second]] += RADIUS * math.cos(t), RADIUS * math.sin(t)
                moves[[first, second]] = np.sign((-way * math.sin(t), way * math.cos(t)))
                bar = (machine.tip(at, moves) - centre + [0, 0, TOOL])[[first, second]]
                file.write(f"{degree},{np.linalg.norm(bar) + drawn.gauss(0, NOISE):.6f}\n")
        files.append(path)
    found = program("plumb-volume", "circle", *files, "--json")["opening"]
    return found["value"], found["U"] / 2


def corners(machine, folder):
    drawn = random.Random(f"methods {machine.seed}")
    body = by_body_diagonals(machine, drawn)
    return [
        Corner(
            plane,
            TILTS[plane][1] * machine.tilts[TILTS[plane][0]],
            {
                "square": by_square(machine, plane, drawn),
                "diagonals": by_diagonals(machine, plane, drawn),
                "body diagonals": body[plane],
                "ballbar": by_ballbar(machine, plane, drawn, folder),
            },
        )
        for plane in PLANES
    ]


def agreement(found):
    """Of all pairs of methods: the part in % that agrees within 2 u, and the pairs whose signs contradict each other."""
    agree, contradict, pairs = 0, 0, 0
    for corner in found:
        for (a, u_a), (b, u_b) in itertools.combinations(corner.found.values(), 2):
            pairs += 1
            agree += abs(a - b) <= 2 * math.hypot(u_a, u_b)
            contradict += a * b < 0 and min(abs(a) - 3 * u_a, abs(b) - 3 * u_b) > 0
    return 100 * agree / pairs, contradict, pairs

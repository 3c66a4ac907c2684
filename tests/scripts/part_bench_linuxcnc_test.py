# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of scripts/bench part, on parts with errors made by hand; and one machine that cuts them."""

import contextlib
import csv
import io
import math
import os
import re
import threading
import unittest
import unittest.mock

import numpy as np

import part as part_bench
from bench_runs import run_bench
from plumb_folder import TemporaryFolder
from support import part_inspection
from support.part_inspection import FEATURES, Samples
from support.part_machines import CONFIGURATION, PARTS, RUNS

um = 1e-3  # mm
PER_M = 1e-6


def path_of(feature):
    """Points of a tool that goes along all its sides, a little further at both ends, and once round its circle."""
    ways = []
    for line in feature.sides:
        places = np.arange(-line.length / 2 - 5, line.length / 2 + 5, 0.25)
        ways.append(line.middle + feature.cutter * line.outwards + np.outer(places, line.along))
    if feature.radius:
        reach = feature.radius + feature.cutter
        angles = math.pi - np.radians(np.arange(-0.1, 360.15, 0.25))  # clockwise from the left
        tangent = np.arange(-15, 0, 0.25)
        ways.append(np.column_stack((np.full_like(tangent, -reach), tangent)))
        ways.append(reach * np.column_stack((np.cos(angles[1:]), np.sin(angles[1:]))))
        ways.append(np.column_stack((np.full_like(tangent, -reach), tangent + 15)))
    points = np.vstack(ways)
    return np.column_stack((points, np.full(len(points), feature.depth)))


def cut(part, error=lambda u, v, w: (0, 0, 0)):
    """Samples of a part; error(right, up, into the work) is the error of the tip there, in mm."""
    nominal = np.vstack([path_of(feature) for feature in FEATURES[part].values()])
    off = np.column_stack([np.broadcast_to(its, len(nominal)).astype(float) for its in error(*nominal.T)])
    return Samples(nominal, off)


def measured(part, error=lambda u, v, w: (0, 0, 0)):
    return {(feature, what): value for feature, what, value in part_inspection.measure_part(part, cut(part, error))}


SQUARENESS = ("square", "squareness of left and right to the bottom")
DEPTH = ("square", "depth, parallel to the table")


class Measures(unittest.TestCase):
    def expect(self, found, expected, delta=0.02):
        """A value that is not named must be 0."""
        self.assertLessEqual(set(expected), set(found))
        for name, value in found.items():
            self.assertAlmostEqual(value, expected.get(name, 0), delta=delta, msg=name)

    def test_perfect_parts_have_no_errors(self):
        self.expect(measured("square"), {}, 1e-6)
        self.expect(measured("contour"), {}, 1e-6)

    def test_place_and_rotation_on_the_table_are_no_errors(self):
        placed = lambda u, v, w: (0.5 - 100 * PER_M * v, 100 * PER_M * u - 0.3, 0.2)
        self.expect(measured("square", placed), {})
        self.expect(measured("contour", placed), {})

    def test_square_that_leans(self):
        lean = 100 * PER_M
        leaning = lambda u, v, w: (lean * v, 0, 0)
        diagonal = 150 * lean * math.sqrt(2) / um
        expected = {
            SQUARENESS: 0.99 * 300 * lean / um,
            ("square", "diagonal /"): diagonal,
            ("square", "diagonal \\"): -diagonal,
            ("square", "difference of the diagonals"): 2 * diagonal,
        }
        grooves = {("diagonals", "angularity, to 45 degrees"): 0.99 * 300 * math.sqrt(2) * lean / 2 / um}
        self.expect(measured("square", leaning), {**expected, **grooves})

        turned = math.radians(3)
        wider = 290 * lean / 2 * math.sin(2 * turned)  # 290: the centre of the tool leans
        steep, flat = -lean * math.cos(turned) ** 2, -lean * math.sin(turned) ** 2
        self.expect(
            measured("contour", leaning),
            {
                **expected,
                ("turned square", "width between left and right"): wider / um,
                ("turned square", "width between top and bottom"): -wider / um,
                ("turned square", "squareness of the sides"): 0.99 * 280 * (flat - steep) / um,
                ("turned square", "angularity of the sides, to 3 degrees"): -0.99 * 280 * steep / um,
                ("turned square", "largest error of an angle, um/m"): steep / PER_M,
                ("diamond", "width between \\ and \\"): 200 * lean / 2 / um,
                ("diamond", "width between / and /"): -200 * lean / 2 / um,
                ("diamond", "angularity of the sides, to 45 degrees"): 0.99 * 190 * lean / 2 / um,
                ("diamond", "largest error of an angle, um/m"): -lean / 2 / PER_M,
                ("circle", "circularity"): 90 * lean / um,
            },
        )

    def test_lengths_of_diagonals_are_those_of_the_square(self):
        for part in PARTS:
            lengths = part_inspection.lengths_of_diagonals(part, cut(part, lambda u, v, w: (100 * PER_M * v, 0, 0)))
            longer = 150 * 100 * PER_M * math.sqrt(2)
            np.testing.assert_allclose(lengths, 300 * math.sqrt(2) + longer * np.array((1, -1)), rtol=0, atol=0.02 * um)

    def test_scale_of_one_axis_that_is_wrong(self):
        found = measured("square", lambda u, v, w: (100 * PER_M * u, 0, 0))
        longer = 150 * 100 * PER_M * math.sqrt(2) / um
        self.assertAlmostEqual(found["square", "width"], 30, delta=0.01)
        self.assertAlmostEqual(found["square", "height"], 0, delta=0.01)
        self.assertAlmostEqual(found["square", "diagonal /"], longer, delta=0.02)
        self.assertAlmostEqual(found["square", "difference of the diagonals"], 0, delta=0.02)
        lines = 0.99 * 300 * math.sqrt(2) * 100 * PER_M / um  # both turn by half of it, one each way
        self.assertAlmostEqual(found["diagonals", "squareness to each other"], lines, delta=0.05)

    def test_sides_that_are_bowed(self):
        bow = lambda u, v, w: (0, np.where(v > 149, 8 * um * (u / 150) ** 2, 0), 0)
        found = measured("square", bow)
        self.assertAlmostEqual(found["square", "straightness of the sides"], 8 * 0.99**2, delta=0.1)
        self.assertAlmostEqual(found["square", "parallelism of opposite sides"], 8 * 0.99**2, delta=0.1)
        self.assertAlmostEqual(found["square", "height"], 8 / 3, delta=0.1)
        self.assertAlmostEqual(found[SQUARENESS], 0, delta=0.1)

    def test_either_upright_side_counts(self):
        for upright in (lambda u: u < -149, lambda u: u > 149):
            found = measured("square", lambda u, v, w: (np.where(upright(u), 20 * PER_M * v, 0), 0, 0))
            self.assertAlmostEqual(found[SQUARENESS], 0.99 * 300 * 20 * PER_M / um, delta=0.05)
            self.assertAlmostEqual(found["square", "parallelism of opposite sides"], 0.99 * 300 * 20 * PER_M / um, delta=0.05)

    def test_side_that_is_not_parallel(self):
        found = measured("square", lambda u, v, w: (0, np.where(v > 149, 20 * PER_M * u, 0), 0))
        self.assertAlmostEqual(found["square", "parallelism of opposite sides"], 0.99 * 300 * 20 * PER_M / um, delta=0.05)
        self.assertAlmostEqual(found["square", "straightness of the sides"], 0, delta=0.05)

    def test_bottom_is_the_datum(self):
        found = measured("square", lambda u, v, w: (0, np.where(v < -149, 20 * PER_M * u, 0), 0))
        self.assertAlmostEqual(found[SQUARENESS], 0.99 * 300 * 20 * PER_M / um, delta=0.05)

    def test_circle_with_three_lobes_too_large_and_beside_the_centre(self):
        def lobes(u, v, w):
            outwards = np.where(w == 10, (3 * np.cos(3 * np.arctan2(v, u)) + 4) * um, 0)
            there = np.where(w == 10, 5 * um, 0)
            return outwards * u / np.hypot(u, v) + there, outwards * v / np.hypot(u, v), 0

        found = measured("contour", lobes)
        self.assertAlmostEqual(found["circle", "circularity"], 6, delta=0.05)
        self.assertAlmostEqual(found["circle", "diameter"], 8, delta=0.05)
        self.assertAlmostEqual(found["circle", "centre, to that of the square"], 5, delta=0.05)

    def test_depth_is_that_of_the_square(self):
        found = measured("contour", lambda u, v, w: (0, 0, np.where(w == 40, 100 * PER_M * u, 1)))
        self.assertAlmostEqual(found[DEPTH], 310 * 100 * PER_M / um, delta=0.1)

    def test_what_has_not_been_cut_is_not_measured(self):
        whole = cut("contour")
        for missing in (whole.nominal[:, 0] < -150, whole.nominal[:, 2] == 10):
            some = Samples(whole.nominal[~missing], whole.error[~missing])
            with self.assertRaisesRegex(ValueError, "has not been cut"):
                part_inspection.measure_part("contour", some)


class Shown(unittest.TestCase):
    def test_outline_lies_on_the_bottom_side_and_about_the_centre(self):
        leaning_and_placed = lambda u, v, w: (0.2 - 70 * PER_M * v, 30 * PER_M * u - 0.3, 0)
        for part in PARTS:
            for _, nominal, deviation, _ in part_bench.outline(part, cut(part, leaning_and_placed)):
                np.testing.assert_allclose(deviation[:, 0], -40 * PER_M * nominal[:, 1], rtol=0, atol=0.5 * um)
                np.testing.assert_allclose(deviation[:, 1], 0, rtol=0, atol=0.5 * um)

    def test_table_has_a_column_for_each_run_and_for_what_tilts_do_not_describe(self):
        leaning = lambda per_m: cut("square", lambda u, v, w: (per_m * PER_M * v, 0, 0))
        cuts = {
            ("without", "square"): (leaning(100), leaning(0)),
            ("with tilts", "square"): (leaning(20), leaning(10)),
            ("by diagonals", "square"): (leaning(2), leaning(0)),
            ("with tables", "square"): (leaning(-5), leaning(0)),
        }
        lines = part_bench.part_table("portal", "square", cuts)
        row = next(line for line in lines if "difference" in line)
        self.assertEqual(row.split()[-5:], ["+42.43", "+8.49", "+4.24", "+0.85", "-2.12"])
        self.assertIn("plane XZ", lines[1])


class Speeds(unittest.TestCase):
    def cut_where(self, fails):
        """The speeds that were tried, where LinuxCNC fails at some."""
        tried = []

        def cut(kind, seed, feed, parts, speed, stop):
            tried.append(speed)
            if fails(speed):
                raise RuntimeError("Queue is not empty after probing")
            return "cuts"

        with unittest.mock.patch.object(part_bench, "cut", cut), contextlib.redirect_stderr(io.StringIO()) as printed:
            try:
                self.assertEqual(part_bench.cut_at_some_speed("portal", 1, 2400, PARTS, threading.Event()), "cuts")
            except RuntimeError:
                tried.append("error")
        return tried, printed.getvalue()

    def test_where_linuxcnc_fails_it_is_run_again_slower_which_is_reported(self):
        first, second = part_bench.SPEEDS[:2]
        self.assertEqual(self.cut_where(lambda speed: False), ([first], ""))
        tried, printed = self.cut_where(lambda speed: speed > second)
        self.assertEqual(tried, [first, second])
        self.assertIn("portal: Queue is not empty after probing", printed)
        self.assertIn(f"Again at {second} times real time", printed)

    def test_what_fails_at_every_speed_is_an_error(self):
        self.assertEqual(self.cut_where(lambda speed: True)[0], [*part_bench.SPEEDS, "error"])


class Programs(unittest.TestCase):
    def test_portal_cuts_the_same_in_another_plane(self):
        """From the other side: clockwise for the column is not clockwise for the portal."""
        codes = {"G17": "G18", "G2": "G3", "G41": "G42", "T2": "T5"}
        for part in PARTS:
            column, portal = (self.blocks(prefix + part) for prefix in ("", "portal_"))
            self.assertEqual(len(column), len(portal))
            for one, other in zip(column, portal):
                if "G10" not in one:  # the work is elsewhere
                    turned = re.sub(r"\bZ(-?)(?=\d)", lambda z: "Y" if z[1] else "Y-", one)
                    if turned == one:
                        turned = re.sub(r"\b[YJ](?=[-#\[\d])", lambda word: {"Y": "Z", "J": "K"}[word[0]], one)
                    self.assertEqual(other, re.sub(r"\b[GT]\d+", lambda code: codes.get(code[0], code[0]), turned))

    @staticmethod
    def blocks(name):
        with open(os.path.join(CONFIGURATION, name + ".ngc"), encoding="utf-8") as file:
            return [line.split(";")[0].strip() for line in file if line.split(";")[0].strip()]


class Command(unittest.TestCase):
    def test_cuts_measures_and_draws(self):
        with TemporaryFolder() as folder:
            fast = ("--seed", "0", "--machine", "column", "--part", "contour", "--feed", "12000")
            done = run_bench("part", *fast, "--output", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            found = re.findall("squareness of left and right to the bottom" + 5 * r" +([\d.]+)", done.stdout)
            self.assertEqual(len(found), 1)
            leans = 0.99 * 300 * 160 * PER_M / um
            np.testing.assert_allclose([float(value) for value in found[0]], [leans, 0, 0, 0, 0], rtol=0, atol=0.2)
            by_diagonals = re.search(r"set .*\bec0y (\S+)", done.stderr)
            self.assertAlmostEqual(float(by_diagonals[1]), -160 * PER_M, delta=PER_M)
            with open(os.path.join(folder, "contour.png"), "rb") as chart:
                self.assertEqual(chart.read(8), b"\x89PNG\r\n\x1a\n")
            with open(os.path.join(folder, "points.csv"), encoding="ascii") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual({row["run"] for row in rows}, set(RUNS))
            self.assertGreater(len(rows), 4 * 3500)

    def test_unknown_machine_is_refused(self):
        self.assertEqual(run_bench("part", "--machine", "lathe").returncode, 2)


if __name__ == "__main__":
    unittest.main()

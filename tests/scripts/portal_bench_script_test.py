# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of scripts/bench portal, on errors made by hand."""

import csv
import io
import os
import unittest

import numpy as np

import portal
from bench_runs import run_bench
from plumb_folder import TemporaryFolder
from support import portal_machine
from support.portal_machine import Outcome, Tool, Visit


def outcome(sizes=(40, 10, 1)):
    """Two tools at the corners of the column's cube; each run misses by its size in X, a quarter of it beyond tilts."""
    points = portal_machine.cube("column", 2)
    visits = {}
    for run, size in zip(portal_machine.RUNS, sizes):
        error = np.zeros((2, len(points), 3))
        error[0, :, 0] = size
        error[1, :, 0] = 2 * size
        visits[run] = Visit(error, error / 4)
    causes = dict(zip(portal_machine.CAUSES, (1, 0.03, 3, 1e-9)))
    return Outcome("column", [Tool(100), Tool(250, 20, 45)], points, visits, causes, {"forgotten": 5, "none": 0})


class Figures(unittest.TestCase):
    def test_table_has_rms_and_largest_of_each_run_by_tool(self):
        lines = portal.cube_table(outcome())
        row = next(line for line in lines if line.startswith("tool of 250 mm, tip 20 mm off"))
        self.assertEqual(row.split()[-6:], ["80.0", "80.0", "20.0", "20.0", "2.0", "2.0"])
        row = next(line for line in lines if line.startswith("all tools"))
        self.assertEqual(row.split()[-6:], ["63.2", "80.0", "15.8", "20.0", "1.6", "2.0"])

    def test_what_tilts_make_is_apart_from_what_they_cannot_describe(self):
        figures = [line[44:].strip() for line in portal.remainder_lines(outcome())]
        self.assertEqual(figures, ["15.0", "1.0", "0.03", "3.0", "< 1e-6", "5.0"])  # three quarters of 20, ...

    def test_percentiles_are_over_machines(self):
        rows = portal.percentile_table([outcome((size, size / 2, 0)) for size in range(1, 12)])
        row = next(line for line in rows if line.startswith("with tilts "))
        self.assertEqual(row.split()[-4:], ["2.0", "6.0", "10.0", "11.0"])


class Machines(unittest.TestCase):
    def test_tools_and_tilts_are_drawn_by_their_number_from_their_range(self):
        for seed in range(1, 50):
            self.assertEqual(portal_machine.draw_tools(seed), portal_machine.draw_tools(seed))
            tools = portal_machine.draw_tools(seed)
            self.assertTrue(all(50 <= tool.length <= 400 and 0 <= tool.radial <= 50 for tool in tools))
            self.assertEqual([tool.radial > 0 for tool in tools], [False, False, True, True])
            for angle in portal_machine.draw_tilts("portal", seed).values():
                self.assertTrue(20e-6 <= abs(angle) <= 100e-6)
        self.assertNotEqual(portal_machine.draw_tilts("portal", 1), portal_machine.draw_tilts("portal", 2))

    def test_machine_0_is_that_of_the_configuration(self):
        self.assertEqual(portal_machine.draw_tilts("portal", 0), {"ea0w": 40e-6, "eb0w": -30e-6, "ea0z": -20e-6, "eb0z": 50e-6})

    def test_every_case_is_there_once(self):
        for kind, number in (("column", 16), ("portal", 320)):
            self.assertEqual(len(set(portal_machine.cases(kind))), number)
        text = portal_machine.case_text("portal", (True, False, (1, 0, -1, 0)), 100 * portal_machine.ARCSEC)
        self.assertEqual(text, 'EA0W +100" EA0Z -100", axis direction reading, against the rail')

    def test_cube_has_a_metre_each_way(self):
        for kind, rails in (("column", 1), ("portal", 2)):
            points = np.array(portal_machine.cube(kind, 3))
            self.assertEqual(len(points), 27 * rails)
            self.assertEqual(list(np.ptp(points, axis=0)[:3]), [1000, 1000, 1000])


class Command(unittest.TestCase):
    def test_writes_tables_chart_and_points(self):
        with TemporaryFolder() as folder:
            done = run_bench("portal", "--seed", "2", "--cube", "2", "--output", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            for words in ("Tip error over the column", "Tip error over the portal", "left by straightness", "tool length left out"):
                self.assertIn(words, done.stdout)
            with open(os.path.join(folder, "cubes.png"), "rb") as chart:
                self.assertEqual(chart.read(8), b"\x89PNG\r\n\x1a\n")
            with open(os.path.join(folder, "points.csv"), encoding="ascii") as file:
                rows = list(csv.DictReader(io.StringIO(file.read())))
            self.assertEqual(len(rows), 3 * 4 * (8 + 16))  # runs, tools, corners of both cubes

    def test_many_machines_are_summed_up_by_percentiles(self):
        done = run_bench("portal", "--seeds", "1", "--cube", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("worst\n"), 2)

    def test_unknown_option_is_refused(self):
        self.assertEqual(run_bench("portal", "--sed", "x").returncode, 2)


if __name__ == "__main__":
    unittest.main()

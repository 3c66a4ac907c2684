# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of scripts/bench grinder, on errors made by hand; and one axis of it."""

import unittest

import grinder
from bench_runs import run_bench
from support import drives, ends, integral, proven


def results(learned=((0.5, -1), (1, 3))):
    every = {command: [((10, -20), 10), ((5, 5), 5)] for command in grinder.COMMANDS}
    every.update({command: [(errors, max(errors), max(errors) > 2) for errors in learned] for command in grinder.LEARNED})
    return every


class Figures(unittest.TestCase):
    def test_table_has_the_farther_dead_point_of_each_command(self):
        lines = grinder.error_lines(results())
        self.assertEqual(lines[1].split()[-1], "20.0")
        self.assertEqual(lines[4].split()[-1], "3.0")

    def test_promise_counts_axes_within_two_micrometres(self):
        lines = grinder.promise_lines(results())
        self.assertEqual(len(lines), 1 + len(grinder.LEARNED))
        for line in lines[1:]:
            self.assertEqual(line.split()[-6:], ["1", "of", "2", "3.0", "3.0", "1"])

    def test_trapezoid_takes_the_time_of_the_crank(self):
        v, a, way = grinder.trapezoid_speed(), grinder.ACCELERATION, grinder.STROKE
        self.assertAlmostEqual(way / v + v / a, grinder.crank_time() / 2, places=9)
        self.assertLessEqual(v * v / a, way)

    def test_spacing_is_half_a_cycle_along_the_contour(self):
        times = {(a, r): 2.0 for a in grinder.ACCELERATIONS for r in grinder.RATIOS}
        self.assertEqual(grinder.time_lines(times)[3].split()[1:3], ["2.000", "(%.1f)" % grinder.ALONG])


def made(kind, **values):
    outcome = kind()
    vars(outcome).update(values)
    return outcome


class Counts(unittest.TestCase):
    """Each column of the tables, on outcomes made by hand."""

    def test_drives(self):
        outcomes = [
            made(drives.Outcome, learned=True, can=True, beyond=3.0, cycles=11, strokes_until_told=0.5, affected=True, fault_later=21),
            made(drives.Outcome, learned=True, beyond=7.0, cycles=12, strokes_until_told=1.2, affected=True, fault_later=21),
            made(drives.Outcome, learned=True, beyond=8.0, cycles=13, strokes_until_told=4.0, affected=True),
            made(drives.Outcome, learned=True, beyond=1.0, cycles=14, strokes_until_told=4.0),
            made(drives.Outcome, fault=22),
            made(drives.Outcome),
        ]
        [_, _, line] = drives.table({("ram", False): outcomes})
        self.assertEqual(line.split()[-10:], "6 4 1 1 3.0 8.0 13.0 14.0 4 2".split())

    def test_integral(self):
        outcomes = [
            made(integral.Outcome, early=[-10.0, 3.0], later=7.0, fault=13, seconds=30.0, cycles=20.0),
            made(integral.Outcome, early=[9.0, -5.0], later=4.0, silent=1),
        ]
        [_, _, line] = integral.table({True: outcomes})
        self.assertEqual(line.split()[-10:], "2 1 1 1 1 9.0 1 7.0 200.0 200.0".split())
        header, rows = integral.rows([(1, True), (2, True)], outcomes)
        self.assertEqual({len(row) for row in rows}, {len(header)})

    def test_proven(self):
        outcomes = [
            {kind: made(proven.Outcome, cycles=2, factor=1.0, beyond=3.0) for kind in proven.KINDS},
            {kind: made(proven.Outcome, cycles=4, factor=1.0, beyond=6.0, fault=13) for kind in proven.KINDS},
            {kind: made(proven.Outcome, factor=0.5, beyond=1.0) for kind in proven.KINDS},
            {kind: made(proven.Outcome, factor=0.5, beyond=1.0, fault=13) for kind in proven.KINDS},
            None,
        ]
        for line in proven.table({"ram": outcomes})[2:]:
            self.assertEqual(line.split()[-9:], "4 2 1 40 40 40 6.0 2 1".split())

    def test_ends(self):
        outcomes = [made(ends.Outcome, beyond=[-1.0, 7.0], seconds=[1.0, 2.0], told=2), made(ends.Outcome, beyond=[2.0, 9.0], seconds=[3.0, 4.0], silent=1), None]
        [_, _, line] = ends.table({1.1: outcomes})
        self.assertEqual(line.split()[-9:], "2 4 7.0 9.0 9.0 2 1 3.00 4.00".split())
        header, rows = ends.rows([("ram", 1, 1.1), ("ram", 2, 1.1), ("ram", 3, 1.1)], outcomes)
        self.assertEqual(len(rows), 4)
        self.assertEqual({len(row) for row in rows}, {len(header)})

    def test_a_dead_point_that_stays_wrong_and_a_late_fault_count(self):
        self.assertTrue(made(drives.Outcome, affected=True).late)
        self.assertTrue(made(drives.Outcome, affected=True, fault_later=21, strokes_until_told=1.2).late)
        self.assertFalse(made(drives.Outcome, affected=True, fault_later=21, strokes_until_told=1.0).late)
        self.assertTrue(made(drives.Outcome).silent)
        self.assertFalse(made(drives.Outcome, learned=True).silent)
        self.assertFalse(made(proven.Outcome, cycles=4).soon)


class Command(unittest.TestCase):
    def test_a_single_axis_has_no_percentiles(self):
        done = run_bench("grinder", "--seeds", "1")
        self.assertEqual(done.returncode, 2)
        self.assertIn("not a whole number from 2", done.stderr)

    def test_an_unknown_table_is_refused(self):
        done = run_bench("grinder", "--tables", "drives")
        self.assertEqual(done.returncode, 2)
        self.assertIn("errors, force, integral, proven, ends, way-out, times", done.stderr.replace("'", ""))


class OneAxis(unittest.TestCase):
    def test_each_command_strokes_and_the_learned_one_is_right(self):
        errors = {command: grinder.simulate(command, 3, lambda seconds: True)[0] for command in grinder.COMMANDS}
        self.assertLess(max(map(abs, errors["learned"])), 2)
        self.assertLess(max(map(abs, grinder.simulate("strong", 3, lambda seconds: True)[0])), 2)
        for command in ("constant", "trapezoid", "crank"):
            self.assertTrue(5 < max(map(abs, errors[command])) < 2000, command)


class Drives(unittest.TestCase):
    """Axes with too little force, or less later; the whole table is in the bench."""

    def outcomes(self, weak, seeds):
        return {(plant, seed): drives.simulate(plant, seed, weak, lambda seconds: True) for plant in drives.PLANTS for seed in seeds}

    def test_an_axis_with_enough_force_learns_and_a_later_loss_is_told_within_a_stroke(self):
        for axis, outcome in self.outcomes(False, (1, 2, 4)).items():
            self.assertFalse(outcome.silent, axis)
            self.assertTrue(outcome.learned, axis)
            self.assertLessEqual(outcome.beyond, 5, axis)
            self.assertFalse(outcome.late, axis)
            self.assertTrue(not outcome.affected or outcome.fault_later in (13, 19, 20, 21), axis)

    def test_a_weak_drive_is_told_and_passes_no_dead_point(self):
        for axis, outcome in self.outcomes(True, (20, 39, 79)).items():
            self.assertFalse(outcome.silent, axis)
            self.assertIn(outcome.fault, (21, 22), axis)
            self.assertLess(outcome.beyond, 50, axis)


class Proven(unittest.TestCase):
    """Strokes within the proven acceleration; the whole table is in the bench."""

    def test_an_axis_is_at_full_speed_at_once_and_soon_right(self):
        for plant in drives.PLANTS:
            outcomes = proven.simulate(plant, 3, lambda seconds: True)
            for kind, outcome in outcomes.items():
                self.assertEqual(outcome.factor, 1, (plant, kind))
                self.assertLessEqual(outcome.beyond, 5, (plant, kind))
                self.assertTrue(outcome.soon, (plant, kind))
            self.assertEqual(len(proven.table({plant: [outcomes, None]})), 2 + len(proven.KINDS))
            header, rows = proven.rows([(plant, 3), (plant, 4)], [outcomes, None])
            self.assertEqual([row[:3] for row in rows], [[plant, 3, kind] for kind in proven.KINDS])
            self.assertEqual({len(row) for row in rows}, {len(header)})


class Integral(unittest.TestCase):
    def test_an_axis_with_an_integral_passes_no_dead_point_in_its_first_strokes(self):
        outcome = integral.simulate(81014, True, lambda seconds: True)
        self.assertEqual(len(outcome.early), integral.EARLY)
        self.assertLess(outcome.first, 0)
        self.assertEqual(outcome.silent, 0)


class Ends(unittest.TestCase):
    def test_an_axis_stops_at_r_or_is_told(self):
        for plant in ends.PLANTS:
            outcome = ends.simulate(plant, 3, 1.1, lambda seconds: True)
            self.assertEqual(len(outcome.beyond), ends.WAYS)
            self.assertLess(max(outcome.beyond), 5, plant)
            self.assertEqual(outcome.silent, 0, plant)
            self.assertGreater(min(outcome.seconds), 0.2, plant)


class Drift(unittest.TestCase):
    def test_a_set_cycle_time_is_kept_to_a_nanosecond(self):
        strokes, seconds = grinder.drift(0.05, lambda seconds: True)
        self.assertGreater(strokes, 300)
        self.assertLess(abs(seconds), 1e-9 * strokes / 2)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench growth: its figures on a recording made by hand, and a short run of it."""

import os
import sys
import unittest

import numpy as np

import growth
from growth import GAUGE, KINDS
from plumb_folder import TemporaryFolder
from support import contacts, growth_curves
from support.figures import largest, rms
from support.growth_tests import PLAN, run_test

SANITIZED = bool(os.environ.get("PLUMB_SANITIZE"))  # ten times slower


class Judged(unittest.TestCase):
    def setUp(self):
        self.column = {name: np.zeros(8) for name in growth.COLUMNS}
        self.column["time"] = np.arange(8) * 10.0
        self.column["program.learn"][:3] = 1
        self.column["mill.truth-contact-operation"][:] = GAUGE
        self.column["mill.truth-contacts"] = np.array([0, 1, 1, 2, 3, 3, 3, 3])
        self.column["mill.truth-contact-growth"] = np.array([0, 1, 1, 5, 8, 8, 8, 8]) / 1000
        self.column["mill.truth-cuts"] = np.array([0, 0, 1, 1, 1, 2, 2, 3])
        self.column["mill.truth-cut-growth"] = np.array([0, 0, 1, 1, 1, 9, 9, 11]) / 1000
        for instance in ("growth", "hold"):
            self.column[instance + ".contacts-accepted"] = np.array([0, 0, 0, 1, 2, 2, 2, 2])
        self.column["growth.contacts"] = np.array([0, 0, 0, 1, 2, 2, 2, 2])
        self.column["growth.displacement"] = np.array([0, 0, 0, 4.5, 7, 7, 7, 7]) / 1000
        self.column["growth.z-offset"] = np.array([0, 0, 0, 4, 7, 8, 9.5, 99]) / 1000
        self.column["hold.z-offset"] = np.array([0, 0, 0, 4, 7, 7, 7, 99]) / 1000

    def test_error_is_the_offset_in_the_work_less_the_growth_since_the_reference(self):
        errors, found, _ = growth.judge(self.column)
        np.testing.assert_allclose(errors["by speed"], [-1, -0.5])
        np.testing.assert_allclose(errors["hold"], [-1, -3])
        np.testing.assert_allclose(found, [0.5, 0])

    def test_the_rivals_are_judged_at_the_same_cuts(self):
        errors, _, lines = growth.judge(self.column)
        np.testing.assert_allclose(errors["none"], [-8, -10])
        np.testing.assert_allclose(errors["Hold"], [-8 + 7, -10 + 7])  # by the last contact
        self.assertEqual(set(errors), {"hold", "by speed", "none", "Hold", "Simple3"})
        self.assertEqual([line.split()[0] for line in lines if not line.startswith(("speed", "part"))], ["contact", "contact", "cut", "cut"])

    def test_cuts_before_the_second_accepted_contact_are_not_reported(self):
        self.column["growth.contacts-accepted"][4:6] = 1
        errors, *_ = growth.judge(self.column)
        np.testing.assert_allclose(errors["by speed"], [-0.5])

    def test_table_is_over_machines(self):
        runs = [({"hold": np.full(3, size), "by speed": np.full(3, -2.0 * size)}, None) for size in range(1, 12)]
        lines = growth.table({"speed steps": runs})
        self.assertEqual(lines[1].split()[-6:], ["6.0", "10.0", "11.0", "10.5", "11.0", "100%"])
        self.assertEqual(lines[2].split()[-6:], ["12.0", "20.0", "22.0", "21.0", "22.0", "64%"])

    def test_a_machine_whose_contacts_were_not_seen_is_reported_and_is_not_within_tolerance(self):
        none = ({"hold": np.empty(0), "by speed": np.empty(0)}, None)
        runs = [({"hold": np.ones(3), "by speed": np.ones(3)}, None)] * 3 + [none]
        line = growth.table({"speed steps": runs})[1]
        self.assertIn(" 75%, 1 without a cut after a second contact", line)
        self.assertEqual(line.split()[3:8], ["1.0"] * 5)
        self.assertIn("not one machine had a cut", growth.table({"speed steps": [none]})[1])


class Curves(unittest.TestCase):
    def read(self, text, *arguments):
        with TemporaryFolder() as folder:
            path = os.path.join(folder, "curve.csv")
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            return growth_curves.read_curve(path, *arguments)

    def test_a_table_is_read_as_plumb_growth_reads_it(self):
        for text in (
            "TIME,S,T1,Z\n0,0,20,0\n30,3000,20,4\n60,3000,21,6\n",  # minutes, micrometres
            "time_s,growth_mm,spindle_rpm\n10,0,0\n1810,0.004,3000\n3610,0.006,3000\n",
            "spindle speed_rpm;displacement_um;time_min\n0;0;5\n3000;4,0;35\n3000;6,0;65\n",
        ):
            curve = self.read(text)
            np.testing.assert_allclose(curve.times, [0, 1800, 3600])
            np.testing.assert_allclose(curve.growth, [0, 0.004, 0.006])
            np.testing.assert_allclose(curve.speeds, [0, 3000, 3000])

    def test_a_head_can_be_read_as_another_and_a_bad_file_is_refused_with_its_reason(self):
        text = "time_s,spindle_rpm,ch1_um,ch2_um\n0,0,1,0\n60,0,1,4\n120,0,1,6\n"
        np.testing.assert_allclose(self.read(text, "ch2_um=Z_um").growth, [0, 0.004, 0.006])
        for bad, reason in (
            (text, "names no column of growth"),
            ("time_s,speed,x_um,z_um\n0,0,0,0\n1,0,1,2\n", "which column is the growth of the mill"),
            ("time_s,speed,z\n0,0,0\n9,0,1\n8,0,3\n", "line 4: the time does not rise"),
            ("time_s,speed,z\n0,0,0\n1,0,x\n", "line 3: column z: 'x' is no number"),
            ("time_s,speed,z\n0,0,0\n1,0\n2,0,1\n", "line 3: 2 values"),
        ):
            with self.assertRaisesRegex(OSError, reason):
                self.read(bad)

    def test_a_rival_has_a_row_below_that_of_the_component(self):
        cuts = np.zeros(2, contacts.CUT)
        cuts["error"], cuts["offset"], cuts["Hold"], cuts["Simple3"] = [-1, 8], [9, 18], [10, 10], [-6, 10]  # 10 um without compensation
        cuts["announced"], cuts["code"] = [True, False], 55
        rows = growth_curves.lines("curve.csv", growth_curves.Outcome(cuts, np.array([1.0, 1.0]), 2.0, 1, []))
        self.assertEqual(rows[0].split(), "curve.csv 2 10.0 5.7 43.0% 90.0% 50.0% 1 0 0 8.0 55: 50%".split())
        self.assertEqual(rows[1].split(), "Hold 0.0 100.0% 0 0.0".split())
        self.assertEqual(rows[2].split(), "Simple3 11.3 -13.1% 1 16.0".split())

    def test_part_removed_is_of_the_rms(self):
        self.assertAlmostEqual(growth_curves.removed(np.array([1, -1]), np.array([10, 10])), 0.9)


class Speeds(unittest.TestCase):
    def test_constant_speed_is_that_and_steps_are_of_10_to_40_minutes(self):
        self.assertEqual(len(set(growth.draw_speeds(1, "constant speed", 14400))), 1)
        resting = 0
        for seed in range(1, 50):
            speeds = np.array(growth.draw_speeds(seed, "speed steps", 14400))
            changes = np.flatnonzero(np.diff(speeds))
            self.assertGreaterEqual(len(speeds), 144)
            self.assertGreaterEqual(np.min(np.diff(changes)), 6)
            self.assertGreaterEqual(len(changes), 4)  # more, but for rests in a row
            resting += np.any(speeds == 0)
        self.assertGreater(resting, 10)


class Plans(unittest.TestCase):
    def test_a_growth_test_works_at_the_speeds_of_its_plan_and_ends_with_it(self):
        with TemporaryFolder() as folder:
            with open(run_test(folder, 1009, plan=PLAN), encoding="ascii") as file:
                lines = [line.split(",") for line in file]
        events = [line[9] for line in lines if line[0] == "event"]
        self.assertEqual(events.count("cycle-end"), len(PLAN))  # this machine is stable two cycles before
        self.assertEqual(events.count("pass-begin"), len(PLAN) + 1)
        speeds = [round(float(line[3]), -2) for line in lines if line[0] == "speed"]
        self.assertTrue({8000, 4000, 0}.issubset(speeds))


@unittest.skipIf(SANITIZED, "mill_both_linuxcnc_test runs the same modules")
class Short(unittest.TestCase):
    def test_following_the_speed_is_within_the_figures_and_better_than_holding(self):
        machines, duration = 2, 5400
        outcomes = growth.bench(machines, 1, duration, False)
        print("\n" + "\n".join(growth.table(outcomes)), file=sys.stderr)
        for kind in KINDS:
            for errors, found, _ in outcomes[kind]:
                self.assertEqual(len(found), duration // 300 - (0 if duration % 300 else 1))
                self.assertLess(rms(found), 3)
                self.assertLess(largest(errors["by speed"]), 15)
            size = {way: np.median([rms(errors[way]) for errors, *_ in outcomes[kind]]) for way in growth.WAYS}
            self.assertLess(size["by speed"], 2.5)
            if kind == "speed steps":
                self.assertLess(size["by speed"], size["hold"])


if __name__ == "__main__":
    unittest.main()

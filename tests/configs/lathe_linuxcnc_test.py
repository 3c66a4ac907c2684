#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/lathe: centre_height in a complete LinuxCNC, by the gauge and by hand, and its tool table."""

import math
import os
import re
import subprocess
import unittest

import linuxcnc_runs
from linuxcnc_runs import own_folder, read_recording
from starts import starts
from tree import ROOT


MORE_CUTS = 41  # of detail-code


class Shift(unittest.TestCase):
    """One start of LinuxCNC, in which programs/lathe_scenario.py works through all scenes."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("lathe", folder)
        cls.ini = ini = linuxcnc_runs.own_ini(os.path.join(machine, "lathe.ini"))
        its, cls.output = linuxcnc_runs.work(folder, ini, "lathe_scenario.py")
        cls.facts, cls.errors, cls.messages = its["facts"], its["errors"], its["messages"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.shift, its["scenes"])
        cls.after_restart = linuxcnc_runs.work(folder, ini, "lathe_scenario.py", "restart")[0]["facts"]
        table = os.path.join(machine, "tool.tbl")
        with open(table) as file:
            text = file.read()
        with open(table, "w") as file:
            file.write(text.replace("X-115.010000", "X-115.020000"))
        cls.two = linuxcnc_runs.work(folder, linuxcnc_runs.own_ini(os.path.join(linuxcnc_runs.copy_configuration("lathe", folder, "two"), "two.ini")),
                                     "lathe_scenario.py", "two")[0]["facts"]
        cls.after_edit = linuxcnc_runs.work(folder, ini, "lathe_scenario.py", "edited")[0]["facts"]

    def test_tool_comes_on_centre_and_the_table_keeps_it(self):
        self.assertEqual(self.facts["before"]["T1"], [-100, 0])
        x, y = self.facts["centred"]["T1"]
        self.assertAlmostEqual(y, -0.1, delta=0.012)
        self.assertAlmostEqual(x, -100.02, delta=0.012)
        self.assertTrue(self.facts["on centre"])
        self.assertEqual(self.facts["centred"]["T2"], self.facts["before"]["T2"])
        self.assertGreaterEqual(self.facts["copies"], 2)
        self.assertTrue(self.facts["last copy"], "the one after the height was stored")

    def test_diameter_is_the_programmed_one_after_it(self):
        self.assertGreater(abs(self.facts["turned before"] - 9.8), 0.03)
        self.assertAlmostEqual(self.facts["turned after"], 8, delta=0.02)

    def test_next_start_has_the_stored_height(self):
        self.assertEqual(self.after_restart["offset"], self.facts["at the end"]["T1"])
        self.assertNotEqual(self.after_restart["offset"][1], 0)

    def test_wear_correction_stops_no_start_and_an_edited_table_is_asked_about_once(self):
        self.assertEqual(self.after_restart["restarted"]["T2"], [-115.01, self.facts["at the end"]["T2"][1]])
        self.assertEqual(self.after_restart["asks"], [False, 40])
        self.assertEqual(self.after_edit["edited"], [True, 55])
        self.assertIn("nothing is stored", "\n".join(self.after_edit["edited store"]))
        self.assertEqual(self.after_edit["edited table"][0], -115.02)

    def test_gauge_that_is_stuck_stores_nothing_and_is_not_on_centre(self):
        texts, seen, untouched = self.facts["stuck"]
        self.assertEqual([each[:3] for each in seen], [[False, False, False]] * 3)
        self.assertIn("The last diameter does not fit. Check the insert", "\n".join(texts + self.messages + self.errors))
        self.assertTrue(untouched)

    def test_store_that_no_land_shows_is_taken_back_with_the_tool_clear(self):
        texts, (before, after), (x, y, joint) = self.facts["not shown"]
        self.assertIn("does not have the programmed diameter", "\n".join(texts))
        self.assertEqual(before, after)
        self.assertEqual([x, y], [-100, 0])
        self.assertGreater(joint, -100 + 5.3)

    def test_x_that_was_stored_meanwhile_is_asked_about(self):
        texts, between, x, y, after = self.facts["meanwhile"]
        self.assertIn("another X or Y was stored meanwhile", "\n".join(texts))
        self.assertIn("stored meanwhile: X  -100.0500", "\n".join(texts))
        self.assertEqual(between, [-100.05, 0])
        self.assertAlmostEqual(after[0], -100.05 + x, delta=2e-5)
        self.assertAlmostEqual(after[1], y, delta=2e-5)

    def test_check_by_hand_needs_a_reading_a_quarter_turn_further(self):
        self.assertIn("Measure this cut a quarter turn further, too", "\n".join(self.facts["one reading"] + self.messages + self.errors))

    def test_height_from_elsewhere_is_stored(self):
        self.assertEqual(self.facts["elsewhere"], [-100, -0.0321])

    def test_store_without_trial_stock_is_not_checked(self):
        self.assertIn("stored, and not checked", "\n".join(self.messages))

    def test_by_hand_the_spindle_stands_and_y_moves_only_clear_in_x(self):
        self.assertEqual(self.facts["standing"], [False] * 6)
        rows = self.rows["by_readme"]
        x, y = (self.shift["joint.%d.pos-cmd" % joint][rows] for joint in (0, 1))
        moves = abs(y[1:] - y[:-1]) > linuxcnc_runs.STILL
        self.assertTrue(moves.any())
        self.assertGreater(x[1:][moves].min(), -100 + 5.3)

    def test_by_hand_the_machine_moves_for_as_long_as_the_readme_says(self):
        rows = self.rows["by_readme"]
        time, *places = (self.shift[name][rows] for name in ("time", *("joint.%d.pos-cmd" % joint for joint in range(3))))
        moving = sum(abs(place[1:] - place[:-1]) for place in places) > linuxcnc_runs.STILL
        with open(os.path.join(ROOT, "configs", "lathe", "README.md")) as file:
            said = int(re.search(r"The machine moves for (\d+) s", file.read())[1])
        self.assertAlmostEqual(float((time[1:] - time[:-1])[moving].sum()), said, delta=0.25 * said)

    def test_restart_in_the_middle_begins_again_and_keeps_the_table(self):
        self.assertEqual(self.after_restart["state"], [0, False, False])
        self.assertIn("nothing is interrupted", "\n".join(self.after_restart["nothing to continue"]))
        self.assertIn("nothing is stored", "\n".join(self.after_restart["nothing to store"]))
        self.assertEqual(self.after_restart["restarted"], self.facts["at the end"])

    def test_readme_brings_a_tool_on_centre_by_hand_word_by_word(self):
        self.assertEqual(self.facts["readme before"], [-100, 0])
        x, y = self.facts["readme"]
        self.assertAlmostEqual(y, -0.1, delta=0.012)
        self.assertAlmostEqual(x, -100.02, delta=0.012)
        self.assertRegex("\n".join(self.messages), r"M454 changes Y of tool *1 from *0\.0000 to *-0\.(09|10)")

    def test_two_cuts_bring_a_thin_bar_to_its_end_and_find_the_side(self):
        x, y = self.facts["two"]
        self.assertAlmostEqual(y, 0.03, delta=0.005)
        self.assertGreater(self.facts["two before"], 0.1)
        self.assertAlmostEqual(self.facts["two after"], 0.06, delta=0.006)
        y = self.facts["word 1"][2]
        self.assertEqual([self.facts["word -1"], self.facts["word 1"]], [[-1, 0, y], [1, 0, y]])
        text, y_after = self.facts["axis word"]
        self.assertIn("a word Y would move Y", "\n".join(text))
        self.assertEqual(y_after, y)
        self.assertIn("two lands need their diameter", "\n".join(self.facts["lands need D"]))

    def test_two_cuts_as_delivered(self):
        (x, y), shown = self.two["two as delivered"]
        self.assertAlmostEqual(y, 0.03, delta=0.005)
        self.assertTrue(shown)

    def test_spindle_that_feels_no_cut_is_told(self):
        self.assertIn("the cut is refused", "\n".join(self.facts["load"]))
        self.assertIn("The load of the spindle has shown no cut", "\n".join(self.facts["load"] + self.messages + self.errors))
        self.assertEqual(self.facts["load of a cut"], 0)

    def previewed(self, program):
        """A screen interprets a program without a machine that answers."""
        command = ["rs274", "-g", "-i", self.ini, os.path.join(os.path.dirname(self.ini), program)]
        done = subprocess.run(command, cwd=os.path.dirname(self.ini), capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("PROGRAM_END", done.stdout)
        return done.stdout

    def test_preview_of_the_program_ends(self):
        self.assertLess(self.previewed("centre.ngc").count("STRAIGHT"), 10)  # no M-code of centre_height measures

    def test_each_pass_of_the_step_of_y_is_of_one_depth(self):
        radius, depths = 5.3, []
        for x, y, z in re.findall(r"STRAIGHT_FEED\((\S+), (\S+), (\S+),", self.previewed("step.ngc")):
            if float(z) == 11:
                depths.append(radius - math.hypot(float(x), float(y)))
                radius -= depths[-1]
        self.assertEqual(len(depths), 10)
        self.assertLess(max(depths) - min(depths), 0.005)

    def test_tools_of_two_turrets_and_two_spindles_come_on_centre_in_one_program(self):
        self.assertAlmostEqual(self.facts["behind"]["T1"][1], -0.1, delta=0.012)
        x, y = self.facts["behind"]["T3"]
        self.assertAlmostEqual(y, -0.08, delta=0.012)
        self.assertAlmostEqual(x, 100.015, delta=0.012)
        self.assertAlmostEqual(self.facts["turned behind"], 8, delta=0.02)
        x, y = self.facts["behind"]["T4"]
        self.assertAlmostEqual(y, -0.07, delta=0.012)
        self.assertAlmostEqual(x, -100.03, delta=0.012)

    def test_tool_does_not_enter_standing_work(self):
        self.assertIn("start the spindle of the work", "\n".join(self.facts["standing work"]))
        self.assertIn("I is the number of a spindle", "\n".join(self.facts["no such spindle"]))
        self.assertIn("M455 needs G90", "\n".join(self.facts["incremental"]))

    def test_step_of_y_in_a_program(self):
        x, y = self.facts["by step"]
        self.assertAlmostEqual(y, -0.1, delta=0.03)
        self.assertAlmostEqual(x, -100.02, delta=0.03)

    def test_height_at_rest_is_told_from_the_one_under_the_cut(self):
        truth = self.shift["lathe.truth-bend"][self.rows["bend"]].max()
        under_cut, _, detail = self.facts["bend"]
        self.assertFalse(self.facts["known"])
        self.assertEqual(detail, 0)
        at_rest, bend, detail = self.facts["bend H3"]
        self.assertTrue(self.facts["known H3"])
        self.assertEqual(detail, 37)
        self.assertAlmostEqual(bend, at_rest - under_cut, delta=1e-6)
        self.assertGreater(bend, 0.6 * truth)  # nine tenths of it are tangential
        self.assertLess(bend, 1.2 * truth)
        self.assertIn("nothing is stored", "\n".join(self.facts["at rest"]))

    def test_thin_bar_and_cone_need_a_tool_on_centre(self):
        self.assertGreater(self.facts["thin before"], 0.19)
        self.assertAlmostEqual(self.facts["thin after"], 0.06, delta=0.012)
        self.assertLess(self.facts["nib"], 0.02)

    def test_refusals_tell_the_operator_and_leave_the_table(self):
        for name, text in (
            ("nothing known", "Y may not move, and nothing is stored"),
            ("compensated", "cutter compensation off"),
            ("no cut", "no cut waits for a diameter"),
            ("radius", "The entry is the radius, not the diameter"),
            ("inch", "The entry is in inches"),
            ("sign", "Y may not move, and nothing is stored"),
            ("other tool's cut", "tool or offsets are not those of M450"),
            ("other tool's diameter", "tool or offsets are not those of M450"),
            ("air", "the tool removed nothing"),
        ):
            with self.subTest(name):
                self.assertIn(text, "\n".join(self.facts[name]))
        self.assertTrue(self.facts["untouched"])
        self.assertTrue(any("Two cuts do not show the sign" in text for text in self.messages))

    def test_units_and_diameter_mode_of_the_program_do_not_matter(self):
        self.assertEqual(len(self.facts["hand"]), 4)
        for mode, length, x, y in self.facts["hand"]:
            with self.subTest(mode + length):
                self.assertAlmostEqual(y, -0.05, delta=2e-5)
                self.assertAlmostEqual(x, -0.03, delta=2e-5)

    def test_height_too_small_to_store_ends_no_program(self):
        self.assertEqual(self.facts["small"], [[True, 0, True], [False, MORE_CUTS, True]])
        texts, untouched = self.facts["unproven"]
        self.assertIn("A check is due", "\n".join(texts))
        self.assertTrue(untouched)
        before, after = self.facts["only X"]
        self.assertAlmostEqual(after[0] - before[0], -0.06, delta=2e-5)
        self.assertEqual(after[1], before[1])
        self.assertRegex("\n".join(self.messages), r"M454 changes X of tool *1 from *%.4f to *%.4f" % (before[0], after[0]))

    def test_cuts_that_met_no_stock_are_not_on_centre(self):
        self.assertFalse(self.facts["air on centre"])
        self.assertEqual(self.facts["unchecked"], [49, False])

    def test_abort_leaves_the_table_and_the_operator_goes_on(self):
        self.assertTrue(self.facts["resumed"])
        self.assertEqual(self.facts["resumed cuts"], 1)
        self.assertAlmostEqual(self.facts["resumed height"], 0.05, delta=1e-5)
        self.assertIn("nothing is stored", "\n".join(self.facts["after abort"]))
        self.assertTrue(self.facts["abort left the table"])

    def test_lands_are_aborted_at_every_step_and_continued_or_begun_again(self):
        self.assertEqual(len(self.facts["steps"]), 7)
        heights = []
        for step, its in self.facts["steps"].items():
            with self.subTest(step):
                self.assertEqual(its["idle"], [False, False, False])
                self.assertIn("nothing is stored", "\n".join(its["store"]))
                self.assertTrue(its["table"])
                self.assertEqual(its["end"][0], 3, "the check is the third cut")
                self.assertTrue(its["end"][2])
                heights.append(its["end"][1])
        self.assertLess(max(heights) - min(heights), 0.02)
        self.assertIn("start the spindle", "\n".join(self.facts["steps"]["between"]["stopped spindle"]))
        self.assertIn("load the tool", "\n".join(self.facts["other tool"]))

    def test_abort_gives_the_operator_the_units_back(self):
        self.assertIn(20, self.facts["units after an abort"])
        self.assertIn(7, self.facts["units after an abort"])

    def test_aborted_store_is_old_or_new_and_never_twice(self):
        ends = set()
        for before, after, x, y in self.facts["stores"]:
            new = abs(after[0] - before[0] - x) < 2e-5 and abs(after[1] - before[1] - y) < 2e-5
            ends.add("new" if new else "old" if before == after else "%s to %s by %g %g" % (before, after, x, y))
        self.assertEqual(ends, {"old", "new"})

    def test_each_tool_has_its_own_height(self):
        before, after = self.facts["second"]
        self.assertEqual(before["T1"], after["T1"])
        self.assertAlmostEqual(after["T2"][1] - before["T2"][1], -0.05, delta=2e-5)


tearDownModule = starts("lathe/lathe.ini", "lathe/two.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Shift, __doc__)

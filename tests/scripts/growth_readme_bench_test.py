# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench growth_readme: reads the commands of the README, runs them in one shell, and judges what their reports say."""

import copy
import os
import unittest

import growth_readme
from tree import BUILD, own_folder

GOOD = {
    "failed": "",
    "seed": 1,
    "tests": [
        {
            "verdict": "pass",
            "reasons": ["All axes stay within their tolerances with compensation."],
            "compensation": {"sentence": "The compensation removes the drift."},
            "axes": {
                letter: {
                    "gain": {"determined": True, "value": 1.0, "uncertainty": 0.05},
                    "off": {"largest_mm": 0.03},
                    "on": {"largest_mm": 0.004},
                }
                for letter in "XYZ"
            },
            "series": [{"compensated": True, "points": [{"compensation_mm": [0.01, 0.01, 0.03]}]}],
            "identified": {"axes": {"Z": {"used": True, "predicted_rest_mm": 0.002, "none_rest_mm": 0.02, "line_rest_mm": 0.003}}},
        }
    ]
    * 2,
}


class Judged(unittest.TestCase):
    def wrong(self, test, change):
        outcome = copy.deepcopy({**GOOD, "tests": [copy.deepcopy(its) for its in GOOD["tests"]]})
        change(outcome["tests"][test])
        return " ".join(growth_readme.judged(outcome))

    def test_a_good_try_is_good_and_counted(self):
        self.assertEqual(growth_readme.judged(GOOD), [])
        text = "\n".join(growth_readme.figures({1: GOOD}))
        self.assertIn("good: 1 of 1 tries; corrected: 1 of 1 axes", text)
        self.assertIn("30.0/30.0/30.0", text)

    def test_a_sentence_that_a_figure_contradicts_is_found(self):
        def gain(test):
            test["axes"]["X"]["gain"]["value"] = 0.04

        def told(test):
            gain(test)
            test["compensation"]["sentence"] += " But X, which drifts by 30.0 µm without it, has a gain of 0.04."

        def nothing(test):
            test["compensation"]["sentence"] = "The compensation does nothing."

        def unused(test):
            test["identified"]["axes"]["Z"]["used"] = False

        self.assertIn("second test: X: gain 0.04", self.wrong(1, gain))
        self.assertEqual(self.wrong(1, told), "")
        self.assertIn("moved an axis by more than 5 um", self.wrong(1, nothing))
        self.assertIn("first test: Z: not corrected, but", self.wrong(0, unused))

    def test_a_verdict_that_is_no_pass_a_missing_law_and_a_command_that_fails_are_found(self):
        def fails(test):
            test["verdict"] = "fail"

        def lawless(test):
            test["identified"], test["not_identified"] = None, "the log has 3 passes"

        self.assertEqual(self.wrong(0, fails), "")  # of the machine as it came
        self.assertIn("the second verdict is fail", self.wrong(1, fails))
        self.assertIn("no law: the log has 3 passes", self.wrong(0, lawless))
        self.assertIn("there is no report of the second test", " ".join(growth_readme.judged({**GOOD, "tests": [GOOD["tests"][0], None]})))


class Commands(unittest.TestCase):
    def test_the_commands_are_those_of_the_readme_in_their_order(self):
        words = ["plumb example growth", "growth.ini", "growth report", "identify logs", "identify logs", "mv logs first", "identified.ini", "growth report", "growth plan", "--ngc"]
        found = growth_readme.commands()
        self.assertEqual(len(found), len(words))
        for command, its in zip(found, words):
            self.assertIn(its, command)

    def test_they_run_in_one_shell_with_the_machine_of_the_try_and_the_first_that_fails_is_named(self):
        folder = own_folder(self)
        outcome = growth_readme.run(folder, ["setp artifact.seed 7", "no such command"])
        self.assertIn("linuxcnc growth.ini", outcome["failed"])
        self.assertEqual(len(outcome["outputs"]), 1)
        with open(os.path.join(folder, "growth", "accelerated.hal"), encoding="ascii") as file:
            self.assertTrue(file.read().endswith("setp artifact.seed 7\nno such command\n"))
        self.assertTrue(os.path.exists(os.path.join(BUILD, "bin", "plumb-growth")))


if __name__ == "__main__":
    unittest.main()

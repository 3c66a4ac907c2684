#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb commission in a complete LinuxCNC: squareness passes on a machine that is wired right, and faults in its wiring are named.

    python3 tests/support/run.py tests/commissioning/commission_linuxcnc_test.py --table [FUNCTION...]

puts each fault into the wiring of each function, and prints what was named.
"""

import os
import sys
import unittest

import commissioning_attacks
import linuxcnc_runs
import restarts
from commissioning_machines import prepared
from linuxcnc_runs import own_folder
from long import long
from plumb_folder import TemporaryFolder


SEED = 398  # ends a press of the stage, and one of the stroke
LONG = ("second-sign", "drive-sign", "position", "other-source")
FAULTS_HERE = ("right", "sign", *(LONG if os.environ.get("PLUMB_LONG") else ()))


class Commission(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        ini = prepared(own_folder(cls), "squareness")
        its, cls.output = linuxcnc_runs.work(os.path.dirname(os.path.dirname(ini)), ini, "commission_scenario.py", "squareness", *FAULTS_HERE,
                                             patience=2 * linuxcnc_runs.PATIENCE)  # several sessions of 20 steps
        cls.facts = its["facts"]
        cls.table = cls.facts["table"]
        for standstill in cls.facts.get("standstills", []):
            restarts.note(restarts.STANDSTILL, standstill)

    def test_machine_that_is_wired_right_passes(self):
        its = self.table["right"]
        self.assertTrue(its["passed"], its)
        self.assertEqual(its["fault"], "")
        for title in ("x-stage moves X by +0.010 mm", "Y without the correction, X", "Y without the correction, Z", "In air at 10 % feed", "Emergency stop", "Bypass and undo"):
            self.assertIn(title, its["titles"])
        self.assertEqual(its["with_one_axis"], "Y, Z did not move by 5 mm while you pressed.")
        self.assertEqual(its["unpressed"], 0, "only a hand that presses beats")

    def test_each_fault_is_named_and_none_passes(self):
        for fault, named in (("sign", "Reverse the sign of ec0y."), ("second-sign", "Reverse the sign of ea0y."), ("drive-sign", "Reverse the sign: of the scale of the drive"),
                             ("position", "Reverse the sign: of the scale of the drive, of the signal")):
            if fault not in FAULTS_HERE:
                continue
            its = self.table[fault]
            self.assertEqual((its["fault"], its["passed"], its["acts"], its["commissioned"]), ("sign", False, False, False), its)
            self.assertIn(named, its["remedy"])

    @long
    def test_a_stage_that_would_move_by_itself_does_not_pass(self):
        its = self.table["other-source"]
        self.assertEqual((its["fault"], its["passed"], its["titles"][-1]), ("state", False, "x-stage moves X by +0.010 mm"), its)
        self.assertIn("x-stage.offset-1 asks for 0.9", its["sentence"])

    def test_sheet_lists_what_was_not_tried(self):
        untried = self.table["right"]["sheet"].split("\nNot tried\n")[1]
        self.assertIn("after work on them, try again", untried)
        self.assertIn("its value did not change", untried)
        self.assertIn("square.z-tool-offset: scale and sign of fault-square-z-tool-offset.out", untried)

    def test_sheet_has_readings_and_who(self):
        text = self.table["right"]["sheet"]
        for words in ("robot", "x-stage moves X by +0.010 mm", "square.ec0y = ", "drive-command > fault-x-cmd.in0", "Error by the tilts"):
            self.assertIn(words, text)

    def test_state_tells_what_passed_and_what_changed(self):
        kinds = {sentence.split(":")[0]: (kind, sentence) for kind, sentence, _command in self.table["right"]["state"]}
        self.assertEqual(kinds["function square"][0], "ok", kinds)
        self.assertIn("robot", kinds["function square"][1])
        changed = [sentence for _kind, sentence, _command in self.table["right"]["state_with_another_sign"]]
        self.assertTrue(any("its wiring or a sign changed since" in sentence for sentence in changed), changed)
        self.assertTrue(any("ec0y was" in sentence for sentence in changed), changed)

    def test_program_lets_pass_by_hand_and_takes_back(self):
        for name, status, words in (("by_hand_on", 1, "square is switched on, and would act at once: switch it off"), ("by_hand", 0, "commissioned_squareness.html"), ("doctor", 0, "function square: set by hand by K. Braun"),
                                    ("undo", 0, "held again"), ("doctor_undone", 1, "function square has not passed, and is held.")):
            text, ended = self.facts[name]
            self.assertEqual(ended, status, text)
            self.assertIn(words, " ".join(text.split()))

    def test_after_work_on_a_drive_the_program_tries_its_stage_again(self):
        text, _status = self.facts["again"]
        self.assertIn("1/3  Wiring", text)
        self.assertEqual(self.facts["after_again"], [False, True, True])

    def test_program_asks_in_the_terminal_and_names_the_fault(self):
        text, status = self.facts["terminal"]
        self.assertEqual(status, 1, text)
        for words in ("x-stage moves X by +0.010 mm", "Picture: ", "Asked 0.01, read", "The sign is wrong.", "The function is off."):
            self.assertIn(words, text)

    def test_kill_ends_a_trial_and_another_beat_does_not_begin_it_again(self):
        for took, applied, stage in self.facts["killed"]:
            self.assertLess(took, 0.5 * linuxcnc_runs.speed + 1)  # half a second of the computer's clock, and the ramp
            self.assertEqual((applied, stage), (0, 0))  # the number of a killed program stays

    def test_emergency_stop_in_the_step_of_10_um_holds_and_then_returns_for_good(self):
        before, off, again = self.facts["stopped"]
        self.assertAlmostEqual(before, 0.01, delta=1e-7)
        self.assertEqual((off, again), (before, 0))


@long
class CommissionStrokes(unittest.TestCase):
    def test_a_grinder_that_is_wired_right_passes_and_a_command_is_no_feedback(self):
        ini = prepared(own_folder(self), "chopping")
        its, _output = linuxcnc_runs.work(os.path.dirname(os.path.dirname(ini)), ini, "commission_scenario.py", "chopping", "command", "right")
        self.assertEqual(its["facts"]["table"]["command"]["sentence"], "chop.joint-feedback has the commanded position, joint.2.motor-pos-cmd.")
        its = its["facts"]["table"]["right"]
        self.assertTrue(its["passed"], its)
        self.assertEqual(its["titles"][3:7], ["One slow stroke in air", "Hold", "Back to point R", "Emergency stop"])
        self.assertLess(its["crept"], 0.001, "where somebody let go the axis stands")
        self.assertEqual(its["unpressed"], 0, "only a hand that presses beats")


@long
class CommissionGrowth(unittest.TestCase):
    def test_a_slow_return_is_no_fault_and_the_sheet_has_the_sensors(self):
        ini = prepared(own_folder(self), "axis_growth")
        its, _output = linuxcnc_runs.work(os.path.dirname(os.path.dirname(ini)), ini, "commission_scenario.py", "axis_growth", "right")
        its = its["facts"]["table"]["right"]
        self.assertTrue(its["passed"], its)
        self.assertTrue(any(sentence.startswith("An offset still returns") for sentence in its["sentences"]), its["sentences"])
        untried = its["sheet"].split("\nNot tried\n")[1]
        self.assertIn("axis-growth.temperature-age-0: scale and sign of artifact.temperature-age-0", untried)
        self.assertNotIn("axis-growth.temperature-0: ", untried)


@unittest.skipIf(os.environ.get("PLUMB_SANITIZE"), "sanitized, it takes too long")
class CommissionAttacks(unittest.TestCase):
    """A case of scripts/campaign commission."""

    def test_whatever_ends_a_session_nothing_moves_but_what_was_pressed_and_it_returns(self):
        run = commissioning_attacks.sessions("chopping", SEED, ways=("one",), steps=4)
        self.assertEqual((run.findings, run.tries), ([], 4))
        self.assertGreaterEqual(sum(pressed for _what, _tries, pressed in run.rows), 2, run.rows)


# By function; the words of put_... in commission_scenario.py.
FAULTS = {
    "squareness": ("right", "sign", "second-sign", "position", "drive-sign", "drive-inch", "drive-25", "swapped", "drive-swapped", "net", "drive-dead", "order"),
    "thermal_displacement": ("right", "sign", "drive-sign", "command", "driven", "part", "drive-25", "swapped", "drive-swapped", "net", "order"),
    "chopping": ("right", "command", "drive-sign", "drive-inch", "drive-25", "swapped", "drive-swapped", "net", "drive-dead", "order"),
    "centre_height": ("right", "sign", "inch", "radius", "swapped", "net", "order"),
    "axis_growth": ("right", "sign", "swapped", "net", "unread", "order"),
    "thermal_growth_test": ("right", "sign", "inch", "25", "command", "swapped", "net", "sensor", "order"),
}


NOTHING = {"steps": 0, "presses": 0, "readings": 0, "seconds": 0}


def table(functions):
    """A row for each fault. Returns how many passed that should not, or did not that should."""
    wrong = 0
    print("| Function | Fault put in | Step | Named |\n| --- | --- | --- | --- |")
    for function in functions or FAULTS:
        faults = FAULTS[function]
        with TemporaryFolder() as folder:
            os.chmod(folder, 0o777)
            its, _output = linuxcnc_runs.work(folder, prepared(folder, function), "commission_scenario.py", function, *faults, patience=1800)
        for fault, row in its["facts"]["table"].items():
            wrong += row["passed"] != (fault == "right") or row["fault"] == "error"
            effort = "passed: {steps} steps, {presses} presses, {readings} readings, {seconds:.0f} s of the machine".format(**row.get("effort", {}) or NOTHING)
            named = effort if row["passed"] else "%s: %s" % (row["fault"], row["sentence"])
            print("| %s | %s | %s | %s |" % (function, fault, row.get("step", ""), named), flush=True)
    print("%d rows are not as they should be." % wrong)
    return wrong


if __name__ == "__main__":
    if "--table" in sys.argv:
        sys.exit(1 if table(sys.argv[2:]) else 0)
    unittest.main()

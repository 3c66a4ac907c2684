#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb commission in a complete LinuxCNC: squareness passes on a machine that is wired right, and faults in its wiring are named.

scripts/bench commission does this for all functions and all faults.
"""

import os
import unittest

import linuxcnc_runs
from commissioning_machines import prepared
from linuxcnc_runs import own_folder


class Commission(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        ini = prepared(own_folder(cls), "squareness")
        its, cls.output = linuxcnc_runs.work(os.path.dirname(os.path.dirname(ini)), ini, "commission_scenario.py", "squareness", "right", "sign", "drive-sign")
        cls.facts, cls.folder = its["facts"], os.path.dirname(ini)
        cls.table = cls.facts["table"]

    def test_machine_that_is_wired_right_passes(self):
        its = self.table["right"]
        self.assertTrue(its["passed"], its)
        self.assertEqual(its["fault"], "")
        for title in ("x-stage moves X by +0.010 mm", "Y without the correction", "In air at 10 % feed", "Emergency stop", "Bypass and undo"):
            self.assertIn(title, its["titles"])

    def test_each_fault_is_named_and_none_passes(self):
        for fault, named in (("sign", "Reverse the sign of ec0y."), ("drive-sign", "Reverse the sign: of the scale of the drive")):
            its = self.table[fault]
            self.assertEqual((its["fault"], its["passed"], its["acts"], its["commissioned"]), ("sign", False, False, False), its)
            self.assertIn(named, its["remedy"])

    def test_sheet_has_readings_and_who(self):
        with open(os.path.join(self.folder, "plumb", "commissioned_squareness.txt"), encoding="utf-8") as file:
            text = file.read()
        for words in ("robot", "x-stage moves X by +0.010 mm", "square.ec0y = ", "drive-command > fault-x-cmd.in0", "Error by the tilts"):
            self.assertIn(words, text)

    def test_state_tells_what_passed_and_what_changed(self):
        kinds = {sentence.split(":")[0]: (kind, sentence) for kind, sentence, _command in self.table["right"]["state"]}
        self.assertEqual(kinds["function square"][0], "ok", kinds)
        self.assertIn("robot", kinds["function square"][1])
        changed = [sentence for _kind, sentence, _command in self.table["right"]["state_with_another_sign"]]
        self.assertTrue(any("its wiring or a sign changed since" in sentence for sentence in changed), changed)
        self.assertTrue(any("ec0y was" in sentence for sentence in changed), changed)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Two programs in turn on configs/mill, in a complete LinuxCNC: each cut, and each sentence."""

import os
import re
import unittest

import linuxcnc_runs
from linuxcnc_runs import own_folder, um
from long import long
from starts import starts

TOLERANCE = 6 * um  # of the cuts, as in mill_config_test
PROBE = 3 * um  # by which a probed zero may be off: the seat of the probe
WORKS, OTHER_PROGRAM = 40, 48  # status-code

GROWS_AS_A_SPINDLE = """
setp growth.max-growth-rate 0.0002
"""


@long
class TwoPrograms(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "mill.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = spindle.hal"))
        with open(os.path.join(machine, "spindle.hal"), "w") as file:
            file.write(GROWS_AS_A_SPINDLE)
        with open(os.path.join(machine, "part.ngc")) as file:
            text = file.read()
        with open(os.path.join(machine, "other.ngc"), "w") as file:  # other depths and another order of the tools
            file.write(re.sub(r"^; One part.*", "; Another part", text, flags=re.MULTILINE).replace("[20] [2] [100]", "[20] [4] [100]").replace("[-20] [2] [150]", "[-20] [3] [150]"))
        cls.parts = {}
        for day in ("first", "second"):
            its, _ = linuxcnc_runs.work(folder, ini, "mill_programs.py", day, facts=day + ".json")
            cls.parts[day] = its["facts"]["parts"]

    def of(self, name):
        return next(part for day in self.parts.values() for part in day if part["name"] == name)

    def test_each_cut_is_true_in_both_programs(self):
        probed = 0
        for part in self.parts["first"]:
            probed = PROBE if "higher table" in part["name"] else probed
            if part["name"] != "without a reference":
                with self.subTest(part["name"]):
                    self.assertEqual(len(part["errors"]), 6)
                    self.assertLess(max(map(abs, part["errors"])), TOLERANCE + probed, part)

    def test_a_program_without_a_reference_is_not_corrected_and_says_so(self):
        part = self.of("without a reference")
        self.assertEqual(part["status-code"], OTHER_PROGRAM)
        self.assertLess(abs(part["z-offset"]), 0.1 * um)
        self.assertLess(max(part["errors"]), -0.5 * part["growth"])

    def test_nothing_is_asked_and_nothing_is_said_but_what_was_learned(self):
        for part in self.parts["first"]:
            with self.subTest(part["name"]):
                self.assertEqual(part["shift-size"], 0, part)
                for text in part["said"]:
                    self.assertRegex(text, "Learned from this part|Nothing was learned" if "learns" in part["name"] or "abort" in part["name"] else "Waits for the first contact", part)

    def test_both_references_outlive_the_restart(self):
        self.assertEqual(self.parts["second"][0]["rows"], self.of("learns warm")["rows"])
        for part in self.parts["second"][1:]:
            with self.subTest(part["name"]):
                self.assertLess(max(map(abs, part["errors"])), TOLERANCE + PROBE, part)
tearDownModule = starts("mill/mill.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(TwoPrograms, __doc__)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/lathe/twin.ini: two tools that cut one bar at once come on centre in a complete LinuxCNC."""

import os
import unittest

import linuxcnc_runs
from linuxcnc_runs import own_folder, read_recording, um
from starts import starts


class Twin(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("lathe", folder)
        its, cls.output = linuxcnc_runs.work(folder, linuxcnc_runs.own_ini(os.path.join(machine, "twin.ini")), "twin_scenario.py")
        cls.facts, cls.messages = its["facts"], its["messages"]
        recording = read_recording(os.path.join(machine, "twin.csv"))
        cls.rows = {name: column[linuxcnc_runs.rows_of(recording, its["scenes"])["together"]] for name, column in recording.items()}

    def test_both_tools_come_on_centre(self):
        after = self.facts["after"]
        for tool, axis, value in (("T1", "X", -100.02), ("T1", "Y", -0.1), ("T3", "U", 100.015), ("T3", "V", -0.08)):
            with self.subTest(tool + axis):
                self.assertAlmostEqual(after[tool][axis], value, delta=12 * um)
        for tool, axis in (("T1", "U"), ("T1", "V"), ("T3", "X"), ("T3", "Y")):
            self.assertEqual(after[tool][axis], self.facts["before"][tool][axis], "the other slide has its own tool")

    def test_both_stay_in_force(self):
        after = self.facts["after"]
        wanted = [after["T1"]["X"], after["T1"]["Y"], after["T3"]["U"], after["T3"]["V"]]
        for got, value in zip(self.facts["in force"], wanted):
            self.assertAlmostEqual(got, value, delta=1e-6)

    def test_both_cut_at_once_in_all_lands(self):
        together = (self.rows["lathe.truth-cutting"] > 0) & (self.rows["second.truth-cutting"] > 0)
        first = self.rows["lathe.truth-cutting"] > 0
        self.assertGreater(together.sum(), 0.9 * first.sum())
        for tool in ("lathe", "second"):
            self.assertGreater(self.rows[tool + ".truth-bend"].max(), 2 * um)

    def test_both_turn_the_programmed_diameter_together(self):
        for diameter in self.facts["diameters"]:
            self.assertAlmostEqual(diameter, 8, delta=0.02)
        self.assertFalse(self.facts["behind the other"], "the deeper tool has made the diameter")

    def test_cut_with_other_offsets_is_refused(self):
        self.assertIn("tool or offsets are not those of M450", "\n".join(self.facts["other offsets"]))

    def test_each_station_of_z_has_its_height(self):
        its = self.facts["stations"]
        self.assertAlmostEqual(its["T1"]["Y"], -0.126, delta=6 * um)
        self.assertAlmostEqual(its["T11"]["Y"], -0.109, delta=6 * um)

    def test_operator_reads_which_offsets_change(self):
        text = "\n".join(self.messages)
        self.assertRegex(text, r"M454 changes Y of tool *1 from *0\.0000 to *-0\.")
        self.assertRegex(text, r"M454 changes V of tool *3 from *0\.0000 to *-0\.")
        self.assertRegex(text, r"M454 changes U of tool *3 from *100\.0000 to *100\.0")


tearDownModule = starts("lathe/twin.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Twin, __doc__)

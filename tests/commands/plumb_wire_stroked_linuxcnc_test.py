#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire with chopping beside functions that use the same axis: they get the place of the stroking axis, whichever came first."""

import os
import unittest

from long import long
from wire_sample import AXIS_MM, Sample, plumb_wire, read

WRITTEN = ("net z-stroked-position chop.command\n", "net z-stroked-velocity chop.command-velocity\n", "net z-stroked-joint-fb chop.measured-position\n",
           "net z-stroked-learns chop.learns\n", "net z-velocity => chop.joint-velocity\n")
AT_REST = ("net z-position => square.z-position\n", "net z-velocity => square.z-velocity\n", "setp square.max-speed [TRAJ]MAX_LINEAR_VELOCITY\n")
STROKING = ("net z-stroked-position => square.z-position\n", "net z-stroked-velocity => square.z-velocity\n", "net z-stroked-learns => square.z-learns\n")


class Stroked(Sample):
    def files(self):
        folder = self.folder(AXIS_MM)
        return {name: read(os.path.join(folder, name)) for name in os.listdir(folder) if name.endswith((".hal", ".tcl"))}

    def wired(self, *functions):
        """The files of a run that must succeed, by name."""
        status, output, _flat = self.wire(AXIS_MM, *functions)
        self.assertEqual(status, 0, output)
        return self.files()

    def missing(self, lines, text):
        return [line for line in lines if line not in text]

    def assert_stroking(self, files):
        self.assertEqual(self.missing(STROKING, files["squareness.hal"]), [])
        self.assertEqual(self.missing(WRITTEN, files["chopping.hal"]), [])
        self.assertIn("net z-position => chop.position\n", files["chopping.hal"])  # point R
        self.assertIn("net x-position => square.x-position\n", files["squareness.hal"])
        self.assertLess(files["order.tcl"].index("  chop.update\n"), files["order.tcl"].index("  square.update\n"))

    @long
    def test_chopping_that_is_wired_later_gives_its_stroke_and_takes_it_away_with_it(self):
        alone = self.wired("squareness")
        self.assertEqual(self.missing(AT_REST, alone["squareness.hal"]), [])
        self.assertNotIn("stroked", alone["squareness.hal"])
        self.assert_stroking(self.wired("chopping"))
        status, output, _flat = plumb_wire("--remove", "chopping", "--ini", self.ini(AXIS_MM))
        self.assertEqual(status, 0, output)
        self.assertEqual(self.files()["squareness.hal"], alone["squareness.hal"])

    def test_chopping_that_is_wired_first_gives_its_stroke(self):
        self.wired("chopping")
        self.assert_stroking(self.wired("squareness"))

    @long
    def test_all_functions_of_this_axis_get_the_stroke_and_its_speed(self):
        files = self.wired("squareness", "thermal_displacement", "axis_growth", "chopping")
        speed = 2 * 30.48  # mm/s: joint and stroke, MAX_VELOCITY each
        self.assertEqual(self.missing([*STROKING, "setp square.max-speed %g\n" % speed], files["squareness.hal"]), [])
        grown = ("net z-stroked-position => axis-growth.z-position\n", "setp axis-growth.max-speed %g\n" % speed)
        self.assertEqual(self.missing(grown, files["axis_growth.hal"]), [])
        contacts = ("net z-stroked-joint-fb => growth.z-position\n", "net z-stroked-velocity => growth.z-velocity-cmd\n")
        self.assertEqual(self.missing(contacts, files["thermal_displacement.hal"]), [])
        self.assertNotIn("growth.z-motor-offset", files["thermal_displacement.hal"])  # the measured position of chopping lacks it
        behind = files["order.tcl"].rpartition("} {")[2].split()
        self.assertEqual(behind[0], "chop.update")


if __name__ == "__main__":
    unittest.main()

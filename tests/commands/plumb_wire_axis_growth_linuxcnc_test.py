#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire joins axis_growth, beside thermal_displacement, to a sample of LinuxCNC."""

import os
import unittest

from wire_sample import AXIS_MM, Sample, read


class AxisGrowth(Sample):
    def test_it_moves_each_axis_through_a_stage_and_thermal_displacement_measures_before_it(self):
        status, output, flat = self.wire(AXIS_MM, "axis_growth", "thermal_displacement")
        self.assertEqual(status, 0, output)
        for function, effect in (("axis_growth", "moves the drives of X, Y, Z"), ("thermal_displacement", "measured as")):
            seen = self.seen(output, function)
            self.assertTrue(any(effect in text for text in seen), output)
            self.assertTrue(all(seen.values()), output)
        self.assertRegex(flat, "Still missing.*growth-temperature-0.*plumb growth identify LOG")
        stages = read(os.path.join(self.folder(AXIS_MM), "stages.hal"))
        for axis in "xyz":
            self.assertRegex(stages, r"net %s-growth-offset +=> %s-stage.offset-0\n" % (axis, axis))
        # It is true in a pause, too, when the tool may be in the cut.
        self.assertRegex(stages, r"net program-running +linuxcnc-alive.program-running\b")
        self.assertRegex(read(os.path.join(self.folder(AXIS_MM), "axis_growth.hal")), r"net program-running +=> axis-growth.cycle-running\n")
        growth = read(os.path.join(self.folder(AXIS_MM), "thermal_displacement.hal"))
        self.assertRegex(growth, r"net \S+ +=> growth.z-position\n")


if __name__ == "__main__":
    unittest.main()

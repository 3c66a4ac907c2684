#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire joins thermal_growth_test to a sample of LinuxCNC."""

import os
import unittest

from wire_sample import AXIS_MM, Sample, read, write


class GrowthTest(Sample):
    def test_a_program_begins_a_test_and_the_rest_is_named(self):
        status, output, flat = self.wire(AXIS_MM, "thermal_growth_test")
        self.assertEqual(status, 0, output)
        seen = self.seen(output, "thermal_growth_test")
        self.assertTrue(any("begins a test" in text for text in seen), output)
        self.assertTrue(all(seen.values()), output)
        self.assertIn("num_dio=32 num_aio=5", flat)
        self.assertRegex(flat, "Still missing.*probe-trips.*x-measured.*compensation-on.*plumb/growth.toml.*growth_bore")
        self.assertIn("loadusr -W growth_log --file $(CONFIG_DIR)/plumb/growth.toml\n", read(os.path.join(self.folder(AXIS_MM), "retain.hal")))
        names = os.listdir(self.folder(AXIS_MM))
        self.assertLessEqual({"growth_test.ngc", "growth_visit.ngc", "thermal_growth_test_settings.hal", "growth.toml"}, set(names))
        bores = os.path.join(self.folder(AXIS_MM), "growth.toml")
        self.assertIn("unit    = 1\n", read(bores))
        own = read(bores) + "[[bore]]\nnumber = 1\nx = 0\ny = -60\nz = 60\n"
        write(bores, own)
        status, output, flat = self.wire(AXIS_MM, "thermal_growth_test")
        self.assertEqual(status, 0, output)
        self.assertIn("growth.toml (yours, not written)", flat)
        self.assertEqual(read(bores), own)


if __name__ == "__main__":
    unittest.main()

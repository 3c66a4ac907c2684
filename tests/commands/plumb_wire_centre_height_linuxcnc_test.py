#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire joins centre_height, beside squareness, to a sample of LinuxCNC."""

import os
import re
import unittest

from wire_sample import AXIS_MM, Sample, read


class Works(Sample):
    def test_height_of_entered_lands_permits_the_move_of_y(self):
        status, output, flat = self.wire(AXIS_MM, "squareness", "centre_height")
        self.assertEqual(status, 0, output)
        seen = self.seen(output, "centre_height")
        self.assertTrue(any("50 um high give 50.000 um" in text for text in seen), output)
        self.assertTrue(all(seen.values()), output)
        self.assertIn("[EMCMOT] EMCMOT = motmod num_dio=15 num_aio=23", flat)
        self.assertRegex(flat, r"USER_M_PATH = \S*functions/centre_height .*REMAP = M450 modalgroup=10 .*REMAP = M455 .*Still missing")
        hal = read(os.path.join(self.folder(AXIS_MM), "stages.hal"))
        self.assertRegex(hal, r"net height-on +interlock\.function-enable-1")
        names = os.listdir(self.folder(AXIS_MM))
        self.assertLessEqual({"m450.ngc", "m454.ngc", "height_abort.ngc", "centre_height_settings.hal"}, set(names))
        self.assertTrue(re.search("height_abort", read(os.path.join(self.folder(AXIS_MM), "plumb_abort.ngc"))))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire chopping on a sample of LinuxCNC in inches: the axis strokes, and its stage lets the stroke through."""

import os
import unittest

from long import long
from wire_sample import Sample, read, write

INCH = "sim/axis/axis.ini"
FORMER = ("REMAP = G81.1 modalgroup=1 argspec=ZQrp ngc=g811", "REMAP = G80.1 modalgroup=1 ngc=g801")


class Chopping(Sample):
    def test_it_strokes_through_a_stage_with_room_and_the_limits_of_the_joint(self):
        text = read(self.ini(INCH))  # wired by an earlier version
        write(self.ini(INCH), text.replace("[RS274NGC]\n", "[RS274NGC]\n%s\n%s\n" % FORMER, 1))
        status, output, flat = self.wire(INCH, "chopping")
        self.assertEqual(status, 0, output)
        seen = self.seen(output, "chopping")
        for word in ("G20", "G21"):
            self.assertTrue(any(word + " G81.1: Z strokes by" in text for text in seen), output)
        self.assertTrue(all(seen.values()), output)
        self.assertIn("num_dio=19 num_aio=21", flat)
        self.assertRegex(flat, "REMAP = G81.1 modalgroup=1 .*REMAP = G80.1 .*Still missing.*FERROR.*chopping_settings.hal")
        patch = read(os.path.join(self.folder(INCH), "ini.patch"))
        for line in FORMER:
            self.assertIn("-%s\n" % line, patch)
        self.assertIn("+REMAP = G81.1 modalgroup=1 argspec=ZQrpij", patch)
        self.assertIn('bound = true\nrecords = ["chop"]', read(os.path.join(self.folder(INCH), "retain.toml")))
        stages = read(os.path.join(self.folder(INCH), "stages.hal"))
        self.assertIn("setp z-stage.max-offset 8.12\n", stages)  # the travel of Z
        self.assertEqual(stages.count("z-stage.offset-acceleration"), 1)
        for line in (
            "setp interlock.function-services-0 51",
            "setp interlock.function-urgent-0 48",
            "net chop-state => interlock.function-state-0",
            "net task-state linuxcnc-alive.task-state => interlock.service-state-4",
        ):
            self.assertIn(line + "\n", stages)
        function = read(os.path.join(self.folder(INCH), "chopping.hal"))
        self.assertIn("setp chop.max-limit [JOINT_2]MAX_LIMIT\n", function)
        self.assertIn("setp chop.max-rate [JOINT_2]MAX_VELOCITY\n", function)
        settings = read(os.path.join(self.folder(INCH), "chopping_settings.hal"))
        self.assertIn("setp chop.max-feed           %.6g\n" % (0.8 * 5), settings)  # of MAX_VELOCITY
        self.assertIn("setp chop.max-acceleration  %.6g\n" % (0.5 * 50), settings)

    @long
    def test_the_axis_that_the_ini_file_names_feeds_in_by_a_stage_of_its_own(self):
        text = read(self.ini(INCH))
        write(self.ini(INCH), text + "\n[CHOPPING]\nSECTIONS = 0\nINFEED = 1\nINFEED_AXIS = Y\n")
        status, output, _flat = self.wire(INCH, "chopping")
        self.assertEqual(status, 0, output)
        stages, function = (read(os.path.join(self.folder(INCH), name)) for name in ("stages.hal", "chopping.hal"))
        for line in ("net y-infeed => y-stage.offset-0", "net y-applied-offset y-stage.applied-offset", "net y-measured joint.1.pos-fb"):
            self.assertIn(line + "\n", stages)
        for line in (
            "net y-infeed chop.infeed-offset",
            "net y-applied-offset => chop.infeed-applied",
            "net y-measured => chop.infeed-feedback",
            "setp chop.infeed-max-limit [JOINT_1]MAX_LIMIT",
        ):
            self.assertIn(line + "\n", function)
        self.assertNotIn("x-stage", stages)


if __name__ == "__main__":
    unittest.main()

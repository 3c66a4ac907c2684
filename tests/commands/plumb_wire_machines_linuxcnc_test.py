#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on samples of LinuxCNC that are read in other ways: TWOPASS, Tcl, drivers, other kinematics."""

import os
import unittest

import wire_samples
from wire_sample import Sample, read

TWOPASS = "sim/axis/simtcl/twopass_basic.ini"
FIVE_AXES = "sim/axis/vismach/5axis/table-rotary-tilting/xyzac-trt.ini"
MESA = "by_interface/mesa/hm2-servo/5i20.ini"


class Machines(Sample):
    def test_twopass_with_tcl_files_and_includes(self):
        status, output, _ = self.wire(TWOPASS, "squareness")
        self.assertEqual(status, 0, output)
        self.assertTrue(all(holds for holds, _ in wire_samples.statements(output)), output)

    def test_drivers_are_named_and_stood_in_for(self):
        status, output, flat = self.wire(MESA, "squareness")
        self.assertEqual(status, 0, output)
        self.assertIn("These drivers need hardware. Pins stand in for them here: hostmot2, hm2_pci.", flat)
        self.assertRegex(flat, r"ok \d+ functions stand around motion-controller in servo-thread")

    def test_kinematics_need_the_joints_to_be_named(self):
        status, _, flat = self.wire(FIVE_AXES, "squareness")
        self.assertEqual(status, 1)
        self.assertIn("No joint is known for the axis X and Y and Z", flat)
        self.assertIn("--joints X=0,Y=1,Z=2", flat)
        status, output, _ = self.wire(FIVE_AXES, "squareness", "--joints", "X=0,Y=1,Z=2")
        self.assertEqual(status, 0, output)
        # A HALCMD line of this machine gives the tool offset a signal later: ours is the same.
        function = read(os.path.join(self.folder(FIVE_AXES), "squareness.hal"))
        self.assertIn("net :tool-offset motion.tooloffset.z => square.z-tool-offset\n", function)


if __name__ == "__main__":
    unittest.main()

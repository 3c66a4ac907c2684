#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on samples of LinuxCNC that are read in other ways: TWOPASS, Tcl, drivers, other kinematics."""

import os
import re
import unittest

import wire_samples
from long import long
from tree import own_folder
from wire_sample import Sample, read, write

TWOPASS = "sim/axis/simtcl/twopass_basic.ini"
FIVE_AXES = "sim/axis/vismach/5axis/table-rotary-tilting/xyzac-trt.ini"
MESA = "by_interface/mesa/hm2-servo/5i20.ini"


class Machines(Sample):
    def test_twopass_with_tcl_files_and_includes(self):
        home = own_folder(self)
        os.mkdir(os.path.join(home, ".local"))  # which a trial cannot write, and plumb-retain counts there outside of one
        status, output, _ = self.wire(TWOPASS, "squareness", HOME=home)
        self.assertEqual(os.listdir(os.path.join(home, ".local")), [])
        self.assertEqual(status, 0, output)
        self.assertTrue(all(holds for holds, _ in wire_samples.statements(output)), output)

    def test_drivers_are_named_and_stood_in_for(self):
        status, output, flat = self.wire(MESA, "squareness")
        self.assertEqual(status, 0, output)
        self.assertIn("These drivers need hardware. Pins stand in for them here: hostmot2, hm2_pci.", flat)
        self.assertRegex(flat, r"ok \d+ functions stand around motion-controller in servo-thread")

    @long
    def test_kinematics_need_the_joints_to_be_named(self):
        status, _, flat = self.wire(FIVE_AXES, "squareness")
        self.assertEqual(status, 1)
        self.assertIn("No joint is known for the axis X and Y and Z", flat)
        self.assertIn("--joints X=0,Y=1,Z=2", flat)
        # The trial has the rotary axes in the chain.
        write(self.ini(FIVE_AXES), read(self.ini(FIVE_AXES)) + "\n[SQUARENESS]\nCHAIN = w-C-A-Y.b-X-Z-t\nROTARY = AC\nTABLE = none\n")
        status, output, flat = self.wire(FIVE_AXES, "squareness", "--joints", "X=0,Y=1,Z=2,A=3,C=4")
        self.assertEqual(status, 0, output)
        self.assertNotIn("[SQUARENESS]ROTARY names", flat)
        # A HALCMD line of this machine gives the tool offset a signal later: ours is the same.
        function = read(os.path.join(self.folder(FIVE_AXES), "squareness.hal"))
        self.assertIn("net :tool-offset motion.tooloffset.z => square.z-tool-offset\n", function)
        stages = read(os.path.join(self.folder(FIVE_AXES), "stages.hal"))
        for letter, joint in (("a", 3), ("c", 4)):
            for pin, of_joint in (("position", "pos-cmd"), ("velocity", "vel-cmd")):
                signal = re.search(r"(?m)^net (\S+) => square\.%s-%s$" % (letter, pin), function)[1]
                self.assertRegex(stages, r"(?m)^net %s joint\.%d\.%s$" % (re.escape(signal), joint, of_joint))
        self.assertNotIn("square.b-position", function)
        self.assertNotIn("a-stage", stages)


if __name__ == "__main__":
    unittest.main()

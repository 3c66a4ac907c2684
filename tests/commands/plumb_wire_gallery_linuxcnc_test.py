#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on two of the machines in tests/specimens/machines; scripts/wire-samples has all of them."""

import os
import re
import shutil
import unittest

import wire_samples
from long import long
from tree import own_folder
from wire_sample import read, write


class Gallery(unittest.TestCase):
    def run_on(self, name, edit=lambda folder: None):
        """The run of the one INI file of a machine, and the files that it wrote."""
        root = own_folder(self)
        folder = os.path.join(root, "gallery")
        shutil.copytree(os.path.join(wire_samples.GALLERY, name), folder)
        edit(folder)
        ((ini, functions, options, _),) = wire_samples.described(folder)
        files = {}
        keep = lambda own: files.update({each: read(os.path.join(own, each)) for each in os.listdir(own)})  # noqa: E731
        run = wire_samples.Run(root, ini, functions, options, keep)
        self.assertEqual((run.status, run.undone, run.changed), (0, "yes", []), run.output)
        self.assertLess(run.megabytes, 10)
        return " ".join(run.output.split()), files

    def test_an_inch_lathe_without_y_asks_for_a_shim(self):
        flat, files = self.run_on("inch_lathe")
        self.assertRegex(flat, "ok centre_height: after a check, a shim raises the tool by -50.000 um")
        self.assertIn("33 + NUM_DIO = 15 34 + NUM_AIO = 24 ", flat)  # which its loadrt line names
        self.assertRegex(flat, "This machine has no Y. Two cuts .M450 P0 Q2. give X of the tool")
        self.assertIn("\nsetp centre.without-y 1\n", files["centre_height.hal"])
        self.assertIn("net y-tool-offset motion.tooloffset.y => motion.analog-in-13\n", files["centre_height.hal"])
        self.assertNotIn("centre.y-position", files["centre_height.hal"])

    @long
    def test_functions_take_outputs_that_neither_hal_nor_a_subroutine_uses(self):
        flat, files = self.run_on("many_functions")
        self.assertIn("These modules are not installed here or need hardware. Pins stand in for them here: acme_io.", flat)
        self.assertIn("net y8-stage-state y8-stage.state => interlock.stage-state-14\n", files["stages.hal"])
        self.assertIn("net z-stage-state z-stage.state => interlock.stage-state-15\n", files["stages.hal"])
        self.assertIn("net z-axis-stage-state z-axis-stage.state => interlock.stage-state-16\n", files["stages.hal"])
        self.assertIn("motion.digital-out-16 keeps your signal vacuum; chopping takes motion.digital-out-06", flat)
        self.assertRegex(flat, "motion.analog-out-18 is in use by lamp.ngc; chopping takes motion.analog-out-[0-9]+")
        self.assertRegex(flat, "M68 E1 Q10 before an operation")  # operation-key, for the user's program
        self.assertIn("net chop-run motion.digital-out-06 => chop.run\n", files["chopping.hal"])
        self.assertIn("\nCHOP_RUN = 6\n", files["plumb.inc"])
        self.assertIn("#<_chop_run_output>       = #<_ini[PLUMB_NUMBERS]CHOP_RUN>\n", files["chop_numbers.ngc"])

    @long
    def test_a_servo_with_mesa_gets_the_velocity_of_the_offset(self):
        flat, files = self.run_on("mesa_7i76e")
        self.assertRegex(flat, "pid.x.command-deriv has the velocity of the offset in it")
        self.assertNotRegex(flat, "Still missing.*spindle-load")  # by the page of its driver, gs2_vfd writes it
        self.assertIn("net x-vel-cmd x-stage.drive-velocity\n", files["stages.hal"])
        self.assertIn("unlinkp joint.0.vel-cmd\n", files["stages.hal"])
        self.assertFalse(re.search(r"^setp interlock.function-switch", files["stages.hal"], re.M))

    @long
    def test_a_pid_without_the_velocity_of_the_stroke_is_measured_and_named(self):
        flat, _ = self.run_on("servo_pid")
        follows = r"the drive follows the strokes within ([\d.]+) mm"
        self.assertLess(float(re.search(follows, flat)[1]), 0.005)
        self.assertNotIn("lacks the velocity", flat)

        def through_a_gain(folder):
            path = os.path.join(folder, "servo.hal")
            text = read(path).replace("vel-cmd => pid-z.command-deriv", "vel-cmd => z-ff.in\nnet z-ff z-ff.out => pid-z.command-deriv")
            text = text.replace("loadrt integ", "loadrt scale names=z-ff\nloadrt integ").replace("setp pid-z.FF1 1\n", "setp pid-z.FF1 1\nsetp z-ff.gain 1\n")
            write(path, text.replace("addf pid-z.do", "addf z-ff servo-thread\naddf pid-z.do"))

        flat, _ = self.run_on("servo_pid", through_a_gain)
        self.assertGreater(float(re.search(follows, flat)[1]), 0.02)
        self.assertIn("pid-z.command-deriv lacks the velocity of the stroke: net z-stage.drive-velocity to it", flat)


if __name__ == "__main__":
    unittest.main()

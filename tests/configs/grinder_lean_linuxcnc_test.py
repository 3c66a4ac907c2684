#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The grinder on a column that leans by 100 um/m: plumb wire joins chopping and squareness to it, and the true path of the wheel is measured."""

import os
import unittest

import linuxcnc_runs
import numpy as np
from linuxcnc_runs import own_folder, read_recording, um
from long import long
from starts import starts
from wire_sample import plumb_wire, read, write

LEAN = 1e-4  # rad, of Z towards +X
STROKE = 400  # mm
CORRECTS, AT_POINT_R = 40, 99  # square.status-code

HAL = """[HAL]
HALUI = halui
HALFILE = common/motion.hal
HALFILE = z_joint.hal
HALFILE = common/iocontrol.hal
HALFILE = rigid.hal
HALFILE = common/spindle.hal
"""
# Its drives follow 3 ms behind, and the heavy one of Z 10 ms.
MACHINE = """loadrt lowpass names=x-drive,y-drive,z-drive
setp x-drive.gain 0.283469
setp y-drive.gain 0.283469
setp z-drive.gain 0.0951626
net x-motor-cmd joint.0.motor-pos-cmd => x-drive.in
net y-motor-cmd joint.1.motor-pos-cmd => y-drive.in
net z-motor-cmd => z-drive.in
net x-motor-fb x-drive.out => joint.0.motor-pos-fb
net y-motor-fb y-drive.out => joint.1.motor-pos-fb
net z-motor-fb z-drive.out
addf x-drive servo-thread
addf y-drive servo-thread
addf z-drive servo-thread
"""
SETTINGS = """setp interlock.commissioning false
setp interlock.function-switch-0 1
setp interlock.function-switch-1 1
setp square.eb0z 0.0001
"""


@long
class Lean(unittest.TestCase):
    """Functions in this order of wiring."""

    functions = ("squareness", "chopping")

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("grinder", folder)
        ini = os.path.join(machine, "grinder.ini")
        write(ini, read(ini).replace("#INCLUDE chop.inc\n", "").replace("#INCLUDE grinder_hal.inc\n", HAL))
        write(os.path.join(machine, "rigid.hal"), MACHINE)
        linuxcnc_runs.change(os.path.join(machine, "z_axis.inc"), "MIN_LIMIT = -300", "MIN_LIMIT = -2000")  # room for the taper of the stage
        write(os.path.join(machine, "lean.hal"), SETTINGS)
        for function in cls.functions:
            status, output, _flat = plumb_wire(function, "--ini", ini, "--apply")
            assert status == 0, output
        ini = linuxcnc_runs.own_ini(ini, HAL=linuxcnc_runs.at_the_end("HALFILE = lean.hal"))
        its, cls.output = linuxcnc_runs.work(folder, ini, "grinder_lean_scenario.py")
        cls.facts = its["facts"]
        cls.recorded = read_recording(os.path.join(machine, "lean.csv"))
        cls.rows = linuxcnc_runs.rows_of(cls.recorded, its["scenes"])

    def of(self, pin, scene):
        rows = self.rows[scene]
        if scene != "moved":
            rows = rows[(self.recorded["chop.stroking"][rows] == 1) & (self.recorded["chop.stroke-count"][rows] >= 1)]
        return self.recorded[pin][rows]

    def crooked(self, scene):
        """How far the true path of the wheel is from a straight line along Z, in mm."""
        z = self.of("z-drive.out", scene)
        self.assertGreater(np.ptp(z), STROKE - 10, scene)
        return np.ptp(self.of("x-drive.out", scene) + LEAN * z)

    def test_table(self):
        print("\npath of the wheel, um: %s" % ", ".join("%s %.2f" % (scene, self.crooked(scene) / um) for scene in ("moved", "stroked", "at_point_r", "mended")))

    def test_linuxcnc_has_the_axis_at_point_r_and_the_contour_goes_on(self):
        self.assertEqual(np.ptp(self.of("joint.2.pos-cmd", "stroked")), 0)
        self.assertGreater(np.ptp(self.of("joint.1.pos-cmd", "stroked")), 20)

    def test_without_the_stroke_in_its_position_squareness_leaves_the_lean_and_says_so(self):
        self.assertGreater(self.crooked("at_point_r"), 0.95 * LEAN * STROKE)
        status = self.of("square.status-code", "at_point_r")
        self.assertEqual(set(status[2000:]), {AT_POINT_R})
        self.assertIn("square.z-position has joint.2.pos-cmd, which lacks the stroke of chop", self.facts["told"])

    def test_as_it_is_wired_the_path_is_as_straight_as_in_moves_of_linuxcnc(self):
        for scene in ("stroked", "mended"):
            self.assertLess(self.crooked(scene), self.crooked("moved") + 0.1 * um, scene)
            self.assertLess(self.crooked(scene), 0.5 * um, scene)
        self.assertEqual(set(self.of("square.status-code", "stroked")), {CORRECTS})
        self.assertEqual(self.of("square.status-code", "mended")[-1], CORRECTS)


class ChoppingFirst(Lean):
    functions = ("chopping", "squareness")


tearDownModule = starts("grinder/grinder.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Lean, __doc__)

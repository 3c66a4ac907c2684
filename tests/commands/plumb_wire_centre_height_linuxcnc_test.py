#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire joins centre_height, beside squareness, to a sample of LinuxCNC."""

import math
import os
import re
import shutil
import subprocess
import unittest

import wire_samples
from long import long
from tree import BUILD, ROOT, own_folder
from wire_sample import AXIS_MM, Sample, plumb_wire, read, write


# A tip 0.02 mm too far out and 0.4 mm too low: diameters of cuts at X 5, 0.6 and 0.5, as a radius in millimetres.
# Two of them could have a burr, by the settings that plumb wire writes; the third one shows that they have none.
DIAMETERS = [2 * math.hypot(x + 0.02, 0.4) for x in (5, 0.6, 0.5)]
LATHE = """\
G18 G21 G8 G90 G94
T1 M6 G43
G0 X10 Z0
M450 P0 Q2 D10 E10.6
G1 X5 F2000
M451
M452 P%.6f
G1 X0.6
M451
M452 P%.6f
M454 D0.1
G1 X0.5
M451
M452 P%.6f
M454 D0.1
M455 D10 Z58 K4 E10.6 Q2 P200 R10
M2
"""


def inches(x):
    """A tip 0.0008 in too far out and 0.016 in too low: the diameter of a cut at this X, a radius."""
    return 2 * math.hypot(x + 0.0008, 0.016)


# In inches and diameters. Three cuts so close together show no X, and further ones do not help: the program goes on.
INCH = """\
G18 G20 G7 G90 G94
T1 M6 G43
G0 X0.8 Z0
M450 P0 Q3 E0.42
G1 X0.4 F80
M451
M452 P%.7f
G1 X0.39
M451
M452 P%.7f
G1 X0.38
M451
M452 P%.7f
M454 D0.004
G0 X0.8
M450 P0 Q3 D0.4 E0.42
G1 X0.4
M451
M452 P%.7f
G1 X0.05
M451
M452 P%.7f
G1 X0.04
M451
M452 P%.7f
M454 D0.004
G0 X0.8
M2
""" % tuple(map(inches, (0.2, 0.195, 0.19, 0.2, 0.025, 0.02)))


@long
class Lathe(unittest.TestCase):
    def test_without_y_cuts_in_inches_and_in_millimetres_correct_x_and_the_lands_of_m455_are_refused(self):
        folder = os.path.join(own_folder(self), "lathe")
        shutil.copytree(os.path.join(wire_samples.GALLERY, "inch_lathe"), folder)
        ini = os.path.join(folder, "lathe.ini")
        write(os.path.join(folder, "tool.tbl"), "T1 P1 X+1.0 Z+0 D+0.1 ;turning tool\n")
        write(os.path.join(folder, "cuts.ngc"), LATHE % tuple(DIAMETERS))
        write(os.path.join(folder, "inch.ngc"), INCH)
        write(os.path.join(folder, "on.hal"), "setp interlock.function-switch-0 1\nsetp interlock.commissioning 0\n")
        status, output, _ = plumb_wire("centre_height", "--ini", ini, "--apply")
        self.assertEqual(status, 0, output)
        text = read(ini).replace("DISPLAY = axis", "DISPLAY = " + os.path.join(ROOT, "configs", "common", "headless.py"))
        write(ini, text.replace("HALFILE = plumb/order.tcl", "HALFILE = plumb/order.tcl\nHALFILE = on.hal"))
        command = [os.path.join(BUILD, "bin", "plumb"), "run", "--speed", "5", "--", "linuxcnc", "-r", ini, "inch.ngc", "cuts.ngc"]
        done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.assertIn("The height is not known well enough.", done.stdout + done.stderr)
        self.assertIn("X of the tool is wrong.", done.stdout + done.stderr)
        self.assertIn("M455 moves Y, which this machine does not have", done.stdout + done.stderr)
        # The tip that turns 0.4 in, then the tip that turns 10 mm, each at its height.
        by_inches = math.sqrt(0.2**2 - 0.016**2) - 0.2008
        by_millimetres = (math.sqrt(5**2 - 0.4**2) - 5.02) / 25.4
        stored = float(re.search(r"X\+?([\d.]+)", read(os.path.join(folder, "tool.tbl")))[1])
        self.assertAlmostEqual(stored, 1 + by_inches + by_millimetres, delta=4e-6)
        self.assertIn("more cuts do not help; nothing is stored", done.stdout + done.stderr)
        self.assertIn("Cut a third time with a shim below the tool", done.stdout + done.stderr)
        self.assertNotIn("step of Y", done.stdout + done.stderr)


class Works(Sample):
    def test_height_of_entered_lands_permits_the_move_of_y(self):
        status, output, flat = self.wire(AXIS_MM, "squareness", "centre_height")
        self.assertEqual(status, 0, output)
        seen = self.seen(output, "centre_height")
        self.assertTrue(any("50 um high give 50.000 um" in text for text in seen), output)
        self.assertTrue(all(seen.values()), output)
        self.assertIn("[EMCMOT] EMCMOT = motmod num_dio=15 num_aio=24", flat)
        self.assertRegex(flat, r"USER_M_PATH = \S*functions/centre_height .*REMAP = M450 modalgroup=10 .*REMAP = M455 .*Still missing")
        hal = read(os.path.join(self.folder(AXIS_MM), "stages.hal"))
        self.assertRegex(hal, r"net height-permit interlock\.function-permit-1")
        names = os.listdir(self.folder(AXIS_MM))
        self.assertLessEqual({"m450.ngc", "m454.ngc", "height_abort.ngc", "centre_height_settings.hal"}, set(names))
        self.assertTrue(re.search("height_abort", read(os.path.join(self.folder(AXIS_MM), "plumb_abort.ngc"))))


if __name__ == "__main__":
    unittest.main()

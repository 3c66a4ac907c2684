#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The user's whole way on an inch machine: plumb wire --apply, plumb commission, a restart, and changes by hand afterwards."""

import os
import re
import shutil
import unittest

import linuxcnc_runs
from long import long
from tree import ROOT
from wire_sample import Sample, plumb_wire, read, write

INCH = "sim/axis/axis.ini"
HELD, STAGE_HELD, ACTS = 12, 13, 0  # function-status
CORRECTION = 0.00016 * 2  # in, at Z-2


@long
class Wired(Sample):
    def test_an_inch_machine_is_wired_commissioned_and_started_again(self):
        ini = self.ini(INCH)
        status, output, flat = plumb_wire("squareness", "--ini", ini, "--apply")
        self.assertEqual(status, 0, output)
        self.assertIn("plumb commission squareness", flat)
        settings = os.path.join(self.folder(INCH), "squareness_settings.hal")
        write(settings, read(settings) + "setp square.eb0z 0.00016\n")
        text = re.sub(r"(?m)^DISPLAY *=.*", "DISPLAY = " + os.path.join(ROOT, "configs", "common", "headless.py"), read(ini))
        text = text.replace("[EMCMOT]", "[EMCMOT]\nCOMM_TIMEOUT = 300", 1)
        write(ini, text.replace("HALFILE = plumb/order.tcl", "HALFILE = plumb/order.tcl\nHALFILE = scene.hal"))
        write(os.path.join(os.path.dirname(ini), "scene.hal"), "newsig scene s32\n" + "".join("setp interlock.service-timeout-%d 60\n" % n for n in range(6)))

        first = self.start("first")
        self.assertEqual(first["before"][0], STAGE_HELD)
        self.assertEqual(first["before"][1], 0)
        self.assertTrue(first["robot"]["passed"], first["robot"])
        self.assertIn("x-stage moves X by +0.010 mm (0.00039 in)", first["robot"]["titles"])
        self.assertRegex(first["robot"]["sheet"], r"0\.000\d+ in")
        self.acts(first["after"])

        self.assertIn("signed by robot", read(os.path.join(self.folder(INCH), "commissioned.json")).replace('"who": "robot"', "signed by robot"))
        again = self.start("again")
        self.acts(again["before"])
        self.assertIn("function square: passed on", again["doctor"])
        self.assertIn("signed by robot", again["doctor"])
        self.assertNotIn("WRONG", again["doctor"])
        for what, held in (("wrong identity", STAGE_HELD), ("swapped", HELD)):
            self.assertEqual(again[what], [held, 0], what)
        self.assertRegex(" ".join(again["doctor of swapped"].split()), "function square passed on .* and is held: its wiring or a sign changed since.*new: .*y-stage")
        self.assertEqual(again["by hand"][0], ACTS)
        self.assertIn("no record says by whom", again["doctor of by hand"])
        self.acts(again["after"])

        shutil.rmtree(os.path.join(os.path.dirname(self.samples), "home"))  # as on another computer, to which the folder was copied
        moved = self.start("moved")
        self.assertIn("commissioned: The store is an old copy", self.output)
        self.assertEqual(moved["before"], [STAGE_HELD, 0])
        for store in ("commissioned", "panel-settings"):
            self.assertRegex(" ".join(moved["doctor"].split()), "WRONG %s: The store is an old copy, or another user's.* plumb commission --accept" % store)
        self.assertEqual(moved["accept"], "What passed counts again on this computer.\n")
        self.acts(moved["after"])
        self.acts(self.start("stays")["before"])

    def acts(self, found):
        self.assertEqual(found[0], ACTS, found)
        self.assertAlmostEqual(found[1], CORRECTION, delta=1e-7)

    def start(self, part):
        folder = os.path.dirname(self.samples)
        facts, self.output = linuxcnc_runs.work(folder, self.ini(INCH), "commission_wired_scenario.py", part)
        return facts["facts"]


if __name__ == "__main__":
    unittest.main()

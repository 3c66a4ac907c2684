# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench-configs names the machines of a folder that run, their models, and the reason for each other machine."""

import os
import subprocess
import sys
import unittest

from tree import ROOT, own_folder

INI = """[EMC]
VERSION = 1.1
[KINS]
KINEMATICS = trivkins coordinates=X
JOINTS = 1
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
[HAL]
HALFILE = machine.hal
"""
# Before LinuxCNC 2.8, joints had the pins axis.N.
OLD = """[EMC]
MACHINE = old
[DISPLAY]
DISPLAY = axis
[TASK]
TASK = milltask
[RS274NGC]
PARAMETER_FILE = old.var
[EMCMOT]
EMCMOT = motmod
[HAL]
HALFILE = machine.hal
[TRAJ]
AXES = 1
COORDINATES = X
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
[EMCIO]
EMCIO = io
[AXIS_0]
TYPE = LINEAR
HOME = 0
MAX_VELOCITY = 1
MAX_ACCELERATION = 1
MIN_LIMIT = -1
MAX_LIMIT = 1
"""
HAL = "loadrt trivkins coordinates=X\nloadrt motmod servo_period_nsec=1000000 num_joints=1\naddf motion-controller servo-thread\n"
# Neither pin says its type: the pages of or2 and estop_latch do.
CARD = """loadrt or2
loadrt estop_latch names=latch
loadrt hostmot2
loadrt hm2_eth board_ip=192.0.2.1
net pressed or2.0.out => hm2_7i92.0.stbl.1.3.thing
net seen hm2_7i92.0.stbl.1.3.other => latch.fault-in
"""


class Collection(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)

    def machine(self, name, hal, ini=INI):
        os.makedirs(os.path.join(self.folder, name))
        for file, text in (("machine.ini", ini), ("machine.hal", HAL + hal)):
            with open(os.path.join(self.folder, name, file), "w", encoding="utf-8") as out:
                out.write(text)

    def told(self, *words):
        script = os.path.join(ROOT, "scripts", "bench_configs.py")
        words = [sys.executable, script, "--for", "10ms", *words, self.folder]
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=200, check=False)
        return done.returncode, done.stdout, done.stderr

    def test_each_machine_is_told_with_its_models_or_the_reason(self):
        self.machine("card", CARD)
        self.machine("old", "net home axis.0.home-sw-in\n", OLD)
        self.machine("plain", "")
        self.machine("wrong", "net home joint.0.home-switch\n")
        self.machine("no_machine", "", "[DISPLAY]\nDISPLAY = axis\n")
        status, told, errors = self.told()
        self.assertEqual((status, errors), (0, ""))
        self.assertRegex(told, r"(?m)^card/machine.ini +[\d.]+ s  runs with .*hostmot2$")
        self.assertRegex(told, r"(?m)^old/machine.ini +[\d.]+ s  runs with .*; converted by update_ini$")
        self.assertRegex(told, r"(?m)^plain/machine.ini +[\d.]+ s  runs with ")
        self.assertRegex(told, r"(?m)^wrong/machine.ini +[\d.]+ s  DOES NOT RUN: machine.hal:4: .*joint.0.home-switch")
        self.assertNotIn("no_machine", told)
        self.assertIn("\n3 of 4 machines run", told)
        self.assertRegex(told, r"(?m)^ +1 with model hostmot2$")

    def test_a_machine_that_does_not_end_is_one_that_does_not_run_and_files_stay_as_they_are(self):
        self.machine("stuck", "loadusr -w sleep 1000\n", OLD)
        status, told, _ = self.told("--limit", "4")
        self.assertEqual(status, 1)
        self.assertRegex(told, r"DOES NOT RUN: not ended after 4 s\n")
        self.assertEqual(sorted(os.listdir(os.path.join(self.folder, "stuck"))), ["machine.hal", "machine.ini"])
        with open(os.path.join(self.folder, "stuck", "machine.ini"), encoding="utf-8") as file:
            self.assertEqual(file.read(), OLD)

    def test_a_folder_without_machines_is_refused(self):
        status, _, errors = self.told()
        self.assertEqual(status, 2)
        self.assertIn("no INI file there names a HALFILE", errors)


if __name__ == "__main__":
    unittest.main()

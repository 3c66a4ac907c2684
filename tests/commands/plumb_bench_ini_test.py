# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb bench --ini loads the machines of LinuxCNC's sample configurations. PLUMB_BUILD names the build folder."""

import csv
import os
import shutil
import subprocess
import unittest

from tree import BUILD, own_folder

PLUMB = os.path.join(BUILD, "bin", "plumb")
SAMPLES = "/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis"
OWN = """[KINS]
KINEMATICS = trivkins coordinates=X
JOINTS = 1
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
[HAL]
HALFILE = first.hal
HALFILE = second.tcl 5
HALCMD = setp scale.offset 1000
#INCLUDE joint.inc
"""
FILES = {
    "own.ini": OWN,
    "joint.inc": "[JOINT_0]\nGAIN = 3\n",
    "first.hal": "loadrt [KINS]KINEMATICS\nloadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS\n"
    "loadrt scale names=scale\nsetp scale.gain [JOINT_0]GAIN\naddf motion-controller servo-thread\naddf scale servo-thread\n"
    "net tool iocontrol.0.tool-prepare => iocontrol.0.tool-prepared\nnet out scale.out\n",
    # The second file finds the first one's signal, and the variables of LinuxCNC's script.
    "second.tcl": "setp scale.in [expr {[lindex $argv 0] + $::JOINT_0(GAIN)}]\n"
    "source [file join $::env(HALLIB_DIR) util_lib.tcl]\n"
    "loadrt constant names=[file rootname [file tail $::env(INI_FILE_NAME)]]\n",
}


class WholeMachine(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)

    def bench(self, *words):
        words = [PLUMB, "bench", *words]
        return subprocess.run(words, cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False)

    def copy(self, name):
        """A folder of samples: its Tcl files write beside the INI file."""
        return shutil.copytree(os.path.join(SAMPLES, name), os.path.join(self.folder, "samples", name))

    def machine(self, **others):
        os.makedirs(os.path.join(self.folder, "machine"))
        for name, text in {**FILES, **others}.items():
            with open(os.path.join(self.folder, "machine", name), "w", encoding="utf-8") as file:
                file.write(text)
        return "machine/own.ini"

    def test_its_files_are_loaded_in_order_in_the_folder_of_the_ini_file(self):
        record = ("--record", "scale.out,own.value,motion.motion-enabled", "--every", "1ms", "--output", "out.csv")
        done = self.bench("--ini", self.machine(), "--for", "5ms", *record)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(self.folder, "out.csv"), encoding="utf-8") as file:
            last = list(csv.DictReader(file))[-1]
        self.assertEqual(float(last["scale.out"]), 3 * (5 + 3) + 1000)
        self.assertEqual(float(last["motion.motion-enabled"]), 0)
        self.assertIn("joints stand: no task", done.stderr)
        self.assertNotIn("user-space programs took part", done.stderr)

    def test_a_missing_file_and_a_failing_one_are_named(self):
        done = self.bench("--ini", self.machine(**{"own.ini": OWN.replace("first.hal", "gone.hal")}), "--for", "5ms")
        self.assertEqual(done.returncode, 1)
        self.assertIn("HALFILE = gone.hal", done.stderr)
        shutil.rmtree(os.path.join(self.folder, "machine"))
        done = self.bench("--ini", self.machine(**{"second.tcl": "setp scale.nothing 1\n"}), "--for", "5ms")
        self.assertEqual(done.returncode, 1)
        self.assertIn("scale.nothing", done.stderr)
        self.assertIn("second.tcl", done.stderr)

    def test_samples_of_linuxcnc_run(self):
        for folder, name in ((".", "axis_mm.ini"), (".", "minimal_xyz.ini"), ("ini_with_includes", "includes_demo.ini"), ("twopass", "twopass.ini"), ("halui_pyvcp", "halui.ini"), ("vismach/hbm", "hbm.ini")):
            with self.subTest(name):
                path = os.path.join(self.copy(folder), name) if folder != "." else self.top(name)
                done = self.bench("--ini", path, "--models", "--for", "1s", "--expect", "finite({joint.0.motor-pos-cmd})")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("simulated 1 s", done.stdout)
                self.assertIn("the statement held in every period", done.stdout)
                self.assertIn("joints stand: no task", done.stderr)

    def top(self, name):
        folder = os.path.join(self.folder, "top")
        os.makedirs(folder, exist_ok=True)
        for file in os.listdir(SAMPLES):
            if os.path.isfile(os.path.join(SAMPLES, file)):
                shutil.copy(os.path.join(SAMPLES, file), folder)
        return os.path.join(folder, name)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Machines and commands that plumb wire refuses: it names both sides of a conflict."""

import os
import sys
import types
import unittest

from long import long
from tree import BUILD, own_folder
from wire_sample import AXIS_MM, Sample, plumb_wire, read, write


class Conflicts(Sample):
    def add_halfile(self, hal):
        """mine.hal, the last HALFILE of axis_mm."""
        write(os.path.join(os.path.dirname(self.ini(AXIS_MM)), "mine.hal"), hal)
        last = "HALFILE = simulated_home.hal"
        write(self.ini(AXIS_MM), read(self.ini(AXIS_MM)).replace(last, last + "\nHALFILE = mine.hal"))

    def refusal(self, hal, *functions, ini_change=("", "")):
        """The words of plumb wire about axis_mm with another HALFILE of these lines."""
        self.add_halfile(hal)
        write(self.ini(AXIS_MM), read(self.ini(AXIS_MM)).replace(*ini_change))
        status, output, flat = self.wire(AXIS_MM, *functions)
        self.assertEqual(status, 1, output)
        self.assertFalse(os.path.exists(self.folder(AXIS_MM)))
        return flat

    def test_a_conflict_names_both_sides(self):
        flat = self.refusal(
            "loadrt xor2 names=square,haze\nloadrt lut5 count=2\nnet haze motion.digital-out-00 => haze.in0\n"
            "net weight motion.analog-in-01 <= motion.current-vel\nnet door motion.feed-inhibit\n",
            "squareness",
            "thermal_displacement",
        )
        self.assertIn("The name square is in use: by xor2 in your configuration (mine.hal:1), and by squareness", flat)
        self.assertIn("Your configuration loads lut5 (mine.hal:2), and a module is loaded once", flat)
        self.assertIn("write names=lut5.0,lut5.1,feed-inhibit-of-all in your line", flat)
        self.assertNotIn("motion.digital-out-00", flat)  # for which the function takes another one
        self.assertNotIn("motion.analog-in-01", flat)

    def test_a_later_line_that_takes_the_place_of_a_stage_is_named(self):
        flat = self.refusal(
            "unlinkp joint.0.motor-pos-cmd\n",
            "squareness",
            ini_change=("HALUI = halui", "HALUI = halui\nHALCMD = net Xpos joint.0.motor-pos-cmd"),
        )
        self.assertIn("joint.0.motor-pos-cmd is netted to the signal Xpos by a HALCMD line", flat)

    def test_an_alias_of_a_pin_that_a_stage_needs_is_named(self):
        flat = self.refusal("alias pin joint.0.motor-pos-cmd x-command\n", "squareness")
        self.assertIn("Your alias (mine.hal:1) gives joint.0.motor-pos-cmd another name, behind which x-stage does not find it", flat)

    def test_a_line_that_locks_hal_is_named(self):
        self.assertIn("mine.hal:1 locks HAL before the files of Plumb are loaded: remove this line.", self.refusal("lock tune\n", "squareness"))

    @long
    def test_an_inhibit_of_the_user_is_joined(self):
        self.add_halfile(
            "net door motion.feed-inhibit\nnet wait motion.digital-in-00\nloadusr -W plumb-retain --file $(CONFIG_DIR)/mine.toml\n"
        )
        write(os.path.join(os.path.dirname(self.ini(AXIS_MM)), "mine.toml"), 'machine = "mine"\n')
        status, output, flat = self.wire(AXIS_MM, "squareness")
        self.assertEqual(status, 0, output)
        self.assertIn("Pins stand in for them here: hal_manualtoolchange. Trying", flat)  # plumb-retain itself runs
        self.assertIn("motion.feed-inhibit keeps your signal door; `or` joins it with plumb-wait.", flat)
        stages = read(os.path.join(self.folder(AXIS_MM), "stages.hal"))
        self.assertEqual(stages.count("unlinkp motion."), 1)
        self.assertIn("unlinkp motion.feed-inhibit\n", stages)
        self.assertIn("net plumb-wait interlock.feed-inhibit => motion.feed-hold\n", stages)
        self.assertIn("setp feed-inhibit-of-all.function 0xE\nnet plumb-wait => feed-inhibit-of-all.in-0\n", stages)
        self.assertIn("net door => feed-inhibit-of-all.in-1\n", stages)
        self.assertIn("net feed-inhibit-of-all feed-inhibit-of-all.out => motion.feed-inhibit\n", stages)
        order = read(os.path.join(self.folder(AXIS_MM), "order.tcl"))
        self.assertLess(order.index("  interlock.update\n"), order.index("  feed-inhibit-of-all\n"))

    @long
    def test_a_machine_that_fails_by_itself_is_told_from_one_that_fails_with_plumb(self):
        flat = self.refusal("net switch joint.1.pos-lim-sw-in\nsets switch 1\n", "squareness")
        self.assertRegex(flat, "The same machine without Plumb fails too: joint 1 on limit switch error")


class Refusals(unittest.TestCase):
    """Machines and commands that are refused without a start of LinuxCNC."""

    def setUp(self):
        self.home = own_folder(self)
        self.ini = os.path.join(self.home, "my.ini")

    def machine(self, coordinates):
        write(
            self.ini,
            "[EMC]\nVERSION = 1.1\n[KINS]\nKINEMATICS = trivkins coordinates=%s\nJOINTS = %d\n[TRAJ]\nCOORDINATES = %s\n"
            % (coordinates, len(coordinates), coordinates),
        )

    def test_unknown_function(self):
        status, output, flat = plumb_wire("squarenes", "--ini", self.ini)
        self.assertEqual(status, 2)
        self.assertIn("there is no function 'squarenes'; is it squareness?", flat)
        self.assertRegex(output, r"\n  thermal_displacement +corrects")

    def test_missing_file(self):
        status, _, flat = plumb_wire("squareness", "--ini", "/nowhere/my.ini")
        self.assertEqual((status, flat), (2, "plumb wire: cannot read /nowhere/my.ini: there is no such file"))

    def test_machine_without_z(self):
        self.machine("XY")
        status, _, flat = plumb_wire("thermal_displacement", "--ini", self.ini)
        self.assertEqual(status, 1)
        self.assertIn("thermal_displacement needs the axis Z, and this machine has X Y", flat)

    def test_a_code_that_the_user_remaps(self):
        self.machine("XYZ")
        write(self.ini, read(self.ini) + "[RS274NGC]\nREMAP = G81.1 modalgroup=1 ngc=peck\n")
        status, _, flat = plumb_wire("chopping", "--ini", self.ini)
        self.assertEqual(status, 1)
        self.assertIn("G81.1 is in use: my.ini:9 remaps it by 'G81.1 modalgroup=1 ngc=peck', and chopping needs it.", flat)

    def test_folder_with_files_of_the_user(self):
        self.machine("XYZ")
        os.mkdir(os.path.join(self.home, "plumb"))
        write(os.path.join(self.home, "plumb", "stages.hal"), "# mine\n")
        status, _, flat = plumb_wire("squareness", "--ini", self.ini)
        self.assertEqual(status, 1)
        self.assertIn("plumb wire did not write it: it has stages.hal", flat)
        self.assertEqual(read(os.path.join(self.home, "plumb", "stages.hal")), "# mine\n")

    def test_folder_outside(self):
        self.machine("XYZ")
        status, _, flat = plumb_wire("squareness", "--ini", self.ini, "--output", "/nowhere")
        self.assertEqual(status, 1)
        self.assertIn("must be a folder below the folder of the INI file", flat)

    def test_system_without_namespaces(self):
        self.machine("XYZ")
        write(os.path.join(self.home, "unshare"), "#!/bin/sh\necho 'unshare: unshare failed' >&2\nexit 1\n")
        os.chmod(os.path.join(self.home, "unshare"), 0o755)
        status, _, flat = plumb_wire("squareness", "--ini", self.ini, programs=self.home)
        self.assertEqual(status, 1)
        self.assertIn("plumb wire needs namespaces, and this system gives none", flat)

    def test_wrong_joints(self):
        self.machine("XYZ")
        status, _, flat = plumb_wire("squareness", "--ini", self.ini, "--joints", "X=0,Q=1")
        self.assertEqual(status, 1)
        self.assertIn("'Q=1' is not an axis and its joint, such as X=0", flat)

    def import_from_plumb_wire(self):
        for name in ("wiring", "models"):
            folder = os.path.join(BUILD, "share", "plumb", name)
            sys.path.insert(1, folder)
            self.addCleanup(sys.path.remove, folder)

    def test_a_machine_that_is_wired_by_hand(self):
        """Its components are named, and not all the signals between them."""
        self.import_from_plumb_wire()
        from functions import all_functions
        from hal_state import State
        from hal_text import halfiles
        from ini_file import IniFile
        from machine import Machine
        from wiring import Wiring

        write(os.path.join(self.home, "mine.hal"), "loadrt interlock names=lock\nsource more.hal\n")
        write(os.path.join(self.home, "more.hal"), "loadrt squareness names=square\n")
        pins = ["lock.arm", "square.enable", "joint.0.motor-pos-cmd", "joint.0.motor-pos-fb", "motion.feed-inhibit"]
        owners = {"lock": "interlock", "square": "squareness"}
        texts = {
            "comp": "".join("1 RT %s 0 ready\n" % name for name in ("interlock", "squareness", "linuxcnc-link")),
            "pin": "".join("%s bit IN 0 %s ==> mine\n" % (owners.get(pin.split(".")[0], "motmod"), pin) for pin in pins),
            "sig": "bit 0 mine ==> %s\n" % " ==> ".join(pins),
            "param": "",
            "thread": "1000000 YES servo-thread 0 0 motion-controller\n",
        }
        self.machine("X")
        write(self.ini, read(self.ini) + "[HAL]\nHALFILE = mine.hal\n")
        ini = IniFile(self.ini)
        machine = Machine(State(texts), State(texts), {"X": [0]}, ini, list(halfiles(ini, self.home)))
        function = all_functions(os.path.join(BUILD, "share", "plumb", "functions"))["squareness"]
        sentence = "Your configuration loads %s, and plumb wire loads it for squareness. A machine has one: leave yours out."
        found = Wiring([function], machine, "plumb").problems
        self.assertEqual(
            sorted(found), [sentence % name for name in ("interlock (mine.hal:1)", "linuxcnc-link", "square (more.hal:1)")]
        )

    def test_more_functions_or_stages_than_interlock_serves(self):
        self.import_from_plumb_wire()
        import interlock
        from stages import Part

        def problems(functions, stages):
            named = [types.SimpleNamespace(name="f%d" % number) for number in range(functions)]
            return interlock.problems(named, [Part("", {"joint_offset": ["s%d" % number]}) for number in range(stages)])

        self.assertEqual(problems(16, 17), [])
        self.assertRegex(problems(17, 8)[0], "interlock serves 16 functions, and there are 17: f0, .*, f16")
        self.assertRegex(problems(6, 18)[0], "interlock serves 17 stages, and there are 18: s0, .*, s17")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on samples of LinuxCNC: its files work, it changes no file of the user, and it can be undone."""

import os
import re
import shutil
import subprocess
import unittest

from long import long
from wire_sample import AXIS_MM, Sample, read, write

LATHE = "sim/axis/lathe.ini"


class Works(Sample):
    def test_both_functions_show_their_effect_and_the_patch_can_be_undone(self):
        panels = "".join("loadusr -Wn %s gladevcp -c %s %s.ui\n" % (name, name, name) for name in ("left", "right"))
        hal = panels + "net my-lamp motion.in-position => left.lamp right.lamp\nnet my-dial motion.analog-out-03 => motion.analog-in-03\n"
        write(os.path.join(os.path.dirname(self.ini(AXIS_MM)), "mine.hal"), hal)
        last = "HALFILE = simulated_home.hal"
        ini = read(self.ini(AXIS_MM)).replace(last, last + "\nHALFILE = mine.hal")
        # X homes at its limit, where a stage brings in a part of its offset, the less the smaller the reserve of the drive is.
        ini = re.sub(r"(\[(?:AXIS_X|JOINT_0)\][^[]*MIN_LIMIT = )\S+", r"\g<1>0", ini)
        write(self.ini(AXIS_MM), re.sub(r"(\[JOINT_0\][^[]*MAX_ACCELERATION = )(\S+)", r"\g<1>\2\nSTEPGEN_MAX_ACC = 530", ini))
        status, output, flat = self.wire(AXIS_MM, "thermal_displacement", "squareness")
        self.assertEqual(status, 0, output)
        for function, effect in (("squareness", "moves the drive of X"), ("thermal_displacement", "measured as")):
            seen = self.seen(output, function)
            self.assertTrue(any(effect in text for text in seen), output)
            self.assertTrue(all(seen.values()), output)
        self.assertIn("These programs need a screen or a device. Pins stand in for them here: hal_manualtoolchange, left, right.", flat)
        self.assertIn("[EMCMOT] EMCMOT = motmod num_dio=8", flat)
        # Output 3 is the user's, and 0 is one of interlock.
        self.assertIn("motion.analog-out-03 keeps your signal my-dial; thermal_displacement takes motion.analog-out-01", flat)
        self.assertIn(
            "net growth-start-height motion.analog-out-01 => growth.start-height\n",
            read(os.path.join(self.folder(AXIS_MM), "thermal_displacement.hal")),
        )
        clock = read(os.path.join(self.folder(AXIS_MM), "growth_clock.ngc"))
        self.assertIn("\n#<height_output> = #<_ini[PLUMB_NUMBERS]GROWTH_START_HEIGHT>\n", clock)
        self.assertIn("\n#<mark_output>   = #<_ini[PLUMB_NUMBERS]GROWTH_CLOCK_START>\n", clock)
        self.assertIn("\nGROWTH_START_HEIGHT = 1\n", read(os.path.join(self.folder(AXIS_MM), "plumb.inc")))
        self.assertRegex(flat, "Still missing.*setp interlock.function-switch-1 1` .squareness.*The load of the spindle.*chain of axes")
        hal = read(os.path.join(self.folder(AXIS_MM), "stages.hal"))
        self.assertIn("unlinkp joint.0.motor-pos-cmd\n", hal)
        self.assertIn("net Xpos x-stage.drive-command\n", hal)
        # All gates are one interlock.
        self.assertEqual(sorted(re.findall("loadrt (\\S+)", hal)), ["axis_offset", "interlock", "joint_offset"])
        self.assertIn("net wait interlock.feed-inhibit => motion.feed-inhibit motion.feed-hold\n", hal)
        self.assertIn("setp interlock.function-services-0 1\n", hal)  # growth needs plumb-retain
        self.assertIn("setp interlock.function-services-1 0\n", hal)
        self.assertIn("loadusr -Wn linuxcnc-link linuxcnc_link\n", hal)
        written = "".join(read(os.path.join(self.folder(AXIS_MM), name)) for name in ("stages.hal", "retain.hal", "thermal_displacement.hal", "squareness.hal"))
        self.assertEqual(set(re.findall(r"=> linuxcnc-link\.(\S+)", written)), {"identify"})  # it finds what it tells
        halfile = read(os.path.join(self.folder(AXIS_MM), "plumb.hal"))
        sourced = re.findall(r"source plumb/(\S+)\.hal", halfile)
        self.assertEqual((sourced[0], sourced[-1]), ("stages", "retain"))  # after the records that plumb-retain looks for
        self.assertIn("\nloadusr -W plumb-retain ", read(os.path.join(self.folder(AXIS_MM), "retain.hal")))
        self.assertEqual(hal.count("loadusr"), 2)  # linuxcnc_link and linuxcnc_alive
        self.assertIn("setp interlock.feed-services 48\n", hal)
        self.assertIn("net growth-state => interlock.function-state-0\n", hal)
        self.assertIn("net estop-loop => iocontrol.0.emc-enable-in motion.enable\n", hal)
        before, behind = re.search(r"plumb_order \{\n(.*)\n\} \{\n(.*)\n\}\n$", read(os.path.join(self.folder(AXIS_MM), "order.tcl")), re.S).groups()
        self.assertEqual(before.split(), ["x-stage.update-feedback", "y-stage.update-feedback", "z-stage.update-feedback"])
        behind = behind.split()
        self.assertLess(behind.index("square.update"), behind.index("x-stage.update"))
        self.assertLess(behind.index("growth.update"), behind.index("z-axis-stage.update"))
        self.assertEqual(behind[-1], "interlock.update")
        self.assertIn("%d functions stand around motion-controller in servo-thread" % (3 + len(behind)), flat)
        # Limits come from the INI file, by name, or from its numbers.
        self.assertIn("setp x-stage.joint-acceleration [JOINT_0]MAX_ACCELERATION\n", hal)

        if shutil.which("patch"):
            home, original = os.path.dirname(self.ini(AXIS_MM)), read(self.ini(AXIS_MM))
            shutil.copy(os.path.join(home, "plumb", "ini.patch"), os.path.join(home, "ini.patch.first"))
            for options, expected in ((["-p1"], None), (["-R", "-p1"], original)):
                with open(os.path.join(home, "plumb", "ini.patch"), "rb") as patch:
                    subprocess.run(["patch", *options], cwd=home, stdin=patch, check=True, stdout=subprocess.DEVNULL)
                if expected is None:
                    status, output, flat = self.wire(AXIS_MM, "squareness")
                    self.assertEqual(status, 0, output)
                    self.assertIn("axis_mm.ini has the lines that put them in.", flat)
                    self.assertEqual(read(os.path.join(self.folder(AXIS_MM), "stages.hal")), hal)  # the same numbers
                    shutil.copy(os.path.join(home, "ini.patch.first"), os.path.join(home, "plumb", "ini.patch"))
                    self.assertIn("HALFILE = plumb/plumb.hal\n", read(self.ini(AXIS_MM)))
                    self.assertIn("OFFSET_AV_RATIO = 0.2\n", read(self.ini(AXIS_MM)))
                else:
                    self.assertEqual(read(self.ini(AXIS_MM)), expected)

    @long
    def test_a_second_function_joins_the_first_and_settings_of_the_user_stay(self):
        self.assertEqual(self.wire(LATHE, "squareness")[0], 0)
        settings = os.path.join(self.folder(LATHE), "squareness_settings.hal")
        values = os.path.join(self.folder(LATHE), "plumb.inc")
        write(settings, "setp square.ea0z 0\nsetp square.eb0z 0.0001\n")
        write(values, "[SQUARENESS]\nCHAIN = w-Y.b-Z-X-C-t\n")
        status, output, flat = self.wire(LATHE, "thermal_displacement")
        self.assertEqual(status, 0, output)
        self.assertIn("squareness_settings.hal (yours, not written)", flat)
        self.assertEqual(read(settings), "setp square.ea0z 0\nsetp square.eb0z 0.0001\n")
        self.assertTrue(read(values).startswith("[SQUARENESS]\nROTARY = none\nTABLE = none\nCHAIN = w-Y.b-Z-X-C-t\n"), read(values))
        self.assertIn("[PLUMB_NUMBERS]\n", read(values))
        stages = read(os.path.join(self.folder(LATHE), "stages.hal"))
        self.assertIn("joint_offset names=x-stage,z-stage unit=[TRAJ]LINEAR_UNITS\n", stages)  # a lathe has no Y
        self.assertIn("axis_offset names=z-axis-stage unit=[TRAJ]LINEAR_UNITS\n", stages)
        # On an inch machine the settings are inches, and the modules convert their defaults.
        own = read(os.path.join(self.folder(LATHE), "thermal_displacement_settings.hal"))
        self.assertIn("setp growth.gate-floor        0.000787402\n", own)

        write(os.path.join(self.folder(LATHE), "stages.hal"), stages + "# mine\n")
        status, _, flat = self.wire(LATHE, "squareness")
        self.assertEqual(status, 1)
        self.assertIn("Somebody changed stages.hal", flat)
        self.assertTrue(read(os.path.join(self.folder(LATHE), "stages.hal")).endswith("# mine\n"))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire --check names the lines that LinuxCNC refuses after an update of Plumb, and what to write. Nothing has to run."""

import os
import subprocess
import unittest

from tree import BUILD, ROOT, own_folder
from wire_sample import plumb_wire, write

FORMER = """\
loadrt interlock names=interlock functions=1 stages=2
loadrt squareness names=square
loadrt joint_offset names=x-stage,y-stage interlock=yes,no
loadrt and2 names=row
net square-on interlock.function-enable-0 => square.enable
net square-permission interlock.function-status-0 => square.interlock-status
net program => interlock.function-busy-0
net x-in-force x-stage.inhibit-homing => interlock.stage-in-force-0   # a stage
setp x-stage.row 0
setp y-stage.enable true
setp y-stage.max-offset 0.1
net retain-beat => interlock.service-heartbeat-0
net spare row.out => x-stage.offset-0
"""

LOADED = """\
loadrt squareness names=square
loadrt chopping names=chop
loadrt thermal_displacement names=growth
loadrt centre_height names=centre
loadrt thermal_growth_test names=growth-test
"""
# Pins that are gone, and words of what to write.
GONE = {
    "square.ea0x": "ea0y and ea0z for ea0x", "square.ec0w": "the axes that it carries", "square.eb0b": "the axes that it carries",
    "square.ez0c": "a rotary axis has no place",
    "chop.pulse-time": "constant now, 0.02 s",
    "growth.exclude-operation-7": "exclude-operation-0 to -3",
    "growth.rejection-code": "growth.detail-code: 30 more", "growth.fault-code": "while growth.fault is true", "growth.doubt-code": "growth.status-code",
    "centre.hold-code": "centre.detail-code: a hold has 30 more", "centre.verdict-code": "centre.status-code",
    "growth.lost-time-tolerance": "constant now, 0.002 s", "centre.known-x-sigma": "make one more cut",
    "centre.stock-sigma": "constant now, 0.01 mm", "growth-test.range-share": "constant now, 0.15",
    "centre.cut-x-07": "cut-x-7; the option keyed_cuts gives the number", "growth-test.sensors": "sensors=N into the line loadrt thermal_growth_test",
}


class FormerLines(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.ini = os.path.join(self.folder, "my.ini")
        write(self.ini, "[EMC]\nMACHINE = mine\n[HAL]\nHALFILE = my.hal\n")

    def check(self, lines):
        write(os.path.join(self.folder, "my.hal"), lines)
        return plumb_wire("--check", "--ini", self.ini)

    def test_each_former_pin_is_named_with_its_line_and_what_to_write(self):
        status, output, _line = self.check(FORMER)
        self.assertEqual(status, 1)
        said = [line.split(" names ")[0].strip() + " " + line.split(" names ")[1].split(",")[0] for line in output.splitlines() if " names " in line]
        self.assertEqual(said, ["my.hal:5 square.enable", "my.hal:6 square.interlock-status", "my.hal:7 interlock.function-busy-0",
                                "my.hal:8 interlock.stage-in-force-0", "my.hal:9 x-stage.row", "my.hal:12 interlock.service-heartbeat-0"])
        for words in ("net NAME-permit interlock.function-permit-N => square.permit", "interlock.function-state-0", "interlock.stage-state-0", "interlock.service-state-0",
                      "a stage takes the row of its permit"):
            self.assertIn(words, output)

    def test_a_setting_that_is_gone_is_named_with_what_to_write(self):
        _status, output, _line = self.check(LOADED + "".join("setp %s 1\n" % pin for pin in GONE))
        said = {line.split(" names ")[1].split(",")[0]: line for line in output.splitlines() if " names " in line}
        self.assertEqual(said.keys(), GONE.keys())
        for pin, words in GONE.items():
            self.assertIn(words, said[pin])

    def test_files_that_plumb_wire_wrote_are_one_line_each_and_settings_there_are_the_users(self):
        os.mkdir(os.path.join(self.folder, "plumb"))
        write(os.path.join(self.folder, "plumb", ".written.json"), '{"version": "0.2.0", "ini": "my.ini", "functions": ["squareness", "chopping"], "files": {}}')
        write(os.path.join(self.folder, "plumb", "stages.hal"), FORMER)
        write(os.path.join(self.folder, "plumb", "chopping_settings.hal"), "setp chop.pulse-time 0.02\n")
        status, output, _line = self.check("loadrt chopping names=chop\nsource plumb/stages.hal\nsource plumb/chopping_settings.hal\n")
        self.assertEqual(status, 1)
        self.assertEqual([line.strip() for line in output.splitlines()[1:]], [
            "plumb/chopping_settings.hal:1 names chop.pulse-time, which this Plumb has no more. Write nothing: it is constant now, 0.02 s.",
            "plumb/stages.hal has lines of an earlier Plumb, 6 of them: wire it again.", "$ plumb wire squareness chopping --ini my.ini --apply"])

    def test_plumb_doctor_gives_the_line_while_linuxcnc_refuses_it(self):
        write(os.path.join(self.folder, "my.hal"), "loadrt squareness names=square\nnet on => square.enable\n")
        for arguments, home in ((("--ini", self.ini), {}), ((), {"HOME": self.folder})):  # named, or picked last
            write(os.path.join(self.folder, ".linuxcncrc"), "[PICKCONFIG]\nLAST_CONFIG = %s\n" % self.ini)
            done = subprocess.run([os.path.join(BUILD, "bin", "plumb"), "doctor", "--machine", *arguments], env={**os.environ, **home},
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            said = " ".join(done.stdout.split())
            self.assertEqual(done.returncode, 1, said)
            self.assertIn("WRONG my.hal:2 names square.enable, which this Plumb has no more. Write net NAME-permit", said)

    def test_a_pin_that_another_option_gives_is_named_with_the_option(self):
        write(self.ini, "[EMC]\nMACHINE = mine\n[SQUARENESS]\nCHAIN = w-X-Y.b-Z-C-t\n[HAL]\nHALFILE = my.hal\n")
        _status, output, _line = self.check(
            "loadrt squareness names=square chain=[SQUARENESS]CHAIN\nloadrt axis_growth names=one,three sensors=1,3\n"
            "net w-position => square.w-position\nsetp square.to-bed 1\nnet t => one.temperature-2 three.temperature-2\nsetp three.x-growth-3 0\n")
        said = {line.split(" names ")[1].split(",")[0]: line.split("Write ")[1] for line in output.splitlines() if " names " in line}
        self.assertEqual(said, {
            "square.w-position": "W into the chain of the line loadrt squareness, or remove this line.",
            "square.to-bed": "U, V or W into the chain of the line loadrt squareness, or remove this line.",
            "one.temperature-2": "sensors=3, or more, into the line loadrt axis_growth, or remove this line.",
            "three.x-growth-3": "sensors=4, or more, into the line loadrt axis_growth, or remove this line.",
        })
        write(self.ini, "[EMC]\nMACHINE = mine\n[SQUARENESS]\nCHAIN = w-X.b-W-Y-Z-C-t\n[HAL]\nHALFILE = my.hal\n")
        _status, output, _line = self.check("loadrt squareness names=square chain=[SQUARENESS]CHAIN\nnet w-position => square.w-position\n")
        self.assertNotIn(" names ", output)

    def test_the_lines_of_today_are_not_named(self):
        for folder, name in (("mill", "stages.hal"), ("portal", "stages.hal"), ("lathe", "by_hand.hal"), ("grinder", "extra.hal")):
            with open(os.path.join(ROOT, "configs", folder, name), encoding="utf-8") as file:
                    _status, output, _line = self.check(file.read())
            self.assertNotIn(" names ", output, name)
            self.assertIn("No function is wired in", output, name)


if __name__ == "__main__":
    unittest.main()

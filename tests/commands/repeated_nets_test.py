#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire repeats the nets of a function's file for the axes, sensors and posts that the INI file names."""

import os
import sys
import unittest

from tree import BUILD, ROOT, own_folder

sys.path[:0] = [os.path.join(BUILD, "python"), os.path.join(ROOT, "components", "commissioning", "wire", "wiring"), os.path.join(ROOT, "hal", "models")]
from functions import all_functions  # noqa: E402
from ini_file import IniFile  # noqa: E402


class RepeatedNets(unittest.TestCase):
    def nets(self, name, values, axes="XYZ"):
        """The function, and its nets as lines, on a machine with these values."""
        path = os.path.join(own_folder(self), "my.ini")
        with open(path, "w", encoding="ascii") as file:
            file.write("[%s]\n%s\n" % (name.upper(), values))
        function = all_functions(os.path.join(BUILD, "share", "plumb", "functions"))[name]
        function.take_values(IniFile(path))
        return function, [" ".join(words) for words in function.nets(axes)]

    def test_the_smallest_machine_has_the_lines_of_the_file(self):
        function, nets = self.nets("squareness", "")
        self.assertEqual([net for net in nets if net[:2] in ("w-", "a-", "c-")], [])
        self.assertEqual(set(function.joint_offset), set("XYZ"))
        self.assertEqual([net for net in self.nets("axis_growth", "")[1] if net.endswith("-1")], [])

    def test_an_axis_of_the_chain_has_the_nets_of_z(self):
        function, nets = self.nets("squareness", "CHAIN = w-C-A-X.b-W-Y-Z-t\nROTARY = AC", "XYZWAC")
        for net in ("w-position => square.w-position", "w-velocity => square.w-velocity", "w-backlash-corr => square.w-backlash-corr",
                    "w-correction square.w-correction", "a-position => square.a-position", "c-velocity => square.c-velocity"):
            self.assertIn(net, nets)
        self.assertEqual([net for net in nets if net.startswith(("w-tool", "u-", "v-", "b-", "a-corr", "c-back"))], [])
        self.assertEqual(set(function.joint_offset), set("XYZW"))

    def test_an_axis_that_the_machine_lacks_has_no_net(self):
        nets = self.nets("squareness", "CHAIN = w-X.b-W-Y-Z-t")[1]
        self.assertEqual([net for net in nets if net.startswith("w-")], [])

    def test_a_signal_without_a_number_goes_to_each_post(self):
        nets = self.nets("centre_height", "POSTS = 2", "XYZ")[1]
        self.assertIn("x-position => centre.x-position-0 centre.x-position-1", nets)
        self.assertIn("height-x-zero motion.analog-out-09 => centre.x-zero-0 centre.x-zero-1", nets)

    def test_each_sensor_has_the_nets_of_the_first_one(self):
        nets = self.nets("axis_growth", "SENSORS = 3")[1]
        self.assertEqual([net for net in nets if net.startswith("growth-temperature-age")],
                         ["growth-temperature-age-%d => axis-growth.temperature-age-%d" % (row, row) for row in range(3)])


if __name__ == "__main__":
    unittest.main()

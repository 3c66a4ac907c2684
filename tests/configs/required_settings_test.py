#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A function's files set what must be set, and nothing else; plumb wire computes the rest of it."""

import glob
import json
import os
import re
import unittest

from tree import BUILD, ROOT


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


FUNCTIONS = os.path.join(ROOT, "configs", "functions")
WIRE = os.path.join(ROOT, "components", "commissioning", "wire", "wiring")
COMPUTED = read(os.path.join(WIRE, "hal_files.py")) + read(os.path.join(WIRE, "stages.py"))


def levels(module):
    with open(os.path.join(BUILD, "share", "plumb", module + ".json"), encoding="utf-8") as file:
        pins = json.load(file)["pins"]
    return {short: pin["level"] for short, pin in pins.items() if "level" in pin}


def settings_of(function):
    """The pins that setp lines of a function's HAL files name, without the instance."""
    text = "\n".join(read(path) for path in glob.glob(os.path.join(FUNCTIONS, function, function + "*.hal")))
    instance = re.search(r"loadrt %s names=(\S+)" % function, text)[1]
    return set(re.findall(r"^setp %s\.(\S+)" % re.escape(instance), text, re.M))


def limits_of_another_axis(function):
    """plumb wire computes the limits of an axis that the INI file names."""
    prefix = re.search(r'^limits = "[^".]+\.([^"]*)"', read(os.path.join(FUNCTIONS, function, "wire.toml")), re.M)
    return {prefix[1] + each for each in ("min-limit", "max-limit")} if prefix else set()


class RequiredSettings(unittest.TestCase):
    def test_a_function_sets_what_must_be_set_and_no_other_setting(self):
        for function in sorted(os.listdir(FUNCTIONS)):
            if not os.path.isdir(os.path.join(FUNCTIONS, function)):
                continue
            with self.subTest(function=function):
                of_level, given = levels(function), settings_of(function)
                required = {short for short, level in of_level.items() if level == "must"}
                self.assertEqual(given - required, set(), "set, and not required")
                left = {short for short in required - given - limits_of_another_axis(function) if not re.search(r"[.\"]%s\b" % short, COMPUTED)}
                self.assertEqual(left, set(), "required, and nobody sets it")


if __name__ == "__main__":
    unittest.main()

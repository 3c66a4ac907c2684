#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel, which takes values of pins from a JSON file in the place of those that HAL has: for pictures of rare states.

    panel_with_values.py VALUES.json BUILD [option of plumb panel ...]
"""

import json
import os
import runpy
import sys

path, build = sys.argv[1:3]
program = os.path.join(build, "bin", "plumb-panel")
sys.path.insert(0, os.path.join(build, "share", "plumb"))
from panel import hal_access, task  # noqa: E402

values_of_hal = hal_access.Hal.values


def values(self):
    with open(path, encoding="utf-8") as file:
        given = json.load(file)
    found = values_of_hal(self)
    return {**found, **{name: value for name, value in given.items() if name in found or name.startswith(("task.", "motion.", "halui."))}}


hal_access.Hal.values = values
task.Task.values = lambda self: {}
sys.argv = [program, *sys.argv[3:]]
runpy.run_path(program, run_name="__main__")

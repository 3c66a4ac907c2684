# SPDX-License-Identifier: GPL-2.0-or-later
"""Which INI files of configs a test starts. A test declares them at its end,

    tearDownModule = starts("mill/mill.ini")

and fails if it has not started LinuxCNC with a copy of each: one of that name and with that MACHINE.
"""

import ast
import glob
import os
import sys

from long import left_out
from tree import ROOT

_started = set()


def starts(*inis):
    """A tearDownModule that compares these INI files with those that the test has started."""
    wanted = {ini: _identity(os.path.join(ROOT, "configs", ini)) for ini in inis}
    sys.addaudithook(_see)

    def check():
        if len(sys.argv) > 1 or left_out:  # not all tests run
            return
        never = [ini for ini, identity in wanted.items() if identity not in _started]
        if never:
            raise AssertionError("declared as started, and never started: " + ", ".join(never))

    return check


def declared():
    """The tests that start an INI file, by its name, such as mill/mill.ini."""
    found = {}
    for path in glob.glob(os.path.join(ROOT, "tests", "**", "*_test.py"), recursive=True):
        with open(path, encoding="utf-8") as file:
            tree = ast.parse(file.read())
        for node in tree.body:
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "tearDownModule":
                call = node.value
                if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "starts":
                    for argument in call.args:
                        found.setdefault(ast.literal_eval(argument), []).append(os.path.relpath(path, ROOT))
    return found


def shipped():
    """The INI files of all configurations."""
    return sorted("/".join(path.split(os.sep)[-2:]) for path in glob.glob(os.path.join(ROOT, "configs", "*", "*.ini")))


def _identity(path):
    """The name of an INI file, also of that of a test (linuxcnc_runs.own_ini), and the line with its machine."""
    with open(path, encoding="utf-8") as file:
        return os.path.basename(path).removeprefix("test_"), next((line for line in file if line.startswith("MACHINE")), "")


def _see(event, arguments):
    """Looks at every program that the test starts."""
    if event != "subprocess.Popen":
        return
    _, command, folder, _ = arguments
    words = " ".join(map(os.fsdecode, [command] if isinstance(command, (str, bytes)) else command)).split()
    if not any(os.path.basename(word) == "linuxcnc" for word in words):
        return
    for word in words:
        path = os.path.join(os.fsdecode(folder or "."), word)
        if word.endswith(".ini") and os.path.isfile(path):
            _started.add(_identity(path))

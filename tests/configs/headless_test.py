#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/common/headless.py: however it ends, it says why. Its LinuxCNC is one of these lines."""

import os
import signal
import subprocess
import sys
import unittest

from plumb_folder import TemporaryFolder
from tree import ROOT

HEADLESS = os.path.join(ROOT, "configs", "common", "headless.py")

MACHINE = """
import time

class OperatorError(RuntimeError): pass
class Overdue(RuntimeError): pass

class Machine:
    def __init__(self):
        self.errors, self.messages = ["a sensor does not answer"], ["Growth test: a message"]
    def __enter__(self): return self
    def __exit__(self, *_): pass
    def turn_on(self): self.is_on = True
    def home(self): self.is_homed = self.is_on
    def was_aborted(self): return "aborts" in self.program
    def run(self, program):
        assert self.is_homed
        self.program = program
        if "fails" in program: raise OperatorError("joint 0 following error")
        if "waits" in program: raise Overdue("the end of the motion did not come within 60 s")
        if "long" in program:
            print("begun", flush=True)
            time.sleep(60)
"""


class Headless(unittest.TestCase):
    def setUp(self):
        folder = TemporaryFolder()
        self.addCleanup(folder.cleanup)
        for name, text in (("linuxcnc.py", ""), ("plumb_linuxcnc.py", MACHINE)):
            with open(os.path.join(folder.name, name), "w", encoding="ascii") as file:
                file.write(text)
        self.environment = {**os.environ, "PYTHONPATH": folder.name}

    def start(self, *programs):
        command = [sys.executable, HEADLESS, "-ini", "machine.ini", *programs]
        return subprocess.Popen(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def test_each_ending_says_why(self):
        ends = {
            "good.ngc": (0, ""),
            "fails.ngc": (1, "joint 0 following error\n"),
            "waits.ngc": (1, "the end of the motion did not come within 60 s\n"),
            "aborts.ngc": (1, "aborts.ngc was aborted before its end, and LinuxCNC gave no reason\n"),
        }
        for program, (status, reason) in ends.items():
            with self.subTest(program=program):
                process = self.start("first.ngc", program)
                output, errors = process.communicate(timeout=60)
                self.assertEqual(process.returncode, status)
                self.assertEqual(errors, "a sensor does not answer\n" + reason)
                self.assertIn("first.ngc is done\n", output)
                self.assertEqual(program + " is done\n" in output, status == 0)
                self.assertIn("Growth test: a message\n", output)

    def test_a_signal_that_ends_it_is_named(self):
        process = self.start("long.ngc")
        self.assertEqual(process.stdout.readline(), "begun\n")
        process.send_signal(signal.SIGTERM)
        output, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertIn("headless.py was asked to end (SIGTERM) before its programs were done", errors)
        self.assertNotIn("is done", output)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on copies of LinuxCNC's own sample configurations."""

import os
import subprocess
import unittest

import wire_samples
from tree import BUILD, own_folder
from wire_samples import changes, snapshot

AXIS_MM = "sim/axis/axis_mm.ini"


def plumb_wire(*arguments, programs=None, **environment):
    """Exit status, output, and the output in one line. `programs` is a folder that is searched before PATH."""
    path = os.environ["PATH"] if programs is None else programs + ":" + os.environ["PATH"]
    done = subprocess.run(
        [os.path.join(BUILD, "bin", "plumb"), "wire", *arguments],
        env={**os.environ, "PATH": path, **environment},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout, " ".join(done.stdout.split())


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


@unittest.skipUnless(os.path.isdir(wire_samples.SAMPLES), "this LinuxCNC has no samples")
class Sample(unittest.TestCase):
    """A copy of the samples, in a folder that the run does not keep in memory."""

    def setUp(self):
        self.samples = wire_samples.copy_samples(wire_samples.SAMPLES, own_folder(self))
        self.roots = [os.path.dirname(self.samples)]  # folders in which nothing may change

    def ini(self, name):
        return os.path.join(self.samples, name)

    def wire(self, name, *arguments, **environment):
        """Runs plumb wire, which may change nothing but its folder."""
        before = [snapshot(root, [self.folder(name)]) for root in self.roots]
        status, output, flat = plumb_wire(*arguments, "--ini", self.ini(name), **environment)
        for root, found in zip(self.roots, before):
            self.assertEqual(changes(found, snapshot(root, [self.folder(name)])), [], "changed files of the user\n" + output)
        return status, output, flat

    def seen(self, output, function):
        return {text[len(function) + 2 :]: holds for holds, text in wire_samples.statements(output) if text.startswith(function)}

    def folder(self, name):
        return os.path.join(os.path.dirname(self.ini(name)), "plumb")

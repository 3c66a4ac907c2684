#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Two plumb wire at a time, with one TMPDIR and two namespaces of processes, as in two containers. PLUMB_ROUNDS=20 repeats it."""

import os
import subprocess
import unittest

from long import long
from tree import BUILD, own_folder
from wire_sample import AXIS_MM, Sample

ROUNDS = int(os.environ.get("PLUMB_ROUNDS", "1"))
APART = ["unshare", *([] if os.geteuid() == 0 else ["--user", "--map-current-user"]), "--pid", "--fork", "--mount-proc", "--kill-child"]


@long
@unittest.skipIf(subprocess.run([*APART, "true"], check=False).returncode, "this computer gives no namespace of processes")
class Beside(Sample):
    def setUp(self):
        super().setUp()
        self.temporary = own_folder(self)

    def start(self, number, prefix):
        words = [*prefix, os.path.join(BUILD, "bin", "plumb"), "wire", "squareness", "--ini", self.ini(AXIS_MM), "--output",
                 os.path.join(os.path.dirname(self.ini(AXIS_MM)), "plumb-%d" % number)]
        return subprocess.Popen(words, env={**os.environ, "TMPDIR": self.temporary}, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def test_both_try_the_machine_to_the_end(self):
        for _ in range(ROUNDS):
            both = [self.start(number, prefix) for number, prefix in enumerate(((), APART))]
            outputs = [process.communicate()[0] for process in both]
            for process, output in zip(both, outputs):
                self.assertEqual(process.returncode, 0, output)
            self.assertEqual(os.listdir(self.temporary), [])


if __name__ == "__main__":
    unittest.main()

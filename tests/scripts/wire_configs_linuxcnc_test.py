#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The stages of our configurations are what plumb wire writes for them."""

import os
import subprocess
import unittest

from tree import BUILD, ROOT


class Configurations(unittest.TestCase):
    def test_stages_are_those_that_plumb_wire_writes(self):
        command = [os.path.join(ROOT, "scripts", "wire-configs"), "--check"]
        done = subprocess.run(command, env={**os.environ, "PLUMB_BUILD": BUILD}, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)


if __name__ == "__main__":
    unittest.main()

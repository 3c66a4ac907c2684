# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/campaign alive: a LinuxCNC works for some seconds, and the pauses of its task and io are measured."""

import os
import re
import subprocess
import unittest

from tree import BUILD, ROOT


class Alive(unittest.TestCase):
    def test_a_seed_measures_pauses_and_takes_no_program_for_lost(self):
        done = subprocess.run(
            [os.path.join(ROOT, "scripts", "campaign"), "alive", "--seed", "7", "--seconds", "1", "--lines", "100", "--hogs", "1"],
            env={**os.environ, "PLUMB_BUILD": BUILD},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        found = re.search(r"^seed 7: longest pause of task (\d+\.\d+) s, of io (\d+\.\d+) s", done.stdout, re.M)
        self.assertTrue(found, done.stdout + done.stderr)
        self.assertGreater(float(found[1]), 0)
        self.assertGreater(float(found[2]), 0.09)  # the cycle of io is 0.1 s
        self.assertNotRegex(done.stdout, "was taken for lost|stroke has ended")


if __name__ == "__main__":
    unittest.main()

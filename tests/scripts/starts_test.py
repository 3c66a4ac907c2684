# SPDX-License-Identifier: GPL-2.0-or-later
"""Each INI file of configs is started by a test; tests/support/starts.py compares what the tests declare with what they start."""

import os
import shutil
import subprocess
import sys
import unittest

import starts
from tree import ROOT, own_folder

# INI files that no test starts, each with the reason.
NOT_STARTED = {}


class Started(unittest.TestCase):
    def test_every_ini_file_is_started_by_a_test_or_has_a_reason(self):
        declared = starts.declared()
        self.assertGreater(len(starts.shipped()), 15)
        for ini in starts.shipped():
            with self.subTest(ini):
                if ini in NOT_STARTED:
                    self.assertFalse(ini in declared, "%s starts configs/%s, which has a reason" % (declared.get(ini), ini))
                else:
                    self.assertTrue(ini in declared, "no test starts configs/%s; see tests/support/starts.py" % ini)

    def test_every_declared_ini_file_exists(self):
        self.assertEqual(set(NOT_STARTED) - set(starts.shipped()), set())
        for ini, tests in starts.declared().items():
            self.assertTrue(os.path.isfile(os.path.join(ROOT, "configs", ini)), "%s starts configs/%s" % (tests, ini))


class Declared(unittest.TestCase):
    """A stand-in for LinuxCNC, and copies of INI files as tests make them."""

    def setUp(self):
        self.folder = own_folder(self)
        words, sys.argv = sys.argv, sys.argv[:1]
        self.addCleanup(setattr, sys, "argv", words)

    def start(self, ini, *words):
        copy = shutil.copy(os.path.join(ROOT, "configs", ini), self.folder)
        subprocess.run(["true", *words, os.path.basename(copy)], cwd=self.folder, check=True)

    def test_a_start_is_seen(self):
        check = starts.starts("grinder/axis.ini")
        with self.assertRaisesRegex(AssertionError, "never started: grinder/axis.ini"):
            check()
        self.start("growth/axis.ini", "linuxcnc")  # of another machine
        self.start("grinder/axis.ini", "cat")
        with self.assertRaises(AssertionError):
            check()
        self.start("grinder/axis.ini", "linuxcnc", "-r")
        check()

    def test_a_start_in_a_line_of_the_shell_is_seen(self):
        check = starts.starts("lathe/lathe.ini")
        shutil.copy(os.path.join(ROOT, "configs", "lathe", "lathe.ini"), self.folder)
        subprocess.run(["sh", "-c", "true plumb run -- linuxcnc -r lathe.ini"], cwd=self.folder, check=True)
        check()


if __name__ == "__main__":
    unittest.main()

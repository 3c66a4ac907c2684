#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The sum of restarts that scripts/test prints."""

import os
import subprocess
import sys
import unittest
import unittest.mock

import restarts
from tree import ROOT, own_folder


class Restarts(unittest.TestCase):
    def setUp(self):
        self.path = os.path.join(own_folder(self), "restarts")

    def note(self, cause, test):
        with unittest.mock.patch.dict(os.environ, PLUMB_RESTARTS=self.path), unittest.mock.patch.object(sys, "argv", ["/x/" + test]):
            restarts.note(cause, "details")

    def printed(self):
        words = [sys.executable, os.path.join(ROOT, "tests", "support", "restarts.py"), self.path]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout.splitlines()

    def test_a_run_without_restarts_passes(self):
        self.assertEqual(self.printed(), (0, ["0 restarts of tests"]))

    def test_causes_are_counted_with_the_tests(self):
        for test in ("b_test.py", "a_test.py", "b_test.py"):
            self.note(restarts.STANDSTILL, test)
        self.assertEqual(self.printed()[1][1:], ["  3: the computer stood still, at most 8 are acceptable (a_test.py, b_test.py)"])

    def test_more_than_the_limit_fail_the_run(self):
        for cause, limit in restarts.LIMITS.items():
            with self.subTest(cause):
                for _ in range(limit):
                    self.note(cause, "a_test.py")
                self.assertEqual(self.printed()[0], 0)
                self.note(cause, "a_test.py")
                self.assertEqual(self.printed()[0], 1)
                os.remove(self.path)

    def test_tests_that_ctest_lists_are_noted(self):
        failed = self.path + ".failed"
        with open(failed, "w", encoding="utf-8") as file:
            file.write("12:One.Test/0\n3:another_test\n")
        subprocess.run([sys.executable, os.path.join(ROOT, "tests", "support", "restarts.py"), self.path, failed], check=True)
        self.assertEqual(self.printed(), (0, ["2 restarts of tests", "  2: it failed beside other tests, at most 5 are acceptable (One.Test/0, another_test)"]))

    def test_a_test_by_itself_notes_nothing(self):
        with unittest.mock.patch.dict(os.environ):
            os.environ.pop("PLUMB_RESTARTS", None)
            restarts.note(restarts.RACE)
        self.assertFalse(os.path.exists(self.path))


if __name__ == "__main__":
    unittest.main()

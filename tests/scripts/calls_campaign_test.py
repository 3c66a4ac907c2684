# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/campaign calls: it finds what programs do wrong when a call fails, and Plumb's do nothing of it."""

import errno
import os
import random
import subprocess
import unittest
from unittest import mock

import calls
from tree import ROOT, own_folder

# A program that copies a file as its first argument says.
COPY = """
import os, sys
text = open("from").read()
{ending}
"""
WELL = 'open(".new", "w").write(text * 3000)\nos.replace(".new", "to")\nprint("done")'
ENDINGS = {
    "Traceback": 'open("to", "w").write(text * 3000)',
    "half written": 'file = open("to", "w")\ntry:\n    file.write(text * 3000)\n    file.close()\n'
                    'except OSError as error:\n    os._exit(print(error, file=sys.stderr) or 1)',
    "without a word": 'try:\n    ' + WELL.replace("\n", "\n    ") + '\nexcept OSError:\n    os._exit(1)',
    "exit status 0, with another to": 'try:\n    ' + WELL.replace("\n", "\n    ") + '\nexcept OSError:\n    os._exit(0)',
    "ended by signal 6": 'try:\n    ' + WELL.replace("\n", "\n    ") + '\nexcept OSError:\n    print("x", file=sys.stderr)\n    os.abort()',
    "does not end": 'import time\nwhile True:\n    try:\n        ' + WELL.replace("\n", "\n        ")
                    + '\n        break\n    except OSError:\n        time.sleep(0.1)',
}


class Copy(calls.Program):
    own_files = ("to",)
    ours = (calls.PYTHON,)

    def __init__(self, ending):
        super().__init__("copy")
        self.ending = ending

    def prepare(self, folder):
        calls.write(os.path.join(folder, "from"), "a line\n")
        calls.write(os.path.join(folder, "to"), "old\n")

    def command(self, folder):
        return [calls.PYTHON, "-c", COPY.format(ending=self.ending)]


class Calls(unittest.TestCase):
    def setUp(self):
        os.chmod(own_folder(self), 0o711)

    def attack(self, ending, kind="write", error=errno.ENOSPC):
        with mock.patch.object(calls, "PATIENCE", 3):
            return calls.attack_one(Copy(ending), kind, error, own_folder(self), random.Random(1))

    def test_each_wrong_end_is_found(self):
        for words, ending in ENDINGS.items():
            outcome = self.attack(ending)
            self.assertIn(words, " ".join(outcome.findings))
            self.assertIn("copy, write ENOSPC, number 1 (write ", outcome.findings[0])

    def test_a_good_program_is_left_in_peace(self):
        careful = ('try:\n    ' + WELL.replace("\n", "\n    ").replace('open(".new", "w").write(text * 3000)',
                   'file = open(".new", "w")\n    file.write(text * 3000)\n    file.close()')
                   + '\n    sys.stdout.flush()\nexcept OSError as error:\n    print(error, file=sys.stderr)\n    os._exit(1)')
        outcome = self.attack(careful)
        self.assertEqual(outcome.findings, [])
        self.assertGreater(outcome.tries, 2)

    def test_every_program_and_every_kind_has_its_cases(self):
        self.assertEqual({kind for _, kind, _ in calls.cases()}, set(calls.ERRORS))
        self.assertEqual({its.name for its, _, _ in calls.cases()}, {its.name for its in calls.SCENARIOS})

    def test_a_few_cases_find_nothing(self):
        for case in ("squareness/allocation", "bench/write/ENOSPC", "tool_table_check/name/EACCES", "plumb-retain/open/EMFILE"):
            done = subprocess.run([os.path.join(ROOT, "scripts", "campaign"), "calls", "--case", case, "--seed", "1", "--most", "4"],
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=200, check=False)
            self.assertRegex(done.stdout, r"\Aseed 1: \d+ tries, 0 findings\n\Z", case + done.stderr)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/campaign: what all campaigns have in common, with an attack made for the test."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ATTACK = """
import sys
sys.path.insert(0, {folder!r})
import campaign
campaign.run("odd", "Finds every third seed.",
             lambda seed: campaign.Outcome(10, ["a third"] if seed % 3 == 0 else []))
"""


class Campaign(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.build = folder.name
        self.record = os.path.join(self.build, "campaigns", "odd.json")

    def odd(self, *arguments):
        code = ATTACK.format(folder=os.path.join(ROOT, "scripts", "campaigns"))
        return subprocess.run([sys.executable, "-c", code, *arguments], env={**os.environ, "PLUMB_BUILD": self.build},
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False)

    def test_a_run_goes_on_where_the_last_one_ended(self):
        first, second = self.odd("--count", "4"), self.odd("--count", "2")
        self.assertEqual((first.returncode, second.returncode), (1, 1))
        self.assertIn("This run: seeds 1 to 4, 1 findings.", first.stdout)
        self.assertIn("seed 6: a third\n", second.stdout)
        self.assertIn("In all: seeds 1 to 6, 60 tries", second.stdout)
        self.assertEqual(self.odd("--count", "2").returncode, 0)

    def test_a_seed_can_be_repeated_and_leaves_the_record_alone(self):
        self.odd("--count", "1")
        self.assertEqual(self.odd("--seed", "3").returncode, 1)
        self.assertEqual(self.odd("--seed", "4").returncode, 0)
        with open(self.record, encoding="utf-8") as file:
            self.assertEqual(json.load(file)["next_seed"], 2)

    def test_fresh_forgets(self):
        self.odd("--count", "4")
        self.assertIn("This run: seeds 1 to 1,", self.odd("--fresh", "--count", "1").stdout)

    def test_the_time_is_over(self):
        self.assertIn("In all: seeds 1 to", self.odd("--for", "0.2s").stdout)

    def test_what_is_not_understood_is_refused(self):
        for arguments in (["--for", "soon"], ["--count", "0"], ["--seed", "-1"], ["--for", "1s", "--count", "1"]):
            self.assertEqual(self.odd(*arguments).returncode, 2, arguments)

    def test_a_damaged_record_is_named(self):
        self.odd("--count", "1")
        with open(self.record, "w", encoding="utf-8") as file:
            file.write("{")
        outcome = self.odd("--count", "1")
        self.assertEqual(outcome.returncode, 1)
        self.assertIn(f"{self.record} is not a record of a campaign", outcome.stderr)

    def test_an_unknown_campaign_shows_those_there_are(self):
        outcome = subprocess.run([os.path.join(ROOT, "scripts", "campaign"), "campaign"], capture_output=True, text=True, check=False)
        self.assertEqual(outcome.returncode, 2)
        self.assertIn("Campaigns:", outcome.stderr)


if __name__ == "__main__":
    unittest.main()

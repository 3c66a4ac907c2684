# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/campaign: the common parts of all campaigns, with an attack made for the test."""

import json
import os
import subprocess
import sys
import unittest

from tree import ROOT, own_folder

ATTACK = """
import sys
sys.path.insert(0, {folder!r})
import campaign
campaign.run("odd", "Finds every third seed.",
             lambda seed: campaign.Outcome(10, ["a third"] if seed % 3 == 0 else []))
"""


class Campaign(unittest.TestCase):
    def setUp(self):
        self.build = own_folder(self)
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

    def test_a_run_can_begin_with_a_seed_and_leaves_the_record_alone(self):
        self.odd("--count", "1")
        outcome = self.odd("--seed", "5", "--count", "3")
        self.assertIn("seed 6: a third\nThis run: seeds 5 to 7, 1 findings.\nIn all: seeds 5 to 7, 30 tries", outcome.stdout)
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



class Bytes(unittest.TestCase):
    """scripts/campaign bytes with stand-ins for cmake and for the readers that clang would build."""

    def setUp(self):
        self.build = own_folder(self)
        os.makedirs(os.path.join(self.build, "bytes"))
        self.program("bytes/build.ninja", "")
        self.program("cmake", "exit 0")

    def program(self, name, script):
        path = os.path.join(self.build, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii") as file:
            file.write("#!/bin/sh\n" + script)
        os.chmod(path, 0o755)

    def attack(self, script, *arguments):
        self.program("bytes/tests/readers/readers", script)
        environment = {**os.environ, "PLUMB_BUILD": self.build, "PATH": self.build + os.pathsep + os.environ["PATH"]}
        return subprocess.run([os.path.join(ROOT, "scripts", "campaign"), "bytes", *arguments], env=environment,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False)

    def test_each_seed_is_a_reader_and_its_tries_are_counted(self):
        outcome = self.attack('echo "stat::number_of_executed_units: 7" >&2; echo $PLUMB_READER >>$(dirname "$0")/log', "--count", "3")
        self.assertEqual(outcome.returncode, 0, outcome.stderr)
        self.assertIn("seeds 1 to 3, 21 tries", outcome.stdout)
        with open(os.path.join(self.build, "bytes", "tests", "readers", "log"), encoding="ascii") as log:
            self.assertEqual(len(set(log.read().split())), 3)

    def test_a_finding_has_its_sentence_and_the_bytes_that_repeat_it(self):
        outcome = self.attack('echo "demanded: it is true" >&2; echo "artifact_prefix=; Test unit written to /x/crash-1" >&2; exit 77',
                              "--count", "1", "--reader", "chain")
        self.assertEqual(outcome.returncode, 1)
        self.assertRegex(outcome.stdout, "seed 1: chain: it is true; repeat it by PLUMB_READER=chain .*readers /x/crash-1\n")

    def test_what_leaves_no_bytes_leaves_its_words(self):
        outcome = self.attack("echo no reader >&2; exit 2", "--count", "1", "--reader", "chain")
        log = os.path.join(self.build, "campaigns", "bytes", "findings", "chain.log")
        self.assertIn(f"chain: exit status 2; see {log}", outcome.stdout)
        with open(log, encoding="ascii") as file:
            self.assertEqual(file.read(), "no reader\n")

    def test_each_reader_has_a_corpus(self):
        readers = {name[:-4] for name in os.listdir(os.path.join(ROOT, "tests", "readers")) if name.endswith(".cpp")}
        self.assertEqual(readers - {"reader", "corpus"}, set(os.listdir(os.path.join(ROOT, "tests", "corpus"))))


if __name__ == "__main__":
    unittest.main()

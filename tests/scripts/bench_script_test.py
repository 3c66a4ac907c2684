# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench: finds each bench by its file, and lists them all."""

import ast
import glob
import os
import subprocess
import unittest

from tree import ROOT

BENCHES = os.path.join(ROOT, "scripts", "benches")
NAMES = sorted(os.path.basename(path)[:-3] for path in glob.glob(os.path.join(BENCHES, "[a-z]*.py")))


def parsed(*path):
    with open(os.path.join(BENCHES, *path), encoding="utf-8") as file:
        return ast.parse(file.read())


def imported(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


class Usage(unittest.TestCase):
    def run_script(self, *words):
        script = os.path.join(ROOT, "scripts", "bench")
        return subprocess.run([script, *words], capture_output=True, text=True, timeout=60, check=False)

    def test_without_a_name_every_bench_is_listed_with_its_first_sentence(self):
        done = self.run_script()
        self.assertEqual(done.returncode, 2)
        self.assertIn("mill", NAMES)
        for name in NAMES:
            sentence = ast.get_docstring(parsed(name + ".py")).splitlines()[0]
            self.assertRegex(done.stderr, rf"(?m)^ +{name} +")
            self.assertIn(sentence, done.stderr)

    def test_what_is_no_bench_is_answered_by_the_list(self):
        for word in ("press", "support", "__main__", "../setup", "--help"):
            done = self.run_script(word)
            self.assertEqual((done.returncode, done.stderr), (2, self.run_script().stderr), word)


class Arrows(unittest.TestCase):
    def test_helpers_import_no_bench_and_benches_no_other(self):
        helpers = [os.path.relpath(path, BENCHES) for path in glob.glob(os.path.join(BENCHES, "support", "*.py"))]
        self.assertGreater(len(helpers), 5)
        for path in helpers + [name + ".py" for name in NAMES]:
            self.assertEqual([name for name in imported(parsed(path)) if name in NAMES], [], path)


if __name__ == "__main__":
    unittest.main()

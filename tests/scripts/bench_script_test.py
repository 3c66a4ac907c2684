# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench: finds each bench by its file, lists them all, and builds what a bench needs."""

import ast
import glob
import graphlib
import os
import re
import shutil
import subprocess
import unittest

from tree import BUILD, ROOT, own_folder

BENCHES = os.path.join(ROOT, "scripts", "benches")
NAMES = sorted(os.path.basename(path)[:-3] for path in glob.glob(os.path.join(BENCHES, "[a-z]*.py")))


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def parsed(*path):
    return ast.parse(text_of(os.path.join(BENCHES, *path)))


def imported(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"support.{name.name}" for name in node.names) if node.module == "support" else [node.module]


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
            self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", self.run_script().stderr), word)


class WithoutMatplotlib(unittest.TestCase):
    """The package of Debian does not bring matplotlib along: it is large."""

    def run_without(self, *words):
        folder = own_folder(self)
        with open(os.path.join(folder, "sitecustomize.py"), "w", encoding="utf-8") as file:
            file.write('import sys\nsys.modules["matplotlib"] = None\n')
        return subprocess.run(
            ["/usr/bin/python3", "-B", *words], env={**os.environ, "PYTHONPATH": f"{folder}:{BUILD}/python"},
            capture_output=True, text=True, timeout=60, check=False)

    def test_a_bench_that_draws_names_the_command_before_it_begins(self):
        done = self.run_without(BENCHES, "mill")
        sentence = "mill needs python3-matplotlib: sudo apt install python3-matplotlib\n"
        self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "", "scripts/bench: " + sentence))

    def test_contacts_name_it_for_a_chart(self):
        recording = os.path.join(own_folder(self), "load.txt")
        with open(recording, "w", encoding="utf-8") as file:
            file.write("0\n")
        done = self.run_without(os.path.join(BUILD, "bin", "plumb-contacts"), recording, "--chart", "chart.png")
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--chart needs python3-matplotlib: sudo apt install python3-matplotlib", done.stderr)


def constants(tree):
    """Name -> value of the constants of a module that are literals."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            found[node.targets[0].id] = node.value.value
    return found


def own_modules(text):
    """The modules of Plumb that HAL lines in a text load."""
    return {name for name in re.findall(r"loadrt +(\w+)", text) if os.path.exists(os.path.join(BUILD, "modules", name + ".so"))}


SOURCES = {"thermal_growth_test": "thermal_growth"}  # a file NAME_test would be taken for a test


class Needs(unittest.TestCase):
    """Each bench states the targets and the packages that it needs."""

    def sources(self, name):
        """The C++ sources of all that is built for a bench, by their place in the tree."""
        words = ["ninja", "-C", BUILD, "-t", "inputs", *constants(parsed(name + ".py"))["TARGETS"].split()]
        lines = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True).stdout.splitlines()
        root, real = os.path.realpath(ROOT), map(os.path.realpath, lines)  # the clone may be reached through a link
        return [os.path.relpath(line, root) for line in real if line.startswith(root) and line.endswith(".cpp")]

    def asked_of_setup(self, *words):
        """The words with which scripts/bench calls scripts/setup."""
        root = own_folder(self)
        shutil.copytree(BENCHES, os.path.join(root, "benches"))
        shutil.copy(os.path.join(ROOT, "scripts", "bench"), root)
        with open(os.path.join(root, "setup"), "w", encoding="ascii") as file:
            file.write("#!/bin/bash\nprintf '%s|' \"$@\"\nexit 1\n")
        os.chmod(os.path.join(root, "setup"), 0o755)
        done = subprocess.run([os.path.join(root, "bench"), *words], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        return done.stdout.split("|")[:-1]

    def test_setup_builds_the_targets_of_the_bench_with_its_packages(self):
        for name in NAMES:
            its = constants(parsed(name + ".py"))
            option, packages, *targets = self.asked_of_setup(name, "--seed", "1")
            self.assertEqual((option, targets), ("--with", its["TARGETS"].split()), name)
            self.assertEqual(packages.split(), ["python3-numpy", *its.get("PACKAGES", "").split()], name)

    def test_cluster_needs_dask_and_the_modules_that_its_workers_have(self):
        option, packages, *targets = self.asked_of_setup("mill", "--cluster", "tcp://mill:8786")
        self.assertEqual((option, targets), ("--with", ["product"]))
        self.assertIn("python3-distributed", packages.split())

    def test_all_that_a_bench_loads_and_starts_is_built(self):
        for name in NAMES:
            paths = [os.path.join(BENCHES, name + ".py")]
            for module in imported(parsed(name + ".py")):
                helper = os.path.join(BENCHES, *module.split(".")) + ".py"
                paths += [helper] if module.startswith("support.") else []
            texts = [text_of(path) for path in paths]
            for machine in set(re.findall(r'"configs", "(\w+)", "bench\.hal"', "".join(texts))):
                texts.append(text_of(os.path.join(ROOT, "configs", machine, "bench.hal")))
            needed = {SOURCES.get(module, module) + ".cpp" for module in own_modules("".join(texts))} | {"plumb_host.cpp"}
            if re.search(r"\b(results_of|law_of)\b", texts[0]):
                needed.add("plumb_growth.cpp")
            self.assertEqual(needed - {os.path.basename(source) for source in self.sources(name)}, set(), name)

    def test_mill_builds_the_host_and_four_modules(self):
        sources = self.sources("mill")
        names = [os.path.basename(source)[:-4] for source in sources if source.startswith("components")]
        self.assertEqual(sorted(names), ["sim_drive_load", "sim_mill", "sim_part_program", "thermal_displacement"])
        self.assertIn("hal/host/plumb_host.cpp", sources)
        self.assertEqual([source for source in sources if source.startswith(("hal/commands", "tests"))], [])


class Arrows(unittest.TestCase):
    def test_helpers_import_no_bench_and_benches_no_other(self):
        helpers = [os.path.relpath(path, BENCHES) for path in glob.glob(os.path.join(BENCHES, "support", "*.py"))]
        self.assertGreater(len(helpers), 5)
        for path in helpers + [name + ".py" for name in NAMES]:
            self.assertEqual([name for name in imported(parsed(path)) if name in NAMES], [], path)

    def test_helpers_do_not_import_each_other_in_a_circle(self):
        paths = glob.glob(os.path.join(BENCHES, "support", "*.py"))
        helpers = {"support." + os.path.basename(path)[:-3]: set(imported(parsed(path))) for path in paths}
        graphlib.TopologicalSorter(helpers).prepare()


if __name__ == "__main__":
    unittest.main()

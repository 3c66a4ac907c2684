# SPDX-License-Identifier: GPL-2.0-or-later
"""README.md and CONTRIBUTING.md say what is there."""

import os
import re
import subprocess
import unittest

from support import simulations  # for the way to plumb.py
from tree import BUILD, ROOT, own_folder


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def block(language, with_word):
    """The README's block in this language that has a word in it."""
    blocks = re.findall(r"```%s\n(.*?)```" % language, read("README.md"), re.S)
    return next(text for text in blocks if with_word in text)


class Links(unittest.TestCase):
    def test_every_file_that_a_page_links_to_exists(self):
        for page in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
            links = re.findall(r"\]\(([^)#]+)\)", read(page))
            for link in links:
                if not link.startswith("http"):
                    self.assertTrue(os.path.exists(os.path.join(ROOT, link)), f"{page}: {link}")

    def test_every_component_in_the_table_is_there(self):
        table = re.findall(r"^\| `(\w+)` \|", read("README.md"), re.M)
        found = []
        for folder in ("modules", "bin"):
            found += [name.partition(".")[0] for name in os.listdir(os.path.join(BUILD, folder))]
        self.assertGreaterEqual(len(table), 4)
        self.assertEqual([name for name in table if name not in found], [])


class Wiring(unittest.TestCase):
    """The lines for a machine's own configuration, on LinuxCNC's motion controller in virtual time."""

    MACHINE = """
loadrt trivkins coordinates=xyz
loadrt tpmod
loadrt homemod
loadrt motmod servo_period_nsec=1000000 num_joints=3
loadrt siggen
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf siggen.0.update servo-thread
net z-position-fb joint.2.motor-pos-cmd => joint.2.motor-pos-fb
net spindle-load siggen.0.cosine
"""

    def test_lines_of_the_readme_load_beside_motmod(self):
        import plumb

        lines = block("hal", "thermal_displacement")
        user_space = [line for line in lines.splitlines() if "iocontrol" in line]
        self.assertEqual(len(user_space), 1)
        with plumb.Host() as host:
            for line in (self.MACHINE + lines).splitlines():
                words = line.split("#")[0].strip()
                if words and line not in user_space:
                    host.command(words)
            host.command("start")
            host.run(1)
            self.assertTrue(host.get("z-growth.enable") and host.get("z-growth.dry-run"))
            self.assertGreater(host.get("z-growth.load-noise"), 0)  # it runs, and hears the load
            self.assertEqual(host.get("z-growth.fault-code"), 0)


class OwnConfiguration(unittest.TestCase):
    """The worked example for those who have a HAL configuration of their own."""

    def setUp(self):
        self.folder = own_folder(self)
        self.write(block("hal", "limit3"))

    def write(self, lines):
        with open(os.path.join(self.folder, "limit.hal"), "w", encoding="utf-8") as file:
            file.write(lines)

    def run_command_of_readme(self):
        command = re.search(r"^    build/bin/(plumb bench limit.hal .*)$", read("README.md"), re.M)[1]
        path = os.path.join(BUILD, "bin") + ":" + os.environ["PATH"]
        return subprocess.run(
            command, shell=True, cwd=self.folder, env=dict(os.environ, PATH=path), capture_output=True, text=True
        )

    def printed_in_readme(self, line):
        return "\n    " + line + "\n" in read("README.md")

    def test_good_configuration_passes_as_printed(self):
        outcome = self.run_command_of_readme()
        self.assertEqual((outcome.returncode, outcome.stderr), (0, ""))
        self.assertTrue(self.printed_in_readme(outcome.stdout.splitlines()[1]), outcome.stdout)

    def test_planted_fault_is_found_as_printed(self):
        fault = re.search(r"`setp limit.maxv \d+`", read("README.md"))[0].strip("`")
        self.write(re.sub(r"setp limit.maxv \d+", fault, block("hal", "limit3")))
        outcome = self.run_command_of_readme()
        self.assertEqual((outcome.returncode, outcome.stderr), (1, ""))
        self.assertEqual(len(outcome.stdout.splitlines()), 3)
        for line in outcome.stdout.splitlines()[1:]:
            self.assertTrue(self.printed_in_readme(line), line)

    def test_same_in_python(self):
        folder = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, folder)
        exec(block("python", "limit.hal").replace("3600", "60"), {})  # pylint: disable=exec-used
        self.write(block("hal", "limit3").replace("maxv 20", "maxv 1200"))
        with self.assertRaises(AssertionError):
            exec(block("python", "limit.hal").replace("3600", "60"), {})  # pylint: disable=exec-used


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the repository agree with the code: links, wiring, printed output."""

import datetime
import glob
import os
import re
import subprocess
import unittest

import panel_texts
import unwritten
from plumb_folder import TemporaryFolder
from support import simulations  # for the way to plumb.py
from tree import BUILD, ROOT, own_folder

PLUMB = os.path.join(BUILD, "bin", "plumb")


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def block(page, language, with_word):
    """The block in this language that has a word in it."""
    blocks = re.findall(r"```%s\n(.*?)```" % language, read(page), re.S)
    return next(text for text in blocks if with_word in text)


def pages():
    """The pages of the first folder, and the README.md of all others."""
    found = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"]
    for top in ("components", "configs", "hal", "scripts"):
        found += glob.glob(top + "/**/README.md", root_dir=ROOT, recursive=True)
    return found


class Versions(unittest.TestCase):
    def test_package_changelog_and_build_name_one_release(self):
        built = re.search(r"project\(plumb VERSION (\S+)", read("CMakeLists.txt"))[1]
        packaged, day = re.search(r"\Aplumb \((\S+)\).*? -- .*?, (.*?) \d\d:", read("debian/changelog"), re.S).groups()
        heading = re.search(r"^## (.*)", read("CHANGELOG.md"), re.M)[1]
        if packaged.startswith(built + "~"):  # before the release
            self.assertEqual(heading, "[Unreleased]")
            return
        released = datetime.datetime.strptime(day, "%d %b %Y").date()
        self.assertEqual(packaged, built)
        self.assertEqual(heading, f"[{built}] - {released}")
        self.assertIn(f'RELEASE_DATE="{released}"', read("hal/CMakeLists.txt"))


class Links(unittest.TestCase):
    def test_every_file_that_a_page_links_to_exists(self):
        for page in pages():
            for link in re.findall(r"\]\(([^)#]+)\)", read(page)):
                if not link.startswith("http"):
                    path = os.path.join(ROOT, os.path.dirname(page), link)
                    self.assertTrue(os.path.exists(path), f"{page}: {link}")

    def test_every_page_of_a_folder_links_to_the_glossary(self):
        for page in pages():
            if page.endswith("README.md"):
                self.assertIn("GLOSSARY.md)", read(page), page)

    def test_the_glossary_is_in_the_order_of_the_alphabet(self):
        terms = [term.lower() for term in re.findall(r"^- (.*?): ", read("GLOSSARY.md"), re.M)]
        self.assertGreater(len(terms), 40)
        self.assertEqual(terms, sorted(terms))

    def test_every_function_in_the_table_is_there(self):
        table = re.findall(r"^\| \[?`(\w+)`", read("README.md"), re.M)
        commands = re.findall(r"^\| `plumb (\w+)`", read("README.md"), re.M)
        found = []
        for folder in ("modules", "bin"):
            found += [name.partition(".")[0] for name in os.listdir(os.path.join(BUILD, folder))]
        self.assertGreaterEqual(len(table), 4)
        self.assertEqual([name for name in table if name not in found], [])
        for command in commands:
            self.assertEqual(subprocess.run([PLUMB, command, "--help"], capture_output=True).returncode, 0, command)

    def test_functions_are_named_and_a_new_one_that_is_not_is_listed(self):
        names = [name for role in ("compensation", "stage") for name in panel_texts.of_role(BUILD, role)]
        self.assertGreaterEqual(len(set(names) - set(unwritten.not_named(BUILD))), 9)
        with TemporaryFolder() as folder:
            os.makedirs(os.path.join(folder, "share", "plumb"))
            with open(os.path.join(folder, "share", "plumb", "cold_cooler.json"), "w", encoding="utf-8") as file:
                file.write('{"role": "compensation"}')
            self.assertEqual(unwritten.not_named(folder), ["cold_cooler"])


class Wiring(unittest.TestCase):
    """The lines for a machine's own configuration, on LinuxCNC's motion controller in virtual time."""

    MOTION = """
loadrt trivkins coordinates=xyz
loadrt tpmod
loadrt homemod
loadrt motmod servo_period_nsec=1000000 num_joints=3 num_dio=32 num_aio=32
"""
    LIMITS = "[JOINT_%d]\nMIN_LIMIT = -400\nMAX_LIMIT = 400\nMAX_ACCELERATION = 2000\n"
    # Instances that a page names, and does not load.
    OTHERS = {
        "growth": "loadrt thermal_displacement names=growth interlock=no",
        "z-stage": "loadrt axis_offset names=z-stage interlock=no",
        "x-stage": "loadrt joint_offset names=x-stage interlock=no",
        "square": "loadrt squareness names=square interlock=no",
        "interlock": "loadrt interlock names=interlock",
        "x-drive": "loadrt lowpass names=x-drive",
        "program": "loadrt sim_part_program names=program",
        "mill": "loadrt sim_mill names=mill",
        "drive": "loadrt sim_drive_load names=drive",
        "centre": "loadrt centre_height names=centre interlock=no",
        "lathe": "loadrt sim_lathe names=lathe",
        "trial": "loadrt sim_trial_cuts names=trial",
        "grinder": "loadrt sim_grinder names=grinder",
        "chop": "loadrt chopping names=chop interlock=no infeed=1",
    }

    def load(self, lines):
        """A host with these lines in it, which runs."""
        import plumb

        host = plumb.Host()
        self.addCleanup(host.close)
        with TemporaryFolder() as folder:
            for name, text in (
                ("wiring.hal", self.MOTION + lines + "\nstart\n"),
                ("wiring.ini", "[TRAJ]\nLINEAR_UNITS = mm\nMAX_LINEAR_VELOCITY = 1000\n" + "".join(self.LIMITS % i for i in range(3))),
            ):
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write(text)
            host.load(os.path.join(folder, "wiring.hal"), ini=os.path.join(folder, "wiring.ini"))
        return host

    @staticmethod
    def without_programs(lines):
        """User-space programs do not run here."""
        lines = re.sub(r"\b(iocontrol\.0|halui|plumb-retain|linuxcnc-link)\.\S+", "", lines)
        return re.sub(r"^net \S+\s+=>\s*$", "", lines, flags=re.M)

    BY_HAND = "components/compensation/squareness/README.md"

    def test_squareness_by_hand_corrects_the_square(self):
        lines = block(self.BY_HAND, "hal", "loadrt joint_offset")
        one_axis = [line for line in lines.splitlines() if re.match(r"(setp|net|addf) x-", line)]
        self.assertGreater(len(one_axis), 12)
        for letter, number in (("y", 1), ("z", 2)):
            for line in one_axis:
                line = re.sub(r"\bx-", letter + "-", line.replace("tooloffset.x", "tooloffset." + letter))
                lines += re.sub(r"(joint\.|JOINT_)0", r"\g<1>%d" % number, line) + "\n"
        drives = "loadrt lowpass names=x-drive,y-drive,z-drive\n"
        for letter in "xyz":
            drives += "net %s-motor-cmd => %s-drive.in\nnet %s-motor-fb %s-drive.out\n" % ((letter,) * 4)
        host = self.load("addf motion-command-handler servo-thread\n" + drives + lines)
        host.run(1)
        for pin in ("square.fault-code", "x-stage.fault-code", "y-stage.fault-code", "z-stage.fault-code"):
            self.assertEqual(host.get(pin), 0, pin)
        for pin, value in (("square.all-homed", 1), ("square.y-position", 300)):
            host.command("unlinkp " + pin)
            host.set(pin, value)
        host.run(2)
        self.assertAlmostEqual(abs(host.get("square.x-correction")), 0.024, delta=1e-4)

    def test_settings_by_hand_are_those_of_the_reading(self):
        command = re.search(r"^    plumb (squareness .*)$", read(self.BY_HAND), re.M)[1]
        printed = subprocess.run([PLUMB, *command.split()], capture_output=True, text=True, check=True).stdout
        angles = r"^ *setp (square\.e[abc]0\w) +(\S+)"
        self.assertEqual(
            re.findall(angles, printed, re.M), re.findall(angles, block(self.BY_HAND, "hal", "loadrt joint_offset"), re.M)
        )

    def test_dry_run_of_thermal_displacement_counts(self):
        lines = block("components/compensation/thermal_displacement/README.md", "hal", "thermal_displacement")
        machine = """
loadrt siggen
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf siggen.0.update servo-thread
net z-motor-fb joint.2.motor-pos-cmd => joint.2.motor-pos-fb
net spindle-load siggen.0.cosine
"""
        host = self.load(machine + self.without_programs(lines))
        host.run(1)
        self.assertTrue(host.get("growth.enable") and host.get("growth.dry-run"))
        self.assertGreater(host.get("growth.load-noise"), 0)  # it runs, and receives the load
        self.assertFalse(host.get("growth.fault"))

    def test_wiring_of_every_manual_page_loads(self):
        names = sorted(name for name in os.listdir(os.path.join(BUILD, "man")) if name.endswith(".9"))
        self.assertGreaterEqual(len(names), 8)
        for name in [*names, "plumb-retain.1"]:
            with self.subTest(page=name):
                command = ["mandoc", "-T", "ascii", os.path.join(BUILD, "man", name)]
                text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
                section = re.search(r"^WIRING\n((?: .*\n|\n)+)", re.sub(".\b", "", text), re.M)[1]
                section = re.sub(r"\\\n +", "", section)
                found = re.findall(r"^ {7,}((?:loadrt|setp|net|addf) .*)$", section, re.M)
                self.assertGreater(len([line for line in found if line.startswith("net")]), 1)
                lines = self.without_programs("\n".join(found))
                loaded = re.findall(r"names=(\S+)", lines)
                used = set(re.findall(r"([a-z][a-z-]*)\.", lines)) - set(",".join(loaded).split(","))
                if re.search("addf x-drive", lines):
                    used.add("x-drive")
                permitted = {instance for instance in used if instance + ".permit" in lines}
                others = []
                for instance, line in self.OTHERS.items():
                    own = re.search(r"^%s names=\S+" % re.sub(" names=.*", " *", line), lines, re.M)
                    if instance in used and own:  # the page loads this module for another instance
                        lines = lines.replace(own[0], own[0] + "," + instance)
                    elif instance in used:
                        others.append(line.replace("=no", "=yes") if instance in permitted else line)
                threads = "" if "motion-controller" in lines else "addf motion-controller servo-thread\n"
                self.load("\n".join(others) + "\n" + threads + lines).run(0.1)


class OwnConfiguration(unittest.TestCase):
    """The worked example for those who have a HAL configuration of their own."""

    HOST = "hal/host/README.md"

    def setUp(self):
        self.folder = own_folder(self)
        self.write(block(self.HOST, "hal", "limit3"))

    def write(self, lines):
        with open(os.path.join(self.folder, "limit.hal"), "w", encoding="utf-8") as file:
            file.write(lines)

    def run_command_of(self, page):
        command = re.search(r"^    (?:build/bin/)?(plumb bench limit.hal .*)$", read(page), re.M)[1]
        path = os.path.join(BUILD, "bin") + ":" + os.environ["PATH"]
        return subprocess.run(
            command, shell=True, cwd=self.folder, env=dict(os.environ, PATH=path), capture_output=True, text=True
        )

    def assert_printed(self, page, line):
        self.assertIn("\n    " + line + "\n", read(page))

    def test_good_configuration_passes_as_printed(self):
        outcome = self.run_command_of(self.HOST)
        self.assertEqual((outcome.returncode, outcome.stderr), (0, ""))
        self.assert_printed(self.HOST, outcome.stdout.splitlines()[1])

    def test_planted_fault_is_found_as_printed(self):
        fault = re.search(r"`setp limit.maxv \d+`", read(self.HOST))[0].strip("`")
        self.write(re.sub(r"setp limit.maxv \d+", fault, block(self.HOST, "hal", "limit3")))
        for page in (self.HOST, "README.md"):
            outcome = self.run_command_of(page)
            self.assertEqual((outcome.returncode, outcome.stderr), (1, ""))
            self.assertEqual(len(outcome.stdout.splitlines()), 3)
            for line in outcome.stdout.splitlines()[1:]:
                self.assert_printed(page, line)

    def test_same_in_python(self):
        folder = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, folder)
        lines = block(self.HOST, "python", "limit.hal").replace("3600", "60")
        exec(lines, {})  # pylint: disable=exec-used
        self.write(block(self.HOST, "hal", "limit3").replace("maxv 20", "maxv 1200"))
        with self.assertRaises(AssertionError):
            exec(lines, {})  # pylint: disable=exec-used


if __name__ == "__main__":
    unittest.main()

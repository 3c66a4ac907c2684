# SPDX-License-Identifier: GPL-2.0-or-later
"""linuxcnc_link and retain in a complete LinuxCNC, ten times faster than the clock, on two days.

PLUMB_BUILD names the build folder.
"""

import os
import subprocess
import tempfile
import unittest

import linuxcnc_runs
from linuxcnc_runs import BUILD, copy_configuration, own_folder

LINK = os.path.join(BUILD, "bin", "linuxcnc_link")
PATIENCE = 100  # s, for what takes a few

HAL = """\
loadrt thermal_displacement names=growth
addf growth.update servo-thread
loadusr -Wn linuxcnc-link {build}/bin/linuxcnc_link --messages $(CONFIG_DIR)/messages.toml
loadusr -W {build}/bin/retain --file $(CONFIG_DIR)/mill.toml
"""

RETAIN = """\
machine = "mill"
pins = ["growth.window"]
records = ["growth"]
every = 0.5
"""

MESSAGES = """\
[[message]]
pin = "refused"
kind = "error"
text = "The reference is refused: {code}"
[message.codes]
1 = "it is of another program"
2 = "it is of other tools"

[[message]]
pin = "hint"
text = "Let it warm up"

[[message]]
pin = "shown"
kind = "display"
text = "Look here"
"""

PROGRAMS = {
    "main.ngc": "(o<none> call)\n; o<none> call\no<first> call [1]\nO<second>CALL\no<first> call\nM2\n",
    "first.ngc": "o<first> sub\no<second> call\no<first> endsub\n",
    "second.ngc": "o<second> sub\nG0 X1\no<second> endsub\n",
    "none.ngc": "o<none> sub\no<none> endsub\n",
    "alone.ngc": "G0 X0\nM2\n",
}


class Days(unittest.TestCase):
    """What the scenario has seen on the first day, and on the second, after a restart of LinuxCNC."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = copy_configuration("three_axis", folder)
        files = dict(PROGRAMS, **{"link.hal": HAL.format(build=BUILD), "messages.toml": MESSAGES, "mill.toml": RETAIN})
        for name, text in files.items():
            with open(os.path.join(machine, name), "w") as file:
                file.write(text)
        ini = os.path.join(machine, "three_axis.ini")
        linuxcnc_runs.use_scenario(ini, "link_scenario.py")
        with open(ini, "a") as file:
            file.write("HALFILE = link.hal\n")
        cls.facts = []
        for _ in range(2):
            told, cls.said = linuxcnc_runs.work(folder, ini)
            cls.facts.append(told["facts"])

    def test_what_was_kept_is_in_force_on_the_second_day(self):
        self.assertEqual(self.facts[0]["in force"], [0.5, 0, 0])
        self.assertEqual(self.facts[1]["in force"], [0.125, 1, 0], self.said)

    def test_no_program_is_known_before_one_is_loaded(self):
        self.assertEqual(self.facts[0]["without a program"], 0)

    def test_the_tool_set_is_that_of_the_table_whatever_is_in_the_spindle(self):
        before, after = self.facts[0]["tools"]
        self.assertEqual(before, after)
        self.assertNotEqual(before, 0)

    def test_the_operator_reads_the_messages(self):
        refused = "The reference is refused: %s"
        self.assertEqual(
            self.facts[0]["messages"],
            [
                [refused % "it is of another program"],
                [refused % "it is of other tools"],
                [refused % "code 9"],
                ["Let it warm up"],
                ["Look here"],
            ],
        )


class Settings(unittest.TestCase):
    """A wrong file of messages is told, and nothing is loaded."""

    def refused(self, text, words):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(text)
            file.flush()
            ended = subprocess.run(
                ["/usr/bin/python3", LINK, "--messages", file.name], capture_output=True, text=True, timeout=PATIENCE
            )
            self.assertEqual(ended.returncode, 1)
            self.assertEqual(ended.stderr.strip(), "linuxcnc_link: %s: %s" % (file.name, words))

    def test_wrong_files_are_told(self):
        good = '[[message]]\npin = "a"\ntext = "b"\n'
        for text, words in (
            ('[[mesage]]\npin = "a"\n', "unknown key 'mesage'"),
            ('[message]\npin = "a"\n', "message is no list of tables: write [[message]]"),
            (good + good, "there are two pins a"),
            (good + '[[message]]\npin = "connected"\ntext = "b"\n', "there are two pins connected"),
            (good + '[[message]]\npin = "c"\n', "message 2: there is no text"),
            (good + "colour = 1\n", "message 1: unknown key 'colour'"),
            (good + 'kind = "shout"\n', "message 1: kind = 'shout' is none of error, text, display"),
            (good.replace('"a"', '"A_b"'), "message 1: pin = 'A_b' is not of a-z, 0-9 and -, at most 24"),
            (good + "codes = 3\n", "message 1: codes is no table"),
            (good + "[message.codes]\nx = 'y'\n", "message 1: codes: invalid literal for int() with base 10: 'x'"),
            (good + "[message.codes]\n1 = 2\n", "message 1: codes: 1 has no text"),
            (good + "[message.codes]\n1 = 'y'\n", "message 1: {code} in the text and a table of codes belong together"),
            (good.replace('"b"', '"%s"' % ("b" * 251)), "message 1: longer than 250 characters: '%s'" % ("b" * 251)),
        ):
            with self.subTest(words):
                self.refused(text, words)

    def test_a_file_that_cannot_be_read_is_told_with_its_line(self):
        self.refused('[[message]]\npin = \n', "Invalid value (at line 2, column 7)")
        ended = subprocess.run(["/usr/bin/python3", LINK, "--messages", "/nowhere.toml"], capture_output=True, text=True)
        self.assertEqual(ended.stderr, "linuxcnc_link: /nowhere.toml: No such file or directory\n")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""Plumb's programs and scripts fail with a message when their output goes to a full disk."""

import os
import subprocess
import unittest

from tree import BUILD, ROOT, own_folder

BIN = os.path.join(BUILD, "bin")
BENCH = "loadrt threads name1=t period1=1000000\nloadrt limit1 names=limit\naddf limit t\n"


def on_full_disk(*command, **options):
    """The exit status of a command whose standard output is /dev/full, and its stderr."""
    with open("/dev/full", "w", encoding="ascii") as full:
        run = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60,
                             check=False, **options)
    return run.returncode, run.stderr


class FullDisk(unittest.TestCase):
    def setUp(self):
        folder = own_folder(self)
        self.hal = os.path.join(folder, "limit.hal")
        with open(self.hal, "w", encoding="ascii") as file:
            file.write(BENCH)

    def assert_told(self, *command, status=1, **options):
        code, words = on_full_disk(*command, **options)
        self.assertEqual(code, status, (command, words))
        self.assertIn("No space left on device", words, command)

    def test_help_pages_and_versions(self):
        plumb, host, retain = (os.path.join(BIN, name) for name in ("plumb", "plumb-host", "plumb-retain"))
        commands = [[plumb], *([plumb, name] for name in ("bench", "doctor", "run", "squareness")), [host], [retain]]
        for command in commands:
            for option in ("--help", "--man"):
                self.assert_told(*command, option)
        for program in (plumb, host):
            self.assert_told(program, "--version")

    def test_pages_of_modules(self):
        self.assert_told(os.path.join(BUILD, "hal", "manual"), os.path.join(BUILD, "modules", "joint_offset.so"))

    def test_results(self):
        plumb = os.path.join(BIN, "plumb")
        self.assert_told(plumb, "squareness")
        self.assert_told(plumb, "squareness", "--lean", "Y+X=0.02mm/300mm")
        self.assert_told(plumb, "bench", self.hal, "--for", "1ms")

    def test_a_failure_keeps_its_status(self):
        self.assert_told(os.path.join(BIN, "plumb"), "bench", self.hal, "--for", "1ms", "--expect", "{limit.out} > 1")
        code, words = on_full_disk(os.path.join(BIN, "plumb"), "bench", "--nonsense")
        self.assertEqual(code, 2, words)

    def test_recordings(self):
        plumb = os.path.join(BIN, "plumb")
        run = subprocess.run([plumb, "bench", self.hal, "--for", "1ms", "--record", "limit.out", "--every", "1ms", "--output", "/dev/full"],
                             stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(run.returncode, 1)
        self.assertIn("/dev/full: No space left on device", run.stderr)

    def test_the_path_of_a_host(self):
        self.assert_told(os.path.join(BIN, "plumb-host"))

    def test_an_output_that_is_not_used_may_be_closed(self):
        run = subprocess.run(f"exec {os.path.join(BIN, 'plumb')} bench {self.hal} >&-", shell=True, stderr=subprocess.PIPE, text=True,
                             timeout=60, check=False)
        self.assertEqual(run.returncode, 2, "a wrong command line")

    def test_programs_in_python(self):
        for name, options in (("plumb-wire", ("--help", "--version", "--summary")), ("plumb-panel", ("--help", "--version", "--summary")),
                              ("plumb-contacts", ("--help", "--summary")), ("can_sensor_dbc", ("--help",))):
            for option in options:
                code, words = on_full_disk(os.path.join(BIN, name), option)
                self.assertEqual(code, 1, (name, option))
                self.assertRegex(words, r"\A(plumb )?[a-z_]+: standard output: No space left on device\n\Z", (name, option))

    def test_tables_of_scripts(self):
        table = "import sys; sys.path.insert(0, 'scripts/benches'); from support import command\nwith command.errors_reported(): print('1 2 3')"
        self.assert_told("/usr/bin/python3", "-c", table, cwd=ROOT)
        code, words = on_full_disk("/usr/bin/python3", os.path.join(BUILD, "bin", "plumb-contacts"), "--help",
                                   env={**os.environ, "PYTHONPATH": os.path.join(BUILD, "python")})
        self.assertNotEqual(code, 0)
        self.assertIn("No space left on device", words)


if __name__ == "__main__":
    unittest.main()

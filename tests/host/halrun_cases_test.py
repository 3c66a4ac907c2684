# SPDX-License-Identifier: GPL-2.0-or-later
"""The unmodified halrun with the virtual-time host behind it, and with LinuxCNC's own realtime side.

A case is a file of halrun_cases/, or some. It prints the same in both: NAME.out on its standard output, NAME.err on the
other. PLUMB_BUILD names the build folder.
"""

import os
import re
import shutil
import subprocess
import unittest

import stock_linuxcnc
from long import long
from tree import BUILD, ROOT, own_folder

CASES = os.path.join(ROOT, "tests", "halrun_cases")
PLUMB = os.path.join(BUILD, "bin", "plumb")
NOBODY = 65534
LIMIT = 60  # s; a case takes about one in real time

# Lines that depend on the machine and its load: rtapi_app's words on its timers and on its user, plumb's on its speed, and
# halcmd's on its patience, a dot at a time.
REMARKS = re.compile(
    r"Note: Using POSIX.*\n|Running with fallback_uid.*\n|plumb run: the computer did not keep up.*\n"
    r"|Waiting for component '\S+' to become ready"
)
DOTS = re.compile(r"^\.+\n?|^\n", re.MULTILINE)


class Cases:
    """The cases, which both sides must do alike."""

    def setUp(self):
        self.folder = own_folder(self)
        shutil.copytree(CASES, self.folder, dirs_exist_ok=True)
        self.environment = dict(stock_linuxcnc.ENVIRONMENT, WORD="ten")

    def command(self, program):
        return program

    def user(self):
        """The user of the programs; None is the user of the tests."""
        return None

    def ran(self, program):
        """The status and the output."""
        done = subprocess.run(
            self.command(program),
            cwd=self.folder,
            env=self.environment,
            user=self.user(),
            group=self.user(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=LIMIT,
        )
        return done.returncode, done.stdout, DOTS.sub("", REMARKS.sub("", done.stderr))

    def expect(self, name, status, *program):
        texts = []
        for kind in ("out", "err"):
            with open(os.path.join(CASES, f"{name}.{kind}"), encoding="ascii") as file:
                texts.append(file.read())
        self.maxDiff = None
        now_status, out, err = self.ran(program)
        self.assertEqual(out, texts[0], err)
        self.assertEqual(err, texts[1])
        self.assertEqual(now_status, status)

    def test_functions_run_in_their_order_and_threads_at_their_periods(self):
        self.expect("threads", 0, "halrun", "-f", "threads.hal")

    def test_threads_and_functions_that_cannot_be_are_refused(self):
        self.expect("threads_refused", 1, "halrun", "-k", "-f", "threads_refused.hal")

    def test_values_have_their_types_and_limits(self):
        self.expect("parameters", 1, "halrun", "-k", "-f", "parameters.hal")

    def test_streams_lose_and_change_no_record(self):
        records = [(i / 8 - 100, i % 2, i + 3000000000, 1500 - i) for i in range(3010)]
        with open(os.path.join(self.folder, "records"), "w", encoding="ascii") as file:
            file.writelines(f"{level} {lamp} {number} {rest}\n" for level, lamp, number, rest in records)
        status, out, err = self.ran(["halrun", "-f", "streams.hal"])
        self.assertEqual((status, err), (0, ""))
        lines = [f"{i} {level:.6f} {lamp} {number} {rest} " for i, (level, lamp, number, rest) in enumerate(records[:3000])]
        self.assertEqual(out.splitlines(), [*lines, "0"])

    def test_personalities_make_pins(self):
        self.expect("personalities", 1, "halrun", "-k", "-f", "personalities.hal")

    def test_two_passes_gather_what_files_load(self):
        self.expect("twopass", 0, "halrun", "twopass.ini")

    def test_save_prints_everything(self):
        self.expect("save", 1, "halrun", "-k", "-f", "save.hal")

    def test_what_was_saved_is_the_same_machine_in_the_next_halrun(self):
        twice = "halrun -f save_once.hal; halrun -f save_twice.hal; diff once.saved twice.saved"
        self.expect("save_twice", 0, "sh", "-ec", twice)

    def test_files_read_files_and_settings(self):
        self.expect("source", 1, "halrun", "-k", "-i", "source.ini", "-f", "source.hal")

    def test_what_cannot_be_is_refused_in_the_same_words(self):
        self.expect("errors", 1, "halrun", "-k", "-f", "errors.hal")

    def test_halrun_stops_at_an_error(self):
        self.expect("stops", 1, "halrun", "-f", "stops.hal")

    def test_programs_become_components_and_end(self):
        self.expect("programs", 1, "halrun", "-k", "-f", "programs.hal")

    def test_last_unload_makes_a_fresh_hal(self):
        self.expect("again", 1, "halrun", "-k", "-f", "again.hal")

    def test_halrun_knows_tcl(self):
        self.expect("script", 0, "halrun", "script.tcl")

    def test_halrun_takes_commands_from_its_input(self):
        self.expect("typed", 0, "sh", "-c", "halrun -I -s -f saved.hal <typed")

    def test_halcmd_by_itself_loads_and_unloads(self):
        self.expect("session", 0, "sh", "-e", "session")


@long
class Stock(Cases, unittest.TestCase):
    """Proves that the cases expect the behaviour of LinuxCNC."""

    def setUp(self):
        super().setUp()
        command = self.command(["true"])
        done = subprocess.run(command, cwd=self.folder, env=self.environment, capture_output=True, text=True)
        if done.returncode:
            self.skipTest(f"the kernel gives no namespaces: {done.stderr}")

    def command(self, program):
        return stock_linuxcnc.closed_in(program, self.folder)


def enters_the_build(user):
    try:
        return subprocess.run([PLUMB, "--version"], user=user, capture_output=True).returncode == 0
    except PermissionError:
        return False


class Host(Cases, unittest.TestCase):
    """As an ordinary user, where one can enter the build folder: the whole LinuxCNCs of the other tests run as root."""

    @classmethod
    def setUpClass(cls):
        cls.ordinary = NOBODY if os.geteuid() == 0 and enters_the_build(NOBODY) else None

    def setUp(self):
        super().setUp()
        self.environment["HOME"] = os.path.join(self.folder, "home")
        os.mkdir(self.environment["HOME"])
        if self.ordinary is not None:
            for folder, _, files in os.walk(self.folder):
                for name in [folder, *(os.path.join(folder, file) for file in files)]:
                    os.chown(name, self.ordinary, self.ordinary)

    def command(self, program):
        return [PLUMB, "run", "--speed", "20", "--", *program]

    def user(self):
        return self.ordinary


if __name__ == "__main__":
    unittest.main()

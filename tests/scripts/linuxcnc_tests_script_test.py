# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/linuxcnc-tests, on tests made by hand."""

import asyncio
import contextlib
import glob
import io
import os
import sys
import tarfile
import unittest

import linuxcnc_tests
from plumb_folder import TemporaryFolder
from tree import ROOT, own_folder


class AsItIs(linuxcnc_tests.Side):
    """Runs a program with no realtime side at all, and halrun as a shell."""

    def command(self, program, box):
        return ["sh", *program[2:]] if program[0] == "halrun" else program


SIDE = AsItIs("as it is")


class Source(unittest.TestCase):
    """A folder of tests."""

    def setUp(self):
        self.folder = own_folder(self)
        self.source = os.path.join(self.folder, "source")
        self.runs = os.path.join(self.folder, "runs")
        os.mkdir(self.source)

    def write(self, name, text="", mode=0o644):
        path = os.path.join(self.source, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        os.chmod(path, mode)

    def run_test(self, script="test.sh", side=SIDE):
        test = linuxcnc_tests.Test("family/it", script, "halrun")

        async def run():
            return await linuxcnc_tests.Runner(self.source, self.runs, 2).run(test, side)

        return asyncio.run(run())


class Selection(Source):
    def names(self):
        return [test.name for test in linuxcnc_tests.halrun_tests(self.source)]

    def test_every_test_hal_needs_halrun_only(self):
        self.write("b/test.hal", "loadusr -w python3 x.py")
        self.write("a/deep/test.hal")
        self.write("a/deep/other.hal")
        self.assertEqual(self.names(), ["a/deep", "b"])

    def test_test_sh_needs_halrun_only_if_it_has_no_word_of_more(self):
        self.write("alone/test.sh", "halrun x.hal")
        self.write("without/test.sh", "halcmd x.hal")
        for word in ("linuxcnc -r x.ini", "halcompile x.comp", "python3 x.py"):
            self.write(f"{word.split()[0]}/test.sh", f"halrun x.hal\n{word}")
        self.assertEqual(self.names(), ["alone"])

    def test_file_skip_skips_unless_it_is_run_and_succeeds(self):
        self.write("a/test.hal")
        self.write("b/test.hal")
        self.write("b/skip")
        for name, status in (("c", 1), ("d", 0)):
            self.write(f"{name}/test.hal")
            self.write(f"{name}/skip", f"#!/bin/sh\nexit {status}", 0o755)
        skipped = [test.skipped for test in linuxcnc_tests.halrun_tests(self.source)]
        self.assertEqual(skipped, [False, True, True, False])


class Verdict(Source):
    def test_what_is_printed_must_be_what_is_expected(self):
        self.write("family/it/test.sh", "echo one; echo not that >&2")
        self.write("family/it/expected", "one\n")
        self.assertEqual(self.run_test().failure, "")
        self.write("family/it/expected", "two\n")
        self.assertIn("-two\n+one", self.run_test().failure)

    def test_checkresult_has_the_word_where_there_is_one(self):
        self.write("family/it/test.sh", "echo one")
        self.write("family/it/checkresult", '#!/bin/sh\ngrep two "$1"', 0o755)
        self.assertIn("its checkresult ended with status 1", self.run_test().failure)
        self.write("family/it/checkresult", '#!/bin/sh\ngrep one "$1"', 0o755)
        self.assertEqual(self.run_test().failure, "")

    def test_failing_script_fails_with_any_output(self):
        self.write("family/it/test.sh", "exit 3")
        self.write("family/it/expected")
        self.assertIn("ended with status 3", self.run_test().failure)

    def test_nothing_to_compare_with_is_a_failure(self):
        self.write("family/it/test.sh")
        self.assertIn("neither checkresult nor expected", self.run_test().failure)

    def test_script_that_does_not_end_is_ended(self):
        self.addCleanup(setattr, linuxcnc_tests, "LIMIT", linuxcnc_tests.LIMIT)
        linuxcnc_tests.LIMIT = {"halrun": 1}
        number = os.path.join(self.folder, "number")
        self.write("family/it/test.sh", f"echo $$ >{number}; sleep 50; true")
        outcome = self.run_test()
        with open(number, encoding="ascii") as file:
            self.assertFalse(os.path.exists(f"/proc/{file.read().strip()}"))
        self.assertIn("did not end in time", outcome.failure)
        self.assertLess(outcome.seconds, 5)

    def test_second_try_is_fair_and_a_third_is_not(self):
        count = os.path.join(self.folder, "count")
        for succeeds, failure in ((2, False), (3, True)):
            self.write("family/it/test.sh", f"echo >>{count}; [ $(wc -l <{count}) = {succeeds} ]")
            self.write("family/it/expected")
            outcome = self.run_test()
            self.assertEqual((bool(outcome.failure), len(outcome.tries_before)), (failure, 1))
            os.remove(count)

    def test_overrun_is_tried_again_up_to_ten_times(self):
        self.write("family/it/expected", "one\n")
        count = os.path.join(self.folder, "count")
        self.write("family/it/test.hal", f"echo >>{count}; [ $(wc -l <{count}) = 4 ] || echo overrun; echo one")
        outcome = self.run_test("test.hal")
        self.assertEqual((outcome.failure, len(outcome.tries_before)), ("", 3))
        self.write("family/it/test.hal", "echo overrun")
        outcome = self.run_test("test.hal")
        self.assertIn("overran", outcome.failure)
        self.assertEqual(len(outcome.tries_before), 9)

    def test_test_has_its_own_copy_with_what_its_family_shares(self):
        self.write("family/common", "one")
        self.write("family/it/test.sh", 'cat ../common; echo two >../common; [ "$PWD" = "$TEST_DIR" ]')
        self.write("family/it/expected", "one")
        for _ in range(2):
            self.assertEqual(self.run_test().failure, "")

    def test_copy_of_a_failed_test_is_kept_with_what_it_printed(self):
        self.write("family/it/test.sh", "echo one; exit 1")
        folder = self.run_test().failure.split("\nin ")[-1]
        with open(os.path.join(folder, "result"), encoding="ascii") as file:
            self.assertEqual(file.read(), "one\n")


class Closed(Source):
    def test_stock_meets_nothing_of_this_machine(self):
        try:
            linuxcnc_tests.need_spaces(self.source)
        except linuxcnc_tests.Trouble as trouble:
            self.skipTest(str(trouble))
        self.write("family/common", "shared\n")
        ours = [os.readlink(f"/proc/self/ns/{kind}") for kind in ("ipc", "mnt", "net", "pid", "user")]
        script = "cat ../common; ls $HOME; ps ax | wc -l; id -u; ip -brief link | cut -d ' ' -f 1"
        script += f"; readlink /proc/self/ns/* | grep -cxFe {' -e '.join(ours)}"
        self.write("family/it/test.sh", f"{script}; touch {self.folder}.mine")
        self.write("family/it/expected", "shared\n4\n1000\nlo\n0\n")
        self.assertEqual(self.run_test(side=linuxcnc_tests.STOCK).failure, "")
        self.assertFalse(os.path.exists(f"{self.folder}.mine"))


class Comparison(unittest.TestCase):
    test = linuxcnc_tests.Test("it", "test.sh", "halrun")
    good = [linuxcnc_tests.Outcome(seconds=1.25)]
    bad = [linuxcnc_tests.Outcome(failure="wrong", tries_before=["wrong, too"])]

    def worse(self, **sides):
        named = {"stock": linuxcnc_tests.STOCK, "host": linuxcnc_tests.host("20")}
        return linuxcnc_tests.host_is_worse({named[name]: {self.test: tried} for name, tried in sides.items()})

    def test_host_must_not_fail_what_stock_passes(self):
        self.assertTrue(self.worse(stock=self.good, host=self.bad))
        self.assertFalse(self.worse(stock=self.good, host=self.good))
        self.assertFalse(self.worse(stock=self.bad, host=self.bad))
        self.assertFalse(self.worse(stock=self.bad))
        self.assertTrue(self.worse(host=self.bad))
        self.assertFalse(self.worse(stock=[None], host=[None]))

    def test_cells(self):
        self.assertEqual(linuxcnc_tests.cell([None]), "skipped")
        self.assertEqual(linuxcnc_tests.cell(self.good), "pass    1.2 s")
        self.assertEqual(linuxcnc_tests.cell(self.good + self.bad), "FAIL 1/2    0.6 s +1")
        self.assertEqual(linuxcnc_tests.total(self.good + self.bad + [None]), "1/2    1.2 s +1")

    def test_whole_run_prints_a_row_each_and_what_failed(self):
        with TemporaryFolder() as folder:
            os.makedirs(os.path.join(folder, "source", "it"))
            for name, text in (("test.sh", "echo one"), ("expected", "two\n")):
                with open(os.path.join(folder, "source", "it", name), "w", encoding="ascii") as file:
                    file.write(text)

            async def run():
                runner = linuxcnc_tests.Runner(os.path.join(folder, "source"), os.path.join(folder, "runs"), 2)
                linuxcnc_tests.print_failures(await linuxcnc_tests.run_tests([self.test], [SIDE], runner, 2))

            with contextlib.redirect_stdout(io.StringIO()) as said:
                asyncio.run(run())
        lines = said.getvalue().splitlines()
        self.assertEqual([" ".join(line.split()[:n]) for line, n in zip(lines[1:3], (3, 2))], ["it FAIL 0/2", "passed 0/2"])
        self.assertEqual(lines.count("it, as it is, try 2: printed something else than expected"), 2)


class Package(Source):
    def pack(self, name, members):
        with tarfile.open(os.path.join(self.folder, name), "w:xz") as archive:
            for path, text in members.items():
                member = tarfile.TarInfo(path)
                member.size = len(text)
                archive.addfile(member, io.BytesIO(text))

    def test_tests_come_from_the_original_archive(self):
        self.pack("l_1.orig.tar.xz", {"l-1/tests/a/test.hal": b"one", "l-1/src/tests/x": b"", "l-1/testsuite": b""})
        self.pack("l_1-1.debian.tar.xz", {"debian/patches/x": b"--- a/src/x.c\n+++ b/src/x.c\n"})
        linuxcnc_tests.unpack_tests(self.folder)
        found = [name for name in glob.glob("**", root_dir=self.folder, recursive=True) if not name.endswith(".xz")]
        self.assertEqual(sorted(found), ["source", "tests", "tests/a", "tests/a/test.hal"])

    def test_patch_of_a_test_is_refused(self):
        self.pack("l_1.orig.tar.xz", {"l-1/tests/a/test.hal": b"one"})
        self.pack("l_1-1.debian.tar.xz", {"debian/patches/x": b"--- a/tests/a/test.hal\n+++ b/tests/a/test.hal\n"})
        with self.assertRaisesRegex(linuxcnc_tests.Trouble, "debian/patches/x changes the tests"):
            linuxcnc_tests.unpack_tests(self.folder)


class Command(unittest.TestCase):
    def test_wrong_options_are_refused(self):
        for wrong in (["--speed", "fast"], ["--repeat", "0"], ["--halrun", "--whole"], ["--stock-only", "--host-only"]):
            script = os.path.join(ROOT, "scripts", "linuxcnc_tests.py")
            done = os.spawnv(os.P_WAIT, sys.executable, [sys.executable, script, *wrong])
            self.assertEqual(done, 2)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of configs/lathe that need no LinuxCNC: the check of the tool table, and the gauges."""

import math
import os
import runpy
import socket
import subprocess
import time
import unittest

from plumb_folder import TemporaryFolder
from support import simulations  # noqa: F401  for the way to plumb.py
from tree import BUILD, ROOT

CHECK = os.path.join(ROOT, "configs", "functions", "centre_height", "tool_table_check")
SERVER = os.path.join(ROOT, "tests", "programs", "modbus_server.py")
GAUGE = os.path.join(ROOT, "configs", "lathe", "%s_gauge.hal")
WHOLE = "T1   P1   D+0.800000 X-100.017478 Y-0.098484 Q2 ;turning tool\nT2 P2 X-115 ;fine\n"


def read(path):
    with open(path, encoding="ascii") as file:
        return file.read()


def write(path, text):
    with open(path, "w", encoding="ascii") as file:
        file.write(text)


class ToolTable(unittest.TestCase):
    def answer(self, table, **copies):
        """Exit status and message of the check; copies by the digits of their date."""
        with TemporaryFolder() as folder:
            for name, text in {"tool.tbl": table, **{"tool.tbl.%s" % day[1:]: text for day, text in copies.items()}}.items():
                if text is not None:
                    with open(os.path.join(folder, name), "w") as file:
                        file.write(text)
            done = subprocess.run([CHECK, "tool.tbl"], cwd=folder, capture_output=True, text=True, check=False)
            return done.returncode, done.stderr

    def test_whole_tables_are_silent(self):
        self.assertEqual(self.answer(WHOLE), (0, ""))
        self.assertEqual(self.answer(WHOLE, d20261101=WHOLE), (0, ""))
        self.assertEqual(self.answer(WHOLE + "T7 P7 Z-1.5\n", d20261101=WHOLE), (0, ""), "a new tool")
        self.assertEqual(self.answer("; mine\n\n" + WHOLE), (0, ""))

    def test_every_kind_of_damage_offers_the_last_whole_copy(self):
        for damaged, reason in (
            ("", "it is empty"),
            (WHOLE[:20], "its last line has no end"),
            (WHOLE.replace("X-100.017478", "X-100.0.7478"), "line 1 has 'X-100.0.7478'"),
            (WHOLE.replace("T2 P2", "P2"), "line 2 has no T or no P"),
            (WHOLE.replace("D+0.8", "\0\0\0\0\0"), "it holds bytes that are no text"),
            (None, "No such file"),
        ):
            with self.subTest(reason):
                status, message = self.answer(damaged, d20261102=WHOLE, d20261103="T1 P")
                self.assertEqual(status, 1)
                self.assertIn(reason, message)
                self.assertIn("tool_table_check --restore tool.tbl", message)
                self.assertIn("Damaged copies are not used: tool.tbl.20261103.", message)

    def test_no_copy_is_chosen_by_its_date(self):
        status, message = self.answer("T1 P1 X", d20261101="T1 P1 X1\n", d20991231="T9 P9 X9\n")
        self.assertEqual(status, 1)
        self.assertIn("Its copies have no numbers, so the last one is not known: tool.tbl.20991231, tool.tbl.20261101.", message)
        self.assertNotIn("--restore", message)
        self.assertEqual(self.answer(WHOLE, d20261101=WHOLE, d20991231="T9 P9 X9\n"), (0, ""))

    def test_no_copy_with_a_flipped_bit_is_used(self):
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table, WHOLE)
            subprocess.run([CHECK, "--copy", table], check=True)
            with open(table + ".copy-1", "rb") as file:
                good = file.read()
            copies = runpy.run_path(CHECK)["copies"]
            self.assertEqual(copies(table), ([(1, table + ".copy-1", WHOLE)], []))
            for bit in range(8 * len(good)):
                flipped = bytearray(good)
                flipped[bit // 8] ^= 1 << bit % 8
                with open(table + ".copy-1", "wb") as file:
                    file.write(flipped)
                self.assertEqual(copies(table), ([], [table + ".copy-1"]), (bit, bytes(flipped)))
            write(table, "T1")
            done = subprocess.run([CHECK, table], capture_output=True, text=True, check=False)
            self.assertIn("There is no whole copy of it.\nDamaged copies are not used: %s.copy-1." % table, done.stderr)
            write(table, WHOLE)
            subprocess.run([CHECK, "--copy", table], check=True)
            self.assertEqual([number for number, _, _ in copies(table)[0]], [2], "the damaged copy is not overwritten")

    def test_a_copy_of_before_without_a_checksum_is_used(self):
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table + ".copy-4", "; copy 4 of tool.tbl\n" + WHOLE)
            write(table, "T1")
            subprocess.run([CHECK, "--restore", table], check=True, stdout=subprocess.DEVNULL)
            self.assertEqual(read(table), WHOLE)

    def test_without_a_copy_it_says_so(self):
        status, message = self.answer("T1 P1 X")
        self.assertEqual(status, 1)
        self.assertIn("There is no whole copy of it", message)

    def asked(self, table):
        """The question about a table, and the answer of nobody."""
        done = subprocess.run([CHECK, table], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""), "a question never stops the start")
        return done.stdout

    def test_what_was_changed_while_linuxcnc_was_off_is_asked_about_and_kept_or_taken_back(self):
        for now, row in (
            (WHOLE.replace("X-115", "X-115.01"), "T2 was X-115, is X-115.01. To take it back: G10 L1 P2 X-115"),
            (WHOLE.replace("X-115", "X-117"), "T2 was X-115, is X-117. To take it back: G10 L1 P2 X-115"),
            (WHOLE.replace("D+0.800000", "D+0.4"), "T1 was D0.8, is D0.4. To take it back: G10 L1 P1 R0.4"),
            (WHOLE.splitlines()[0] + "\n", "T2 is removed; it was P2 X-115."),
        ):
            with self.subTest(row), TemporaryFolder() as folder:
                table = os.path.join(folder, "my tool.tbl")
                write(table, WHOLE)
                subprocess.run([CHECK, "--copy", table], check=True)
                self.assertEqual(self.asked(table), "")
                write(table, now)
                self.assertIn(row, self.asked(table))
                self.assertIn("To keep all: M159 P1", self.asked(table))
                subprocess.run([CHECK, "--accept", table], check=True)
                self.assertEqual(self.asked(table), "", "once")

    def test_every_digit_that_flips_is_asked_about(self):
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table, WHOLE)
            subprocess.run([CHECK, "--copy", table], check=True)
            its = runpy.run_path(CHECK)
            last = its["tools"](WHOLE)
            places = [place for place, letter in enumerate(WHOLE) if letter.isdigit()]
            self.assertGreater(len(places), 20)
            for place in places:
                for bit in range(4):
                    text = WHOLE[:place] + chr(ord(WHOLE[place]) ^ 1 << bit) + WHOLE[place + 1 :]
                    try:
                        found = its["changes"](last, its["tools"](text))
                    except ValueError:
                        continue  # damaged: LinuxCNC does not start
                    self.assertTrue(found, text)

    def test_what_linuxcnc_writes_while_it_runs_is_right(self):
        """A wear correction, then the next start."""
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table, WHOLE)
            watch = runpy.run_path(CHECK)["Watch"]
            its = watch(table)
            self.assertFalse(its.asked)
            self.assertEqual(len(os.listdir(folder)), 2, "the first copy")
            for wear in range(1, 100):
                write(table, WHOLE.replace("X-115", "X%.6f" % (-115 - 0.01 * wear)))
                its.look()
                its.look()
                self.assertFalse(watch(table).asked, wear)
            write(table, WHOLE[:30])  # LinuxCNC writes it in place
            its.look()
            its.look()
            self.assertEqual(len([name for name in os.listdir(folder) if "copy" in name]), 100)

    def test_a_question_is_open_until_it_is_answered(self):
        watch = runpy.run_path(CHECK)["Watch"]
        changed = WHOLE.replace("X-115", "X-115.01")
        for answer in ("keep", "take back"):
            with self.subTest(answer), TemporaryFolder() as folder:
                table = os.path.join(folder, "tool.tbl")
                write(table, WHOLE)
                subprocess.run([CHECK, "--copy", table], check=True)
                write(table, changed)
                its = watch(table)
                self.assertEqual(list(its.asked), [2])
                write(table, changed.replace("X-100.017478", "X-100.02"))  # LinuxCNC writes another tool
                its.look()
                its.look()
                self.assertEqual(list(its.asked), [2])
                if answer == "keep":
                    subprocess.run([CHECK, "--accept", table], check=True)
                else:
                    write(table, WHOLE.replace("X-115", "X-115.000000"))  # G10 L1 P2 X-115
                its.look()
                self.assertFalse(its.asked)
                its.look()
                self.assertFalse(watch(table).asked, "the next start")

    def test_a_damaged_table_is_mended_without_losing_what_is_newer_than_the_copy(self):
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table, WHOLE)
            subprocess.run([CHECK, "--copy", table], check=True)
            newer = WHOLE.replace("X-100.017478", "X-100.03")
            write(table, newer[:-4])
            done = subprocess.run([CHECK, "--restore", table], capture_output=True, text=True, check=True)
            self.assertEqual(read(table), newer)
            self.assertIn("kept, newer than the copy:  T1", done.stdout)
            self.assertIn("from the last copy:         T2", done.stdout)
            self.assertIn("T1 was X-100.017478, is X-100.03", self.asked(table))

    def test_the_last_copy_is_the_one_with_the_highest_number_whatever_the_clock_shows(self):
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table + ".2099-01-01-00-00-00", "T1 P1 X9\nT9 P9\n")
            for number in range(1, 12):
                write(table, "T1 P1 X%d\n" % number)
                subprocess.run([CHECK, "--copy", table], check=True)
                os.utime(table + ".copy-%d" % number, (1e9 - number, 1e9 - number))
            self.assertRegex(read(table + ".copy-11"), r"\A; copy 11 of tool.tbl, CRC-32 [0-9a-f]{8}\nT1 P1 X11\n\Z")
            self.assertEqual(subprocess.run([CHECK, table], check=False).returncode, 0, "T9 is of an older copy")
            write(table, "T1")
            subprocess.run([CHECK, "--restore", table], check=True, stdout=subprocess.DEVNULL)
            self.assertEqual(read(table), "T1 P1 X11\n")

    def test_a_damaged_table_is_not_copied(self):
        with TemporaryFolder() as folder:
            table = os.path.join(folder, "tool.tbl")
            write(table, "T1 P1 X")
            done = subprocess.run([CHECK, "--copy", table], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("its last line has no end", done.stderr)
            self.assertEqual(os.listdir(folder), ["tool.tbl"])


def measure_two_lands(test, host, show):
    """Two lands of a tool that is 0.05 mm high; show(diameter) is the reading of the gauge."""
    for y in (1, -1):
        show(20)  # far off, until it has settled
        host.set("centre.y-position-0", y)
        host.set("centre.cut-done", True)
        host.run(0.5)
        test.assertTrue(host.get("centre.measure"))
        show(2 * math.hypot(5, y + 0.05))
        host.run(1)
        test.assertFalse(host.get("centre.measure"))
        host.set("centre.cut-done", False)
        host.run(0.01)
    test.assertAlmostEqual(host.get("centre.height"), 0.05, delta=1e-9)


class AnalogGauge(unittest.TestCase):
    def test_two_lands_are_measured_when_the_reading_has_settled(self):
        import plumb

        with plumb.Host() as host:
            for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt centre_height names=centre interlock=no", "newsig gauge-voltage float"):
                host.command(line)
            host.command("net height-measure centre.measure")
            host.load(GAUGE % "analog")
            host.command("addf centre.update servo-thread")
            host.command("start")
            host.set("centre.start", True)
            host.run(0.01)
            measure_two_lands(self, host, lambda diameter: host.set("gauge-voltage", diameter / 2))


class DigitalGauge(unittest.TestCase):
    def test_lands_are_measured_once_the_gauge_has_seen_its_master(self):
        import plumb

        with plumb.Host() as host:
            for line in (
                "loadrt threads name1=servo-thread period1=1000000",
                "loadrt centre_height names=centre interlock=no",
                "newsig gauge-near float",
                "newsig gauge-far float",
                "newsig gauge-master bit",
            ):
                host.command(line)
            host.command("net height-measure centre.measure")
            host.load(GAUGE % "digital")
            host.command("addf centre.update servo-thread")
            host.command("start")

            def touch(diameter):
                host.set("gauge-near", diameter / 2 + 3.25)  # counters start anywhere
                host.set("gauge-far", diameter / 2 - 71.5)

            host.set("centre.start", True)
            host.run(0.01)
            touch(9.8)
            host.set("centre.cut-done", True)
            host.run(5)
            self.assertTrue(host.get("centre.measure"), "nobody has pressed the button")
            host.set("centre.cut-done", False)
            touch(10)
            host.set("gauge-master", True)
            host.run(0.1)
            host.set("gauge-master", False)
            host.set("centre.start", False)
            host.run(0.01)
            host.set("centre.start", True)
            host.run(0.01)
            measure_two_lands(self, host, touch)


class ModbusGauge(unittest.TestCase):
    def test_diameter_counts_while_the_gauge_answers(self):
        import plumb

        with TemporaryFolder() as folder:
            with socket.socket() as free:
                free.bind(("127.0.0.1", 0))
                port = free.getsockname()[1]
            with open(os.path.join(ROOT, "configs", "lathe", "modbus_gauge.toml")) as file:
                text = file.read()
            with open(os.path.join(folder, "modbus_gauge.toml"), "w") as file:
                file.write(text.replace("127.0.0.1:1502", "127.0.0.1:%d" % port))
            os.environ["CONFIG_DIR"] = folder
            os.environ["PATH"] = os.path.join(BUILD, "bin") + ":" + os.environ["PATH"]
            with plumb.Host() as host:
                for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt centre_height names=centre interlock=no", "loadrt interlock names=interlock"):
                    host.command(line)
                host.command("addf interlock.update servo-thread")
                host.command("net height-measure centre.measure")
                host.load(GAUGE % "modbus")
                host.command("addf centre.update servo-thread")
                host.command("start")
                host.set("centre.start", True)
                host.set("centre.x-position-0", 5)
                host.run(0.01)
                host.set("centre.cut-done", True)
                self.pass_time(host)
                self.assertTrue(host.get("centre.measure"), "nobody answers yet")
                device = subprocess.Popen(["/usr/bin/python3", SERVER, "tcp", str(port)])
                try:
                    self.await_(host, lambda: host.get("modbus-sensor.diameter.valid"))
                    self.assertEqual(host.get("centre.diameter"), 3.5)
                    self.await_(host, lambda: not host.get("centre.measure"))
                    self.assertEqual(host.get("centre.cut-number"), 1)
                finally:
                    device.kill()
                    device.wait()
                self.await_(host, lambda: not host.get("modbus-sensor.diameter.valid"))
                host.set("centre.cut-done", False)
                host.run(0.01)
                host.set("centre.cut-done", True)
                self.pass_time(host)
                self.assertTrue(host.get("centre.measure"), "the gauge is dead")

    def pass_time(self, host):
        """1.5 s of the machine, no faster than the clock: the program that reads the gauge has its own."""
        for _ in range(150):
            time.sleep(0.01)
            host.run(0.01)

    def await_(self, host, condition):
        latest = time.monotonic() + 60
        while not condition():
            self.assertLess(time.monotonic(), latest)
            time.sleep(0.01)
            host.run(0.01)


if __name__ == "__main__":
    unittest.main()

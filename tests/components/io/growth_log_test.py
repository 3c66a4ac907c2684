# SPDX-License-Identifier: GPL-2.0-or-later
"""growth_log, the real program, beside thermal_growth_test and the simulated machine in the virtual-time host."""

import contextlib
import glob
import itertools
import os
import random
import signal
import subprocess
import time
import unittest
import zlib

import plumb
from tree import BUILD, ROOT, own_folder

GROWTH_LOG = os.path.join(BUILD, "bin", "growth_log")
PATIENCE = 60  # s of real time, for an event that takes a moment
KINDS = ("touch", "temperature", "event", "speed")  # of records
COMPONENT, DISK, DAMAGED, FOREIGN, REFUSED = range(1, 6)

SETTINGS = """machine = "%s"
folder = "logs"
tolerance = { x = 0.01, y = 0.01, z = 0.015 }
[[sensor]]
number = 1
name = "spindle"
[artifact]
sensor = 1
expansion = 23.5
fixed = { x = 0, y = -100, z = 5 }
[[bore]]
number = 1
x = 0
y = -60
z = 60
[[bore]]
number = 9
kind = "sphere"
x = 0
y = 0
z = 80
"""


class GrowthLog(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.toml = os.path.join(self.folder, "growth.toml")
        self.write(SETTINGS % "mill 3")
        self.host = None
        self.start_machine()

    def tearDown(self):
        self.host.close()

    def write(self, text):
        with open(self.toml, "w", encoding="ascii") as file:
            file.write(text)

    def start_machine(self):
        """LinuxCNC is started again: a fresh component."""
        if self.host:
            self.host.close()
        self.host = plumb.Host()
        self.host.load(os.path.join(ROOT, "configs/growth/bench.hal"))
        self.host.set("artifact.play", False)
        self.host.set("artifact.touch-time", 2)
        self.host.command("start")

    def start_log(self):
        self.host.command("loadusr -W %s --file %s" % (GROWTH_LOG, self.toml))

    def start_log_again(self):
        """After a kill. HAL still has the component of the one that was killed, and loadusr does not wait."""
        self.start_log()
        self.until(lambda: self.process() is not None and self.is_there("growth-log.lines"), "growth_log has its pins", tick=True)

    def is_there(self, name):
        try:
            self.get(name)
        except plumb.Refused:
            return False
        return True

    def process(self):
        for line in glob.glob("/proc/[0-9]*/cmdline"):
            try:
                with open(line, "rb") as file:
                    words = file.read().decode(errors="replace").split("\0")
            except OSError:
                continue
            if os.path.basename(words[0]) == "growth_log" and self.toml in words:
                return int(line.split("/")[2])
        return None

    def kill(self):
        os.kill(self.process(), signal.SIGKILL)
        self.until(lambda: self.process() is None, "the killed growth_log is gone")

    def until(self, holds, what, tick=False):
        end = time.monotonic() + PATIENCE
        while not holds():
            self.assertLess(time.monotonic(), end, what)
            if tick:
                self.host.run(0.5)
            time.sleep(0.005)

    def get(self, name):
        return self.host.get(name)

    def play(self, seconds):
        """The test goes on until the log has all records."""
        self.host.set("artifact.play", True)
        self.host.run(seconds)
        self.catch_up()

    def catch_up(self):
        self.until(self.has_all_records, "the log has all records", tick=True)

    def has_all_records(self):
        try:
            return self.get("growth-log.lines") == self.get("growth-test.rows")
        except plumb.Refused:  # one that starts again makes its pins again
            return False

    def logs(self):
        return sorted(glob.glob(os.path.join(self.folder, "logs", "growth-*.csv")))

    def raw_lines(self, path):
        with open(path, encoding="ascii") as file:
            return file.read().split("\n")

    def lines(self, path):
        """The lines without their checksums, each of which is that of the lines so far."""
        lines, so_far = self.raw_lines(path), b""
        for place, line in enumerate(lines[:-1]):
            lines[place], _, checksum = line.rpartition(",")
            so_far += lines[place].encode("ascii") + b"\n"
            self.assertEqual(checksum, "%08x" % zlib.crc32(so_far), line)
        return lines

    def gap(self):
        self.until(lambda: self.get("growth-log.resumable"), "the test was given back", tick=True)
        return self.get("growth-test.gap")

    def test_the_log_has_each_record_in_order(self):
        self.start_log()
        self.play(300)
        (path,) = self.logs()
        lines = self.lines(path)
        self.assertEqual(lines[0], "growth-log,2")
        self.assertIn("machine,mill 3", lines)
        self.assertIn("bore,1,0,-60,60", lines)
        self.assertIn("sphere,9,0,0,80", lines)
        self.assertIn("artifact,1,23.5,1,0,-100,5", lines)
        records = [line.split(",") for line in lines if line.split(",")[0] in KINDS]
        self.assertEqual([int(record[1]) for record in records], list(range(1, len(records) + 1)))
        self.assertEqual(records[0][9], "begin")
        touches = [record for record in records if record[0] == "touch"]
        self.assertEqual(len(touches), self.get("growth-test.touches"))
        self.assertEqual({record[9] for record in touches}, {"-Z", "+X", "-X", "+Y", "-Y"})
        last = [float(value) for value in touches[-1][10:13]]
        self.assertEqual(last, [self.get("growth-test.touch-" + letter) for letter in "xyz"])
        report = subprocess.run([GROWTH_LOG, "--declarations"], capture_output=True, text=True, check=True)
        self.assertIn("resumable", report.stdout)

    def test_a_second_writer_is_refused(self):
        self.start_log()
        self.play(100)
        before = self.lines(self.logs()[0])
        with self.assertRaises(plumb.Refused) as refusal:
            self.host.command("loadusr -Wn other %s other --file %s" % (GROWTH_LOG, self.toml))
        self.assertIn("written by another growth_log", str(refusal.exception))
        self.assertEqual(self.lines(self.logs()[0]), before)

    def test_kill_and_restart_continue_the_same_test(self):
        self.start_log()
        self.play(400)
        rows, number = self.get("growth-test.rows"), self.get("growth-test.pass")
        self.kill()
        with open(self.logs()[0], "a", encoding="ascii") as file:
            file.write("touch,99,5")  # torn
        self.start_machine()
        self.assertEqual(self.get("growth-test.rows"), 0)
        self.start_log()
        self.until(lambda: self.get("growth-log.resumable"), "the test was given back", tick=True)
        self.assertEqual(self.get("growth-test.rows"), rows)
        self.assertEqual(self.get("growth-test.pass"), number)
        self.host.set("growth-test.resume", True)
        self.play(400)
        self.assertEqual(len(self.logs()), 1)
        text = "\n".join(self.lines(self.logs()[0]))
        self.assertIn(",resumed,", text)
        self.assertNotIn("touch,99,5", text)
        numbers = [int(line.split(",")[1]) for line in text.split("\n") if line.split(",")[0] in KINDS]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        self.assertGreater(len(numbers), rows)

    def test_started_again_while_the_test_runs_it_goes_on_in_the_same_log(self):
        self.start_log()
        self.play(300)
        self.kill()
        kept = self.lines(self.logs()[0])[:-1]
        self.host.run(300)
        self.start_log_again()
        self.catch_up()
        (path,) = self.logs()
        lines = self.lines(path)
        self.assertEqual(lines[: len(kept)], kept)
        numbers = [int(line.split(",")[1]) for line in lines if line.split(",")[0] in KINDS]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        self.assertGreater(len(numbers), sum(line.split(",")[0] in KINDS for line in kept))
        self.assertFalse(any(",resumed," in line for line in lines))

    def test_started_again_under_its_name_it_has_the_nets_of_the_one_that_was_killed(self):
        self.host.command("loadrt interlock names=interlock")
        self.host.command("addf interlock.update servo-thread")
        self.start_log()
        self.host.command("net log-state growth-log.state => interlock.service-state-6")
        self.host.command("net log-fault growth-log.fault")
        self.play(60)
        for _ in range(2):
            self.kill()
            self.start_log_again()
            seen = set()
            self.until(lambda seen=seen: seen.add(self.get("log-state")) or len(seen) == 2, "the net beats", tick=True)
            self.assertIn("log-fault", self.host.halcmd("show", "pin", "growth-log.fault").output)
        self.play(60)
        self.assertEqual(len(self.logs()), 1)
        before = self.process()
        with contextlib.suppress(plumb.Refused):  # of one that lives the name is taken
            self.start_log()
        time.sleep(0.3)
        self.assertEqual(self.process(), before)
        self.play(60)

    def test_a_killed_one_for_which_its_parent_does_not_wait_is_replaced(self):
        parent = os.path.join(self.folder, "parent.sh")
        with open(parent, "w", encoding="utf-8") as file:
            file.write("%s --file %s &\nexec sleep 60\n" % (GROWTH_LOG, self.toml))
        self.host.command("loadusr sh " + parent)
        self.until(lambda: self.process() is not None and self.is_there("growth-log.lines"), "growth_log has its pins", tick=True)
        self.kill()
        self.start_log_again()

    def test_another_test_that_runs_as_it_starts_gets_a_log_of_its_own(self):
        self.start_log()
        self.play(100)
        self.kill()
        self.start_machine()
        self.host.set("artifact.seed", 5)
        self.host.set("artifact.play", True)
        self.host.run(2000)
        before = self.lines(self.logs()[0])
        self.assertGreater(self.get("growth-test.rows"), len(before))  # so that only their content differs
        self.start_log()
        self.catch_up()
        self.assertEqual(len(self.logs()), 2)
        self.assertIn(before, [self.lines(path) for path in self.logs()])

    def test_killed_at_any_moment_it_keeps_what_it_reported_and_goes_on(self):
        draw, kept = random.Random(4), ""
        self.start_log()
        for attempt in range(6):
            self.host.set("growth-test.resume", attempt > 0)
            self.host.set("artifact.play", True)
            before = self.get("growth-log.lines")
            self.until(lambda before=before: self.get("growth-log.lines") > before, "a record of this run", tick=True)
            for _ in range(draw.randrange(60)):
                self.host.run(draw.choice((0.5, 3, 20)))
            reported = self.get("growth-log.lines")
            self.kill()
            self.assertEqual(len(self.logs()), 1)
            with open(self.logs()[0], encoding="ascii") as file:
                text = file.read()
            text = text[: text.rfind("\n") + 1]
            self.assertTrue(text.startswith(kept))
            records = sum(line.split(",")[0] in KINDS for line in text.split("\n"))
            self.assertGreaterEqual(records, reported)
            kept = text
            self.start_machine()
            self.start_log()
            self.until(lambda: self.get("growth-log.resumable"), "the test was given back", tick=True)
            self.assertEqual(self.get("growth-test.rows"), records)
        self.host.set("growth-test.resume", True)
        self.play(1500)
        bores = {}
        for line in self.lines(self.logs()[0]):
            fields = line.split(",")
            if fields[0] == "event" and fields[9] == "measured":
                bores.setdefault(int(fields[3]), set()).add(tuple(fields[5:8]))
        self.assertEqual(len(bores[1]), 16)  # bores, orientations and states of a whole pass

    def test_asked_to_end_while_it_writes_it_leaves_each_record_once(self):
        for row in (1, 5, 20, 40):
            for path in self.logs():
                os.remove(path)
            self.start_machine()
            self.host.set("artifact.play", True)
            self.host.run(200)
            self.assertGreater(self.get("growth-test.rows"), 40)
            self.start_log()
            self.until(lambda row=row: self.get("growth-test.row") >= row, "it reads", tick=True)
            os.kill(self.process(), signal.SIGTERM)
            self.until(lambda: self.process() is None, "growth_log has ended", tick=True)
            records = [line.split(",") for line in self.lines(self.logs()[0]) if line.split(",")[0] in KINDS]
            self.assertEqual([int(record[1]) for record in records], list(range(1, len(records) + 1)))

    def test_a_machine_that_stands_while_records_are_given_back_gets_each_once(self):
        self.start_log()
        self.play(60)
        rows = self.get("growth-test.rows")
        self.kill()
        self.start_machine()
        self.start_log()

        ticks = itertools.count(1)

        def given_back():
            self.host.run(0.5)
            if next(ticks) % 50 == 0:
                time.sleep(0.3)  # longer than growth_log waits for an answer
            return self.get("growth-log.resumable")

        self.until(given_back, "the test was given back")
        self.assertEqual(self.get("growth-test.rows"), rows)
        self.assertEqual(self.get("growth-test.restores-refused"), 0)
        self.assertEqual(len(self.logs()), 1)

    def test_without_resume_a_new_file_begins_and_the_old_one_stays(self):
        self.start_log()
        self.play(200)
        self.kill()
        before = self.lines(self.logs()[0])
        self.start_machine()
        self.start_log()
        self.until(lambda: self.get("growth-log.resumable"), "the test was given back", tick=True)
        self.play(0.5)
        self.until(lambda: len(self.logs()) == 2, "a second file", tick=True)
        self.assertEqual(self.lines(self.logs()[0]), before)

    def test_the_last_log_is_the_one_with_the_highest_number_whatever_the_clock_showed(self):
        self.start_log()
        self.play(200)
        self.kill()
        future = os.path.join(os.path.dirname(self.logs()[0]), "growth-20991231-235959.csv")
        os.rename(self.logs()[0], future)
        self.start_machine()
        self.start_log()
        self.until(lambda: self.get("growth-log.resumable"), "the test was given back", tick=True)
        self.play(200)
        self.until(lambda: len(self.logs()) == 2, "a second file", tick=True)
        self.kill()
        second = next(log for log in self.logs() if log != future)
        self.assertEqual([self.lines(log)[1] for log in (future, second)], ["log,1", "log,2"])
        before = self.lines(future)
        self.start_machine()
        self.start_log()
        self.until(lambda: self.get("growth-log.resumable"), "the test was given back", tick=True)
        self.host.set("growth-test.resume", True)
        self.play(1)
        self.until(lambda: any(",resumed," in line for line in self.lines(second)), "the second test is resumed", tick=True)
        self.assertEqual(self.lines(future), before)

    def test_a_damaged_or_foreign_log_stays_and_is_not_resumed(self):
        self.start_log()
        self.play(200)
        self.kill()
        path = self.logs()[0]
        good = self.raw_lines(path)
        first = next(i for i, line in enumerate(good) if line.split(",")[0] in KINDS)
        for text, settings, code in (
            ("\n".join(good[:first] + good[first + 1 :]), "mill 3", DAMAGED),
            ("\n".join(good).replace(",measured,0", ",measured,1", 1), "mill 3", DAMAGED),
            ("\n".join(good), "mill 4", FOREIGN),
        ):
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            self.write(SETTINGS % settings)
            self.start_machine()
            self.start_log()
            self.until(lambda code=code: self.get("growth-log.fault-code") == code, "the fault", tick=True)
            self.assertEqual(self.get("growth-test.rows"), 0)
            with open(path, encoding="ascii") as file:
                self.assertEqual(file.read(), text)
            self.kill()

    def test_the_gap_is_that_of_the_computer_whatever_its_clock_shows(self):
        self.start_log()
        self.play(100)
        self.kill()
        began = time.monotonic()
        number = self.get("growth-test.rows")
        for wrong in (0, time.time() + 1e6):  # 1970, and days ahead
            os.utime(self.logs()[0], (wrong, wrong))
            self.start_machine()
            self.start_log()
            gap = self.gap()
            self.assertGreater(gap, 0)
            self.assertLess(gap, time.monotonic() - began + 1)
            self.kill()
        self.assertEqual(self.get("growth-test.rows"), number)

        os.remove(os.path.join(self.folder, "logs", ".growth_log.last"))  # as after a start of the computer
        self.start_machine()
        self.start_log()
        self.assertEqual(self.gap(), -1)
        self.host.set("growth-test.resume", True)
        elapsed = float(next(line for line in reversed(self.lines(self.logs()[0])) if line).split(",")[2])
        self.play(1)
        resumed = [line.split(",") for line in self.lines(self.logs()[0]) if ",resumed," in line]
        self.assertEqual([event[10] for event in resumed], ["1"])
        self.assertEqual(float(resumed[0][2]), elapsed)

    def test_wrong_settings_are_refused_with_their_line(self):
        for wrong, reason in (("ball = -1", "growth.toml:1: ball is no number"), ("bal = 6", "unknown key 'bal'")):
            self.write(wrong + "\n" + SETTINGS % "mill 3")
            with self.assertRaises(plumb.Refused) as refusal:
                self.start_log()
            self.assertIn(reason, str(refusal.exception))


if __name__ == "__main__":
    unittest.main()

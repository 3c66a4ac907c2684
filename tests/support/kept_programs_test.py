# SPDX-License-Identifier: GPL-2.0-or-later
"""A test that ends, or is killed, leaves no process behind."""

import os
import signal
import subprocess
import sys
import time
import unittest

import keeper
from tree import BUILD, ROOT, own_folder

RUN = os.path.join(ROOT, "tests", "support", "run.py")
LEFT = "PLUMB_LEFT_BY"  # in the environment of all that a test starts
PATIENCE = 30  # s

# Starts a host, a run of the host, a program with a process group of its own, and a daemon.
STARTER = """\
import os
import subprocess
import sys
import time

import plumb
from plumb_run import plumb_run
from tree import BUILD

host = plumb.Host()
subprocess.Popen([*plumb_run(BUILD), "sleep", "1001"], start_new_session=True)
subprocess.Popen(["sleep", "1002"], start_new_session=True)
subprocess.run(["sh", "-c", "setsid sleep 1003 &"], check=True)
time.sleep(0.3)
open("begun", "a").close()
%s
"""


def marked(mark):
    """Numbers and command lines of the processes whose environment has the mark."""
    found = {}
    for entry in os.listdir("/proc"):
        try:
            with open("/proc/%d/environ" % int(entry), "rb") as file:
                if mark.encode() not in file.read().split(b"\0"):
                    continue
            with open("/proc/%s/cmdline" % entry, "rb") as file:
                found[int(entry)] = file.read().replace(b"\0", b" ").decode()
        except (ValueError, OSError):
            pass
    return found


def parent(process):
    with open("/proc/%d/stat" % process) as file:
        return int(file.read().rpartition(")")[2].split()[1])


class Leftovers(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.mark = "%s=%s" % (LEFT, self.folder)

    def start(self, last_line, *words, hangup="default"):
        """Starts such a test in its folder, under nohup if it is to ignore the hangup. Returns the first process."""
        with open(os.path.join(self.folder, "starter.py"), "w") as file:
            file.write(STARTER % last_line)
        environment = {name: value for name, value in os.environ.items() if name not in (keeper.MARK, "PLUMB_RESTARTS")}
        environment[LEFT], environment["PLUMB_BUILD"] = self.folder, BUILD
        command = ["env", "--%s-signal=HUP" % hangup, sys.executable, RUN, *words, "starter.py"]
        process = subprocess.Popen(command, cwd=self.folder, env=environment, start_new_session=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def await_begin(self):
        self.until(lambda: os.path.exists(os.path.join(self.folder, "begun")), "the start of the test")
        self.assertGreater(len(marked(self.mark)), 6)

    def until(self, condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.02)

    def expect_nothing_left(self):
        end = time.monotonic() + PATIENCE
        while marked(self.mark) and time.monotonic() < end:
            time.sleep(0.05)
        self.assertEqual(marked(self.mark), {})

    def test_after_its_end(self):
        for status in (0, 3):
            process = self.start("os._exit(%d)" % status, "--again")
            self.assertEqual(process.wait(), status)
            self.assertEqual(marked(self.mark), {})
            os.remove(os.path.join(self.folder, "begun"))

    def test_after_a_signal_to_the_first_process(self):
        for number, status in ((signal.SIGTERM, 128 + signal.SIGTERM), (signal.SIGHUP, 128 + signal.SIGHUP),
                               (signal.SIGKILL, -signal.SIGKILL)):
            for words in ([], ["--again"]):
                with self.subTest(number=number, words=words):
                    process = self.start("time.sleep(1000)", *words)
                    self.await_begin()
                    process.send_signal(number)
                    self.assertEqual(process.wait(PATIENCE), status)
                    self.expect_nothing_left()
                    os.remove(os.path.join(self.folder, "begun"))

    def test_a_program_that_does_not_end_is_killed(self):
        process = self.start("subprocess.run(['sh', '-c', 'trap \"\" TERM; sleep 1004; sleep 1005'])")
        self.await_begin()
        process.terminate()
        process.wait(PATIENCE)
        self.assertEqual(marked(self.mark), {})

    def test_after_the_death_of_any_process_that_keeps_it_or_is_it(self):
        for generation, words in ((1, ["--again"]), (2, ["--again"]), (2, [])):
            with self.subTest(generation=generation, words=words):
                process = self.start("time.sleep(1000)", *words)
                self.await_begin()
                victim = process.pid
                for _ in range(generation):
                    victim = next(each for each in marked(self.mark) if parent(each) == victim)
                os.kill(victim, signal.SIGKILL)
                process.wait(PATIENCE)
                self.expect_nothing_left()
                os.remove(os.path.join(self.folder, "begun"))

    def test_after_a_kill_at_any_moment_of_its_start(self):
        for moment in (0.02, 0.05, 0.1, 0.2, 0.4):
            with self.subTest(moment):
                process = self.start("time.sleep(1000)", "--again")
                time.sleep(moment)
                process.kill()
                self.expect_nothing_left()

    def test_a_hangup_does_not_end_it_under_nohup(self):
        process = self.start("time.sleep(1); os._exit(4)", "--again", hangup="ignore")
        self.await_begin()
        process.send_signal(signal.SIGHUP)
        self.assertEqual(process.wait(PATIENCE), 4)


if __name__ == "__main__":
    unittest.main()

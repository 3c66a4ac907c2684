# SPDX-License-Identifier: GPL-2.0-or-later
"""A run ends, whatever its components do. PLUMB_BUILD names the build folder."""

import os
import signal
import subprocess
import time
import unittest

import plumb
from tree import BUILD, own_folder

PLUMB = os.path.join(BUILD, "bin", "plumb")
SPECIMENS = os.path.join(BUILD, "specimens")
PATIENCE = 60  # s; a run that does not end fails its test
BUSY = """loadrt threads name1=servo-thread period1=1000000
loadrt lowpass names=before
loadrt busy_function names=one,two
addf before servo-thread
addf one.update servo-thread
addf two.update servo-thread
"""


class EveryRunEnds(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)

    def write(self, text):
        path = os.path.join(self.folder, "it.hal")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def ended(self, *words, ask=None, once=None):
        """Exit status and output of plumb; the signal `ask` comes once the file `once` is there."""
        begun = subprocess.Popen([PLUMB, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        with begun:
            try:
                if ask is not None:
                    self.await_file(once, begun)
                    begun.send_signal(ask)
                output = begun.communicate(timeout=PATIENCE)[0]
            except BaseException:
                begun.kill()
                raise
        return begun.returncode, output

    def await_file(self, path, program):
        limit = time.monotonic() + PATIENCE
        while not os.path.exists(path):
            self.assertIsNone(program.poll(), "plumb ended before its run began")
            self.assertLess(time.monotonic(), limit, "the run does not begin")
            time.sleep(0.01)

    def test_a_function_that_never_returns_ends_a_bench_and_is_named(self):
        file = self.write(BUSY + "setp two.hold 1e9\n")
        for ask in (None, signal.SIGTERM):
            with self.subTest(ask=ask):
                # The run begins with its recording: a signal during the loading ends plumb at once.
                record = os.path.join(self.folder, f"{ask}.csv")
                recording = ("--record", "two.hold", "--every", "1ms", "--output", record)
                status, output = self.ended(
                    "bench", file, "--for", "1h", "--modules", SPECIMENS, *recording, ask=ask, once=record
                )
                self.assertEqual(status, 1, output)
                self.assertIn("plumb-host: two.update has not returned for 5 s: the run ends", output)
                self.assertEqual(output.count("has not returned"), 1, output)

    def test_it_ends_a_run_of_programs(self):
        file = self.write(BUSY + "setp one.hold 1e9\nstart\nloadusr -w sleep 1000\n")
        status, output = self.ended("run", "--modules", SPECIMENS, "--", "halrun", "-f", file)
        self.assertEqual(status, 1, output)
        self.assertIn("one.update has not returned for 5 s", output)

    def test_it_ends_the_host_of_a_client(self):
        with plumb.Host(modules=[SPECIMENS]) as host:
            host.load(self.write(BUSY + "start\n"))
            host.set("one.hold", 1e9)
            with self.assertRaisesRegex(plumb.HostDied, "one.update has not returned for 5 s"):
                host.run(1)

    def test_slow_functions_that_return_go_on(self):
        with plumb.Host(modules=[SPECIMENS]) as host:
            host.load(self.write(BUSY + "start\n"))
            host.set({"one.hold": 0.06, "two.hold": 0.06})
            self.assertEqual(host.run(0.06).ran, 0.06)

    def test_the_limit_of_a_run_ends_it_between_two_periods(self):
        with plumb.Host(modules=[SPECIMENS]) as host:
            host.load(self.write(BUSY + "start\n"))
            host.set("one.hold", 0.001)
            seen = []
            ran = host.run(3600, progress=seen.append, limit=0.5)
            self.assertEqual(ran.ended, "limit")
            self.assertLess(ran.ran, 3600)
            self.assertGreater(len(seen), 1)
            self.assertEqual(ran.time, host.time)
            self.assertEqual(host.run(0.002, limit=100).ended, "")

    def test_hm2_eth_with_an_address_gives_the_cause(self):
        file = self.write('loadrt hostmot2\nloadrt hm2_eth board_ip="192.168.1.121"\nloadrt threads name1=t period1=1000000\n')
        for words in (("bench", file, "--for", "1s"), ("run", "--", "halrun", "-f", file)):
            with self.subTest(words[0]):
                status, output = self.ended(*words)
                self.assertEqual(status, 1, output)
                self.assertIn("The virtual-time host has no hardware", output)
                self.assertRegex(output, "hm2_eth: rtapi_app_main: ")
                self.assertIn("hm2_eth: run without this hardware: plumb run --models, plumb bench --models", output)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""--cluster of scripts/bench: the machines on two workers of a Dask scheduler that the test starts here."""

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

from long import long
from plumb_folder import TemporaryFolder
from support import mill_events, simulations
from support.cluster import Cluster, differences, identity
from tree import BUILD, ROOT

BENCHES = os.path.join(ROOT, "scripts", "benches")
PATIENCE = 60  # s


class Silent:
    """The progress of a run that calls a function once some of it is done."""

    def __init__(self, amid=lambda: None):
        self.amid = amid

    def show(self, done):
        pass

    def show_part(self, part):
        if 0 < part < 1 and self.amid:
            self.amid, amid = None, self.amid
            amid()

    def end(self):
        pass


class Differences(unittest.TestCase):
    def test_only_differences_are_reported(self):
        here = identity()
        self.assertEqual(differences(here, identity()), "")
        self.assertEqual(
            differences(here, {**here, "Plumb": "0.0.1, build x"}), f"Plumb 0.0.1, build x there, {here['Plumb']} here"
        )

    def test_everything_has_a_value(self):
        self.assertTrue(all(identity().values()), identity())


@unittest.skipUnless(importlib.util.find_spec("distributed"), "python3-distributed is not installed")
class OnWorkers(unittest.TestCase):
    def setUp(self):
        folder = TemporaryFolder()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        scheduler = os.path.join(self.folder, "scheduler.json")
        its = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", scheduler)
        self.scheduler = self.start("dask_scheduler", *its)
        self.wait_until(lambda: os.path.exists(scheduler), "the scheduler")
        import distributed

        self.client = distributed.Client(scheduler_file=scheduler, timeout=PATIENCE)
        self.addCleanup(self.client.close)
        self.address = self.client.scheduler_info()["address"]
        self.cluster = Cluster(self.address)

    def start(self, program, *arguments, **variables):
        """A program of Dask, which ends with the test."""
        words = [sys.executable, "-m", "distributed.cli." + program, *arguments]
        environment = {**os.environ, "PLUMB_BUILD": BUILD, **variables}
        with open(os.path.join(self.folder, program + ".log"), "a", encoding="utf-8") as log:
            process = subprocess.Popen(words, env=environment, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def start_worker(self, **variables):
        present = len(self.client.scheduler_info()["workers"])
        # Without its nanny, which would start a killed one again.
        its = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", self.folder)
        worker = self.start("dask_worker", self.address, *its, **{"PYTHONPATH": BENCHES, **variables})
        self.wait_until(lambda: len(self.client.scheduler_info()["workers"]) > present, "a worker")
        return worker

    def wait_until(self, condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end, f"{what} does not come")
            time.sleep(0.1)

    @long
    def test_same_as_here_also_where_a_worker_is_lost_amid_its_machine(self):
        workers = [self.start_worker() for _ in range(2)]
        programs = mill_events.draw_programs(6, False)
        lost = []

        def lose_one():
            lost.extend(worker for worker, tasks in self.client.processing().items() if tasks)
            workers[0].send_signal(signal.SIGKILL)

        there = self.cluster.simulate_all(mill_events.simulate, programs, Silent(lose_one))
        self.assertEqual(len(lost), 2, "both had machines when one was killed")
        self.assertEqual(len(self.client.scheduler_info()["workers"]), 1)
        self.assertEqual(repr(there), repr(simulations.simulate_all(mill_events.simulate, programs, 1000)))

    def test_worker_with_another_build_is_named_with_both_versions_and_refused(self):
        build = os.path.join(self.folder, "build")
        shutil.copytree(os.path.join(BUILD, "python"), os.path.join(build, "python"))
        for name in ("bin", "modules", "man"):
            os.symlink(os.path.join(BUILD, name), os.path.join(build, name))
        with open(os.path.join(build, "python", "plumb.py"), "a", encoding="utf-8") as file:
            file.write("# another one\n")
        self.start_worker()
        self.start_worker(PLUMB_BUILD=build)
        with self.assertRaises(RuntimeError) as refusal:
            self.cluster.simulate_all(mill_events.simulate, mill_events.draw_programs(2, False), Silent())
        self.assertRegex(
            str(refusal.exception), r"^the worker tcp://127.0.0.1:\d+ is refused: Plumb [\d.]+, build \w+ there, [\d.]+, build \w+ here$"
        )
        self.assertIn(identity()["Plumb"] + " here", str(refusal.exception))

    def test_worker_that_comes_later_with_another_build_is_refused_as_well(self):
        from support import cluster

        expected = {**identity(), "Plumb": "0.0.1, build x"}
        with self.assertRaisesRegex(RuntimeError, "is refused: Plumb .* there, 0.0.1, build x here"):
            cluster.simulate_there(expected, lambda seconds: None, ())

    def test_worker_without_the_benches_is_refused(self):
        self.start_worker(PYTHONPATH="")
        with self.assertRaisesRegex(RuntimeError, "is refused: it does not find the benches of Plumb .*README.md"):
            self.cluster.simulate_all(mill_events.simulate, mill_events.draw_programs(1, False), Silent())

    @long
    def test_lost_scheduler_is_an_error(self):
        self.start_worker()
        programs = mill_events.draw_programs(4, False)
        with self.assertRaisesRegex(RuntimeError, "were lost"):
            self.cluster.simulate_all(mill_events.simulate, programs, Silent(self.scheduler.kill))

    def test_no_worker_is_an_error(self):
        with self.assertRaisesRegex(RuntimeError, "has no worker"):
            self.cluster.simulate_all(mill_events.simulate, mill_events.draw_programs(1, False), Silent())

    @long
    def test_command_prints_the_same(self):
        self.start_worker()
        here, there = (self.run_bench(*place) for place in (("--jobs", "1"), ("--cluster", self.address)))
        self.assertIn("programs with an event", here)
        self.assertEqual(there, here)

    def test_no_scheduler_is_an_error(self):
        with self.assertRaisesRegex(RuntimeError, "no Dask scheduler at tcp://127.0.0.1:1"):
            Cluster("tcp://127.0.0.1:1").simulate_all(mill_events.simulate, [], Silent())

    def run_bench(self, *place):
        words = [sys.executable, BENCHES, "mill", "--events", "2", *place, "--output", self.folder]
        done = subprocess.run(words, capture_output=True, text=True, timeout=200, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout


if __name__ == "__main__":
    unittest.main()

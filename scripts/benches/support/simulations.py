# SPDX-License-Identifier: GPL-2.0-or-later
"""Many simulations at a time, and their progress."""

import concurrent.futures
import ctypes
import multiprocessing
import os
import signal
import sys
import time

BENCHES = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ROOT = os.path.dirname(os.path.dirname(BENCHES))
BUILD = os.path.abspath(os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build")))
sys.path[:0] = [os.path.join(BUILD, "python"), os.path.join(ROOT, "scripts")]  # plumb, once it is built; plumb_run


def simulate_all(simulate, tasks, duration, place=None):
    """simulate(*task, progress) of each task, in their order; `duration` is that of all, in simulated seconds.

    Each calls progress(seconds done), and stops when that returns False. The progress of all goes to stderr.
    The simulations run in `place`, by default in ThisComputer().
    """
    return (place or ThisComputer()).simulate_all(simulate, tasks, Progress(duration))


class ThisComputer:
    """Processes of its own for the simulations: as many as it has cores, or as given."""

    def __init__(self, processes=None):
        self._processes = processes or len(os.sched_getaffinity(0))

    def simulate_all(self, simulate, tasks, progress):
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # as Ctrl-C: stops the others
        done = multiprocessing.Array("d", len(tasks))
        interrupted = multiprocessing.Value("b", False)
        processes = min(self._processes, len(tasks))
        with concurrent.futures.ProcessPoolExecutor(processes, initializer=_share, initargs=(done, interrupted)) as pool:
            futures = [pool.submit(_simulate, simulate, index, task) for index, task in enumerate(tasks)]
            try:
                while concurrent.futures.wait(futures, 0.2, concurrent.futures.FIRST_EXCEPTION).not_done:
                    if any(future.done() and future.exception() for future in futures):
                        break
                    progress.show(sum(done))
                progress.end()
                return [future.result() for future in futures if future.done()]
            finally:
                interrupted.value = True
                pool.shutdown(cancel_futures=True)


def _share(done, interrupted):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the main process, which stops the others
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    set_parent_death_signal = 1  # PR_SET_PDEATHSIG: a killed main process can stop nobody
    ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGTERM)
    _share.done, _share.interrupted = done, interrupted


def _simulate(simulate, index, task):
    def progress(seconds):
        _share.done[index] = seconds
        return not _share.interrupted.value

    return simulate(*task, progress)


class Progress:
    """A line that is rewritten on a terminal; elsewhere a line for each quarter."""

    def __init__(self, total):
        self._total = total
        self._began = time.monotonic()
        self._quarters = 0

    def show(self, done):
        self.show_part(done / self._total)

    def show_part(self, part):
        line = f"{part:4.0%} of {duration_text(self._total)} simulated in {time.monotonic() - self._began:.0f} s"
        if sys.stderr.isatty():
            print(f"\r{line}\x1b[K", end="", file=sys.stderr, flush=True)
        elif int(4 * part) > self._quarters:
            self._quarters = int(4 * part)
            print(line, file=sys.stderr, flush=True)

    def end(self):
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def duration_text(seconds):
    """5400 -> "1 h 30 min"."""
    whole = round(seconds)
    parts = [(whole // 3600, "h"), (whole % 3600 // 60, "min"), (whole % 60, "s")]
    return " ".join(f"{number} {unit}" for number, unit in parts if number) or "0 s"

# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether the computer stood still: a program came late, or the processors of a virtual machine were taken away."""

import os
import threading
import time

PAUSE = 0.01  # s, of the thread that looks
LATE = 0.2  # s, by which it woke too late
TAKEN = 0.3  # s in one second, in which a processor was taken away


class Standstill:
    """A thread looks while `with` lasts."""

    def __init__(self):
        self.late = self.taken = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()

    def __str__(self):
        return "The computer stood still for %.1f s, and lost %.1f s of its processors in one second" % (self.late, self.taken)

    def seen(self):
        return self.late > LATE or self.taken > TAKEN

    def _look(self):
        looked, began, stolen = time.monotonic(), time.monotonic(), _stolen()
        while not self._over.wait(PAUSE):
            now = time.monotonic()
            self.late = max(self.late, now - looked - PAUSE)
            looked = now
            if now - began >= 1:
                self.taken = max(self.taken, (_stolen() - stolen) / (now - began))
                began, stolen = now, _stolen()


def _stolen():
    """Seconds of all processors together that the host of this virtual machine gave to others."""
    with open("/proc/stat") as file:
        columns = file.readline().split()
    return int(columns[8]) / os.sysconf("SC_CLK_TCK") if len(columns) > 8 else 0.0

# SPDX-License-Identifier: GPL-2.0-or-later
"""What LinuxCNC's task does, as values beside the pins: task.alive, task.program and task.on."""

import json
import os
import subprocess
import sys
import time

from gi.repository import GLib

STALE = 3  # s


class Task:
    def __init__(self):
        self._values, self._heard, self._rest = {}, 0, b""
        try:
            self._process = subprocess.Popen([sys.executable, os.path.join(os.path.dirname(__file__), "task_watch.py")],
                                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        except OSError:
            self._process = None
            return
        os.set_blocking(self._process.stdout.fileno(), False)
        GLib.io_add_watch(self._process.stdout, GLib.PRIORITY_DEFAULT, GLib.IOCondition.IN | GLib.IOCondition.HUP, self._read)

    def _read(self, _file, _condition):
        text = self._process.stdout.read() if self._process else b""
        if not text:
            return text is None  # else it has ended
        *lines, self._rest = (self._rest + text).split(b"\n")
        if lines:
            self._values, self._heard = json.loads(lines[-1]), time.monotonic()
        return True

    def values(self):
        """Those of the last seconds."""
        if time.monotonic() - self._heard > STALE:
            return {"task.alive": False} if self._heard else {}
        return self._values

    def close(self):
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

# SPDX-License-Identifier: GPL-2.0-or-later
"""The log of changed settings: who changed which pin, when, from which value to which. One JSON object a line, and its CRC-32."""

import collections
import contextlib
import fcntl
import json
import os
import re
import time
import zlib

from panel.files import open_own

CHECKED = re.compile(rb"(\{.*\}) ([0-9a-f]{8})")
Change = collections.namedtuple("Change", "time who pin old new why deed", defaults=("",))
Change.__doc__ = "time is in s since 1970; old and new are texts as setp takes them; why is '' or such as 'undo'; what was written together has one deed."


class ChangeLog:
    """Several screens append to one file. A change that could not be written stays in memory, and is written with the next one."""

    def __init__(self, path):
        self.path = path
        self._read_to = 0
        self._changes, self._unwritten = [], []

    @contextlib.contextmanager
    def alone(self):
        """While the block runs, no other screen changes a setting. Raises OSError."""
        with open_own(self.path + ".lock", "ab") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def add(self, change):
        """Raises OSError."""
        self._unwritten.append(change)
        texts = [json.dumps(each._asdict()).encode("ascii") for each in self._unwritten]
        with open_own(self.path, "ab+") as file:
            if file.tell() and os.pread(file.fileno(), 1, file.tell() - 1) != b"\n":
                file.write(b"\n")  # behind a torn line
            file.write(b"".join(text + b" %08x\n" % zlib.crc32(text) for text in texts))
            file.flush()
            os.fsync(file.fileno())
        self._unwritten = []

    def all(self):
        """All changes, oldest first; a line that is damaged is left out. Lines of before have no checksum."""
        try:
            size = os.stat(self.path).st_size
        except OSError:
            self._read_to, self._changes = 0, []
            size = 0
        if size < self._read_to:
            self._read_to, self._changes = 0, []
        if size > self._read_to:
            try:
                with open_own(self.path, "rb") as file:
                    file.seek(self._read_to)
                    added = file.read()
            except OSError:  # of another user, or a link
                return self._changes + self._unwritten
            whole = added[: added.rfind(b"\n") + 1]
            self._read_to += len(whole)
            for line in whole.splitlines():
                found = CHECKED.fullmatch(line)
                if found and int(found[2], 16) != zlib.crc32(found[1]):
                    continue
                with contextlib.suppress(ValueError, TypeError):
                    self._changes.append(Change(**json.loads(found[1] if found else line)))
        return self._changes + self._unwritten

    def last(self, pin):
        return next((change for change in reversed(self.all()) if change.pin == pin), None)

    def together_with(self, change):
        """All changes of a deed."""
        return [each for each in self.all() if each.deed == change.deed] if change.deed else [change]


def now():
    return time.time()

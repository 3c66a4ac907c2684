# SPDX-License-Identifier: GPL-2.0-or-later
"""Temporary folders that nobody leaves behind.

The program holds a lock on its folder as long as it lives, and removes the folder at its end. After kill -9 the folder stays,
and its lock does not: the next program removes it. A lock is seen in all namespaces of processes, which a process number is not.
"""

import contextlib
import fcntl
import os
import re
import shutil
import tempfile
import weakref

BEGINNING = "plumb-temporary-"
_NAME = re.compile(re.escape(BEGINNING) + r"\w{6,8}")
_OPEN = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW


class TemporaryFolder:
    """A folder in `place`, by default in TMPDIR or /tmp. `with` gives its path, and removes it."""

    def __init__(self, place=None):
        place = place or tempfile.gettempdir()
        _remove_dead(place)
        self.name, lock = _new(place)
        self._end = weakref.finalize(self, _end, self.name, lock)

    def cleanup(self):
        self._end()

    def __enter__(self):
        return self.name

    def __exit__(self, *_):
        self.cleanup()


def _new(place):
    while True:
        path = tempfile.mkdtemp(prefix=BEGINNING, dir=place)
        try:
            # Until it is locked, another program may take it for a dead one's, and remove it.
            with contextlib.suppress(FileNotFoundError):
                lock = os.open(path, _OPEN)
                with contextlib.suppress(OSError):  # the file system has no locks: nobody removes it then
                    fcntl.flock(lock, fcntl.LOCK_SH)
                if _is_at(path, lock):
                    return path, lock
                os.close(lock)
        except OSError:
            os.rmdir(path)
            raise


def _is_at(path, descriptor):
    try:
        return os.path.samestat(os.lstat(path), os.fstat(descriptor))
    except FileNotFoundError:
        return False


def _end(path, lock):
    _remove(path)
    os.close(lock)


def _remove_dead(place):
    """Removes the folders of this user's programs that were killed."""
    with contextlib.suppress(OSError):
        for name in filter(_NAME.fullmatch, os.listdir(place)):
            _remove_if_dead(os.path.join(place, name))


def _remove_if_dead(path):
    try:
        lock = os.open(path, _OPEN)
    except OSError:  # another user's, or gone
        return
    try:
        if os.fstat(lock).st_uid == os.geteuid():
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(path, lock):
                _remove(path)
    except OSError:  # its program lives
        pass
    finally:
        os.close(lock)


def _remove(path):
    """What cannot be removed now is left to the next program."""
    shutil.rmtree(path, ignore_errors=True)
    if not os.path.lexists(path):
        return
    for base, folders, _ in os.walk(path):  # folders without rights
        for folder in (os.path.join(base, name) for name in folders):
            with contextlib.suppress(OSError):
                if not os.path.islink(folder):
                    os.chmod(folder, 0o700)
    shutil.rmtree(path, ignore_errors=True)

# SPDX-License-Identifier: GPL-2.0-or-later
"""The end of a program in Python: its exit status, and a sentence if its output cannot be written."""

import contextlib
import errno
import io
import os
import sys


def run(name, main):
    """Calls main() and ends the program with the status that it returns. Its messages begin with `name`.

    The status is 1 if the output cannot be written, as on a full disk, 130 after Ctrl-C, and 141 if a reader such as `head`
    has enough.
    """
    if sys.stdout is None:
        sys.stdout = _Closed()
    try:
        status = _status(main)
        sys.stdout.flush()
    except KeyboardInterrupt:
        status = 130
    except BrokenPipeError:
        status = 141
    except OSError as error:
        with contextlib.suppress(OSError):
            print("%s: %s: %s" % (name, error.filename or "standard output", error.strerror or error), file=sys.stderr)
        status = 1
    _drop_output()
    sys.exit(status)


class _Closed(io.TextIOBase):
    """In the place of an output that was closed before the start."""

    def write(self, text):
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))

    def reconfigure(self, **_):
        pass


def _status(main):
    try:
        return main()
    except SystemExit as end:
        if not isinstance(end.code, str):
            return end.code
        print(end.code, file=sys.stderr)
        return 1


def _drop_output():
    """Python writes what is left at its end, and could only report it in a traceback."""
    with contextlib.suppress(OSError, ValueError):  # and io.UnsupportedOperation, which is both
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

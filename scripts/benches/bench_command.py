# SPDX-License-Identifier: GPL-2.0-or-later
"""What the commands of scripts/bench have in common."""

import argparse
import contextlib
import os
import re
import sys
import tempfile


def whole(least, most):
    """A type for argparse: a whole number from least to most."""

    def number(text):
        if not re.fullmatch(r"\d{1,10}", text) or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from {least} to {most}")
        return int(text)

    return number


def make_writable(folder):
    """So that a run does not end with what it cannot write."""
    os.makedirs(folder, exist_ok=True)
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise OSError(f"cannot write into {folder}: {error.strerror}") from error


@contextlib.contextmanager
def errors_told():
    """Ends the program with a sentence where something went wrong, as with a full disk, and at Ctrl-C."""
    try:
        try:
            yield
        finally:
            flush_output()
    except KeyboardInterrupt:
        sys.exit(130)
    except (RuntimeError, OSError, ValueError) as error:
        sys.exit(f"scripts/bench: {error}")


def flush_output():
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more at its end
        raise OSError(f"standard output: {error.strerror}") from error

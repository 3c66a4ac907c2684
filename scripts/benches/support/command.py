# SPDX-License-Identifier: GPL-2.0-or-later
"""Common parts of the commands of scripts/bench."""

import argparse
import contextlib
import os
import re
import sys
import tempfile

from support.cluster import Cluster
from support.simulations import BUILD, ThisComputer

COMMAND = os.environ.get("PLUMB_BENCH", "scripts/bench")  # what the user wrote
OUTPUT = os.environ.get("PLUMB_FIGURES", os.path.join(BUILD, "bench"))

def whole(least, most):
    """A type for argparse: a whole number from least to most."""

    def number(text):
        if not re.fullmatch(r"\d{1,10}", text) or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from {least} to {most}")
        return int(text)

    return number


def duration_of(text):
    """ "4h", "10min", "90s" or "90" in seconds."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?) *(h|min|s|)", text)
    seconds = float(match[1]) * {"h": 3600, "min": 60}.get(match[2], 1) if match else 0
    if not seconds:
        raise argparse.ArgumentTypeError(f"'{text}' is not a time in s, min or h such as 600, 10min or 4h")
    return seconds


def new_parser(bench, docstring):
    return argparse.ArgumentParser(prog=f"{COMMAND} {bench}", description=docstring.splitlines()[0])


def add_output(parser, bench):
    folder = os.path.join(OUTPUT, bench)
    parser.add_argument("--output", default=folder, metavar="DIR", help=f"where the files go (default: {os.path.relpath(folder)})")


def add_place(parser):
    """For benches that draw machines."""
    parser.add_argument("--jobs", type=whole(1, 4096), metavar="N", help="simulations at a time (default: one a core)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="run the simulations on the workers of this Dask scheduler, such as tcp://mill:8786")


def place_of(options):
    """Where simulate_all() is to run the simulations."""
    return Cluster(options.cluster) if options.cluster else ThisComputer(options.jobs)


def written_line(paths):
    return "Written: " + "  ".join(os.path.relpath(path) for path in paths)


def make_writable(folder):
    """So that a run does not fail at its end, when it writes."""
    os.makedirs(folder, exist_ok=True)
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise OSError(f"cannot write into {folder}: {error.strerror}") from error


@contextlib.contextmanager
def errors_reported():
    """Ends the program with a sentence where something went wrong, as with a full disk, and at Ctrl-C."""
    try:
        try:
            yield
        finally:
            flush_output()
    except KeyboardInterrupt:
        sys.exit(130)
    except (RuntimeError, OSError, ValueError) as error:
        sys.exit(f"{COMMAND}: {error}")


def flush_output():
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more at its end
        raise OSError(f"standard output: {error.strerror}") from error

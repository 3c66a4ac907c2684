# SPDX-License-Identifier: GPL-2.0-or-later
"""The logs of growth_log in a folder. Without a screen."""

import glob
import math
import os
import re
import zlib

from panel.texts import _

HEAD_BYTES = 64
NUMBERED = re.compile(rb"(growth-log,2),([0-9a-f]{8})\r?\n(log,(\d{1,7})),([0-9a-f]{8})\r?\n")


def number_of_log(path):
    """The number in the head of a growth log; 0 for none. A damaged one is infinite: it may be the last log."""
    try:
        with open(path, "rb") as file:
            start = file.read(HEAD_BYTES)
    except OSError:
        return 0
    found = NUMBERED.match(start)
    if not found:
        return math.inf if len(start) == HEAD_BYTES else 0
    sums = [b"%08x" % zlib.crc32(found[1] + b"\n"), b"%08x" % zlib.crc32(found[1] + b"\n" + found[3] + b"\n")]
    return int(found[4]) if sums == [found[2], found[5]] else math.inf


def last_log(folder):
    """The log of a folder with the highest number, or None. Names and times of files come from a clock, which may be wrong.
    Raises ValueError if two logs have this number."""
    logs = [(number_of_log(log), log) for log in sorted(glob.glob(os.path.join(glob.escape(folder), "growth-*.csv")))]
    highest = max(logs, default=(0, None))[0]
    found = [log for number, log in logs if number == highest]
    if len(found) > 1 and highest != math.inf:
        raise ValueError(_("{one} and {other} have the same number: move one of them out of {folder}.").format(
            one=os.path.basename(found[0]), other=os.path.basename(found[1]), folder=folder))
    return found[0] if found else None

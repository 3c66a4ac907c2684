# SPDX-License-Identifier: GPL-2.0-or-later
"""Counts the starts after the first one: each test that begins something again notes why. scripts/test prints the sums.

    python3 tests/support/restarts.py FILE

prints how often tests began again, by cause, and ends with 1 if a cause came more often than its limit.

    python3 tests/support/restarts.py FILE LastTestsFailed.log

notes the tests that ctest lists there, which scripts/test begins again.
"""

import collections
import os
import sys

RACE = "LinuxCNC's task read the status of motion too early"
STANDSTILL = "the computer stood still"
AXIS = "AXIS lost a command or a press"
FAILED = "it failed beside other tests"
# In one run of all tests. A quiet computer has none. One whose processors were taken away for half of the time had two
# standstills, and each test begins again twice at most. Five of 1191 tests failed on one that was three times too slow.
LIMITS = {RACE: 1, STANDSTILL: 8, AXIS: 4, FAILED: 5}


def note(cause, details=""):
    """Notes that a test begins again, in the file that PLUMB_RESTARTS names."""
    test = os.path.basename(sys.argv[0])
    print("%s begins again: %s.\n%s" % (test, cause, details), flush=True)
    path = os.environ.get("PLUMB_RESTARTS")
    if path:
        with open(path, "a", encoding="utf-8") as file:
            file.write("%s\t%s\n" % (cause, test))


def note_failed(path, failed):
    """Notes the tests of a list of ctest, in which each has its number and a colon before it."""
    with open(failed, encoding="utf-8") as names, open(path, "a", encoding="utf-8") as file:
        file.writelines("%s\t%s" % (FAILED, name.partition(":")[2]) for name in names)


def report(path):
    """The lines to print, and whether there are too many restarts."""
    try:
        with open(path, encoding="utf-8") as file:
            noted = [line.rstrip("\n").split("\t") for line in file]
    except FileNotFoundError:
        noted = []
    lines = ["%d restarts of tests" % len(noted)]
    too_many = False
    for cause, count in collections.Counter(cause for cause, _ in noted).most_common():
        tests = ", ".join(sorted({test for its, test in noted if its == cause}))
        lines.append("  %d: %s, at most %d are acceptable (%s)" % (count, cause, LIMITS[cause], tests))
        too_many = too_many or count > LIMITS[cause]
    return lines, too_many


if __name__ == "__main__":
    if len(sys.argv) > 2:
        note_failed(*sys.argv[1:])
        sys.exit()
    text, too_many = report(sys.argv[1])
    print("\n".join(text))
    sys.exit(1 if too_many else 0)

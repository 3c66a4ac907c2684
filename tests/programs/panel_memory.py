#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads all pins and signals as the panel does, as often as it does in some minutes. Its exit status is 1 if its memory grows."""

import sys

sys.path.insert(0, sys.argv[1])
from panel.hal_access import Hal  # noqa: E402

LOOKS = 400
MOST = 8000  # kB


def memory():
    with open("/proc/self/status") as file:
        return int(next(line for line in file if line.startswith("VmRSS")).split()[1])


its = Hal()
first = its.values()
before = memory()
for _ in range(LOOKS):
    last = its.values()
    its.signals()
grown = memory() - before
print("%d pins, %d looks: %d kB" % (len(last), LOOKS, grown), file=sys.stderr)
good = last.keys() == first.keys() and grown < MOST
its.close()
sys.exit(0 if good else 1)

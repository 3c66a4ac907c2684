#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Waits until a pin has a value, or is gone: wait_for.py PIN VALUE|gone SECONDS. Its exit status is 0 if that came."""

import sys
import time

import hal


def value_of(pin):
    try:
        return str(float(hal.get_value(pin)))
    except RuntimeError:
        return "gone"


it = hal.component("wait-for")
it.ready()
pin, wanted, seconds = sys.argv[1], sys.argv[2], float(sys.argv[3])
if wanted != "gone":
    wanted = str(float(wanted))
for _ in range(int(seconds * 100)):
    if value_of(pin) == wanted:
        sys.exit(0)
    time.sleep(0.01)
sys.exit(1)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Waits until a pin has a value: wait_for.py PIN VALUE SECONDS.  Its exit status tells whether that came."""

import sys
import time

import hal

it = hal.component("wait-for")
it.ready()
pin, value, seconds = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
for _ in range(int(seconds * 100)):
    if hal.get_value(pin) == value:
        sys.exit(0)
    time.sleep(0.01)
sys.exit(1)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A component whose output is twice its input; a negative input ends it."""

import sys
import time

import hal

it = hal.component(sys.argv[1] if len(sys.argv) > 1 else "doubler")
it.newpin("in", hal.HAL_FLOAT, hal.HAL_IN)
it.newpin("out", hal.HAL_FLOAT, hal.HAL_OUT)
it.ready()
try:
    while it["in"] >= 0:
        it["out"] = 2 * it["in"]
        time.sleep(0.01)
except KeyboardInterrupt:  # which is how halcmd ends a program
    pass

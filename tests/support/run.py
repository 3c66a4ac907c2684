# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs a Python test with the folders that tests import from: run.py [--again] TEST.py [argument ...].

With --again a test that fails while the computer stands still (standstill.py) runs again, twice at most: LinuxCNC's
programs run on a clock that is faster than the computer's, and a second without a processor is ten of theirs.

All that the test starts ends with it, also when the test or this program is killed (keeper.py).
"""

import os
import runpy
import subprocess
import sys

import keeper
import restarts
from standstill import Standstill
from tree import BUILD, ROOT

ATTEMPTS = 3


def run_again(command):
    for attempt in range(1, ATTEMPTS + 1):
        with Standstill() as standstill:
            status = subprocess.call(command)
        if status == 0 or not standstill.seen() or attempt == ATTEMPTS:
            return status
        sys.argv = [command[-1]]
        restarts.note(restarts.STANDSTILL, standstill)


keeper.keep()
if sys.argv[1] == "--again":
    sys.exit(run_again([sys.executable, sys.argv[0], *sys.argv[2:]]))
for folder in ("components/commissioning/contacts", "scripts/campaigns", "scripts/benches", "scripts"):
    sys.path.insert(1, os.path.join(ROOT, folder))
sys.path.insert(1, os.path.join(BUILD, "python"))  # before one that is installed
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")

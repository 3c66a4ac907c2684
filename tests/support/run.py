# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs a Python test with the folders that tests import from: run.py TEST.py [argument ...]."""

import os
import runpy
import sys

from tree import BUILD, ROOT

for folder in ("components/commissioning/contacts", "scripts/campaigns", "scripts/benches", "scripts"):
    sys.path.insert(1, os.path.join(ROOT, folder))
sys.path.insert(1, os.path.join(BUILD, "python"))  # before one that is installed
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")

# SPDX-License-Identifier: GPL-2.0-or-later
"""How tests run a bench of scripts/benches."""

import os
import subprocess
import sys

from tree import ROOT

PATIENCE = 200  # seconds


def run_bench(*words):
    """Runs scripts/bench with these words, a name and its options; returns status, stdout and stderr."""
    command = [sys.executable, os.path.join(ROOT, "scripts", "benches"), *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)

# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line of plumb run, also in a container that forbids namespaces, where it needs an option to go without."""

import functools
import os
import subprocess
import sys


def plumb_run(build, *options):
    """The words before the program: plumb run, its options and --."""
    plumb = os.path.join(build, "bin", "plumb")
    return [plumb, "run", *_going_without(plumb), *options, "--"]


@functools.lru_cache(maxsize=None)
def _going_without(plumb):
    tried = subprocess.run([plumb, "run", "true"], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if tried.returncode == 0 or "gives the run no namespaces" not in tried.stderr:
        return ()
    print("No namespaces here: LinuxCNC runs on the computer's one HAL, with its devices and network.", file=sys.stderr)
    return ("--no-namespaces",)

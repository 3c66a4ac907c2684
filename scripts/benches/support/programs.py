# SPDX-License-Identifier: GPL-2.0-or-later
"""Programs of this Plumb, called by a bench."""

import json
import os
import subprocess

from support.simulations import BUILD


def program(name, *arguments):
    """The output, as a document with --json. Raises RuntimeError with the program's reason."""
    done = subprocess.run([os.path.join(BUILD, "bin", name), *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{name} {' '.join(arguments)}: {done.stderr}")
    return json.loads(done.stdout) if "--json" in arguments else done.stdout

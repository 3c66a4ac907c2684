# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the tests are, and the build that they test."""

import os
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUILD = os.path.abspath(os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build")))


def own_folder(test, prefix="plumb-test-"):
    """A folder for the files of a test case or a test class, removed with it."""
    folder = tempfile.TemporaryDirectory(prefix=prefix)
    (test.addClassCleanup if isinstance(test, type) else test.addCleanup)(folder.cleanup)
    return folder.name

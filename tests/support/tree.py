# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the tests are, and the build that they test."""

import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUILD = os.path.abspath(os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build")))


def own_folder(test):
    """A folder for the files of a test case or a test class, removed with it."""
    from plumb_folder import TemporaryFolder  # where there is a build

    folder = TemporaryFolder()
    (test.addClassCleanup if isinstance(test, type) else test.addCleanup)(folder.cleanup)
    return folder.name

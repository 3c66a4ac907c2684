# SPDX-License-Identifier: GPL-2.0-or-later
"""Where the tests are, and the build that they test."""

import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUILD = os.path.abspath(os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build")))

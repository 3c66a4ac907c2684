# SPDX-License-Identifier: GPL-2.0-or-later
"""Marks a long test case, or a class of them, that has a shorter one beside it. scripts/test leaves it out; scripts/test --long runs it."""

import os
import unittest

left_out = []


def long(item):
    if os.environ.get("PLUMB_LONG"):
        return item
    left_out.append(item.__name__)
    return unittest.skip("scripts/test --long runs it")(item)

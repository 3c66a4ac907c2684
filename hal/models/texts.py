# SPDX-License-Identifier: GPL-2.0-or-later
"""Sentences for a terminal, and why something is refused."""

import textwrap


class Impossible(RuntimeError):
    """A conflict that keeps a function from being wired, in sentences."""


def wrapped(text, indent=""):
    return textwrap.fill(
        text,
        100,
        initial_indent=indent,
        subsequent_indent=" " * len(indent),
        break_long_words=False,
        break_on_hyphens=False,
    )

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Runs a bench of a function on simulated machines. See plumb-figures(1)."""

import os
import sys

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
BENCHES = os.path.join(PREFIX, "share", "plumb", "scripts", "benches")
SUMMARY = "runs a bench of a function and prints its figures"


def main():
    words = sys.argv[1:]
    if words == ["--summary"]:
        print(SUMMARY)
        return
    if words == ["--version"]:
        print("plumb @PROJECT_VERSION@")
        return
    os.environ["PLUMB_BUILD"] = PREFIX
    os.environ["PLUMB_BENCH"] = "plumb figures"
    os.environ.setdefault("PLUMB_FIGURES", os.path.abspath("figures"))
    os.execv("/usr/bin/python3", ["python3", "-B", BENCHES, *words])


if __name__ == "__main__":
    main()

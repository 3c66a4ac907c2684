# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the list of tests that CTest reads: discover.py PROGRAM JSON OUTPUT COMPUTE WAIT

JSON is what the GoogleTest program prints of its tests. Each source file becomes a test, or a test for each fifty that it
has: a process for each one would take as long to start as most of them run. Where they start LinuxCNC, it is ten. COMPUTE
and WAIT are the jobs that a test takes.
"""

import collections
import json
import os
import re
import sys


def lines(program, suites, compute, wait):
    files = collections.defaultdict(list)
    for suite in suites:
        for test in suite["testsuite"]:
            files[test["file"]].append("%s.%s" % (suite["name"], test["name"]))
    for file, tests in files.items():
        name = os.path.splitext(os.path.basename(file))[0]
        processors, at_once = (wait, 10) if re.search("/tests/(commands|host)/|/stock_", file) else (compute, 50)
        for first in range(0, len(tests), at_once):
            some = tests[first : first + at_once]
            its_name = name if len(tests) <= at_once else "%s_from_%d" % (name, first)
            yield "add_test([=[%s]=] [=[%s]=] --gtest_brief=1 [=[--gtest_filter=%s]=])\n" % (its_name, program, ":".join(some))
            yield "set_tests_properties([=[%s]=] PROPERTIES PROCESSORS %s TIMEOUT 600 COST %d)\n" % (its_name, processors, len(some))


_, its_program, path, output, *jobs = sys.argv
with open(path, encoding="utf-8") as source:
    found = json.load(source)["testsuites"]
with open(output, "w", encoding="utf-8") as target:
    target.writelines(lines(its_program, found, *jobs))

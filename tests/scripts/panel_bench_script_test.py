# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench panel measures all that it judges. How fast a computer is today is no matter of a test."""

import contextlib
import io
import re
import unittest

import panel


class PanelBench(unittest.TestCase):
    def test_it_measures_the_start_and_each_state(self):
        table = io.StringIO()
        with contextlib.redirect_stdout(table):
            panel.bench(2)
        found = dict(re.findall(r"(?m)^(\S.*?) +([\d.]+) (?:s|MB|% of a processor) +at most", table.getvalue()))
        self.assertEqual(set(found), set(panel.LIMITS))
        self.assertGreater(float(found["start"]), 0)
        self.assertGreater(float(found["at rest"]), 0, "it looks at HAL")


if __name__ == "__main__":
    unittest.main()

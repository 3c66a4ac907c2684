# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench ablation: a module without one mechanism, and an axis that needs it."""

import unittest

import ablation
import plumb
from plumb_folder import TemporaryFolder
from support import integral


class Ablation(unittest.TestCase):
    def test_each_text_stands_once_in_its_header(self):
        for name, mechanism in ablation.MECHANISMS.items():
            with self.subTest(name):
                if mechanism:
                    self.assertNotEqual(ablation.changed(*mechanism), "")

    def test_a_text_that_a_header_does_not_have_ends_the_bench(self):
        with self.assertRaisesRegex(SystemExit, "climb.hpp does not have this text once: no such text"):
            ablation.changed(ablation.CLIMB, "no such text", "")

    def test_an_axis_with_an_integral_passes_a_dead_point_without_the_first_inset(self):
        defaults = plumb.Host.__init__.__defaults__
        self.addCleanup(setattr, plumb.Host.__init__, "__defaults__", defaults)
        with TemporaryFolder() as folder:
            ablation.search_first(ablation.without(ablation.MECHANISMS["first cycle farther inside"], folder))
            self.assertGreater(integral.simulate(2, True, lambda seconds: True).first, integral.UNTOLD)


if __name__ == "__main__":
    unittest.main()

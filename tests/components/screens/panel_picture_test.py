# SPDX-License-Identifier: GPL-2.0-or-later
"""The pen of the pictures of the panel: each stroke stands alone; without a screen."""

import os
import sys
import unittest

import cairo
import gi

from tree import ROOT

gi.require_version("Gtk", "3.0")
sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from panel.picture import Pen  # noqa: E402


class Drawn(unittest.TestCase):
    def setUp(self):
        self.surface = cairo.ImageSurface(cairo.FORMAT_ARGB32, 200, 100)
        self.pen = Pen(cairo.Context(self.surface), False)

    def ink(self, left, top, right, bottom):
        """Number of pixels in a part of the picture that are drawn."""
        self.surface.flush()
        data, stride = self.surface.get_data(), self.surface.get_stride()
        return sum(data[y * stride + 4 * x + 3] > 0 for y in range(top, bottom) for x in range(left, right))

    def test_a_disc_after_words_has_no_line_to_their_end(self):
        self.pen.words(5, 90, "upper", 16)
        self.pen.disc(180, 20, 9, "pick", "text")
        self.assertEqual(self.ink(70, 0, 165, 100), 0)
        self.assertGreater(self.ink(172, 12, 188, 28), 200)

    def test_a_line_after_a_dashed_one_is_whole(self):
        self.pen.line((0, 20), (200, 20), dashes=(10, 10))
        self.pen.line((0, 60), (200, 60))
        self.assertLess(self.ink(0, 19, 200, 21), 240)
        self.assertEqual(self.ink(0, 59, 200, 61), 400)

    def test_a_box_without_an_edge_leaves_nothing_for_the_next_line(self):
        self.pen.box(20, 20, 40, 40, "pick")
        self.pen.line((100, 80), (180, 80), width=8)
        self.assertEqual(self.ink(0, 0, 20, 100), 0)


if __name__ == "__main__":
    unittest.main()

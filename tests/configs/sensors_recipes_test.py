# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/sensors/recipes: each loads, and hands its driver's value on. The drivers need devices, so they are left out."""

import glob
import os
import re
import unittest

from support import simulations  # noqa: F401 (for the way to plumb.py)
import plumb
from tree import ROOT

DRIVER = re.compile(r"\b(?:lcec|hm2_\w+|spindle-vfd|wj200-vfd|hy_gt_vfd)\.\S+")
RESULTS = {  # of a raw value of 50, or of -50 where the sign is not taken
    "lcec_torque": ("torque-raw", -500, "spindle-load", 50),
    "mesa_analogue": ("load-raw", 2.5, "spindle-load", 50),
    "mesa_encoder": ("speed-raw", -3000, "spindle-speed", 3000),
    "wj200_vfd": ("load-raw", 2.1, "spindle-load", 49.98),
    "hy_gt_vfd": ("load-raw", 1100, "spindle-load", 49.995),
    "vfs11_vfd": ("spindle-load", 50, "spindle-load", 50),
    "gs2_vfd": ("spindle-load", 50, "spindle-load", 50),
}


def lines_of(name):
    with open(os.path.join(ROOT, "configs", "sensors", "recipes", name + ".hal"), encoding="utf-8") as file:
        return file.read().splitlines()


class Recipes(unittest.TestCase):
    def test_each_hands_its_value_on(self):
        for name, (raw, value, result, wanted) in RESULTS.items():
            with self.subTest(name), plumb.Host() as host:
                host.command("loadrt threads name1=servo-thread period1=1000000")
                for line in lines_of(name):
                    if line.startswith(("#", "loadusr")) or DRIVER.search(line) and line.startswith("setp"):
                        continue
                    words = line.split()
                    if words and words[0] == "net" and not DRIVER.sub("", line).split()[2:]:
                        host.command("newsig %s %s" % (words[1], "bit" if words[1] == "load-valid" else "float"))
                    elif words:
                        host.command(DRIVER.sub("", line))
                host.command("sets %s %r" % (raw, value))
                host.command("start")
                host.run(0.01)
                self.assertAlmostEqual(host.get(result), wanted, 6)

    def test_each_names_its_source_its_bug_its_rate_and_whether_it_can_be_used(self):
        files = {os.path.basename(path)[:-4] for path in glob.glob(os.path.join(ROOT, "configs", "sensors", "recipes", "*.hal"))}
        self.assertEqual(files, set(RESULTS))
        for name in files:
            text = "\n".join(lines_of(name))
            for word in ("# Source: ", "# Known bug: ", "# Rate: ", "thermal_displacement"):
                self.assertIn(word, text, name)


if __name__ == "__main__":
    unittest.main()

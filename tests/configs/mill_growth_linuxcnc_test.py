#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill under a growth test in a complete LinuxCNC: thermal_displacement as it is, and with the wrong sign."""

import glob
import json
import os
import subprocess
import unittest

from linuxcnc_runs import BUILD, copy_configuration, own_folder, own_ini, run_to_the_end, start, um
from long import long
from starts import starts

TOLERANCE = 10 * um  # of growth_test.toml


def tested(folder, program):
    """The results of one test on a fresh mill."""
    machine = copy_configuration("mill", folder, program)
    ini = own_ini(os.path.join(machine, "growth.ini"))
    status, output = run_to_the_end(machine, lambda: start(folder, ini, "setup.ngc", "growth_test/%s.ngc" % program))
    if status != 0:
        raise AssertionError("linuxcnc ended with %d:\n%s" % (status, output))
    (log,) = glob.glob(os.path.join(machine, "logs", "growth-*.csv"))
    done = subprocess.run([os.path.join(BUILD, "bin", "plumb-growth"), "report", log, "--json"], check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)["tests"][0], output


@long
class MillUnderTest(unittest.TestCase):
    def judged(self, program, verdict, sentence):
        results, output = tested(own_folder(type(self)), program)
        self.assertIn("Growth test: The test has ended: the machine is warm.", output)
        self.assertEqual(results["verdict"], verdict)
        self.assertEqual(results["compensation"]["sentence"], sentence)
        z = results["axes"]["Z"]
        self.assertGreater(z["off"]["largest_mm"], 2 * TOLERANCE)  # the mill alone
        return z

    def test_thermal_displacement_removes_the_drift(self):
        z = self.judged("on", "pass", "The compensation removes the drift.")
        self.assertLess(z["on"]["largest_mm"], TOLERANCE)

    def test_a_wrong_sign_is_named_and_fails(self):
        z = self.judged("wrong_sign", "fail", "The compensation has the wrong sign.")
        self.assertGreater(z["on"]["largest_mm"], z["off"]["largest_mm"])


tearDownModule = starts("mill/growth.ini")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""Simulations on this computer: as many at a time as asked for, their results in order."""

import os
import time
import unittest

from support.simulations import ThisComputer, simulate_all


def report(number, progress):
    """Its number and process, after a while in which the other processes come to do something."""
    progress(1)
    time.sleep(0.2)
    return number, os.getpid()


def fail(number, progress):
    raise ValueError(f"simulation {number} failed")


class Simulations(unittest.TestCase):
    def test_results_are_in_the_order_of_the_tasks(self):
        found = simulate_all(report, [(number,) for number in range(5)], 5, ThisComputer(2))
        self.assertEqual([number for number, _ in found], [0, 1, 2, 3, 4])

    def test_so_many_run_at_a_time(self):
        for processes in (1, 3):
            found = simulate_all(report, [(number,) for number in range(6)], 6, ThisComputer(processes))
            self.assertEqual(len({process for _, process in found}), processes)

    def test_an_error_in_a_simulation_is_that_of_all(self):
        with self.assertRaisesRegex(ValueError, "simulation 0 failed"):
            simulate_all(fail, [(0,)], 1)


if __name__ == "__main__":
    unittest.main()

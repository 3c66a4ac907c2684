# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/campaign kills: the seed alone determines the victim, and a seed runs through."""

import json
import os
import subprocess
import unittest

import kills  # noqa: E402
from tree import ROOT


class Kills(unittest.TestCase):
    def test_a_seed_draws_the_same_kills_again_and_another_seed_others(self):
        plans = [json.dumps(kills.plan_of(seed)) for seed in (7, 7, 8)]
        self.assertEqual(plans[0], plans[1])
        self.assertNotEqual(plans[0], plans[2])

    def test_all_scenarios_roles_and_depths_are_drawn(self):
        drawn = [plan for seed in range(1, 30) for plan in kills.plan_of(seed)]
        for key, number in (("scenario", 6), ("role", 3), ("depth", 11), ("trap", 2), ("mode", 3)):
            self.assertEqual(len({plan[key] for plan in drawn}), number, key)

    @unittest.skipIf(os.environ.get("PLUMB_SANITIZE"), "the instants are drawn for programs of usual speed")
    def test_a_seed_finds_nothing(self):
        done = subprocess.run(
            [os.path.join(ROOT, "scripts", "campaign"), "kills", "--seed", "6"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=200,
            check=False,
        )
        if "no machine of its own" in done.stderr:
            self.skipTest(done.stderr)
        self.assertEqual(done.stdout, "seed 6: 12 tries, 0 findings\n", done.stderr)


if __name__ == "__main__":
    unittest.main()

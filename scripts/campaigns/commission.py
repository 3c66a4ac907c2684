# SPDX-License-Identifier: GPL-2.0-or-later
"""Trials of stages and functions beside others that have passed, are on, change or wait with an offset; the client lets go, is killed or hangs."""

import campaign

if __name__ == "__main__":
    campaign.run("commission", __doc__, campaign.of_tests("InterlockTrials.*", "TRIALS_SEED"), setup=("tests",))

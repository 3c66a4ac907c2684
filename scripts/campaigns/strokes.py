# SPDX-License-Identifier: GPL-2.0-or-later
"""Each setting of chopping changes in each phase of its strokes, alone or with another one; scales slip; and events beside an infeed."""

import campaign

if __name__ == "__main__":
    attack = campaign.of_tests("*/ChoppingSettingsAttack.*:ChoppingSlipsAttack.*:ChoppingInfeedAttack.*", "CHOPPING_SEED")
    campaign.run("strokes", __doc__, attack, setup=("tests",))

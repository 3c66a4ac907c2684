# SPDX-License-Identifier: GPL-2.0-or-later
"""Each setting of chopping changes in each phase of its strokes, alone or with another one; and scales slip."""

import os
import re
import subprocess

import campaign


def attack(seed):
    tests = os.path.join(campaign.BUILD, "tests", "tests")
    found = subprocess.run([tests, "--gtest_filter=*/ChoppingSettingsAttack.*:ChoppingSlipsAttack.*"], capture_output=True, text=True, check=False,
                           env={**os.environ, "CHOPPING_SEED": str(seed)})
    tries = sum(map(int, re.findall(r"^cases: (\d+)$", found.stdout, re.M)))
    findings = [text.strip() for text in re.findall(r"^(\S+: Failure\n.*?)(?=^\[ |^\S+: Failure)", found.stdout, re.M | re.S)]
    if not tries or (found.returncode and not findings):
        findings.append(f"the tests ended with status {found.returncode}: " + (found.stdout + found.stderr)[-2000:])
    return campaign.Outcome(tries, findings)


if __name__ == "__main__":
    campaign.run("strokes", __doc__, attack, setup=("tests",))

# SPDX-License-Identifier: GPL-2.0-or-later
"""Random sequences of faults, toggles and returns against all that moves an axis."""

import os
import re
import subprocess

import campaign

ATTACKS = 10  # of each seed, on each of the live machines


def attack(seed):
    tests = os.path.join(campaign.BUILD, "tests", "tests")
    found = subprocess.run([tests, "--gtest_filter=Faults.*:Faults/*"], capture_output=True, text=True, check=False,
                           env={**os.environ, "RC_PARAMS": f"seed={seed} max_success={ATTACKS} max_size=60 max_discard_ratio=100"})
    ran = re.findall(r"^\[ +(OK|FAILED) +\] (Faults[./][\w./]+) \(", found.stdout, re.M)
    findings = [re.sub(r"\n+", "\n    ", text.strip()) for text in re.findall(r"^(Falsifiable after.*?)(?=^\[ )", found.stdout, re.M | re.S)]
    if not ran or (found.returncode and not findings):
        findings.append(f"the tests ended with status {found.returncode}: " + (found.stdout + found.stderr)[-2000:])
    return campaign.Outcome(len(ran) * ATTACKS, findings)


if __name__ == "__main__":
    campaign.run("faults", __doc__, attack, setup=("tests",))

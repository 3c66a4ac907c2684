# SPDX-License-Identifier: GPL-2.0-or-later
"""Devices that fail in every way, against the links of modbus_sensor and can_sensor.

A seed is 10,000 faults, of Modbus devices over TCP and serial lines for odd seeds, on a CAN bus for even ones. A value that is valid
and older than it may be is a finding, and so is a link that does not recover or does not end.
"""

import os
import re
import subprocess

import campaign
from plumb_folder import TemporaryFolder

FAULTS = 10000
PATIENCE = 900  # s


def attack(seed):
    return can(seed) if seed % 2 == 0 else modbus(seed)


def modbus(seed):
    program = os.path.join(campaign.BUILD, "tests", "tests")
    environment = {**os.environ, "PLUMB_FAULTS": str(FAULTS), "PLUMB_SEED": str(seed)}
    return outcome([program, "--gtest_filter=ModbusLinkFaults.*"], environment)


def can(seed):
    machine = os.path.join(campaign.ROOT, "tests", "support", "can_vm")
    program = os.path.join(campaign.BUILD, "specimens", "can_link_faults")
    with TemporaryFolder() as folder:
        words = [machine, str(PATIENCE), folder, program, str(FAULTS), str(seed)]
        return outcome(words, {**os.environ, "PLUMB_BUILD": campaign.BUILD})


def outcome(words, environment):
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False, timeout=2 * PATIENCE)
    counted = re.search(r"^(\d+) faults.*", done.stdout, re.M)
    if counted:
        print(counted[0], flush=True)
    if done.returncode == 0 and counted:
        return campaign.Outcome(int(counted[1]), [])
    text = f"{words[0]} ended with status {done.returncode}: {(done.stdout + done.stderr)[-2000:]}"
    return campaign.Outcome(int(counted[1]) if counted else 0, [text])


if __name__ == "__main__":
    campaign.run("sensors", __doc__, attack, setup=("tests",))

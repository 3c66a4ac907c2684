# SPDX-License-Identifier: GPL-2.0-or-later
"""Trials beside others that have passed, are on, change or wait with an offset. The client lets go, is killed, stopped or hangs.

Each seed tries interlock on a bench, and runs a complete LinuxCNC twice in virtual time. The first run ends plumb commission in each of its
steps, in each way. The second one commissions functions that have drawn faults in their wiring.
"""

import os
import subprocess
import sys

import campaign

INTERLOCK = campaign.of_tests("InterlockTrials.*", "TRIALS_SEED")
WIRINGS = 5


def attack(seed):
    import commissioning_attacks as attacks

    tried = INTERLOCK(seed)
    table, findings, tries = [("interlock", tried.tries, 0)], list(tried.findings), tried.tries
    names = attacks.FUNCTIONS[seed % len(attacks.FUNCTIONS) :] + attacks.FUNCTIONS[: seed % len(attacks.FUNCTIONS)]
    for work in (lambda: attacks.sessions(names[0], seed), lambda: attacks.wirings(names[1], seed, WIRINGS)):
        try:
            run = work()
        except (AssertionError, OSError, subprocess.SubprocessError) as error:
            findings.append("LinuxCNC did not come to its end: " + str(error)[-2000:])
            continue
        table += run.rows
        tries += run.tries
        findings += run.findings
    print("".join("| %d | %-50s | %4d | %4d |\n" % (seed, *row) for row in table), end="", flush=True)
    return campaign.Outcome(tries, findings)


def prepare(_options):
    sys.path[:0] = [os.path.join(campaign.BUILD, "python"), os.path.join(campaign.ROOT, "tests", "support"), os.path.join(campaign.ROOT, "scripts")]
    print("| Seed | What | Tries | In a press |\n| --- | --- | --- | --- |", flush=True)


if __name__ == "__main__":
    campaign.run("commission", __doc__, attack, setup=("tests",), prepare=prepare)

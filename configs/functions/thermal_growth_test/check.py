# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of thermal_growth_test on a copy: the outputs of a program begin a test, a pass, and end them."""

import csv
import os

IDLE, PROBING_COLD, WARMING, INTERRUPTED = 0, 1, 2, 5
LONGEST = 60  # s

# One program: on a busy computer, commands in MDI come too far apart for a test that runs.
BEGIN_AND_END = """M64 P24
M64 P25
G4 P0.5
M65 P25
G4 P0.5
M65 P24
G4 P0.5
M2
"""


def check(machinery):
    program, record = (os.path.join(machinery.folder, name) for name in ("growth_trial.ngc", "growth_trial.csv"))
    with open(program, "w", encoding="ascii") as file:
        file.write(machinery.numbered(BEGIN_AND_END))
    with machinery.machine.recording(record, ["growth-test.state-code"]):
        machinery.machine.run(program, LONGEST)
    with open(record, encoding="utf-8") as file:
        codes = [int(float(row["growth-test.state-code"])) for row in csv.DictReader(file)]
    states = [code for code, before in zip(codes, [IDLE] + codes) if code != before]
    begun = PROBING_COLD in states
    after = states[states.index(PROBING_COLD) + 1 :] if begun else []
    machinery.machine.wait(2)  # growth_log looks for the component once a second
    return [
        ("a program begins a test and its first pass", begun),
        ("the pass ends, and the machine warms", after[:1] == [WARMING]),
        ("a test that does not reach its end can be resumed", after[1:] == [INTERRUPTED]),
        ("its records count up to %d" % machinery.get("growth-test.rows"), machinery.get("growth-test.rows") >= 4),
        ("growth_log has written them all", machinery.get("growth-log.lines") == machinery.get("growth-test.rows") and not machinery.get("growth-log.fault")),
        ("interlock sees that growth_log runs", machinery.get("interlock.service-ok-6")),
    ]

# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of thermal_growth_test on a copy: the outputs of a program begin a test, a pass, and end them."""

PROBING_COLD, WARMING, INTERRUPTED = 1, 2, 5


def check(machinery):
    def state_after(*words):
        for word in words:
            machinery.machine.mdi(machinery.numbered(word))
        machinery.machine.wait(0.3)
        return machinery.get("growth-test.state-code")

    probing = state_after("M64 P24", "M64 P25")
    warming = state_after("M65 P25")
    interrupted = state_after("M65 P24")
    machinery.machine.wait(2)  # growth_log looks for the component once a second
    return [
        ("a program begins a test and its first pass", probing == PROBING_COLD),
        ("the pass ends, and the machine warms", warming == WARMING),
        ("a test that does not reach its end can be resumed", interrupted == INTERRUPTED),
        ("its records count up to %d" % machinery.get("growth-test.rows"), machinery.get("growth-test.rows") >= 4),
        ("growth_log has written them all", machinery.get("growth-log.lines") == machinery.get("growth-test.rows") and not machinery.get("growth-log.fault")),
        ("interlock sees that growth_log runs", machinery.get("interlock.service-ok-6")),
    ]

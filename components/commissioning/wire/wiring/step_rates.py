# SPDX-License-Identifier: GPL-2.0-or-later
"""Step generators of software that are slower than their joints may move: a common reason of a following error."""

import math
import re


def too_slow(machine):
    """A sentence for each joint whose stepgen cannot follow."""
    state = machine.complete
    thread = state.thread_with("stepgen.make-pulses")
    period = thread and float(state.periods[thread])  # ns
    for joint in sorted({joint for joints in machine.joints.values() for joint in joints}) if period else ():
        stepgen = _stepgen_of(state, joint)
        if stepgen is None:
            continue
        steplen, stepspace, scale = (float(state.values.get(stepgen + "." + name, 0)) for name in ("steplen", "stepspace", "position-scale"))
        periods = max(math.ceil(steplen / period), 1) + math.ceil(stepspace / period)
        fastest = 1e9 / (period * periods) / abs(scale) if scale else math.inf
        wanted = machine.number(joint, "MAX_VELOCITY")
        if fastest < wanted:
            sentence = "Joint %d may move at %g/s, by MAX_VELOCITY of [JOINT_%d], and %s makes steps for %.3g/s at most: %g ns of %s, %g steps a unit. Lower one of these."
            yield sentence % (joint, wanted, joint, stepgen, fastest, period, thread, abs(scale))


def _stepgen_of(state, joint):
    """The stepgen that takes the command of a joint."""
    signal = state.signals.get(state.signal_of("joint.%d.motor-pos-cmd" % joint))
    for pin in signal.readers if signal else ():
        if re.fullmatch(r"stepgen\.\d+\.position-cmd", pin):
            return pin.rpartition(".")[0]
    return None

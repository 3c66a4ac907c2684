# SPDX-License-Identifier: GPL-2.0-or-later
"""What the pins show of sessions of commissioning that came to an end in a step: nothing moved but what was pressed, and it returned.

The recording has a row for each period. A press is computed here from the pins that the session writes, not from what interlock says.
"""

import collections
import json
import os

import numpy as np

FUNCTIONS = ("thermal_displacement", "squareness", "chopping")  # by their numbers at interlock
STAGES = ("x-stage", "y-stage", "z-stage", "z-axis-stage")
STAGES_OF = ((3,), (0, 1, 2), (2,))
STROKES, SHARED = 2, 2  # a function; and a stage that it shares with squareness
TRIAL = ("beat", "stage", "function", "offset", "measures")
COLUMNS = [
    "motion.motion-enabled", "spindle.0.speed-out", "axis.z.eoffset", *("interlock.trial-" + short for short in TRIAL),
    *("%s.%s" % (stage, short) for stage in STAGES[:3] for short in ("drive-command", "joint-command")),
    *("interlock.%s-%s-%d" % (kind, short, number) for kind, rows in (("function", FUNCTIONS), ("stage", STAGES)) for number in range(len(rows))
      for short in ("passed", "identity")),
    *("interlock.function-enable-%d" % number for number in range(len(FUNCTIONS))),
]
PERIOD = 0.001  # s
PAUSE = 0.5  # s of the computer's clock
RAMP = 0.1  # mm/s, the ramp-rate of all stages here
LAG = 4  # rows from a pin of interlock to the drive
BRAKE = 100  # rows in which a stroke, or a change that is held, comes to a stand
STILL = 1e-6  # mm
CREEP = 5e-5  # mm, of braking before a return
BACK = 2e-4  # mm

Press = collections.namedtuple("Press", "begin end stages function asked")


def judge(recording, function, speed):
    """Findings as (row, sentence); and the presses, with what each showed."""
    its = FUNCTIONS.index(function)
    outputs = [recording[stage + ".drive-command"] - recording[stage + ".joint-command"] for stage in STAGES[:3]] + [recording["axis.z.eoffset"]]
    on = recording["motion.motion-enabled"] != 0
    presses, findings, shown = _presses(recording, speed), [], []
    pressed = np.zeros(len(on), bool)
    for press in presses:
        pressed[press.begin : press.end + LAG] = True
    for press in presses:
        findings += _beside(press, outputs)
        its_findings, what = _return(press, presses, outputs, on, recording)
        findings += its_findings
        shown.append(what)
    findings += _unpressed(recording, its, outputs, pressed)
    return sorted(findings), presses, shown


def _presses(recording, speed):
    """From the pins that a session writes: it has chosen a stage or a function, and beats."""
    beat, stage, function = (recording["interlock.trial-" + short] for short in ("beat", "stage", "function"))
    rests = (recording["motion.motion-enabled"] == 0) | ((recording["spindle.0.speed-out"] != 0) & (recording["interlock.trial-measures"] == 0))
    rows, changes = np.arange(len(beat)), np.r_[True, np.diff(beat) != 0]
    heard = (rows - np.maximum.accumulate(np.where(changes, rows, 0))) * PERIOD < PAUSE * speed
    presses, begun, over, begin = [], False, False, None
    for row in rows:
        chosen = stage[row] >= 0 or function[row] >= 0
        begun = chosen and (begun or heard[row])
        over = chosen and (over or (begun and (not heard[row] or rests[row])))
        is_pressed = chosen and heard[row] and not over
        if is_pressed and begin is None:
            begin = row
        elif not is_pressed and begin is not None:
            its = int(function[row - 1])
            stages = (int(stage[row - 1]),) if stage[row - 1] >= 0 else STAGES_OF[its] if not recording["interlock.trial-measures"][row - 1] else ()
            presses.append(Press(begin, row, stages, its, abs(recording["interlock.trial-offset"][row - 1])))
            begin = None
    return presses


def _beside(press, outputs):
    """All other stages stand while somebody presses; a stage on trial goes no farther than it is asked to."""
    findings = []
    for number, output in enumerate(outputs):
        its = output[press.begin + LAG : press.end]
        if not len(its):
            continue
        if number in press.stages:
            if press.function < 0 and np.abs(its).max() > max(press.asked, abs(its[0])) + STILL:
                findings.append((press.begin, "%s went to %.4f in a press of %.4f" % (STAGES[number], np.abs(its).max(), press.asked)))
        elif len(its) > BRAKE and np.ptp(its[BRAKE:]) > STILL:
            findings.append((press.begin, "%s moved by %.4f beside a press of %s" % (STAGES[number], np.ptp(its[BRAKE:]), _name(press))))
    return findings


def _name(press):
    return ", ".join(STAGES[number] for number in press.stages) if press.function < 0 else FUNCTIONS[press.function]


def _return(press, presses, outputs, on, recording):
    """After a press a stage returns at its ramp; strokes stand; with the machine off nothing moves. Returns findings, and the largest offset, the time
    to 0 and the time that the ramp needs."""
    findings, most = [], (0.0, 0.0, 0.0)
    scene = recording["scene"]
    following = min([other.begin for other in presses if other.begin >= press.end] + [_first(scene[press.end :] != scene[press.end - 1], press.end)])
    for number in press.stages:
        output, begin = outputs[number], press.end + LAG
        size = abs(output[min(press.end, len(output) - 1)])
        takes = size / RAMP + 0.1
        end = min(following, begin + int(takes / PERIOD) + LAG)
        window = output[begin:end]
        shares = number == SHARED and any(recording["interlock.function-enable-%d" % other][begin:end].any() for other in (1, STROKES) if other != press.function)
        if not len(window) or shares:
            continue
        if not on[press.end : end].all():
            held = output[begin:following][~on[begin:following]]
            if press.function != STROKES and len(held) and np.ptp(held) > STILL:
                findings.append((press.end, "%s moved by %.4f with the machine off" % (STAGES[number], np.ptp(held))))
        elif press.function == STROKES:
            stands = output[begin + BRAKE : min(following, _first(~on[begin:], begin))]
            if len(stands) and np.ptp(stands) > STILL:
                findings.append((press.end, "the stroke went on by %.4f" % np.ptp(stands)))
        else:
            if np.abs(window).max() > size + CREEP:
                findings.append((press.end, "%s went on by %.4f after the press" % (STAGES[number], np.abs(window).max() - size)))
            if end < following and abs(output[end - 1]) > BACK:
                findings.append((press.end, "%s is %.4f from 0, %.2f s after a press of %.4f" % (STAGES[number], output[end - 1], takes, size)))
            there = np.flatnonzero(np.abs(window) <= BACK)
            if len(there) and size > most[0]:
                most = (size, there[0] * PERIOD, size / RAMP)
    return findings, most


def _unpressed(recording, function, outputs, pressed):
    """Between presses a stage that has not passed goes nowhere but to 0, and the function of the session is off."""
    findings = []

    def passes(kind, number):
        identity = recording["interlock.%s-identity-%d" % (kind, number)]
        return (identity != 0) & (identity == recording["interlock.%s-passed-%d" % (kind, number)])

    enabled = recording["interlock.function-enable-%d" % function] != 0
    for row in _begins(enabled & ~pressed & ~passes("function", function)):
        findings.append((row, "%s is enabled without a press" % FUNCTIONS[function]))
    for number, output in enumerate(outputs):
        rests = ~pressed & ~passes("stage", number)
        for begin, end in _runs(rests):
            its = np.abs(output[begin:end])
            beyond = its - np.minimum.accumulate(its)
            if len(its) and beyond.max() > CREEP:
                findings.append((begin, "%s, which has not passed, moved by %.4f without a press" % (STAGES[number], beyond.max())))
    return findings


def _first(holds, begin):
    """The first row that does, from a row on; the number of all rows where none does."""
    return begin + (int(np.argmax(holds)) if holds.any() else len(holds))


def _runs(holds):
    edges = np.flatnonzero(np.diff(np.r_[False, holds, False]))
    return list(zip(edges[::2], edges[1::2]))


def _begins(holds):
    return [begin for begin, _end in _runs(holds)]


# --- whole runs ---

Run = collections.namedtuple("Run", "tries findings rows facts")
Run.__doc__ = "rows: (what, tries, of them in a press) for a table"
PATIENCE = 1800  # s, for a session that ends in each of its steps


def sessions(function, seed, ways=("kill", "stop", "hang"), steps=99):
    """Commissions a function, and ends it in each of its first steps in each way, or in a drawn one. The other functions are in drawn states."""
    import linuxcnc_runs
    from commissioning_machines import prepared
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        os.chmod(folder, 0o777)
        ini = prepared(folder, "shop")
        its, _output = linuxcnc_runs.work(folder, ini, "commission_attacks_scenario.py", "die", function, str(seed), str(steps), *ways, patience=PATIENCE)
        recording = linuxcnc_runs.read_recording(os.path.join(os.path.dirname(ini), "attacks.csv"))
    facts = its["facts"]
    found, presses, shown = judge(recording, function, facts["speed"])
    tries = {one["scene"]: one for one in facts["tries"]}
    of_scene = [tries.get(int(recording["scene"][press.end - 1])) for press in presses]
    rows = [("%s, %s" % (function, way), sum(one["way"] == way for one in tries.values()), sum(one is not None and one["way"] == way for one in of_scene))
            for way in sorted({one["way"] for one in tries.values()})]
    findings = list(facts["findings"])
    for row, sentence in found:
        one = tries.get(int(recording["scene"][row]))
        findings.append("%s at %.3f s%s: %s" % (function, row * PERIOD, " of %s" % json.dumps(one) if one else "", sentence))
    return Run(len(tries), findings, rows, {**facts, "return": max(shown, default=(0, 0, 0))})


def wirings(function, seed, count):
    """A function is commissioned with drawn faults in its wiring: none passes, unless the sheet says that the pin was not tried."""
    import linuxcnc_runs
    from commissioning_machines import prepared
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        os.chmod(folder, 0o777)
        its, _output = linuxcnc_runs.work(folder, prepared(folder, "shop"), "commission_attacks_scenario.py", "wire", function, str(seed), str(count),
                                          patience=PATIENCE)
    tries = its["facts"]["tries"]
    kinds, findings = collections.Counter(), []
    for one in tries:
        untried = one["sheet"].partition("\nNot tried\n")[2].partition("\nSettings\n")[0]
        told = all(pin in untried for pin in one["wiring"].partition(": ")[2].split(" and "))
        kinds["refused: " + one["fault"] if not one["passed"] else "not tried, on the sheet" if told else "passed"] += 1
        if one["passed"] and not told:
            findings.append("%s passed with a wrong wiring, %s" % (function, one["wiring"]))
    return Run(len(tries), findings, [("%s, %s" % (function, kind), count, 0) for kind, count in sorted(kinds.items())], its["facts"])

# SPDX-License-Identifier: GPL-2.0-or-later
"""What the pins show of sessions of commissioning that came to an end in a step: nothing moved but what was pressed, and it returned.

The recording has a row for each period. A press is computed here from the pins that the session writes, not from what interlock says.
"""

import collections
import json
import os

import numpy as np

TRIAL = ("beat", "stage", "function", "offset", "measures")


class Machine:
    """A machine of commissioning_machines: its functions and stages by their numbers at interlock, the stages of each function, and the bits
    by which a function lets a program move an axis. Functions that return their offsets slower than the stages have a rate, in mm/s."""

    def __init__(self, name, functions, stages, stages_of, allows=(), rates=()):
        self.name, self.functions, self.stages, self.stages_of = name, functions, stages, stages_of
        self.allows, self.rates = dict(allows), dict(rates)
        self.strokes = functions.index("chopping") if "chopping" in functions else None
        self.columns = [
            "motion.motion-enabled", "spindle.0.speed-out", "axis.z.eoffset", *("interlock.trial-" + short for short in TRIAL),
            *("%s.%s" % (stage, short) for stage in stages if stage != "z-axis-stage" for short in ("drive-command", "joint-command")),
            *("interlock.%s-%s-%d" % (kind, short, number) for kind, rows in (("function", functions), ("stage", stages)) for number in range(len(rows))
              for short in ("passed", "identity")),
            *("interlock.function-enable-%d" % number for number in range(len(functions))), *self.allows.values(),
        ]

    def outputs(self, recording):
        return [recording["axis.z.eoffset"] if stage == "z-axis-stage" else recording[stage + ".drive-command"] - recording[stage + ".joint-command"]
                for stage in self.stages]

    def time_to_return(self, press, sizes):
        """A stage returns by itself, and a slower function as a vector."""
        slow = self.rates.get(self.functions[press.function]) if press.function >= 0 else None
        return np.linalg.norm(sizes) / slow if slow else max(sizes) / RAMP

    def others_at(self, stage, function):
        """The other functions of a stage that several have."""
        users = [number for number, stages in enumerate(self.stages_of) if stage in stages]
        return [number for number in users if number != function] if len(users) > 1 else []


JOINTS = ("x-stage", "y-stage", "z-stage")
MACHINES = (
    Machine("shop", ("thermal_displacement", "squareness", "chopping"), (*JOINTS, "z-axis-stage"), ((3,), (0, 1, 2), (2,))),
    Machine("turning", ("centre_height", "axis_growth"), JOINTS, ((), (0, 1, 2)), {"centre_height": "centre.move-allowed"}),
    Machine("warm", ("axis_growth", "thermal_growth_test"), JOINTS, ((0, 1, 2), ()), rates={"axis_growth": 0.004}),
)
MACHINE_OF = {function: machine for machine in MACHINES for function in machine.functions}  # axis_growth has its sessions on the warm one
FUNCTIONS = tuple(MACHINE_OF)
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
    machine = MACHINE_OF[function]
    outputs = machine.outputs(recording)
    on = recording["motion.motion-enabled"] != 0
    presses, findings, shown = _presses(machine, recording, speed), [], []
    pressed = np.zeros(len(on), bool)
    for press in presses:
        pressed[press.begin : press.end + LAG] = True
    for press in presses:
        findings += _beside(machine, press, outputs)
        its_findings, what = _return(machine, press, presses, outputs, on, recording)
        findings += its_findings
        shown.append(what)
    findings += _unpressed(machine, recording, function, outputs, pressed)
    return sorted(findings), presses, shown


def _presses(machine, recording, speed):
    """From the pins that a session writes: it has chosen a stage or a function, and beats."""
    beat, stage, function = (recording["interlock.trial-" + short] for short in ("beat", "stage", "function"))
    rests = (recording["motion.motion-enabled"] == 0) | ((recording["spindle.0.speed-out"] != 0) & (recording["interlock.trial-measures"] == 0))
    changes = np.r_[False, np.diff(beat) != 0]
    presses, begun, over, begin, last = [], False, False, None, None
    for row in range(len(beat)):
        chosen = stage[row] >= 0 or function[row] >= 0
        last = None if not chosen else row if changes[row] else last  # a beat of the press before begins no trial
        heard = last is not None and (row - last) * PERIOD < PAUSE * speed
        begun = chosen and (begun or heard)
        over = chosen and (over or (begun and (not heard or rests[row])))
        is_pressed = chosen and heard and not over
        if is_pressed and begin is None:
            begin = row
        elif not is_pressed and begin is not None:
            its = int(function[row - 1])
            stages = (int(stage[row - 1]),) if stage[row - 1] >= 0 else machine.stages_of[its] if not recording["interlock.trial-measures"][row - 1] else ()
            presses.append(Press(begin, row, stages, its, abs(recording["interlock.trial-offset"][row - 1])))
            begin = None
    return presses


def _beside(machine, press, outputs):
    """All other stages stand while somebody presses; a stage on trial goes no farther than it is asked to."""
    findings = []
    for number, output in enumerate(outputs):
        its = output[press.begin + LAG : press.end]
        if not len(its):
            continue
        if number in press.stages:
            if press.function < 0 and np.abs(its).max() > max(press.asked, abs(its[0])) + STILL:
                findings.append((press.begin, "%s went to %.4f in a press of %.4f" % (machine.stages[number], np.abs(its).max(), press.asked)))
        elif len(its) > BRAKE and np.ptp(its[BRAKE:]) > STILL:
            findings.append((press.begin, "%s moved by %.4f beside a press of %s" % (machine.stages[number], np.ptp(its[BRAKE:]), _name(machine, press))))
    return findings


def _name(machine, press):
    return ", ".join(machine.stages[number] for number in press.stages) if press.function < 0 else machine.functions[press.function]


def _return(machine, press, presses, outputs, on, recording):
    """After a press a stage returns at its ramp; strokes stand; with the machine off nothing moves. Returns findings, and the largest offset, the time
    to 0 and the time that the ramp needs."""
    findings, most = [], (0.0, 0.0, 0.0)
    scene = recording["scene"]
    sizes = [abs(outputs[number][min(press.end, len(on) - 1)]) for number in press.stages]
    needs = machine.time_to_return(press, sizes) if sizes else 0
    following = min([other.begin for other in presses if other.begin >= press.end] + [_first(scene[press.end :] != scene[press.end - 1], press.end)])
    for number, size in zip(press.stages, sizes):
        output, begin = outputs[number], press.end + LAG
        takes = needs + 0.1
        end = min(following, begin + int(takes / PERIOD) + LAG)
        window = output[begin:end]
        shares = any(recording["interlock.function-enable-%d" % other][begin:end].any() for other in machine.others_at(number, press.function))
        if not len(window) or shares:
            continue
        if not on[press.end : end].all():
            held = output[begin:following][~on[begin:following]]
            if press.function != machine.strokes and len(held) and np.ptp(held) > STILL:
                findings.append((press.end, "%s moved by %.4f with the machine off" % (machine.stages[number], np.ptp(held))))
        elif press.function == machine.strokes:
            stands = output[begin + BRAKE : min(following, _first(~on[begin:], begin))]
            if len(stands) and np.ptp(stands) > STILL:
                findings.append((press.end, "the stroke went on by %.4f" % np.ptp(stands)))
        else:
            if np.abs(window).max() > size + CREEP:
                findings.append((press.end, "%s went on by %.4f after the press" % (machine.stages[number], np.abs(window).max() - size)))
            if end < following and abs(output[end - 1]) > BACK:
                findings.append((press.end, "%s is %.4f from 0, %.2f s after a press of %.4f" % (machine.stages[number], output[end - 1], takes, size)))
            there = np.flatnonzero(np.abs(window) <= BACK)
            if len(there) and size > most[0]:
                most = (size, there[0] * PERIOD, needs)
    return findings, most


def _unpressed(machine, recording, function, outputs, pressed):
    """Between presses a stage that has not passed goes nowhere but to 0, and the function of the session is off and lets no program move."""
    findings, its_number = [], machine.functions.index(function)

    def passes(kind, number):
        identity = recording["interlock.%s-identity-%d" % (kind, number)]
        return (identity != 0) & (identity == recording["interlock.%s-passed-%d" % (kind, number)])

    held = ~pressed & ~passes("function", its_number)
    for row in _begins((recording["interlock.function-enable-%d" % its_number] != 0) & held):
        findings.append((row, "%s is enabled without a press" % function))
    allows = machine.allows.get(function)
    for begin, end in _runs((recording[allows] != 0) & held) if allows else ():
        if end - begin > LAG:
            findings.append((begin, "%s without a press" % allows))
    for number, output in enumerate(outputs):
        rests = ~pressed & ~passes("stage", number)
        for begin, end in _runs(rests):
            its = np.abs(output[begin:end])
            beyond = its - np.minimum.accumulate(its)
            if len(its) and beyond.max() > CREEP:
                findings.append((begin, "%s, which has not passed, moved by %.4f without a press" % (machine.stages[number], beyond.max())))
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
        ini = prepared(folder, MACHINE_OF[function].name)
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
        its, _output = linuxcnc_runs.work(folder, prepared(folder, MACHINE_OF[function].name), "commission_attacks_scenario.py", "wire", function, str(seed), str(count),
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

# SPDX-License-Identifier: GPL-2.0-or-later
"""interlock, which stands between the functions, their stages, plumb-retain and LinuxCNC. It is loaded once."""

import plumb
from stages import Part, instance, message

RETAIN, LINK, TASK_AND_IO = 1, 2, 16 + 32  # the services of interlock, as sums


def room(row):
    """The number of functions, or of stages, that interlock serves: its pins function-enable-N, stage-fault-N."""
    return sum(pin.startswith(row + "-") for pin in plumb.declarations("interlock")["pins"])


def problems(functions, stages):
    """A sentence for each row of interlock that is too short."""
    instances = [name for part in stages for names in part.modules.values() for name in names]
    rows = (("functions", "function-enable", [function.name for function in functions]), ("stages", "stage-fault", instances))
    sentence = "interlock serves %d %s, and there are %d: %s. Wire fewer functions."
    return [
        sentence % (room(row), kind, len(names), ", ".join(names)) for kind, row, names in rows if len(names) > room(row)
    ]


def switch(number):
    """The pin by which the operator switches a function."""
    return "interlock.function-switch-%d" % number


def interlock(functions, stages, has_operation):
    """The interlock of these functions and of the Parts of their stages."""
    part = Part("interlock: permits the functions, arms the stages, holds LinuxCNC back", {"interlock": ["interlock"]})
    part.nets = [
        ["motion-enabled", "motion.motion-enabled", "=>", "interlock.motion-enabled"],
        ["all-homed", "motion.is-all-homed", "=>", "interlock.all-homed"],
        ["motion-type", "motion.motion-type", "=>", "interlock.motion-type"],
    ]
    if has_operation:
        part.nets.append(["operation-key", "motion.analog-out-00", "=>", "interlock.operation-key"])
        part.nets.append(["operation", "interlock.operation"])
    for function in functions:
        number = function.number
        part.setp += _services(number, function)
        part.setp.append(("interlock.function-stages-%d" % number, _stages(function, stages)))
        part.nets.append([function.interlock["enable"], "interlock.function-enable-%d" % number])
        part.nets.append([function.interlock["status"], "interlock.function-status-%d" % number])
        busy = function.interlock.get("busy", "program-running")
        part.nets.append([busy, "=>", "interlock.function-busy-%d" % number])
        for name in ("settling", "ramping"):
            if name in function.interlock:
                part.nets.append([function.interlock[name], "=>", "interlock.function-%s-%d" % (name, number)])
    for number, stage in enumerate(stages):
        name = instance(stage)
        part.setp.append((name + ".row", number))
        part.nets.append([name + "-permit", "interlock.stage-permit-%d" % number, "=>", name + ".permit"])
        for name, signal in stage.reports.items():
            part.nets.append([signal, "=>", "interlock.stage-%s-%d" % (name, number)])
    part.nets += [
        ["wait", "interlock.feed-inhibit", "=>", "motion.feed-inhibit", "motion.feed-hold"],
        ["no-homing", "interlock.homing-inhibit", "=>", "motion.homing-inhibit"],
        ["stages-ramping", "interlock.ramping"],
        ["spindle-speed-cmd", "spindle.0.speed-out", "=>", "interlock.spindle-speed"],
        ["feed-held", "interlock.feed-held", "=>", "linuxcnc-link.feed-held"],
        ["interlock-fault", "interlock.fault", "=>", "linuxcnc-link.interlock-fault"],
        ["interlock-code", "interlock.fault-code", "=>", "linuxcnc-link.interlock-fault-code"],
    ]
    part.messages = message("interlock-fault", "Interlock: {code}", "Verriegelung: {code}", "interlock fault-code")
    german = "Der Vorschub steht, bis die Achsen ihren Versatz haben."
    part.messages += message("feed-held", "The feed is held until the axes have their offsets.", german)
    for function in functions:
        if function.stroke:
            _stroke(part, function.number)
    armed = [stage.modules["axis_offset"][0][0].upper() for stage in stages if "axis_offset" in stage.modules]
    if armed:
        _arm(part, " or ".join(armed))
    part.last = ["interlock.update"]
    return part


def _services(number, function):
    """The services of a function, from its wire.toml; an offset with records needs plumb-retain, a stroke needs linuxcnc_link,
    task and io, too."""
    needs = function.interlock.get("services", 0) + (RETAIN if function.records else 0)
    if not function.stroke:
        return [("interlock.function-services-%d" % number, needs)]
    needs += LINK + TASK_AND_IO
    return [("interlock.function-services-%d" % number, needs), ("interlock.function-urgent-%d" % number, TASK_AND_IO)]


def _stages(function, stages):
    """The stages that take offsets of a function, as a sum."""
    given = {*function.joint_offset.values(), *(signals[0] for signals in function.axis_offset.values())}
    return sum(1 << number for number, stage in enumerate(stages) if any(net[0] in given for net in stage.nets))


def _stroke(part, number):
    """The message for a stroke that a loss has ended."""
    part.nets.append(["strokes-lost", "interlock.function-lost-%d" % number, "=>", "linuxcnc-link.strokes-lost"])
    sentence = "A program that strokes need did not answer. No other stroke starts before you turn the switch of strokes off and on."
    german = "Ein Programm, das die Hübe brauchen, antwortete nicht. Kein anderer Hub beginnt, ehe Sie den Schalter der Hübe aus- und einschalten."
    part.messages += message("strokes-lost", sentence, german, kind="error")
    for net in (
        ["path-velocity", "motion.current-vel", "=>", "interlock.path-speed"],
        ["abort", "interlock.abort", "=>", "halui.abort"],
        ["hold-defeated", "interlock.hold-defeated", "=>", "linuxcnc-link.hold-defeated"],
    ):
        if net not in part.nets:
            part.nets.append(net)
    sentence = "A move began while strokes end, and was aborted: M49, M51 P0 and M53 P0 disable the holds of LinuxCNC."
    german = "Eine Bewegung begann, während Hübe enden, und wurde abgebrochen: M49, M51 P0 und M53 P0 schalten das Anhalten von LinuxCNC ab."
    if sentence not in part.messages:
        part.messages += message("hold-defeated", sentence, german, kind="error")


def _arm(part, axes):
    """The lines for offsets of LinuxCNC's axes: a cycle arms them, and a probing move is refused."""
    abort = ["abort", "interlock.abort", "=>", "halui.abort"]
    part.nets += [] if abort in part.nets else [abort]
    part.nets += [
        ["cycle-running", "motion.digital-out-00", "=>", "interlock.cycle-running"],
        ["lacks-offset", "interlock.uncompensated", "=>", "linuxcnc-link.uncompensated"],
        ["probing-told", "interlock.probing-refused", "=>", "linuxcnc-link.probing-refused"],
    ]
    sentence = "Probing is aborted: its result would contain the offset of %s. Take it back, or use o<probe_work> call."
    german = "Das Antasten ist abgebrochen: sein Ergebnis enthielte den Versatz von %s. Erst zurücknehmen, oder mit o<probe_work> call antasten."
    part.messages += message("probing-refused", sentence % axes, german % axes, kind="error")
    sentence = "%s lacks its offset until the next cycle starts: touch off by o<touch_off> call."
    german = "%s fehlt sein Versatz, bis der nächste Zyklus beginnt: mit o<touch_off> call ankratzen."
    part.messages += message("uncompensated", sentence % axes, german % axes)

# SPDX-License-Identifier: GPL-2.0-or-later
"""interlock, which stands between the functions, their stages, plumb-retain and LinuxCNC. It is loaded once."""

from stages import Part, instance

RETAIN, LINK, TASK_AND_IO = 1, 2, 16 + 32  # the services of interlock, as sums
MOST_FUNCTIONS, MOST_STAGES = 16, 17  # rows of interlock


def problems(functions, stages):
    """A sentence for each row of interlock that is too short."""
    instances = [name for part in stages for names in part.modules.values() for name in names]
    rows = (("functions", MOST_FUNCTIONS, [function.name for function in functions]), ("stages", MOST_STAGES, instances))
    sentence = "interlock serves %d %s, and there are %d: %s. Wire fewer functions."
    return [sentence % (most, kind, len(names), ", ".join(names)) for kind, most, names in rows if len(names) > most]


def switch(number):
    """The pin by which the operator switches a function."""
    return "interlock.function-switch-%d" % number


def interlock(functions, stages, has_operation):
    """The interlock of these functions and of the Parts of their stages."""
    part = Part("interlock: permits the functions, arms the stages, holds LinuxCNC back", {"interlock": ["interlock"]})
    part.options["interlock"] = "functions=%d stages=%d" % (functions[-1].number + 1, len(stages))
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
        part.nets.append([function.interlock["permit"], "interlock.function-permit-%d" % number])
        part.nets.append([function.interlock["state"], "=>", "interlock.function-state-%d" % number])
    for number, stage in enumerate(stages):
        name = instance(stage)
        part.nets.append([name + "-permit", "interlock.stage-permit-%d" % number, "=>", name + ".permit"])
        part.nets.append([name + "-state", name + ".state", "=>", "interlock.stage-state-%d" % number])
    part.nets += [
        ["wait", "interlock.feed-inhibit", "=>", "motion.feed-inhibit", "motion.feed-hold"],
        ["no-homing", "interlock.homing-inhibit", "=>", "motion.homing-inhibit"],
        ["stages-ramping", "interlock.ramping"],
        ["spindle-speed-cmd", "spindle.0.speed-out", "=>", "interlock.spindle-speed"],
    ]
    for function in functions:
        if function.stroke:
            _stroke(part)
    if any("axis_offset" in stage.modules for stage in stages):
        _arm(part)
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


def _stroke(part):
    for net in (["path-velocity", "motion.current-vel", "=>", "interlock.path-speed"], ["abort", "interlock.abort", "=>", "halui.abort"]):
        if net not in part.nets:
            part.nets.append(net)


def _arm(part):
    """The lines for offsets of LinuxCNC's axes: a cycle arms them, and a probing move is refused."""
    abort = ["abort", "interlock.abort", "=>", "halui.abort"]
    part.nets += [] if abort in part.nets else [abort]
    part.nets.append(["cycle-running", "motion.digital-out-00", "=>", "interlock.cycle-running"])

# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts that functions of a machine share: stages, plumb-retain, growth_log, linuxcnc_link, linuxcnc_alive, a gate."""

import dataclasses


@dataclasses.dataclass
class Part:
    """Lines of a HAL file, and the functions that it adds to the servo thread."""

    title: str
    modules: dict = dataclasses.field(default_factory=dict)  # instances of each
    options: dict = dataclasses.field(default_factory=dict)  # of the load line of each
    programs: dict = dataclasses.field(default_factory=dict)  # the words of loadusr for each component
    setp: list = dataclasses.field(default_factory=list)
    nets: list = dataclasses.field(default_factory=list)  # words of net
    before: list = dataclasses.field(default_factory=list)  # motion-controller
    after: list = dataclasses.field(default_factory=list)  # the functions
    last: list = dataclasses.field(default_factory=list)
    is_late: bool = False  # loaded after the functions


def joint_stage(prefix, joint, sources, machine):
    """joint_offset between motion and the drive of one joint. `prefix` is x, or y2 for the second motor of Y."""
    limits = machine.limits(joint)
    stage = prefix + "-stage"
    part = Part("%s: between joint %d and its drive" % (stage, joint), {"joint_offset": [stage]})
    part.setp = [(stage + ".min-limit", limits[0]), (stage + ".max-limit", limits[1])]
    part.setp.append((stage + ".joint-acceleration", machine.named(joint, "MAX_ACCELERATION", 1)))
    part.setp.append((stage + ".offset-acceleration", "%g" % machine.reserve(joint, "ACCELERATION")))
    part.setp.append((stage + ".max-rate", "%g" % min(machine.unit, machine.reserve(joint, "VELOCITY"))))
    part.nets = [
        [prefix + "-position", "joint.%d.pos-cmd" % joint, "=>", stage + ".position"],
        [prefix + "-homed", "joint.%d.homed" % joint, "=>", stage + ".homed"],
        ["motion-enabled", "motion.motion-enabled", "=>", stage + ".motion-enabled"],
        *([source, "=>", "%s.offset-%d" % (stage, index)] for index, source in enumerate(sources)),
        [prefix + "-joint-cmd", "joint.%d.motor-pos-cmd" % joint, "=>", stage + ".joint-command"],
        [prefix + "-velocity", "joint.%d.vel-cmd" % joint, "=>", stage + ".joint-velocity"],
        [prefix + "-motor-velocity", stage + ".drive-velocity"],
        [prefix + "-motor-cmd", stage + ".drive-command"],
        [prefix + "-motor-fb", "=>", stage + ".drive-feedback"],
        [prefix + "-joint-fb", stage + ".joint-feedback", "=>", "joint.%d.motor-pos-fb" % joint],
    ]
    part.before, part.after = [stage + ".update-feedback"], [stage + ".update"]
    return part


def let_strokes_through(part, prefix, joint, machine, strokes):
    """Makes the stage of a joint one that passes a stroke without a limit of its own; the function has the limits. Machine off
    makes these sources, by their numbers, part of the position."""
    stage = prefix + "-stage"
    wide = {
        "offset-acceleration": 10 * machine.number(joint, "MAX_ACCELERATION"),
        "max-offset": machine.travel(joint),
        "max-rate": 2 * machine.number(joint, "MAX_VELOCITY"),
    }
    part.setp = [pair for pair in part.setp if pair[0].partition(".")[2] not in wide]
    part.setp += [("%s.%s" % (stage, name), "%g" % value) for name, value in wide.items()]
    part.setp += [("%s.release-at-off-%d" % (stage, index), "1") for index in strokes]
    part.nets.append([prefix + "-measured", "joint.%d.pos-fb" % joint])
    part.nets.append([prefix + "-limited", stage + ".limited"])
    part.nets.append([prefix + "-released", stage + ".released"])


def seen(prefix, joint):
    """The nets of a function that watches whether the joint has its offset."""
    return [[prefix + "-applied-offset", prefix + "-stage.applied-offset"], [prefix + "-measured", "joint.%d.pos-fb" % joint]]


def axis_stage(letter, source, clear):
    """axis_offset, which brings an offset into an axis by LinuxCNC's external offsets."""
    stage, axis, own = letter + "-axis-stage", "axis." + letter, letter + "-axis"
    part = Part("%s: into the axis %s" % (stage, letter.upper()), {"axis_offset": [stage]})
    part.nets = [
        [source, "=>", stage + ".offset-0"],
        [clear, "=>", stage + ".clear"],
        ["motion-type", "motion.motion-type", "=>", stage + ".motion-type"],
        ["motion-enabled", "motion.motion-enabled", "=>", stage + ".motion-enabled"],
        ["all-homed", "motion.is-all-homed", "=>", stage + ".all-homed"],
        [letter + "-counts", stage + ".counts", "=>", axis + ".eoffset-counts"],
        [letter + "-counts-scale", stage + ".counts-scale", "=>", axis + ".eoffset-scale"],
        [letter + "-offset-enable", stage + ".offset-enable", "=>", axis + ".eoffset-enable"],
        [letter + "-offset-clear", stage + ".offset-clear", "=>", axis + ".eoffset-clear"],
        [letter + "-offset-request", axis + ".eoffset-request", "=>", stage + ".offset-request"],
        [letter + "-offset-in-force", axis + ".eoffset", "=>", stage + ".offset-in-force"],
        ["offset-limited", "motion.eoffset-limited", "=>", stage + ".offset-limited"],
        [letter + "-applied-offset", stage + ".applied-offset"],
        [letter + "-uncompensated", stage + ".uncompensated"],
    ]
    part.after = [stage + ".update"]
    return part


def retain(path):
    """plumb-retain, which wants an absolute path. It is service 0 of interlock for these functions, which keep records. It reports
    a fault if it finds no records, and so comes after them."""
    part = Part("plumb-retain, service 0 of interlock", is_late=True)
    part.programs = {"plumb-retain": "-W plumb-retain --file %s" % path}
    part.setp = [("interlock.service-timeout-0", "30")]
    part.nets = [
        ["retain-state", "plumb-retain.state", "=>", "interlock.service-state-0"],
        ["date", "plumb-retain.date"],
    ]
    return part


def growth_log(path):
    """growth_log, which writes the records of thermal_growth_test. It is service 6 of interlock. No function needs it; its loss is a message."""
    part = Part("growth_log, service 6 of interlock", is_late=True)
    part.programs = {"growth-log": "-W growth_log --file %s" % path}
    part.setp = [("interlock.service-timeout-6", "10")]
    part.nets = [
        ["log-state", "growth-log.state", "=>", "interlock.service-state-6"],
        ["test-resumable", "growth-log.resumable"],
    ]
    return part


def panel_settings(path):
    """plumb-retain for the settings that plumb panel changes, and for the switches of the functions."""
    part = Part("Settings of plumb panel", is_late=True)
    part.programs = {"panel-settings": "-Wn panel-settings plumb-retain panel-settings --file %s" % path}
    return part


def link():
    """linuxcnc_link, loaded once: it finds all that has messages. It is service 1 of interlock."""
    part = Part("Messages to the operator, service 1 of interlock")
    part.programs = {"linuxcnc-link": "-Wn linuxcnc-link linuxcnc_link"}
    part.setp = [("interlock.service-timeout-1", "10")]
    part.nets = [
        ["link-state", "linuxcnc-link.state", "=>", "interlock.service-state-1"],
    ]
    return part


def commissioning(functions, stages, limit):
    """interlock holds each function and each stage until it has passed plumb commission. A trial moves a stage by at most
    `limit`. The stages are the Parts, in the order of their numbers at interlock."""
    part = Part("Nothing acts before it has passed plumb commission")
    part.setp = [("interlock.commissioning", "true"), ("interlock.trial-limit", "%g" % limit)]
    part.nets = [["trial", "interlock.trial", "=>", *(instance(stage) + ".trial" for stage in stages)]]
    return part


def commissioned(path):
    """plumb-retain for the identities with which functions and stages have passed. It asks where they are another computer's, or old."""
    part = Part("What has passed plumb commission", is_late=True)
    part.programs = {"commissioned": "-Wn commissioned plumb-retain commissioned --file %s" % path}
    return part


def passed(functions, stages):
    """The pins of interlock with those identities."""
    pins = ["interlock.function-passed-%d" % function.number for function in functions]
    return pins + ["interlock.stage-passed-%d" % number for number in range(len(stages))]


def instance(stage):
    """The name of a stage."""
    return next(names[0] for names in stage.modules.values())


def alive():
    """linuxcnc_alive, by which LinuxCNC's task and io are the services 4 and 5 of interlock."""
    part = Part("LinuxCNC's task and io, services 4 and 5 of interlock")
    part.programs = {"linuxcnc-alive": "-W linuxcnc_alive"}
    part.setp = [("interlock.service-timeout-%d" % service, "2.5") for service in (4, 5)]
    part.setp.append(("interlock.feed-services", "48"))
    part.nets = [
        ["task-state", "linuxcnc-alive.task-state", "=>", "interlock.service-state-4"],
        ["io-state", "linuxcnc-alive.io-state", "=>", "interlock.service-state-5"],
        ["program-running", "linuxcnc-alive.program-running", "=>", "interlock.program-running"],
        ["part-program-running", "linuxcnc-alive.part-program-running"],
    ]
    return part


def emergency_stop():
    """The chain that LinuxCNC's io reads, to motion, too."""
    part = Part("The emergency stop chain reaches motion, too, when LinuxCNC's io is dead")
    part.nets = [["emergency-stop-ok", "=>", "iocontrol.0.emc-enable-in", "motion.enable"]]
    return part


def identity():
    part = Part("The identity of program and tools, and the work offset of Z")
    part.nets = [
        ["program-id", "linuxcnc-link.program-id"],
        ["tool-set-id", "linuxcnc-link.tool-set-id"],
        ["identified", "linuxcnc-link.identified"],
        ["work-offset", "linuxcnc-link.work-offset"],
    ]
    return part


def either(ours, theirs, pin):
    """A gate that brings two signals to one pin."""
    name = pin.split(".")[1] + "-of-all"
    part = Part("Your signal, or ours, to " + pin, {"lut5": [name]})
    part.setp = [(name + ".function", "0xE")]  # in-0 or in-1
    part.nets = [[ours, "=>", name + ".in-0"], [theirs, "=>", name + ".in-1"], [name, name + ".out", "=>", pin]]
    part.last = [name]
    return part

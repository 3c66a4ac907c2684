# SPDX-License-Identifier: GPL-2.0-or-later
"""The HAL that all functions of a machine share: stages, retain, linuxcnc_link, and gates between them."""

import dataclasses


@dataclasses.dataclass
class Part:
    """Lines of a HAL file. `modules` are instances by module; `before` and `after` are functions of the servo thread."""

    title: str
    modules: dict = dataclasses.field(default_factory=dict)
    setp: list = dataclasses.field(default_factory=list)
    loadusr: list = dataclasses.field(default_factory=list)
    nets: list = dataclasses.field(default_factory=list)  # words of net
    before: list = dataclasses.field(default_factory=list)  # motion-controller
    after: list = dataclasses.field(default_factory=list)
    last: list = dataclasses.field(default_factory=list)
    messages: str = ""


GATE_INPUTS = 5


def any_of(name, signals, output):
    """An `or` of any number of signals, by lut5."""
    part, level = Part("Either of " + ", ".join(signals)), 0
    while True:
        groups = [signals[first : first + GATE_INPUTS] for first in range(0, len(signals), GATE_INPUTS)]
        results = []
        for number, group in enumerate(groups):
            gate = name if len(groups) == 1 else "%s-%d-%d" % (name, level, number)
            result = output if len(groups) == 1 else gate
            part.modules.setdefault("lut5", []).append(gate)
            part.setp.append((gate + ".function", "0xFFFFFFFE"))
            part.nets += [[signal, "=>", "%s.in-%d" % (gate, index)] for index, signal in enumerate(group)]
            part.nets.append([result, gate + ".out"])
            part.last.append(gate)
            results.append(result)
        if len(groups) == 1:
            return part
        signals, level = results, level + 1


def joint_stage(prefix, joint, sources, limits, acceleration):
    """joint_offset between motion and the drive of one joint. `prefix` is x, or y2 for the second motor of Y."""
    stage = prefix + "-stage"
    part = Part("%s: between joint %d and its drive" % (stage, joint), {"joint_offset": [stage]})
    part.setp = [(stage + ".min-limit", limits[0]), (stage + ".max-limit", limits[1])]
    part.setp.append((stage + ".joint-acceleration", "%g" % acceleration))
    part.setp.append((stage + ".offset-acceleration", "%g" % (acceleration / 4)))
    part.nets = [
        [prefix + "-position", "joint.%d.pos-cmd" % joint, "=>", stage + ".position"],
        [prefix + "-homed", "joint.%d.homed" % joint, "=>", stage + ".homed"],
        ["motion-enabled", "motion.motion-enabled", "=>", stage + ".motion-enabled"],
        *([source, "=>", "%s.offset-%d" % (stage, index)] for index, source in enumerate(sources)),
        [prefix + "-joint-cmd", "joint.%d.motor-pos-cmd" % joint, "=>", stage + ".joint-command"],
        [prefix + "-motor-cmd", stage + ".drive-command"],
        [prefix + "-motor-fb", "=>", stage + ".drive-feedback"],
        [prefix + "-joint-fb", stage + ".joint-feedback", "=>", "joint.%d.motor-pos-fb" % joint],
        [prefix + "-ramping", stage + ".ramping"],
        [prefix + "-corrected", stage + ".inhibit-homing"],
        [prefix + "-fault", stage + ".fault", "=>", "linuxcnc-link.%s-fault" % prefix],
        [prefix + "-code", stage + ".fault-code", "=>", "linuxcnc-link.%s-fault-code" % prefix],
        [prefix + "-limited", stage + ".limited", "=>", "linuxcnc-link.%s-limited" % prefix],
    ]
    part.before, part.after = [stage + ".update-feedback"], [stage + ".update"]
    part.messages = _message(prefix + "-fault", "Correction of %s: {code}" % prefix.upper(), "joint_offset fault-code")
    sentence = "%s does not have all of its correction: near its soft limit, or by max-offset or max-rate of its stage."
    part.messages += _message(prefix + "-limited", sentence % prefix.upper())
    return part


def axis_stage(letter, source, arm, clear, delays):
    """axis_offset, which brings an offset into an axis by LinuxCNC's external offsets. `delays`: by timedelay."""
    stage, axis = letter + "-axis-stage", "axis." + letter
    part = Part("%s: into the axis %s" % (stage, letter.upper()), {"axis_offset": [stage]})
    part.setp = [
        (letter + "-lacks-long.on-delay", "2"),
        (letter + "-probing-long.on-delay", "0"),
        (letter + "-probing-long.off-delay", "5"),
    ]
    part.nets = [
        [source, "=>", stage + ".offset-0"],
        [arm, "=>", stage + ".arm"],
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
        [letter + "-uncompensated", stage + ".uncompensated", "=>", letter + "-lacks-long.in"],
        [letter + "-probing", stage + ".probing-refused", "=>", "motion.feed-inhibit", "halui.abort"],
        [letter + "-probing", "=>", letter + "-probing-long.in"],
        [letter + "-lacks", letter + "-lacks-long.out", "=>", "linuxcnc-link.%s-lacks-offset" % letter],
        [letter + "-probing-told", letter + "-probing-long.out", "=>", "linuxcnc-link.%s-probing-refused" % letter],
        [letter + "-axis-fault", stage + ".fault", "=>", "linuxcnc-link.%s-axis-fault" % letter],
        [letter + "-axis-code", stage + ".fault-code", "=>", "linuxcnc-link.%s-axis-fault-code" % letter],
    ]
    part.after = [stage + ".update"]
    if delays:
        part.modules["timedelay"] = part.last = [letter + "-lacks-long", letter + "-probing-long"]
    else:
        part.setp = []
        direct = [net for net in part.nets if "-long.out" not in net[1]]
        part.nets = [[word for word in net if not word.endswith("-long.in")] for net in direct]
        part.nets.append([letter + "-uncompensated", "=>", "linuxcnc-link.%s-lacks-offset" % letter])
        part.nets.append([letter + "-probing", "=>", "linuxcnc-link.%s-probing-refused" % letter])
    axis_name = letter.upper()
    part.messages = _message(letter + "-axis-fault", "Offset of %s: {code}" % axis_name, "axis_offset fault-code")
    sentence = "Probing is aborted: its result would contain the offset of %s. Take it back, or use o<probe_work> call."
    part.messages += _message(letter + "-probing-refused", sentence % axis_name, kind="error")
    sentence = "%s lacks its offset until the next cycle starts: touch off by o<touch_off> call."
    part.messages += _message(letter + "-lacks-offset", sentence % axis_name)
    return part


def operation():
    """The number of the operation, from M68 E0."""
    part = Part("The number of the operation, from M68 E0", {"conv_float_s32": ["operation"]})
    part.nets = [["operation-key", "motion.analog-out-00", "=>", "operation.in"], ["operation", "operation.out"]]
    part.after = ["operation"]
    return part


def retain(folder):
    """retain, which wants an absolute path, and `kept`: the values are restored, and it still runs."""
    part = Part(
        "What a restart must not lose; kept is true while it is restored and retain runs",
        {"lut5": ["kept", "not-restored", "retain-troubled", "retain-lost"], "watchdog": ["watchdog"]},
    )
    part.loadusr = ["loadusr -W retain --file %s/retain.toml" % folder]
    part.setp = [
        ("watchdog.timeout-0", "30"),
        ("watchdog.enable-in", "1"),
        ("kept.function", "0x8"),  # in-0 and in-1
        ("not-restored.function", "0x2"),  # in-0 and not in-1
        ("retain-troubled.function", "0x8"),
        ("retain-lost.function", "0x1"),  # not in-0
    ]
    part.nets = [
        ["restored", "retain.restored", "=>", "kept.in-0", "not-restored.in-1", "retain-troubled.in-1"],
        ["retain-heartbeat", "retain.heartbeat", "=>", "watchdog.input-0"],
        ["retain-lives", "watchdog.ok-out", "=>", "kept.in-1", "retain-lost.in-0"],
        ["kept", "kept.out"],
        ["date", "retain.date"],
        ["retain-fault", "retain.fault", "=>", "not-restored.in-0", "retain-troubled.in-0"],
        ["retain-code", "retain.fault-code", "=>", "linuxcnc-link.not-restored-code"],
        ["retain-code", "=>", "linuxcnc-link.retain-fault-code"],
        ["not-restored", "not-restored.out", "=>", "linuxcnc-link.not-restored"],
        ["retain-troubled", "retain-troubled.out", "=>", "linuxcnc-link.retain-fault"],
        ["retain-lost", "retain-lost.out", "=>", "linuxcnc-link.retain-lost"],
    ]
    part.after = ["watchdog.set-timeouts", "watchdog.process", "kept"]
    part.last = ["not-restored", "retain-troubled", "retain-lost"]
    codes = "retain fault-code"
    part.messages = _message("not-restored", "Nothing is compensated: {code} The terminal has more.", codes)
    part.messages += _message("retain-fault", "Compensation continues. {code} The terminal has more.", codes)
    sentence = "Nothing is compensated: retain has ended. Start LinuxCNC again."
    part.messages += _message("retain-lost", sentence, kind="error")
    return part


def link(folder):
    """linuxcnc_link, loaded once for the messages of all."""
    part = Part("Messages to the operator, and the identity of program and tools")
    part.loadusr = ["loadusr -Wn linuxcnc-link linuxcnc_link --messages %s/messages.toml" % folder]
    return part


def identity():
    part = Part("The identity of program and tools")
    part.nets = [
        ["program-id", "linuxcnc-link.program-id"],
        ["tool-set-id", "linuxcnc-link.tool-set-id"],
        ["identified", "linuxcnc-link.identified"],
    ]
    return part


def _message(pin, text, codes=None, kind=None):
    lines = ["[[message]]", 'pin  = "%s"' % pin]
    if codes or kind:
        lines.append('kind = "error"')
    lines.append('text = "%s"' % text)
    if codes:
        lines.append('codes = "%s"' % codes)
    return "\n" + "\n".join(lines) + "\n"

# SPDX-License-Identifier: GPL-2.0-or-later
"""Lines of a machine's HAL files that name pins of Plumb which there are no more, and what to write instead. LinuxCNC does not load
such a file, so nothing has to run."""

import collections
import json
import os
import re

import hal_text
import plumb

Finding = collections.namedtuple("Finding", "path line pin instead")
STAGE = "net NAME-state NAME.state => interlock.stage-state-{0}, once for all that the stage says"
FUNCTION = "net NAME-state NAME.state => interlock.function-state-{0}, once for all that the function says"
PROGRAM = "net NAME-state PROGRAM.state => interlock.service-state-{0}, once for all that the program says"
PERMIT = "net NAME-permit interlock.function-permit-{0} => NAME.permit, with NAME for the function"
BY_PERMIT = "net NAME-permit interlock.function-permit-N => {instance}.permit, with the N of the function; or load it with interlock=no"
CONSTANT = "nothing: it is constant now, %s"
# Of each module: the former pin, and what to write.
INSTEAD = {
    "interlock": (
        (r"stage-(?:in-force|ramping|uncompensated|probing-refused|fault|limited)-(\d+)", STAGE),
        (r"stage-(?:enable|trial)-(\d+)", "net trial interlock.trial => x-stage.trial, once for all stages; the permit enables them"),
        (r"function-(?:busy|settling|ramping)-(\d+)", FUNCTION),
        (r"service-(?:heartbeat|ready|fault)-(\d+)", PROGRAM),
        (r"service-(?:not-ready|troubled)-(\d+)", "nothing: the fault of the program says it"),
    ),
    "joint_offset": ((r"row", "nothing: a stage takes the row of its permit"), (r"enable|heartbeat", "nothing, with interlock; or load it with interlock=no")),
    "axis_offset": ((r"row", "nothing: a stage takes the row of its permit"), (r"enable|heartbeat|arm", "nothing, with interlock; or load it with interlock=no")),
    "squareness": (
        (r"ea0[xua]|eb0[yvb]|ec0[zwc]", "nothing: a tilt of an axis about itself is one of the axes that it carries: ea0y and ea0z for ea0x"),
        (r"ex0a|ey0b|ez0c", "nothing: along itself a rotary axis has no place"),
        (r"e[abc]0[xyzuvw]-in-use", "nothing: of a tilt of an axis about itself"),
    ),
    "chopping": ((r"pulse-time", CONSTANT % "0.02 s"),),
    "thermal_displacement": (
        (r"exclude-operation-[4-7]", "exclude-operation-0 to -3"),
        (r"baseline-time", CONSTANT % "0.5 s"),
        (r"feed-tolerance", CONSTANT % "0.02"),
        (r"feed-range", CONSTANT % "0.5"),
        (r"lost-time-tolerance", CONSTANT % "0.002 s"),
        (r"steady-time", CONSTANT % "0.2 s"),
        (r"fault-code", "{instance}.detail-code, the same number, while {instance}.fault is true"),
        (r"learning-failed-code", "{instance}.detail-code: 10 more"),
        (r"refusal-code", "{instance}.detail-code: 20 more"),
        (r"rejection-code", "{instance}.detail-code: 30 more"),
        (r"doubt-code", "{instance}.status-code: the CHANGELOG has its numbers"),
    ),
    "thermal_growth_test": ((r"sensors", "sensors=N into the line loadrt thermal_growth_test"), (r"range-share", CONSTANT % "0.15"),),
    "centre_height": ((r"(cut-(?:diameter|x|y)-)0(\d)", "{0}{1}; the option keyed_cuts gives the number of cuts"),
                      (r"x-known|known-x(?:-sigma)?", "nothing: make one more cut"), (r"stock-sigma", CONSTANT % "0.01 mm"),
                      (r"automatic", "nothing: the permit of interlock says it"), (r"interlock-status|enable", BY_PERMIT),
                      (r"(?:fault|hold|remedy)-code|hold", "{instance}.detail-code: a hold has 30 more, a remedy 40 more"),
                      (r"(?:state|verdict)-code", "{instance}.status-code: the CHANGELOG has its numbers")),
    None: ((r"interlock-status|enable", BY_PERMIT),),  # all others
}


def findings(ini, folder):
    """A Finding for each word of the HAL files of an INI file that names no pin of the module of its instance."""
    lines = [(path, number, command) for path in hal_text.halfiles(ini, folder) if path.endswith(".hal") for number, command in _commands(path)]
    modules = {}  # by instance: its module, and the options of its line by name
    for _path, _number, words in lines:
        if words[0] == "loadrt" and len(words) > 1 and _declared(words[1]):
            options = dict(word.split("=", 1) for word in words[2:] if "=" in word)
            for place, name in enumerate(options.pop("names", "").split(",")):
                given = {option: _value(ini, values.split(","), place) for option, values in options.items()}
                modules[name] = (words[1], given)
    found = []
    for path, number, words in lines:
        if words[0] not in ("net", "setp", "unlinkp", "linksp", "linkps", "linkpp", "sets"):
            continue
        for word in words[1:]:
            instance, _dot, short = word.rpartition(".")
            if instance in modules and not plumb.has_pin(_declared(modules[instance][0]), short, modules[instance][1]):
                found.append(Finding(path, number, word, _instead(modules[instance][0], instance, short)))
    return found


def rows(ini, written):
    """What to do: a sentence for each line, and "", or of each file in the folder `written` one sentence, and the command that writes it
    again. Its settings are the user's."""
    home = os.path.dirname(os.path.abspath(ini.path))
    result, lines = [], collections.Counter()
    for path, line, pin, instead in findings(ini, home):
        if os.path.dirname(path) == os.path.join(home, written) and not path.endswith("_settings.hal"):
            lines[path] += 1
        else:
            result.append(("%s:%d names %s, which this Plumb has no more. Write %s." % (os.path.relpath(path, home), line, pin, instead), ""))
    command = "plumb wire %s --ini %s --apply" % (" ".join(_functions(os.path.join(home, written))), os.path.basename(ini.path))
    return result + [("%s has lines of an earlier Plumb, %d of them: wire it again." % (os.path.relpath(path, home), number), command)
                     for path, number in lines.items()]


def _functions(folder):
    try:
        with open(os.path.join(folder, ".written.json"), encoding="utf-8") as file:
            return json.load(file)["functions"]
    except (OSError, ValueError, KeyError, TypeError):
        return ["FUNCTION"]


def _commands(path):
    with open(path, encoding="utf-8", errors="surrogateescape") as file:
        for number, line in enumerate(file, 1):
            words = line.split("#")[0].split()
            if words:
                yield number, words


def _value(ini, values, place):
    """The value of an option for the instance at this place; [SECTION]NAME is one of the INI file."""
    value = values[place if place < len(values) else 0]
    named = hal_text.VALUE.fullmatch(value)
    return (named and ini.get(named[1], named[2] or named[3])) or value


def _declared(module):
    try:
        return plumb.declarations(module)
    except (FileNotFoundError, ValueError):
        return None


def _instead(module, instance, short):
    for pattern, text in (*INSTEAD.get(module, ()), *INSTEAD[None]):
        match = re.fullmatch(pattern, short)
        if match:
            return text.format(*match.groups(), instance=instance)
    condition = _declared(module)["pins"].get(short, {}).get("only_with", "")
    if condition:
        *letters, last = re.findall(r"(\w) in ", condition) or [""]
        axes = ", ".join(letters) + " or " + last if letters else last
        option = "%s into the %s of" % (axes, condition.rpartition(" ")[2]) if last else condition.replace(">=", "=") + ", or more, into"
        return "%s the line loadrt %s, or remove this line" % (option, module)
    return "what man 9 %s says of its pins" % module

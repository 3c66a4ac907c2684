# SPDX-License-Identifier: GPL-2.0-or-later
"""The text of the files that put functions into a machine."""

import re

import hal_text
import plumb
from machine import INCH, MOTION

UNIT = "unit=[TRAJ]LINEAR_UNITS"
STAGES = ("joint_offset", "axis_offset")
LICENSE = "# SPDX-License-Identifier: GPL-2.0-or-later"
ORDER = LICENSE + """
# Written by plumb wire. The last HALFILE: it adds functions in front of motion-controller and behind it, in this order.

# The installed package gives plumb_order.tcl; without the package, the copy in a folder here does.
if {[catch {source $::env(HALLIB_DIR)/plumb_order.tcl}]} {source [file join [file dirname [info script]] plumb_order.tcl]}

plumb_order {
  BEFORE
} {
  BEHIND
}
"""


class HalFiles:
    """Files in which the signals have the names of this machine.

    parts       Parts of stages.hal
    modules     Modules of all parts and functions
    signals     Signals
    """

    def __init__(self, functions, machine, folder, parts, modules, signals):
        self.functions, self.machine, self.folder = functions, machine, folder
        self.parts, self.modules, self.signals = parts, modules, signals
        self.all_parts = parts.all + signals.gates
        self.all_names = " and ".join(function.name for function in functions)

    def _net(self, words, is_gate=False):
        """A line, without the pins that a gate joins to the user's signal; `is_gate` is for that gate itself."""
        signal, writer, readers = hal_text.pins_of_net(words)
        readers = [pin for pin in readers if is_gate or pin not in self.signals.unlinked]
        if not writer and not readers:
            return None
        arrow = " => " + " ".join(readers) if readers else ""
        return "net %s%s%s" % (self.signals.name(signal), " " + writer if writer else "", arrow)

    def stages(self):
        lines = [LICENSE, "# Written by plumb wire for %s: the HAL that these functions share." % self.all_names]
        if not self.parts.passed:
            lines.append("# This machine is simulated: its functions act without plumb commission.")
        lines.append("")
        for module, instances in self.modules.shared():
            options = self._value(UNIT) if module in STAGES else next((p.options[module] for p in self.parts.all if module in p.options), "")
            lines.append(("loadrt %s names=%s %s" % (module, ",".join(instances), options)).rstrip())
        early = [part for part in self.all_parts if not part.is_late]
        lines += ["", *self._programs(early)]
        taken = [*self.parts.freed, *self.signals.unlinked]
        if taken:
            lines += ["", "# Your signals of these pins go on: from the stages to the drives, and into the gates."]
            lines += ["unlinkp " + pin for pin in taken]
        return "\n".join(lines + self._bodies(early)) + "\n"

    def retain(self):
        """The programs that come after the functions; None if there are none."""
        late = [part for part in self.all_parts if part.is_late]
        lines = [LICENSE, "# Written by plumb wire: the programs that are loaded after the components whose records they keep.", ""]
        return "\n".join(lines + self._programs(late) + self._bodies(late)) + "\n" if late else None

    def _programs(self, parts):
        return ["loadusr " + words for part in parts for words in part.programs.values()]

    def _bodies(self, parts):
        lines = []
        for part in parts:
            body = ["setp %s %s" % pair for pair in part.setp]
            body += filter(None, (self._net(net, part in self.signals.gates) for net in part.nets))
            if body:
                lines += ["", "# %s." % part.title, *body]
        return lines

    def function(self, function):
        lines = [LICENSE, "# Written by plumb wire: %s with the signals of this machine." % function.name]
        for command in function.commands(self.machine.axes):
            if command.name == "addf":
                continue
            if command.name == "net":
                line = self._net(command.words)
            else:
                fastest = self.machine.fastest(function.stroked_by)
                line = " ".join([command.name, *filter(None, (self._value(word, fastest) for word in command.words))])
            comment = [text for text in command.comment if "SPDX" not in text]
            if lines[-1].startswith("# Written"):
                comment = [""]  # the sentence on top is about the file of the function
            lines += comment + ([line] if line else [])
        for letter, instance in function.stroke.items():
            joint = self.machine.joints[letter][0]
            lines += ["", "# The limits of the joint, and the distance from them that its stage needs."]
            limits = zip(("min-limit", "max-limit"), self.machine.limits(joint))
            lines += ["setp %s.%s %s" % (instance, *pair) for pair in limits]
            lines.append("setp %s.max-offset %g" % (instance, self.machine.travel(joint)))
            lines.append("setp %s.max-rate %s" % (instance, self.machine.named(joint, "MAX_VELOCITY", 1)))
            lines.append("setp %s.taper 3" % instance)
        if function.other_axis:
            lines += ["", "# The limits of the joint of %s." % function.other_axis]
            limits = zip(("min-limit", "max-limit"), self.machine.limits(self.machine.joints[function.other_axis][0]))
            lines += ["setp %s%s %s" % (function.named_axis["limits"], *pair) for pair in limits]
        for letter in set(function.without) - set(self.machine.axes):
            lines += ["", "# This machine has no %s." % letter, *("setp %s 1" % pin for pin in function.without[letter])]
        return "\n".join(lines) + "\n"

    def _value(self, word, fastest=0):
        """A word of a function's HAL for this machine. [TRAJ]MAX_LINEAR_VELOCITY becomes a number where it is not given or
        an axis is faster, and the unit is left out where it is not given."""
        ini = self.machine.ini
        if word == UNIT:
            return word if ini.get("TRAJ", "LINEAR_UNITS") else ""
        if word != "[TRAJ]MAX_LINEAR_VELOCITY":
            return word
        return word if ini.number("TRAJ", "MAX_LINEAR_VELOCITY", -1) >= fastest else "%g" % fastest

    def settings(self, function):
        """The settings of a function: its lengths are inches on an inch machine, and a stroke is no faster than the joint."""
        text = function.text(function.name + "_settings.hal")
        own = self._stroke_limits(function)
        modules = {instance: module for module, instances in function.modules.items() for instance in instances}
        lines = []
        for line in text.splitlines():
            words = line.split()
            if len(words) >= 3 and words[0] == "setp":
                instance, pin = words[1].split(".", 1)
                is_length = plumb.declarations(modules[instance])["pins"][pin]["unit"].startswith("mu")
                line = self._setp(line, words, self.machine.inch and is_length, own.get(words[1]))
            lines.append(line)
        return "\n".join(lines) + "\n"

    @staticmethod
    def _setp(line, words, is_inch, largest):
        """A setp line with its value in inches, and at most the largest one."""
        if not is_inch and largest is None:
            return line
        given = float(words[2])
        value = given / INCH if is_inch else given
        value = value if largest is None else min(value, largest)
        return line if value == given else re.sub(r"^(\s*setp\s+\S+\s+)\S+", r"\g<1>%.6g" % value, line)

    def _stroke_limits(self, function):
        """The largest speed and acceleration of a stroke, by pin: motion keeps a fifth of the speed of the joint, and half of
        its acceleration."""
        limits = {}
        for letter, instance in function.stroke.items():
            joints = self.machine.joints[letter]
            for pin, name, part in (("max-feed", "MAX_VELOCITY", 0.8), ("max-acceleration", "MAX_ACCELERATION", 0.5)):
                limits["%s.%s" % (instance, pin)] = part * min(self.machine.number(joint, name) for joint in joints)
        return limits

    @property
    def before(self):
        """The functions in front of motion-controller."""
        return [name for part in self.all_parts for name in part.before]

    @property
    def behind(self):
        """The functions behind motion-controller, in the order of the data: others read the place of a stroking axis."""
        names = [name for function in sorted(self.functions, key=lambda its: not its.stroke) for name in function.updates]
        names += [name for part in self.all_parts for name in part.after]
        return names + [name for part in self.all_parts for name in part.last]

    @property
    def sequence(self):
        """The functions that stand together in the thread."""
        return [*self.before, MOTION, *self.behind]

    def order(self):
        """The last HALFILE: it adds the functions around motion-controller, wherever the machine's files have that by now."""
        lists = {"BEFORE": self.before, "BEHIND": self.behind}
        text = ORDER
        for name, functions in lists.items():
            text = text.replace("  " + name, "\n".join("  " + function for function in functions))
        return text

    def plumb(self, texts):
        """The first HALFILE. With TWOPASS, which reads no file within a file, it has all lines itself."""
        machine = self.machine
        lines = [LICENSE, "# Written by plumb wire. The first HALFILE of %s; order.tcl is the second one." % self.all_names, ""]
        for name, text in texts.items():
            if machine.twopass and not name.endswith("_settings.hal"):
                lines += ["", text.rstrip()]
            else:
                lines.append("source %s/%s" % (self.folder, name))
        return "\n".join(lines) + "\n"


# SPDX-License-Identifier: GPL-2.0-or-later
"""The text of the files that put functions into a machine."""

import hal_text
import plumb
from machine import INCH, MOTION

UNIT = "unit=[TRAJ]LINEAR_UNITS"
STAGES = ("joint_offset", "axis_offset")
LICENSE = "# SPDX-License-Identifier: GPL-2.0-or-later"


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
        self.thread_order = []  # names of functions, once the addf lines are written
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
        lines = [LICENSE, "# Written by plumb wire for %s: the HAL that these functions share." % self.all_names, ""]
        for module, instances in self.modules.shared():
            unit = self._value(UNIT) if module in STAGES else ""
            lines.append(("loadrt %s names=%s %s" % (module, ",".join(instances), unit)).rstrip())
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
        lines = [LICENSE, "# Written by plumb wire: retain, loaded after the components whose records it keeps.", ""]
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
                line = " ".join([command.name, *filter(None, map(self._value, command.words))])
            comment = [text for text in command.comment if "SPDX" not in text]
            if lines[-1].startswith("# Written"):
                comment = [""]  # the sentence on top is about the file of the function
            lines += comment + ([line] if line else [])
        for letter, instance in function.stroke.items():
            limits = self.machine.limits(self.machine.joints[letter][0])
            lines += ["", "# The limits of the joint, and the distance from them that its stage needs."]
            lines += ["setp %s.%s %s" % (instance, *pair) for pair in zip(("min-limit", "max-limit"), limits)]
            lines.append("setp %s.taper 3" % instance)
        return "\n".join(lines) + "\n"

    def _value(self, word):
        """A word of a function's HAL for this machine. [TRAJ]MAX_LINEAR_VELOCITY becomes a number where it is not given or
        a joint is faster, and the unit is left out where it is not given."""
        ini = self.machine.ini
        if word == UNIT:
            return word if ini.get("TRAJ", "LINEAR_UNITS") else ""
        if word != "[TRAJ]MAX_LINEAR_VELOCITY":
            return word
        given, fastest = ini.get("TRAJ", "MAX_LINEAR_VELOCITY"), self.machine.fastest()
        return word if given and float(given) >= fastest else "%g" % fastest

    def settings(self, function):
        """The settings of a function, whose lengths become inches on an inch machine."""
        text = function.text(function.name + "_settings.hal")
        if not self.machine.inch:
            return text
        modules = {instance: module for module, instances in function.modules.items() for instance in instances}
        lines = []
        for line in text.splitlines():
            words = line.split()
            if len(words) >= 3 and words[0] == "setp":
                instance, pin = words[1].split(".", 1)
                if plumb.declarations(modules[instance])["pins"][pin]["unit"].startswith("mu"):
                    line = line.replace(words[2], "%.6g" % (float(words[2]) / INCH), 1)
            lines.append(line)
        return "\n".join(lines) + "\n"

    def _order(self):
        """The addf lines, each with its place: around motion-controller, in the order of the data."""
        present = list(self.machine.halfiles.threads[self.machine.thread])
        lines = []

        def add(names, place):
            for name in names:
                lines.append("addf %s %s %d" % (name, self.machine.thread, place + 1))
                present.insert(place, name)
                place += 1

        add([name for part in self.all_parts for name in part.before], present.index(MOTION))
        behind = [name for function in self.functions for name in function.updates]
        behind += [name for part in self.all_parts for name in part.after]
        add(behind + [name for part in self.all_parts for name in part.last], present.index(MOTION) + 1)
        self.thread_order = present
        return lines

    def plumb(self, texts):
        """The one HALFILE. With TWOPASS, which reads no file within a file, it has all lines itself."""
        machine = self.machine
        lines = [LICENSE, "# Written by plumb wire. The one HALFILE of %s." % self.all_names, ""]
        for name, text in texts.items():
            if machine.twopass and not name.endswith("_settings.hal"):
                lines += ["", text.rstrip()]
            else:
                lines.append("source %s/%s" % (self.folder, name))
        place = machine.halfiles.threads[machine.thread].index(MOTION) + 1
        sentence = "# Around motion-controller, which is the function %d of %s in your HAL files."
        return "\n".join([*lines, "", sentence % (place, machine.thread), *self._order()]) + "\n"

    def messages(self):
        text = LICENSE + "\n# Written by plumb wire: the messages of linuxcnc_link to the operator.\n"
        for function in self.functions:
            own = function.text(function.name + "_messages.toml")
            text += "\n" + own[own.index("[[message]]") :]
        return text + "".join(part.messages for part in self.parts.all)


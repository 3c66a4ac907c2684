# SPDX-License-Identifier: GPL-2.0-or-later
"""Joins the files of functions to the signals of a machine, and writes the HAL that results."""

import fnmatch

import hal_text
import plumb
import stages

# Inputs of LinuxCNC that hold something back while true: a second source joins the first by `or`.
JOINED = ("motion.feed-inhibit", "motion.feed-hold", "motion.homing-inhibit", "halui.abort")
INCH = 25.4
UNIT = "unit=[TRAJ]LINEAR_UNITS"
STAGES = ("joint_offset", "axis_offset")
MOTION = "motion-controller"


class Machine:
    """The user's machine, as wiring needs it.

    halfiles    State after the HALFILEs, behind which ours comes
    complete    State with all that comes later: HALCMD lines, files of the screen
    joints      the numbers of the joints of each axis, by its letter
    ini         IniFile
    files       its HAL files, to name lines
    """

    def __init__(self, halfiles, complete, joints, ini, files):
        self.halfiles, self.complete, self.joints, self.ini, self.files = halfiles, complete, joints, ini, files
        self.twopass = bool(ini.get("HAL", "TWOPASS"))
        self.inch = is_inch(ini.get("TRAJ", "LINEAR_UNITS"))
        self.unit = 1 / INCH if self.inch else 1  # machine units in a millimetre
        self.axes = {
            letter: {"joints": numbers, "limits": self._travel(letter, numbers)} for letter, numbers in joints.items()
        }
        self.thread = halfiles.thread_with(MOTION)

    def at(self, *names):
        """' (FILE:LINE)' of the first of these names that the HAL files have."""
        for name in names:
            found = name and hal_text.where(name, self.files)
            if found:
                return " (%s)" % found
        return ""

    def _travel(self, letter, joints):
        """Of an axis, by its own limits or by those of its joint."""
        given = [
            self.ini.get("AXIS_" + letter, name) or self.ini.get("JOINT_%d" % joints[0], name)
            for name in ("MIN_LIMIT", "MAX_LIMIT")
        ]
        return [float(given[0] or -100), float(given[1] or 100)]

    def limits(self, joint):
        """Of a joint, as text for setp; the file names the INI values where they are given."""
        section = "JOINT_%d" % joint
        return [
            "[%s]%s" % (section, name) if self.ini.get(section, name) else value
            for name, value in (("MIN_LIMIT", "-1e6"), ("MAX_LIMIT", "1e6"))
        ]

    def acceleration(self, joint):
        return float(self.ini.get("JOINT_%d" % joint, "MAX_ACCELERATION") or 1)


def is_inch(units):
    """Of [TRAJ]LINEAR_UNITS, which is a word, or the number of units in a millimetre."""
    units = (units or "mm").strip().lower()
    try:
        return abs(float(units) - 1 / INCH) < 1e-4
    except ValueError:
        return units in ("in", "inch", "imperial")


class Wiring:
    """The functions joined to the machine. `problems` has the conflicts, a sentence each."""

    def __init__(self, functions, machine, folder):
        self.functions, self.machine, self.folder = functions, machine, folder
        self.problems, self.notes = [], []
        self.freed = {}  # pins of joints that stages take over, and their signals
        self.names = {}  # the machine's signals by ours
        self.unlinked = []
        self.gates, self.lacking, self.joined_pins, self.motmod = [], [], set(), {}
        self.parts = self._parts()
        if not self.problems:
            self._check_instances()
            self._join()
            self._count_outputs()

    # --- the parts to wire ---

    def axes_of(self, function):
        return [letter for letter in function.axes if self.machine.joints.get(letter)]

    def commands_of(self, function):
        """Of its file, without the lines of axes that the machine does not have."""
        absent = [letter.lower() for letter in function.axes if not self.machine.joints.get(letter)]
        return [
            command
            for command in function.commands()
            if not (command.name == "net" and any(command.words[0].startswith(letter + "-") for letter in absent))
        ]

    def _parts(self):
        """The parts of stages.hal."""
        here = "$::env(CONFIG_DIR)/" if self.machine.twopass else "$(CONFIG_DIR)/"  # TWOPASS makes Tcl of the file
        here += self.folder
        parts = [stages.link(here)]
        if any(function.records for function in self.functions):
            parts += [stages.retain(here), stages.identity()]
        for service in sorted({name for function in self.functions for name in function.services}):
            parts.append(getattr(stages, service)())
        ramping, corrected = [], []
        for letter in "XYZABCUVW":
            sources = [function.joint_offset[letter] for function in self.functions if letter in function.joint_offset]
            for number, joint in enumerate(self.machine.joints.get(letter, [])):
                prefix = letter.lower() + ("" if number == 0 else str(number + 1))
                if sources and self._free(prefix, joint):
                    limits, acceleration = self.machine.limits(joint), self.machine.acceleration(joint)
                    parts.append(stages.joint_stage(prefix, joint, sources, limits, acceleration))
                    ramping.append(prefix + "-ramping")
                    corrected.append(prefix + "-corrected")
            arguments = [function.axis_offset[letter] for function in self.functions if letter in function.axis_offset]
            if len(arguments) > 1:
                names = [function.name for function in self.functions if letter in function.axis_offset]
                self.problems.append("%s and %s both offset the axis %s." % (*names[:2], letter))
            elif arguments and self.machine.joints.get(letter):
                delays = self._may_load("timedelay", letter.lower() + "-lacks-long")
                parts.append(stages.axis_stage(letter.lower(), *arguments[0], delays))
        if ramping:
            parts.append(stages.any_of("stages-ramping", ramping, "stages-ramping"))
            gate = stages.any_of("no-homing", corrected, "no-homing")
            gate.nets.append(["no-homing", "=>", "motion.homing-inhibit"])
            parts.append(gate)
        parts.append(self._bindings(parts))
        return parts

    def _may_load(self, module, instance):
        """Whether a stock module is free, or has the instance already."""
        state = self.machine.halfiles
        return module not in state.components or self.machine.twopass or state.owner_of_prefix(instance) == module

    def _free(self, prefix, joint):
        """Takes the two pins of a joint from their signals, which become those of the drive."""
        for pin, name in (("motor-pos-cmd", "-motor-cmd"), ("motor-pos-fb", "-motor-fb")):
            whole = "joint.%d.%s" % (joint, pin)
            signal, later = self.machine.halfiles.signal_of(whole), self.machine.complete.signal_of(whole)
            if later and signal != later:
                self.problems.append(
                    "%s is netted to the signal %s by a HALCMD line or a file of the screen%s. The stage %s-stage must come "
                    "behind that: move the line into a HALFILE." % (whole, later, self.machine.at(whole), prefix)
                )
            elif signal is None:
                self.problems.append(
                    "%s has no signal: your HAL files must net it to the drive before %s-stage can stand between."
                    % (whole, prefix)
                )
            else:
                self.freed[whole] = signal
                self.names[prefix + name] = signal
        return not self.problems

    def _bindings(self, parts):
        """The signals of joints that functions use and no stage gives."""
        used = {name for function in self.functions for name in self._signals(function)}
        given = {net[0] for part in parts for net in part.nets}
        part = stages.Part("Of the joints")
        for letter, joints in self.machine.joints.items():
            for number, joint in enumerate(joints):
                prefix = letter.lower() + ("" if number == 0 else str(number + 1))
                pins = {"position": "pos-cmd", "velocity": "vel-cmd", "homed": "homed", "joint-fb": "motor-pos-fb"}
                for name, pin in pins.items():
                    signal = "%s-%s" % (prefix, name)
                    if signal in used and signal not in given:
                        arrow = ["=>"] if pin == "motor-pos-fb" else []
                        part.nets.append([signal, *arrow, "joint.%d.%s" % (joint, pin)])
        return part

    def _signals(self, function):
        return [command.words[0] for command in self.commands_of(function) if command.name == "net"]

    # --- names in use ---

    def _modules(self):
        """Module, instances, and for whom, of all that is loaded."""
        found = {}
        for part in self.parts + self.gates:
            for module, instances in part.modules.items():
                found.setdefault(module, []).extend(instances)
        for function in self.functions:
            for command in function.commands():
                if command.name == "loadrt":
                    names = next(word[6:] for word in command.words if word.startswith("names="))
                    found.setdefault(command.words[0], []).extend(names.split(","))
        return found

    def _check_instances(self):
        state = self.machine.complete
        for module, instances in self._modules().items():
            for instance in instances:
                owner = state.owner_of_prefix(instance)
                if owner and owner != module:
                    self.problems.append(
                        "The name %s is in use: by %s in your configuration%s, and by %s here. Rename yours."
                        % (instance, owner, self.machine.at(instance), module)
                    )
        for program in ("linuxcnc-link", "retain"):
            if state.owner_of_prefix(program):
                where = self.machine.at(program)
                self.problems.append("Your configuration loads %s itself%s. Leave that out." % (program, where))

    def is_loaded(self, module):
        """Whether the user loads it, with all instances that are wanted; else the problem is noted."""
        state, instances = self.machine.halfiles, self._modules()[module]
        if module not in state.components or self.machine.twopass:
            return False
        lacking = [instance for instance in instances if state.owner_of_prefix(instance) != module]
        if lacking:
            yours = ", ".join(state.instances(module)) or "without names"
            self.problems.append(
                "%s is loaded by your configuration%s as %s. A module is loaded once: add %s to the names in your line, "
                "or use TWOPASS." % (module, self.machine.at(module), yours, ",".join(lacking))
            )
        return True

    # --- signals ---

    def _nets(self):
        """For whom, and the words, of all nets."""
        for part in self.parts:
            for net in part.nets:
                yield "the stages", net
        for function in self.functions:
            for command in self.commands_of(function):
                if command.name == "net":
                    yield function.name, command.words

    def _join(self):
        state, writers, joined, wanted = self.machine.complete, {}, {}, {}
        for who, words in self._nets():
            signal, writer, readers = hal_text.pins_of_net(words)
            if writer:
                if writers.setdefault(signal, (writer, who))[0] != writer:
                    self.problems.append("%s and %s both write the signal %s." % (writer, writers[signal][0], signal))
            for pin in ([writer] if writer else []) + readers:
                if pin in state.pins and pin not in self.freed:
                    if pin in JOINED and pin in readers:
                        joined.setdefault(pin, []).append((signal, who))
                    else:
                        wanted.setdefault(signal, []).append((pin, who))
                elif not (pin in self.freed or self._is_ours(pin)):
                    self._note_missing(pin, who)
        for signal, pins in wanted.items():
            for pin, who in pins:
                self._unify(signal, pin, who, writers.get(signal, (None, None))[0])
        external = {name for function in self.functions for name in function.external_signals}
        mine = {words[0] for _, words in self._nets()}
        for signal in sorted(mine):
            known = signal in state.signals or signal in self.machine.halfiles.signals
            if signal not in self.names and known and signal not in external:
                self.names[signal] = "plumb-" + signal
        for pin, sources in joined.items():
            self._join_pin(pin, [signal for signal, _ in sources])
        for module in self._modules():
            self.is_loaded(module)

    def _is_ours(self, pin):
        instances = [name for names in self._modules().values() for name in names] + ["linuxcnc-link", "retain"]
        return any(pin.startswith(instance + ".") for instance in instances)

    def _note_missing(self, pin, who):
        if pin.startswith(("motion.digital-", "motion.analog-")):
            self.lacking.append(pin)
        elif pin.startswith("halui."):
            self.problems.append("%s needs %s: write HALUI = halui into [HAL] of the INI file." % (who, pin))
        else:
            self.problems.append("%s needs the pin %s, which this LinuxCNC does not have." % (who, pin))

    def _unify(self, signal, pin, who, writer):
        """Takes the signal that the user has at a pin for ours, where that means the same."""
        state = self.machine.complete
        theirs = state.signal_of(pin)
        if theirs is None:
            return
        other = state.signals[theirs]
        alone = not [end for end in [other.writer, *other.readers] if end and end != pin]
        own = any(fnmatch.fnmatch(pin, pattern) for function in self.functions for pattern in function.own_pins)
        is_source = state.pins[pin].direction == "OUT"
        if own and not alone:
            others = ", ".join(end for end in [other.writer, *other.readers] if end and end != pin)
            self.problems.append(
                "%s is in use: your signal %s joins it to %s%s, and %s needs it for %s. Use another one for yours."
                % (pin, theirs, others, self.machine.at(pin, theirs), who, signal)
            )
        elif not is_source and writer and other.writer and other.writer != writer:
            self.problems.append(
                "%s is in use: your signal %s brings it %s%s, and %s needs it for %s from %s. Only one can have it."
                % (pin, theirs, other.writer, self.machine.at(pin, theirs), who, signal, writer)
            )
        elif self.names.setdefault(signal, theirs) != theirs:
            self.problems.append(
                "%s is in your signal %s%s, and %s needs it in %s, as %s is." % (
                    pin, theirs, self.machine.at(pin, theirs), who, self.names[signal], signal)
            )

    def _join_pin(self, pin, signals):
        """Sources of a pin that holds something back: ours, and the user's."""
        theirs = self.machine.complete.signal_of(pin)
        early = self.machine.halfiles.signal_of(pin)
        if theirs and not early:
            self.problems.append(
                "%s is netted to the signal %s by a HALCMD line or a file of the screen%s. It must take %s too: move the line "
                "into a HALFILE." % (pin, theirs, self.machine.at(pin, theirs), ", ".join(signals))
            )
            return
        if theirs:
            self.unlinked.append(pin)
            self.names["your-" + theirs] = theirs
            signals = signals + ["your-" + theirs]
            ours = ", ".join(signals[:-1])
            self.notes.append("%s keeps your signal %s; `or` joins it with %s." % (pin, theirs, ours))
        self.joined_pins.add(pin)
        if len(signals) == 1:
            gate = stages.Part("To " + pin)
            gate.nets.append([signals[0], "=>", pin])
        else:
            name = pin.split(".")[1] + "-of-all"
            gate = stages.any_of(name, signals, name)
            gate.nets.append([name, "=>", pin])
        self.gates.append(gate)

    def _count_outputs(self):
        """How many digital and analog outputs motmod must have, as options of its loadrt line; none if it has them."""
        counts = {}
        for pin in self.lacking:
            kind = "num_dio" if "digital" in pin else "num_aio"
            counts[kind] = max(counts.get(kind, 0), int(pin.rsplit("-", 1)[1]) + 1)
        self.motmod = counts

    # --- the files ---

    def name(self, signal):
        """The signal of this machine."""
        return self.names.get(signal, signal)

    def net(self, words, joins=False):
        """A line, without the pins whose sources are joined elsewhere; `joins` is the place where they are."""
        signal, writer, readers = hal_text.pins_of_net(words)
        readers = [pin for pin in readers if joins or pin not in self.joined_pins]
        if not writer and not readers:
            return None
        arrow = " => " + " ".join(readers) if readers else ""
        return "net %s%s%s" % (self.name(signal), " " + writer if writer else "", arrow)

    def stages_hal(self):
        lines = [
            "# SPDX-License-Identifier: GPL-2.0-or-later",
            "# Written by plumb wire for %s: what these functions share." % " and ".join(f.name for f in self.functions),
            "",
        ]
        own = {command.words[0] for f in self.functions for command in f.commands() if command.name == "loadrt"}
        for module, instances in self._modules().items():
            if module == "watchdog":
                lines.append("loadrt watchdog num_inputs=1")
            elif module not in own and not (module in self.machine.halfiles.components and not self.machine.twopass):
                unit = self._value(UNIT) if module in STAGES else ""
                lines.append(("loadrt %s names=%s %s" % (module, ",".join(instances), unit)).rstrip())
        lines += [""] + [line for part in self.parts for line in part.loadusr]
        if self.freed or self.unlinked:
            lines += ["", "# Your signals of these pins go on between the stages and the drives."]
            lines += ["unlinkp " + pin for pin in [*self.freed, *self.unlinked]]
        for part in self.parts + self.gates:
            body = ["setp %s %s" % pair for pair in part.setp]
            body += [line for line in (self.net(net, part in self.gates) for net in part.nets) if line]
            if body:
                lines += [""] + (["# %s." % part.title] if part.title else []) + body
        return "\n".join(lines) + "\n"

    def function_hal(self, function):
        lines = [
            "# SPDX-License-Identifier: GPL-2.0-or-later",
            "# Written by plumb wire: %s with the signals of this machine." % function.name,
        ]
        for command in self.commands_of(function):
            if command.name == "addf":
                continue
            if command.name == "net":
                line = self.net(command.words)
            else:
                line = " ".join([command.name, *filter(None, map(self._value, command.words))])
            comment = [text for text in command.comment if "SPDX" not in text]
            if lines[-1].startswith("# Written"):
                comment = [""]  # the sentence on top is about the file of the function
            lines += comment + ([line] if line else [])
        return "\n".join(lines) + "\n"

    def _value(self, word):
        """A word of a function's HAL for this machine. [TRAJ]MAX_LINEAR_VELOCITY becomes a number where it is not given or
        a joint is faster, and the unit is left out where it is not given."""
        if word == UNIT:
            return word if self.machine.ini.get("TRAJ", "LINEAR_UNITS") else ""
        if word != "[TRAJ]MAX_LINEAR_VELOCITY":
            return word
        ini, joints = self.machine.ini, [joint for numbers in self.machine.joints.values() for joint in numbers]
        fastest = max(float(ini.get("JOINT_%d" % joint, "MAX_VELOCITY") or 1) for joint in joints)
        given = ini.get("TRAJ", "MAX_LINEAR_VELOCITY")
        return word if given and float(given) >= fastest else "%g" % fastest

    def settings_hal(self, function):
        text = function.text(function.name + "_settings.hal")
        if not self.machine.inch:
            return text
        modules = {
            name: command.words[0]
            for command in function.commands()
            if command.name == "loadrt"
            for word in command.words
            if word.startswith("names=")
            for name in word[6:].split(",")
        }
        lines = []
        for line in text.splitlines():
            words = line.split()
            if len(words) >= 3 and words[0] == "setp":
                instance, pin = words[1].split(".", 1)
                if plumb.declarations(modules[instance])["pins"][pin]["unit"].startswith("mu"):
                    line = line.replace(words[2], "%.6g" % (float(words[2]) / INCH), 1)
            lines.append(line)
        return "\n".join(lines) + "\n"

    def order(self):
        """The addf lines, each with its place: around motion-controller, in the order of the data."""
        present = list(self.machine.halfiles.threads[self.machine.thread])
        lines = []

        def add(names, place):
            for name in names:
                lines.append("addf %s %s %d" % (name, self.machine.thread, place + 1))
                present.insert(place, name)
                place += 1

        parts = self.parts + self.gates
        updates = [command.words[0] for f in self.functions for command in f.commands() if command.name == "addf"]
        staged = [name for part in parts for name in part.after if name.endswith("-stage.update")]
        first = [name for part in parts for name in part.after if name not in staged]
        add([name for part in parts for name in part.before], present.index(MOTION))
        add(first + updates + staged + [name for part in parts for name in part.last], present.index(MOTION) + 1)
        self.thread_order = present
        return lines

    def plumb_hal(self, texts):
        """The one HALFILE. With TWOPASS, which reads no file within a file, it has all lines itself."""
        title = "# The one HALFILE of %s." % " and ".join(f.name for f in self.functions)
        lines = ["# SPDX-License-Identifier: GPL-2.0-or-later", "# Written by plumb wire. " + title[2:], ""]
        for name, text in texts.items():
            if self.machine.twopass and not name.endswith("_settings.hal"):
                lines += ["", text.rstrip()]
            else:
                lines.append("source %s/%s" % (self.folder, name))
        lines += ["", "# Around motion-controller, which is the function %d of %s in your HAL files." % (
            self.machine.halfiles.threads[self.machine.thread].index(MOTION) + 1, self.machine.thread)]
        return "\n".join(lines + self.order()) + "\n"

    def messages_toml(self):
        text = "# SPDX-License-Identifier: GPL-2.0-or-later\n# Written by plumb wire: what linuxcnc_link shows the operator.\n"
        for function in self.functions:
            own = function.text(function.name + "_messages.toml")
            text += "\n" + own[own.index("[[message]]") :]
        return text + "".join(part.messages for part in self.parts)

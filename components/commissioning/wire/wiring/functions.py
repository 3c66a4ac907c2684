# SPDX-License-Identifier: GPL-2.0-or-later
"""The functions that can be wired: a folder with a wire.toml each. Adding one adds a folder."""

import os
import re
import tomllib

import hal_text
import plumb


MOST_ROWS = 16


class Function:
    """A function, as its folder in configs/functions describes it; the keys of wire.toml are in README.md beside it."""

    def __init__(self, folder):
        self.folder, self.name = folder, os.path.basename(folder)
        with open(os.path.join(folder, "wire.toml"), "rb") as file:
            given = tomllib.load(file)
        self.summary, self.axes, self.required = given["summary"], given["axes"], given["required"]
        self.reads = given.get("reads", [])
        self._joint_offset = given.get("joint_offset", {})
        self.axis_offset = given.get("axis_offset", {})
        self.stroke = given.get("stroke", {})
        self.stroked_by = {}  # the function that strokes an axis which this one reads, by letter
        self.without = given.get("without", {})
        self.interlock = given["interlock"]
        self.records = given.get("records", [])
        self.log = given.get("log", False)
        self.abort = given.get("abort")
        self.own_pins = given.get("own", {}).get("pins", [])
        self.outputs = given.get("outputs", {})
        self.named_axis = given.get("named_axis")
        self.if_netted = given.get("if_netted", {})
        self.left_out = set()  # signals of if_netted whose pins this machine does not net
        self.number = 0  # at interlock
        self.numbers = None  # Numbers on a machine
        self.remap = given.get("remap", [])
        self.m_codes = given.get("m_codes", False)
        self.ini = given.get("ini", {})
        self.values = self.ini  # values of the INI file, by section and name
        self.missing = given.get("missing", [])
        self.check = self._file("check.py")
        self.check_hal = self._file("check.hal")
        self.subroutines = sorted(name for name in os.listdir(folder) if name.endswith(".ngc"))

    def _file(self, name):
        path = os.path.join(self.folder, name)
        return path if os.path.exists(path) else None

    def original(self, name):
        with open(os.path.join(self.folder, name), encoding="utf-8") as file:
            return file.read()

    def text(self, name):
        """A file for this machine."""
        text = self.original(name)
        if self.numbers and name.endswith(".ngc"):
            text = self.numbers.named(text)
            for parameter, pin in self.outputs.items():
                text = re.sub(r"(?m)^(#<%s> *= ).*" % parameter, r"\g<1>" + self.numbers.parameter(pin), text)
        return text

    def meet(self, state):
        """Leaves out the nets of pins that the machine does not net: another signal would take their default from them."""
        self.left_out = {signal for signal, pins in self.if_netted.items() if not any(state.signal_of(pin) for pin in pins)}

    def take_values(self, *inis):
        """The values of its sections in the first of these IniFiles that has them."""
        self.values = {section: {name: next(filter(None, (ini.get(section, name) for ini in inis)), value) for name, value in values.items()}
                       for section, values in self.ini.items()}

    @property
    def joint_offset(self):
        """The signals that stages take into joints, by axis: those that it writes with its options."""
        written = {words[0] for words in self.nets([*self.axes, *self.reads])}
        return {letter: signal for letter, signal in self._joint_offset.items() if signal in written}

    @property
    def other_axis(self):
        """The letter of the axis that [CHOPPING]INFEED_AXIS names, for example; None where the INI file switches this axis off."""
        its = self.named_axis and self.values.get(self.named_axis["section"], {})
        return its[self.named_axis["name"]].upper() if its and its[self.named_axis["switch"]] != "0" else None

    def _lines(self):
        """The HAL file of the function. The file of the named axis follows it, with the letter of this axis in the place of X."""
        commands = hal_text.parse(self.text(self.name + ".hal"))
        if not self.other_axis:
            return commands
        letter = r"\g<1>%s-" % self.other_axis.lower()
        more = hal_text.parse(self.text(self.named_axis["file"]))
        at = next(i for i, command in enumerate(commands) if command.name == "addf")
        more = [each._replace(words=[re.sub(r"^()x-", letter, word) for word in each.words]) for each in more]
        return [*commands[:at], *more, *commands[at:]]

    def _has(self, pin, loaded):
        """Whether a pin is there that other options would not give; `loaded` has module and options by instance."""
        instance, _dot, short = pin.rpartition(".")
        if instance not in loaded:
            return False
        declared = plumb.declarations(loaded[instance][0])
        return bool(declared["pins"].get(short, {}).get("only_with")) and plumb.has_pin(declared, short, loaded[instance][1])

    def _repeated(self, command, loaded):
        """Returns the command, and a copy of it for each further axis and row of the machine: the HAL file of a function has only the
        lines of Z and of row 0. A signal without a number goes to all rows."""
        found = [command]
        for letter in "uvwabc":
            words = [re.sub(r"^((?:.*\.)?)z-", r"\g<1>%s-" % letter, word) for word in command.words]
            if any(self._has(word, loaded) for word, before in zip(words, command.words) if word != before):
                found.append(command._replace(words=words, comment=[]))
        for row in range(1, MOST_ROWS):
            words = [re.sub(r"-0$", "-%d" % row, word) for word in command.words]
            more = [word for word, before in zip(words, command.words) if word != before and self._has(word, loaded)]
            if more and words[0] != command.words[0]:
                found.append(command._replace(words=words, comment=[]))
            else:
                found[0].words.extend(more)
        return found

    def _loaded(self, commands):
        """Module and options of each instance that it loads."""
        found = {}
        for command in commands:
            if command.name != "loadrt":
                continue
            options = dict(word.split("=", 1) for word in command.words[1:])
            for name, value in options.items():
                ini = hal_text.VALUE.fullmatch(value)
                options[name] = self.values.get(ini[1], {}).get(ini[2] or ini[3], value) if ini else value
            found.update({instance: (command.words[0], options) for instance in options["names"].split(",")})
        return found

    def _stroked(self, letter):
        """What this function reads in the place of the signals of a joint: z-stroked-position for z-position. The function that strokes
        the axis writes them."""
        other, prefix = self.stroked_by[letter], letter.lower() + "-"
        commands = hal_text.parse(other.text(other.name + ".hal"))
        signals = [command.words[0] for command in commands if command.name == "net"]
        return {signal.replace("stroked-", "", 1): signal for signal in signals if signal.startswith(prefix + "stroked-")}

    def commands(self, axes):
        """The commands of its HAL file on a machine with these axes: without the nets of an axis that it lacks."""
        moved = self.numbers.moved if self.numbers else {}
        commands = self._lines()
        loaded = self._loaded(commands)
        stroked = {signal: other for letter in self.stroked_by for signal, other in self._stroked(letter).items()}
        netted = {word for command in commands for word in command.words[1:] if command.name == "net"}
        commands += [
            hal_text.Command("net", [other, "=>", "%s.%s" % (instance, signal)], [])
            for instance, (module, options) in loaded.items()
            for signal, other in stroked.items()
            if "%s.%s" % (instance, signal) not in netted and plumb.has_pin(plumb.declarations(module), signal, options)
        ]
        unmoved = {letter.lower() + "-motor-offset" for letter in self.stroked_by}  # the stroking feedback lacks it
        absent = tuple(letter.lower() + "-" for letter in [*self.axes, *self.reads] if letter not in axes)
        return [
            command._replace(words=[stroked.get(moved.get(word, word), moved.get(word, word)) for word in command.words])
            for each in commands
            for command in (self._repeated(each, loaded) if each.name == "net" else [each])
            if not (
                command.name == "net"
                and (command.words[0] in self.left_out or command.words[0].startswith(absent) or command.words[0] in unmoved)
                and not command.words[0].endswith("-tool-offset")  # LinuxCNC has this pin for all axes
            )
        ]

    def nets(self, axes):
        """The words of its nets on a machine with these axes."""
        return [command.words for command in self.commands(axes) if command.name == "net"]

    def lacks(self, axes):
        """The axes that it needs, if a machine with these axes has too few of them."""
        if isinstance(self.required, list):
            return [letter for letter in self.required if letter not in axes]
        lacking = [letter for letter in self.axes if letter not in axes]
        return lacking if len(self.axes) - len(lacking) < self.required else []

    @property
    def needs_halui(self):
        """Whether it or interlock for it joins pins of halui."""
        own = any(word.startswith("halui.") for words in self.nets(self.axes) for word in words)
        return bool(own or self.axis_offset or self.stroke)

    @property
    def modules(self):
        """The instances of each module that it loads."""
        return {
            command.words[0]: word[len("names=") :].split(",")
            for command in self.commands(self.axes)
            if command.name == "loadrt"
            for word in command.words
            if word.startswith("names=")
        }

    @property
    def updates(self):
        """Its functions of the servo thread."""
        return [command.words[0] for command in self.commands(self.axes) if command.name == "addf"]

    @property
    def external_signals(self):
        """Signals that nobody but the user can give."""
        return [part["signal"] for part in self.missing if "signal" in part]


def all_functions(folder):
    """Function by name."""
    found = {}
    for name in sorted(os.listdir(folder)):
        if os.path.exists(os.path.join(folder, name, "wire.toml")):
            found[name] = Function(os.path.join(folder, name))
    return found

# SPDX-License-Identifier: GPL-2.0-or-later
"""The functions that can be wired: a folder with a wire.toml each. Adding one adds a folder."""

import os
import re
import tomllib

import hal_text


class Function:
    """A function, as its folder in configs/functions describes it; the keys of wire.toml are in README.md beside it."""

    def __init__(self, folder):
        self.folder, self.name = folder, os.path.basename(folder)
        with open(os.path.join(folder, "wire.toml"), "rb") as file:
            given = tomllib.load(file)
        self.summary, self.axes, self.required = given["summary"], given["axes"], given["required"]
        self.reads = given.get("reads", [])
        self.joint_offset = given.get("joint_offset", {})
        self.axis_offset = given.get("axis_offset", {})
        self.stroke = given.get("stroke", {})
        self.without = given.get("without", {})
        self.interlock = given["interlock"]
        self.records = given.get("records", [])
        self.log = given.get("log", False)
        self.abort = given.get("abort")
        self.own_pins = given.get("own", {}).get("pins", [])
        self.outputs = given.get("outputs", {})
        self.if_netted = given.get("if_netted", {})
        self.left_out = set()  # signals of if_netted whose pins this machine does not net
        self.number = 0  # at interlock
        self.numbers = None  # Numbers on a machine
        self.remap = given.get("remap", [])
        self.m_codes = given.get("m_codes", False)
        self.ini = given.get("ini", {})
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

    def commands(self, axes):
        """The commands of its HAL file on a machine with these axes: without the nets of an axis that it lacks."""
        moved = self.numbers.moved if self.numbers else {}
        absent = tuple(letter.lower() + "-" for letter in [*self.axes, *self.reads] if letter not in axes)
        return [
            command._replace(words=[moved.get(word, word) for word in command.words])
            for command in hal_text.parse(self.text(self.name + ".hal"))
            if not (
                command.name == "net"
                and (command.words[0] in self.left_out or command.words[0].startswith(absent))
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

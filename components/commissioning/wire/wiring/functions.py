# SPDX-License-Identifier: GPL-2.0-or-later
"""The functions that can be wired: a folder with a wire.toml each. Adding one adds a folder."""

import os
import tomllib

import hal_text


class Function:
    """A function, as its folder in configs/functions describes it; the keys of wire.toml are in README.md beside it."""

    def __init__(self, folder):
        self.folder, self.name = folder, os.path.basename(folder)
        with open(os.path.join(folder, "wire.toml"), "rb") as file:
            given = tomllib.load(file)
        self.summary, self.axes, self.required = given["summary"], given["axes"], given["required"]
        self.joint_offset = given.get("joint_offset", {})
        self.axis_offset = given.get("axis_offset", {})
        self.records, self.services = given.get("records", []), given.get("services", [])
        self.abort = given.get("abort")
        self.own_pins = given.get("own", {}).get("pins", [])
        self.ini = given.get("ini", {})
        self.missing = given.get("missing", [])
        self.check = self._file("check.py")
        self.check_hal = self._file("check.hal")
        self.subroutines = sorted(name for name in os.listdir(folder) if name.endswith(".ngc"))

    def _file(self, name):
        path = os.path.join(self.folder, name)
        return path if os.path.exists(path) else None

    def text(self, name):
        with open(os.path.join(self.folder, name), encoding="utf-8") as file:
            return file.read()

    def commands(self):
        return hal_text.parse(self.text(self.name + ".hal"))

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

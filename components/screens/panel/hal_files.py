# SPDX-License-Identifier: GPL-2.0-or-later
"""INI values, and the values that the HAL files of a machine set, for comparison with those in force."""

import os
import re


class Ini:
    """Sections with their lines, included files too. Without a file all is empty."""

    def __init__(self, path):
        self.path = path or ""
        self.folder = os.path.dirname(os.path.abspath(path)) if path else ""
        self._values = []  # (section, name, value, file)
        if path:
            self._read(os.path.abspath(path), "", 0)

    def _read(self, path, section, depth):
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                lines = file.read().splitlines()
        except OSError:
            return section
        for line in lines:
            text = line.strip()
            if text.startswith("#INCLUDE") and depth == 0:
                section = self._read(os.path.join(self.folder, text[len("#INCLUDE"):].strip()), section, 1)
            elif text.startswith("[") and "]" in text:
                section = text[1:text.index("]")].strip()
            elif "=" in text and not text.startswith(("#", ";")):
                name, value = (part.strip() for part in text.split("=", 1))
                self._values.append((section, name, value, path))
        return section

    def all(self, section, name):
        return [value for its, key, value, _ in self._values if (its, key) == (section, name)]

    def get(self, section, name, otherwise=""):
        found = self.all(section, name)
        return found[0] if found else otherwise

    def place(self, section, name):
        """The file that gives a value; '' without one."""
        return next((path for its, key, _, path in self._values if (its, key) == (section, name)), "")


def values_of_hal_files(ini):
    """Texts by pin, and the file of each: the last `setp` of all HAL files counts. What needs Tcl is not followed."""
    found = {}
    for value in ini.all("HAL", "HALFILE") + ini.all("HAL", "POSTGUI_HALFILE"):
        _follow(ini, value.split()[0] if value.split() else "", found, set())
    return found


def _follow(ini, name, found, seen):
    path = os.path.join(ini.folder, os.path.expanduser(name))
    if path in seen or name.endswith(".tcl") or not os.path.isfile(path):
        return
    seen.add(path)
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read().replace("\\\n", " ")
    for line in text.splitlines():
        words = line.split("#", 1)[0].split()
        words = [_substituted(ini, word) for word in words]
        if len(words) == 2 and words[0] == "source":
            _follow(ini, words[1], found, seen)
        elif len(words) == 3 and words[0] == "setp":
            found[words[1]] = (words[2], os.path.relpath(path, ini.folder))


def _substituted(ini, word):
    word = word.replace("$(CONFIG_DIR)", ini.folder)
    return re.sub(r"\[(\w+)\]\(?(\w+)\)?", lambda found: ini.get(found[1], found[2], found[0]), word)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes the list of models (hal/host/models.hpp) of a machine: write_models.py FOLDER FILE.ini|FILE.hal ...

Prints the path of the list. What stands in, and what the models do not do, goes to standard error, a line each.
"""

import json
import os
import re
import shutil
import subprocess
import sys

# By the name that started this program: in a build, its folder is a link.
PREFIX = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(sys.argv[0])))))
sys.path.append(os.path.join(PREFIX, "python"))
import hal_text  # noqa: E402
from stand_ins import StandIns, script  # noqa: E402
from texts import Impossible  # noqa: E402


class Ini:
    """The values of an INI file, with those of the files that it includes; or of none."""

    def __init__(self, path=None):
        self.path, self.values = path, {}
        self.folder = os.path.dirname(os.path.abspath(path or "."))
        self.lines = list(self._lines(path)) if path else []
        section = ""
        for line in self.lines:
            found = re.match(r"\s*\[(\w+)\]", line)
            value = re.match(r"\s*(\w+)\s*=\s*(.*?)\s*$", line)
            if found:
                section = found[1]
            elif value:
                self.values.setdefault((section, value[1]), []).append(value[2])

    def _lines(self, path):
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            text = re.sub(r"\\\n", "", file.read())
        for line in text.splitlines():
            included = re.match(r"#INCLUDE\s+(\S+)", line)
            if included:
                file = os.path.join(self.folder, os.path.expanduser(included[1]))
                if os.access(file, os.R_OK):
                    yield from self._lines(file)
                else:  # LinuxCNC goes on as well
                    print("note: %s: #INCLUDE %s: the file cannot be read" % (path, included[1]), file=sys.stderr)
            else:
                yield line

    def get(self, section, name):
        return self.all(section, name)[0] if self.all(section, name) else None

    def all(self, section, name):
        return self.values.get((section, name), [])


class Place:
    """A folder of the run, where the list and the programs go."""

    def __init__(self, folder):
        shutil.rmtree(folder, ignore_errors=True)
        self.folder, self.read, self.covers = folder, set(), []
        self.plumb = shutil.which("plumb", path=os.path.join(PREFIX, "bin")) or "plumb"

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text, mode=0o666):
        path = self.path(name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(text)
        os.chmod(path, mode & 0o755)
        return path

    def program(self, name, *words):
        return self.write(name, script(*words), 0o777)

    def can_place(self, path):
        return os.path.isfile(path)

    def place(self, path, text, mode=0o666):
        """Another text for a file, in the run alone."""
        name = "covers/%d" % len(self.covers)
        self.covers.append([self.write(name, text, mode), os.path.realpath(path)])

    def list_models(self, models):
        listed = {"modules": models, "programs": self.covers, "path": self.path("bin")}
        return self.write("models.json", json.dumps(listed))

    def pins_of_modules(self, lines):
        path = self.write("modules.hal", "".join(line + "\n" for line in lines) + "show pin\n")
        words = [self.plumb, "run", "--", "halrun", "-k", "-s", path]
        return subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=10, check=False).stdout


def models_of(place, ini, hal):
    return StandIns(place, ini, hal, follows=False)


def show(models):
    """Prints which drivers and programs are models, and what each leaves out."""
    for module in models.drivers:
        rows = models.models[module]["pins"]
        if rows:
            misses = "; the model leaves out " + models.misses[module] if module in models.misses else ""
            print("model: %s has %d pins%s" % (module, len(rows), misses), file=sys.stderr)
    if models.programs:
        print("model: %s" % ", ".join(sorted(models.programs)), file=sys.stderr)


def main(folder, files):
    ini = Ini(next((file for file in files if file.endswith(".ini")), None))
    hal = [path for file in files if file.endswith(".hal") for path in hal_text.with_sourced(file, os.path.dirname(os.path.abspath(file)))]
    if ini.path:
        hal = list(hal_text.halfiles(ini, ini.folder)) + hal
    elif hal:
        ini.folder = os.path.dirname(os.path.abspath(hal[0]))
    models = models_of(Place(folder), ini, hal)
    show(models)
    print(models.list)


if __name__ == "__main__":
    try:
        main(sys.argv[1], sys.argv[2:])
    except (Impossible, OSError) as error:
        sys.exit("plumb: the models: %s" % error)

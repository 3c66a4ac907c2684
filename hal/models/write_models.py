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

MOTION = (("KINS", "KINEMATICS"), ("TRAJ", "TPMOD"), ("EMCMOT", "HOMEMOD"), ("EMCMOT", "EMCMOT"))  # modules without a model
DEEPEST = 3  # folders below the INI file in which a module's source is looked for
PATIENCE = 60  # s, for a compiler


def variable(name):
    """A variable that LinuxCNC's script sets first of all: a folder of this LinuxCNC."""
    path = shutil.which("linuxcnc")
    if path is None:
        raise Impossible("LinuxCNC's script linuxcnc is not in PATH")
    with open(path, encoding="utf-8", errors="replace") as file:
        found = re.search(r"^%s=([^;\s]+)" % name, file.read(), re.M)
    if not found:
        raise Impossible("%s does not set %s" % (path, name))
    return found[1].strip("\"'")


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

    def is_absent(self, module, ini):
        """Whether a module is neither installed nor can be made of its source. The modules of motion have no model."""
        folders = (variable("LINUXCNC_RTLIB_DIR"), os.path.join(PREFIX, "modules"), self.path("modules"))
        if not re.fullmatch(r"[\w-]+", module) or any(os.path.exists(os.path.join(folder, module + ".so")) for folder in folders):
            return False
        if self._compile(module, ini.folder):
            return False
        return module != "motmod" and not any(module in (ini.get(*name) or "").split() for name in MOTION)

    def _compile(self, module, folder):
        """Compiles a module of the user's from the source beside his INI file."""
        source = next(iter(sources(module, folder)), None)
        if source is None or shutil.which("halcompile") is None:
            return False
        os.makedirs(self.path("modules"), exist_ok=True)
        words = ["halcompile", "--compile", source]
        place = self.path("modules")
        done = subprocess.run(words, cwd=place, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE, check=False)
        made = os.path.exists(self.path("modules/%s.so" % module))
        what = "is compiled for this run" if made else "cannot be compiled:\n" + "\n".join((done.stdout + done.stderr).splitlines()[-5:])
        print("note: %s %s" % (source, what), file=sys.stderr)
        return made

    def list_models(self, models):
        listed = {**models, "programs": self.covers, "path": self.path("bin"), "module_folder": self.path("modules")}
        return self.write("models.json", json.dumps(listed))

    def pins_of_modules(self, lines):
        os.makedirs(self.path("modules"), exist_ok=True)
        path = self.write("modules.hal", "".join(line + "\n" for line in lines) + "show pin\n")
        words = [self.plumb, "run", "--modules", self.path("modules"), "--", "halrun", "-k", "-s", path]
        return subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE, check=False).stdout


def sources(module, folder):
    """The sources of a module, in a folder and those in it."""
    for place, folders, names in os.walk(folder):
        if os.path.relpath(place, folder).count(os.sep) >= DEEPEST - 1:
            folders.clear()
        folders.sort()
        yield from (os.path.join(place, module + end) for end in (".comp", ".c") if module + end in names)


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
    for note in models.notes:
        print("note: %s; its pins rest" % note, file=sys.stderr)


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

# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts a copy of a configuration once, in virtual time and in namespaces: nothing of the user's is written to."""

import json
import os
import shutil
import subprocess
import sys

from texts import Impossible

HERE = os.path.dirname(os.path.realpath(__file__))
SPEED = 10  # times real time
PATIENCE = 300  # s of this computer's time
NOISE = ("Running with fallback_uid", "tool_mmap_close", "task: ", "link (updating", "Found file")

# As the root of new namespaces: the copy takes the place of the folder, so that ../ and absolute paths lead there.
# Programs that cannot run here are covered in the same way: pairs of paths up to --.
_PLACE = """
set -e
home=$2
while [ "$1" != -- ]; do
  mount --no-canonicalize --bind "$1" "$2"
  shift 2
done
shift
case $home in
/tmp | /tmp/*) ;;
*) mount -t tmpfs -o mode=1777 tmpfs /tmp ;;  # its files go with the trial
esac
cd "$home"
exec "$@"
"""


class NotStarted(RuntimeError):
    """LinuxCNC did not come up with this configuration; the message has its last words."""


class Trial:
    """A copy of the folder of an INI file. `ini` is an IniFile, whose changes are written into the copy."""

    def __init__(self, ini, folder, plumb):
        self.ini, self.plumb = ini, plumb
        os.makedirs(folder, exist_ok=True)
        self.copy = os.path.join(folder, "copy")
        copy_folder(ini.folder, self.copy)
        self.own = os.path.join(self.copy, ".plumb-wire")
        os.mkdir(self.own)
        os.makedirs(os.path.join(self.copy, "bin"), exist_ok=True)
        self.covers = []  # a file of the copy, and the file in whose place it is seen

    def cover(self, name, path):
        self.covers += [os.path.join(self.copy, name), path]

    def write(self, name, text):
        path = os.path.join(self.copy, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8", errors="surrogateescape") as file:
            file.write(text)
        return os.path.join(self.ini.folder, name)

    def program(self, name, *words):
        """An executable of the copy that runs one of ours."""
        path = self.write(name, "#!/bin/sh\nexec %s %s \"$@\"\n" % (sys.executable, " ".join(words)))
        os.chmod(os.path.join(self.copy, name), 0o755)
        return path

    def run(self, task, **settings):
        """Starts LinuxCNC, with display.py for `task` as its DISPLAY; returns the findings of this."""
        here = os.path.join(self.ini.folder, ".plumb-wire")
        result = os.path.join(self.own, "result.json")
        with open(os.path.join(self.own, "task.json"), "w", encoding="utf-8") as file:
            json.dump({"task": task, "folder": here, "ini": self.ini.path, **settings}, file)
        if os.path.exists(result):
            os.unlink(result)
        display = self.program(".plumb-wire/display", os.path.join(HERE, "display.py"), os.path.join(here, "task.json"))
        self.ini.set("DISPLAY", "DISPLAY", display)
        self.ini.set("EMCMOT", "COMM_TIMEOUT", "300")  # s of a clock that is ten times faster
        self.ini.drop("DISPLAY", "INTRO_GRAPHIC")
        self.ini.drop("APPLICATIONS", "APP")
        self.ini.write(self.copy)
        status, output = self._linuxcnc()
        if "unshare:" in output or "gives the run no namespaces" in output:
            raise Impossible("plumb wire needs namespaces, and this system gives none: plumb doctor says why.")
        if not os.path.exists(result):
            raise NotStarted(last_words(output) or "linuxcnc ended with %d" % status)
        with open(result, encoding="utf-8") as file:
            return json.load(file)

    def _linuxcnc(self):
        environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        command = [self.plumb, "run", "--speed", str(SPEED), "--", "linuxcnc", "-r", self.ini.path]
        place = ["/bin/sh", "-c", _PLACE, "sh", self.copy, self.ini.folder, *self.covers, "--"]
        if os.geteuid() == 0:
            spaces = ["unshare", "--mount", "--propagation", "private", "--", *place]
        else:
            back = ["unshare", "--user", "--map-user=%d" % os.getuid(), "--map-group=%d" % os.getgid(), "--"]
            spaces = ["unshare", "--user", "--map-root-user", "--mount", "--", *place, *back]
        with subprocess.Popen(
            [*spaces, *command],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
        ) as process:
            try:
                output = process.communicate(timeout=PATIENCE)[0]
            except subprocess.TimeoutExpired:
                process.terminate()
                output = process.communicate()[0] + "\nLinuxCNC did not end within %d s" % PATIENCE
            except BaseException:
                process.terminate()
                raise
        with open(os.path.join(self.own, "output"), "w", encoding="utf-8") as file:
            file.write(output)
        return process.returncode, output


def copy_folder(source, copy):
    """Links to files become files, as they might be written to; links to folders stay."""

    def ignore(folder, names):
        return [name for name in names if _is_special(os.path.join(folder, name))]

    def copy_file(path, to):
        if os.path.islink(path) and os.path.isdir(path):
            os.symlink(os.readlink(path), to)
        else:
            shutil.copy2(path, to)

    os.makedirs(copy)
    for name in os.listdir(source):
        path, to = os.path.join(source, name), os.path.join(copy, name)
        if _is_special(path):
            continue
        if os.path.isdir(path) and not os.path.islink(path):
            shutil.copytree(path, to, symlinks=True, ignore=ignore)
        else:
            copy_file(path, to)


def _is_special(path):
    return not (os.path.isdir(path) or os.path.isfile(path))


def last_words(output):
    lines = [line for line in output.splitlines() if line.strip() and not line.startswith(NOISE)]
    return "\n".join("  " + line for line in lines[-40:])

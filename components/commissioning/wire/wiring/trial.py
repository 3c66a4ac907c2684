# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts a copy of a configuration once, in virtual time, where nothing but the copy can be written (sandbox.py)."""

import json
import os
import re
import select
import subprocess
import sys
import time

import stand_ins
import writing
from copies import copy_links
from sandbox import OWN, PLAN, READY
from stand_ins import script
from texts import Impossible, wrapped

HERE = os.path.dirname(os.path.realpath(__file__))
MODELS = os.path.dirname(os.path.realpath(stand_ins.__file__))
SPEED = 10  # times real time
PATIENCE = 300  # s of this computer's time
MODULE_PATIENCE = 10
WRONG_NAME = b"Did you specify the correct name via 'loadusr -Wn'?"  # of halcmd, when another component has come
NAME_PATIENCE = 30  # s from then on
MOST_WORDS = 40  # lines
NOISE = ("Running with fallback_uid", "tool_mmap_close", "task: ", "link (updating", "Found file", "Starting LinuxCNC", "Machine configuration file")
WRITTEN = (("RS274NGC", "PARAMETER_FILE"), ("EMCIO", "TOOL_TABLE"), ("TRAJ", "POSITION_FILE"))  # LinuxCNC writes these
# Variables by which a program reaches another that runs outside the trial.
OUTSIDE = (
    "DISPLAY",
    "WAYLAND_DISPLAY",
    "XAUTHORITY",
    "DBUS_SESSION_BUS_ADDRESS",
    "DBUS_SYSTEM_BUS_ADDRESS",
    "XDG_RUNTIME_DIR",
    "SSH_AUTH_SOCK",
    "GPG_AGENT_INFO",
    "TMPDIR",
)


class NotStarted(RuntimeError):
    """LinuxCNC did not come up with this configuration; the message has its last words."""


class Trial:
    """A copy of the folder of an INI file. `ini` is an IniFile, whose changes are written into the copy.

    copy    files that cover the files of the folder, and that the trial writes
    own     files of the trial, which its programs see in sandbox.OWN
    """

    def __init__(self, ini, folder, plumb):
        self.ini, self.plumb = ini, plumb
        self.copy, self.own = os.path.join(folder, "copy"), os.path.join(folder, "own")
        os.makedirs(folder, exist_ok=True)
        copy_links(ini.folder, self.copy)
        os.mkdir(self.own)
        self.covers = {}  # a path outside the folder, and the file of ours that is seen in its place
        self.read = set()  # paths that must stay in sight
        self.models = ()  # options of plumb run with the list of models

    def write(self, name, text, mode=0o666):
        """A file of the trial; returns its path in the trial."""
        writing.write(self.own, name, text, mode)
        return os.path.join(OWN, name)

    @staticmethod
    def path(name):
        return os.path.join(OWN, name)

    def list_models(self, models):
        """Lets the drivers of the trial be models (hal/host/models.hpp)."""
        self.models = ("--model-list", self.write("models.json", json.dumps(models)))

    @staticmethod
    def is_absent(_module, _ini):
        """A trial finds this out: LinuxCNC complains."""
        return False

    def can_place(self, path):
        return os.path.exists(path) or writing.inside(path, self.ini.folder) is not None

    def place(self, path, text, mode=0o666):
        """Gives a file of the user another text, in the trial alone: in the copy, or over a file that lies outside."""
        name = writing.inside(path, self.ini.folder)
        if name is not None:
            writing.write(self.copy, name, text, mode)
        elif os.path.isfile(path):
            self._cover(os.path.realpath(path), text, mode)
        else:
            raise Impossible("plumb wire writes nothing outside %s, and %s would be a new file." % (self.ini.folder, path))

    def _cover(self, path, text, mode):
        name = self.covers.setdefault(path, "covers/%d" % len(self.covers))
        writing.write(self.own, name, text, mode)

    def program(self, name, *words):
        """An executable of the trial that runs one of ours."""
        return self.write(name, script(*words), 0o777)

    def run(self, task, **settings):
        """Starts LinuxCNC, with display.py for `task` as its DISPLAY; returns the findings of this."""
        result = os.path.join(self.own, "result.json")
        self.write("task.json", json.dumps({"task": task, "folder": OWN, "ini": self.ini.path, **settings}))
        for name in ("result.json", READY):
            if os.path.lexists(os.path.join(self.own, name)):
                os.unlink(os.path.join(self.own, name))
        display = self.program("display", os.path.join(HERE, "display.py"), os.path.join(OWN, "task.json"))
        self.ini.set("DISPLAY", "DISPLAY", display)
        self.ini.set("EMCMOT", "COMM_TIMEOUT", "300")  # s of a clock that is ten times faster
        self.ini.drop("DISPLAY", "INTRO_GRAPHIC")
        self.ini.drop("APPLICATIONS", "APP")
        self._bring_inside()
        self.ini.write(self.place)
        status, output = self._linuxcnc()
        if not os.path.exists(os.path.join(self.own, READY)) or "gives the run no namespaces" in output:
            sentence = "plumb wire needs namespaces, and this system gives none: plumb doctor says why."
            raise Impossible(sentence + "\n" + last_words(output))
        if not os.path.exists(result):
            words = last_words(output) or "linuxcnc ended with %d" % status
            if "Read-only file system" in output:
                words += "\n" + wrapped("In the trial, programs can write only into %s, HOME and /tmp." % self.ini.folder)
            raise NotStarted(words)
        return json.loads(writing.read(self.own, "result.json"))

    def _bring_inside(self):
        """Gives the trial copies of files outside the folder that LinuxCNC writes."""
        for number, (section, name) in enumerate(WRITTEN):
            value = self.ini.get(section, name)
            path = os.path.join(self.ini.folder, os.path.expanduser(value or ""))
            if not os.path.basename(path) or writing.inside(path, self.ini.folder) is not None:
                continue
            text = writing.read("/", path, follow=True) if os.path.isfile(path) else None
            if text is not None:
                self.write("outside/%d/%s" % (number, os.path.basename(path)), text)
            else:
                os.makedirs(os.path.join(self.own, "outside", str(number)), exist_ok=True)
            self.ini.set(section, name, os.path.join(OWN, "outside", str(number), os.path.basename(path)))

    def pins_of_modules(self, lines):
        """Rows of `halcmd -s show pin` with the pins of modules that load without their hardware, by their loadrt lines."""
        path = self.write("modules.hal", "".join(line + "\n" for line in lines) + "show pin\n")
        command, environment = in_sandbox(self._plan(), [self.plumb, "run", "--"], ["halrun", "-k", "-s", path])
        return finished(command, environment, MODULE_PATIENCE)[1]

    def _plan(self):
        return {
            "home": self.ini.folder,
            "copy": self.copy,
            "own": self.own,
            "covers": [(os.path.join(self.own, name), path) for path, name in self.covers.items()],
            "keep": [HERE, MODELS, self.plumb, sys.executable, *self.ini.texts, *self.read, *self.covers],
        }

    def _linuxcnc(self):
        host = [self.plumb, "run", *self.models, "--speed", str(SPEED), "--"]
        command, environment = in_sandbox(self._plan(), host, ["linuxcnc", "-r", self.ini.path])
        return finished(command, environment, PATIENCE)


def finished(command, environment, patience):
    """Exit status and output of a program that has this many seconds; fewer once halcmd waits for a name that nobody has. By
    setsid() the program has no terminal to type into, and its signals to its process group do not reach wire."""
    pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen(command, env=environment, start_new_session=True, **pipes) as process:
        output, began = b"", time.monotonic()
        try:
            while select.select([process.stdout], [], [], max(0, began + patience - time.monotonic()))[0]:
                words = os.read(process.stdout.fileno(), 1 << 16)
                if not words:
                    break
                output += words
                if patience > NAME_PATIENCE and WRONG_NAME in output:
                    began, patience = time.monotonic(), NAME_PATIENCE
            else:
                process.terminate()
                output += process.stdout.read() + b"\nLinuxCNC did not end within %d s" % patience
        except BaseException:
            process.terminate()
            raise
    return process.returncode, output.decode(errors="replace")


def in_sandbox(plan, host, words):
    """The command that starts `words` by plumb run in a sandbox, and its environment. Root stays root, without its rights
    over the computer."""
    sandbox = [sys.executable, os.path.join(HERE, "sandbox.py")]
    writing.write(plan["own"], PLAN, json.dumps({**plan, "user": os.geteuid()}))
    plan = os.path.join(plan["own"], PLAN)
    if os.geteuid() == 0:
        spaces = ["unshare", "--mount", "--propagation", "private", "--", *sandbox, plan]
        inside = [*host, *sandbox, "--inside", *words]
    else:
        spaces = ["unshare", "--user", "--map-root-user", "--mount", "--", *sandbox, plan]
        inside = ["unshare", "--user", "--map-user=%d" % os.getuid(), "--map-group=%d" % os.getgid(), "--", *host, *words]
    environment = {name: value for name, value in os.environ.items() if name not in OUTSIDE}
    environment["XDG_STATE_HOME"] = os.path.join(OWN, "state")  # plumb-retain counts there, and HOME shows its folders read-only
    environment["PYTHONPATH"] = ":".join(filter(None, (MODELS, environment.get("PYTHONPATH"))))
    environment["PATH"] = environment.get("PATH", os.defpath) + ":" + os.path.join(OWN, "bin")
    if environment.get("HOME") in (None, "", "/") or not os.path.isdir(environment["HOME"]):
        environment["HOME"] = "/tmp"  # LinuxCNC has a file of its own there
    return [*spaces, *inside], environment


def last_words(output):
    """The last lines before LinuxCNC's own report of its end."""
    lines = [re.sub(r"\.{4,}", "...", line) for line in output.splitlines()]
    lines = [line for line in lines if line.strip(" .") and not line.startswith(NOISE)]
    end = next((number for number, line in enumerate(lines) if line.startswith("Shutting down and cleaning up")), len(lines))
    said = lines[:end][-MOST_WORDS:] + [line for line in lines[end:] if line.startswith("LinuxCNC did not end")]
    return "\n".join("  " + line for line in said)

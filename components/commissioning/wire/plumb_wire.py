#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Wires functions into a LinuxCNC configuration, and tries the result. See plumb-wire(1)."""

import argparse
import contextlib
import difflib
import hashlib
import json
import os
import re
import shutil
import sys
import tempfile
import textwrap

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
sys.path.append(os.path.join(PREFIX, "python"))  # of a build
sys.path.insert(0, os.path.join(PREFIX, "share", "plumb", "wiring"))
import hal_text  # noqa: E402
from functions import all_functions  # noqa: E402
from hal_state import State  # noqa: E402
from ini_file import IniFile  # noqa: E402
from stand_ins import StandIns  # noqa: E402
from trial import NotStarted, Trial  # noqa: E402
from wiring import Machine, Wiring  # noqa: E402

SUMMARY = "wires functions into a LinuxCNC configuration, and tries the result"
FUNCTIONS = os.path.join(PREFIX, "share", "plumb", "functions")
MANIFEST = ".written.json"  # what was written here, to know a user's hand
OFFSET_RATIO = "0.2"
ABORT = "plumb_abort"
# Modules that pass a number on, with its pin and settings: the first that the user does not load.
FOLLOWERS = (("sum2", "in0", ()), ("scale", "in", (("gain", 1),)), ("mult2", "in0", (("in1", 1),)), ("lowpass", "in", (("gain", 1),)))
BASIC_STEPS = 3  # of a trial: on, home, program
ATTEMPTS = 30  # to find what the pins of a driver are


class Impossible(RuntimeError):
    """What keeps it from being wired, in sentences."""


def main():
    parser = argparse.ArgumentParser(prog="plumb wire", description=SUMMARY[0].upper() + SUMMARY[1:] + ".")
    parser.add_argument("--summary", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("functions", nargs="*", metavar="FUNCTION", help="such as squareness")
    parser.add_argument("--ini", metavar="FILE.ini", help="INI file of the machine")
    parser.add_argument("--output", metavar="DIR", help="folder for the files; the default is plumb, beside the INI file")
    parser.add_argument(
        "--joints", metavar="X=0,...", default="", help="joints that drive the axes, where the kinematics do not show it"
    )
    parser.add_argument("--version", action="version", version="plumb @PROJECT_VERSION@")
    arguments = parser.parse_args()
    if arguments.summary:
        print(SUMMARY)
        return 0
    known = all_functions(FUNCTIONS)
    wrong = [name for name in arguments.functions if name not in known]
    if wrong or not arguments.functions:
        return refuse(unknown(wrong, known))
    if not arguments.ini:
        return refuse("give the INI file of your machine: --ini my.ini")
    if not os.path.isfile(arguments.ini):
        return refuse("cannot read %s: there is no such file" % arguments.ini)
    try:
        return Wire([known[name] for name in dict.fromkeys(arguments.functions)], arguments, known).run()
    except (Impossible, NotStarted) as error:
        print("plumb wire: nothing was written.\n\n%s" % error, file=sys.stderr)
        return 1


def refuse(sentence):
    print("plumb wire: " + sentence, file=sys.stderr)
    return 2


def unknown(wrong, known):
    listed = "".join("\n  %-22s %s" % (function.name, function.summary) for function in known.values())
    if not wrong:
        return "name the functions to wire. There are" + listed
    close = difflib.get_close_matches(wrong[0], known, 1)
    return "there is no function '%s'%s There are%s" % (wrong[0], "; is it %s?" % close[0] if close else ".", listed)


class Wire:
    def __init__(self, functions, arguments, known):
        self.ini_path = os.path.abspath(arguments.ini)
        self.home = os.path.dirname(self.ini_path)
        self.output = os.path.abspath(arguments.output or os.path.join(self.home, "plumb"))
        self.folder = os.path.relpath(self.output, self.home)
        if self.folder.startswith("..") or self.folder == ".":
            raise Impossible("--output %s must be a folder below that of the INI file, %s" % (arguments.output, self.home))
        self.manifest = self._read_manifest()
        earlier = [known[name] for name in self.manifest.get("functions", []) if name in known and known[name] not in functions]
        self.functions = sorted([*earlier, *functions], key=lambda function: function.name)
        self.given_joints = parse_joints(arguments.joints)
        self.learnt, self.motmod = {}, None
        self.needs_halui = any(function.axis_offset for function in self.functions)

    # --- reading ---

    def fresh_ini(self):
        """The INI file without the lines that put our files in."""
        ini = IniFile(self.ini_path)
        ini.drop("HAL", "HALFILE", lambda value: value.split()[0] in (self.halfile, "./" + self.halfile))
        ini.drop_include(self.include)
        return ini

    @property
    def halfile(self):
        return self.folder + "/plumb.hal"

    @property
    def include(self):
        return self.folder + "/plumb.inc"

    def run(self):
        ini = self.fresh_ini()
        joints = joints_of(ini, self.given_joints)
        self.check_axes(joints, ini)
        print("Reading %s" % os.path.basename(self.ini_path), flush=True)
        with tempfile.TemporaryDirectory(prefix="plumb-wire-") as folder:
            machine, found = self.look(ini, joints, folder)
            wiring = self.join(machine)
            if wiring.motmod:
                machine, wiring = self.look_with_outputs(wiring, joints, folder)
            if wiring.problems:
                raise Impossible("\n".join(wrapped(problem, "- ") for problem in dict.fromkeys(wiring.problems)))
            self.describe(machine, found)
            files = self.files(wiring)
            self.forbid_strangers(files)
            print("Trying it on a copy", flush=True)
            seen, messages = self.try_it(wiring, machine, files, folder)
            for statement, holds in seen:
                print("  %-4s %s" % ("ok" if holds else "NO", statement))
            if not all(holds for _, holds in seen):
                for message in messages:
                    print("  LinuxCNC: " + message)
                raise Impossible("It does not work on the copy, as shown above." + self.without_plumb(machine, len(seen), folder))
        self.write(files)
        self.tell(wiring, files)
        return 0

    def check_axes(self, joints, ini):
        for function in self.functions:
            there = [letter for letter in function.axes if joints.get(letter)]
            if len(there) < function.required:
                lacking = [letter for letter in function.axes if letter not in there]
                kinematics = ini.get("KINS", "KINEMATICS") or "none"
                letters = (ini.get("TRAJ", "COORDINATES") or "").replace(" ", "").upper()
                if lacking[0] not in letters:
                    raise Impossible(
                        wrapped("%s needs the axis %s, and this machine has %s: [TRAJ]COORDINATES in %s."
                                % (function.name, " and ".join(lacking), " ".join(letters) or "none", self.ini_path))
                    )
                raise Impossible(
                    wrapped("No joint is known for the axis %s, which %s needs: the kinematics are %s. If a joint of its own drives "
                            "each of these axes, name them: --joints %s."
                            % (" and ".join(lacking), function.name, kinematics,
                               ",".join("%s=%d" % (letter, number) for number, letter in enumerate(function.axes))
                               if len(function.axes) > 1 else function.axes[0] + "=2"))
                )

    def look(self, ini, joints, folder, name="look"):
        files = list(hal_text.halfiles(ini, self.home))
        os.makedirs(os.path.join(folder, name))
        if self.needs_halui and not ini.get("HAL", "HALUI"):
            ini.set("HAL", "HALUI", "halui")
        postgui = [os.path.join(self.home, value.split()[0]) for value in ini.all("HAL", "POSTGUI_HALFILE")]
        postgui = [path for path in postgui if os.path.isfile(path) and not path.endswith(".tcl")]
        written = ini.copy()
        for turn in range(ATTEMPTS):
            ini = written.copy()
            self.trial = Trial(ini, os.path.join(folder, name, str(turn)), plumb_program())
            self.stand_ins = StandIns(self.trial, ini, files, self.learnt)
            marker = self.snapshot(self.trial, ini)
            try:
                found = self.trial.run("look", postgui=postgui)
                break
            except NotStarted as error:
                if not self.stand_ins.learn(str(error)):
                    raise Impossible("Your configuration does not start here, without anything of Plumb:\n%s" % error) from None
        else:
            raise Impossible("Your configuration does not start here: no pins could stand in for its drivers.")
        texts = {}
        for what in found["started"]:
            with open(os.path.join(self.trial.copy, marker + what), encoding="utf-8") as file:
                texts[what] = file.read()
        machine = Machine(State(texts), State(found["postgui"]), joints, written, files)
        if machine.thread is None:
            raise Impossible("No thread of this configuration runs motion-controller.")
        return machine, found

    def snapshot(self, trial, ini):
        """A last HALFILE that notes the HAL. Returns where, in the copy."""
        lines = ["if {[info procs ::tp::passnumber] ne \"\" && [::tp::passnumber] == 0} return"]
        for what in ("comp", "pin", "sig", "param", "thread"):
            lines.append("exec halcmd -s show %s > %s" % (what, os.path.join(self.home, ".plumb-wire", "show-" + what)))
        ini.add("HAL", "HALFILE", trial.write(".plumb-wire/show.tcl", "\n".join(lines) + "\n"))
        return ".plumb-wire/show-"

    def join(self, machine):
        return Wiring(self.functions, machine, self.folder, self.kept_values())

    def look_with_outputs(self, wiring, joints, folder):
        """Again, with as many outputs of motmod as the functions need."""
        self.motmod = dict(wiring.motmod)
        ini = self.fresh_ini()
        self.add_outputs(ini)
        machine, _ = self.look(ini, joints, folder, "look-again")
        again = self.join(machine)
        if again.motmod:
            wanted = " ".join("%s=%d" % item for item in self.motmod.items())
            raise Impossible(
                wrapped("motmod has too few outputs: add %s to the line that loads it%s." % (wanted, machine.at("motmod")), "- ")
            )
        return machine, again

    def add_outputs(self, ini):
        """Into [EMCMOT]EMCMOT, which the line that loads motmod names in most configurations."""
        if self.motmod:
            value = ini.get("EMCMOT", "EMCMOT") or "motmod"
            for option, number in self.motmod.items():
                value = re.sub(r"\s*\b%s=\d+" % option, "", value) + " %s=%d" % (option, number)
            ini.set("EMCMOT", "EMCMOT", value)

    def describe(self, machine, found):
        """What was met while reading."""
        if self.stand_ins.drivers:
            print(wrapped("These drivers need hardware. Pins stand in for them here: %s." % ", ".join(self.stand_ins.drivers), "  "))
        if self.stand_ins.programs:
            print(wrapped("These programs need a screen or a device. Pins stand in for them here: %s."
                          % ", ".join(self.stand_ins.programs), "  "))

    # --- what is written ---

    def kept_values(self):
        """[SECTION]NAME -> value, of the plumb.inc that is there."""
        path = os.path.join(self.output, "plumb.inc")
        values = {}
        if os.path.exists(path):
            old = IniFile(path)
            for function in self.functions:
                for section, names in function.ini.items():
                    for name in names:
                        values[section, name] = old.get(section, name)
        return values

    def files(self, wiring):
        """Text by name, in the order in which the HAL files are loaded."""
        hal = {"stages.hal": wiring.stages_hal()}
        for function in self.functions:
            hal[function.name + ".hal"] = wiring.function_hal(function)
            hal[function.name + "_settings.hal"] = wiring.settings_hal(function)
        files = {"plumb.hal": wiring.plumb_hal(hal)}
        files.update({name: text for name, text in hal.items() if not wiring.machine.twopass or name.endswith("_settings.hal")})
        files["messages.toml"] = wiring.messages_toml()
        files["plumb.inc"] = self.inc(wiring)
        records = [name for function in self.functions for name in function.records]
        if records:
            machine = (wiring.machine.ini.get("EMC", "MACHINE") or "machine").replace('"', "'")
            files["retain.toml"] = (
                "# SPDX-License-Identifier: GPL-2.0-or-later\n# Written by plumb wire: what retain keeps over a restart, in "
                "retain.retained beside this file.\nmachine = \"%s\"\nrecords = [%s]\n"
                % (machine, ", ".join('"%s"' % name for name in records))
            )
        for function in self.functions:
            files.update({name: function.text(name) for name in function.subroutines})
        aborts = [function.abort for function in self.functions if function.abort]
        if aborts:
            calls = "".join("o<%s> call\n" % name for name in aborts)
            files[ABORT + ".ngc"] = (
                "; SPDX-License-Identifier: GPL-2.0-or-later\n; Written by plumb wire for ON_ABORT_COMMAND.\n"
                "o<%s> sub\n%so<%s> endsub\nM2\n" % (ABORT, calls, ABORT)
            )
        self.ini_changes = self.changed_ini(wiring)
        files["ini.patch"] = self.ini_changes.patch()
        return files

    def inc(self, wiring):
        """Sections of our own, and those that the INI file does not have: LinuxCNC reads only the first of a name."""
        kept = self.kept_values()
        lines = ["# SPDX-License-Identifier: GPL-2.0-or-later", "# Values of the functions that plumb wire put in."]
        for function in self.functions:
            for section, values in function.ini.items():
                lines += ["", "[%s]" % section]
                lines += ["%s = %s" % (name, kept.get((section, name)) or value) for name, value in values.items()]
        return "\n".join(lines) + "\n"

    def changed_ini(self, wiring):
        """The INI file with all lines that put the functions in."""
        ini = self.fresh_ini()
        self.added = []

        def note(section, name, value, add=False):
            if add or ini.get(section, name) != value:
                (ini.add if add else ini.set)(section, name, value)
                self.added.append((section, name, value))

        note("HAL", "HALFILE", self.halfile, add=True)
        if self.needs_halui and not ini.get("HAL", "HALUI"):
            note("HAL", "HALUI", "halui")
        for function in self.functions:
            for letter in function.axis_offset:
                if not ini.get("AXIS_" + letter, "OFFSET_AV_RATIO"):
                    note("AXIS_" + letter, "OFFSET_AV_RATIO", OFFSET_RATIO)
        if any(function.subroutines for function in self.functions):
            path = ini.get("RS274NGC", "SUBROUTINE_PATH")
            if self.folder not in (path or "").split(":"):
                note("RS274NGC", "SUBROUTINE_PATH", path + ":" + self.folder if path else self.folder)
        if any(function.abort for function in self.functions) and not ini.get("RS274NGC", "ON_ABORT_COMMAND"):
            note("RS274NGC", "ON_ABORT_COMMAND", "O <%s> call" % ABORT)
        if self.motmod:
            self.add_outputs(ini)
            self.added.append(("EMCMOT", "EMCMOT", ini.get("EMCMOT", "EMCMOT")))
        if any(function.ini for function in self.functions):
            ini.include(self.include)
        return ini

    # --- trying ---

    def try_it(self, wiring, machine, files, folder):
        os.makedirs(os.path.join(folder, "try"))
        ini = self.changed_ini(wiring)
        trial = Trial(ini, os.path.join(folder, "try"), plumb_program())
        self.release(machine)
        stand_ins = StandIns(trial, ini, machine.files, self.learnt)
        for name, text in files.items():
            trial.write(os.path.join(self.folder, name), self.kept_text(name) or text)
        checks = {function.name: function.check for function in self.functions if function.check}
        for function in self.functions:
            if function.check_hal:
                name = os.path.join(self.folder, function.name + "_check.hal")
                with open(function.check_hal, encoding="utf-8") as file:
                    trial.write(name, renamed(file.read(), wiring, machine))
                ini.add("HAL", "HALFILE", name)
        self.drive(trial, ini, machine, stand_ins)
        settings = dict(unit=machine.unit, names=wiring.names, axes=machine.axes, checks=checks)
        found = trial.run("check", **settings)
        if found["overdue"]:  # a busy computer can upset LinuxCNC's programs on the faster clock
            found = trial.run("check", **settings)
        return found["seen"], found["messages"]

    def without_plumb(self, machine, steps, folder):
        """Whether the machine fails by itself, where it did not come through the first steps."""
        if steps > BASIC_STEPS:
            return ""
        ini = self.fresh_ini()
        trial = Trial(ini, os.path.join(folder, "bare"), plumb_program())
        stand_ins = StandIns(trial, ini, machine.files, self.learnt)
        self.drive(trial, ini, machine, stand_ins)
        try:
            seen = trial.run("check", unit=machine.unit, names={}, axes=machine.axes, checks={})["seen"]
        except NotStarted:
            return " Your configuration does not start either when Plumb is left out."
        failed = [statement for statement, holds in seen if not holds]
        return " The same machine without Plumb fails too: %s." % failed[0] if failed else " Without Plumb it works."

    def release(self, machine):
        """What the hardware must say for the machine to turn on, and for the spindle to be at speed."""
        outputs = self.stand_ins.outputs()
        wanted = [name for name in machine.complete.pins if name.endswith(("emc-enable-in", ".ok-in", ".at-speed"))]
        for name in wanted:
            signal = machine.complete.signals.get(machine.complete.signal_of(name))
            if signal and signal.writer in outputs:
                self.learnt.setdefault("true", []).append(signal.writer)

    def drive(self, trial, ini, machine, stand_ins):
        """Lets joints whose feedback comes from hardware follow their commands, and home where they stand."""
        outputs, lines, drives = stand_ins.outputs(), [], []
        if not outputs:
            return
        module, pin, settings = next(follower for follower in FOLLOWERS if follower[0] not in machine.complete.components)
        for joint in sorted({joint for numbers in machine.joints.values() for joint in numbers}):
            if ini.get("JOINT_%d" % joint, "HOME_SEARCH_VEL"):
                for name in ("HOME_SEARCH_VEL", "HOME_LATCH_VEL", "HOME_USE_INDEX"):
                    ini.set("JOINT_%d" % joint, name, "0")
            command, feedback = (machine.halfiles.signal_of("joint.%d.%s" % (joint, name)) for name in ("motor-pos-cmd", "motor-pos-fb"))
            writer = feedback and machine.halfiles.signals[feedback].writer
            if writer in outputs and command:
                name = "plumb-drive-%d" % joint
                lines += ["unlinkp " + writer, "net %s => %s.%s" % (command, name, pin), "net %s %s.out" % (feedback, name)]
                lines += ["setp %s.%s %g" % (name, *setting) for setting in settings]
                lines += ["addf %s %s" % (name, machine.thread)]
                drives.append(name)
        if lines:
            lines.insert(0, "loadrt %s names=%s" % (module, ",".join(drives)))
            trial.write(".plumb-wire/drives.hal", "\n".join(lines) + "\n")
            ini.add("HAL", "HALFILE", ".plumb-wire/drives.hal")

    # --- the folder ---

    def _read_manifest(self):
        path = os.path.join(self.output, MANIFEST)
        with contextlib.suppress(OSError, ValueError):
            with open(path, encoding="utf-8") as file:
                manifest = json.load(file)
            if manifest["ini"] != os.path.basename(self.ini_path):
                raise Impossible("%s belongs to %s. Name another folder by --output." % (self.output, manifest["ini"]))
            return manifest
        if os.path.isdir(self.output) and os.listdir(self.output):
            raise Impossible(
                wrapped("%s exists, and plumb wire did not write it: it has %s. Name another folder by --output."
                        % (self.output, ", ".join(sorted(os.listdir(self.output))[:5])))
            )
        if os.path.exists(self.output) and not os.path.isdir(self.output):
            raise Impossible("%s is a file. Name another folder by --output." % self.output)
        return {}

    def kept_text(self, name):
        """The text of a file of settings that the user has changed, or None."""
        if not name.endswith("_settings.hal"):
            return None
        text = self.present(name)
        return text if text is not None and digest(text) != self.manifest.get("files", {}).get(name) else None

    def present(self, name):
        with contextlib.suppress(FileNotFoundError):
            with open(os.path.join(self.output, name), encoding="utf-8", errors="surrogateescape") as file:
                return file.read()
        return None

    def forbid_strangers(self, files):
        changed = []
        for name, text in files.items():
            there = self.present(name)
            is_ours = there is not None and digest(there) == self.manifest.get("files", {}).get(name)
            if there is not None and not is_ours and there != text and not name.endswith(("_settings.hal", ".inc")):
                changed.append(name)
        if changed:
            raise Impossible(
                wrapped("Somebody changed %s in %s after plumb wire wrote it. Move the changes into a HALFILE of your own, "
                        "behind plumb.hal, and remove the file; then wire again." % (", ".join(changed), self.output))
            )

    def write(self, files):
        """Each file at once, whole or not at all."""
        os.makedirs(self.output, exist_ok=True)
        self.kept = []
        written = {}
        for name, text in files.items():
            if self.kept_text(name) is not None:
                self.kept.append(name)
                written[name] = self.manifest.get("files", {}).get(name, "")
            else:
                write_whole(os.path.join(self.output, name), text)
                written[name] = digest(text)
        manifest = {"ini": os.path.basename(self.ini_path), "functions": [function.name for function in self.functions], "files": written}
        write_whole(os.path.join(self.output, MANIFEST), json.dumps(manifest, indent=1) + "\n")

    # --- telling ---

    def tell(self, wiring, files):
        ini_name = os.path.basename(self.ini_path)
        print("\nWritten into %s" % self.output)
        for name in files:
            print("  %s%s" % (name, "  (yours, not written)" if name in self.kept else ""))
        if files["ini.patch"]:
            print("\nAdd to %s, each line in its section, or run this in %s" % (ini_name, self.home))
            print("  patch -p1 < %s/ini.patch       # patch -R -p1 < %s/ini.patch undoes it\n" % (self.folder, self.folder))
            present = IniFile(self.ini_path)
            for section, name, value in self.added:
                if value not in present.all(section, name):
                    print("  [%s]  %s = %s" % (section, name, value))
            if any(function.ini for function in self.functions) and not present.includes(self.include):
                print("  last line   #INCLUDE %s" % self.include)
        else:
            print("\n%s has the lines that put them in." % ini_name)
        for note in wiring.notes:
            print(wrapped(note, "  "))
        missing = self.missing(wiring)
        if missing:
            print("\nStill missing")
            for number, text in enumerate(missing, start=1):
                print(wrapped(text, "  %d. " % number))

    def missing(self, wiring):
        found = []
        for function in self.functions:
            kept = self.kept_values()
            values = {name: kept.get((section, name)) or value for section, names in function.ini.items() for name, value in names.items()}
            for part in function.missing:
                signal = part.get("signal")
                state = wiring.machine.complete
                if signal in state.signals and state.signals[signal].writer:
                    continue
                found.append(" ".join(part["text"].split()).format(folder=self.folder, **values))
        on_abort = wiring.machine.ini.get("RS274NGC", "ON_ABORT_COMMAND")
        aborts = [function.abort for function in self.functions if function.abort]
        if aborts and on_abort and ABORT not in on_abort:
            found.append("Your ON_ABORT_COMMAND is %s: add the line o<%s> call to this subroutine." % (on_abort, ABORT))
        return found


def parse_joints(text):
    joints = {}
    for part in filter(None, text.split(",")):
        found = re.fullmatch(r"\s*([XYZABCUVWxyzabcuvw])\s*=\s*(\d+)\s*", part)
        if not found:
            raise Impossible("--joints %s: '%s' is not an axis and its joint, such as X=0" % (text, part))
        joints.setdefault(found[1].upper(), []).append(int(found[2]))
    return joints


def joints_of(ini, given):
    """The joints of each axis: as given, or by the coordinates of trivkins."""
    if given:
        return given
    words = (ini.get("KINS", "KINEMATICS") or "").split()
    if not words or words[0] != "trivkins":
        return {}
    letters = next((word.split("=", 1)[1] for word in words if word.startswith("coordinates=")), "XYZABCUVW")
    count = int(ini.get("KINS", "JOINTS") or len(letters))
    coordinates = set((ini.get("TRAJ", "COORDINATES") or letters).replace(" ", "").upper())
    joints = {}
    for number, letter in enumerate(letters.upper()[:count]):
        if letter in coordinates:
            joints.setdefault(letter, []).append(number)
    return joints


def renamed(text, wiring, machine):
    """The HAL of a check with the signals of this machine."""
    lines = []
    for line in text.splitlines():
        words = line.split()
        if words and words[0] == "net":
            line = " ".join(["net", wiring.name(words[1]), *words[2:]])
        if words and words[0] == "addf":
            line = "addf %s %s %d" % (words[1], machine.thread, wiring.thread_order.index("motion-controller") + 2)
        lines.append(line)
    return "\n".join(lines) + "\n"


def plumb_program():
    beside = os.path.join(PREFIX, "bin", "plumb")
    return beside if os.access(beside, os.X_OK) else shutil.which("plumb") or "plumb"


def digest(text):
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()


def write_whole(path, text):
    new = path + ".new"
    with open(new, "w", encoding="utf-8", errors="surrogateescape") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(new, path)


def wrapped(text, indent=""):
    return textwrap.fill(text, 100, initial_indent=indent, subsequent_indent=" " * len(indent), break_long_words=False, break_on_hyphens=False)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)

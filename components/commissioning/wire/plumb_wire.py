#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Wires functions into a LinuxCNC configuration, and tries the result. See plumb-wire(1)."""

import argparse
import difflib
import os
import re
import shlex
import shutil
import signal
import sys

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
sys.path.append(os.path.join(PREFIX, "python"))  # of a build tree
sys.path[:0] = [os.path.join(PREFIX, "share", "plumb", name) for name in ("wiring", "models")]
from applying import COPY, Applied, changes  # noqa: E402
from error_tables import compensated, own_compensation, slow_turns, unsealed  # noqa: E402
import former_pins  # noqa: E402
from functions import all_functions  # noqa: E402
from ini_file import IniFile  # noqa: E402
from later_files import LaterFiles  # noqa: E402
from machine import joints_by_coordinates  # noqa: E402
from numbers_of_programs import SECTION as NUMBERS  # noqa: E402
from numbers_of_programs import Numbers, number_names, pins_of  # noqa: E402
from output import Output  # noqa: E402
from plumb_folder import TemporaryFolder  # noqa: E402
from plumb_program import run as run_program  # noqa: E402
from rotary_axes import without_joint  # noqa: E402
from stand_ins import given_pins  # noqa: E402
from texts import Impossible, wrapped  # noqa: E402
from trial import NotStarted  # noqa: E402
from trials import Trials  # noqa: E402
from wiring import Wiring  # noqa: E402
from writing import PartlyWritten  # noqa: E402

SUMMARY = "wires functions into a LinuxCNC configuration, and tries the result"
FUNCTIONS = os.path.join(PREFIX, "share", "plumb", "functions")
OFFSET_RATIO = "0.2"
INI_VERSION = "1.1"  # without which LinuxCNC does not start
ABORT = "plumb_abort"
TABS = {"axis": "ntb_preview", "gmoccapy": "ntb_preview", "qtdragon": "stackedWidget_mainTab"}  # place of a tab, by the screen


def main():
    parser = argparse.ArgumentParser(prog="plumb wire", description=SUMMARY[0].upper() + SUMMARY[1:] + ".")
    parser.add_argument("--summary", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("functions", nargs="*", metavar="FUNCTION", help="such as squareness")
    parser.add_argument("--ini", metavar="FILE.ini", help="INI file of the machine")
    parser.add_argument("--output", metavar="DIR", help="folder for the files; the default is plumb beside the INI file")
    parser.add_argument(
        "--joints", metavar="X=0,...", default="", help="joints of the axes, where the kinematics do not show them"
    )
    parser.add_argument(
        "--stand-in",
        metavar="NAME=FILE",
        action="append",
        default=[],
        help="pins of a driver or program that is not here: rows of `halcmd -s show pin`, or PIN TYPE DIRECTION",
    )
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--apply", action="store_true", help="edit the INI file, too; a copy stays beside it")
    action.add_argument("--undo", action="store_true", help="give the INI file back as it was before --apply")
    action.add_argument("--remove", action="store_true", help="take these functions out of the machine")
    action.add_argument("--check", action="store_true", help="report what an upgrade of Plumb or an edit of the machine changed")
    parser.add_argument("--version", action="version", version="plumb @PROJECT_VERSION@")
    arguments = parser.parse_args()
    sys.stdout.reconfigure(errors="backslashreplace")  # names of files need not be text
    if arguments.summary:
        print(SUMMARY)
        return 0
    known = all_functions(FUNCTIONS)
    wrong = [name for name in arguments.functions if name not in known]
    if wrong or not (arguments.functions or arguments.undo or arguments.check):
        return refuse(unknown(wrong, known))
    if arguments.functions and (arguments.undo or arguments.check):
        return refuse("--undo and --check take no function: they are for all that is wired")
    if not arguments.ini:
        return refuse("give the INI file of your machine: --ini my.ini")
    if not os.path.isfile(arguments.ini):
        return refuse("cannot read %s: there is no such file" % arguments.ini)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    try:
        wire = Wire([known[name] for name in dict.fromkeys(arguments.functions)], arguments, known)
        if arguments.undo or (arguments.remove and not wire.functions):
            return wire.undo()
        if arguments.check:
            return wire.check()
        wire.run()
    except BrokenPipeError:
        raise
    except PartlyWritten as error:
        print("plumb wire: some files are new and some are not: wire again.\n\n%s" % in_words(error.cause), file=sys.stderr)
        return 1
    except (Impossible, NotStarted, OSError) as error:
        print("plumb wire: nothing was written.\n\n%s" % in_words(error), file=sys.stderr)
        return 1
    try:
        if arguments.apply or arguments.remove:
            wire.apply()
        wire.tell()
    except (Impossible, OSError) as error:
        if isinstance(error, OSError) and not error.filename:  # of the output
            raise
        print("plumb wire: all files of its folder were written.\n\n%s" % in_words(error), file=sys.stderr)
        return 1
    return 0


def refuse(sentence):
    print("plumb wire: " + sentence, file=sys.stderr)
    return 2


def in_words(error):
    if not isinstance(error, OSError) or not error.filename:
        return error
    return "%s: %s" % (error.filename2 or error.filename, error.strerror)


def unknown(wrong, known):
    listed = "".join("\n  %-22s %s" % (function.name, function.summary) for function in known.values())
    if not wrong:
        return "name the functions to wire. There are" + listed
    close = difflib.get_close_matches(wrong[0], known, 1)
    return "there is no function '%s'%s There are%s" % (wrong[0], "; is it %s?" % close[0] if close else ".", listed)


class Wire:
    """One INI file, and the functions that are to be in it: the present ones and the new ones."""

    def __init__(self, functions, arguments, known):
        self.ini_path = os.path.abspath(arguments.ini)
        self.home = os.path.dirname(self.ini_path)
        folder = os.path.abspath(arguments.output or os.path.join(self.home, "plumb"))
        self.folder = os.path.relpath(folder, self.home)
        if self.folder.startswith("..") or self.folder == ".":
            raise Impossible("--output %s must be a folder below the folder of the INI file, %s" % (folder, self.home))
        odd = re.search(r"[^\w./+-]", self.folder)
        if odd:
            sentence = "--output %r has %s in its name. LinuxCNC reads this name in HAL lines: use letters, digits, - and _."
            raise Impossible(wrapped(sentence % (self.folder, character(odd[0]))))
        self.output = Output(folder, self.home, os.path.basename(self.ini_path), "@PROJECT_VERSION@")
        self.applied = Applied(folder, self.home, self.ini_path)
        self.later = LaterFiles(folder)
        if arguments.apply or arguments.remove:
            self.applied.forbid_running()
        self.functions = self._numbered(functions, known, arguments.remove)
        self.reserved = {pin for function in known.values() for _, pin in pins_of(function)}  # of programs of all functions
        self.numbers = None
        self.given_joints = parse_joints(arguments.joints)
        self.given_pins = given_pins(dict(map(named_file, arguments.stand_in)))
        self.needs_halui = any(function.needs_halui for function in self.functions)
        self.motmod = {}  # options that motmod lacks
        self.output_keys = {}  # (section, name) of INI values that give these options
        self.added = []  # (section, name, value) of the INI file
        self.written = None
        self.inline = forbid_names(self.ini_path, self.fresh_ini())
        if " " in self.home and any(function.subroutines for function in self.functions):
            names = ", ".join(function.name for function in self.functions if function.subroutines)
            sentence = "LinuxCNC opens no subroutine in a path with a blank, and %s has some: rename %s."
            raise Impossible(wrapped(sentence % (names, self.home)))

    def _numbered(self, functions, known, remove):
        """The functions of before and the new ones, or the rest of them. A function keeps its number at interlock; a new one
        has the first that is free."""
        slots = [known.get(name) for name in self.output.functions]
        if remove:
            absent = [function.name for function in functions if function not in slots]
            if absent:
                raise Impossible("%s is not wired in %s." % (absent[0], self.output.folder))
            slots = [None if function in functions else function for function in slots]
        else:
            for function in functions:
                if function not in slots:
                    free = slots.index(None) if None in slots else len(slots)
                    slots[free : free + 1] = [function]
        for number, function in enumerate(slots):
            if function:
                function.number = number
        return list(filter(None, slots))

    def run(self):
        ini = self.fresh_ini()
        if ini.get("EMC", "VERSION") != INI_VERSION:
            sentence = "%s is an INI file of LinuxCNC 2.7 or before: its [EMC]VERSION is not %s. LinuxCNC converts it: update_ini %s"
            raise Impossible(wrapped(sentence % (os.path.basename(self.ini_path), INI_VERSION, shlex.quote(self.ini_path))))
        joints = self.given_joints or joints_by_coordinates(ini)
        self.check_axes(joints, ini)
        self.check_codes(ini)
        print("Reading %s" % os.path.basename(self.ini_path), flush=True)
        with TemporaryFolder() as folder:
            trials = Trials(self.home, folder, plumb_program(), self.given_pins, self.later)
            wiring = self.joined(trials, joints)
            self.tell_stand_ins(trials.stand_ins)
            files = self.files(wiring)
            self.output.forbid_strangers(files)
            print("Trying it on a copy", flush=True)
            self.try_it(trials, wiring, files)
        self.output.write(files, self.functions)
        self.written = wiring, files

    def joined(self, trials, joints):
        wiring = self.read(trials, joints)
        problems = [*wiring.problems, *compensated(wiring.machine, self.home)]
        if problems:
            raise Impossible("\n".join(wrapped(problem, "- ") for problem in dict.fromkeys(problems)))
        return wiring

    # --- what --apply, --undo and --check do ---

    def apply(self):
        """Edits the INI file and the files that it includes."""
        ini = self.changed_ini()
        outside = ini.outside()
        if outside:
            sentence = "%s lies outside %s, and plumb wire does not edit it: add its lines by hand."
            raise Impossible(wrapped(sentence % (outside[0], self.home)))
        texts = {path: (ini.before[path], ini.text(path)) for path in ini.texts}
        self.applied.apply(texts)
        for path, (before, after) in texts.items():
            if before != after:
                name = os.path.relpath(path, self.home)
                print("\nChanged %s; %s is the file as it was" % (name, name + COPY))
                print("\n".join("  " + line for line in changes(before, after)))
        self.tell_kept()

    def undo(self):
        """Gives the INI file back."""
        if not self.applied.files:
            sentence = "%s has no changes of plumb wire --apply. A patch is undone by patch --binary -R -p1 < %s/ini.patch."
            raise Impossible(wrapped(sentence % (os.path.basename(self.ini_path), self.folder)))
        names = self.applied.undo()
        self.output.forget()
        print("As before: %s" % ", ".join(names))
        self.tell_kept()
        print(wrapped("%s stays, with your settings, and LinuxCNC does not read it. Wire again to have the functions back." % self.folder))
        return 0

    def tell_kept(self):
        for note in dict.fromkeys(self.applied.notes):
            print(wrapped(note, "  "))

    def check(self):
        """Whether the machine and Plumb are as they were when the functions were wired."""
        former = former_pins.rows(IniFile(self.ini_path), self.folder)
        if former:  # LinuxCNC loads no such line, so no trial can begin
            print("%s: lines of an earlier Plumb" % os.path.basename(self.ini_path))
            for sentence, command in former:
                print("  " + sentence)
            for command in dict.fromkeys(command for _sentence, command in former if command):
                print("    $ " + command)
            return 1
        if not self.functions:
            raise Impossible("No function is wired in %s." % self.output.folder)
        ini = self.fresh_ini()
        with TemporaryFolder() as folder:
            trials = Trials(self.home, folder, plumb_program(), self.given_pins, self.later)
            wiring = self.joined(trials, self.given_joints or joints_by_coordinates(ini))
        files = self.files(wiring)
        found = self.output.differences(files)
        changed = self.changed_ini().changed()
        for path in changed:
            lines = changes(self.changed_ini().original[path], changed[path])
            found.append("%s lacks lines, or has others:\n%s" % (os.path.basename(path), "\n".join("    " + line for line in lines)))
        print("%s: %s" % (os.path.basename(self.ini_path), ", ".join(function.name for function in self.functions)))
        for sentence in dict.fromkeys([*found, *self.applied.notes]):
            print("  " + sentence)
        print("  Wire again, to try the machine as it is now." if found else "  Nothing has changed since they were wired.")
        return 1 if found else 0

    # --- reading ---

    @property
    def halfile(self):
        return self.folder + "/plumb.hal"

    @property
    def order(self):
        return self.folder + "/order.tcl"

    @property
    def include(self):
        return self.folder + "/plumb.inc"

    def fresh_ini(self):
        """The INI file without the lines that put our files in."""
        ini = IniFile(self.ini_path, self.applied.without)
        for name in (self.halfile, self.order):
            ini.drop("HAL", "HALFILE", lambda value, name=name: value.split()[:1] in ([name], ["./" + name]))
        ini.drop_include(self.include)
        ini.drop("RS274NGC", "REMAP", self.is_former)
        return ini

    def first_later(self, ini):
        """The place of the first HALFILE of the user that uses something of ours, and so comes behind our own."""
        places = {}
        for place in ini.named("HAL", "HALFILE"):
            words = place.text.split("=", 1)[1].split()
            path = os.path.join(self.home, words[0]) if words else ""
            if os.path.isfile(path) and words[0] not in (self.halfile, self.order):
                places[path] = place
        return places.get(self.later.first(places, self.home))

    def is_former(self, remap):
        """Whether an earlier version of ours has written this value of REMAP: our code and our subroutine, with other words."""
        code, *options = remap.split() or [""]
        ours = [value for function in self.functions for value in function.remap]
        return remap not in ours and any(value.split()[0] == code and value.split()[-1] in options for value in ours)

    def check_axes(self, joints, ini):
        letters = (ini.get("TRAJ", "COORDINATES") or "").replace(" ", "").upper()
        for function in self.functions:
            lacking = function.lacks([letter for letter in function.axes if joints.get(letter)])
            if not lacking:
                continue
            if lacking[0] not in letters:
                sentence = "%s needs the axis %s, and this machine has %s: [TRAJ]COORDINATES in %s."
                which = (function.name, " and ".join(lacking), " ".join(letters) or "none", self.ini_path)
                raise Impossible(wrapped(sentence % which))
            sentence = (
                "No joint is known for the axis %s, which %s needs: the kinematics are %s. If a joint of its own drives each "
                "of these axes, name them: --joints %s."
            )
            example = ",".join("%s=%d" % (letter, letters.index(letter)) for letter in function.axes if letter in letters)
            kinematics = ini.get("KINS", "KINEMATICS") or "none"
            lacking = " and ".join(letter for letter in lacking if letter in letters)
            raise Impossible(wrapped(sentence % (lacking, function.name, kinematics, example)))

    def check_codes(self, ini):
        """No code of a function has a REMAP of the user."""
        for function in self.functions:
            for place in ini.named("RS274NGC", "REMAP"):
                theirs = place.text.split("=", 1)[1].split("#")[0].strip()
                for value in function.remap:
                    if theirs.split()[:1] == value.split()[:1] and theirs != value:
                        sentence = (
                            "%s is in use: %s:%d remaps it by %r, and %s needs it. LinuxCNC takes a code once: give yours "
                            "another number, or remove this line."
                        )
                        which = (value.split()[0], os.path.basename(place.path), place.line + 1, theirs, function.name)
                        raise Impossible(wrapped(sentence % which))

    def read(self, trials, joints):
        """The functions joined to the machine, if necessary with more outputs of motmod."""
        wiring = self.join(trials, joints, "look")
        if wiring.motmod:
            self.motmod, self.output_keys = dict(wiring.motmod), wiring.machine.output_keys()
            wiring = self.join(trials, joints, "look-again")
            if wiring.motmod:
                wanted = " ".join("%s=%d" % item for item in self.motmod.items())
                sentence = "motmod has too few outputs: add %s to the line that loads it%s."
                raise Impossible(wrapped(sentence % (wanted, wiring.machine.at("motmod"))))
        return wiring

    def join(self, trials, joints, name):
        ini = self.fresh_ini()
        self.add_outputs(ini)
        if self.needs_halui and not ini.get("HAL", "HALUI"):
            ini.set("HAL", "HALUI", "halui")
        machine = trials.look(ini, joints, name)
        written = os.path.join(self.output.folder, "plumb.inc")
        for function in self.functions:
            function.take_values(ini, *([IniFile(written)] if os.path.exists(written) else []))
        self.numbers = Numbers(self.functions, machine, self.given_numbers(), self.output.functions, self.reserved)
        return Wiring(self.functions, machine, self.folder, self.numbers)

    def given_numbers(self):
        """The numbers of an earlier time, by name."""
        path = self.ini_path if self.inline else os.path.join(self.output.folder, "plumb.inc")
        ini = IniFile(path) if os.path.exists(path) else None
        names = {name for function in self.functions for name in number_names(function)}
        return {name: ini.get(NUMBERS, name) for name in names} if ini else {}

    def add_outputs(self, ini):
        """Into the INI values that give the options to motmod, or else into [EMCMOT]EMCMOT, which the line that loads motmod
        names in most configurations. Returns the lines (section, name, value)."""
        lines = {}
        for option, number in self.motmod.items():
            if option in self.output_keys:
                lines[self.output_keys[option]] = str(number)
                continue
            key = "EMCMOT", "EMCMOT"
            value = lines.get(key) or ini.get(*key) or "motmod"
            lines[key] = re.sub(r"\s*\b%s=\d+" % option, "", value) + " %s=%d" % (option, number)
        for key, value in lines.items():
            ini.set(*key, value)
        return [(*key, value) for key, value in lines.items()]

    @staticmethod
    def tell_stand_ins(stand_ins):
        for kind, names in (
            ("drivers need hardware", [name for name in stand_ins.drivers if name not in stand_ins.learnt.get("absent", ())]),
            ("modules are not installed here or need hardware", stand_ins.learnt.get("absent")),
            ("programs need a screen or a device", stand_ins.programs),
        ):
            if names:
                print(wrapped("These %s. Pins stand in for them here: %s." % (kind, ", ".join(names)), "  "))

    # --- the files ---

    def files(self, wiring):
        """Text by name, in the order in which the HAL files are loaded."""
        hal = {"stages.hal": wiring.files.stages()}
        for function in self.functions:
            hal[function.name + ".hal"] = wiring.files.function(function)
            hal[function.name + "_settings.hal"] = wiring.files.settings(function)
        if wiring.files.retain():
            hal["retain.hal"] = wiring.files.retain()
        files = {"plumb.hal": wiring.files.plumb(hal), "order.tcl": wiring.files.order()}
        alone = [name for name in hal if not wiring.machine.twopass or name.endswith("_settings.hal")]
        files.update({name: hal[name] for name in alone})
        with open(os.path.join(FUNCTIONS, "plumb_order.tcl"), encoding="utf-8") as file:
            files["plumb_order.tcl"] = file.read()
        if not self.inline:
            files["plumb.inc"] = self.output.inc(self.sections(), self.numbers.values())
        records = [name for function in self.functions for name in function.records]
        machine = re.sub(r'[^ -~]|["\\]', " ", wiring.machine.ini.get("EMC", "MACHINE") or "").strip() or "machine"
        files["panel.toml"] = (
            "# SPDX-License-Identifier: GPL-2.0-or-later\n"
            "# Written by plumb panel: the settings that plumb-retain keeps for it.\n"
            'machine = "%s"\nbound = true\npins = []\n' % machine
        )
        files["commissioning.toml"] = (
            "# SPDX-License-Identifier: GPL-2.0-or-later\n"
            "# Written by plumb wire: with which wiring functions and stages passed plumb commission, in commissioning.retained.\n"
            'machine = "%s"\nbound = true\npins = [\n%s]\n' % (machine, "".join('    "%s",\n' % pin for pin in wiring.passed))
        )
        if records:
            files["retain.toml"] = (
                "# SPDX-License-Identifier: GPL-2.0-or-later\n"
                "# Written by plumb wire: the records that plumb-retain keeps over a restart, in retain.retained beside this file.\n"
                'machine = "%s"\nbound = true\nrecords = [%s]\n' % (machine, ", ".join('"%s"' % name for name in records))
            )
        if any(function.log for function in self.functions):
            files["growth.toml"] = (
                "# SPDX-License-Identifier: GPL-2.0-or-later\n"
                "# growth_log: the machine, and the logs of its growth tests. Name your sensors and bores here, as `man growth_log` shows.\n"
                'machine = "%s"\nfolder  = "logs"\nunit    = %g\n' % (machine.replace(",", " "), 1 / wiring.machine.unit)
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
        files["ini.patch"] = self.changed_ini().patch()
        return files

    def changed_ini(self):
        """The INI file with all lines that put the functions in."""
        ini = self.fresh_ini()
        self.added = [("HAL", "HALFILE", self.halfile), ("HAL", "HALFILE", self.order)]
        for line in self.added:
            behind = self.first_later(ini)
            if behind:
                ini.insert(behind, *line[1:])
            else:
                ini.add(*line)

        def give(section, name, value):
            ini.set(section, name, value)
            self.added.append((section, name, value))

        if self.needs_halui and not ini.get("HAL", "HALUI"):
            give("HAL", "HALUI", "halui")
        for letter in {letter for function in self.functions for letter in function.axis_offset}:
            if not ini.get("AXIS_" + letter, "OFFSET_AV_RATIO"):
                give("AXIS_" + letter, "OFFSET_AV_RATIO", OFFSET_RATIO)
        if any(function.subroutines for function in self.functions):
            path = ini.get("RS274NGC", "SUBROUTINE_PATH")
            if self.folder not in (path or "").split(":"):
                give("RS274NGC", "SUBROUTINE_PATH", path + ":" + self.folder if path else self.folder)
        if any(function.abort for function in self.functions) and not ini.get("RS274NGC", "ON_ABORT_COMMAND"):
            give("RS274NGC", "ON_ABORT_COMMAND", "O <%s> call" % ABORT)
        for function in [function for function in self.functions if function.m_codes]:
            path = ini.get("RS274NGC", "USER_M_PATH")
            if function.folder not in (path or "").split(":"):
                give("RS274NGC", "USER_M_PATH", path + ":" + function.folder if path else function.folder)
        for value in [value for function in self.functions for value in function.remap]:
            if value not in ini.all("RS274NGC", "REMAP"):
                ini.add("RS274NGC", "REMAP", value)
                self.added.append(("RS274NGC", "REMAP", value))
        self.added += self.add_outputs(ini)
        for name, value in (("ACCESS", "operator"), ("SETTINGS", self.folder + "/panel.toml")):
            if not ini.get("PLUMB", name):
                give("PLUMB", name, value)
        for name, value in self.tab(ini):
            ini.add("DISPLAY", name, value)
            self.added.append(("DISPLAY", name, value))
        if self.inline:
            for (section, name), value in self.sections().items():
                if section == NUMBERS or ini.get(section, name) is None:
                    give(section, name, value)
        elif self.sections():
            ini.include(self.include)
        return ini

    def sections(self):
        """The values of the functions' own sections, by section and name."""
        values = {
            (section, name): value
            for function in self.functions
            for section, values in function.ini.items()
            for name, value in values.items()
        }
        values.update({(NUMBERS, name): value for name, value in self.numbers.values().items()})
        return values

    @staticmethod
    def tab(ini):
        """The lines that show plumb panel in a tab of the screen; none for a screen without tabs, or with this one."""
        words = (ini.get("DISPLAY", "DISPLAY") or "").split()
        screen = next((name for name in TABS if any(name in os.path.basename(word) for word in words)), None)
        if screen is None or any("plumb-panel" in command for command in ini.all("DISPLAY", "EMBED_TAB_COMMAND")):
            return []
        location = TABS[screen] if screen != "axis" or ini.all("DISPLAY", "EMBED_TAB_LOCATION") else None
        lines = [("EMBED_TAB_NAME", "Plumb"), ("EMBED_TAB_COMMAND", "plumb-panel -x {XID}")]
        return lines + ([("EMBED_TAB_LOCATION", location)] if location else [])

    def try_it(self, trials, wiring, files):
        """On a copy; raises Impossible where it does not work."""
        texts = {
            os.path.join(self.folder, name): self.output.present(name) if self.output.is_kept(name) else text
            for name, text in files.items()
        }
        seen, messages = trials.run(self.changed_ini(), texts, wiring, self.functions)
        for statement, holds in seen:
            print("  %-4s %s" % ("ok" if holds else "NO", statement))
        if not all(holds for _, holds in seen):
            for message in messages:
                print("  LinuxCNC: " + message)
            alone = trials.without_plumb(self.fresh_ini(), wiring.machine, len(seen))
            raise Impossible("It does not work on the copy, as shown above." + alone)

    # --- telling ---

    def tell(self):
        wiring, files = self.written
        print("\nWritten into %s" % self.output.folder)
        for name in files:
            print("  %s%s" % (name, "  (yours, not written)" if name in self.output.kept else ""))
        ini_name = os.path.basename(self.ini_path)
        changed = self.changed_ini()
        if changed.changed():
            again = shlex.join(["plumb", "wire", *(function.name for function in self.functions), "--ini", ini_name, "--apply"])
            print("\nAdd to %s, each line in its section, or let plumb wire edit the file: in %s" % (ini_name, self.home))
            print("  %s       # plumb wire --ini %s --undo gives it back\n" % (again, shlex.quote(ini_name)))
            present = IniFile(self.ini_path)
            for section, name, value in self.added:
                if value not in present.all(section, name):
                    print("  [%s]  %s = %s" % (section, name, value))
            if not self.inline and self.sections() and not present.includes(self.include):
                print("  last line   #INCLUDE %s" % self.include)
            for path in changed.outside():
                print(wrapped("%s lies outside this folder, and ini.patch leaves it alone: add its lines by hand." % path, "  "))
        else:
            print("\n%s has the lines that put them in." % ini_name)
        machine = wiring.machine
        notes = wiring.notes + unsealed(machine.ini, machine.files, self.home)
        for note in [*notes, *own_compensation(machine, self.home), *slow_turns(machine, self.home), *without_joint(machine)]:
            print(wrapped(note, "  "))
        missing = self.missing(wiring)
        if missing:
            print("\nStill missing")
            for number, text in enumerate(missing, start=1):
                print(wrapped(text, "  %d. " % number))

    def missing(self, wiring):
        machine, ini = wiring.machine, self.changed_ini()
        names = {name: ini.get(section, name) or value for (section, name), value in self.sections().items()}
        names["values"] = os.path.basename(self.ini_path) if self.inline else self.include
        switches = " ".join("`setp %s 1` (%s)" % (wiring.switch_of(function), function.name) for function in self.functions)
        name = self.functions[0].name
        found = [
            "The first power-on: nothing acts before it has passed `plumb commission %s`, which asks for an indicator." % name,
            "The switches: LinuxCNC starts with each function off. Switch it on in `plumb panel`, which keeps that, or by halcmd: "
            "%s. As a line of %s/FUNCTION_settings.hal, it is on after each start." % (switches, self.folder)
        ]
        for function in self.functions:
            for part in function.missing:
                if part.get("without") in machine.axes:
                    continue
                signal = machine.complete.signals.get(part.get("signal"))
                if not (signal and signal.writer):
                    text = self.numbers.literal(" ".join(part["text"].split()))
                    found.append(text.format(folder=self.folder, **names))
        on_abort = machine.ini.get("RS274NGC", "ON_ABORT_COMMAND")
        for name in [function.abort for function in self.functions if function.abort]:
            if on_abort and ABORT not in on_abort:
                found.append("Your ON_ABORT_COMMAND is %s: add the line o<%s> call to this subroutine." % (on_abort, name))
        return found


def forbid_names(path, ini):
    """Whether our values must stand in the INI file itself: LinuxCNC reads no line #INCLUDE of a file whose path has a blank, or
    whose lines have the ends of DOS. Tcl reads UTF-8 alone."""
    odd = re.search(r"[^\S ]|[\ud800-\udfff]", path)
    if odd:
        sentence = "The path %r has %s, and LinuxCNC cannot read an INI file there. Rename it."
        raise Impossible(wrapped(sentence % (path, character(odd[0]))))
    blank = " " in path
    dos = "\r\n" in ini.original[ini.path]
    lines = enumerate(ini.texts[ini.path], start=1)
    included = [(number, line.strip()) for number, line in lines if re.match(r"#INCLUDE\s", line)]
    if included and dos:
        sentence = (
            "%s has the line ends of DOS, and LinuxCNC does not find the file of its line %d, %r. This line gives it others: "
            "sed -i 's/\\r$//' %s"
        )
        raise Impossible(wrapped(sentence % (ini.path, *included[0], shlex.quote(ini.path))))
    if included and blank:
        sentence = "The path %r has a blank, and LinuxCNC does not find the INI file of line %d, %r, there. Rename the folder."
        raise Impossible(wrapped(sentence % (path, *included[0])))
    return blank or dos


def character(text):
    if "\ud800" <= text <= "\udfff":
        return "a byte that is not UTF-8"
    return {" ": "a blank", "\t": "a tab", "\n": "a line break"}.get(text, "the character %r" % text)


def named_file(text):
    """Name, and path and text of the file, of NAME=FILE."""
    name, equals, path = text.partition("=")
    if not (name and equals and path):
        raise Impossible("--stand-in %s is not NAME=FILE, such as lcec=pins.txt" % text)
    with open(path, encoding="utf-8", errors="replace") as file:
        return name, (path, file.read())


def parse_joints(text):
    joints = {}
    for part in filter(None, text.split(",")):
        found = re.fullmatch(r"\s*([XYZABCUVWxyzabcuvw])\s*=\s*(\d+)\s*", part)
        if not found:
            raise Impossible("--joints %s: '%s' is not an axis and its joint, such as X=0" % (text, part))
        joints.setdefault(found[1].upper(), []).append(int(found[2]))
    return joints


def plumb_program():
    beside = os.path.join(PREFIX, "bin", "plumb")
    return beside if os.access(beside, os.X_OK) else shutil.which("plumb") or "plumb"


if __name__ == "__main__":
    run_program("plumb wire", main)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Drivers that need hardware and programs that need a screen: their names, and models in their place.

A driver becomes components of the host (hal/host/models.hpp), a program stand_in.py. The pins are those that the user's
files name; types and directions come from model files, manual pages, and what is netted to a pin.
"""

import json
import os
import re
import shlex
import shutil
import sys

import hal_text
import model_parts
from driver_pages import page_of
from model_files import DIRECTIONS, TYPES, known, model_files, of_module, of_program
from texts import Impossible

HERE = os.path.dirname(os.path.realpath(__file__))

# Programs for devices; those that open a window are found by their imports.
DEVICES = re.compile(
    r"^(lcec_conf|mb2hal|\w*_vfd|vfdb|gs2_vfd|hy_gt_vfd|xhc-hb04|xhc-whb04b-6|shuttle|hal_input|thermistor|"
    r"mesambccc|pmx485|modbus\w*|hidcomp|joyhandle|hy_vfd|vfs11_vfd|hal_gpio_mcp23017|sim_pin|halscope|halmeter|halshow)$"
)
WINDOWS = re.compile(r"^\s*(from|import)\s+(tkinter|Tkinter|gi|gtk|PyQt5|vismach|qtvcp|gladevcp|rs274\.OpenGLTk)\b", re.M)
SCREENS = ("pyvcp", "gladevcp", "qtvcp", "halui_screen", "hal_manualtoolchange", "panelui")

FLOAT, BIT, S32, U32 = "float", "bit", "s32", "u32"
LIKE_A_BIT = re.compile(
    r"enable|fault|limit|home|-in(-not)?$|-out(-not)?$|led|button|switch|open|clos|lock|flood|mist|stop|ready|\bon$|"
    r"change|probe|brake|\b(in|out)-\d+(-not)?$",
    re.I,
)
# A module that is not installed here, or that looks for its hardware in vain.
ABSENT = re.compile(
    r"\b([\w-]+): (?:dlopen: .*cannot open shared object file|rtapi_app_main: "
    r"(?:No such device|Operation not permitted|No such file|Permission denied|Input/output error|Device or resource busy))"
)


class StandIns:
    """Stand-ins for the `drivers` and `programs` of a machine. `learnt` goes from one trial to the next.

    trial      takes files: write(), program(), place(), can_place(), path(), list_models(); loads modules: pins_of_modules()
    follows    feedback of a joint follows its command in the period, with any drive
    """

    def __init__(self, trial, ini, files, learnt=None, follows=True):
        self.drivers, self.programs, self.misses = [], [], {}
        self.models = {}  # by their modules
        self.files = model_files(ini.folder)
        self.learnt = {} if learnt is None else learnt  # name -> type or direction that LinuxCNC wanted
        self.trial, self.ini, self.described, self.numbers = trial, ini, {}, {}
        self.pages = []  # the beginning of a pin's name, the page that can have the pin, and how names begin there if otherwise
        trial.read.update(files)
        self.texts = {path: self._read(path) for path in files}
        commands = "\n".join(ini.all("HAL", "HALCMD"))
        self.all = self._values("\n".join([*self.texts.values(), commands]))
        self.nets = hal_text.nets_of(self.all)
        self._stand_in_for_drivers()
        self._stand_in_for_programs()
        model_parts.add(self.models, self.files, self.nets, ini, self.all, follows)
        self.list = trial.list_models(self.models)

    def _read(self, path):
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            return file.read()

    def _values(self, text):
        def value(found):
            return self.ini.get(found[1], found[2] or found[3]) or found[0]

        return hal_text.VALUE.sub(value, re.sub(r"\\\n", " ", text))

    def pins_behind(self, prefix):
        """Type and direction of each pin that the HAL files name behind a prefix."""
        found = {}
        for name in sorted(set(re.findall(r"(?<![\w.-])%s\.[\w.+-]+" % re.escape(prefix), self.all))):
            function = re.sub(r"\.(time|tmax|tmax-increased)$", "", name)  # each function has these pins
            if not re.search(r"^\s*(addf|delf)\s+%s\s" % re.escape(function), self.all, re.M):
                found[name[len(prefix) + 1 :]] = self._kind(name)
        return found

    def _kind(self, name):
        kind, direction = self._guess(name)
        return [self.learnt.get(name, kind), self.learnt.get("direction of " + name, direction)]

    def _on_page(self, name):
        """Type and direction of a pin in the manual page of its driver."""
        pages = ((page, re.sub(head, other, name, count=1) if other else name) for head, page, other in self.pages if re.match(head, name))
        return next(filter(None, (page_of(page).kind(there) for page, there in pages)), [None, None])

    def _told(self, name):
        """Type and direction of a pin, as far as its module, LinuxCNC and their pages give them."""
        return self.learnt.get("real", {}).get(name) or known(self.files, name) or self._on_page(name)

    def _guess(self, name):
        told = self._told(name)
        return [given or used for given, used in zip(told, self._by_use(name))] if None in told else told

    def _by_use(self, name):
        """Type and direction of a pin by the signals and values that the user's files give it."""
        others, is_source, likely = [], False, known(self.files, name, likely=True) or [None, None]
        for pins, sources in self.nets.values():
            if name in pins:
                others += [kind for kind in map(self._told, pins) if None not in kind]
                is_source = is_source or name in sources
        value = re.search(r"^\s*(?:HALCMD\s*=\s*)?setp\s+%s\s+(\S+)" % re.escape(name), self.all, re.M)
        if others:
            kind = others[0][0]
        elif value:
            kind = likely[0] or (BIT if value[1].lower() in ("0", "1", "true", "false") else FLOAT)
        else:
            kind = likely[0] or (BIT if LIKE_A_BIT.search(name) else FLOAT)
        if any(direction == "IO" for _, direction in others):
            return [kind, "IO"]
        has_writer = any(direction == "OUT" for _, direction in others)
        reads = any(direction == "IN" for _, direction in others)
        return [kind, "IN" if has_writer or not (is_source or reads) else "OUT"]

    def _stand_in_for_drivers(self):
        lines = {}
        for found in re.finditer(r"^[ \t]*(?:hal[ \t]+)?loadrt[ \t]+(\S+).*$", self.all, re.M):
            module = found[1]
            if of_module(self.files, module) or any(module in self.learnt.get(kind, ()) for kind in ("given", "absent")):
                lines.setdefault(module, found[0].strip())
        self.drivers += lines
        self._learn_components()
        if not self.drivers:
            return
        by_module = {module: of_module(self.files, module) for module in self.drivers}
        self._load(line for module, line in lines.items() if not by_module[module] or by_module[module].without_hardware)
        for module, file in by_module.items():
            head = file.head(module) if file else module
            pages = (module, *(file.pages if file else ()))
            self.pages += [(r"%s(\.\d+)?\." % head, name, None) for name in pages]
        described = []
        for module, file in by_module.items():
            named = re.search(r"\bnames=(\S+)", lines[module])  # instances have names of their own
            names = [file.head(module) if file else re.sub("[-_]", "[-_]", module)]
            names += map(re.escape, named[1].split(",") if named else ())
            prefix = r"(?<![\w.-])((?:%s)(?:\.\d+)?)\.(?=\w)" % "|".join(names)
            heads = [head for head in sorted(set(re.findall(prefix, self.all))) if head not in described]
            described += heads
            pins, functions = {}, []
            for head in heads:
                pins.update({head + "." + name: kind for name, kind in self.pins_behind(head).items()})
                added = sorted(set(re.findall(r"^\s*(?:hal\s+)?addf\s+(%s(?:\.\S+)?)(?=\s)" % re.escape(head), self.all, re.M)))
                functions += [name for name in added if name not in functions]  # parport.0.read is one of parport, too
            self.described[module] = list(pins)
            rows = [[name, *kind, 1 if self._is_true(name, kind) else 0] for name, kind in pins.items()]
            self.models[module] = {"pins": rows, "functions": functions, "parts": []}
            if file and file.misses:
                self.misses[module] = file.misses

    def _learn_components(self):
        """The pages of LinuxCNC's components: a pin of a driver has the type of the pin that it is netted to."""
        for found in re.finditer(r"^[ \t]*(?:hal[ \t]+)?loadrt[ \t]+([\w-]+)(.*)$", self.all, re.M):
            if found[1] not in self.drivers:
                named = re.search(r"\bnames=(\S+)", found[2])
                head = re.sub("[-_]", "[-_]", found[1]) + r"\.\d+"
                names = map(re.escape, named[1].strip("\"'").split(",")) if named else [head]
                self.pages += [("^%s\\." % name, found[1], found[1].replace("_", "-") + ".0.") for name in names]

    def _load(self, lines):
        """Learns the pins of drivers that can be loaded without their hardware."""
        lines = list(lines)
        if lines and self.learnt.get("loaded") != lines:
            rows = (row.split() for row in self.trial.pins_of_modules(lines).splitlines())
            self.learnt["real"] = {words[4]: [words[1], DIRECTIONS[words[2]]] for words in rows if len(words) > 4 and words[2] in DIRECTIONS}
            self.learnt["loaded"] = lines

    def _stand_in_for_programs(self):
        for line in self.all.splitlines():
            words = line.split("#")[0].split()
            if len(words) < 2 or words[0] != "loadusr":
                continue
            name, program = _program(words[1:])
            is_given = name in self.learnt.get("given", ())
            if not program or name in self.programs or not (is_given or self._cannot_run_here(program)):
                continue
            self.programs.append(name)
            self.pages.append((re.escape(name) + r"\.", os.path.basename(program), None))
            file = of_program(self.files, os.path.basename(program))
            self._describe(name, {**self.pins_behind(name), **(file.program_pins if file else {})}, file.follow if file else {})
            self._cover(name, program)
        for file in self.files:
            name = file.programs.pattern
            if file.always and name not in self.programs:
                self._describe(name, file.program_pins, file.follow)
                self._cover(name, name)

    def _cover(self, name, program):
        """Puts the stand-in where LinuxCNC will look for the program."""
        path = os.path.join(self.ini.folder, program) if "/" in program else self._installed(program)
        if path is None:
            self.trial.program("bin/" + program, *self._stand_in(name))
        elif self.trial.can_place(path):
            self.trial.place(path, script(*self._stand_in(name)), 0o777)

    def _installed(self, program):
        """The program that LinuxCNC starts by this name; it looks into a folder bin beside the INI file first."""
        return shutil.which(program, path=os.path.join(self.ini.folder, "bin") + ":" + os.environ.get("PATH", os.defpath))

    def _cannot_run_here(self, program):
        base = os.path.basename(program)
        if base in SCREENS or DEVICES.match(base) or of_program(self.files, base):
            return True
        path = os.path.join(self.ini.folder, program) if "/" in program else self._installed(program)
        path = path or os.path.join(os.path.dirname(self.trial.plumb), base)  # Plumb's own may be built and not installed
        try:
            with open(path, "rb") as file:
                text = file.read(200000)
        except (OSError, TypeError):
            return True  # it is not installed here
        return text.startswith(b"#!") and bool(WINDOWS.search(text.decode(errors="replace")))

    def _number(self, name):
        return self.numbers.setdefault(name, len(self.numbers))

    def _stand_in(self, name):
        """The words of the command that stands in. HAL may give any name: files of ours have numbers."""
        description = self.trial.path("stand-in-%d.json" % self._number(name))
        return os.path.join(HERE, "stand_in.py"), description

    def _describe(self, name, pins, follow):
        self.described[name] = [name + "." + pin for pin in pins]
        values = [pin for pin, kind in pins.items() if self._is_true(pin, kind)]
        described = {"name": name, "pins": pins, "follow": follow, "true": values}
        self.trial.write("stand-in-%d.json" % self._number(name), json.dumps(described))

    def _is_true(self, pin, kind):
        """Whether an input of the hardware is true at first. It and its inverse contradict each other."""
        for name, value in (("true", True), ("false", False)):
            if pin in self.learnt.get(name, []):
                return value
            if _inverse(pin) & set(self.learnt.get(name, [])):
                return not value
        return kind == [BIT, "OUT"] and pin.endswith(("-not", "_not"))

    def learn(self, words):
        """Takes the type or direction of a pin from LinuxCNC's complaint. Returns whether there was one."""
        found = re.search(r"Signal '([^']+)' of type '(\w+)' cannot add pin '([^']+)' of type '(\w+)'", words)
        if found:
            return self._take_type(*found.groups())
        found = ABSENT.search(words)
        if found and found[1] not in self.drivers and re.search(r"^[ \t]*loadrt[ \t]+%s\b" % re.escape(found[1]), self.all, re.M):
            self.learnt.setdefault("absent", []).append(found[1])
            return True
        found = re.search(r"pin '([^']+)' is not writable", words)
        if found and self._is_stand_in(found[1]) and self.learnt.get("direction of " + found[1]) != "IN":
            self.learnt["direction of " + found[1]] = "IN"
            return True
        found = re.search(r"type mismatch '([^']+)' <- '([^']+)'", words)
        if found and not self._is_stand_in(found[1]):
            others = [pin for pin in self.nets.get(found[2], ([],))[0] if not self._known(pin)]
            return any([self._try_next(pin) for pin in others])
        if found:
            return self._try_next(found[1])
        found = re.search(r"([\w./-]+\.hal):(\d+): value '\S+' invalid for (\w+)", words)
        if found:
            path = next((path for path in self.texts if path.endswith(os.path.basename(found[1]))), None)
            line = self._values(self.texts[path].splitlines()[int(found[2]) - 1]) if path else ""
            return len(line.split()) > 1 and self._try_next(line.split()[1])
        found = re.search(r"[Ss]ignal '([^']+)' (?:can not add OUT pin|already has output)", words)
        if found and found[1] in self.nets:
            for pin in self.nets[found[1]][0]:
                if not self._known(pin) and self.learnt.get("direction of " + pin) != "IN" and self._is_stand_in(pin):
                    self.learnt["direction of " + pin] = "IN"
                    return True
        return False

    def _take_type(self, signal, kind, pin, wanted):
        """Gives the pins that stand in on a signal the type of a pin that does not."""
        kind, wanted = kind.lower(), wanted.lower()
        others = [other for other in self.nets.get(signal, ([],))[0] if other != pin and self._is_stand_in(other)]
        if self._is_stand_in(pin) and not (self._known(pin) and others):
            pins, wanted = [pin], kind
        else:
            pins = others
        pins = [other for other in pins if self.learnt.get(other) != wanted]
        self.learnt.update(dict.fromkeys(pins, wanted))
        return bool(pins)

    def _known(self, pin):
        return known(self.files, pin) or known(self.files, pin, likely=True)

    def _is_stand_in(self, pin):
        return any(pin in pins for pins in self.described.values())

    def _try_next(self, pin):
        if not self._is_stand_in(pin):
            return False
        order = [FLOAT, BIT, S32, U32]
        tried = self.learnt.setdefault("tried " + pin, [self._kind(pin)[0]])
        rest = [kind for kind in order if kind not in tried]
        if rest:
            tried.append(rest[0])
            self.learnt[pin] = rest[0]
        return bool(rest)

    def outputs(self):
        """The pins of drivers that are outputs here: the hardware would write them."""
        return {pin for module in self.drivers for pin in self.described[module] if self._kind(pin)[1] == "OUT"}


def given_pins(texts):
    """The pins that files of pins list, by the name of the driver or program: rows of `halcmd -s show pin`, or PIN TYPE
    DIRECTION."""
    learnt = {"given": list(texts)}
    for path, text in texts.values():
        for number, line in enumerate(text.splitlines(), start=1):
            words = line.split("#")[0].split()
            if not words:
                continue
            row = (words[4], *words[1:3]) if len(words) > 4 else tuple(words)
            if len(row) != 3 or row[1].lower() not in TYPES or row[2].upper() not in DIRECTIONS:
                sentence = "%s:%d has %r. Write the pin, its type (%s) and its direction (%s)."
                raise Impossible(sentence % (path, number, line.strip(), ", ".join(TYPES), ", ".join(DIRECTIONS)))
            learnt[row[0]], learnt["direction of " + row[0]] = row[1].lower(), DIRECTIONS[row[2].upper()]
    return learnt


def script(*words):
    """A shell script that runs a Python program of ours."""
    return "#!/bin/sh\nexec %s \"$@\"\n" % shlex.join([sys.executable, *words])


def _inverse(pin):
    """The names that the inverse of a pin can have."""
    return {pin[:-4]} if pin.endswith(("-not", "_not")) else {pin + "-not", pin + "_not"}


def _program(words):
    """Component and program of the words of loadusr."""
    name, options = None, iter(words)
    for word in options:
        if word == "-Wn":
            name = next(options, None)
        elif word.startswith("-"):
            continue
        else:
            return name or os.path.basename(word), word
    return name, None

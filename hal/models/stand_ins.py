# SPDX-License-Identifier: GPL-2.0-or-later
"""Drivers that need hardware and programs that need a screen: their names, and models in their place.

A driver becomes components of the host (hal/host/models.hpp). A program becomes stand_in.py, whose pins the host moves. The
pins are those that the user's files name; types and directions come from model files, manual pages, ethercat-conf.xml, and
the nets.
"""

import ast
import importlib.util
import json
import os
import re
import shlex
import shutil
import sys

import ethercat
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
PORTS = {"serial", "minimalmodbus", "pymodbus", "smbus", "smbus2", "usb", "hid", "evdev", "RPi", "spidev", "can"}  # modules of Python
BOARD = re.compile(r"/sys/|/dev/|/boot/|config-pin|\b(modprobe|insmod|sudo|gpio)\b")  # what sets up hardware
# Pins of LinuxCNC itself, and of screens.
LINUXCNCS = "joint axis spindle motion iocontrol halui ini tp motion-command-handler motion-controller axisui gladevcp pyvcp qtvcp".split()
PIN_LINE = re.compile(r"^[ \t]*(?:hal[ \t]+)?(?:(?:net|linksp)[ \t]+\S+|setp|linkps|linkpp|addf)[ \t]+(.*)$", re.M)
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
        self.models, self.program_models = {}, {}  # by module, and by program
        self.notes = []  # sentences on what is no driver and no program of LinuxCNC
        self.files = model_files(ini.folder)
        self.learnt = {} if learnt is None else learnt  # name -> type or direction that LinuxCNC wanted
        self.trial, self.ini, self.described, self.numbers = trial, ini, {}, {}
        self.pages = []  # the beginning of a pin's name, the page that can have the pin, and how names begin there if otherwise
        trial.read.update(files)
        self.texts = {path: self._read(path) for path in files}
        commands = "\n".join(ini.all("HAL", "HALCMD"))
        text = self._values("\n".join([*self.texts.values(), commands]))
        self.aliases = hal_text.aliases(text)
        self.all = hal_text.without(self.aliases, text)
        self.commands = re.sub(r"^[ \t]*(loadusr|loadrt|source)[ \t].*", "", self.all, flags=re.M)  # with names of pins
        self.nets = hal_text.nets_of(self.all)
        self.kinds, self.real = {}, None  # of signals, and of the pins of modules
        self.ethercat = ethercat.Bus(self._lcec_files())
        self.heads = self._heads_without_an_owner(files)
        self._stand_in_for_drivers()
        self._stand_in_for_programs()
        model_parts.add(self, follows)
        for name, model in self.program_models.items():
            self.trial.write(self._description(name), json.dumps({"name": name, "pins": model["pins"]}))
        both = {kind: [row for model in self.program_models.values() for row in model[kind]] for kind in ("pins", "parts")}
        self.listed = {"modules": self.models, "program_pins": {**both, "functions": []}}
        self.list = trial.list_models(self.listed)

    def _lcec_files(self):
        """The files of the EtherCAT bus that HAL files name."""
        named = re.findall(r"^\s*loadusr\s.*?lcec_conf\s+(\S+)", self.all, re.M)
        places = [os.path.join(self.ini.folder, os.path.expanduser(name)) for name in named]
        return list(filter(os.path.isfile, places))

    def _heads_without_an_owner(self, files):
        """How names of pins begin that no component in sight has: those of a program or module under another name."""
        later = [os.path.basename((value.split() or [""])[0]) for value in self.ini.all("HAL", "POSTGUI_HALFILE")]
        text = "\n".join(self._values(self.texts[path]) for path in files if os.path.basename(path) not in later)
        owned, self.nameless = {_plain(name) for name in LINUXCNCS}, []
        for module, rest in re.findall(r"^[ \t]*(?:hal[ \t]+)?loadrt[ \t]+([\w-]+)(.*)$", text, re.M):
            named = re.search(r"\bnames?=(\S+)", rest)
            names = named[1].strip("\"'").split(",") if named else [module, re.sub("^hal_", "", module)]
            owned.update(_plain(name.partition(".")[0]) for name in names)
            self.nameless.append(module)
        programs = []
        for line in re.findall(r"^[ \t]*(?:hal[ \t]+)?loadusr[ \t]+(.*)$", text, re.M):
            programs.append(_program(line.split("#")[0].split())[0] or "")
        self.nameless += programs
        found = []
        for line in PIN_LINE.findall(text):
            for word in line.split("#")[0].split():
                head = re.match(r"([A-Za-z][\w-]*)\.[\w.+-]*\w$", word)
                if not head or head[1] in (*found, *programs) or _plain(head[1]) in owned or re.search(r"\.(hal|tcl|ini)$", word):
                    continue
                if not any(re.match(file.heads, word) for file in self.files if isinstance(file.heads, str)):
                    found.append(head[1])
        return found

    def _take_heads(self, name):
        """The heads that a component without pins under its own name can have: those like it, else those like no other."""
        taken = [head for head in self.heads if _like(head, name)]
        taken = taken or [head for head in self.heads if not any(_like(head, other) for other in self.nameless)]
        self.heads = [head for head in self.heads if head not in taken]
        return taken

    def _read(self, path):
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            return file.read()

    def _values(self, text):
        def value(found):
            return self.ini.get(found[1], found[2] or found[3]) or found[0]

        text = re.sub(r"(^|\s)#.*", r"\1", re.sub(r"\\\n", " ", text), flags=re.M)
        return hal_text.VALUE.sub(value, text)

    def pins_behind(self, prefix):
        """Type and direction of each pin that the HAL files name behind a prefix."""
        found = {}
        for name in sorted(set(re.findall(r"(?<![\w.-])%s\.[\w.+-]+" % re.escape(prefix), self.commands))):
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

    def told(self, name):
        """Type and direction of a pin, as far as its module, LinuxCNC and their pages give them."""
        real = self._real_pins().get(name) or self.ethercat.pins.get(name)
        return real or known(self.files, name) or self._on_page(name)

    def _guess(self, name):
        told = self.told(name)
        return [given or used for given, used in zip(told, self._by_use(name))] if None in told else told

    def _by_use(self, name):
        """Type and direction of a pin by the signals and values that the user's files give it."""
        others, is_source, has_writer, likely = [], False, False, known(self.files, name, likely=True) or [None, None]
        signals = [signal for signal, (pins, _) in self.nets.items() if name in pins]
        for signal in signals:
            pins, sources = self.nets[signal]
            others += [kind for kind in map(self.told, pins) if None not in kind]
            is_source = is_source or name in sources
            has_writer = has_writer or any(self.told(source)[1] != "IN" for source in sources - {name})  # HAL ignores arrows
        kind = self._kind_of_signal(signals[0]) if signals else likely[0] or self._kind_by_value(name) or _kind_by_name(name)
        if any(direction == "IO" for _, direction in others):
            return [kind, "IO"]
        has_writer = has_writer or any(direction == "OUT" for _, direction in others)
        reads = any(direction == "IN" for _, direction in others)
        return [kind, "IN" if has_writer or not (is_source or reads) else "OUT"]

    def _kind_of_signal(self, signal):
        """The type of a signal: all of its pins have this type."""
        if signal not in self.kinds:
            pins = self.nets[signal][0]
            told = [kind for kind, _ in map(self.told, pins) if kind]
            new = re.search(r"^\s*(?:hal\s+)?newsig\s+%s\s+(\w+)" % re.escape(signal), self.all, re.M)
            likely = [found[0] for found in (known(self.files, pin, likely=True) for pin in pins) if found]
            values = [kind for kind in map(self._kind_by_value, pins) if kind]
            names = [BIT if any(LIKE_A_BIT.search(name) for name in (*pins, signal)) else FLOAT]
            self.kinds[signal] = next(iter([*told, *([new[1].lower()] if new else []), *likely, *values, *names]))
        return self.kinds[signal]

    def _kind_by_value(self, name):
        """The type by the value that the user's files set, or None."""
        value = re.search(r"^\s*(?:HALCMD\s*=\s*)?setp\s+%s\s+(\S+)" % re.escape(name), self.all, re.M)
        return value and (BIT if value[1].lower() in ("0", "1", "true", "false") else FLOAT)

    def _stand_in_for_drivers(self):
        lines = {}
        for found in re.finditer(r"^[ \t]*(?:hal[ \t]+)?loadrt[ \t]+(\S+).*$", self.all, re.M):
            module = found[1]
            learnt = any(module in self.learnt.get(kind, ()) for kind in ("given", "absent"))
            if of_module(self.files, module) or learnt or self.trial.is_absent(module, self.ini):
                lines.setdefault(module, found[0].strip())
        self.drivers += lines
        by_module = {module: of_module(self.files, module) for module in self.drivers}
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
            named = set(re.findall(prefix, self.all))
            heads = sorted(named - set(described)) if named or (file and file.heads) else self._take_heads(module)
            described += heads
            pins, functions = {}, []
            for head in heads:
                pins.update({head + "." + name: kind for name, kind in self.pins_behind(head).items()})
                added = sorted(set(re.findall(r"^\s*(?:hal\s+)?addf\s+(%s(?:\.\S+)?)(?=\s)" % re.escape(head), self.all, re.M)))
                functions += [name for name in added if name not in functions]  # parport.0.read is one of parport, too
            self.described[module] = list(pins)
            rows = [[name, *kind, 1 if self._is_true(name, kind) else 0] for name, kind in pins.items()]
            self.models[module] = {"pins": rows, "functions": functions, "parts": []}
            if not file:
                self.misses[module] = "all that the module does, because it is not installed here"
            elif file.misses:
                self.misses[module] = file.misses

    def _real_pins(self):
        """The pins of all modules but those that need their hardware, as the modules make them."""
        if self.real is None:
            lines = ["loadrt tpmod", "loadrt homemod"]  # as LinuxCNC does first
            for line, module in re.findall(r"^[ \t]*(?:hal[ \t]+)?(loadrt[ \t]+(\S+).*)$", self.all, re.M):
                file = of_module(self.files, module)
                if (not file or file.without_hardware) and line.strip() not in lines:
                    lines.append(line.strip())
            if self.learnt.get("loaded") != lines:
                rows = (row.split() for row in self.trial.pins_of_modules(lines).splitlines())
                real = {words[4]: [words[1], DIRECTIONS[words[2]]] for words in rows if len(words) > 4 and words[2] in DIRECTIONS}
                self.learnt.update({"real": real, "loaded": lines})
            self.real = self.learnt["real"]
        return self.real

    def _stand_in_for_programs(self):
        started = {}  # names of the components of a program that is started more than once
        for line in self.all.splitlines():
            words = line.split("#")[0].split()
            if len(words) < 2 or words[0] != "loadusr":
                continue
            name, program, interpreted = _program(words[1:])
            if interpreted and not self._installed(interpreted):
                self.trial.program("bin/" + interpreted)
            why = program and ("given" if name in self.learnt.get("given", ()) else self._cannot_run_here(program, interpreted))
            if not why or name in self.programs:
                continue
            if why not in (True, "given"):
                self.notes.append("%s: %s" % (program, why))
            if "-w" in words[1 : words.index(program)]:  # LinuxCNC waits for its end
                self._cover(program, "-c", "")
                continue
            self.programs.append(name)
            self.pages.append((re.escape(name) + r"\.", os.path.basename(program), None))
            file = of_program(self.files, os.path.basename(program))
            pins = {"%s.%s" % (name, pin): kind for pin, kind in self.pins_behind(name).items()}
            for head in () if pins or file else self._take_heads(name):
                pins.update({"%s.%s" % (head, pin): kind for pin, kind in self.pins_behind(head).items()})
            self._describe(name, pins, file)
            names = started.setdefault(program, [])
            names.append(name)
            self._cover(program, *self._stand_in(*names), interpreted=interpreted)
        for file in self.files:
            name = file.programs.pattern
            if file.always and name not in self.programs:
                self._describe(name, {}, file)
                self._cover(name, *self._stand_in(name))

    def _path(self, program, interpreted=None):
        return os.path.join(self.ini.folder, program) if "/" in program or interpreted else self._installed(program)

    def _cover(self, program, *words, interpreted=None):
        """Puts a command where LinuxCNC, or an interpreter, will look for the program."""
        path = self._path(program, interpreted)
        if path is None:
            self.trial.program("bin/" + program, *words)
        elif self.trial.can_place(path):
            text = "import os\nos.execv(%r, %r)\n" % (sys.executable, [sys.executable, *words]) if interpreted else script(*words)
            self.trial.place(path, text, 0o777)
        else:  # no file can be put there: the HAL files name another, in the run alone
            ours = self.trial.path("bin/" + os.path.basename(program))
            self.trial.program("bin/" + os.path.basename(program), *words)
            for file, text in self.texts.items():
                if program in text:
                    self.texts[file] = text.replace(program, ours)
                    self.trial.place(file, self.texts[file])

    def _installed(self, program):
        """The program that LinuxCNC starts by this name; it looks into a folder bin beside the INI file first."""
        return shutil.which(program, path=os.path.join(self.ini.folder, "bin") + ":" + os.environ.get("PATH", os.defpath))

    def _cannot_run_here(self, program, interpreted=None):
        """Whether a program cannot run here, or a sentence why."""
        base = os.path.basename(program)
        if base in SCREENS or DEVICES.match(base) or of_program(self.files, base):
            return True
        path = self._path(program, interpreted) or os.path.join(os.path.dirname(self.trial.plumb), base)  # Plumb's own may be built and not installed
        try:
            with open(path, "rb") as file:
                text = file.read(200000)
        except (OSError, TypeError):
            return "the program is not installed here"
        if not text.startswith(b"#!") and not interpreted:
            return False
        text = text.decode(errors="replace")
        if not interpreted and "python" not in text.partition("\n")[0]:
            return BOARD.search(text) is not None and "the script sets up hardware"
        return bool(WINDOWS.search(text)) or _python_misses(text, os.path.dirname(path))

    def _number(self, name):
        return self.numbers.setdefault(name, len(self.numbers))

    def _description(self, name):
        """The file of a program's pins. HAL may give any name: files of ours have numbers."""
        return "stand-in-%d.json" % self._number(name)

    def _stand_in(self, *names):
        """The words of the command that stands in: at each start for the first of these that is not there."""
        return os.path.join(HERE, "stand_in.py"), ":".join(self.trial.path(self._description(name)) for name in names)

    def _describe(self, name, pins, file):
        """The pins of a program, and those that its file says."""
        parts = []
        if file:
            pins.update({"%s.%s" % (name, pin): kind for pin, kind in file.program_pins.items()})
            parts = [
                {"kind": "follow", "pins": {"in": "%s.%s" % (name, leader), "out": "%s.%s" % (name, follower)}}
                for follower, leader in file.follow.items()
            ]
        self.described[name] = list(pins)
        rows = [[pin, *kind, int(self._is_true(pin, kind))] for pin, kind in pins.items()]
        self.program_models[name] = {"pins": rows, "parts": parts}

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
        words = hal_text.without(self.aliases, words)
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


def _plain(name):
    return re.sub("[-_]", "", name).lower()


def _like(head, name):
    head, name = _plain(head), _plain(name)
    return head in name or (len(name) > 2 and name in head)


def _kind_by_name(name):
    return BIT if LIKE_A_BIT.search(name) else FLOAT


def _python_misses(text, folder):
    """Why a program in Python cannot run here: it is of Python 2, or imports a module for a port, or one that is not here."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return "the program is no valid Python 3"
    for node in tree.body:
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module] if isinstance(node, ast.ImportFrom) and node.module and not node.level else []
        for name in (name.partition(".")[0] for name in names):
            here = any(os.path.exists(os.path.join(folder, name + end)) for end in (".py", ""))
            if name in PORTS:
                return "the program talks to a port by Python's module %s" % name
            if not here and importlib.util.find_spec(name) is None:
                return "Python's module %s is not installed here" % name
    return False


def _inverse(pin):
    """The names that the inverse of a pin can have."""
    return {pin[:-4]} if pin.endswith(("-not", "_not")) else {pin + "-not", pin + "_not"}


def _program(words):
    """Component and program of the words of loadusr, and the interpreter of Python before the program or None."""
    name, interpreted, options = None, None, iter(words)
    for word in options:
        if word == "-Wn":
            name = next(options, None)
        elif re.fullmatch(r"python[\d.]*", word) and not interpreted:
            interpreted = word
        elif not word.startswith("-"):
            return name or os.path.splitext(os.path.basename(word))[0], word, interpreted  # as halcmd names it
    return name, None, interpreted

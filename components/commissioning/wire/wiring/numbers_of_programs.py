# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers of outputs and inputs of M62 to M68: those that a machine has free, which subroutines read from the INI file."""

import os
import re

import hal_text

SECTION = "PLUMB_NUMBERS"
MOST = 64  # of motmod
PIN = re.compile(r"motion\.(digital|analog)-(out|in)-(\d+)")
WORD = re.compile(r"\b(M6[2-8])(\s*)([PE])(\d+)", re.I)
SHARED = {"motion.analog-out-00": "operation-key", "motion.digital-out-00": "cycle-running"}  # of interlock, for programs
MOST_PROGRAMS, LONGEST = 500, 1 << 20  # files of the user, and bytes of one


class Numbers:
    """The numbers that functions use on a machine.

    moved       pins that functions take in place of the pins of their files
    names       the name of the number of each pin of their files
    notes       a sentence for each pin that is another
    problems    a sentence for each pin for which none is free
    """

    def __init__(self, functions, machine, given, earlier=(), reserved=()):
        """`given` has the numbers of an earlier time by name, `earlier` the functions that were wired then."""
        self.moved, self.notes, self.problems = {}, [], []
        self.names, owner = {}, {}
        for function in functions:
            for signal, pin in pins_of(function):
                self.names.setdefault(pin, signal.replace("-", "_").upper())
                owner.setdefault(pin, function)
        used = in_programs(machine.ini)
        reserved = {*reserved, *SHARED, *self.names}
        for pin, name in self.names.items():
            self.moved[pin] = self._place(pin, name, owner[pin], machine, given, used, earlier, reserved)
        self.moved = {pin: other for pin, other in self.moved.items() if pin != other}

    def _place(self, pin, name, function, machine, given, used, earlier, reserved):
        wished = numbered(pin, int(given[name])) if (given.get(name) or "").isdigit() else pin
        theirs = machine.in_use(wished)
        known = function.name in earlier
        if not theirs and (known or wished not in used) and wished not in self.moved.values():
            return wished
        others = [numbered(pin, number) for number in range(MOST)]
        taken = {*SHARED, *self.names, *used, *self.moved.values()}
        free = [other for other in others if other not in taken and not machine.in_use(other)]
        # Those that motmod has come first, and of these the ones that no function uses.
        free.sort(key=lambda other: (other not in machine.complete.pins, other in reserved))
        for other in free[:1]:
            if other in machine.complete.pins or theirs or machine.can_have_more_outputs():
                reason = "keeps your signal %s" % theirs if theirs else "is in use by %s" % used.get(wished, "another function")
                self.notes.append("%s %s; %s takes %s, and its subroutines know the number." % (wished, reason, function.name, other))
                return other
        if not theirs and wished not in self.moved.values():
            self.notes.append("%s uses %s, as %s does. Do not run it while %s is on." % (used[wished], wished, function.name, function.name))
            return wished
        self.problems.append("%s is in use, and %s finds no other one that is free." % (wished, function.name))
        return wished

    def values(self):
        """The lines of the section, by name."""
        return {name: str(number_of(self.moved.get(pin, pin))) for pin, name in self.names.items()}

    def literal(self, text):
        """A text with the numbers of this machine."""
        return renumbered(text, self.moved)

    def named(self, text):
        """A subroutine that reads its numbers from the INI file; comments have the numbers of now."""
        lines = []
        for line in text.split("\n"):
            code = re.match(r"[^;(]*", line)[0]
            lines.append(WORD.sub(self._parameter, code) + self.literal(line[len(code) :]))
        return "\n".join(lines)

    def parameter(self, pin):
        return "#<_ini[%s]%s>" % (SECTION, self.names[pin])

    def _parameter(self, found):
        pin = written(found)
        return found[1] + found[2] + found[3] + (self.parameter(pin) if pin in self.names else found[4])


def renumbered(text, moved):
    """A text whose words have the numbers of other pins."""

    def word(found):
        pin = written(found)
        return found[1] + found[2] + found[3] + (str(number_of(moved[pin])) if pin in moved else found[4])

    return WORD.sub(word, text)


def pins_of(function):
    """(signal, pin) of each output and input for programs in the files of a function."""
    commands = hal_text.parse(function.original(function.name + ".hal"))
    nets = [command.words for command in commands if command.name == "net"]
    found = [(words[0], word) for words in nets for word in words[1:] if PIN.fullmatch(word)]
    pins = {pin for _, pin in found}
    for name in function.subroutines:
        for pin in map(written, WORD.finditer(function.original(name))):
            if pin not in pins:
                pins.add(pin)
                found.append((SHARED.get(pin, pin.partition(".")[2]), pin))
    if function.axis_offset:
        found += [(signal, pin) for pin, signal in SHARED.items() if pin not in pins]
    return found


def number_names(function):
    return [signal.replace("-", "_").upper() for signal, _ in pins_of(function)]


def written(found):
    """The pin that a word such as M64 P3 drives or reads."""
    code, letter = found[1].upper(), found[3].upper()
    kind = "digital" if letter == "P" else "analog"
    return "motion.%s-%s-%02d" % (kind, "in" if code == "M66" else "out", int(found[4]))


def numbered(pin, number):
    return "%s-%02d" % (pin.rsplit("-", 1)[0], number)


def number_of(pin):
    return int(pin.rsplit("-", 1)[1])


def in_programs(ini):
    """The pins that the user's programs and subroutines drive or read, and the file with each."""
    folders = [ini.folder]
    for section, name in (("DISPLAY", "PROGRAM_PREFIX"), ("RS274NGC", "SUBROUTINE_PATH")):
        folders += [os.path.join(ini.folder, os.path.expanduser(path)) for path in (ini.get(section, name) or "").split(":") if path]
    found, files = {}, 0
    for folder in dict.fromkeys(map(os.path.realpath, folders)):
        if not os.path.isdir(folder) or os.path.exists(os.path.join(folder, ".written.json")):  # our own subroutines
            continue
        for name in sorted(os.listdir(folder)):
            path = os.path.join(folder, name)
            if not name.lower().endswith((".ngc", ".nc", ".tap")) or not os.path.isfile(path) or files >= MOST_PROGRAMS:
                continue
            files += 1
            with open(path, encoding="utf-8", errors="replace") as file:
                for line in file.read(LONGEST).splitlines():
                    for word in WORD.finditer(re.match(r"[^;(]*", line)[0]):
                        found.setdefault(written(word), name)
    return found

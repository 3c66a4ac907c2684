# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of HAL commands: loadrt, setp, net, addf."""

import collections
import contextlib
import itertools
import os
import re

Command = collections.namedtuple("Command", "name words comment")  # comment: the lines before it
ARROWS = ("=>", "<=", "<=>")
VALUE = re.compile(r"\[(\w+)\](?:\((\w+)\)|(\w+))")  # [SECTION]NAME or [SECTION](NAME)


def read(path):
    """The commands of a file of ours, which has one on each line."""
    with open(path, encoding="utf-8") as file:
        return parse(file.read())


def parse(text):
    commands, comment = [], []
    for line in text.splitlines():
        stripped = line.strip()
        if not stripped or stripped.startswith("#"):
            comment.append(stripped)
            continue
        words = re.split(r"\s+#", stripped)[0].split()
        commands.append(Command(words[0], words[1:], comment))
        comment = []
    return commands


def pins_of_net(words):
    """The signal, the pin that writes it or None, and the other pins of `net` in a file of ours."""
    signal, rest = words[0], words[1:]
    if "=>" not in rest:
        return signal, rest[0] if rest else None, []
    arrow = rest.index("=>")
    return signal, rest[0] if arrow else None, rest[arrow + 1 :]


def aliases(text):
    """The names of pins by their aliases."""
    return {alias: pin for pin, alias in re.findall(r"^[ \t]*alias[ \t]+pin[ \t]+(\S+)[ \t]+(\S+)", text, re.M)}


def without(aliases, text):
    """The text with the names of pins in the place of their aliases."""
    for alias, pin in aliases.items():
        text = re.sub(r"(?<![\w.:-])%s(?![\w.:-])" % re.escape(alias), pin.replace("\\", r"\\"), text)
    return text


def nets_of(text):
    """All pins of each signal in the text of HAL files, and those that an arrow calls its source."""
    found = {}
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if len(words) > 2 and words[0] in ("net", "linksp", "linkps"):
            pins = [word for word in words[2:] if word not in ARROWS]
            signal = found.setdefault(words[1], ([], set()))
            signal[0].extend(pins)
            if "=>" in words:
                signal[1].update(words[2 : words.index("=>")])
            if "<=" in words:
                signal[1].update(words[words.index("<=") + 1 :][:1])
    return found


def halfiles(ini, folder):
    """The HAL files that the INI file names, found as LinuxCNC finds them, each with those that it sources."""
    library = os.environ.get("HALLIB_DIR", "/usr/share/linuxcnc/hallib")
    seen = set()
    first = itertools.takewhile(str.strip, ini.all("HAL", "HALFILE"))  # LinuxCNC reads no further than an empty value
    for value in [*first, *ini.all("HAL", "POSTGUI_HALFILE")]:
        name = os.path.expanduser((value.split() or [""])[0])
        places = [os.path.join(library, name[4:])] if name.startswith("LIB:") else [
            os.path.join(folder, name),
            os.path.join(library, name),
        ]
        found = next(filter(os.path.isfile, places), None)
        if found:
            yield from _with_sourced(found, folder, seen)
    for value in ini.all("HAL", "HALCMD"):
        yield from _sourced(value, folder, seen)


def with_sourced(path, folder):
    """A HAL file and those that it sources."""
    return list(_with_sourced(path, folder, set()))


def _with_sourced(path, folder, seen):
    if path in seen:
        return
    seen.add(path)
    yield path
    if path.endswith(".hal"):
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
        yield from _sourced(text, folder, seen)


def _sourced(text, folder, seen):
    for name in re.findall(r"^[ \t]*source[ \t]+(\S+)", text, re.M):
        path = os.path.join(folder, name)
        if os.path.isfile(path):
            yield from _with_sourced(path, folder, seen)


def where(pattern, files):
    """FILE:LINE of the first line that has a word, or None. A name that Tcl computes is not found."""
    return next((place for place, _line in lines_with(pattern, files)), None)


def lines_with(pattern, files):
    """(FILE:LINE, the line without its remark) of each line that has a word."""
    word = re.compile(r"(?<![\w.:-])%s(?![\w.:-])" % re.escape(pattern))
    for path in files:
        with contextlib.suppress(OSError), open(path, encoding="utf-8", errors="replace") as file:
            for number, line in enumerate(file, start=1):
                line = line.split("#")[0]
                if word.search(line):
                    yield "%s:%d" % (os.path.basename(path), number), line

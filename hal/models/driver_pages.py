# SPDX-License-Identifier: GPL-2.0-or-later
"""Types and directions of the pins of a driver, as its manual page lists them."""

import functools
import gzip
import lzma
import re
import subprocess

LONGEST = 2_000_000  # bytes of a page
PATIENCE = 10  # s
OPEN = {"gz": gzip.open, "xz": lzma.open}
DIRECTIONS = {
    **dict.fromkeys(("in", "input", "w", "rw", "r/w", "read/write"), "IN"),
    **dict.fromkeys(("out", "output", "r", "ro"), "OUT"),
    **dict.fromkeys(("io", "i/o", "in/out"), "IO"),
}
TYPE = r"(?P<type>bit|float|s32|u32)"
DIRECTION = "(?P<direction>%s)" % "|".join(sorted(DIRECTIONS, key=len, reverse=True))
NAME = r"(?P<name>[\w<\[(][\w<>\[\]().-]*\.[\w<>\[\]().-]+)"
PINS = [  # the ways in which LinuxCNC's pages write a pin
    re.compile(r"%s\s+\(%s(?:,?\s*%s)?\)" % (NAME, TYPE, DIRECTION), re.I),
    re.compile(r"%s\s+%s\s+%s\b" % (NAME, TYPE, DIRECTION), re.I),
    re.compile(r"%s\s+%s\s+%s\b" % (NAME, DIRECTION, TYPE), re.I),
]
KIND_FIRST = re.compile(r"\(%s,?\s*%s\)\s*(?P<rest>.*)" % (TYPE, DIRECTION), re.I)
HEAD = re.compile(r"\bnames\s+like\s+\W*?([A-Za-z<][\w<>]*\.[\w<>.]*[\w>])")
PLACE = re.compile(r"<[^<>]*>|\[[^\[\]]*\]|\([^()]*\)|(?<![A-Za-z])(?:N+|M+|X{2,})(?![A-Za-z])")  # of a number or a name


class Page:
    """The pins of a manual page. Its names have places for numbers: stepgen.<Instance>.counts, in-NN."""

    def __init__(self, text):
        found = {}
        for name, kind, direction in _pins([_plain(line) for line in text.splitlines()]):
            found.setdefault(_pattern(name), (len(PLACE.sub("", name)), [kind, direction]))
        # The name with the most letters of its own comes first: in-NN-invert before in-NN.
        self.pins = [(re.compile(name), kind) for name, (_, kind) in sorted(found.items(), key=lambda item: -item[1][0])]

    def kind(self, pin):
        """Type and direction of a pin; the direction is None where the page has none. None without the pin."""
        return next((kind for name, kind in self.pins if name.fullmatch(pin)), None)


@functools.lru_cache(maxsize=None)
def page_of(name):
    """The manual page of a driver or program; empty if there is none here."""
    try:
        words = ["man", "-w", "--", name]
        found = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE, check=False)
        path = found.stdout.splitlines()[0]
        with OPEN.get(path.rpartition(".")[2], open)(path, "rb") as file:
            return Page(file.read(LONGEST).decode(errors="replace"))
    except (OSError, EOFError, IndexError, ValueError, lzma.LZMAError, subprocess.SubprocessError):
        return Page("")


def _plain(line):
    """A line of a page without the commands of its type. A word in italics stands for a number or a name."""
    line = re.sub(r"\\fI([^.\\]*)(?=\\f)", lambda word: word[1] if word[1].startswith("<") else "<%s>" % word[1], line)
    line = re.sub(r"\\f(\w|\(\w\w|\[\w*\])|\\&", "", line).replace("\\-", "-").replace("\\ ", " ")
    return re.sub(r"^\.(B|I|IP|TP|RB|BR)\b *", "", line).replace('"', "").replace("'", "").strip()


def _pins(lines):
    """Name, type and direction of each pin. A section says once how the names of its pins begin."""
    head = None
    for number, line in enumerate(lines):
        if line.startswith((".SH", ".SS")):
            head = None
        like = HEAD.search(" ".join(lines[number : number + 2]))
        head = re.sub(r"\.<Pin>$", "", like[1]) if like else head
        match = KIND_FIRST.match(line)
        if match:
            yield from ((name, *_kind(match)) for name in _names(match["rest"], lines[number - 1], head))
        else:
            match = next(filter(None, (pattern.match(line) for pattern in PINS)), None)
            if match:
                yield (match["name"], *_kind(match))


def _kind(match):
    direction = match["direction"]
    return match["type"].lower(), direction and DIRECTIONS[direction.lower()]


def _names(rest, above, head):
    """The whole names behind a type, or above it, or behind it without their head: in & in_not."""
    first = (rest.split() or [""])[0].rstrip(".,:")
    if "." in first:
        return [first]
    if re.fullmatch(NAME, above):
        return [above]
    listed = re.split(r"\s*(?:,\s*and\s|,|&|\band\b)\s*", re.sub(r"\(.*|:.*", "", rest).strip())
    return ["%s.%s" % (head, name) for name in listed if re.fullmatch(r"[\w<>-]+", name)] if head else []


def _pattern(name):
    """A regular expression for a name. The place in front is the name of a component, which can have dots."""
    pattern, end = "", 0
    for place in PLACE.finditer(name):
        pattern += re.escape(name[end : place.start()]) + (r"[^.]+" if place.start() else r"[\w.-]+")
        end = place.end()
    return pattern + re.escape(name[end:])

# SPDX-License-Identifier: GPL-2.0-or-later
"""An INI file with the files that it includes: LinuxCNC reads the values; lines are added where they belong."""

import collections
import contextlib
import copy
import difflib
import errno
import math
import os
import re
import shlex
import tempfile

import linuxcnc
import writing
from texts import Impossible, wrapped

LONGEST = 1 << 20  # bytes of a file

Place = collections.namedtuple("Place", "path line text")  # line counts from 0


class IniFile:
    """The sections as LinuxCNC sees them: the first one of a name counts, and an included file includes nothing."""

    def __init__(self, path, without=lambda path, text: text):
        """`without` gives the text of a file without earlier changes of ours."""
        self.path, self.without = path, without
        self.folder = os.path.dirname(path)
        self.texts = {}  # new lines of each file, by path; the last one is what stands behind the last line end
        self.before = {}  # texts without changes of ours
        self.original = {}  # texts as they are
        self._include(path)

    def copy(self):
        """The same text, to be changed apart."""
        other = copy.copy(self)
        other.texts = {path: list(lines) for path, lines in self.texts.items()}
        return other

    def _include(self, path):
        if os.path.getsize(path) > LONGEST:
            raise Impossible("%s is longer than %d bytes." % (path, LONGEST))
        with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
            self.original[path] = file.read()
        if self.original[path].startswith("\ufeff"):
            sentence = "%s begins with a byte order mark, behind which LinuxCNC does not find the first line. This takes it away: sed -i '1s/^\\xEF\\xBB\\xBF//' %s"
            raise Impossible(wrapped(sentence % (os.path.basename(path), shlex.quote(path))))
        self.before[path] = self.without(path, self.original[path])
        self.texts[path] = self.before[path].split("\n")
        if path != self.path:
            self._forbid_nested(path)
            return
        for number, line in enumerate(self.texts[path], start=1):
            included = self._included(line)
            if included:
                self._forbid_odd(included, number)
            if included and included not in self.texts:
                self._include(included)

    def _included(self, line):
        words = line.split(None, 1)
        if len(words) < 2 or words[0] != "#INCLUDE":
            return None
        path = os.path.join(self.folder, os.path.expanduser(os.path.expandvars(words[1].strip())))
        return path if os.path.exists(path) else None

    def _forbid_odd(self, path, number):
        """LinuxCNC copies all of it before it reads it."""
        if not os.path.isfile(path) or os.path.getsize(path) > LONGEST:
            kind = "is no file" if not os.path.isfile(path) else "is longer than %d bytes" % LONGEST
            sentence = "%s:%d includes %s, which %s. Write the name of a file with INI lines there."
            raise Impossible(wrapped(sentence % (os.path.basename(self.path), number, path, kind)))

    def _forbid_nested(self, path):
        """LinuxCNC 2.9 takes an #INCLUDE in an included file for a comment; 2.10 reads that file, too."""
        for number, line in enumerate(self.texts[path], start=1):
            if line.startswith("#INCLUDE") and not linuxcnc.version.startswith("2.9"):
                sentence = "%s:%d includes a file, and is included itself. Write that #INCLUDE into %s instead."
                raise Impossible(wrapped(sentence % (os.path.basename(path), number, os.path.basename(self.path))))

    def lines(self):
        """All lines in the order in which LinuxCNC reads them."""
        for number, text in enumerate(self.texts[self.path]):
            included = self._included(text)
            if included in self.texts:
                yield from (Place(included, line, words) for line, words in enumerate(self.texts[included]))
            else:
                yield Place(self.path, number, text)

    def get(self, section, name):
        found = self.all(section, name)
        return found[0] if found else None

    def number(self, section, name, default=None):
        """A number; the default where there is none."""
        text = (self.get(section, name) or "").strip()
        if not text:
            return default
        with contextlib.suppress(ValueError):
            if math.isfinite(float(text)) and "_" not in text:
                return float(text)
        place = self.named(section, name)[0]
        remark = " LinuxCNC takes no remark behind a value: give the remark a line of its own." if re.search("[#;]", text) else ""
        sentence = "%s:%d: %s = %s is no number.%s"
        raise Impossible(wrapped(sentence % (os.path.basename(place.path), place.line + 1, name, text, remark)))

    def all(self, section, name):
        try:
            with tempfile.NamedTemporaryFile("w", suffix=".ini", encoding="utf-8", errors="surrogateescape") as file:
                # An #INCLUDE of a file that is not written yet: a comment in 2.9, an error in LinuxCNC 2.10.
                lines = ("" if place.text.startswith("#INCLUDE") else place.text for place in self.lines())
                file.write("\n".join(lines) + "\n")
                file.flush()
                found, again = (list(linuxcnc.ini(file.name).findall(section, name)) for _ in range(2))
                if found != again:  # LinuxCNC takes an error for the end of the file
                    raise OSError(errno.EIO, os.strerror(errno.EIO), file.name)
                return found
        except SystemError:
            place = next((place for place in self.named(section, name) if re.search("[\ud800-\udfff]", place.text)), None)
            if place is None:
                raise
            sentence = "%s:%d: %s is not UTF-8 text: save the file as UTF-8."
            raise Impossible(wrapped(sentence % (os.path.basename(place.path), place.line + 1, name))) from None
        except linuxcnc.error as error:
            raise OSError(errno.EIO, str(error), tempfile.gettempdir()) from None
        except OSError as error:
            error.filename = error.filename or tempfile.gettempdir()
            raise

    def _section(self, section):
        """Its header and the lines behind it."""
        found = []
        for place in self.lines():
            text = place.text.strip()
            if found and text.startswith("["):
                break
            if found or text.startswith("[%s]" % section):
                found.append(place)
        return found

    def named(self, section, name):
        """The places of the lines of this name."""
        return [place for place in self._section(section) if re.match(r"\s*%s\s*=" % re.escape(name), place.text)]

    def set(self, section, name, value):
        """Gives a value another text; adds it where there is none."""
        found = self.named(section, name)
        if found:
            end = "\r" if found[0].text.endswith("\r") else ""
            self.texts[found[0].path][found[0].line] = "%s = %s%s" % (name, value, end)
        else:
            self.add(section, name, value)

    def add(self, section, name, value):
        """Adds a line behind the last one of this name, or behind the last one of the section. LinuxCNC reads the lines of a
        name up to the first without a value: it comes before that."""
        line = "%s = %s" % (name, value)
        inside = self._section(section)
        if not inside:
            self._append(["", "[%s]" % section, line])
            return
        written = [place for place in inside if place.text.strip() and not place.text.strip().startswith(("#", ";"))]
        named = self.named(section, name)
        empty = next((place for place in named if not place.text.split("=", 1)[1].strip()), None)
        if empty:
            self.texts[empty.path].insert(empty.line, line + self._end(empty.path))
            return
        after = (named or written)[-1]
        lines = self.texts[after.path]
        if after.line + 1 == len(lines):  # the last line has no end
            lines[after.line] += self._end(after.path)
            lines.append(line)
        else:
            lines.insert(after.line + 1, line + self._end(after.path))

    def insert(self, place, name, value):
        """Adds a line in front of the one at this place."""
        self.texts[place.path].insert(place.line, "%s = %s%s" % (name, value, self._end(place.path)))

    def _end(self, path):
        """What stands before the line feed in a file."""
        return "\r" if "\r\n" in self.original[path] else ""

    def _append(self, lines):
        """Adds lines behind all others. The last one gets an end, without which LinuxCNC leaves out an #INCLUDE."""
        there, end = self.texts[self.path], self._end(self.path)
        if there[-1]:
            there[-1] += end
            there.append("")
        there[-1:] = [*(line + end for line in lines), ""]

    def include(self, name):
        """Adds an included file behind all others."""
        self._append(["#INCLUDE " + name])

    def drop(self, section, name, matches=lambda value: True):
        for place in reversed(self.named(section, name)):
            if matches(place.text.split("=", 1)[1].strip()):
                del self.texts[place.path][place.line]

    def includes(self, name):
        return any(_includes(line, name) for line in self.texts[self.path])

    def drop_include(self, name):
        self.texts[self.path] = [line for line in self.texts[self.path] if not _includes(line, name)]

    def text(self, path):
        return "\n".join(self.texts[path])

    def changed(self):
        """The text of each file that is not the one on the disk, by path."""
        return {path: self.text(path) for path in self.texts if self.text(path) != self.original[path]}

    def write(self, place):
        """Calls place(path, text) for each file that has changed."""
        for path, text in self.changed().items():
            place(path, text)

    def outside(self):
        """Included files that have changed and lie outside the folder, where patch(1) does not go."""
        return [os.path.realpath(path) for path in self.changed() if self._is_outside(path)]

    def _is_outside(self, path):
        return writing.inside(path, self.folder) is None

    def patch(self):
        """The changes, for patch(1)."""
        text = ""
        for path, new in self.changed().items():
            if self._is_outside(path):
                continue
            name = os.path.relpath(path, self.folder)
            for line in difflib.unified_diff(lines_of(self.original[path]), lines_of(new), "a/" + name, "b/" + name):
                text += line if line.endswith("\n") else line + "\n\\ No newline at end of file\n"
        return text


def lines_of(text):
    """The lines with their ends, by line feeds alone."""
    return re.findall(r"[^\n]*\n|[^\n]+\Z", text)


def _includes(line, name):
    return re.match(r"#INCLUDE\s+(\./)?%s\s*$" % re.escape(name), line)

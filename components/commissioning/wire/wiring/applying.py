# SPDX-License-Identifier: GPL-2.0-or-later
"""The changes of an INI file and of the files that it includes: applied, found again, and undone."""

import difflib
import json
import os

import writing
from texts import Impossible, wrapped

NOTES = ".applied.json"  # the texts of each file before and after
COPY = ".before-plumb"  # a file beside each changed one, as it was


class Applied:
    """What plumb wire has changed in the files of a machine.

    notes   sentences on lines that a user has changed since, and that stay
    """

    def __init__(self, folder, home, ini_path):
        self.folder, self.home, self.ini_path, self.notes = folder, home, ini_path, []
        self.files = self._read()

    def _read(self):
        try:
            text = writing.read(self.folder, NOTES)
        except NotADirectoryError:
            return {}
        try:
            files = json.loads(text)["files"] if text else {}
            if not all(isinstance(one[key], str) for one in files.values() for key in ("before", "after")):
                raise TypeError
            return files
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            sentence = "%s, in which plumb wire notes the lines that it added, is damaged. The files as they were are beside them: *%s."
            raise Impossible(wrapped(sentence % (os.path.join(self.folder, NOTES), COPY))) from None

    def without(self, path, text):
        """The text of a file without the changes."""
        its = self.files.get(os.path.relpath(path, self.home))
        if not its or text == its["before"]:
            return text
        if text == its["after"]:
            return its["before"]
        lines, kept = undone(*(one.split("\n") for one in (its["before"], its["after"], text)))
        sentence = "%s: plumb wire added the line `%s`, and somebody changed or removed it. That stays as it is."
        self.notes += [sentence % (os.path.basename(path), line.strip()) for line in kept]
        return "\n".join(lines)

    def apply(self, texts):
        """Gives files new texts. `texts` has the text of before and of after by path."""
        self.forbid_running()
        files = {os.path.relpath(path, self.home): pair for path, pair in texts.items()}
        self.files = {name: {"before": before, "after": after} for name, (before, after) in files.items() if before != after}
        self._place({name: its["after"] for name, its in self.files.items()}, copies=True)

    def undo(self):
        """Gives the files their texts of before. Returns their names."""
        self.forbid_running()
        texts = {}
        for name in self.files:
            path = os.path.join(self.home, name)
            text = writing.read(self.home, name)
            if text is None:
                raise Impossible("%s is not there any more." % path)
            texts[name] = self.without(path, text)
        before = {name: its["before"] for name, its in self.files.items()}
        self._place(texts, copies=False)
        for name, text in before.items():
            if writing.read(self.home, name + COPY) == text:
                os.unlink(os.path.join(self.home, name + COPY))
        os.unlink(os.path.join(self.folder, NOTES))
        self.files = {}
        return sorted(texts)

    def _place(self, texts, copies):
        for name in texts:
            path = os.path.join(self.home, name)
            if os.path.islink(path):
                raise Impossible("%s is a link to %s. Wire the INI file itself." % (path, os.path.realpath(path)))
            if not os.access(path, os.W_OK):
                raise Impossible("You cannot write %s." % path)
        present = {name: writing.read(self.home, name) for name in texts}
        if copies:
            notes = json.dumps({"ini": os.path.basename(self.ini_path), "files": self.files}, indent=1) + "\n"
            beside = [(name + COPY, its["before"]) for name, its in self.files.items()]
            folder = os.path.relpath(self.folder, self.home)
            writing.write_all(self.home, [(os.path.join(folder, NOTES), notes), *beside], lasting=True)
        for name, text in texts.items():
            if text != present[name]:
                writing.rewrite(os.path.join(self.home, name), text)

    def forbid_running(self):
        """LinuxCNC reads its INI file again while it runs, and a HALFILE that comes meanwhile is not loaded."""
        for process in filter(str.isdigit, os.listdir("/proc")):
            path = ini_of(process)
            if path and os.path.dirname(os.path.realpath(path)) == os.path.realpath(self.home):
                sentence = "LinuxCNC runs with %s (process %s). End it before its INI file changes."
                raise Impossible(wrapped(sentence % (path, process)))


def ini_of(process):
    """The INI file with which a program of LinuxCNC runs, or None. A trial runs in a file system of its own."""
    try:
        with open("/proc/%s/cmdline" % process, "rb") as file:
            words = os.fsdecode(file.read()).split("\0")
        if "-ini" not in words[:-1]:
            return None
        if os.readlink("/proc/%s/ns/mnt" % process) != os.readlink("/proc/self/ns/mnt"):
            return None
        return os.path.join(os.readlink("/proc/%s/cwd" % process), words[words.index("-ini") + 1])
    except OSError:
        return None


def undone(before, after, present):
    """The lines of `present` without the changes that lead from `before` to `after`, and the lines of these changes that are
    not in `present` any more."""
    place = {}
    for block in difflib.SequenceMatcher(None, after, present, autojunk=False).get_matching_blocks():
        place.update({block.a + i: block.b + i for i in range(block.size)})
    lines, kept = list(present), []
    changes = difflib.SequenceMatcher(None, after, before, autojunk=False).get_opcodes()
    for tag, begin, end, first, last in reversed(changes):
        if tag == "equal":
            continue
        places = [place.get(index) for index in range(begin, end)]
        kept += [after[begin + i] for i, found in enumerate(places) if found is None and after[begin + i].strip()]
        there = [found for found in places if found is not None]
        if tag == "delete":
            for found in reversed(there):
                del lines[found]
        elif tag == "insert":
            above = place.get(begin - 1)
            if above is not None:
                lines[above + 1 : above + 1] = before[first:last]
        elif len(there) == len(places):
            for found in reversed(there):
                del lines[found]
            lines[there[0] : there[0]] = before[first:last]
    return lines, kept[::-1]


def changes(before, after):
    """A line for each one that changes: its number, + or -, and its text."""
    before, after = ([line.rstrip("\r") for line in text.split("\n")] for text in (before, after))
    found = []
    for tag, begin, end, first, last in difflib.SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        if tag != "equal":
            found += ["%5d - %s" % (i + 1, before[i]) for i in range(begin, end) if before[i].strip()]
            found += ["%5d + %s" % (i + 1, after[i]) for i in range(first, last) if after[i].strip()]
    return found

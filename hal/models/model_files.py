# SPDX-License-Identifier: GPL-2.0-or-later
"""Model files: the pins of a driver, or of a program, that cannot be here, and how they move.

A file NAME.model, in TOML, beside this module or beside the user's INI file, whose own come first:

    modules = 'hm2_\\w+|hostmot2'     modules in loadrt lines, as a regular expression
    programs = 'hal_manualtoolchange' or programs in loadusr lines
    heads = 'hm2_\\w+'                how names of pins begin; without it as the module. {module = head} for several
    pages = ['hostmot2']             manual pages with types of pins, beside the one of the module
    without_hardware = true          the module can be loaded without hardware: its pins are learnt from it
    pins = '''NAME TYPE DIRECTION'''  names as regular expressions; the first that fits the whole name counts
    likely = '''...'''               the same, where neither pages nor signals tell
    misses = 'the bus'               what the model does not do

    [[parts]]                        each head that has the pins of a part has this part
    of = 'hm2_\\w+\\.\\d+\\.stepgen\\.\\d+'
    each = 'in_not'                  with it: one part for each such pin behind the head, which is '$' below
    kind = 'stepgen'                 see hal/host/models.cpp
    pins = { command = 'position-cmd', ... }    roles, and regular expressions of pins behind the head
    numbers = { factor = 1 }
"""

import glob
import os
import re
import tomllib

from texts import Impossible

HERE = os.path.dirname(os.path.realpath(__file__))
TYPES = ("bit", "float", "s32", "u32")
DIRECTIONS = {"IN": "IN", "OUT": "OUT", "IO": "IO", "I/O": "IO"}
KEYS = {"modules", "programs", "heads", "pages", "without_hardware", "pins", "likely", "misses", "parts", "always", "follow", "program_pins"}
KINDS = {"stepgen", "encoder", "at-speed", "switch", "inverse", "follow", "speed", "drive", "cia402"}


class ModelFile:
    """A file, checked."""

    def __init__(self, path):
        self.path = path
        try:
            with open(path, "rb") as file:
                given = tomllib.load(file)
        except (OSError, tomllib.TOMLDecodeError) as error:
            raise Impossible("%s: %s" % (path, error)) from None
        unknown = sorted(set(given) - KEYS)
        if unknown:
            raise Impossible("%s: '%s' is no word of a model file. There are %s." % (path, unknown[0], ", ".join(sorted(KEYS))))
        self.modules = self._pattern(given.get("modules", ""))
        self.programs = self._pattern(given.get("programs", ""))
        self.heads = given.get("heads", {})
        self.pages = given.get("pages", ())
        self.without_hardware = given.get("without_hardware", False)
        self.always, self.follow = given.get("always", False), given.get("follow", {})
        self.misses = given.get("misses", "")
        self.pins, self.likely = self._rows(given.get("pins", "")), self._rows(given.get("likely", ""))
        self.program_pins = {name: list(self._kind(name, kind.split())) for name, kind in given.get("program_pins", {}).items()}
        self.parts = given.get("parts", [])
        for part in self.parts:
            if part.get("kind") not in KINDS:
                raise Impossible("%s: '%s' is no kind of a part. There are %s." % (path, part.get("kind"), ", ".join(sorted(KINDS))))
            for expression in (part.get("of", ""), part.get("each", "")):
                self._pattern(expression)

    def _pattern(self, expression):
        try:
            return re.compile(expression)
        except re.error as error:
            raise Impossible("%s: '%s' is no regular expression: %s" % (self.path, expression, error)) from None

    def _rows(self, text):
        rows = []
        for line in text.splitlines():
            words = line.split()
            if words:
                rows.append((self._pattern(words[0]), *self._kind(line.strip(), words[1:])))
        return rows

    def _kind(self, line, words):
        if len(words) != 2 or words[0] not in TYPES or words[1].upper() not in DIRECTIONS:
            sentence = "%s: '%s' is no pin. Write its name, its type (%s) and its direction (in, out, io)."
            raise Impossible(sentence % (self.path, line, ", ".join(TYPES)))
        return words[0], DIRECTIONS[words[1].upper()]

    def head(self, module):
        """How the names of a module's pins begin, as a regular expression."""
        if isinstance(self.heads, str):
            return self.heads
        return self.heads.get(module, re.sub("[-_]", "[-_]", module))  # a component in C has - in its pins for _ in its name


def model_files(folder=None):
    """The files of a folder, then those of Plumb."""
    paths = sorted(glob.glob(os.path.join(glob.escape(folder), "*.model"))) if folder else []
    return [ModelFile(path) for path in paths + sorted(glob.glob(os.path.join(glob.escape(HERE), "*.model")))]


def of_module(files, module):
    """The file with this module, or None."""
    return next((file for file in files if file.modules.pattern and file.modules.fullmatch(module)), None)


def of_program(files, program):
    return next((file for file in files if file.programs.pattern and file.programs.fullmatch(program)), None)


def known(files, name, likely=False):
    """Type and direction of a pin in the files, or None."""
    for file in files:
        for pattern, kind, direction in file.likely if likely else file.pins:
            if pattern.fullmatch(name):
                return [kind, direction]
    return None

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Copies a configuration of Plumb, ready to run. See plumb-example(1)."""

import argparse
import difflib
import os
import re
import shutil
import sys

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
sys.path.append(os.path.join(PREFIX, "python"))  # of a build tree
from plumb_program import run as run_program  # noqa: E402

SUMMARY = "copies a configuration of Plumb, ready to run"
FOLDERS = [os.path.join(PREFIX, "share", *words) for words in (("plumb", "examples"), ("linuxcnc", "aux_examples", "plumb"))]
SHARED = ("common", "functions")  # links in each configuration, to what several of them use
READ = (".ini", ".inc", ".hal", ".tcl", ".toml", ".ngc", ".py", ".md")  # these may name further files


def main():
    parser = argparse.ArgumentParser(prog="plumb example", description=SUMMARY[0].upper() + SUMMARY[1:] + ".")
    parser.add_argument("--summary", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("name", nargs="?", metavar="NAME", help="such as mill")
    parser.add_argument("folder", nargs="?", metavar="FOLDER", help="folder of the copy; the default is ./NAME")
    parser.add_argument("--version", action="version", version="plumb @PROJECT_VERSION@")
    arguments = parser.parse_args()
    if arguments.summary:
        print(SUMMARY)
        return 0
    examples = all_examples()
    if arguments.name not in examples:
        return refuse(unknown(arguments.name, examples), 2)
    folder = os.path.abspath(arguments.folder or arguments.name)
    if os.path.lexists(folder):
        return refuse("%s is there already; give another folder: plumb example %s FOLDER" % (folder, arguments.name), 1)
    if re.search(r"\s", folder):
        return refuse("the path %s has a blank, and LinuxCNC cannot read these INI files there; give another folder" % folder, 1)
    source = examples[arguments.name]
    names = files_of(source)
    try:
        copy(source, names, folder)
    except (OSError, shutil.Error) as error:
        return refuse("nothing was copied: %s" % why(error), 1)
    starts = sorted(name for name in names if name.endswith(".ini"))
    print("%s has %d files. README.md describes them." % (folder, len(names)))
    print("Start it with  linuxcnc %s" % os.path.join(os.path.relpath(folder), starts[0]))
    if len(starts) > 1:
        print("or with %s." % " or ".join(starts[1:]))
    return 0


def refuse(sentence, status):
    print("plumb example: " + sentence, file=sys.stderr)
    return status


def why(error):
    if not isinstance(error, OSError) or not error.filename:
        return error
    return "%s: %s" % (error.filename2 or error.filename, error.strerror)


def all_examples():
    """Name -> folder of each configuration that has an INI file."""
    found = {}
    for folder in filter(os.path.isdir, FOLDERS):
        for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
            if entry.is_dir() and any(name.endswith(".ini") for name in os.listdir(entry.path)):
                found.setdefault(entry.name, entry.path)
    return found


def unknown(name, examples):
    if not examples:
        return "no configuration is installed in " + " or ".join(FOLDERS)
    listed = "".join("\n  %-12s %s" % (each, title(folder)) for each, folder in examples.items())
    if name is None:
        return "name a configuration. There are" + listed
    close = difflib.get_close_matches(name, examples, 1)
    return "there is no configuration '%s'%s There are%s" % (name, "; is it %s?" % close[0] if close else ".", listed)


def title(folder):
    """The first line of its README, without the sign of a heading."""
    with open(os.path.join(folder, "README.md"), encoding="utf-8") as file:
        return file.readline().lstrip("# ").rstrip()


def files_of(source):
    """The names of the files that a copy has: the INI files, the G-code, the README, and all that they name."""
    waiting = [name for name in os.listdir(source) if name.endswith((".ini", ".ngc")) or name == "README.md"]
    found = set()
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        if name.endswith(READ):
            waiting += named_by(source, name)
    return sorted(found)


def named_by(source, name):
    """The files of a configuration that a file of it names: by their place in the configuration, or beside this file."""
    with open(os.path.join(source, name), encoding="utf-8") as file:
        text = file.read()
    words = set(re.findall(r"[\w./+-]*\w", text.replace("$(CONFIG_DIR)/", "")))
    if name.endswith(".py"):
        words |= {module + ".py" for module in re.findall(r"^(?:from|import) (\w+)", text, re.M)}
    for word in words:
        for place in (word, os.path.join(os.path.dirname(name), word)):
            place = os.path.normpath(place)
            path = os.path.join(source, place)
            if place.startswith(("..", "/")) or place in (".", *SHARED):
                continue
            if os.path.isfile(path):
                yield place
            elif os.path.isdir(path) and name.endswith((".ini", ".inc")):  # of subroutines and M-codes
                yield from (os.path.join(place, each) for each in os.listdir(path) if re.fullmatch(r".*\.ngc|M1\d\d", each))


def copy(source, names, folder):
    """All of it, or nothing. Links become files."""
    part = folder + ".part"
    shutil.rmtree(part, ignore_errors=True)
    try:
        for name in names:
            place = os.path.join(part, name)
            os.makedirs(os.path.dirname(place), exist_ok=True)
            shutil.copyfile(os.path.join(source, name), place)
            os.chmod(place, 0o755 if os.access(os.path.join(source, name), os.X_OK) else 0o644)
        os.rename(part, folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


if __name__ == "__main__":
    run_program("plumb example", main)

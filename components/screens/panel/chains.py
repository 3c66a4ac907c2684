# SPDX-License-Identifier: GPL-2.0-or-later
"""[SQUARENESS]CHAIN in the INI file. Without a screen."""

import os
import re

from panel import files
from panel.hal_files import Ini
from panel.texts import _

SECTION = re.compile(r"\s*\[([^\]]*)\]")
LINE = re.compile(r"(\s*CHAIN\s*=\s*)(.*?)(\s*)$")


def place(ini):
    """The file that has the chain; a link is followed within the folder of the INI file. Raises OSError."""
    path = ini.place("SQUARENESS", "CHAIN")
    if path.endswith(".expanded"):  # which LinuxCNC makes of the user's file at each start
        path = Ini(path[: -len(".expanded")]).place("SQUARENESS", "CHAIN")
    if not path:
        raise OSError(2, _("[SQUARENESS] of the INI file has no CHAIN"), ini.path)
    real = os.path.realpath(path)
    if os.path.islink(path) and os.path.commonpath([real, os.path.realpath(ini.folder)]) != os.path.realpath(ini.folder):
        files.refuse_link(path)
    return real


def in_file(ini):
    """The chain as the file has it now: the next start's. '' without one."""
    try:
        return Ini(place(ini)).get("SQUARENESS", "CHAIN") or _read(place(ini))
    except OSError:
        return ""


def _read(path):
    """The chain of a file that another one includes, perhaps without its section."""
    with open(path, encoding="utf-8", errors="surrogateescape") as file:
        found = [LINE.match(line) for line in file]
    return next((match[2] for match in found if match), "")


def write(path, chain):
    """Changes the chain by a new file in the place of the old one, with its owner and its mode. Raises OSError."""
    with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
        lines = file.read().splitlines(keepends=True)
    own = any(SECTION.match(line) and SECTION.match(line)[1].strip() == "SQUARENESS" for line in lines)
    section, changed = "" if own else "SQUARENESS", False
    for number, line in enumerate(lines):
        if SECTION.match(line):
            section = SECTION.match(line)[1].strip()
        found = LINE.match(line)
        if section == "SQUARENESS" and found and not changed:
            lines[number], changed = found[1] + chain + found[3], True
    if not changed:
        raise OSError(2, _("[SQUARENESS] of the INI file has no CHAIN"), path)
    files.replace(path, "".join(lines), like=os.stat(path))

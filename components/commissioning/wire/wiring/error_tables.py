# SPDX-License-Identifier: GPL-2.0-or-later
"""The error tables that the user's HAL files load into squareness. They are read, never written."""

import os
import re
import shlex
import stat

from hal_text import VALUE

LONGEST = 4 << 20  # bytes, as squareness reads them
SEAL = re.compile(rb"# end, seal [0-9a-f]{8}, \d+ rows?")


def unsealed(ini, files, home):
    """A sentence for each table without a seal, with the command that seals it."""
    tables = dict.fromkeys(table for text in texts(ini, files) for table in loaded(text, ini, home))
    sentence = "The error table %s has no seal, so a damaged digit can go unseen. Check the table, then run: plumb squareness --table %s --seal"
    return [sentence % (table, shlex.quote(table)) for table in tables if lacks_seal(table)]


def texts(ini, files):
    yield from ini.all("HAL", "HALCMD")
    for path in files:
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            yield file.read().replace("\\\n", " ")


def loaded(text, ini, home):
    """The paths in the lines that load squareness."""
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if words[:2] != ["loadrt", "squareness"]:
            continue
        for word in words[2:]:
            if word.startswith("table="):
                value = word[len("table=") :].replace("$(CONFIG_DIR)", home)
                value = VALUE.sub(lambda found: ini.get(found[1], found[2] or found[3]) or "", value)
                yield from filter(None, value.split(":"))


def lacks_seal(path):
    """Whether it is a table that can be read, without a seal in its last line."""
    try:
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                return False
            lines = [line for line in file.read(LONGEST).splitlines() if line.strip()]
    except OSError:
        return False
    return bool(lines) and not SEAL.fullmatch(lines[-1])

# SPDX-License-Identifier: GPL-2.0-or-later
"""What to do where a configuration does not start without Plumb either."""

import re

import hal_text

REMEDIES = (
    (r"CANNOT FIND FILE FOR:(\S+)", "{place} names {0}, and it is not there: put the file into {folder}, or remove the line."),
    (r"[Cc]ould not open hal file '([^']+)'", "{place} names {0}, and it is not there: put the file into {folder}, or remove the line."),
    (r"handle_includes\(\): <(\d+)> CANNOT READ (\S+)", "{ini} includes {1}, and it is not there: put the file into {folder}, or remove the line."),
    (r"couldn't read file \"([^\"]+)\"", "{0} is not there: put the file into {folder}, or remove the line that sources it."),
    (r"File \"([^\"]+)\", line (\d+)\n(?:.*\n){0,2}.*Missing parentheses in call to 'print'", "{0}:{1} is written for Python 2: convert it by 2to3."),
    (r"(\S+\.hal:\d+): Pin '(\S+)' was already linked to signal '(\S+)'", "{0} nets {1}, which is in your signal {2}: use this signal there."),
    (
        r"Waiting for component '([^']+)'(?:.*\n)+?.*component '([^']+)' loaded",
        "{place} waits for the component {0}, and the component {1} came: write loadusr -Wn {1} there.",
    ),
    (r"Waiting for component '([^']+)'", "{place} waits for the component {0}, which did not come: start its program by hand to see why."),
    (r"HAL is locked", "{lock} locks HAL before the files of Plumb are loaded: remove this line."),
    (
        r"\b([\w-]+): dlopen: .*cannot open shared object file",
        "The module {0} is not installed here. If it is yours, install it: sudo halcompile --install {0}.comp",
    ),
    (r"(\S+\.hal:\d+): Pin '(\S+)' does not exist", "{0} names the pin {1}: load its component in a line before, or remove the line."),
)


def remedy(words, ini):
    """A sentence for the first complaint that is known; None for others."""
    for pattern, sentence in REMEDIES:
        found = re.search(pattern, words)
        if found:
            lock = hal_text.where("lock", hal_text.halfiles(ini, ini.folder))
            return sentence.format(*found.groups(), ini=ini.path, folder=ini.folder, place=_place(ini, found), lock=lock)
    return None


def _place(ini, found):
    """FILE:LINE of the line of the INI file that names a HAL file."""
    name = found[1] if found.groups() else None
    for key in ("HALFILE", "POSTGUI_HALFILE"):
        for place in ini.named("HAL", key):
            if name and name in place.text:
                return "%s:%d" % (place.path, place.line + 1)
    return (name and hal_text.where(name, hal_text.halfiles(ini, ini.folder))) or ini.path

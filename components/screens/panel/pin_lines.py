# SPDX-License-Identifier: GPL-2.0-or-later
"""The lines of `halcmd -s show pin`."""

import collections
import re

Pin = collections.namedtuple("Pin", "name owner kind output value signal")
Pin.__doc__ = "kind is bit, float, s32 or u32; owner is the component that has the pin; signal is empty without one."
LINE = re.compile(r"^(\S+)\s+(bit|float|s32|u32|port|s64|u64)\s+(IN|OUT|I/O)\s+(\S+)\s+(\S+)(?:\s+[<=>-]+\s+(\S+))?$")



def parse_pins(shown):
    """The pins in the output of `halcmd -s show pin`."""
    found = []
    for line in shown.splitlines():
        match = LINE.match(line.strip())
        if match:
            owner, kind, direction, value, name, signal = match.groups()
            found.append(Pin(name, owner, kind, direction == "OUT", parse_value(kind, value), signal or ""))
    return found


def parse_parameters(shown):
    """Values by names in the output of `halcmd -s show param`: owner, kind, direction, value, name."""
    lines = [line.split() for line in shown.splitlines()]
    return {words[4]: parse_value(words[1], words[3]) for words in lines if len(words) == 5}


def parse_value(kind, text):
    if kind == "bit":
        return text == "TRUE"
    if kind == "float":
        return float(text)
    try:
        return int(text, 0)
    except ValueError:
        return text

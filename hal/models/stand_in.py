# SPDX-License-Identifier: GPL-2.0-or-later
"""A HAL component with the pins of a program that cannot be here. The host moves them (hal/host/models.hpp)."""

import json
import signal
import sys

import hal

TYPES = {"bit": hal.HAL_BIT, "float": hal.HAL_FLOAT, "s32": hal.HAL_S32, "u32": hal.HAL_U32}
DIRECTIONS = {"IN": hal.HAL_IN, "OUT": hal.HAL_OUT, "IO": hal.HAL_IO}


def first_absent(descriptions):
    """The first description whose component is not there yet, and this component."""
    for path in descriptions:
        with open(path, encoding="utf-8") as file:
            given = json.load(file)
        try:
            return given, {given["name"]: hal.component(given["name"])}
        except hal.error:
            continue
    sys.exit("all of %s are there" % descriptions)


def main():
    given, heads = first_absent(sys.argv[1].split(":"))
    for pin, kind, direction, value in given["pins"]:
        head, _, tail = pin.partition(".")  # a program can have pins under other names than its own
        if head not in heads:
            heads[head] = hal.component(head)
        heads[head].newpin(tail, TYPES[kind], DIRECTIONS[direction])
        heads[head][tail] = value
    for component in reversed(list(heads.values())):  # LinuxCNC waits for the program's own
        component.ready()
    while True:
        signal.pause()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass

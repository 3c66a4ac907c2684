# SPDX-License-Identifier: GPL-2.0-or-later
"""A HAL component with the pins of a program that cannot be here; some outputs follow an input."""

import json
import sys
import time

import hal

TYPES = {"bit": hal.HAL_BIT, "float": hal.HAL_FLOAT, "s32": hal.HAL_S32, "u32": hal.HAL_U32}
DIRECTIONS = {"IN": hal.HAL_IN, "OUT": hal.HAL_OUT, "IO": hal.HAL_IO}


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        given = json.load(file)
    component = hal.component(given["name"])
    pins = {}
    for name, (kind, direction) in given["pins"].items():
        pins[name] = component.newpin(name, TYPES[kind], DIRECTIONS[direction])
        if name in given["true"]:
            pins[name].set(True)
    component.ready()
    while True:
        time.sleep(0.02)
        for follower, leader in given["follow"].items():
            pins[follower].set(pins[leader].get())


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass

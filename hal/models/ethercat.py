# SPDX-License-Identifier: GPL-2.0-or-later
"""The pins of the module lcec, as the file for lcec_conf describes the slaves of a bus."""

import sys
import xml.etree.ElementTree

# Objects of CiA 402, by index: the roles of a drive.
OBJECTS = {0x6040: "control", 0x6041: "status", 0x607A: "target", 0x6064: "position", 0x60FF: "target-velocity", 0x606C: "velocity"}
OBJECTS.update({0x6060: "mode", 0x6061: "mode-display"})
ANOTHER_AXIS = 0x800  # distance of the objects of two axes
TYPES = {"bit": "bit", "u32": "u32", "s32": "s32", "float": "float", "float-unsigned": "float", "float-ieee": "float", "float-double-ieee": "float"}


class Bus:
    """Pins and drives of the slaves. The pins of a slave with a driver of its own are not in the file."""

    def __init__(self, paths):
        self.pins = {}  # name -> type, direction
        self.drives = []  # pins by roles
        for path in paths:
            try:
                masters = xml.etree.ElementTree.parse(path).getroot().iter("master")
            except (OSError, xml.etree.ElementTree.ParseError) as error:
                print("note: %s: %s" % (path, error), file=sys.stderr)
                continue
            for master in masters:
                for slave in master.iter("slave"):
                    head = "lcec.%s.%s." % tuple(part.get("name") or part.get("idx", "0") for part in (master, slave))
                    self._add(head, slave)

    def _add(self, head, slave):
        axes = {}
        for manager in slave.iter("syncManager"):
            direction = {"out": "IN", "in": "OUT"}.get(manager.get("dir"))  # of the bus, and of the pin
            for entry in manager.iter("pdoEntry") if direction else ():
                for part in (entry, *entry.iter("complexEntry")):
                    name, kind = part.get("halPin"), TYPES.get(part.get("halType"))
                    if not name or not kind:
                        continue
                    bits = int(part.get("bitLen") or 1) if kind == "bit" else 1
                    for pin in [name] if bits == 1 else ["%s-%d" % (name, bit) for bit in range(bits)]:
                        self.pins[head + pin] = [kind, direction]
                axis, role = _role(entry.get("idx", ""))
                if role and entry.get("halPin"):
                    axes.setdefault(axis, {})[role] = head + entry.get("halPin")
        self.drives += [roles for roles in axes.values() if "control" in roles]


def _role(index):
    """The axis and the role of an object of CiA 402."""
    try:
        number = int(index, 16)
    except ValueError:
        return 0, None
    axis = max(0, (number - 0x6000) // ANOTHER_AXIS)
    return axis, OBJECTS.get(number - axis * ANOTHER_AXIS)

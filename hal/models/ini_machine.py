#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""How plumb bench loads the machine of an INI file: ini_machine.py FOLDER FILE.ini [--models].

Prints one line of JSON, as LinuxCNC's script `linuxcnc` would load the realtime side of the machine:

    ini          the INI file that HAL files use: with included files, a copy in FOLDER
    folder       where all of it runs
    environment  variables
    commands     words of halcmd, in this order
    models       the list of models: the pins of LinuxCNC's own programs, with --models of drivers, too

A bench has neither LinuxCNC's task nor its io and halui. Their pins are there, and rest.
"""

import itertools
import json
import os
import sys

from stand_ins import StandIns
from texts import Impossible
from write_models import Ini, Place, models_of, show, variable

import hal_text

# The pins of LinuxCNC's io, which it has in each machine.
IO_PINS = """
    user-enable-out bit OUT, emc-enable-in bit IN, user-request-enable bit OUT, coolant-mist bit OUT, coolant-flood bit OUT,
    lube bit OUT, lube_level bit IN, tool-change bit OUT, tool-changed bit IN, tool-prepare bit OUT, tool-prepared bit IN,
    tool-number s32 OUT, tool-prep-number s32 OUT, tool-prep-pocket s32 OUT, tool-prep-index s32 OUT, tool-from-pocket s32 OUT
"""


class LinuxCNCsPrograms(StandIns):
    """The pins of LinuxCNC's programs alone: drivers and programs of the machine are the real ones."""

    def _stand_in_for_drivers(self):
        pass

    def _stand_in_for_programs(self):
        pass


def pins_of_programs(models):
    """Models of io and halui: all pins of io, and the pins of halui that the HAL files name."""
    pins = {"iocontrol.0." + name: kind for name, *kind in (row.split() for row in IO_PINS.replace("\n", " ").split(","))}
    named = {"iocontrol.0." + name: kind for name, kind in models.pins_behind("iocontrol.0").items()}
    halui = {"halui." + name: kind for name, kind in models.pins_behind("halui").items()}
    both = {"iocontrol": {**named, **pins}, "halui": halui}
    return {
        name: {"pins": [[pin, *kind, 0] for pin, kind in rows.items()], "functions": [], "parts": []}
        for name, rows in both.items()
        if rows
    }


def whole(ini, place):
    """The INI file without included files: halcmd does not know them."""
    with open(ini.path, encoding="utf-8", errors="surrogateescape") as file:
        included = any(line.startswith("#INCLUDE") for line in file)
    return place.write(os.path.basename(ini.path), "\n".join(ini.lines) + "\n") if included else os.path.abspath(ini.path)


def halfile(ini, value, library, path):
    """The command that loads a HALFILE, found as LinuxCNC finds the file."""
    name, *arguments = value.split()
    name = os.path.expanduser(name)
    if name.startswith("LIB:"):
        places = [os.path.join(library, name[4:])]
    else:
        places = [os.path.join(folder, name) for folder in (ini.folder, library)]
    found = next(filter(os.path.isfile, places), None)
    if not found:
        raise Impossible("%s: HALFILE = %s: there is no %s" % (ini.path, value, " and no ".join(places)))
    if found.endswith(".tcl"):
        return ["loadusr", "-w", "haltcl", "-i", path, found, *arguments]
    return ["-i", path, "-f", found]


def machine(ini, place, with_models):
    files = list(hal_text.halfiles(ini, ini.folder))
    models = models_of(place, ini, files) if with_models else LinuxCNCsPrograms(place, ini, files)
    if with_models:
        show(models)
    programs = pins_of_programs(models)
    listed = place.list_models({**models.listed, "modules": {**models.models, **programs}})
    library, path = variable("HALLIB_DIR"), whole(ini, place)
    commands = [["loadrt", name] for name in programs]
    for section, key, usual in (("TRAJ", "TPMOD", "tpmod"), ("EMCMOT", "HOMEMOD", "homemod")):
        commands.append(["loadrt", *(ini.get(section, key) or usual).split()])
    tcl = variable("LINUXCNC_TCL_DIR")
    if ini.get("HAL", "TWOPASS"):
        commands.append(["loadusr", "-w", "haltcl", "-i", path, os.path.join(tcl, "twopass.tcl")])
    else:
        values = itertools.takewhile(str.strip, ini.all("HAL", "HALFILE"))  # LinuxCNC reads no further than an empty value
        commands += [halfile(ini, value, library, path) for value in values]
    commands += [value.split() for value in ini.all("HAL", "HALCMD")]
    environment = {
        "HALLIB_DIR": library,
        "HALLIB_PATH": ".:" + library,
        "LINUXCNC_TCL_DIR": tcl,
        "HAL_RTMOD_DIR": variable("LINUXCNC_RTLIB_DIR"),
        "INI_FILE_NAME": path,
        "CONFIG_DIR": ini.folder,
        "PATH": os.path.join(ini.folder, "bin") + ":" + os.environ.get("PATH", os.defpath),
        "TRAJ_COORDINATES": ini.get("TRAJ", "COORDINATES") or "",
        "KINS_KINEMATICS": ini.get("KINS", "KINEMATICS") or "",
    }
    return {"ini": path, "folder": ini.folder, "environment": environment, "commands": commands, "models": listed}


def main(folder, file, *options):
    ini = Ini(file)
    if not ini.get("HAL", "HALFILE"):
        raise Impossible("%s: [HAL]HALFILE names no file, so there is no machine to load" % file)
    print(json.dumps(machine(ini, Place(folder), "--models" in options)))


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except (Impossible, OSError) as error:
        sys.exit("plumb: %s" % error)

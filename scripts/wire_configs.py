# SPDX-License-Identifier: GPL-2.0-or-later
"""The stages of our configurations, written by the code of plumb wire. Run it when that code changes."""

import argparse
import os
import shutil
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build"))
CONFIGS = os.path.join(ROOT, "configs")
sys.path[:0] = [os.path.join(BUILD, "python"), os.path.join(ROOT, "components", "commissioning", "wire", "wiring"), os.path.join(ROOT, "hal", "models")]
from functions import all_functions  # noqa: E402
from ini_file import IniFile  # noqa: E402
from later_files import LaterFiles  # noqa: E402
from machine import joints_by_coordinates  # noqa: E402
from numbers_of_programs import Numbers  # noqa: E402
from plumb_folder import TemporaryFolder  # noqa: E402
from trials import Trials  # noqa: E402
from wiring import Wiring  # noqa: E402

# INI file, what the names of the files begin with, functions, and the file of retain.
CONFIGURATIONS = (
    ("mill/mill.ini", "", ("thermal_displacement", "squareness"), "mill.toml"),
    ("portal/column.ini", "", ("squareness",), None),
    ("portal/portal.ini", "portal_", ("squareness",), None),
    ("lathe/lathe.ini", "", ("centre_height",), None),
    ("grinder/grinder.ini", "", ("chopping",), "grinder.toml"),
    ("grinder/inch.ini", "inch_", ("chopping",), "inch.toml"),
    ("grinder/face.ini", "face_", ("chopping",), "face.toml"),
    ("growth/growth.ini", "", ("thermal_growth_test",), None),
    ("growth/identified.ini", "identified_", ("axis_growth", "thermal_growth_test"), None),
)
SPARE_ROWS = {"mill/mill.ini": 1}  # of interlock, for functions that other INI files add
# The machine, without the plant behind it: a plant reads signals that the stages give.
MACHINE = ("common/motion.hal", "common/joints.hal", "common/w_joint.hal", "common/drives.hal", "z_joint.hal", "face_joint.hal", "common/spindle.hal", "common/iocontrol.hal")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing, and end with 1 if a file would be another")
    arguments = parser.parse_args()
    others = []
    for configuration in CONFIGURATIONS:
        for path, text in files(*configuration).items():
            if read(path) == text:
                continue
            others.append(os.path.relpath(path, ROOT))
            if not arguments.check:
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
    for path in others:
        print(("%s would be another: scripts/wire-configs" if arguments.check else "Wrote %s") % path)
    return 1 if arguments.check and others else 0


def files(ini, beginning, names, kept):
    """Text by path of the files that the stages of a configuration consist of."""
    known = all_functions(os.path.join(CONFIGS, "functions"))
    functions = [known[name] for name in names]
    for number, function in enumerate(functions):
        function.number = number
    folder = os.path.dirname(os.path.join(CONFIGS, ini))
    with TemporaryFolder("/var/tmp") as temporary:
        copy = os.path.join(temporary, "machine")
        shutil.copytree(folder, copy)
        machine = look(os.path.join(copy, os.path.basename(ini)), temporary)
        for function in functions:
            function.take_values(machine.ini)
        numbers = Numbers(functions, machine, {}, names)
        wiring = Wiring(functions, machine, "", numbers, commissioning=False)
        renamed = {name: other for name, other in {**wiring.names, **numbers.moved}.items() if name != other}
        if wiring.problems or renamed:  # the files of the functions are alike for all machines
            raise SystemExit("%s: %s" % (ini, "\n".join(wiring.problems) or "other names: %s" % renamed))
        written = wiring.files
        texts = {"stages.hal": written.stages(), "order.tcl": written.order()}
        rows = "functions=%d stages="
        texts["stages.hal"] = texts["stages.hal"].replace(rows % len(functions), rows % (len(functions) + SPARE_ROWS.get(ini, 0)))
        if kept:
            texts["retain.hal"] = written.retain().replace("/retain.toml", "/" + kept)
    texts["order.tcl"] = texts["order.tcl"].replace(" plumb_order.tcl]", " functions/plumb_order.tcl]")
    return {os.path.join(folder, beginning + name): text for name, text in texts.items()}


def look(path, temporary):
    """The machine of an INI file without its functions and its plant."""
    ini = IniFile(path)
    ini.drop("HAL", "HALFILE", lambda value: value not in MACHINE)
    plumb = os.path.join(BUILD, "bin", "plumb")
    trials = Trials(ini.folder, os.path.join(temporary, "trials"), plumb, {}, LaterFiles(os.path.join(temporary, "none")))
    machine = trials.look(ini, joints_by_coordinates(ini), "look")
    machine.complete.components.add("panel-settings")  # which panel.hal loads
    return machine


def read(path):
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        return file.read()


if __name__ == "__main__":
    sys.exit(main())

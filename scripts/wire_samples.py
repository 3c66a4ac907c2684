# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on the sample configurations of LinuxCNC, which were written without Plumb in mind."""

import argparse
import os
import re
import shutil
import stat
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build"))
SAMPLES = "/usr/share/doc/linuxcnc/examples/sample-configs"

BOTH = ("squareness", "thermal_displacement")
SQUARE = BOTH[:1]
XYZ = ("--joints", "X=0,Y=1,Z=2")

# INI file, functions, other arguments, and the reason to try it.
MACHINES = [
    ("sim/axis/axis_mm.ini", BOTH, (), "millimetres; command and feedback in one signal"),
    ("sim/axis/axis.ini", BOTH, (), "inches"),
    ("sim/axis/lathe.ini", BOTH, (), "lathe by Tcl, without Y, inches"),
    ("sim/axis/gantry/gantry_mm.ini", BOTH, (), "gantry, two joints at Y"),
    ("sim/axis/twopass/twopass.ini", BOTH, (), "TWOPASS, inches"),
    ("sim/axis/simtcl/twopass_basic.ini", BOTH, (), "TWOPASS with Tcl and #INCLUDE"),
    ("sim/axis/ini_with_includes/includes_demo.ini", BOTH, (), "all sections by #INCLUDE"),
    ("sim/axis/vismach/5axis/table-rotary-tilting/xyzac-trt.ini", BOTH, XYZ, "5 axes, switchable kinematics"),
    ("sim/axis/vismach/5axis/bridgemill/5axis.ini", BOTH, XYZ, "5 axes, tool tip kinematics"),
    ("sim/axis/vismach/VMC_toolchange/vmc_index.ini", SQUARE, (), "tool changer by classicladder and vismach"),
    ("sim/axis/axis_9axis.ini", BOTH, (), "9 axes"),
    ("sim/axis/external_offsets/dynamic_offsets.ini", SQUARE, (), "external offsets by another component"),
    ("sim/gmoccapy/gmoccapy.ini", BOTH, (), "gmoccapy"),
    ("sim/gmoccapy/gmoccapy_XYZAC.ini", BOTH, (), "gmoccapy, 5 joints"),
    ("sim/qtvcp_screens/qtdragon/qtdragon.ini", BOTH, (), "qtdragon"),
    ("sim/gmoccapy/lathe_configs/lathe.ini", BOTH, (), "gmoccapy, lathe"),
    ("sim/touchy/touchy.ini", BOTH, (), "touchy"),
    ("sim/tklinuxcnc/servo_sim.ini", BOTH, (), "servo loops with pid and encoder"),
    ("by_interface/parport/stepper/stepper_mm.ini", BOTH, (), "parallel port: stepgen in a base thread"),
    ("by_interface/parport/gantry/gantry.ini", BOTH, (), "parallel port, gantry"),
    ("by_interface/mesa/hm2-servo/5i20.ini", BOTH, (), "Mesa card, servo loops"),
    ("by_interface/mesa/hm2-stepper/5i20.ini", BOTH, (), "Mesa card, stepgen"),
]
STEPS = ("the machine turns on", "it homes", "it runs a program")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-R", metavar="REGEX", default="", help="only the INI files that it finds")
    parser.add_argument("--samples", metavar="DIR", default=SAMPLES, help="other sample configurations")
    parser.add_argument("--show", action="store_true", help="print the output of plumb wire")
    arguments = parser.parse_args()
    chosen = [machine for machine in MACHINES if re.search(arguments.R, machine[0])]
    works = 0
    with tempfile.TemporaryDirectory(prefix="plumb-samples-", dir="/var/tmp") as folder:
        samples = copy_samples(arguments.samples, folder)
        print("| Configuration | Function | starts | homes | runs | seen |\n| --- | --- | --- | --- | --- | --- |")
        for path, functions, options, purpose in chosen:
            ini = os.path.join(samples, path)
            name = "%s, %s" % (os.path.basename(path), purpose)
            if not os.path.exists(ini):
                print("| %s | | not in this LinuxCNC | | | |" % name)
                continue
            own = [output_of(ini)]
            before = snapshot(folder, own)
            status, output = wire(ini, functions, options)
            if arguments.show:
                print(output)
            for row in rows(name, functions, status, output):
                print(row, flush=True)
            changed = changes(before, snapshot(folder, own))
            if changed:
                print("| %s | CHANGED: %s | | | | |" % (name, ", ".join(changed)))
            works += status == 0 and not changed
    print("\n%d of %d configurations" % (works, len(chosen)))
    return 0 if works == len(chosen) else 1


def copy_samples(samples, folder):
    """With the folder to which ../nc_files of the samples leads."""
    copy = os.path.join(folder, "sample-configs")
    shutil.copytree(samples, copy, symlinks=True)
    os.symlink(os.path.join(os.path.dirname(os.path.realpath(samples)), "nc_files"), os.path.join(folder, "nc_files"))
    return copy


def wire(ini, functions, options=()):
    done = subprocess.run(
        [os.path.join(BUILD, "bin", "plumb"), "wire", *functions, "--ini", ini, "--output", output_of(ini), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


def output_of(ini):
    """Several INI files may share a folder."""
    return os.path.join(os.path.dirname(ini), "plumb-" + os.path.basename(ini)[:-4])


def statements(output):
    """(holds, statement) of each trial."""
    return [(found[1] == "ok", found[2]) for found in re.finditer(r"^  (ok|NO)\s+(.*)$", output, re.M)]


def rows(name, functions, status, output):
    seen = dict((text, holds) for holds, text in statements(output))
    steps = ["yes" if seen.get(step) else "no" for step in STEPS]
    for function in functions:
        own = [(text[len(function) + 2 :], holds) for text, holds in seen.items() if text.startswith(function + ": ")]
        failed = [text for text, holds in own if not holds]
        effect = next((text for text, _ in own if " um" in text), "")
        if failed:
            effect = "NO: " + "; ".join(failed)
        elif not own:
            effect = "; ".join(text for text, holds in seen.items() if not holds)
            effect = effect or " ".join(output.split("nothing was written.")[-1].split())[:300]
        yield "| %s | %s | %s | %s |" % (name, function, " | ".join(steps), effect)


def snapshot(root, without=()):
    """Mode, time and content of each file, link and folder below `root`; of the folder in which one of `without` lies, the
    mode alone."""
    found = {}
    parents = {os.path.dirname(path) for path in without}
    for folder, folders, files in os.walk(root):
        folders[:] = [name for name in folders if os.path.join(folder, name) not in without]
        state = os.lstat(folder)
        found[os.path.relpath(folder, root)] = state.st_mode, None if folder in parents else state.st_mtime_ns, None
        for name in [*files, *(name for name in folders if os.path.islink(os.path.join(folder, name)))]:
            path = os.path.join(folder, name)
            state, content = os.lstat(path), None
            if stat.S_ISLNK(state.st_mode):
                content = os.readlink(path)
            elif stat.S_ISREG(state.st_mode):
                with open(path, "rb") as file:
                    content = file.read()
            found[os.path.relpath(path, root)] = state.st_mode, state.st_mtime_ns, content
    return found


def changes(before, after):
    return sorted(name for name in {*before, *after} if before.get(name) != after.get(name))


if __name__ == "__main__":
    sys.exit(main())

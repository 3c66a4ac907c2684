# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on the sample configurations of LinuxCNC, on those in tests/specimens/machines, or on a folder of yours."""

import argparse
import os
import re
import shutil
import stat
import subprocess
import sys
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build"))
sys.path.append(os.path.join(ROOT, "hal", "client"))
from plumb_folder import TemporaryFolder  # noqa: E402

PLUMB = os.path.join(BUILD, "bin", "plumb")
SAMPLES = "/usr/share/doc/linuxcnc/examples/sample-configs"
GALLERY = os.path.join(ROOT, "tests", "specimens", "machines")

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


HEADINGS = ("Configuration", "Function", "starts", "homes", "runs", "seen", "applied, undone", "s", "MB")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", help="other configurations: each INI file in it, as its lines `# wire:` and `# options:` say")
    parser.add_argument("-R", metavar="REGEX", default="", help="only the INI files that it finds")
    parser.add_argument("--samples", metavar="DIR", default=SAMPLES, help="other sample configurations of LinuxCNC")
    parser.add_argument("--show", action="store_true", help="print the output of plumb wire")
    arguments = parser.parse_args()
    works = tried = 0
    with TemporaryFolder("/var/tmp") as folder:
        machines = []
        if not arguments.folder:
            samples = copy_samples(arguments.samples, folder)
            machines = [(os.path.join(samples, path), *rest) for path, *rest in MACHINES]
        gallery = os.path.join(folder, "gallery")
        shutil.copytree(arguments.folder or GALLERY, gallery, symlinks=True)
        machines += described(gallery)
        print("| %s |\n|%s" % (" | ".join(HEADINGS), " --- |" * len(HEADINGS)))
        for ini, functions, options, purpose in machines:
            if not re.search(arguments.R, os.path.relpath(ini, folder)):
                continue
            tried += 1
            name = "%s, %s" % (os.path.basename(ini), purpose)
            if not os.path.exists(ini):
                print("| %s | | not in this LinuxCNC | | | | | | |" % name)
                continue
            works += show(Run(folder, ini, functions, options), name, functions, arguments.show)
    print("\n%d of %d configurations" % (works, tried))
    return 0 if works == tried else 1


def described(folder):
    """INI file, functions, options and purpose of each INI file below a folder, from its first lines."""
    for path in sorted(os.path.join(place, name) for place, _, names in os.walk(folder) for name in names if name.endswith(".ini")):
        with open(path, encoding="utf-8", errors="replace") as file:
            lines = [line.strip("# \r\n") for line in file if line.startswith("#")]
        given = {line.split(":")[0]: line.split(":", 1)[1].split() for line in lines if line.startswith(("wire:", "options:"))}
        purpose = next((line for line in lines if line and not line.startswith(("SPDX", "wire:", "options:"))), "")
        yield path, tuple(given.get("wire", SQUARE)), tuple(given.get("options", ())), purpose


def show(run, name, functions, output):
    """Prints the rows of a configuration. Returns whether all is as it must be."""
    if output:
        print(run.output)
    ends = " | ".join([run.undone, "%.0f" % run.seconds, "%.1f" % run.megabytes])
    for row in rows(name, functions, run.status, run.output):
        print("%s %s |" % (row, ends), flush=True)
    if run.changed:
        print("| %s | CHANGED: %s | | | | | | | |" % (name, ", ".join(run.changed)))
    return run.status == 0 and run.undone == "yes" and not run.changed


class Run:
    """plumb wire --apply on a configuration, and --undo.

    changed     files of the user that the trial changed
    undone      whether the INI file comes back byte for byte with its rights; "-" where nothing was applied
    seconds     of plumb wire --apply
    megabytes   of temporary files, at most
    """

    def __init__(self, root, ini, functions, options, look=lambda own: None):
        """`look` is called with the folder of the files that were written."""
        own, home = [output_of(ini)], os.path.dirname(ini)
        before, files = snapshot(root, own), contents(home)
        begin = time.monotonic()
        with TemporaryFolder("/var/tmp") as temporary, Watch(temporary) as watch:
            self.status, self.output = wire(ini, functions, [*options, "--apply"], TMPDIR=temporary)
        self.seconds, self.megabytes = time.monotonic() - begin, watch.largest / 1e6
        applied = [name for name, text in contents(home).items() if files.get(name) != text and name + ".before-plumb" in contents(home)]
        if self.status == 0:
            look(own[0])
        undone = subprocess.run([PLUMB, "wire", "--undo", "--ini", ini, "--output", own[0]], stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, check=False)
        after = snapshot(root, own)
        shutil.rmtree(own[0], ignore_errors=True)
        # An edited file is a new one: its time differs, and so does the time of its folder.
        edited = {os.path.relpath(os.path.join(home, name), root) for name in applied}
        same = all(before[name][0] == after[name][0] and before[name][2] == after[name][2] for name in edited)
        self.changed = [name for name in changes(before, after) if name not in edited]
        self.undone = "-" if self.status else "yes" if applied and undone.returncode == 0 and same else "NO"


class Watch(threading.Thread):
    """The largest size of the temporary files of plumb wire, in bytes."""

    def __init__(self, place):
        super().__init__(daemon=True)
        self.place, self.largest, self.ended = place, 0, threading.Event()

    def run(self):
        while not self.ended.wait(0.2):
            size = 0
            for folder, _, names in os.walk(self.place):
                size += sum(size_of(os.path.join(folder, name)) for name in names)
            self.largest = max(self.largest, size)

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.join()


def size_of(path):
    try:
        return os.lstat(path).st_blocks * 512
    except OSError:
        return 0


def contents(home):
    """The bytes of each file in a folder, by its name."""
    found = {}
    for entry in os.scandir(home):
        if entry.is_file(follow_symlinks=False):
            with open(entry.path, "rb") as file:
                found[entry.name] = file.read()
    return found


def copy_samples(samples, folder):
    """With the folder to which ../nc_files of the samples leads."""
    copy = os.path.join(folder, "sample-configs")
    shutil.copytree(samples, copy, symlinks=True)
    os.symlink(os.path.join(os.path.dirname(os.path.realpath(samples)), "nc_files"), os.path.join(folder, "nc_files"))
    return copy


def wire(ini, functions, options=(), **environment):
    done = subprocess.run(
        [PLUMB, "wire", *functions, "--ini", ini, "--output", output_of(ini), *options],
        env={**os.environ, **environment},
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

# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawn configurations against plumb wire: they reach out of their folder, and nothing outside may change.

A seed is one machine with several attacks: paths that lead out, links, words for a shell, CRLF, Latin-1, ten thousand
lines, files without rights, a full disk, a folder with an odd name. All files are compared before and after: names, bytes,
times and rights. A traceback, a wrong exit status or a trial that does not end is a finding too.
"""

import os
import random
import re
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import campaign  # noqa: E402  (beside this file)
import wire_samples  # noqa: E402
from plumb_folder import TemporaryFolder  # noqa: E402

PATIENCE = 600  # s
MACHINES = ("axis_mm.ini", "lathe.ini", "axis.ini", "simtcl/twopass_basic.ini", "ini_with_includes/includes_demo.ini")
WINDOW = "#!/usr/bin/python3\nimport tkinter\n"
DRIVERS = ("hal_parport cfg=0x378", "hal_gpio", "uparport", "hm2_eth board_ip=10.10.10.10", "pluto_step")
WORDS = ("$(touch {0}/ran)", "`touch {0}/ran`", ";touch {0}/ran;", "$(id)", "`id`", "a b", "'", '"', "\\", "[exit]", "{{", "*", "$HOME", "\t",
         "\xb0", "..")
WRITTEN = (("RS274NGC", "PARAMETER_FILE"), ("EMCIO", "TOOL_TABLE"), ("TRAJ", "POSITION_FILE"))


class Machine:
    """A copy of a sample, with a folder outside it. The attacks edit it; `done` names them."""

    def __init__(self, draw, root):
        self.draw, self.root, self.done, self.command, self.limit = draw, root, [], [], None
        self.outside, self.home = os.path.join(root, "outside"), os.path.join(root, "home")
        for folder in (self.outside, self.home, os.path.join(self.outside, "shared"), os.path.join(root, "tmp")):
            os.makedirs(folder)
        samples = wire_samples.copy_samples(wire_samples.SAMPLES, root)
        self.ini = os.path.join(samples, "sim", "axis", draw.choice(MACHINES))
        self.folder = os.path.dirname(self.ini)
        for name in ("precious", "shared/precious"):
            self.put(name, "1.5\n2.5\n3.5\n")
        for name in ("linuxcnc_print.txt", "linuxcnc_debug.txt", ".axisrc"):
            shutil.copy(os.path.join(self.outside, "precious"), os.path.join(self.home, name))
        self.writer = self.put("writer", "#!/bin/sh\nfor path in %s/* %s/shared/* %s/* %s/new; do\n  (echo ruined >> $path)\n"
                               "  rm -rf $path\ndone 2>/dev/null\nexit 0\n" % (self.outside, self.outside, self.home, self.outside), 0o755)

    def put(self, name, text, mode=0o644):
        path = os.path.join(self.outside, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(path, mode)
        return path

    def reach(self, path):
        """A way to write the path of a file outside: absolute, relative, by a link to it or to its folder, from HOME."""
        relative = os.path.relpath(path, self.folder)
        name = "way-%d" % self.draw.randrange(10**6)
        way = self.draw.choice(("absolute", "relative", "link", "folder", "home"))
        if way == "link":
            os.symlink(self.draw.choice((path, relative)), os.path.join(self.folder, name))
            return name
        if way == "folder":
            os.symlink(os.path.dirname(path), os.path.join(self.folder, name))
            return os.path.join(name, os.path.basename(path))
        if way == "home":
            os.symlink(path, os.path.join(self.home, name))
            return "~/" + name
        return path if way == "absolute" else relative

    def words(self):
        return self.draw.choice(WORDS).format(self.outside)

    def add(self, section, line):
        with open(self.ini, encoding="utf-8", errors="surrogateescape", newline="") as file:
            text = file.read()
        head = "[%s]\n" % section
        text = text.replace(head, head + line + "\n", 1) if head in text else text + "\n" + head + line + "\n"
        self.write(self.ini, text)

    def write(self, path, text):
        with open(path, "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
            file.write(text)


def halfile(machine):
    driver = machine.draw.choice(DRIVERS)
    path = machine.put("shared/driver-%d.hal" % len(machine.done), "loadrt %s\n" % driver)
    way = machine.reach(path)
    if machine.draw.random() < 0.3:
        more = machine.put("more-%d.hal" % len(machine.done), "source %s\n" % way)
        way = machine.reach(more)
    machine.add("HAL", machine.draw.choice(("HALFILE = %s", "HALFILE = %s", "HALCMD = source %s")) % way)


def include(machine):
    with open(machine.ini, encoding="utf-8", errors="surrogateescape", newline="") as file:
        text = file.read()
    section = machine.draw.choice(re.findall(r"^\[\w+\].*?(?=^\[|\Z)", text, re.M | re.S))
    path = machine.put("part-%d.inc" % len(machine.done), section)
    machine.write(machine.ini, text.replace(section, "\n") + "\n#INCLUDE %s\n" % machine.reach(path))


def written(machine):
    section, name = machine.draw.choice(WRITTEN)
    machine.add(section, "%s = %s" % (name, machine.reach(os.path.join(machine.outside, "precious"))))


def program(machine):
    path = machine.put("view-%d" % len(machine.done), WINDOW, 0o755)
    name = machine.draw.choice(("view", "../../x", "../" * 6 + "etc/x", "x" * 40, machine.words().replace(" ", "")))
    line = "loadusr -Wn %s %s" % (name, machine.reach(path))
    hal = os.path.join(machine.folder, "program-%d.hal" % len(machine.done))
    machine.write(hal, line + "\n")
    machine.add("HAL", "HALFILE = " + os.path.basename(hal))


def command(machine):
    line = machine.draw.choice(("HALCMD = loadusr -w %s", "HALCMD = loadusr %s", "SHUTDOWN = %s", "APP = %s"))
    machine.add("APPLICATIONS" if line.startswith("APP") else "HAL", line % machine.reach(machine.writer))


def tcl(machine):
    path = os.path.join(machine.folder, "escape-%d.tcl" % len(machine.done))
    machine.write(path, "catch {exec %s}\ncatch {open %s/precious w}\n" % (machine.writer, machine.outside))
    machine.add("HAL", "HALFILE = " + os.path.basename(path))


def shell(machine):
    section, name = machine.draw.choice((("HAL", "HALFILE"), ("HAL", "POSTGUI_HALFILE"), ("EMC", "MACHINE"), ("DISPLAY", "DISPLAY"),
                                         ("DISPLAY", "EMBED_TAB_COMMAND"), ("RS274NGC", "SUBROUTINE_PATH"), ("TRAJ", "POSITION_FILE")))
    machine.add(section, "%s = %s" % (name, machine.words()))


def line_ends(machine):
    for path in machine.draw.choice(([machine.ini], files_of(machine, ".hal"), files_of(machine, ".ini"))):
        with open(path, "rb") as file:
            data = file.read()
        with open(path, "wb") as file:
            file.write(data.replace(b"\n", b"\r\n"))


def latin(machine):
    for path in [machine.ini, *files_of(machine, ".hal")]:
        with open(path, "ab") as file:
            file.write(b"\n# caf\xe9 \x80\x0c\x85 \xff\n")


def long_file(machine):
    with open(machine.ini, "a", encoding="utf-8") as file:
        file.write("".join("# line %d\n" % number for number in range(10000)))
    hal = os.path.join(machine.folder, "long.hal")
    machine.write(hal, "".join("# line %d\n" % number for number in range(10000)))
    machine.add("HAL", "HALFILE = long.hal")


def planted(machine):
    names = (".plumb-wire", "bin", "plumb", "plumb.hal", "loop", "deep/loop", "hard")
    for name in machine.draw.sample(names, 3):
        path = os.path.join(machine.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        if os.path.lexists(path):
            continue
        if name == "hard":
            os.link(os.path.join(machine.outside, "precious"), path)
        else:
            os.symlink(machine.draw.choice((machine.outside, ".", "..", "nowhere", os.path.join(machine.outside, "precious"))), path)


def manifest(machine):
    """A folder of plumb wire, made by another, with links in the places of its files."""
    folder = os.path.join(machine.folder, "plumb")
    if os.path.lexists(folder):
        return
    os.mkdir(folder)
    machine.write(os.path.join(folder, ".written.json"), '{"ini": "%s", "functions": [], "files": {}}' % os.path.basename(machine.ini))
    for name in ("plumb.hal.new", ".written.json.new", machine.draw.choice(("plumb.hal", "plumb.inc", "squareness_settings.hal", "x"))):
        os.symlink(os.path.join(machine.outside, "precious"), os.path.join(folder, name))


def no_rights(machine):
    paths = [os.path.join(machine.folder, name) for name in os.listdir(machine.folder)]
    path = machine.draw.choice([path for path in paths if not os.path.islink(path)])
    os.chmod(path, machine.draw.choice((0, 0o200, 0o444)))


def full_disk(machine):
    machine.limit = machine.draw.choice((1 << 10, 1 << 14, 1 << 18, 1 << 20))  # bytes of the longest file


def odd_folder(machine):
    name = re.sub("[/\0]", "", machine.words()) or "odd"
    if name != ".." and len(machine.done) == 0:
        folder = os.path.join(os.path.dirname(machine.folder), name)
        os.rename(machine.folder, folder)
        machine.ini, machine.folder = os.path.join(folder, os.path.basename(machine.ini)), folder


ATTACKS = (odd_folder, halfile, include, written, program, command, tcl, shell, line_ends, latin, long_file, planted, manifest, no_rights,
           full_disk)


def files_of(machine, ending):
    return [os.path.join(machine.folder, name) for name in os.listdir(machine.folder)
            if name.endswith(ending) and os.path.isfile(os.path.join(machine.folder, name))]


def attack(seed):
    draw = random.Random(seed)
    with TemporaryFolder("/var/tmp") as root:
        machine = Machine(draw, root)
        for one in sorted(draw.sample(ATTACKS, draw.randint(1, 4)), key=ATTACKS.index):
            one(machine)
            machine.done.append(one.__name__)
        findings = wire(machine)
    told = "%s of %s" % (", ".join(machine.done), os.path.basename(machine.ini))
    return campaign.Outcome(len(machine.done), ["%s: %s" % (told, text) for text in findings])


def wire(machine):
    own = [os.path.join(machine.folder, "plumb"), os.path.join(machine.root, "tmp")]
    if os.path.islink(own[0]):
        del own[0]
    before = wire_samples.snapshot(machine.root, own)
    limit = ["prlimit", "--fsize=%d" % machine.limit] if machine.limit else []
    words = [*limit, os.path.join(campaign.BUILD, "bin", "plumb"), "wire", "squareness", "--ini", machine.ini]
    environment = {**os.environ, "HOME": machine.home, "TMPDIR": os.path.join(machine.root, "tmp")}
    try:
        done = subprocess.run(words, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              encoding="utf-8", errors="replace", timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return ["it did not end within %d s" % PATIENCE]
    changed = wire_samples.changes(before, wire_samples.snapshot(machine.root, own))
    left = os.listdir(os.path.join(machine.root, "tmp"))
    findings = ["changed " + ", ".join(changed)] if changed else []
    findings += ["left " + ", ".join(left)] if left else []
    if done.returncode not in (0, 1, 2) or "Traceback" in done.stdout:
        findings.append("it ended with status %d: %s" % (done.returncode, done.stdout[-2000:]))
    return findings


if __name__ == "__main__":
    campaign.run("wire", __doc__, attack)

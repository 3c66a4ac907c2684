# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb bench on a collection of machines: which run in virtual time without their hardware, and with which models."""

import argparse
import collections
import os
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build"))
sys.path.append(os.path.join(ROOT, "hal", "client"))
from plumb_folder import TemporaryFolder  # noqa: E402

PLUMB = os.path.join(BUILD, "bin", "plumb")

ERROR = re.compile("(?i)error|can ?not|not found|unknown|failed|no such|there is no|does not exist|undefined|is no |already |requires ")
# A machine that needs no model has this word in the table.
NONE = "none"


def update(path):
    """Lets LinuxCNC convert the files of an older version, as it does at its start. Returns whether it did."""
    with open(path, encoding="utf-8", errors="replace") as file:
        if re.search(r"^\s*VERSION\s*=\s*1\.[1-9]", file.read(), re.M) or shutil.which("update_ini") is None:
            return False
    keep = path + ".before"
    shutil.copy(path, keep)
    done = subprocess.run(["update_ini", "-f", path], stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False)
    if done.returncode != 0:  # it has written a part of the file
        shutil.copy(keep, path)
    return done.returncode == 0


class Machine:
    """What plumb bench did with the INI file of a machine."""

    def __init__(self, path, span, limit):
        begin = time.monotonic()
        self.updated = update(path)
        command = [PLUMB, "bench", "--ini", path, "--models", "--for", span]
        with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True) as bench:
            late = False
            try:
                output = bench.communicate(timeout=limit)[0]
            except subprocess.TimeoutExpired:
                late = True
                os.killpg(bench.pid, signal.SIGTERM)
                try:
                    output = bench.communicate(timeout=20)[0]
                except subprocess.TimeoutExpired:
                    os.killpg(bench.pid, signal.SIGKILL)
                    output = bench.communicate()[0]
        self.path, self.seconds = path, time.monotonic() - begin
        text = output.decode(errors="replace")
        self.runs = not late and bench.returncode == 0
        self.models = models(text)
        self.why = "" if self.runs else "not ended after %g s" % limit if late else reason(text.replace(os.path.dirname(path) + "/", ""))


def models(text):
    """The models that a bench says it put in the place of drivers and programs."""
    found = re.findall(r"^model: (\S+) has \d+ pins", text, re.M)
    for names in re.findall(r"^model: (?!\S+ has \d+ pins)(.+)$", text, re.M):
        found += names.split(", ")
    return sorted(set(found))


def reason(text):
    """Why a machine was not loaded: the first word of halcmd, haltcl or a module that is an error, else the last line."""
    lines = [line.strip() for line in text.splitlines() if line.strip() and not re.match(r"note: |model: |twopass:(invoked|found)", line)]
    telling = [number for number, line in enumerate(lines) if ERROR.search(line)] or [len(lines) - 1]
    told = " ".join(lines[telling[0] :][: 2 if lines and lines[telling[0]].endswith(":") else 1]) or "no word"
    return re.sub(r"^/\S*/", "", told)


def ini_files(place):
    """The INI files of machines in a folder: those that name a HAL file."""
    for folder, folders, names in os.walk(place):
        folders.sort()
        for name in sorted(names):
            path = os.path.join(folder, name)
            if name.endswith(".ini") and os.path.isfile(path) and names_hal_file(path):
                yield path


def names_hal_file(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        return re.search(r"^\s*HALFILE\s*=\s*\S", file.read(), re.M) is not None


def show(machine, name):
    told = "runs with " + (", ".join(machine.models) or "no model") if machine.runs else "DOES NOT RUN: " + machine.why
    print("%-60s %5.1f s  %s%s" % (name, machine.seconds, told, "; converted by update_ini" if machine.updated and machine.runs else ""), flush=True)


def show_sums(machines):
    ran = [machine for machine in machines if machine.runs]
    updated = sum(machine.updated for machine in ran)
    print("\n%d of %d machines run, in %.0f s" % (len(ran), len(machines), sum(machine.seconds for machine in machines)))
    if updated:
        print("%5d of them with files that LinuxCNC's update_ini converted from an older version" % updated)
    counts = collections.Counter(model for machine in ran for model in machine.models or [NONE])
    for model, count in counts.most_common():
        print("%5d with %s" % (count, "model " + model if model != NONE else "no model"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, prog="scripts/bench-configs")
    parser.add_argument("places", nargs="+", metavar="PLACE", help="a folder with machines, or an INI file; a copy runs")
    parser.add_argument("--for", dest="span", default="1s", metavar="TIME", help="virtual time of each machine (1s)")
    parser.add_argument("--limit", type=float, default=120, metavar="S", help="seconds of real time for each machine (120)")
    arguments = parser.parse_args()
    missing = [place for place in arguments.places if not os.path.exists(place)]
    if missing:
        parser.error("there is no file or folder %s" % missing[0])
    machines = []
    for place in map(os.path.abspath, arguments.places):
        folder = place if os.path.isdir(place) else os.path.dirname(place)
        with TemporaryFolder("/var/tmp") as temporary:
            copy = os.path.join(temporary, os.path.basename(folder))
            shutil.copytree(folder, copy, symlinks=True)
            subprocess.run(["chmod", "-R", "u+w", copy], check=True)
            paths = ini_files(copy) if folder == place else [os.path.join(copy, os.path.basename(place))]
            for path in paths:
                machine = Machine(path, arguments.span, arguments.limit)
                machines.append(machine)
                show(machine, os.path.relpath(path, copy))
    if not machines:
        parser.error("no INI file there names a HALFILE")
    show_sums(machines)
    return 0 if any(machine.runs for machine in machines) else 1


if __name__ == "__main__":
    sys.exit(main())

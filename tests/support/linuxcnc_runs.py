# SPDX-License-Identifier: GPL-2.0-or-later
"""How tests start a complete LinuxCNC in virtual time, and read its results."""

import argparse
import csv
import glob
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

from plumb_run import plumb_run  # noqa: E402
from tree import BUILD, ROOT, own_folder  # noqa: F401

PROGRAMS = os.path.join(ROOT, "tests", "programs")
WORKED = 42  # exit status of a scenario (scenario.py), and of no one else
PATIENCE = 200  # seconds, for an event that takes a few
ATTEMPTS = 4
PERIOD = 0.001  # seconds, of the servo thread
nm = 1e-6  # mm
STILL = 1e-3 * nm  # a smaller difference of positions is rounding, and no motion
um = 1e-3  # mm

speed = 10  # times real time


def copy_configuration(name, folder, copy="machine"):
    """Copies it as LinuxCNC's picker and `cp -rL` do: with the targets of its links."""
    machine = shutil.copytree(os.path.join(ROOT, "configs", name), os.path.join(folder, copy))
    # Task gives motion up after a time of the faster clock, which passes on a busy computer.
    change(os.path.join(machine, "common", "controller.inc"), "COMM_TIMEOUT = 30\n", "COMM_TIMEOUT = 300\n")
    for ini in glob.glob(os.path.join(machine, "*.ini")):
        # LinuxCNC waits until the parameters are on the disk, for seconds on a busy one; the memory of a run is its own.
        change(ini, "PARAMETER_FILE = ", "PARAMETER_FILE = /dev/shm/")
    return machine


def change(file, old, new):
    with open(file) as lines:
        text = lines.read()
    if old not in text:
        raise AssertionError("no %r in %s" % (old, file))
    with open(file, "w") as lines:
        lines.write(text.replace(old, new))


def environment(folder, **more):
    """The environment of a run whose home is in a folder."""
    home = os.path.join(folder, "home")
    os.makedirs(home, exist_ok=True)
    return {
        "HOME": home,
        "PATH": os.path.join(BUILD, "bin") + ":/usr/bin:/bin:/usr/sbin:/sbin",
        # A sanitized program minds that libfaketime is loaded before its own library.
        "ASAN_OPTIONS": "verify_asan_link_order=0",
        "PYTHONPATH": os.path.join(ROOT, "tests", "support"),  # of scenarios
        **more,
    }


def use_scenario(ini, scenario):
    """Makes a scenario of PROGRAMS the DISPLAY of a copied configuration."""
    change(ini, "common/headless.py", os.path.join(PROGRAMS, scenario))


def work(folder, ini, *arguments, facts="facts.json"):
    """Starts LinuxCNC, and works through its scenario. Returns its file of facts, and LinuxCNC's output."""
    machine = os.path.dirname(ini)
    fresh = os.path.join(tempfile.mkdtemp(dir=folder), "machine")
    shutil.copytree(machine, fresh)
    for attempt in range(ATTEMPTS):
        if attempt > 0:
            print("LinuxCNC lost a command to its own race, so the scenario starts afresh:\n%s" % output)
            shutil.rmtree(machine)
            shutil.copytree(fresh, machine)
        status, output = finish(start(folder, ini, *arguments))
        if not ended_by_linuxcncs_race(output):
            break
    if status != WORKED:
        raise AssertionError("linuxcnc ended with %d:\n%s" % (status, output))
    with open(os.path.join(os.path.dirname(ini), facts)) as file:
        return json.load(file), output


def ended_by_linuxcncs_race(output):
    """Whether LinuxCNC took a probing move, or the wait for an input, for done before it had begun.

    Task may read motion's status between the echo of a command and the period that begins it. A busy computer widens that gap.
    """
    return "Queue is not empty after" in output or "Probe tripped during non-probe move" in output


def start(folder, ini, *arguments, prefix=()):
    plumb = plumb_run(BUILD, "--speed", "%g" % speed)
    return subprocess.Popen(
        [*prefix, *plumb, "linuxcnc", "-r", ini, *arguments],
        env=environment(folder, ROOT=ROOT, BUILD=BUILD, FOLDER=folder),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def finish(process, patience=PATIENCE):
    """Exit status and output of a process from start()."""
    try:
        output = process.communicate(timeout=patience)[0]
    except subprocess.TimeoutExpired:
        process.terminate()
        raise AssertionError("linuxcnc did not end:\n" + process.communicate()[0]) from None
    return process.returncode, output


def add_operator(machine, ini, operator):
    """An operator of PROGRAMS, with arguments, who works plumb panel in a tab of a copied configuration's screen."""
    shutil.copy(os.path.join(PROGRAMS, operator.split()[0]), machine)
    path = os.path.join(machine, ini)
    change(path, "plumb-panel -x {XID}", "plumb-panel -x {XID} --widgets widgets.json --user anna")
    with open(path, "a") as file:
        file.write("[APPLICATIONS]\nAPP = ./%s\n" % operator)


def work_screen(folder, machine, ini, display, speed, patience=PATIENCE):
    """Starts LinuxCNC with its screen on a display, until the operator has ended it. Returns what this one has seen."""
    python = os.pathsep.join([os.path.join(BUILD, "python"), os.path.join(ROOT, "tests", "support")])
    process = subprocess.Popen(
        [*plumb_run(BUILD, "--speed", "%g" % speed), "linuxcnc", "-r", ini],
        cwd=machine,
        # Without a service for notifications on the session's bus, QtDragon crashes in libdbus.
        env=environment(folder, PYTHONPATH=python, DISPLAY=display, LC_ALL="C.UTF-8", NO_AT_BRIDGE="1", PLUMB_PATIENCE="600",
                        DBUS_SESSION_BUS_ADDRESS="disabled:", PYTHONFAULTHANDLER="1"),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    status, output = finish(process, patience)
    with open(os.path.join(machine, "seen.json")) as file:
        seen = json.load(file)
    if not seen.get("done"):
        raise AssertionError("linuxcnc ended with %d:\n%s\n%s" % (status, output, seen.get("error")))
    return seen


def read_recording(file):
    """Columns of a recording, by name."""
    with open(file) as lines:
        names = next(csv.reader(lines))
        table = np.loadtxt(lines, delimiter=",", ndmin=2)
    return {name: table[:, column] for column, name in enumerate(names)}


def read_scenes(folder, scenes):
    """The recordings of single scenes, by their names."""
    return {scene: read_recording(os.path.join(folder, scene + ".csv")) for scene in scenes}


def rows_of(recording, scenes):
    """The rows of each scene in a recording of all."""
    return {name: np.flatnonzero(recording["scene"] == number) for number, name in enumerate(scenes, start=1)}


def changes(values):
    """The rows in which a value is another than in the row before."""
    return np.flatnonzero(np.diff(values)) + 1


def main(case, description):
    """unittest.main, which with --repeat goes through one test case many times beside busy loops."""
    global speed
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=0, help="go through the shift that often")
    parser.add_argument("--hogs", type=int, default=0, help="busy loops beside it")
    parser.add_argument("--speed", type=float, default=speed, help="times real time")
    options, others = parser.parse_known_args()
    speed = options.speed
    if options.repeat:
        sys.exit(0 if _repeat(case, options.repeat, options.hogs) else 1)
    unittest.main(argv=sys.argv[:1] + others)


def _repeat(case, times, hogs):
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(hogs)]
    failed = []
    try:
        for turn in range(1, times + 1):
            began = time.monotonic()
            tests = unittest.defaultTestLoader.loadTestsFromTestCase(case)
            result = unittest.TextTestRunner(stream=io.StringIO()).run(tests)
            taken = time.monotonic() - began
            print("%3d  %5.1f s  %s" % (turn, taken, "ok" if result.wasSuccessful() else "FAILED"), flush=True)
            if not result.wasSuccessful():
                failed.append(turn)
            for test, trace in result.errors + result.failures:
                print(test, trace)
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
    print("%d of %d shifts at %gx beside %d busy loops" % (times - len(failed), times, speed, hogs))
    return not failed

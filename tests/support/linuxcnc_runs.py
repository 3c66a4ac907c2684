# SPDX-License-Identifier: GPL-2.0-or-later
"""How tests start a complete LinuxCNC in virtual time, and read its results."""

import argparse
import csv
import io
import json
import os
import shutil
import subprocess
import sys
import time
import unittest

import numpy as np

import restarts
from plumb_folder import TemporaryFolder  # noqa: E402
from plumb_run import plumb_run  # noqa: E402
from tree import BUILD, ROOT, own_folder  # noqa: F401

PROGRAMS = os.path.join(ROOT, "tests", "programs")
WORKED = 42  # exit status of a scenario (scenario.py), and of no one else
PATIENCE = 300  # seconds, for an event that takes up to a hundred on a quiet computer
ATTEMPTS = 2  # of a run that LinuxCNC's race ends
PERIOD = 0.001  # seconds, of the servo thread
nm = 1e-6  # mm
STILL = 1e-3 * nm  # a smaller difference of positions is rounding, and no motion
um = 1e-3  # mm

speed = 10  # times real time


def copy_configuration(name, folder, copy="machine"):
    """Copies it by `plumb example`, and returns its folder."""
    place = os.path.join(folder, copy)
    subprocess.run([os.path.join(BUILD, "bin", "plumb"), "example", name, place], stdout=subprocess.DEVNULL, timeout=60, check=True)
    return place


def own_ini(ini, **sections):
    """Writes the INI file of a test beside one of a configuration, with its sections and the test's. Returns its path.

    LinuxCNC starts with it only if the functions of Plumb are in the order of their pages.

    sections  a section -> lines in place of those of the same name, or further ones; or a function that makes the lines of
              the test of the lines of the configuration
    """
    folder, name = os.path.split(ini)
    given = _sections(ini)[0]
    # The memory of a run is its own. On a busy disk LinuxCNC waits for seconds until the parameters are written, and task
    # gives motion up after a time of the faster clock.
    sections = {"RS274NGC": ["PARAMETER_FILE = /dev/shm/linuxcnc.var"], "EMCMOT": ["COMM_TIMEOUT = 300"], "HAL": at_the_end(), **sections}
    for section, own in sections.items():
        its = given.get(section, [])
        names = [line.split("=")[0].strip() for line in own] if not callable(own) else []
        given[section] = own(its) if callable(own) else own + [line for line in its if line.split("=")[0].strip() not in names]
    given["HAL"].append("HALCMD = loadusr -w plumb doctor --running")  # LinuxCNC ends where a function is in a wrong place
    with open(os.path.join(folder, "scene.hal"), "w") as file:
        file.write("newsig scene s32\n")
    # On a busy computer task and io stand still for longer than beside four busy loops.
    stages = next((line for line in given["HAL"] if line.endswith("stages.hal")), None)
    if stages:
        given["HAL"].insert(given["HAL"].index(stages) + 1, "HALFILE = patience.hal")
        with open(os.path.join(folder, "patience.hal"), "w") as file:
            file.write("".join("setp interlock.service-timeout-%d 60\n" % service for service in (4, 5)))
    path = os.path.join(folder, "test_" + name)
    with open(path, "w") as file:
        for section, lines in given.items():
            file.write("\n".join(["[%s]" % section, *lines, "", ""]))
    return path


def after(line, *more):
    """[HAL] of own_ini: puts lines behind one of them."""

    def put(lines):
        place = lines.index(line) + 1
        return ["HALFILE = scene.hal", *lines[:place], *more, *lines[place:]]

    return put


def at_the_end(*more):
    """[HAL] of own_ini: puts lines behind all of them."""
    return lambda lines: ["HALFILE = scene.hal", *lines, *more]


def _sections(ini, section=None, found=None):
    """The lines of each section, with those of included files."""
    found = {} if found is None else found
    with open(ini) as file:
        for line in map(str.strip, file):
            if line.startswith("#INCLUDE "):
                section = _sections(os.path.join(os.path.dirname(ini), line.split(None, 1)[1]), section, found)[1]
            elif line.startswith("["):
                section = line.strip("[]")
            elif line and not line.startswith("#"):
                found.setdefault(section, []).append(line)
    return found, section


def change(file, old, new):
    """Replaces text in a program or a settings file of a copy; [HAL] and other sections of an INI file are those of own_ini."""
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
    machine_id = os.path.join(folder, "machine-id")  # a chroot may have none
    with open(machine_id, "w") as file:
        file.write("0123456789abcdef0123456789abcdef\n")
    return {
        "HOME": home,
        "PLUMB_MACHINE_ID": machine_id,
        "PATH": os.path.join(BUILD, "bin") + ":/usr/bin:/bin:/usr/sbin:/sbin",
        # A sanitized program minds that libfaketime is loaded before its own library.
        "ASAN_OPTIONS": "verify_asan_link_order=0",
        "PYTHONPATH": os.path.join(ROOT, "tests", "support"),  # of scenarios
        "PLUMB_STORIES": os.environ.get("PLUMB_STORIES", ""),  # of fingers
        **more,
    }


def work(folder, ini, scenario, *arguments, facts="facts.json", options=(), patience=PATIENCE):
    """Starts LinuxCNC, and works through a scenario of PROGRAMS. Returns its file of facts, and LinuxCNC's output."""
    machine = os.path.dirname(ini)
    arguments = [os.path.join(PROGRAMS, scenario), *arguments]
    status, output = run_to_the_end(machine, lambda: start(folder, ini, *arguments, options=options), patience)
    if status != WORKED:
        raise AssertionError("linuxcnc ended with %d:\n%s" % (status, output))
    with open(os.path.join(os.path.dirname(ini), facts)) as file:
        return json.load(file), output


def run_to_the_end(machine, begin, patience=PATIENCE):
    """Exit status and output of a process from begin(). Begins again, in the folder of before, after LinuxCNC's race."""
    with TemporaryFolder() as folder:
        fresh = shutil.copytree(machine, os.path.join(folder, "machine"), symlinks=True)
        for _ in range(ATTEMPTS):
            status, output = finish(begin(), patience)
            if not ended_by_linuxcncs_race(output):
                break
            restarts.note(restarts.RACE, output)
            shutil.rmtree(machine)
            shutil.copytree(fresh, machine, symlinks=True)
    return status, output


def ended_by_linuxcncs_race(output):
    """Whether LinuxCNC took a probing move, or the wait for an input, for done before it had begun (hal/host/motion_status.hpp)."""
    return "Queue is not empty after" in output or "Probe tripped during non-probe move" in output


def start(folder, ini, *arguments, prefix=(), options=(), at=None):
    """Starts LinuxCNC at so many times the clock; options are further ones of plumb run."""
    plumb = plumb_run(BUILD, "--speed", "%g" % (at or speed), *options)
    return subprocess.Popen(
        [*prefix, *plumb, "linuxcnc", ini, *arguments],
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


def with_operator(ini, operator, **more):
    """own_ini with an operator of PROGRAMS, with arguments, who works plumb panel in a tab of the screen."""
    panel = "EMBED_TAB_COMMAND = plumb-panel -x {XID}"

    def shown_to(lines):
        return [line.replace(panel, panel + " --widgets widgets.json --user anna") for line in lines]

    return own_ini(ini, DISPLAY=shown_to, APPLICATIONS=["APP = " + os.path.join(PROGRAMS, operator)], **more)


def work_screen(folder, ini, display, speed, patience=PATIENCE, program=None):
    """Starts LinuxCNC with its screen on a display, or a program that does, until the operator has ended it. Returns what this one has seen."""
    machine = os.path.dirname(ini)
    python = os.pathsep.join(os.path.join(*parts) for parts in ((BUILD, "python"), (ROOT, "tests", "support"), (ROOT, "scripts")))
    process = subprocess.Popen(
        [*plumb_run(BUILD, "--speed", "%g" % speed), *(program or ["linuxcnc", "-r", ini])],
        cwd=machine,
        # Without a service for notifications on the session's bus, QtDragon crashes in libdbus. Root's browser refuses its sandbox.
        env=environment(folder, ROOT=ROOT, BUILD=BUILD, PYTHONPATH=python, DISPLAY=display, LC_ALL="C.UTF-8", NO_AT_BRIDGE="1", PLUMB_PATIENCE="600",
                        DBUS_SESSION_BUS_ADDRESS="disabled:", QTWEBENGINE_DISABLE_SANDBOX="1", PYTHONFAULTHANDLER="1"),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    status, output = finish(process, patience)
    try:
        with open(os.path.join(machine, "seen.json")) as file:
            seen = json.load(file)
    except FileNotFoundError:
        seen = {"error": "LinuxCNC ended before the operator"}
    if not seen.get("done"):
        raise AssertionError("linuxcnc ended with %d:\n%s\n%s" % (status, output, seen.get("error")))
    return seen


def despite_axis(work):
    """Carries out work() again, twice at most, if AXIS has lost a command or a press."""
    for _ in range(2):
        try:
            return work()
        except AssertionError as error:
            restarts.note(restarts.AXIS, error)
    return work()


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

# SPDX-License-Identifier: GPL-2.0-or-later
"""A complete LinuxCNC at work beside busy loops: how long its task and io pause, and whether one is taken for lost.

A seed is a LinuxCNC of configs/grinder at the clock's speed for a minute. It strokes, and meanwhile loads and runs programs of ten
thousand lines, runs a remap in Python that computes, and changes tools, in a drawn order. The longest pauses of task and io are
printed, as linuxcnc_alive(1) measures them, and how late a program woke that only sleeps: by as much the computer is too slow
for all programs. A service of interlock that is lost is a finding, and so is a pause that is, without this delay, longer than a
third of the time-out.
"""

import json
import os
import random
import shutil
import subprocess
import sys

import campaign

sys.path.insert(1, os.path.join(campaign.ROOT, "scripts"))
from plumb_folder import TemporaryFolder  # noqa: E402
from plumb_run import plumb_run  # noqa: E402

TIME_OUT = 2.5  # s, of task and io in configs/common/alive.hal
PATIENCE = 120  # s, for LinuxCNC to start and end beside busy loops

# grinder.ini, and a remap in Python.
INI = """\
[EMC]
VERSION = 1.1
MACHINE = Plumb grinder

#INCLUDE common/display.inc
DISPLAY = common/headless.py

#INCLUDE common/controller.inc
#INCLUDE common/tools.inc
#INCLUDE common/interpreter.inc
#INCLUDE chop.inc
REMAP = M410 modalgroup=10 python=compute
PARAMETER_FILE = linuxcnc.var

[PYTHON]
PATH_PREPEND = .
TOPLEVEL = remap.py

#INCLUDE common/xyz.inc
#INCLUDE common/x_axis.inc
#INCLUDE common/y_axis.inc
#INCLUDE z_axis.inc
#INCLUDE grinder_hal.inc
"""

# A table of fifty thousand rows is read, and a correction found in it.
REMAP = """\
import remap
from interpreter import INTERP_OK

def compute(self, **words):
    rows = [tuple(map(float, ("%d %d" % (i, i * i % 97)).split())) for i in range(50000)]
    self.params["compute"] = sum(b * (a - 25000) ** 2 for a, b in rows) / 1e12
    return INTERP_OK
"""

WORK = """\
#!/usr/bin/python3
import json, os, random, sys, threading, time
from plumb_linuxcnc import Machine

seed, seconds, lines = int(sys.argv[-3]), float(sys.argv[-2]), int(sys.argv[-1])
draw = random.Random(seed)
SERVICES = {0: "retain", 1: "linuxcnc_link", 4: "task", 5: "io"}

late = 0

def sleep():
    global late
    while True:
        began = time.monotonic()
        time.sleep(0.01)
        late = max(late, time.monotonic() - began - 0.01)

threading.Thread(target=sleep, daemon=True).start()
with Machine(timeout=%(patience)d) as machine:
    host = machine.host
    machine.turn_on()
    machine.home()
    while not host.get("interlock.function-enable-0"):
        machine.poll()
        time.sleep(0.1)
    for service, name in SERVICES.items():
        host.expect(name + " == 0", **{name: "interlock.service-lost-%%d" %% service})
    machine.mdi("G0 X0 Y0 Z10")
    machine.mdi("M64 P18")  # strokes outlast a program
    machine.mdi("M3 S1000 G81.1 Z5 Q-30 R5 P3600")

    def program():
        with open("long.ngc", "w") as file:
            file.write("F6000\\n")
            for line in range(lines):
                file.write("G1 X%%.4f Y%%.4f\\n" %% (line %% 400 * 0.05, draw.random() * 0.02))
            file.write("M2\\n")
        machine.run("long.ngc")

    def remap():
        for _ in range(5):
            machine.mdi("M410")

    def tools():
        machine.mdi("T%%d M6" %% draw.choice((1, 2)))

    began = time.monotonic()
    while time.monotonic() < began + seconds:
        draw.choice((program, remap, tools))()
    lost = sorted(next(iter(each.values)) for each in host.violations())
    pauses = {name: host.get("linuxcnc-alive.longest-%%s-pause" %% name) for name in ("task", "io")}
    with open("seen.json", "w") as file:
        json.dump({"pauses": pauses, "late": late, "lost": lost, "strokes": host.get("chop.active")}, file)
""" % {"patience": PATIENCE}


def attack(seed):
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(options.hogs)]
    try:
        with TemporaryFolder() as folder:
            return one_run(seed, folder)
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def one_run(seed, folder):
    machine = shutil.copytree(os.path.join(campaign.ROOT, "configs", "grinder"), os.path.join(folder, "machine"))
    for name, text in (("alive.ini", INI), ("remap.py", REMAP), ("work.py", WORK)):
        with open(os.path.join(machine, name), "w", encoding="utf-8") as file:
            file.write(text)
    os.chmod(os.path.join(machine, "work.py"), 0o755)
    path = os.path.join(campaign.BUILD, "bin") + ":/usr/bin:/bin:/usr/sbin:/sbin"
    environment = {"HOME": folder, "PATH": path, "PYTHONPATH": os.path.join(campaign.BUILD, "python")}
    ini, work = os.path.join(machine, "alive.ini"), os.path.join(machine, "work.py")
    words = [*plumb_run(campaign.BUILD, "--speed", "1"), "linuxcnc", "-r", ini, work, str(seed), "%g" % options.seconds, str(options.lines)]
    limit = 10 * options.seconds + 2 * PATIENCE
    done = subprocess.run(words, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=limit, check=False)
    try:
        with open(os.path.join(machine, "seen.json"), encoding="utf-8") as file:
            seen = json.load(file)
    except FileNotFoundError:
        return campaign.Outcome(1, ["LinuxCNC ended with %d: %s" % (done.returncode, (done.stdout + done.stderr)[-1500:])])
    words = "seed %d: longest pause of task %.2f s, of io %.2f s; a sleeping program woke %.2f s late"
    print(words % (seed, seen["pauses"]["task"], seen["pauses"]["io"], seen["late"]), flush=True)
    findings = ["%s was taken for lost" % name for name in seen["lost"]]
    findings += ["%s paused for %.2f s, and its time-out is %g s" % (name, pause, TIME_OUT)
                 for name, pause in seen["pauses"].items() if 3 * (pause - seen["late"]) > TIME_OUT]
    if not seen["strokes"]:
        findings.append("the stroke has ended")
    return campaign.Outcome(1, findings)


if __name__ == "__main__":
    options = None

    def add_options(parser):
        parser.add_argument("--hogs", type=int, default=4, metavar="N", help="busy loops beside it (default: 4)")
        parser.add_argument("--lines", type=int, default=10000, metavar="N", help="lines of its programs (default: 10000)")
        parser.add_argument("--seconds", type=float, default=60, metavar="S", help="how long a LinuxCNC works (default: 60)")

    def prepare(given):
        global options
        options = given

    campaign.run("alive", "Measures the pauses of LinuxCNC's task and io at work, and looks for a loss that is none.", attack,
                 add_options=add_options, prepare=prepare)

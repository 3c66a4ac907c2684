#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Lets the N-th system call, or the N-th allocation, of each program of Plumb fail.

A seed is one case: a program, a kind of call, and the error that it gets: a full disk, no free descriptor, a refused name.
The program runs once undisturbed, then once for each N, or for as many as are drawn where there are many. Each time it must
end with a sentence or go on rightly. A signal, a traceback, an end without a word, a wrong result with exit status 0, a
file of the user that is lost or half written, a leftover, and a program that does not end are findings.
"""

import contextlib
import errno
import glob
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import campaign  # noqa: E402  (beside this file)
from plumb_folder import TemporaryFolder  # noqa: E402

ROOT, BUILD = campaign.ROOT, os.path.realpath(campaign.BUILD)
BIN = os.path.join(BUILD, "bin")
FAIL_CALL = os.path.join(BUILD, "specimens", "fail_call")
FAIL_ALLOCATION = os.path.join(BUILD, "specimens", "fail_allocation.so")
PYTHON = "/usr/bin/python3"
PATIENCE = 60  # s, for a program to end
MOST = 40  # runs of a seed
TRACES = ("Traceback", "terminate called", "Exception ignored", "AddressSanitizer", "runtime error:", "pure virtual")
TEMPORARY = "/tmp"
NOISE = "Running with fallback_uid"  # of LinuxCNC's rtapi_app

# Kind of call (tests/programs/fail_call.cpp) and the errors that it gets.
ERRORS = {
    "open": (errno.EMFILE, errno.EACCES),
    "read": (errno.EIO, errno.EINTR),
    "write": (errno.ENOSPC, errno.EIO, errno.EINTR),
    "sync": (errno.EIO, errno.ENOSPC),
    "name": (errno.EACCES, errno.EDQUOT),
    "state": (errno.EIO,),
    "socket": (errno.ENOBUFS, errno.EINTR, errno.ECONNRESET),
    "wait": (errno.EINTR,),
    "process": (errno.EAGAIN, errno.EMFILE),
    "memory": (errno.ENOMEM,),
    "allocation": (errno.ENOMEM,),
}

HAL = """\
loadrt threads name1=servo-thread period1=1000000
loadrt siggen names=wave
loadrt limit3 names=limit
setp limit.max 1
setp limit.min -1
net command wave.sine => limit.in
addf wave.update servo-thread
addf limit servo-thread
"""


class Fault:
    """The N-th call of a kind fails with an error; N = 0: none does."""

    def __init__(self, kind, error, number, folder):
        self.kind, self.error, self.number = kind, error, number
        self.report, self.failed = os.path.join(folder, "report"), os.path.join(folder, "allocation-failed")
        for path in (self.report, self.failed):
            with contextlib.suppress(FileNotFoundError):
                os.unlink(path)

    def words(self, *command, ours=()):
        """The command, and with it the fault."""
        kind, number = ("sync", 0) if self.kind == "allocation" else (self.kind, self.number)
        return [FAIL_CALL, kind, str(self.error), str(number), self.report, BUILD + "/", *ours, "--", *command]

    def environment(self, program):
        if self.kind != "allocation":
            return {}
        return {"LD_PRELOAD": FAIL_ALLOCATION, "FAIL_PROGRAM": program, "FAIL_REPORT": self.failed, "FAIL_ALLOCATION": str(self.number)}

    def _line(self, number):
        with contextlib.suppress(OSError, IndexError):
            with open(self.report, encoding="utf-8", errors="replace") as file:
                return file.read().split("\n")[number]
        return ""

    @property
    def count(self):
        return int(self._line(0) or 0)

    @property
    def call(self):
        """The name of the call that failed, and its file; empty if there were not so many."""
        if self.kind == "allocation":
            return "allocation" if os.path.exists(self.failed) else ""
        return self._line(1)

    @property
    def status(self):
        return int(self._line(2)) if self._line(2) else None


class Run:
    """What a program left: its exit status, None if it did not end, its words, and its results by name."""

    def __init__(self, status, out, err, results):
        self.status, self.out, self.err, self.results = status, out, err, results


# --- programs that run to their end ---


class Program:
    """A program with arguments. A scenario has a name, kinds of calls, and run(folder, fault) -> (Run, findings)."""

    kinds = ("open", "read", "write", "sync", "name", "state", "process", "allocation")
    program = "plumb"  # whose allocations fail
    ours = ()  # interpreters whose calls count
    own_files = ()  # names of the user's files in the folder: each stays as it was or becomes as in a good run

    def __init__(self, name):
        self.name = name

    def prepare(self, folder):
        """Files that are there before."""

    def command(self, folder):
        raise NotImplementedError

    def results(self, folder):
        """Texts by name that a good run always gives."""
        return {}

    def run(self, folder, fault):
        work, temporary = os.path.join(folder, "work"), os.path.join(folder, "tmp")
        for path in (work, temporary):
            shutil.rmtree(path, ignore_errors=True)
            os.mkdir(path)
        self.prepare(work)
        before = {name: read(os.path.join(work, name)) for name in self.own_files}
        environment = {**os.environ, "TMPDIR": temporary, "HOME": work, "LC_ALL": "C", "PYTHONPATH": os.path.join(BUILD, "python"),
                       **fault.environment(self.program)}
        out, err = (os.path.join(folder, name) for name in ("output", "errors"))
        with open(out, "wb") as output, open(err, "wb") as errors:
            process = subprocess.Popen(fault.words(*self.command(work), ours=self.ours), cwd=work, env=environment,
                                       stdin=subprocess.DEVNULL, stdout=output, stderr=errors, start_new_session=True)
            status = await_end(process)
        run = Run(status, read(out) or "", read(err) or "", self.results(work))
        findings = []
        for name, old in before.items():
            run.results[name] = read(os.path.join(work, name))
            if self.good and run.results[name] not in (old, self.good.results[name]):
                findings.append("%s is %s" % (name, "lost" if run.results[name] is None else "half written"))
        left = os.listdir(temporary)
        if left and fault.kind not in ("name", "state"):
            findings.append("left in TMPDIR: " + ", ".join(left))
        return run, findings

    good = None

    def judge(self, run, fault):
        """Findings about the end of a program."""
        words = run.err + run.out
        if run.status is None:
            return ["it does not end within %d s" % PATIENCE]
        findings = ["it reports '%s'" % trace for trace in TRACES if trace in words]
        if run.status >= 128:
            findings.append("it ended by signal %d" % (run.status - 128))
        elif run.status != 0 and not self.told(run):
            findings.append("it ended with status %d, without a word" % run.status)
        elif run.status == 0 and self.good:
            if self.shape(run.out) != self.shape(self.good.out):
                findings.append("exit status 0, with another output")
            findings += ["exit status 0, with another %s" % name for name, text in self.good.results.items()
                         if run.results.get(name) != text]
        return findings

    @staticmethod
    def told(run):
        """Whether it has reported a failure."""
        return any(line.strip() and not line.startswith(NOISE) for line in run.err.split("\n"))

    @staticmethod
    def shape(output):
        """An output without what differs from run to run."""
        return re.sub(r"in [\d.e-]+ [mun]?s, [\d.e+-]+ times real time|\d+\.\d+|plumb-host-\w+|/tmp/[\w./-]+", "#", output)


def await_end(process, patience=None):
    """The exit status, 128 + N for a signal; None for a process that had to be killed, with all of its group."""
    try:
        status = process.wait(PATIENCE if patience is None else patience)
        return status if status >= 0 else 128 - status
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return None


def read(path):
    try:
        with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
            return file.read()
    except OSError:
        return None


def write(path, text, mode=0o644):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
        file.write(text)
    os.chmod(path, mode)


class Squareness(Program):
    program = "plumb-squareness"

    def command(self, folder):
        return [os.path.join(BIN, "plumb-squareness"), "--chain", "w-X-Y.b-Z-C-t", "--square", "move=Y,plunger=+X,at=0:300mm,reads=0:20um,u=1um"]


class Bench(Program):
    kinds = (*Program.kinds, "socket", "wait", "memory")

    def prepare(self, folder):
        write(os.path.join(folder, "limit.hal"), HAL)

    def command(self, folder):
        return [os.path.join(BIN, "plumb"), "bench", "limit.hal", "--for", "2", "--record", "limit.out", "--every", "0.1", "--output", "z.csv",
                "--expect", "abs({limit.out}) <= 1.001"]

    def results(self, folder):
        return {"z.csv": read(os.path.join(folder, "z.csv"))}


class BenchHost(Bench):
    """The same, with the allocations of its host."""

    program = "plumb-host"
    kinds = ("allocation",)


class RunProgram(Program):
    """plumb run, with a program that writes into /tmp."""

    kinds = (*Program.kinds, "socket", "wait", "memory")
    program = "plumb-host"

    def prepare(self, folder):
        self.brought = os.path.join(TEMPORARY, "plumb-calls-%d" % os.getpid())
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.brought)
        write(os.path.join(folder, "limit.hal"), HAL + "start\n")
        write(os.path.join(folder, "program"), "#!/bin/sh\nset -e\nhead -c 30000 /dev/zero > %s\nhalcmd -f limit.hal\n"
              "halcmd -s show thread servo-thread > threads\nhalcmd unload all\n" % self.brought, 0o755)

    def command(self, folder):
        return [os.path.join(BIN, "plumb"), "run", "--", "./program"]

    def results(self, folder):
        text = read(self.brought)
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.brought)
        return {"the file in /tmp": text and len(text)}


class Doctor(Program):
    kinds = ("open", "read", "write", "state", "process", "socket", "allocation")

    def command(self, folder):
        return [os.path.join(BIN, "plumb"), "doctor"]

    @staticmethod
    def told(run):
        return Program.told(run) or "WRONG" in run.out

    @staticmethod
    def shape(output):
        return ""  # it reports what it could not find


class Growth(Program):
    """The report of a growth test, into a folder that has an older one."""

    program = "plumb-growth"
    own_files = ("out/report.html", "out/results.json", "out/results.csv")
    log = None

    def prepare(self, folder):
        if Growth.log is None:
            Growth.log = growth_log_text()
        write(os.path.join(folder, "growth.csv"), Growth.log)
        for name in self.own_files:
            write(os.path.join(folder, name), "old\n")

    def command(self, folder):
        return [os.path.join(BIN, "plumb-growth"), "report", "growth.csv", "--output", "out"]

    @staticmethod
    def shape(output):
        return Program.shape(re.sub(r"(?m)^No charts: .*\n", "", output))  # it says so


def growth_log_text():
    """A log of the simulated machine."""
    sys.path[1:1] = [os.path.join(ROOT, "scripts", "benches"), os.path.join(BUILD, "python")]
    os.environ.setdefault("PLUMB_BUILD", BUILD)
    from support.growth_tests import run_test

    with TemporaryFolder() as folder:
        return read(run_test(folder, 3))


class Dbc(Program):
    kinds = ("open", "read", "write", "state")
    ours = (PYTHON,)

    def prepare(self, folder):
        shutil.copy(os.path.join(ROOT, "tests", "programs", "machine.dbc"), folder)

    def command(self, folder):
        return [os.path.join(BIN, "can_sensor_dbc"), "machine.dbc", "--list"]


class ToolTable(Program):
    kinds = ("open", "read", "write", "sync", "name", "state")
    ours = (PYTHON, os.path.join(ROOT, "configs") + "/")  # where Python looks for modules
    own_files = ("tool.tbl",)

    def prepare(self, folder):
        write(os.path.join(folder, "tool.tbl"), "T1 P1 Z10.5\nT2 P2 Z20.25 ; drill\n" * 500)

    def command(self, folder):
        return [PYTHON, os.path.join(ROOT, "configs", "functions", "centre_height", "tool_table_check"), "--copy", "tool.tbl"]

    def results(self, folder):
        return {"copy": read(os.path.join(folder, "tool.tbl.copy-1"))}

    def run(self, folder, fault):
        run, findings = super().run(folder, fault)
        copies = [read(path) for path in glob.glob(os.path.join(folder, "work", "tool.tbl.copy-*[0-9]"))]
        if self.good and [copy for copy in copies if copy != self.good.results["copy"]]:
            findings.append("the copy of the tool table is half written")
        return run, findings


# Runs plumb wire with trials that were recorded, or records them: WORD FOLDER, then its command line.
TRIALS = """
import glob, os, runpy, shutil, sys
_, build, word, folder, *arguments = sys.argv
sys.path[:0] = [os.path.join(build, "share", "plumb", name) for name in ("wiring", "models")]
import trial
number, start = [0], trial.Trial._linuxcnc
def known(source, to):
    for path in [os.path.join(source, name) for name in os.listdir(source)]:
        if os.path.basename(path).startswith(("show-", "result.json", "ready")):
            shutil.copy(path, to)
def linuxcnc(self):
    place = os.path.join(folder, str(number[0]))
    number[0] += 1
    if word == "replay":
        known(place, self.own)
        return 0, ""
    ended = start(self)
    os.makedirs(place)
    known(self.own, place)
    return ended
trial.Trial._linuxcnc = linuxcnc
sys.argv = [os.path.join(build, "bin", "plumb-wire"), *arguments]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


class Wire(Program):
    """plumb wire, whose trials were recorded once. After a failure it is started again, and must do its work."""

    kinds = ("open", "read", "write", "sync", "name", "state")
    ours = (PYTHON,)
    trials = None

    def prepare(self, folder):
        sys.path.insert(1, os.path.join(ROOT, "scripts"))
        import wire_samples

        samples, copy = os.path.join(wire_samples.SAMPLES, "sim", "axis"), os.path.join(folder, "sim", "axis")
        os.makedirs(copy)
        for entry in os.scandir(samples):
            if entry.is_file() and entry.name.startswith(("axis_mm", "sim_mm", "axis_manualtoolchange", "postgui")):
                shutil.copy(entry.path, copy)
        self.ini = os.path.join(copy, "axis_mm.ini")
        if Wire.trials is None:
            Wire.holder = TemporaryFolder("/var/tmp")
            done = subprocess.run(self.words("record", Wire.holder.name), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                  env={**os.environ, "PYTHONPATH": os.path.join(BUILD, "python")}, check=False)
            if done.returncode != 0:
                raise RuntimeError("plumb wire, undisturbed: " + done.stderr[-1000:])
            Wire.trials = Wire.holder.name
            shutil.rmtree(self.output)

    @property
    def output(self):
        return os.path.join(os.path.dirname(self.ini), "plumb")

    def words(self, word, trials):
        return [PYTHON, "-c", TRIALS, BUILD, word, trials, "squareness", "--ini", self.ini]

    def command(self, folder):
        return self.words("replay", Wire.trials)

    def results(self, folder):
        texts = {}
        for base, _, names in os.walk(folder):
            for name in names:
                path = os.path.join(base, name)
                texts[os.path.relpath(path, folder)] = read(path)
        return texts

    def run(self, folder, fault):
        run, findings = super().run(folder, fault)
        if self.good and run.status not in (0, None):
            again = subprocess.run(self.words("replay", Wire.trials), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                   env={**os.environ, "PYTHONPATH": os.path.join(BUILD, "python")}, check=False)
            if again.returncode != 0:
                findings.append("it does not do its work afterwards: " + " ".join(again.stderr.split()))
            elif self.results(os.path.join(folder, "work")) != self.good.results:
                findings.append("its next start leaves other files")
        return run, findings

    def judge(self, run, fault):
        findings = super().judge(run, fault)
        if self.good:
            findings += ["%s of the user is changed" % name for name, text in self.good.results.items()
                         if "/axis/plumb/" not in name and run.results.get(name) != text]
        return findings

    @staticmethod
    def shape(output):
        return ""  # a file that cannot be read need not be copied


# --- programs beside a host ---


class Beside(Program):
    """A program that HAL loads. work(host, until) tries it; stored(folder) judges its files."""

    kinds = ("open", "read", "write", "sync", "name", "state", "socket", "wait", "process", "memory", "allocation")
    component = None  # its name in HAL
    hal = ("loadrt threads name1=servo-thread period1=1000000",)

    def words(self, folder):
        raise NotImplementedError

    def work(self, host, until):
        """Returns once it has worked as in a good run."""

    def stored(self, folder, run):
        return []

    def run(self, folder, fault):
        sys.path.insert(1, os.path.join(BUILD, "python"))
        import plumb

        work, out = os.path.join(folder, "work"), os.path.join(folder, "errors")
        shutil.rmtree(work, ignore_errors=True)
        os.mkdir(work)
        self.prepare(work)
        words = fault.words(*self.words(work), ours=self.ours)
        settings = "".join("export %s='%s'\n" % item for item in fault.environment(self.program).items())
        script = os.path.join(folder, "script")
        write(script, "#!/bin/sh\n%sexec %s > %s 2>&1\n" % (settings, " ".join("'%s'" % word for word in words), out), 0o755)
        write(out, "")
        findings, worked = [], False
        with plumb.Host(modules=[os.path.join(BUILD, "specimens")]) as host:
            for line in self.hal:
                host.load(line) if line.endswith(".hal") else host.command(line)
            self.folder = work
            with contextlib.suppress(plumb.Refused):
                host.command("loadusr -Wn %s %s" % (self.component, script))
                worked = self.try_work(host, fault)
                # One failure is over when it is: a program that lives has to do its work. A full disk stays full.
                if not worked and fault.status is None and fault.error != errno.ENOSPC:
                    findings.append("it goes on, and does not do its work")
                host.command("unloadusr " + self.component)
            end = time.monotonic() + PATIENCE
            while host.programs() and time.monotonic() < end:
                time.sleep(0.005)
            if host.programs():
                findings.append("it does not end within %d s" % PATIENCE)
        run = Run(fault.status if fault.status is not None else -1, "", read(out) or "", {})
        if not worked and not run.err.strip():
            findings.append("it did not do its work, and reported nothing")
        return run, findings + self.stored(work, run)

    def try_work(self, host, fault):
        class Late(Exception):
            pass

        end = time.monotonic() + (5 if fault.error == errno.ENOSPC else 20)

        def until(condition):
            while not condition():
                if time.monotonic() > end or fault.status is not None:
                    raise Late
                host.run(0.01)
                time.sleep(0.001)

        try:
            self.work(host, until)
            return True
        except Late:
            return False

    def get(self, host, name):
        import plumb

        with contextlib.suppress(plumb.Refused):
            return host.get(name)
        return None


def checksummed(rest):
    return "# retain 1, CRC-32 of the rest: %08x\n%s" % (zlib.crc32(rest.encode()), rest)


class Retain(Beside):
    component = program = "plumb-retain"
    hal = ("loadrt threads name1=servo-thread period1=1000000", "loadrt specimen names=it", "addf it.update servo-thread", "start")

    def prepare(self, folder):
        write(os.path.join(folder, "it.toml"), 'machine = "bench"\npins = ["it.in"]\nrecords = ["it"]\nevery = 0.01\n')
        write(os.path.join(folder, "it.retained"), checksummed('machine = "bench"\n\n[pins]\n"it.in" = 1.0\n\n[records]\n"it" = [\n]\n'))

    def words(self, folder):
        return [os.path.join(BIN, "plumb-retain"), "--file", os.path.join(folder, "it.toml"), "--period", "0.01"]

    def value(self, folder):
        text = read(os.path.join(folder, "it.retained"))
        if text is None or text != checksummed(text.partition("\n")[2]):
            return None
        return float(re.search(r'"it.in" = (\S+)', text)[1])

    def work(self, host, until):
        until(lambda: self.get(host, "plumb-retain.restored") and host.get("it.in") == 1)
        for value in (2, 3):
            host.set("it.in", value)
            until(lambda value=value: self.value(self.folder) == value)
        until(lambda: not host.get("plumb-retain.fault"))

    def stored(self, folder, run):
        value = self.value(folder)
        if value is None:
            return ["the store is torn or lost"]
        left = set(os.listdir(folder)) - {"it.toml", "it.retained", "it.retained.lock"}
        return ["left " + ", ".join(left)] if left and not run.err else []


class RetainFirst(Retain):
    """Without a store."""

    def prepare(self, folder):
        super().prepare(folder)
        os.unlink(os.path.join(folder, "it.retained"))

    def work(self, host, until):
        until(lambda: self.get(host, "plumb-retain.restored"))
        host.set("it.in", 3)
        until(lambda: self.value(self.folder) == 3)

    def stored(self, folder, run):
        there = os.path.exists(os.path.join(folder, "it.retained"))
        return super().stored(folder, run) if there or not run.err else []


class GrowthLog(Beside):
    program, component = "growth_log", "growth_log"
    hal = (os.path.join(ROOT, "configs", "growth", "bench.hal"), "setp artifact.play 0", "setp artifact.touch-time 2", "start")

    def prepare(self, folder):
        write(os.path.join(folder, "growth.toml"), 'machine = "mill"\nfolder = "logs"\ntolerance = { x = 0.01, y = 0.01, z = 0.01 }\n'
              '[[sensor]]\nnumber = 1\nname = "spindle"\n[[bore]]\nnumber = 1\nx = 0\ny = -60\nz = 60\n')

    def words(self, folder):
        return [os.path.join(BIN, "growth_log"), "--file", os.path.join(folder, "growth.toml")]

    def work(self, host, until):
        host.set("artifact.play", True)
        host.run(60)
        host.set("artifact.play", False)
        until(lambda: host.get("growth-test.rows") > 0 and self.get(host, "growth-log.lines") == host.get("growth-test.rows"))
        self.rows = host.get("growth-test.rows")

    def stored(self, folder, run):
        findings, logs = [], glob.glob(os.path.join(folder, "logs", "growth-*.csv"))
        for path in logs:
            lines = (read(path) or "").split("\n")
            records = [line.split(",") for line in lines[:-1] if line.split(",")[0] in ("touch", "temperature", "speed", "event")]
            if [fields[1] for fields in records] != [str(number) for number in range(1, len(records) + 1)]:
                findings.append("%s has wrong or half records" % os.path.basename(path))
            if not lines[0].startswith("growth-log,") and not run.err:
                findings.append("%s has no head" % os.path.basename(path))
        if len(logs) > 1:
            findings.append("%d logs of one test" % len(logs))
        return findings


class ModbusSensor(Beside):
    program = component = "modbus_sensor"

    def prepare(self, folder):
        if not hasattr(self, "port"):
            import socket

            with socket.socket() as listener:
                listener.bind(("127.0.0.1", 0))
                self.port = listener.getsockname()[1]
            server = [PYTHON, os.path.join(ROOT, "tests", "programs", "modbus_server.py"), "tcp", str(self.port)]
            self.server = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", *server], stdin=subprocess.DEVNULL)
        write(os.path.join(folder, "sensors.toml"), '[[link]]\nname = "plc"\ntcp = "127.0.0.1:%d"\ntimeout = 0.5\nretry = 0.1\nretry-max = 0.1\n'
              '[[link.channel]]\nname = "cold"\ntable = "holding"\nregister = 0\ntype = "s16"\nunit = "degC"\n' % self.port)

    def words(self, folder):
        return [os.path.join(BIN, "modbus_sensor"), "--file", os.path.join(folder, "sensors.toml")]

    def work(self, host, until):
        until(lambda: self.get(host, "modbus-sensor.cold.valid") and host.get("modbus-sensor.cold.value") == -15)
        age = host.get("modbus-sensor.cold.age")
        until(lambda: self.get(host, "modbus-sensor.cold.valid") and host.get("modbus-sensor.cold.age") != age)


class CanSensor(Beside):
    """Without a bus: this kernel need not have CAN."""

    program = component = "can_sensor"

    def prepare(self, folder):
        write(os.path.join(folder, "can.toml"), '[[link]]\nname = "bus"\ninterface = "plumb0"\n[[link.channel]]\nname = "load"\nid = 0x123\n'
              'start-bit = 0\nlength = 16\nunit = "%"\n')

    def words(self, folder):
        return [os.path.join(BIN, "can_sensor"), "--file", os.path.join(folder, "can.toml")]

    def work(self, host, until):
        until(lambda: self.get(host, "can-sensor.load.fault-code"))
        beat = host.get("can-sensor.bus.heartbeat")
        until(lambda: host.get("can-sensor.bus.heartbeat") != beat)


class Link(Beside):
    """Without LinuxCNC."""

    component = "linuxcnc-link"
    ours = (PYTHON,)
    kinds = ("open", "read", "write", "state", "socket")

    def words(self, folder):
        return [os.path.join(BIN, "linuxcnc_link")]

    def work(self, host, until):
        beat = self.get(host, "linuxcnc-link.heartbeat")
        until(lambda: self.get(host, "linuxcnc-link.heartbeat") not in (None, beat))


SCENARIOS = (Squareness("squareness"), Bench("bench"), BenchHost("bench-host"), RunProgram("run"), Doctor("doctor"), Growth("growth"),
             Dbc("can_sensor_dbc"), Wire("wire"), ToolTable("tool_table_check"), Retain("plumb-retain"), RetainFirst("plumb-retain-first"), GrowthLog("growth_log"),
             ModbusSensor("modbus_sensor"), CanSensor("can_sensor"), Link("linuxcnc_link"))

options = None


def cases():
    """(scenario, kind, error), in an order that mixes the programs."""
    every = [(its, kind, error) for its in SCENARIOS for kind in its.kinds for error in ERRORS[kind]]
    random.Random(1).shuffle(every)
    return every


def chosen():
    words = (options.case or "").split("/") if options else []
    return [case for case in cases() if all(word in (case[0].name, case[1], errno.errorcode[case[2]]) for word in words if word)]


def attack(seed):
    every = chosen()
    scenario, kind, error = every[(seed - 1) % len(every)]
    with TemporaryFolder("/var/tmp") as folder:
        os.chmod(folder, 0o711)  # root's host has a part with the rights of another user
        return attack_one(scenario, kind, error, folder, random.Random(seed))


def attack_one(scenario, kind, error, folder, draw, numbers=None):
    what = "%s, %s %s" % (scenario.name, kind, errno.errorcode[error])
    scenario.good = None
    fault = Fault(kind, error, 0, folder)
    good, findings = scenario.run(folder, fault)
    findings += scenario.judge(good, fault)
    if findings or good.status != 0:
        return campaign.Outcome(1, ["%s, undisturbed: %s: %s" % (what, "; ".join(findings) or "status %s" % good.status, words_of(good))])
    scenario.good = good
    tries, found = 1, []
    for number in numbers or numbers_of(fault, draw):
        fault = Fault(kind, error, number, folder)
        run, findings = scenario.run(folder, fault)
        tries += 1
        if not fault.call:  # it has run through
            if kind == "allocation" and numbers is None:
                break
            continue
        findings += [each for each in scenario.judge(run, fault) if each not in findings]
        if findings:
            found.append("%s, number %d (%s): %s: %s" % (what, number, fault.call, "; ".join(findings), words_of(run)))
        if options and options.verbose:
            print("%s %d (%s): %s, %s" % (what, number, fault.call, run.status, words_of(run)), flush=True)
    return campaign.Outcome(tries, found)


def numbers_of(fault, draw):
    """1, 2, 3, ... until the program runs through; where that is long, as many as fit into a seed, drawn."""
    most = options.most if options else MOST
    if fault.kind == "allocation":  # nobody has counted them
        step = draw.choice((1, 1, 3, 10, 30))
        return range(draw.randint(1, step), 10**6, step)[:most]
    if fault.count <= most:
        return range(1, fault.count + 1)
    return sorted(draw.sample(range(1, fault.count + 1), most))


def words_of(run):
    said = "\n".join(line for line in run.err.split("\n") if not line.startswith(NOISE)).strip() or run.out
    return " ".join(said.split())[-400:] or "no words"


def add_options(parser):
    parser.add_argument("--case", metavar="PROGRAM/KIND/ERROR", help="cases of these words alone, such as plumb-retain/open")
    parser.add_argument("--most", type=int, default=MOST, metavar="N", help="runs of a seed (default: %(default)s)")
    parser.add_argument("--verbose", action="store_true", help="show every run")
    parser.add_argument("--list", action="store_true", help="show the cases and end")


def prepare(given):
    global options
    options = given
    if options.list:
        for number, (scenario, kind, error) in enumerate(chosen(), 1):
            print("%4d  %s/%s/%s" % (number, scenario.name, kind, errno.errorcode[error]))
        sys.exit(0)
    if not chosen():
        raise RuntimeError("--case %s: there is no such case; --list shows all" % options.case)


if __name__ == "__main__":
    campaign.run("calls", __doc__, attack, setup=("specimens", "product"), add_options=add_options, prepare=prepare)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Kills a part of Plumb with signal 9 at a drawn instant, and looks for everything that it leaves behind.

Each seed has a machine of its own in namespaces: processes, shared memory, network, /dev, /tmp, /run/lock and HOME. The
programs run as root, as an ordinary user, and on the one HAL of that machine (--no-namespaces). A try starts one of

    run      plumb run, with a program that uses halcmd
    bench    plumb bench
    client   a Python program with a host
    attached a Python program that records in the host of a plumb run, and is killed alone
    retain   the same with plumb-retain, whose store belongs to another user
    linuxcnc a complete LinuxCNC of configs/grinder, which strokes while X feeds; its task, its io, linuxcnc_alive, linuxcnc_link
             or plumb-retain is killed: the stroke must end at R with the feed held, or go on

kills one process of it, or its whole process group, often in its first milliseconds. Where the group was that of a run, the next run
clears up. Then the campaign looks for processes, shared memory, sockets, files,
mounts, a lock that is held, HAL's own lock, a torn or lost store, its owner and mode, a result that is lost though the exit
status is 0, and a program that has seen the devices or the network of the machine.
"""

import contextlib
import fcntl
import glob
import json
import os
import random
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
import zlib

BUILD = "/opt/build"  # on the machine
CONFIGS = "/opt/configs"
WORK = "/mnt"  # an empty folder of the machine, where the programs run
HOME = "/var/tmp"
LOCKS = ("/run/lock/plumb-host", "/tmp/plumb-host.lock")
USER = 65534  # role user
OWNER = 4321  # of plumb-retain's store
LATEST = 4  # s after the death of task or io, for the end of a stroke; plumb run ends 5 s after the death of task
SPEED = 10  # of that LinuxCNC
RESULT = 40000  # bytes that the program of plumb run writes to /tmp
PATIENCE = 20  # s, for everything to end: a keeper on a terminal waits 15 s for its host

HARMLESS = set("null zero full random urandom tty console pts ptmx mqueue dri fd stdin stdout stderr shm".split())

# As the root of new namespaces. $1 is this file, $2 the folder of the build, $3 the folder of the configurations: they get a place
# where every user finds them, however private the folders above them are.
FURNISH = """
set -e
ip link set lo up
mount -t tmpfs -o mode=0755 tmpfs /opt
cp "$1" /opt/kills.py
mkdir /opt/build /opt/configs /opt/components
mount --bind "$2" /opt/build
mount --bind "$3/../components" /opt/components  # where links of the build lead
mount --bind "$3" /opt/configs
for folder in /tmp /dev/shm /run/lock /var/tmp /mnt; do
    if [ -d "$folder" ]; then mount -t tmpfs -o mode=1777 tmpfs "$folder"; fi
done
new=/mnt/dev
mkdir "$new"
mount -t tmpfs -o mode=0755 tmpfs "$new"
for device in null zero full random urandom tty; do : > "$new/$device"; mount --bind "/dev/$device" "$new/$device"; done
mkdir "$new/shm" "$new/pts"
mount --rbind /dev/pts "$new/pts"
mount -t tmpfs -o mode=1777 tmpfs "$new/shm"
ln -s pts/ptmx "$new/ptmx"
ln -s /proc/self/fd "$new/fd"
: > "$new/ttyS-of-the-machine"
mount --rbind "$new" /dev
umount -R "$new"
rmdir "$new"
cd /
exec /usr/bin/python3 /opt/kills.py --machine
"""

SPACES = ["--ipc", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"]

HAL = """\
loadrt threads name1=servo-thread period1=1000000
loadrt integ
addf integ.0 servo-thread
setp integ.0.in 1
start
loadusr sleep 1000
"""

PROGRAM = """\
#!/bin/sh
{ ls /dev; echo --; readlink /proc/self/ns/net /proc/self/ns/ipc /proc/self/ns/mnt /proc/self/ns/pid; } > seen
stat -c %%u "${RTAPI_FIFO_PATH%%/*}" > folder
head -c %d /dev/zero | tr '\\0' x > /tmp/result
halcmd -f one.hal
echo "$RTAPI_FIFO_PATH" > socket
while [ ! -e end ]; do halcmd getp integ.0.out > pin; done
[ "$(stat -c %%s /tmp/result)" = %d ] || exit 3
touch done
""" % (RESULT, RESULT)

ATTACHED = """\
import sys, plumb
host = plumb.Host(attach=sys.argv[1])
host.record("recorded.csv", ["integ.0.out"], every=0.001)
host.expect("x >= 0", x="integ.0.out")
while True:
    host.get("integ.0.out")
    host.set("integ.0.gain", 2)
"""

CLIENT = """\
import sys, plumb
host = plumb.Host(namespaces=%(namespaces)s, modules=["%(build)s/specimens"])
host.load("one.hal")
host.run(1e9)
"""

# Sets one value after the other and notes how often plumb-retain had saved before: of the saves from then on the second one
# begins when the value is there.
KEEPING = """\
import random, sys, time, plumb
host = plumb.Host(namespaces=%(namespaces)s, modules=["%(build)s/specimens"])
host.command("loadrt threads name1=servo-thread period1=1000000")
host.command("loadrt specimen names=it")
host.command("addf it.update servo-thread")
host.command("start")
host.command("loadusr %(retain)s --file %(work)s/it.toml --period 0.01")
def get(name):
    try:
        return host.get(name)
    except plumb.Refused:
        return None
log = open("log", "w", 1)
while not get("plumb-retain.restored"):
    host.run(0.01)
    time.sleep(0.001)
    if get("plumb-retain.fault"):
        print("fault", int(get("plumb-retain.fault-code")), file=log)
        time.sleep(1000)
print("restored", host.get("it.in"), file=log)
value = host.get("it.in")
while True:
    value += 1
    host.set("it.in", value)
    print("set", value, get("plumb-retain.saves"), file=log)
    host.run(0.005)
    time.sleep(0.002)
"""

# Waits for the death of a program, and writes what is amiss afterwards: nothing, or a sentence. Its clock is that of the machine.
STROKING = """\
import os, time
from plumb_linuxcnc import Machine

with Machine() as machine:
    host = machine.host
    def until(condition):
        end = time.monotonic() + 10 * %(speed)d
        while not condition() and time.monotonic() < end:
            machine.poll()
            time.sleep(0.1)
    machine.turn_on()
    machine.home()
    until(lambda: host.get("interlock.function-enable-0"))
    machine.mdi("G0 X-100 Y0 Z10")
    machine.mdi("M3 S1000 G81.1 Z5 Q-30 R5 P3600")
    machine.mdi("G1 X200 F60", wait=False)
    until(lambda: host.get("chop.stroke-count") >= 2)
    open("strokes", "w").close()
    until(lambda: os.path.exists("victim"))
    with open("victim") as file:
        ends = file.read() in ("milltask", "io", "linuxcnc_alive")
    held = lambda: bool(host.get("interlock.feed-inhibit") and host.get("chop.at-end"))
    began = time.monotonic()
    while time.monotonic() < began + %(latest)g and not (ends and held()):
        time.sleep(0.1)
    before = host.get("joint.0.pos-cmd")
    time.sleep(1)
    moved = host.get("joint.0.pos-cmd") != before
    amiss = held() != ends or moved == ends or host.get("chop.active") == ends
    pins = ["interlock.feed-inhibit", "chop.at-end", "chop.active", *("interlock.service-lost-%%d" %% i for i in (0, 1, 4, 5))]
    with open("outcome", "w") as file:
        file.write("X moves: %%s, %%s" %% (moved, {pin: host.get(pin) for pin in pins}) if amiss else "")
""" % {"speed": SPEED, "latest": SPEED * LATEST}

SETTINGS = 'machine = "bench"\npins = ["it.in"]\nrecords = ["it"]\nevery = 0.01\nstore = "%s/it.retained"\n'


# --- the plan, from the seed alone ---

TRIES = 12


def plan_of(seed):
    draw = random.Random(seed)
    return [one_try(draw, number) for number in range(TRIES)]


def one_try(draw, number):
    role = draw.choice(("root", "user", "shared"))
    scenario = draw.choices(("run", "bench", "client", "attached", "retain", "linuxcnc"), (5, 2, 2, 1, 3, 1))[0]
    # How deep below the program that was started the victim is; "any" is any process there is, "group" all of its process
    # group, and a name the program of that name.
    depths = (0, 1, 1, 2, 3, "any", "group")
    depth = draw.choice((*depths, "any", "plumb-retain") if scenario == "retain" else depths)
    # From the moment the victim is there, or from the start for any.
    delay = draw.choice((draw.uniform(0, 0.02), 10 ** draw.uniform(-4, -0.3)))
    if scenario == "attached":
        depth, delay = 0, 10 ** draw.uniform(-3, -0.3)
    if scenario == "linuxcnc":
        depth = draw.choice(("milltask", "io", "linuxcnc_alive", "linuxcnc_link", "plumb-retain"))
        role = draw.choice(("root", "user"))  # LinuxCNC leaves files on a HAL that it shares
    if not isinstance(depth, int):
        delay = 10 ** draw.uniform(-2, 0.3)
    return {
        "number": number,
        "role": role,
        "scenario": scenario,
        "depth": depth,
        "delay": delay,
        "which": draw.random(),
        "speed": draw.choice(("1", "10")),
        "mode": draw.choice((0o600, 0o640, 0o644)),
        "trap": draw.random() < 0.3 and scenario not in ("attached", "linuxcnc"),  # links where Plumb makes files
    }


def describe(plan):
    victim = {0: "the program started", 1: "its child", 2: "its grandchild", 3: "its great-grandchild"}.get(plan["depth"])
    if victim:
        when = "%.1f ms after it was there" % (1000 * plan["delay"])
    else:
        victim = {"any": "a process", "group": "the process group"}.get(plan["depth"], plan["depth"])
        when = "after %.0f ms" % (1000 * plan["delay"])
    return "%s, role %s, try %d, kill of %s %s" % (plan["scenario"], plan["role"], plan["number"], victim, when)


# --- on the machine ---


class Machine:
    """This process is the first of the machine: all orphans fall to it, and it kills everything between two tries."""

    def __init__(self):
        assert os.getpid() == 1, "not on a machine of its own"
        with open("/proc/self/uid_map") as file:
            self.users = int(file.read().split()[2]) > USER  # else root is the only one
        self.mounts = mounts()
        self.spaces = spaces_of("self")
        self.statuses = {}

    def reap(self):
        while True:
            try:
                process, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return
            if process == 0:
                return
            self.statuses[process] = status

    def start(self, words, role, name):
        """Returns once it has become the program."""
        ends = os.pipe()
        process = os.fork()
        if process != 0:
            os.close(ends[1])
            os.read(ends[0], 1)
            os.close(ends[0])
            return process
        try:
            os.setsid()
            null = os.open("/dev/null", os.O_RDONLY)
            out = os.open(os.path.join(WORK, name), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
            os.dup2(null, 0)
            os.dup2(out, 1)
            os.dup2(out, 2)
            environment = {
                "HOME": HOME,
                "PATH": "/usr/bin:/bin:/usr/sbin:/sbin",
                "LC_ALL": "C",
                "PYTHONPATH": os.path.join(BUILD, "python"),
            }
            if role == "user":
                if self.users:
                    os.setgroups([])
                    os.setgid(USER)
                    os.setuid(USER)
                else:
                    words = ["unshare", "--user", "--map-user=1000", "--map-group=1000", "--", *words]
            os.execvpe(words[0], words, environment)
        finally:
            os._exit(127)

    def clear(self):
        """Kills all but this process and empties the machine."""
        try:
            os.kill(-1, signal.SIGKILL)
        except ProcessLookupError:
            pass
        end = time.monotonic() + 10
        while processes() and time.monotonic() < end:
            self.reap()
            time.sleep(0.001)
        self.reap()
        self.statuses.clear()
        subprocess.run(["ipcrm", "--all=shm"], stderr=subprocess.DEVNULL, check=False)
        self.reap()
        for line in reversed(mounts()):
            if line not in self.mounts:
                subprocess.run(["umount", "-l", line.split()[1]], check=False)
        if mounts() != self.mounts:
            sys.exit("a mount cannot be taken away, and the files behind it must stay")
        for folder in ("/tmp", "/dev/shm", "/run/lock", HOME, WORK):
            for entry in os.scandir(folder) if os.path.isdir(folder) else ():
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.path, ignore_errors=True)
                else:
                    os.unlink(entry.path)


def mounts():
    with open("/proc/self/mounts") as file:
        return file.read().splitlines()


def spaces_of(process):
    return {kind: os.readlink("/proc/%s/ns/%s" % (process, kind)) for kind in ("net", "ipc", "mnt", "pid")}


def processes():
    return [int(name) for name in os.listdir("/proc") if name.isdigit() and int(name) > 1]


def name_of(process):
    try:
        with open("/proc/%d/stat" % process) as file:
            text = file.read()
        name, state = text[text.index("(") + 1 : text.rindex(")")], text[text.rindex(")") + 2]
        return name + (" (zombie)" if state in "ZX" else "")
    except OSError:
        return "gone"


def children(process):
    found = []
    for path in glob.glob("/proc/%d/task/*/children" % process):
        try:
            with open(path) as file:
                found += [int(word) for word in file.read().split()]
        except OSError:
            pass
    return found


def tree(process):
    found = [process]
    for each in found:
        found += children(each)
    return found


def first_at(process, depth, end):
    """The first descendant in this depth, as soon as there is one; the deepest one when the time is over."""
    chain = [process]
    path = "/proc/%d/task/%d/children"
    while len(chain) <= depth and time.monotonic() < end:
        try:
            with open(path % (chain[-1], chain[-1])) as file:
                words = file.read().split()
        except OSError:
            break
        if words:
            chain.append(int(words[0]))
    return chain[-1]


def segments():
    with open("/proc/sysvipc/shm") as file:
        return [line.split()[0] for line in file.read().splitlines()[1:]]


def sockets():
    with open("/proc/net/unix") as file:
        return [line.split()[7] for line in file.read().splitlines()[1:] if len(line.split()) > 7]


def files():
    found = []
    for folder in ("/tmp", "/dev/shm", "/run/lock", HOME):
        if os.path.isdir(folder):
            found += [entry.path for entry in os.scandir(folder)]
    return [path for path in found if path not in LOCKS]


def sleep_until(instant):
    """To 0.1 ms."""
    while True:
        left = instant - time.monotonic()
        if left <= 0:
            return
        if left > 0.002:
            time.sleep(left - 0.001)


def kill(process):
    try:
        os.kill(process, signal.SIGKILL)
        return True
    except ProcessLookupError:
        return False


def checksummed(rest):
    return "# retain 1, CRC-32 of the rest: %08x\n%s" % (zlib.crc32(rest.encode()), rest)


def write(path, text, mode=0o644):
    with open(path, "w") as file:
        file.write(text)
    os.chmod(path, mode)


class Try:
    def __init__(self, machine, plan):
        self.machine, self.plan, self.findings = machine, plan, []
        self.role = plan["role"]
        self.killed = "nothing"

    def find(self, text):
        said = ""
        for name in ("run.out", "attached.out", "bench.out", "client.out", "keeping.out", "linuxcnc.out"):
            path = os.path.join(WORK, name)
            if os.path.exists(path):
                with open(path, errors="replace") as file:
                    said += " ".join(file.read().split())[-300:]
        self.findings.append("%s (%s): %s%s" % (describe(self.plan), self.killed, text, "; its output: " + said if said else ""))

    def attack(self):
        os.chmod(WORK, 0o1777)
        folder = os.path.join(WORK, "work")
        os.mkdir(folder)
        os.chmod(folder, 0o777)
        os.chdir(folder)
        write("one.hal", HAL)
        write("program", PROGRAM, 0o755)
        self.set_traps()
        try:
            getattr(self, self.plan["scenario"])()
            self.look_at_traps()
        finally:
            os.chdir("/")

    # Links that another user may have put where Plumb makes files.
    def set_traps(self):
        self.secret = os.path.join(WORK, "secret")
        write(self.secret, "secret\n", 0o600)
        if self.plan["trap"]:
            for lock in LOCKS:
                if self.role == "shared" and os.path.isdir(os.path.dirname(lock)):
                    os.symlink(self.secret, lock)

    def look_at_traps(self):
        state = os.stat(self.secret)
        with open(self.secret) as file:
            text = file.read()
        if stat.S_IMODE(state.st_mode) != 0o600 or text != "secret\n":
            self.find("a file behind a link was changed: mode %o, '%s'" % (stat.S_IMODE(state.st_mode), text[:40]))

    def words(self, command, *words):
        shared = ["--no-namespaces"] if self.role == "shared" else []
        return [os.path.join(BUILD, "bin", "plumb"), command, *words, *shared]

    def kill(self, top):
        """Kills the process of the plan, and notes its name."""
        began, depth, delay = time.monotonic(), self.plan["depth"], self.plan["delay"]
        if depth == "group":
            sleep_until(began + delay)
            self.killed = "the process group of %s" % name_of(top)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(top, signal.SIGKILL)
            return top
        if not isinstance(depth, int):
            sleep_until(began + delay)
            there = tree(top)
            if depth != "any":
                there = [each for each in there if name_of(each) == depth] or there
            victim = there[int(self.plan["which"] * len(there))]
        else:
            victim = first_at(top, depth, began + 2)
            sleep_until(time.monotonic() + delay)
        name = name_of(victim)
        place = "the program started" if victim == top else "a part"
        gone = not kill(victim)
        self.killed = "%s, %s%s" % (name, place, ", was gone" if gone else "")
        return victim

    def run(self):
        started = self.machine.start([*self.words("run", "--speed", self.plan["speed"]), "--", "./program"], self.role, "run.out")
        self.kill(started)
        time.sleep(0.05)
        if self.goes_on(started) and os.path.exists("socket"):
            self.ask_host()
        write("end", "")
        status = self.await_end(started)
        if self.plan["depth"] == "group":  # with the host and its keeper: the next host clears up
            self.await_end(self.machine.start([*self.words("run"), "--", "true"], self.role, "next.out"))
        self.look_at_view()
        if status == 0:
            if not os.path.exists("done"):
                self.find("exit status 0, though the program has not come to its end")
            elif not os.path.exists("/tmp/result") or os.stat("/tmp/result").st_size != RESULT:
                self.find("exit status 0, though /tmp/result is lost or truncated")
        self.look()

    def attached(self):
        """The run goes on without its client."""
        started = self.machine.start([*self.words("run", "--speed", self.plan["speed"]), "--", "./program"], self.role, "run.out")
        end = time.monotonic() + PATIENCE
        while not os.path.exists("pin") and time.monotonic() < end and self.goes_on(started):
            time.sleep(0.002)
        with open("socket") as file:
            path = file.read().strip()
        write("attached.py", ATTACHED)
        self.kill(self.machine.start(["/usr/bin/python3", "attached.py", path], self.role, "attached.out"))
        self.ask_host()
        write("end", "")
        if self.await_end(started) != 0:
            self.find("the run does not end with 0")
        self.look()

    def bench(self):
        started = self.machine.start(self.words("bench", "one.hal", "--for", "1000000h"), self.role, "bench.out")
        self.kill(started)
        self.end(started)

    def client(self):
        write("client.py", CLIENT % self.names())
        started = self.machine.start(["/usr/bin/python3", "client.py"], self.role, "client.out")
        self.kill(started)
        self.end(started)

    def retain(self):
        store = os.path.join(os.getcwd(), "it.retained")
        write("it.toml", SETTINGS % os.getcwd())
        write(store, checksummed('machine = "bench"\n\n[pins]\n"it.in" = 1.0\n\n[records]\n"it" = [\n]\n'), self.plan["mode"])
        if self.machine.users:
            owner = USER if self.role == "user" else OWNER
            os.chown(store, owner, owner)
        before = os.stat(store)
        if self.plan["trap"]:
            os.symlink(self.secret, store + ".new")
        write("keeping.py", KEEPING % self.names())
        started = self.machine.start(["/usr/bin/python3", "keeping.py"], self.role, "keeping.out")
        self.kill(started)
        if self.goes_on(started):
            time.sleep(0.1)
        self.end(started, look=False)
        self.look_at_store(store, before)
        self.look()

    def linuxcnc(self):
        shutil.copytree(os.path.join(CONFIGS, "grinder"), "grinder")
        os.mkdir("home")
        for path in (".", *(path for path in glob.glob("**", recursive=True))):
            os.chmod(path, 0o777)
        os.chdir("grinder")
        write("stroking.py", STROKING)
        home = ["env", "HOME=" + os.path.join(WORK, "work", "home"), "PATH=%s/bin:/usr/bin:/bin:/usr/sbin:/sbin" % BUILD]
        words = self.words("run", "--speed", str(SPEED), "--", *home, "linuxcnc", "-r", os.path.abspath("grinder.ini"), os.path.abspath("stroking.py"))
        started = self.machine.start(words, self.role, "linuxcnc.out")
        self.await_file("strokes", started)
        self.kill(started)
        write("victim", self.plan["depth"])
        self.await_file("outcome", started)
        if not os.path.exists("outcome"):
            self.find("the run ended too early")
        else:
            with open("outcome") as file:
                amiss = file.read()
            if amiss:
                self.find(amiss)
        self.end(started)

    def await_file(self, name, started):
        end = time.monotonic() + PATIENCE
        while not os.path.exists(name) and time.monotonic() < end and self.goes_on(started):
            time.sleep(0.002)

    def names(self):
        return {
            "namespaces": self.role != "shared",
            "build": BUILD,
            "retain": os.path.join(BUILD, "bin", "plumb-retain"),
            "work": os.getcwd(),
        }

    def goes_on(self, started):
        self.machine.reap()
        return started not in self.machine.statuses

    def ask_host(self):
        """A host that runs answers, even if a program was killed while it held HAL's lock."""
        with open("socket") as file:
            path = file.read().strip()
        code = "import sys, plumb; plumb.Host(attach=sys.argv[1]).halcmd('show', 'pin')"
        client = self.machine.start(["/usr/bin/python3", "-c", code, path], self.role, "ask.out")
        end = time.monotonic() + 8
        while client not in self.machine.statuses and time.monotonic() < end:
            self.machine.reap()
            time.sleep(0.002)
        if client not in self.machine.statuses:
            kill(client)
            self.find("the host does not answer for 8 s")

    def end(self, started, look=True):
        """Asks all processes that still run to end, as their user would."""
        time.sleep(0.02)
        if self.goes_on(started):
            try:
                os.kill(started, signal.SIGTERM)
            except ProcessLookupError:
                pass
        self.await_end(started)
        if look:
            self.look()

    def await_end(self, started):
        end = time.monotonic() + PATIENCE
        while self.goes_on(started):
            if time.monotonic() > end:
                self.find("%s does not end within %d s" % (name_of(started), PATIENCE))
                kill(started)
                time.sleep(0.1)
                break
            time.sleep(0.002)
        self.machine.reap()
        return self.machine.statuses.get(started, -1)

    def look_at_view(self):
        if os.path.exists("folder") and self.machine.users and self.role != "user":
            with open("folder") as file:
                owner = file.read().strip()
            if owner not in ("", "0"):
                self.find("the folder of root's socket is user %s's" % owner)
        if not os.path.exists("seen") or self.role == "shared":
            return
        with open("seen") as file:
            devices, _, spaces = file.read().partition("--\n")
        if set(devices.split()) - HARMLESS:
            self.find("the program saw the devices of the machine: %s" % " ".join(sorted(set(devices.split()) - HARMLESS)))
        shared = set(spaces.split()) & set(self.machine.spaces.values())
        if shared:
            self.find("the program had namespaces of the machine: %s" % " ".join(sorted(shared)))

    def look_at_store(self, store, before):
        try:
            after = os.stat(store)
            with open(store) as file:
                text = file.read()
        except OSError as error:
            self.find("the store is lost: %s" % error)
            return
        if (after.st_uid, after.st_gid, after.st_mode) != (before.st_uid, before.st_gid, before.st_mode):
            what = "%d:%d %o became %d:%d %o"
            self.find(
                "owner or mode of the store: "
                + what % (before.st_uid, before.st_gid, before.st_mode & 0o7777, after.st_uid, after.st_gid, after.st_mode & 0o7777)
            )
        if text != checksummed(text.partition("\n")[2]):
            self.find("the store is torn: '%s'" % text[:60])
            return
        if not os.path.exists("log"):
            return
        with open("log") as file:
            lines = [line.split() for line in file.read().splitlines(keepends=True) if line.endswith("\n")]
        written = [(float(line[1]), int(line[2])) for line in lines if line[0] == "set" and line[2] != "None"]
        if not written:
            return
        seen = written[-1][1]
        safe = max([value for value, saves in written if seen >= saves + 2], default=1.0)
        kept = float(re.search(r'"it.in" = (\S+)', text)[1])
        if kept < safe:
            self.find("the store has lost a saved value: %g instead of %g or more" % (kept, safe))

    def look(self):
        """Until nothing is left."""
        end = time.monotonic() + PATIENCE
        while True:
            self.machine.reap()
            if os.path.exists("/tmp/result"):  # a host whose keeper was killed brings it later
                os.unlink("/tmp/result")
            left = {
                "processes": ["%d %s" % (each, name_of(each)) for each in processes()],
                "shared memory": segments(),
                "sockets": sockets(),
                "files": files(),
                "mounts": [line for line in mounts() if line not in self.machine.mounts],
            }
            if not any(left.values()):
                break
            if time.monotonic() > end:
                for kind, list_of in left.items():
                    if list_of:
                        self.find("%s left: %s" % (kind, ", ".join(list_of)))
                break
            time.sleep(0.005)
        for path in LOCKS:
            try:
                lock = os.open(path, os.O_RDWR | os.O_NOFOLLOW)
            except OSError:
                continue
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self.find("%s stays locked" % path)
            os.close(lock)


def check_machine_works(machine, role):
    """As if nothing had been."""
    os.chmod(WORK, 0o1777)
    write(os.path.join(WORK, "one.hal"), HAL)
    words = [os.path.join(BUILD, "bin", "plumb"), "bench", os.path.join(WORK, "one.hal"), "--for", "1"]
    started = machine.start(words + (["--no-namespaces"] if role == "shared" else []), role, "works.out")
    end = time.monotonic() + PATIENCE
    while started not in machine.statuses and time.monotonic() < end:
        machine.reap()
        time.sleep(0.005)
    if machine.statuses.get(started) == 0:
        return []
    with open(os.path.join(WORK, "works.out")) as file:
        return ["role %s: the bench after the kills fails: %s" % (role, file.read()[-300:])]


def on_machine():
    machine = Machine()
    for plan in json.load(sys.stdin):
        one = Try(machine, plan)
        began = time.monotonic()
        try:
            one.attack()
        except Exception as error:  # the machine is to go on, and to report the try
            one.find("the campaign itself failed: %r" % error)
        print(json.dumps({"findings": one.findings, "killed": one.killed, "seconds": time.monotonic() - began}), flush=True)
        machine.clear()
    for role in ("root", "user", "shared"):
        findings = check_machine_works(machine, role)
        machine.clear()
        if findings:
            print(json.dumps({"findings": findings, "killed": "", "seconds": 0}), flush=True)


# --- outside ---


def attack(seed):
    plans = plan_of(seed)
    if only:
        plans = [plan for plan in plans if plan["number"] == only]
    users = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
    command = ["setpriv", "--pdeathsig", "KILL", "unshare", *users, *SPACES, "--", "/bin/sh", "-c", FURNISH, "sh"]
    command += [os.path.abspath(__file__), os.path.abspath(campaign.BUILD), os.path.join(campaign.ROOT, "configs")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as machine:
        try:
            output, errors = machine.communicate(json.dumps(plans), timeout=120 * len(plans))
            hung = False
        except subprocess.TimeoutExpired:
            machine.kill()
            output, errors = machine.communicate()
            hung = True
        except BaseException:
            machine.kill()
            raise
    outcomes = [json.loads(line) for line in output.splitlines()]
    findings = [finding for outcome in outcomes for finding in outcome["findings"]]
    if verbose:
        for plan, outcome in zip(plans, outcomes):
            print("%6.2f s  %s (%s)" % (outcome["seconds"], describe(plan), outcome["killed"]), flush=True)
    if hung:
        findings.append("the machine hangs after %d of %d tries" % (len(outcomes), len(plans)))
    elif machine.returncode != 0:
        raise RuntimeError("no machine of its own: %s" % " ".join(errors.split())[-300:])
    return campaign.Outcome(min(len(outcomes), len(plans)), findings)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--machine"]:
        on_machine()
    else:
        import campaign

        verbose, only = False, None

        def add_options(parser):
            parser.add_argument("--verbose", action="store_true", help="show every try")
            parser.add_argument("--try", type=int, dest="only", metavar="N", help="of each seed this try alone")

        def prepare(options):
            global verbose, only
            verbose, only = options.verbose, options.only

        campaign.run(
            "kills",
            "Kills parts of Plumb at drawn instants and looks for everything that is left behind.",
            attack,
            setup=("--with", "iproute2", "product"),
            add_options=add_options,
            prepare=prepare,
        )

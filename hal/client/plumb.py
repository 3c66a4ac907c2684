# SPDX-License-Identifier: GPL-2.0-or-later
"""Python client of Plumb's virtual-time host: LinuxCNC's real HAL, faster than the clock.

    import plumb

    with plumb.Host() as host:
        host.command("loadrt threads name1=servo-thread period1=1000000")
        host.command("loadrt lowpass names=filter")
        host.command("addf filter servo-thread")
        host.command("start")
        host.set("filter.gain", 0.001)
        host.set("filter.in", 1)
        host.run(600)
        print(host.get("filter.out"))

Times are in seconds, and virtual: they pass only in run(). A host has a HAL of its own; any number of them
run side by side. Where the host refuses something, Refused carries its sentence; when it has died, every
call raises HostDied with its last words. A Host is for one thread at a time.

The sentences of a module's codes come from its declarations:

    plumb.declarations("thermal_displacement")["codes"]["detail-code"][38]
"""

import collections
import contextlib
import json
import math
import os
import select
import shlex
import shutil
import socket
import struct
import subprocess
import sys
import time

__all__ = ["Host", "Refused", "HostDied", "Halcmd", "Ran", "Violation", "declarations"]

_PATIENCE = 5  # seconds for a host to unload its modules and end
_AT_ONCE = 64  # requests without their answers
_KEPT_WORDS = 4000  # of the last output of the host


class Refused(RuntimeError):
    """The host refuses a request; the message gives the reason."""


class HostDied(RuntimeError):
    """The host is dead; the message has its last words."""


Halcmd = collections.namedtuple("Halcmd", "status output")
Halcmd.__doc__ = "The result of halcmd: its exit status (0 is success), and all output."

Ran = collections.namedtuple("Ran", "time ran ended")
Ran.__doc__ = "Virtual time after a run, how long it was, and what ended it early: 'replay' (the file's end), 'limit', or ''."

Violation = collections.namedtuple("Violation", "id count first_time values")
Violation.__doc__ = "In how many periods an expectation did not hold, when first, and its variables' values then."


class Host:
    """A virtual-time host, started here unless `attach` is the socket path of one that runs.

    modules      folders of realtime modules, searched before the build's and LinuxCNC's own
    options      "MODULE.NAME" -> value, with which MODULE is loaded in the place of that in its loadrt line
    namespaces   False: in the machine's one HAL, one host at a time
    guard        watch for allocations and, on x86-64, system calls in realtime functions
    show_output  pass output of the host and its programs on to stderr
    executable   plumb-host; by default the one beside this file's build, else the one in PATH

    Its attributes: socket, the host's RTAPI_FIFO_PATH; process, its number; namespaces, whether it has a HAL
    of its own; modules, the folders that it searches.
    """

    def __init__(self, attach=None, modules=(), namespaces=True, guard=False, show_output=False, executable=None, options=None):
        self._started = None  # the process begun here, which ends when the host does
        self._output = None
        self._show_output = show_output
        self._words = b""
        self._unread = b""
        self._death = None
        self._awaited = 0  # requests that have no answer yet
        self._names_given = 0
        if attach is not None:
            self._control = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                self._control.connect(attach)
            except OSError as error:
                self._control.close()
                raise HostDied("no virtual-time host at %s: %s" % (attach, error.strerror)) from None
            # Any program may listen where a host was; the system knows its process.
            peer = self._control.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
            user = struct.unpack("3i", peer)[1]
            if user not in (0, os.geteuid()):
                self._control.close()
                raise HostDied("%s belongs to user %d, and is no host of yours" % (attach, user))
            self.socket = attach
        else:
            self.socket = None
            self._start(executable or _find_executable(), modules, options or {}, namespaces, guard)
        try:
            hello = self._request("hello")
        except HostDied:
            words = self._last_words()
            if not words:
                raise
            raise HostDied(words) from None
        self.socket = hello["socket"]
        self.process = hello["pid"]
        self.namespaces = hello["namespaces"]
        self.modules = hello["modules"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_started", None) is not None:
            self.close()

    def close(self):
        """Ends the host, if this client started it. Further calls raise HostDied."""
        with contextlib.suppress(OSError):
            self._control.shutdown(socket.SHUT_RDWR)  # closing is not enough while a forked process has a copy
        self._control.close()
        self._death = self._death or "the virtual-time host was closed"
        self._await_end()

    @property
    def time(self):
        """Virtual time since the host began."""
        return self._request("hello")["time"] / 1e9

    def halcmd(self, *arguments):
        """Runs the real halcmd beside the host, in the present folder; returns a Halcmd, even after a failure."""
        answer = self._request("halcmd", args=[str(argument) for argument in arguments], cwd=os.getcwd())
        return Halcmd(answer["status"], answer["output"])

    def command(self, line):
        """Carries out one line of a .hal file. Raises Refused with halcmd's message; returns its output."""
        return self._succeed(self.halcmd(*shlex.split(line)), line)

    def load(self, file, ini=None):
        """Loads a .hal file, with the values of an INI file. Raises Refused with halcmd's message."""
        options = [] if ini is None else ["-i", ini]
        return self._succeed(self.halcmd(*options, "-f", file), file)

    def get(self, names):
        """The value of a pin, parameter or signal, a float, an int or a bool; or a list of them for a list."""
        if isinstance(names, str):
            return self.get([names])[0]
        answer = self._request("get", names=list(names))
        return [
            float(value) if kind == "float" else value for value, kind in zip(answer["values"], answer["types"])
        ]

    def set(self, name, value=None):
        """Sets a pin, parameter or signal, or all of a dict; refuses a value that `halcmd setp` and `halcmd sets` refuse."""
        pairs = [(name, value)] if isinstance(name, str) else list(name.items())
        for first in range(0, len(pairs), _AT_ONCE):
            self._requests([{"do": "set", "name": its, "value": _to_json(wanted)} for its, wanted in pairs[first : first + _AT_ONCE]])

    def run(self, seconds, progress=None, limit=None):
        """Moves virtual time; returns a Ran.

        About five times a second of real time, progress(seconds done) is called; if it returns False the
        run stops at the next period. After `limit` seconds of real time it stops too, and Ran.ended is
        "limit". An interrupt (Ctrl-C) stops it as well, and is raised. A function that does not return within
        5 s of real time ends the host: HostDied names the function.
        """
        end = math.inf if limit is None else time.monotonic() + limit
        ended = ""

        def heard(done):
            nonlocal ended, end
            goes_on = progress is None or progress(done / 1e9) is not False
            if time.monotonic() > end:
                goes_on, ended, end = False, "limit", math.inf
            if not goes_on:
                self._send({"do": "stop"})

        try:
            answer = self._request("run", heard, ns=_nanoseconds(seconds))
        except KeyboardInterrupt:
            self._send({"do": "stop"})
            raise
        return Ran(answer["time"] / 1e9, answer["ran"] / 1e9, answer.get("ended", "") or ended)

    def record(self, file, names, every, append=False):
        """Writes values into a CSV file: a row now and one after each `every` seconds. Returns an id."""
        identity = self._identity("record")
        self._request(
            "record",
            id=identity,
            names=list(names),
            every=_nanoseconds(every),
            file=os.path.abspath(file),
            append=append,
        )
        return identity

    def stop_recording(self, identity):
        """Ends a recording."""
        self._request("record-stop", id=identity)

    def replay(self, file, columns=None, sample_period=None, override=False):
        """Writes a file's columns into pins before each period, from now on; returns how long it lasts.

        A CSV file names its pins in the header, with column time in seconds. A halsampler file has no
        header: give the pins as `columns`, and the time from row to row. A pin that is netted is refused,
        unless `override`. The run that reaches the end of the file ends there.
        """
        answer = self._request(
            "replay",
            **{
                "file": os.path.abspath(file),
                "columns": None if columns is None else list(columns),
                "sample-period": None if sample_period is None else _nanoseconds(sample_period),
                "override": override,
            }
        )
        return answer["duration"] / 1e9

    def expect(self, expression, **variables):
        """Checks a statement after every period: host.expect("abs(z) < 1", z="filter.out").

        It is true or false: a comparison, a bit, or several joined by && and ||; a number by itself is refused.
        Besides each variable x it may use x_rate, the change of x per second, and finite(x). Returns the
        id under which violations() reports it.
        """
        identity = self._identity("expect")
        self._request("expect", id=identity, expression=expression, variables=variables)
        return identity

    def violations(self):
        """The statements that did not hold: a list of Violation."""
        return [
            Violation(
                found["id"],
                found["count"],
                found["first-time"] / 1e9,
                {name: float(value) for name, value in found["values"].items()},
            )
            for found in self._request("violations")["violations"]
        ]

    def guard(self):
        """Allocations and system calls in realtime functions: a list of (function, what)."""
        return [(found["function"], found["what"]) for found in self._request("guard")["violations"]]

    def programs(self):
        """Names of the user-space HAL programs that are alive."""
        return self._request("programs")["names"]

    def _start(self, executable, modules, options, namespaces, guard):
        self._control, theirs = socket.socketpair()
        arguments = [executable, "--control-fd", str(theirs.fileno())]
        for folder in modules:
            arguments += ["--modules", os.path.abspath(folder)]
        for name, value in options.items():
            arguments += ["--option", "%s=%s" % (name, value)]
        arguments += [] if namespaces else ["--no-namespaces"]
        arguments += ["--guard"] if guard else []
        with theirs, contextlib.ExitStack() as on_failure:
            on_failure.callback(self._control.close)
            # Apart from the terminal, so that Ctrl-C reaches only this program.
            self._started = subprocess.Popen(
                arguments,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                bufsize=0,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )
            on_failure.pop_all()
        self._output = self._started.stdout
        os.set_blocking(self._output.fileno(), False)

    def _identity(self, kind):
        self._names_given += 1
        return "%s %d" % (kind, self._names_given)

    def _request(self, what, progress=None, **arguments):
        """The answer to a request. Raises Refused if it is a refusal."""
        return self._requests([dict(arguments, do=what)], progress)[0]

    def _requests(self, requests, progress=None):
        """The answers to requests that are sent at once. Raises Refused with the first refusal."""
        earlier = self._awaited  # answers to interrupted requests, or to a stop
        self._send(*requests)
        for _ in range(earlier):
            self._answer()
        answers = [self._answer(progress) for _ in requests]
        for answer in answers:
            if not answer["ok"]:
                raise Refused(answer["error"])
        return answers

    @staticmethod
    def _succeed(halcmd, what):
        if halcmd.status != 0:
            raise Refused(halcmd.output.strip() or "%s: halcmd ended with status %d" % (what, halcmd.status))
        return halcmd.output

    def _send(self, *requests):
        if self._death:
            raise HostDied(self._death)
        try:
            self._control.sendall(b"".join(json.dumps(request).encode() + b"\n" for request in requests))
            self._awaited += len(requests)
        except OSError:
            self._die()

    def _answer(self, progress=None):
        while True:
            answer = self._receive()
            if "progress" not in answer:
                self._awaited -= 1
                return answer
            if progress is not None:
                progress(answer["progress"])

    def _receive(self):
        while b"\n" not in self._unread:
            ready = self._ready()
            if self._output in ready:
                self._listen()
            if self._control in ready:
                try:
                    received = self._control.recv(65536)
                except OSError:
                    received = b""
                if not received:
                    self._die()
                self._unread += received
        line, self._unread = self._unread.split(b"\n", 1)
        return json.loads(line)

    def _ready(self):
        """The sockets and pipes with words. Going to sleep takes longer than the answer to a short request."""
        ends = [self._control] + ([self._output] if self._output else [])
        awake = time.monotonic() + 2e-5
        while time.monotonic() < awake:
            ready = select.select(ends, [], [], 0)[0]
            if ready:
                return ready
        return select.select(ends, [], [])[0]

    def _listen(self):
        """Takes in the output of the host."""
        while self._output:
            printed = self._output.read(65536)
            if printed is None:
                return
            if not printed:
                self._output.close()
                self._output = None
                return
            if self._show_output:
                sys.stderr.write(printed.decode(errors="replace"))
            self._words = (self._words + printed)[-_KEPT_WORDS:]

    def _last_words(self):
        return self._words.decode(errors="replace").strip()

    def _await_end(self):
        if self._started is None:
            return None
        process, self._started = self._started, None
        try:
            # Its output is read meanwhile: a full pipe would keep it from ending.
            process.stdout = self._output
            if self._output:
                os.set_blocking(self._output.fileno(), True)
                self._words = (self._words + (process.communicate(timeout=_PATIENCE)[0] or b""))[-_KEPT_WORDS:]
            process.wait(timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if self._output:
            self._output.close()
            self._output = None
        return process.returncode

    def _die(self):
        self._control.close()
        if self._started is None:
            self._death = "the virtual-time host at %s is gone" % self.socket
        else:
            status = self._await_end()
            if self.socket:  # the host clears up after its death, unless that part of it was killed as well
                folder = os.path.dirname(self.socket)
                with contextlib.suppress(OSError):
                    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)  # not the target of a link
                    try:
                        os.unlink(os.path.basename(self.socket), dir_fd=opened)
                    finally:
                        os.close(opened)
                with contextlib.suppress(OSError):
                    os.rmdir(folder)
            cause = "signal %d" % -status if status < 0 else "exit status %d" % status
            words = self._last_words()
            self._death = "the virtual-time host died (%s); %s" % (
                cause,
                "its last words: " + words if words else "it left no words",
            )
        raise HostDied(self._death)


def declarations(module):
    """The declarations of a module, or of a HAL program: its pins, codes, options and functions by their names.

    A pin has a type, output, unit, default and sentence; codes has the sentences of each code by their numbers. An option has a
    sentence and a default.
    Raises FileNotFoundError for one that this Plumb does not have, ValueError for a damaged file.
    """
    here = os.path.dirname(os.path.abspath(__file__))
    build, prefix = os.path.dirname(here), os.path.normpath(os.path.join(here, "..", "..", ".."))
    folders = [os.path.join(root, "share", "plumb") for root in (build, prefix)]
    paths = [os.path.join(folder, "%s.json" % module) for folder in folders]
    path = next(filter(os.path.isfile, paths), None) if str(module).replace("-", "_").isidentifier() else None
    if path is None:
        raise FileNotFoundError("cannot find the declarations of '%s' in %s or %s" % (module, *folders))
    try:
        with open(path, encoding="utf-8") as file:
            declared = {"pins": {}, "options": {}, "functions": {}, "codes": {}, **json.load(file)}
        for pin, texts in declared["codes"].items():
            declared["codes"][pin] = {int(code): text for code, text in texts.items()}
    except (ValueError, TypeError, AttributeError) as error:
        raise ValueError("%s is damaged: %s" % (path, error)) from None
    return declared


def has_pin(declared, short, options):
    """Whether an instance of a declared module has this pin. `options` has those of its load line by name; the others have their
    defaults."""
    if short not in declared["pins"]:
        return False
    given = {**{name: option["default"] for name, option in declared["options"].items()}, **options}
    conditions = declared["pins"][short].get("only_with", "")
    return not conditions or any(_holds(condition, given) for condition in conditions.split(" or "))


def _holds(condition, given):
    letter, is_letter, option = condition.partition(" in ")
    if is_letter:
        return letter in given[option]
    option, is_count, least = condition.partition(">=")
    if is_count:
        return given[option].isdecimal() and int(given[option]) >= int(least)
    option, _sign, value = condition.partition("=")
    return given[option] == value


def _find_executable():
    here = os.path.dirname(os.path.abspath(__file__))
    beside = os.path.join(os.path.dirname(here), "bin", "plumb-host")
    found = beside if os.access(beside, os.X_OK) else shutil.which("plumb-host")
    if found is None:
        raise FileNotFoundError("cannot find plumb-host: neither %s nor in PATH" % beside)
    return found


def _to_json(value):
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    return value


def _nanoseconds(seconds):
    return round(seconds * 1e9)

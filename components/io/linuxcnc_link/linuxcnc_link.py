#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Shows the program and its tools as HAL pins, and faults and statuses of Plumb as messages of LinuxCNC. See linuxcnc_link(1)."""

import argparse
import contextlib
import errno
import itertools
import os
import re
import signal
import sys
import time
import zlib

import hal
import linuxcnc

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
SHARE = os.path.join(PREFIX, "share", "plumb")
sys.path.insert(0, SHARE)
from panel import declared, hal_access, texts, voice  # noqa: E402

PAUSE = 0.02  # s between two looks
TOOLS_PAUSE = 0.5  # s; the table is long
NEWS_PAUSE = 0.1  # s between two looks for news of the instances
NAMES_PAUSE = 1  # s between two looks for instances
ZERO_TIME = 0.5  # s for which zero-set is true
PANEL_PATIENCE = 3  # s for which a beat of the panel counts
UNKNOWN_SIDE = 2
SIDES = {400: 0, 410: 1, 411: 1, 420: -1, 421: -1}  # by G-code, times ten
STATES = (linuxcnc.STATE_ESTOP, linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_OFF, linuxcnc.STATE_ON)
CALL = re.compile(rb"^\s*o\s*<\s*([^<>]+?)\s*>\s*call", re.IGNORECASE | re.MULTILINE)
COMMENT = re.compile(rb"\([^)\n]*\)|;.*")
LINE_NUMBER = re.compile(rb"^n[\d.]+", re.MULTILINE)


def identity(content):
    """The CRC-32 as the signed number that a pin holds; 0 is for nothing."""
    crc = zlib.crc32(content)
    return (crc - (1 << 32) if crc >> 31 else crc) or 1


def orders(content):
    """What a program orders, line by line: without comments, blanks, upper case and numbers of lines."""
    return LINE_NUMBER.sub(b"", re.sub(rb"[^\S\n]", b"", COMMENT.sub(b"", content)).lower())


class Program:
    """The file that LinuxCNC has loaded, and the subroutines that it calls."""

    def __init__(self):
        self.identity = 0
        self._is_read = False
        self._path = ""
        self._folders = []
        self._stamps = {}  # of the files, by path
        self._seen = set()  # names of the files of all programs so far
        self._first_named = None  # since the program began, LinuxCNC 2.10 only

    def look(self, status):
        """Reads changed files again. Returns whether LinuxCNC names the program now. Raises OSError."""
        is_idle = status.interp_state == linuxcnc.INTERP_IDLE
        is_named = is_idle or (status.task_mode == linuxcnc.MODE_AUTO and status.call_level == 0)
        if names_moves(status) and not is_idle:
            if is_named and self._is_another(status.file):
                self.identity, self._is_read = 0, False
                return False
            path = self._path
        else:
            self._first_named = None
            if names_moves(status) and status.file != self._path:
                time.sleep(0.005)  # for one cycle after its end a program names its last move
                status.poll()
                if status.interp_state != linuxcnc.INTERP_IDLE:
                    return False
            path = status.file if is_named else self._path  # while a subroutine runs, LinuxCNC names its file instead
        if self._is_read and path == self._path and self._stamps == self._stamps_now():
            return is_named
        self.identity, self._stamps, self._is_read = 0, {}, False
        self._path = path
        self._folders = subroutine_folders(status.ini_filename)
        if self._path:
            self.identity = identity(orders(b"".join(self._contents(self._path))))
        self._is_read = True
        self._seen.update(os.path.basename(path) for path in self._stamps)
        return is_named

    def _is_another(self, named):
        """Whether another program than the one that was seen before the start moves: it was opened between two looks."""
        named = os.path.basename(named)
        is_first = self._first_named is None
        if is_first:
            self._first_named = named
        own = {os.path.basename(path) for path in self._stamps}
        return bool(named) and named not in own and named not in (self._seen if is_first else {self._first_named})

    def _contents(self, path):
        self._stamps[path] = stamp(path)
        with open(path, "rb") as file:
            content = file.read()
        yield content
        for name in CALL.findall(COMMENT.sub(b"", content)):
            called = self._find(os.fsdecode(name.lower()) + ".ngc")
            if called and called not in self._stamps:
                yield from self._contents(called)

    def _find(self, name):
        for folder in [os.path.dirname(self._path), *self._folders]:
            path = os.path.realpath(os.path.join(folder, name))
            if os.path.isfile(path):
                return path
        return None

    def _stamps_now(self):
        return {path: stamp(path) for path in self._stamps}


def names_moves(status):
    """LinuxCNC 2.10 names the file of the present move while a program runs, even of the last move of the program before."""
    return hasattr(status, "taskbeat")


def stamp(path):
    """Another one after each write: st_mtime_ns alone can be set back, by touch or cp -p."""
    found = os.stat(path)
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


def subroutine_folders(ini_file):
    """The folders of subroutines, apart from the folder of the program."""
    try:
        ini = linuxcnc.ini(ini_file)
    except linuxcnc.error as error:  # it was moved, or is being written
        raise OSError(errno.EIO, str(error), ini_file) from None
    paths = [ini.find("DISPLAY", "PROGRAM_PREFIX") or ""] + (ini.find("RS274NGC", "SUBROUTINE_PATH") or "").split(":")
    return [os.path.join(os.path.dirname(ini_file), os.path.expanduser(path)) for path in paths if path]


def tool_set(status):
    """Identity of the tool table; its first row, the tool in the spindle, is a copy. Lengths along Z are left out: a new insert
    that was measured is the same tool, and the offset of its length has a signal of its own."""
    rows = (tuple(tool)[:11] for tool in status.tool_table[1:] if tool.id > 0)  # id, nine offsets, diameter
    tools = sorted(row[:3] + row[4:] for row in rows)
    return identity(repr(tools).encode()) if tools else 0


def compensation_side(status):
    """1 for G41, -1 for G42, 0 for G40, of the move that runs; other modes than AUTO name the block that was read last."""
    if status.task_mode != linuxcnc.MODE_AUTO:
        return UNKNOWN_SIDE
    return next((SIDES[code] for code in status.gcodes[1:] if code in SIDES), UNKNOWN_SIDE)


class WorkZero:
    """Whether somebody has set the work zero: its offsets change, and the coordinate system stays the same."""

    def __init__(self):
        self._last = None
        self._until = 0

    def is_set(self, status, now):
        """True for ZERO_TIME after a change; now in s."""
        offsets = [*status.g5x_offset[:3], *status.g92_offset[:3]]
        system = status.g5x_index
        if self._last and self._last[0] == system and self._last[1] != offsets:
            self._until = now + ZERO_TIME
        self._last = system, offsets
        return now < self._until


class Operator:
    """Shows the operator what the instances of this machine tell. Their pins come late, as with a postgui file, and go."""

    def __init__(self, component, known):
        self._voice, self._hal, self._panel = voice.Voice(known), hal_access.Hal(component), PanelBeats(component)
        self._names, self._names_due, self._strange = None, 0, []
        self._news_due = 0

    def look(self, show):
        """show(kind, text) raises linuxcnc.error if LinuxCNC does not take it; it comes again then."""
        now = time.monotonic()
        if now < self._news_due:
            return
        self._news_due = now + NEWS_PAUSE
        if now >= self._names_due:
            self._names_due = now + NAMES_PAUSE
            self._meet()
        while self._strange:
            show("text", self._strange[0])
            print("linuxcnc_link: " + self._strange.pop(0), file=sys.stderr, flush=True)
        for news in self._voice.news(hal_access.Now(), now, self._panel.are_heard(now)):
            show(news.tell, news.text)
            self._voice.told(news)

    def _meet(self):
        names = self._hal.values().keys()
        if names != self._names:
            with contextlib.suppress(hal_access.HalGone):
                self._strange += self._voice.meet(self._hal.pins())
                self._names = names


class PanelBeats:
    """Whether plumb panel is on the screen."""

    def __init__(self, component):
        self._component = component
        self._last, self._heard = component["panel-beat"], -PANEL_PATIENCE

    def are_heard(self, now):
        beat = self._component["panel-beat"]
        if beat != self._last:
            self._last, self._heard = beat, now
        return now - self._heard < PANEL_PATIENCE


class Link:
    def __init__(self, component, known):
        self._component = component
        self._operator = Operator(component, known)
        self._program = Program()
        self._status = None
        self._command = None
        self._tools_due = 0
        self._reported = None
        self._zero = WorkZero()

    def step(self):
        identify = self._component["identify"]  # first: later pins are read after the request
        if identify and not self._component["identified"]:
            self._tools_due = 0
        connected = self._connect()
        self._component["connected"] = connected
        self._component["compensation-side"] = compensation_side(self._status) if connected else UNKNOWN_SIDE
        if not connected:
            return
        self._component["zero-set"] = self._zero.is_set(self._status, time.monotonic())
        self._component["work-offset"] = self._status.g5x_offset[2] + self._status.g92_offset[2]
        is_named = False
        try:
            is_named = self._program.look(self._status)
        except OSError as error:
            self._tell("%s: %s" % (error.filename, error.strerror))
        self._component["program-id"] = self._program.identity
        if time.monotonic() >= self._tools_due:
            self._tools_due = time.monotonic() + TOOLS_PAUSE
            self._component["tool-set-id"] = tool_set(self._status)
        self._component["identified"] = identify and (is_named or self._component["identified"])
        texts.MACHINE_UNIT[0] = "in" if self._status.linear_units < 0.1 else "mm"  # per mm
        with contextlib.suppress(linuxcnc.error):
            self._operator.look(lambda kind, text: getattr(self._command, kind + "_msg")(text))

    def _connect(self):
        """HAL files are loaded before task runs; until then the status is missing, or all zero."""
        with contextlib.suppress(linuxcnc.error, SystemError):  # the latter by an error within linuxcnc.stat
            self._status = self._status or linuxcnc.stat()
            self._command = self._command or linuxcnc.command()
            self._status.poll()
            return self._status.joints > 0 and self._status.task_state in STATES
        self._status = self._command = None
        return False

    def _tell(self, what):
        if what != self._reported:
            print("linuxcnc_link: " + what, file=sys.stderr, flush=True)
        self._reported = what


def state(beat, ready):
    """The word for interlock, as interlock(9) has it under "The words": of a program (3) that is service 1."""
    word = 1 << 31 | 3 << 29 | 1 << 24 | beat % 61 << 17 | ready << 8
    return word | (word >> 24 ^ word >> 16 ^ word >> 8 ^ 0xA5) & 0xFF


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--name", default="linuxcnc-link", help="of the HAL component, as in loadusr -Wn")
    parser.add_argument("--messages", metavar="FILE", default="messages.toml", help="your changes, if the file is there (default: %(default)s)")
    arguments = parser.parse_args()
    texts.choose(os.path.join(PREFIX, "share", "locale"))
    texts.PIN_NAMES[0] = False
    try:
        known, damaged = declared.read_all(SHARE, arguments.messages)
    except ValueError as error:
        sys.exit("linuxcnc_link: %s" % error)
    for path in damaged:
        print("linuxcnc_link: %s is damaged, and left out" % path, file=sys.stderr)
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # as nohup does
            signal.signal(number, lambda *_: sys.exit(0))
    component = hal.component(arguments.name)
    try:
        for pin in ("program-id", "tool-set-id"):
            component.newpin(pin, hal.HAL_S32, hal.HAL_OUT)
        component.newpin("connected", hal.HAL_BIT, hal.HAL_OUT)
        component.newpin("identify", hal.HAL_BIT, hal.HAL_IN)
        component.newpin("identified", hal.HAL_BIT, hal.HAL_OUT)
        component.newpin("heartbeat", hal.HAL_BIT, hal.HAL_OUT)
        component.newpin("state", hal.HAL_U32, hal.HAL_OUT)
        component.newpin("compensation-side", hal.HAL_S32, hal.HAL_OUT)
        component["compensation-side"] = UNKNOWN_SIDE
        component.newpin("zero-set", hal.HAL_BIT, hal.HAL_OUT)
        component.newpin("work-offset", hal.HAL_FLOAT, hal.HAL_OUT)
        component.newpin("panel-beat", hal.HAL_S32, hal.HAL_IN)
        component.ready()
        link = Link(component, known)
        for beat in itertools.count():
            link.step()
            component["heartbeat"] = bool(beat & 1)
            component["state"] = state(beat, component["connected"])
            time.sleep(PAUSE)
    finally:
        component.exit()


if __name__ == "__main__":
    main()

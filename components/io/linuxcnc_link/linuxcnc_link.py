#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Program and tool set as HAL pins, and HAL pins as messages to the operator. See linuxcnc_link(1)."""

import argparse
import contextlib
import errno
import gettext
import os
import re
import signal
import sys
import time
import tomllib
import zlib

import hal
import linuxcnc

sys.path.append(os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "python"))  # of a build
import plumb  # noqa: E402

PAUSE = 0.02  # s between two looks
TOOLS_PAUSE = 0.5  # s; the table is long
LONGEST = 250  # characters; LinuxCNC cuts longer texts
OWN_PINS = ("program-id", "tool-set-id", "connected", "identify", "identified", "heartbeat", "compensation-side", "panel-beat", "zero-set", "work-offset")
ZERO_TIME = 0.5  # s for which zero-set is true
PANEL_PATIENCE = 3  # s for which a beat of the panel counts
LOCALE = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "share", "locale")  # the texts of the panel, codes too
UNKNOWN_SIDE = 2
SIDES = {400: 0, 410: 1, 411: 1, 420: -1, 421: -1}  # by G-code, times ten
STATES = (linuxcnc.STATE_ESTOP, linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_OFF, linuxcnc.STATE_ON)
STATUS = "status-code"  # of a function; a status with a detail has the message of that
CALL = re.compile(rb"^\s*o\s*<\s*([^<>]+?)\s*>\s*call", re.IGNORECASE | re.MULTILINE)
UNITS = {  # of values in a message, as texts; a value, and the micrometres of a machine unit
    "count": lambda value, _: "%d" % value,
    "um": lambda value, micrometres: "%.1f \u00b5m" % (value * micrometres),
    "%": lambda value, _: "%.0f %%" % value,
}
COMMENT = re.compile(rb"\([^)]*\)|;.*")


class SettingsError(ValueError):
    """The TOML file of messages is wrong."""


def identity(content):
    """The CRC-32 as the signed number that a pin holds; 0 is for nothing."""
    crc = zlib.crc32(content)
    return (crc - (1 << 32) if crc >> 31 else crc) or 1


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
            self.identity = identity(b"".join(self._contents(self._path)))
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


def declared_codes(source, say=lambda text: text):
    """The sentences of "MODULE PIN", as the module declares them, each translated by say(). Raises OSError and ValueError."""
    words = source.split()
    if len(words) != 2:
        raise ValueError("'%s' is not a module and its pin, as 'axis_offset fault-code'" % source)
    module, pin = words
    declared = plumb.declarations(module)
    if pin == STATUS and "statuses" in declared:
        return {
            code: ("%s %s" % (say(its["sentence"]), say(its["remedy"]) if its["remedy"] else "")).rstrip()
            for code, its in declared["statuses"].items()
            if its["kind"] == "bad" and not its["detail"]
        }
    codes = declared["codes"]
    if pin not in codes:
        raise ValueError("%s has no codes of '%s', only of: %s" % (module, pin, ", ".join(sorted(codes)) or "nothing"))
    return {code: say(text) for code, text in codes[pin].items()}


class Message:
    """One message, and the pins by which it is called for."""

    KINDS = ("error", "text", "display")

    def __init__(self, table, where, languages=()):
        def fail(why):
            raise SettingsError("%s: %s" % (where, why))

        if not isinstance(table, dict):
            fail("it is no table")
        for key in table:
            if key not in ("pin", "text", "kind", "codes", "values", "except", "only", "on-panel", "translated"):
                fail("unknown key '%s'" % key)
        for key in ("pin", "text"):
            if not isinstance(table.get(key), str) or not table[key]:
                fail("there is no %s" % key)
        self.pin, self.text, self.kind = table["pin"], table["text"], table.get("kind", "text")
        if not re.fullmatch(r"[a-z0-9-]{1,24}", self.pin):
            fail("pin = '%s' is not of a-z, 0-9 and -, at most 24" % self.pin)
        if self.kind not in self.KINDS:
            fail("kind = '%s' is none of %s" % (self.kind, ", ".join(self.KINDS)))
        self.on_panel = table.get("on-panel", False)
        if not isinstance(self.on_panel, bool):
            fail("on-panel is neither true nor false")
        codes = table.get("codes")
        in_words = {}
        self.only_listed = isinstance(codes, str) and codes.endswith(" " + STATUS)  # other statuses are for screens
        if isinstance(codes, str):
            try:
                source, codes = codes, declared_codes(codes)
                catalog = gettext.translation("plumb-panel", LOCALE, languages=list(languages), fallback=True)
                in_words = declared_codes(source, catalog.gettext)
            except (OSError, ValueError) as error:
                fail("codes: %s" % error)
        if codes is not None and not isinstance(codes, dict):
            fail("codes is neither a table nor a module and its pin")
        try:
            self.codes = None if codes is None else {int(code): text for code, text in codes.items()}
        except ValueError as error:
            fail("codes: %s" % error)
        self.values = table.get("values", {})  # unit by name
        if not isinstance(self.values, dict) or not all(unit in UNITS for unit in self.values.values()):
            fail("values is no table of %s" % ", ".join(UNITS))
        for name in self.values:
            if not re.fullmatch(r"[a-z]{1,12}", name) or "{%s}" % name not in self.text:
                fail("value '%s' is not of a-z, or not in the text as {%s}" % (name, name))
        for code, text in (self.codes or {}).items():
            if not isinstance(text, str):
                fail("codes: %d has no text" % code)
        self.left_out = self._left_out(table, fail)
        if (self.codes is not None) != ("{code}" in self.text):
            fail("{code} in the text and codes belong together")
        for text in map(self._composed, self.codes or [0]):
            if len(text.encode()) > LONGEST:
                fail("longer than %d characters: '%s'" % (LONGEST, text))
        self._translate(table.get("translated", {}), languages, in_words, fail)
        self.seen = None  # the code of the last message, None while the pin is false

    def _left_out(self, table, fail):
        """The codes that other messages tell."""
        if "only" in table and "except" in table:
            fail("only and except do not go together")
        for key in ("only", "except"):
            listed = table.get(key, [])
            if not isinstance(listed, list):
                fail("%s is no list of codes" % key)
            for code in listed:
                if type(code) is not int or code not in (self.codes or {}):
                    fail("%s: %s is none of its codes" % (key, code))
        return [code for code in self.codes or {} if code not in table["only"]] if "only" in table else table.get("except", [])

    def _translate(self, texts, languages, codes, fail):
        """Takes the text of the first language that there is. A translated code that makes it too long stays English."""
        if not isinstance(texts, dict) or not all(isinstance(text, str) and text for text in texts.values()):
            fail("translated is no table of texts by language")
        for text in texts.values():
            for name in ("code", *self.values):
                if ("{%s}" % name in text) != ("{%s}" % name in self.text):
                    fail("{%s} is in the text and in each translation, or in none" % name)
            if len(text.encode()) > LONGEST:
                fail("longer than %d characters: '%s'" % (LONGEST, text))
        language = next((each for each in languages if each in texts), None)
        if language is None:
            return
        self.text = texts[language]
        for code, text in codes.items():
            if len(self.text.replace("{code}", text).encode()) <= LONGEST:
                self.codes[int(code)] = text

    @property
    def pins(self):
        return [*self._own_pins, *map(self._value_pin, self.values)]

    @property
    def _own_pins(self):
        return [self.pin] if self.codes is None else [self.pin, self.pin + "-code"]

    def _value_pin(self, name):
        return "%s-%s" % (self.pin, name)

    def make_pins(self, component):
        for name, unit in self.values.items():
            component.newpin(self._value_pin(name), hal.HAL_S32 if unit == "count" else hal.HAL_FLOAT, hal.HAL_IN)
        for name, kind in zip(self._own_pins, (hal.HAL_BIT, hal.HAL_S32)):
            component.newpin(name, kind, hal.HAL_IN)

    def new_text(self, component, panel_is_seen=False, micrometres=1000.0):
        """The text to show now, if any; `micrometres` is the number in a machine unit. A text that the panel shows waits until the panel is hidden."""
        if self.on_panel and panel_is_seen and component[self.pin]:
            return None
        code = component[self.pin + "-code"] if self.codes is not None else 0
        now = code if component[self.pin] else None
        if now in self.left_out or self.only_listed and now not in self.codes:
            now = None
        news = now is not None and now != self.seen
        self.seen = now
        if not news:
            return None
        text = self._composed(now)
        for name, unit in self.values.items():
            text = text.replace("{%s}" % name, UNITS[unit](component[self._value_pin(name)], micrometres))
        return text

    def _composed(self, code):
        if self.codes is None:
            return self.text
        return self.text.replace("{code}", self.codes.get(code, "code %d" % code))


def languages_of_user(environment=os.environ):
    """As gettext reads them, such as de_AT and de; none for C."""
    chosen = next((environment[name] for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG") if environment.get(name)), "")
    names = [name.split(".")[0].split("@")[0] for name in chosen.split(":")]
    return [part for name in names if name not in ("", "C", "POSIX") for part in dict.fromkeys((name, name.split("_")[0]))]


def read_messages(*paths, languages=()):
    """The messages of all these files. Raises SettingsError, which names the file and the message."""
    messages, places = [], dict.fromkeys(OWN_PINS)  # places: the files of pins
    for path in paths:
        for message in read_file(path, languages):
            for pin in message.pins:
                if pin in places:
                    other = places[pin]
                    where = "; the other one is in %s" % other if other not in (None, path) else ""
                    raise SettingsError("%s: there are two pins %s%s" % (path, pin, where))
                places[pin] = path
            messages.append(message)
    return messages


def read_file(path, languages=()):
    try:
        with open(path, "rb") as file:
            table = tomllib.load(file)
    except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError("%s: %s" % (path, getattr(error, "strerror", None) or error)) from None
    for key in table:
        if key != "message":
            raise SettingsError("%s: unknown key '%s'" % (path, key))
    tables = table.get("message", [])
    if not isinstance(tables, list):
        raise SettingsError("%s: message is no list of tables: write [[message]]" % path)
    return [Message(entry, "%s: message %d" % (path, number), languages) for number, entry in enumerate(tables, 1)]


class Link:
    def __init__(self, component, messages):
        self._component = component
        self._messages = messages
        self._program = Program()
        self._status = None
        self._command = None
        self._tools_due = 0
        self._reported = None
        self._panel_beat, self._panel_beaten = component["panel-beat"], -PANEL_PATIENCE
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
        panel_is_seen = self._panel_is_seen()
        for message in self._messages:
            text = message.new_text(self._component, panel_is_seen, 1000 / self._status.linear_units)
            if text is not None:
                try:
                    getattr(self._command, message.kind + "_msg")(text)
                except linuxcnc.error:
                    message.seen = None  # so it is tried again

    def _panel_is_seen(self):
        beat = self._component["panel-beat"]
        if beat != self._panel_beat:
            self._panel_beat, self._panel_beaten = beat, time.monotonic()
        return time.monotonic() - self._panel_beaten < PANEL_PATIENCE

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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--name", default="linuxcnc-link", help="of the HAL component, as in loadusr -Wn")
    parser.add_argument(
        "--messages",
        metavar="FILE",
        action="append",
        default=[],
        help="TOML file of messages to the operator; give it again for another file",
    )
    arguments = parser.parse_args()
    try:
        messages = read_messages(*arguments.messages, languages=languages_of_user())
    except SettingsError as error:
        sys.exit("linuxcnc_link: %s" % error)
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
        component.newpin("compensation-side", hal.HAL_S32, hal.HAL_OUT)
        component["compensation-side"] = UNKNOWN_SIDE
        component.newpin("zero-set", hal.HAL_BIT, hal.HAL_OUT)
        component.newpin("work-offset", hal.HAL_FLOAT, hal.HAL_OUT)
        component.newpin("panel-beat", hal.HAL_S32, hal.HAL_IN)
        for message in messages:
            message.make_pins(component)
        component.ready()
        link = Link(component, messages)
        while True:
            link.step()
            component["heartbeat"] = not component["heartbeat"]
            time.sleep(PAUSE)
    finally:
        component.exit()


if __name__ == "__main__":
    main()

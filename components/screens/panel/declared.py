# SPDX-License-Identifier: GPL-2.0-or-later
"""What the components declare about themselves, from the files that their manual pages are made of, and from messages.toml of the user."""

import glob
import json
import os
import tomllib

TELL = ("never", "behind-panel", "text", "error")
KINDS = ("good", "wait", "off", "warn", "bad")
STATUS = {"remedy": "", "button": "", "detail": "", "size": "", "after": 0}
OWN = ("title", "statuses", "codes", "told")  # what messages.toml may have of a component


class Declared:
    """One module: pins by their names without the instance, sentences of codes by pin and number."""

    def __init__(self, content):
        self.name, self.summary, self.role = content["name"], content.get("summary", ""), content.get("role", "")
        self.title = content.get("title", "")  # of its page and its messages
        self.codes = {pin: {int(code): text for code, text in texts.items()} for pin, texts in content.get("codes", {}).items()}
        self.statuses = {int(number): {**STATUS, **its} for number, its in content.get("statuses", {}).items()}
        self.told = content.get("told", {})  # bits that are told when they rise: tell, and sentence with the values of pins in braces
        self.fault_code = next((pin for pin in ("fault-code", "detail-code") if pin in self.codes), "")  # the cause of its fault
        self.is_users = "pins" not in content  # of messages.toml
        self.pins = content.get("pins", dict.fromkeys([*["status-code"][: len(self.statuses)], *self.codes, *self.told], {}))
        self.is_of_sensors = "CHANNEL.value" in self.pins
        self.moves = content.get("moves", {})  # outputs that move an axis; "bound" of one is the setting that bounds it
        self.has_records = {"row-shown", "restores"} <= set(self.pins)

    def pin(self, short):
        return self.pins.get(short, {})

    def is_of_records(self, short):
        """Whether a pin is there for plumb-retain alone, which walks the records."""
        return self.has_records and (short in ("row", "forget", "kept", "restore", "rows", "restores", "restores-refused")
                                     or short.startswith(("row-", "restore-")))

    def sentence(self, pin, code):
        """The sentence of a code, '' for 0."""
        if not code:
            return ""
        return self.codes.get(pin, {}).get(code, "%s %s" % (pin, code))


def read_all(folder, own=""):
    """All modules by name, as the user has changed them in the file `own`, if it is there; a damaged file of the folder is left out, and
    named in the second result. Raises ValueError about `own`."""
    contents, damaged = {}, []
    for path in sorted(glob.glob(os.path.join(folder, "*.json"))):
        try:
            with open(path, encoding="utf-8") as file:
                content = json.load(file)
            Declared(content)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            damaged.append(path)
            continue
        contents[content["name"]] = content
    if own and os.path.exists(own):
        _change(contents, own)
    return {name: Declared(content) for name, content in contents.items()}, damaged


def _change(contents, path):
    """Puts the entries of messages.toml over the declarations. A component that has none is the user's."""
    try:
        with open(path, "rb") as file:
            changes = tomllib.load(file)
        if "message" in changes:
            raise ValueError("[[message]] is of Plumb 0.2: a component's texts come by themselves now, see linuxcnc_link(1)")
        for name, entries in changes.items():
            content = contents.setdefault(name, {"name": name})
            for key, entry in _table(name, entries).items():
                if key not in OWN:
                    raise ValueError("[%s]: unknown key '%s', none of %s" % (name, key, ", ".join(OWN)))
                content[key] = _merged(content.get(key), entry)
            _judge(name, content)
    except (OSError, ValueError) as error:
        raise ValueError("%s: %s" % (path, getattr(error, "strerror", None) or error)) from None


def _table(name, entries):
    if not isinstance(entries, dict):
        raise ValueError("%s is no table: write [%s]" % (name, name))
    return entries


def _merged(former, entry):
    if isinstance(former, dict) and isinstance(entry, dict):
        return {**former, **{key: _merged(former.get(key), value) for key, value in entry.items()}}
    return entry


def _judge(name, content):
    """Completes statuses of a user's component. Raises ValueError about what cannot be told."""
    statuses, told, codes = (_table("%s.%s" % (name, key), content.get(key, {})) for key in ("statuses", "told", "codes"))
    for number, its in statuses.items():
        where = "[%s.statuses.%s]" % (name, number)
        if not number.isdecimal():
            raise ValueError("%s: %s is no number" % (where, number))
        if _table(where[1:-1], its).get("kind") not in KINDS:
            raise ValueError("%s: kind is none of %s" % (where, ", ".join(KINDS)))
        its.setdefault("tell", "error" if its["kind"] == "bad" else "never")
        if "detail-code" in codes:
            its.setdefault("detail", "detail-code")
        if not isinstance(its.get("after", 0), (int, float)):
            raise ValueError("%s: after is no number of seconds" % where)
    for where, its in [("statuses." + key, its) for key, its in statuses.items()] + [("told." + key, _table(key, its)) for key, its in told.items()]:
        if its.get("tell") not in TELL:
            raise ValueError("[%s.%s]: tell is none of %s" % (name, where, ", ".join(TELL)))
        if not isinstance(its.get("sentence"), str) or not isinstance(its.get("remedy", ""), str):
            raise ValueError("[%s.%s]: there is no sentence" % (name, where))
    for pin, texts in codes.items():
        for number, text in _table("%s.codes.%s" % (name, pin), texts).items():
            if not number.isdecimal() or not isinstance(text, str):
                raise ValueError("[%s.codes.%s]: write NUMBER = \"SENTENCE\"" % (name, pin))

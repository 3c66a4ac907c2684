# SPDX-License-Identifier: GPL-2.0-or-later
"""Changes of settings: judged, written, logged, kept by plumb-retain. Without a screen."""

import collections
import contextlib
import json
import math
import os
import random
import re
import time
import tomllib

from panel import chains, files
from panel.changes import Change, ChangeLog, now
from panel.texts import _, with_unit

OFF = ("0", "false")  # texts of a bit
S32 = (-(1 << 31), (1 << 31) - 1)
U32 = (0, (1 << 32) - 1)
CHAIN, MDI = "[SQUARENESS]CHAIN", "MDI"  # what a change has in the place of a pin
REFERENCE = " reference"  # also behind the name of the component
SETTLING = 0.15  # s in which a component judges a new setting


class Refused(ValueError):
    """A value that is not written; the text names pin, value and reason."""


class Conflict(Refused):
    """Another screen has changed the setting meanwhile; `change` is that change, or None."""

    def __init__(self, text, change):
        super().__init__(text)
        self.change = change


def as_text(value):
    """As setp takes it."""
    if isinstance(value, bool):
        return "1" if value else "0"
    return repr(value) if isinstance(value, float) else str(value)


def parsed(name, kind, text):
    """The value of a text for a pin. Raises Refused."""
    text = str(text).strip()
    if kind == "bit":
        if text.lower() in ("1", "true", "0", "false"):
            return text.lower() in ("1", "true")
        raise Refused(_("{pin}: \"{text}\" is neither on nor off.").format(pin=name, text=text))
    try:
        value = float(text.replace(",", ".")) if kind == "float" else int(text)
    except ValueError:
        what = _("no number") if kind == "float" else _("no whole number")
        raise Refused(_("{pin}: \"{text}\" is {what}.").format(pin=name, text=text, what=what)) from None
    if kind == "float":
        if not math.isfinite(value):
            raise Refused(_("{pin}: {text} is not a finite number.").format(pin=name, text=text))
        return value
    lowest, highest = S32 if kind == "s32" else U32
    if not lowest <= value <= highest:
        raise Refused(_("{pin}: {text} is beyond {lowest} to {highest}.").format(pin=name, text=text, lowest=lowest, highest=highest))
    return value


Done = collections.namedtuple("Done", "values lost")
Done.__doc__ = "The values that are in force, and a sentence about what could not be logged or kept, or ''."


class Write(collections.namedtuple("Write", "instance short text seen lasts", defaults=(None, True))):
    """A setting to be written, which a user saw as `seen`; plumb-retain keeps it if it lasts."""

    @property
    def name(self):
        return self.instance.full(self.short)

    @property
    def unit(self):
        return self.instance.declared.pin(self.short).get("unit", "")


class Settings:
    """The settings of one machine, in a folder that all its screens share.

    hal     get(name), set(name, text) and values()
    settle  waits until the components have judged a new value
    """

    def __init__(self, hal, folder, who, machine_name="", settle=lambda: time.sleep(SETTLING)):
        self.hal, self.who, self.machine_name, self._settle = hal, who, machine_name, settle
        self.log = ChangeLog(os.path.join(folder, "panel_changes.log"))
        self.kept_file = os.path.join(folder, "panel.toml")
        self.session = ""  # the start of HAL that a change of the chain belongs to

    def change(self, instance, short, text, seen=None, why=""):
        """Writes a setting that a user saw as `seen`. Returns its value. Raises Refused, and Conflict."""
        return self.change_all([Write(instance, short, text, seen)], why).values[0]

    def change_all(self, writes, why="", chain=None):
        """Writes settings together, or none of them. Returns what was Done. Raises Refused, and Conflict.

        chain  (file, former, new) of a chain that is written first
        """
        values = [self._judged(write) for write in writes]
        olds = [self._value(write) for write in writes]
        try:
            with self.log.alone():
                return self._write_all(writes, values, why, chain)
        except OSError as error:
            raise Refused(" ".join((self._state(writes, olds), self._cause(error)))) from None

    def switch_off(self, writes, why=""):
        """Off goes before the log, its lock, and what another screen has changed. Returns what was Done. Raises Refused if HAL refuses it."""
        olds = [self._value(write) for write in writes]
        for write in writes:
            self._set(write, write.text not in OFF)
        values = [self._value(write) for write in writes]
        return Done(values, self._noted(writes, olds, values, why, new_deed()))

    def _value(self, write):
        try:
            return self.hal.get(write.name)
        except KeyError:
            raise Refused(_("{pin} is not there any more: its component was unloaded.").format(pin=write.name)) from None

    def _state(self, writes, olds):
        """What the pins are, read back."""
        now = [self._value(write) for write in writes]
        if all(map(same, now, olds)):
            return _("{pin} is not changed.").format(pin=", ".join(write.name for write in writes) or CHAIN)
        return " ".join(_("{pin} is {value} now.").format(pin=write.name, value=with_unit(value, write.unit)) for write, value in zip(writes, now))

    def _cause(self, error):
        return "%s: %s." % (error.filename or self.log.path, error.strerror)

    def _noted(self, writes, olds, values, why, deed, chain=None):
        """Logs and keeps what was written. Returns a sentence about what could not be; ''."""
        lost = ""
        changes = [Change(now(), self.who, CHAIN, chain[1], chain[2], why, deed)] if chain else []
        changes += [Change(now(), self.who, write.name, as_text(old), as_text(value), why, deed)
                    for write, value, old in zip(writes, values, olds) if not same(old, value)]
        for change in changes:
            lost = self._logged(change) or lost
        try:
            for write in writes:
                if write.lasts:
                    self.keep(write.name)
        except OSError as error:
            lost = lost or _("The change could not be kept: {why}").format(why=self._cause(error))
        except Refused as refused:
            lost = lost or _("The change could not be kept: {why}").format(why=refused)
        return lost

    def _logged(self, change):
        """Logs a change, or returns why it could not be: this screen alone remembers it then."""
        try:
            self.log.add(change)
        except OSError as error:
            return _("The change could not be logged: {why}").format(why=self._cause(error))
        return ""

    def _judged(self, write):
        pin, limits = write.instance.pins[write.short], write.instance.declared.pin(write.short)
        value, unit = parsed(pin.name, pin.kind, write.text), limits.get("unit", "")
        for key, beyond in (("minimum", lambda limit: value < limit), ("maximum", lambda limit: value > limit)):
            if key in limits and beyond(limits[key]):
                which = _("at least") if key == "minimum" else _("at most")
                raise Refused(_("{pin}: {value} is out of range: {which} {limit}.").format(
                    pin=pin.name, value=with_unit(value, unit), which=which, limit=with_unit(limits[key], unit)))
        return value

    def _write_all(self, writes, values, why, chain):
        olds = [self._present(write, value) for write, value in zip(writes, values)]
        faults = {write.instance.name: self._fault(write.instance) for write in writes}
        if chain:
            chains.write(chain[0], chain[2])
        done = []
        try:
            for write, value, old in zip(writes, values, olds):
                done.append((write, old))
                self._set(write, value)
            self._settle()
            for write, value in zip(writes, values):
                fault = self._fault(write.instance)
                if fault not in (0, faults[write.instance.name]):
                    raise Refused(_("{instance} refuses {pin} = {value}: {why}").format(
                        instance=write.instance.name, pin=write.name, value=with_unit(value, write.unit),
                        why=_(write.instance.declared.sentence(write.instance.declared.fault_code, fault))))
        except Refused as refused:
            for write, old in reversed(done):
                with contextlib.suppress(ValueError):
                    self.hal.set(write.name, as_text(old))
            self._settle()
            if chain:
                chains.write(chain[0], chain[1])
            raise Refused("%s %s" % (refused, self._state(writes, olds))) from None
        return Done(values, self._noted(writes, olds, values, why, new_deed() + ("@" + self.session if chain else ""), chain))

    def _present(self, write, value):
        name, unit, seen, old = write.name, write.unit, write.seen, self._value(write)
        if seen is not None and not same(old, seen) and not same(old, value):
            change = self.log.last(name)
            by = _(" by {who}").format(who=change.who) if change and same_text(change.new, old) else ""
            raise Conflict(_("{pin} was changed meanwhile{by}: it was {seen} and is {now}. Your {value} is not written.").format(
                pin=name, by=by, seen=with_unit(seen, unit), now=with_unit(old, unit), value=with_unit(value, unit)), change)
        return old

    def _set(self, write, value):
        try:
            self.hal.set(write.name, as_text(value))
        except ValueError as error:
            raise Refused(_("HAL refuses {pin} = {value}: {why}").format(pin=write.name, value=with_unit(value, write.unit), why=error)) from None

    def _fault(self, instance):
        """Its number, 0 for none."""
        values = self.hal.values()
        return instance.value(values, instance.declared.fault_code, 0) if instance.value(values, "fault") else 0

    def note(self, name, old, new, why="", deed=""):
        """Logs a write that is no setting, such as a button. A log that cannot be written stops no button: returns why it could not, or ''."""
        return self._logged(Change(now(), self.who, name, old, new, why, deed))

    def note_all(self, changes, why=""):
        """Logs (name, old, new) that belong together."""
        deed, lost = new_deed(), ""
        for name, old, new in changes:
            lost = self.note(name, old, new, why, deed) or lost
        return lost

    def undoing(self, change, machine):
        """What takes the whole deed of a change back: writes, the chain's former text or '', the MDI lines, and former references as
        (instance, text).

        Raises Refused, also for a deed that a later change has overtaken.
        """
        writes, chain, lines, references = [], "", [], []
        for each in self.log.together_with(change):
            if each.pin == MDI:
                if not each.old:
                    raise Refused(_("{line} cannot be undone.").format(line=each.new))
                lines.append(each.old)
                continue
            if self.log.last(each.pin) != each:
                raise Conflict(_("{pin} was changed again since: undo that first.").format(pin=each.pin), self.log.last(each.pin))
            if each.pin == CHAIN:
                chain = each.old
                continue
            if each.pin.endswith(REFERENCE):
                instance = machine.named(each.pin[: -len(REFERENCE)])
                if instance is None:
                    raise Refused(_("{pin} is not there any more: its component was unloaded.").format(pin=each.pin))
                references.append((instance, each.old))
                continue
            instance, short = machine.owner_of(each.pin)
            if instance is None or short not in instance.settings():
                raise Refused(_("{pin} is not there any more: its component was unloaded.").format(pin=each.pin))
            pin = instance.pins[short]
            writes.append(Write(instance, short, each.old, parsed(pin.name, pin.kind, each.new), lasts=False))
        return writes, chain, lines, references

    def last_of(self, name):
        last = self.log.last(name)
        if last is None:
            raise Refused(_("{pin} has not been changed here.").format(pin=name))
        return last

    # --- what plumb-retain keeps ---

    def kept(self):
        """Pins that plumb-retain keeps for the screens. Raises Refused for a damaged file."""
        return self._read_kept().get("pins", [])

    def _read_kept(self):
        try:
            with open(self.kept_file, "rb") as file:
                return tomllib.load(file)
        except FileNotFoundError:
            return {}
        except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise Refused("%s: %s" % (self.kept_file, getattr(error, "strerror", None) or error)) from None

    def keep(self, name, keep=True):
        """Adds a pin to those that plumb-retain keeps, or takes it from them."""
        content = self._read_kept()
        pins = content.get("pins", [])
        if (name in pins) == keep:
            return
        pins = sorted(set(pins) | {name}) if keep else [pin for pin in pins if pin != name]
        machine = content.get("machine") or re.sub(r'[^ -~]|["\\]', " ", self.machine_name).strip() or "machine"
        lines = ["# SPDX-License-Identifier: GPL-2.0-or-later", "# Written by plumb panel: the settings that plumb-retain keeps for it.",
                 "machine = " + json.dumps(machine)]
        lines += ["%s = %s" % (key, json.dumps(value)) for key, value in content.items() if key in ("store", "every", "bound")]
        lines += ["pins = [", *("    %s," % json.dumps(pin) for pin in pins), "]"]
        files.replace(self.kept_file, "\n".join(lines) + "\n")

    def retain_state(self, values):
        """Why plumb-retain does not keep the settings of the screens; '' if it does."""
        if "panel-settings.restored" not in values:
            return _("No plumb-retain keeps the settings of this screen: a change is lost when LinuxCNC ends.")
        if not values["panel-settings.restored"]:
            return _("plumb-retain has not restored the settings of this screen: see its page.")
        return ""


def new_deed():
    return "%08x" % random.getrandbits(32)


def same(one, other):
    if isinstance(one, float) or isinstance(other, float):
        one, other = float(one), float(other)
        return one == other or (math.isnan(one) and math.isnan(other))
    return one == other


def same_text(text, value):
    try:
        return same(type(value)(float(text)), value)
    except (ValueError, OverflowError):
        return False

# SPDX-License-Identifier: GPL-2.0-or-later
"""Changes of settings: judged, written, logged, kept by retain. Without a screen."""

import json
import math
import os
import re
import tempfile
import time
import tomllib

from panel.changes import Change, ChangeLog, now
from panel.texts import _, with_unit

S32 = (-(1 << 31), (1 << 31) - 1)
U32 = (0, (1 << 32) - 1)
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


class Settings:
    """The settings of one machine, in a folder that all its screens share.

    hal     get(name), set(name, text) and values()
    settle  waits until the components have judged a new value
    """

    def __init__(self, hal, folder, who, machine_name="", settle=lambda: time.sleep(SETTLING)):
        self.hal, self.who, self.machine_name, self._settle = hal, who, machine_name, settle
        self.log = ChangeLog(os.path.join(folder, "panel_changes.log"))
        self.kept_file = os.path.join(folder, "panel.toml")

    def change(self, instance, short, text, seen=None, why=""):
        """Writes a setting that a user saw as `seen`. Returns its value. Raises Refused, and Conflict."""
        pin = instance.pins[short]
        name, unit = pin.name, instance.declared.pin(short).get("unit", "")
        value = parsed(name, pin.kind, text)
        limits = instance.declared.pin(short)
        for key, beyond in (("minimum", lambda limit: value < limit), ("maximum", lambda limit: value > limit)):
            if key in limits and beyond(limits[key]):
                which = _("at least") if key == "minimum" else _("at most")
                raise Refused(_("{pin}: {value} is out of range: {which} {limit}.").format(
                    pin=name, value=with_unit(value, unit), which=which, limit=with_unit(limits[key], unit)))
        try:
            with self.log.alone():
                return self._write(instance, pin, unit, value, seen, why)
        except OSError as error:
            raise Refused(_("{pin} is not changed: {file}: {why}.").format(pin=name, file=error.filename, why=error.strerror)) from None

    def _write(self, instance, pin, unit, value, seen, why):
        name = pin.name
        try:
            old = self.hal.get(name)
        except KeyError:
            raise Refused(_("{pin} is not there any more: its component was unloaded.").format(pin=name)) from None
        if seen is not None and not same(old, seen) and not same(old, value):
            change = self.log.last(name)
            by = _(" by {who}").format(who=change.who) if change and same_text(change.new, old) else ""
            raise Conflict(_("{pin} was changed meanwhile{by}: it was {seen} and is {now}. Your {value} is not written.").format(
                pin=name, by=by, seen=with_unit(seen, unit), now=with_unit(old, unit), value=with_unit(value, unit)), change)
        codes = self._codes(instance)
        try:
            self.hal.set(name, as_text(value))
        except ValueError as error:
            raise Refused(_("HAL refuses {pin} = {value}: {why}").format(pin=name, value=with_unit(value, unit), why=error)) from None
        self._settle()
        objection = self._objection(instance, codes)
        if objection:
            self.hal.set(name, as_text(old))
            self._settle()
            raise Refused(_("{instance} refuses {pin} = {value}: {why} It stays {old}.").format(
                instance=instance.name, pin=name, value=with_unit(value, unit), why=_(objection), old=with_unit(old, unit)))
        if not same(old, value):
            self.log.add(Change(now(), self.who, name, as_text(old), as_text(value), why))
        self.keep(name)
        return value

    def _codes(self, instance):
        values = self.hal.values()
        return {short: instance.value(values, short, 0) for short in instance.declared.codes if short in instance.pins}

    def _objection(self, instance, before):
        """The sentence of a fault that came with the new value."""
        code = self._codes(instance).get("fault-code", 0)
        return instance.declared.sentence("fault-code", code) if code and code != before.get("fault-code") else ""

    def undo(self, instance, short):
        """Puts the last change of a setting back, if its value is still in force: the log may lack a later change."""
        last = self.log.last(instance.full(short))
        if last is None:
            raise Refused(_("{pin} has not been changed here.").format(pin=instance.full(short)))
        pin = instance.pins[short]
        return self.change(instance, short, last.old, seen=parsed(pin.name, pin.kind, last.new), why="undo")

    # --- what retain keeps ---

    def kept(self):
        """Pins that retain keeps for the screens. Raises Refused for a damaged file."""
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
        """Adds a pin to those that retain keeps, or takes it from them."""
        content = self._read_kept()
        pins = content.get("pins", [])
        if (name in pins) == keep:
            return
        pins = sorted(set(pins) | {name}) if keep else [pin for pin in pins if pin != name]
        machine = content.get("machine") or re.sub(r'[^ -~]|["\\]', " ", self.machine_name).strip() or "machine"
        lines = ["# SPDX-License-Identifier: GPL-2.0-or-later", "# Written by plumb panel: the settings that retain keeps for it.",
                 "machine = " + json.dumps(machine)]
        lines += ["%s = %s" % (key, json.dumps(value)) for key, value in content.items() if key in ("store", "every")]
        lines += ["pins = [", *("    %s," % json.dumps(pin) for pin in pins), "]"]
        folder = os.path.dirname(self.kept_file)
        with tempfile.NamedTemporaryFile("w", dir=folder, prefix=".panel-", delete=False, encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
            file.flush()
            os.fsync(file.fileno())
        os.chmod(file.name, 0o644)
        os.replace(file.name, self.kept_file)

    def retain_state(self, values):
        """Why retain does not keep the settings of the screens; '' if it does."""
        if "panel-settings.restored" not in values:
            return _("No retain keeps the settings of this screen: a change is lost when LinuxCNC ends.")
        if not values["panel-settings.restored"]:
            return _("retain has not restored the settings of this screen: see its page.")
        return ""


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

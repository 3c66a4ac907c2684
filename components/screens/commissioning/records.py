# SPDX-License-Identifier: GPL-2.0-or-later
"""What was commissioned: a file of the machine, the sheets to sign, and what has changed since."""

import getpass
import html
import json
import os
import time

from commissioning import pictures
from panel.files import replace
from panel.texts import VERSION, _, number

FILE, LENT = "commissioned.json", "lent.json"
MOST_SHOWN = 6


class Records:
    """The file of one machine; `folder` also holds its sheets."""

    def __init__(self, folder, machine):
        self.folder, self.machine = folder, machine
        self.path = os.path.join(folder, FILE)

    def all(self):
        """The last record of each place, by its key. Raises ValueError where the file is damaged."""
        try:
            with open(self.path, encoding="utf-8") as file:
                found = json.load(file)
        except FileNotFoundError:
            return {}
        if not isinstance(found, dict) or not all(isinstance(one, dict) for one in found.get("places", {}).values()):
            raise ValueError("%s is damaged" % self.path)
        return found.get("places", {})

    def note(self, rig, place, who, log, tolerance, by_hand=False, minutes=None, untried=()):
        """Notes that a function or a stage has passed."""
        places = self.all()
        places[place.key] = {
            "kind": place.kind, "name": place.name, "module": place.module, "when": time.strftime("%Y-%m-%d %H:%M:%S"), "who": who,
            "user": getpass.getuser(), "by_hand": by_hand, "identity": rig.identity(place), "log": list(log), "tolerance": tolerance,
            "versions": versions(), "wiring": rig.wiring(place), "settings": rig.settings(place), "scales": rig.scales(place), "options": rig.options(place), "unit": _unit(rig), "minutes": minutes,
            "untried": list(untried),
        }
        self._write(places)

    def take_back(self, rig, places):
        """Functions and stages that have not passed any more."""
        for place in places:
            rig.take_back(place)
        kept = self.all()
        if any([kept.pop(place.key, None) for place in places]):
            self._write(kept)

    def _write(self, places):
        os.makedirs(self.folder, exist_ok=True)
        replace(self.path, json.dumps({"machine": self.machine, "places": places}, indent=1, ensure_ascii=False) + "\n")

    # --- settings that a step has changed for a while ---

    def lend(self, memory, pin, value):
        """Notes the value of a pin before its change, in the HAL of this memory; the first one counts."""
        self._write_lent({"memory": memory, "pins": {pin: value, **self.lent(memory)}})

    def lent(self, memory):
        """Values by pins; none where another LinuxCNC noted them."""
        try:
            with open(os.path.join(self.folder, LENT), encoding="utf-8") as file:
                found = json.load(file)
            return found["pins"] if found["memory"] == memory else {}
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return {}

    def lend_nothing(self):
        if os.path.exists(os.path.join(self.folder, LENT)):
            os.unlink(os.path.join(self.folder, LENT))

    def _write_lent(self, found):
        os.makedirs(self.folder, exist_ok=True)
        replace(os.path.join(self.folder, LENT), json.dumps(found) + "\n")

    def sheets(self, rig, function):
        """Writes the page of a function to sign, as HTML and as text. Returns both paths."""
        places = self.all()
        its = [places[place.key] for place in [*rig.stages_of(function), function] if place.key in places]
        stem = os.path.join(self.folder, "commissioned_%s" % function.module)
        for ending, text in ((".html", as_html(self.machine, its)), (".txt", as_text(self.machine, its))):
            replace(stem + ending, text)
        return stem + ".html", stem + ".txt"


# For gettext: _("function"), _("stage")


def findings(rig, records):
    """What has passed and what changed since: rows of "ok", "note" or "wrong", a sentence, and a command that fixes it."""
    rows = [("wrong", doubt, "plumb commission --accept") for doubt in rig.doubts()]
    if not rig.is_required():
        return [*rows, ("note", _("Commissioning is off, as on a simulated machine: functions act at once."), "")]
    places = records.all()
    for place in [*rig.stages, *rig.functions]:
        its, name = places.get(place.key), "%s %s" % (_(place.kind), place.name)
        function = place if place.kind == "function" else rig.function_of(place)
        command = "plumb commission %s" % (function.module if function else "NAME")
        if rig.is_commissioned(place):
            rows.append(("ok", "%s: %s" % (name, passed_words(its, rig.identity(place))), ""))
            rows += [("note", "%s: %s" % (name, change), "") for change in changes(rig, place, its)[:MOST_SHOWN] if its]
        elif rig.passed(place) and its:
            rows.append(("wrong", _("{name} passed on {when}, and is held: its wiring or a sign changed since.").format(name=name, when=its["when"]), command))
            rows += [("note", "%s: %s" % (name, change), "") for change in changes(rig, place, its)[:MOST_SHOWN]]
        else:
            rows.append(("wrong", _("{name} has not passed, and is held.").format(name=name), command))
    return rows


def passed_words(its, identity):
    if not its or its["identity"] != identity:
        return _("passed by hand, with setp: no record says by whom.")
    words = _("set by hand by {who} ({user}) on {when}.") if its["by_hand"] else _("passed on {when}, signed by {who}.")
    return words.format(who=its["who"], user=its["user"], when=its["when"])


def changes(rig, place, its):
    """What differs from a record: lines of the wiring, and settings."""
    if not its:
        return []
    now, then = set(rig.wiring(place)), set(its["wiring"])
    found = [_("new: {line}").format(line=line) for line in sorted(now - then)] + [_("gone: {line}").format(line=line) for line in sorted(then - now)]
    for values, before in ((rig.settings(place), its["settings"]), (rig.scales(place), its.get("scales", {}))):
        for name in sorted(values.keys() | before.keys()):
            if values.get(name) != before.get(name):
                found.append(_("{setting} was {then} and is {now}").format(setting=name, then=_value(before.get(name)), now=_value(values.get(name))))
    for title, value, before in ((_("The loadrt line"), " ".join(rig.options(place)), " ".join(its.get("options", []))),
                                 ("LINEAR_UNITS", _unit(rig), its["unit"])):
        if value != before:
            found.append(_("{setting} was {then} and is {now}").format(setting=title, then=before or _("empty"), now=value or _("empty")))
    return found


def versions():
    found = {"Plumb": VERSION[0]}
    try:
        import linuxcnc

        found["LinuxCNC"] = linuxcnc.version
    except (ImportError, AttributeError):  # HAL may run without LinuxCNC
        pass
    return found


def _unit(rig):
    return "mm" if rig.unit == 1 else "in"


def _value(value):
    return _("its default") if value is None else number(value)


# --- the page to sign ---

def _facts(machine, its):
    last = its[-1]
    versions = ", ".join("%s %s" % pair for pair in last["versions"].items())
    facts = [(_("Machine"), machine), (_("Function"), "%s (%s)" % (last["name"], last["module"])), (_("Date"), last["when"]), (_("By"), last["who"]),
             (_("Tolerance of a reading"), "%s %s" % (number(last["tolerance"]), last["unit"])), (_("Versions"), versions)]
    if last["minutes"]:
        facts.append((_("Time"), _("{minutes} minutes").format(minutes=number(last["minutes"], 2))))
    if last["by_hand"]:
        facts.append((_("Set by hand"), _("by {who}, user {user}: nothing was measured.").format(who=last["who"], user=last["user"])))
    return facts


def _entries(its):
    """The rows of the steps, each once."""
    seen, rows = set(), []
    for record in its:
        for entry in record["log"]:
            key = (entry["when"], entry["title"], entry["sentence"])
            if key not in seen:
                seen.add(key)
                rows.append(entry)
    return sorted(rows, key=lambda entry: entry["when"])


def _untried(its):
    """What no step has shown, and what no program can see."""
    found = [text for record in its for text in record.get("untried", ())]
    return [*found, _("A parameter of a drive, an encoder, a screw: after work on them, try again.")]


def _read(entry, unit):
    return ", ".join("%s %s %s" % (name, number(value), unit) for name, value in entry["read"].items())


def as_text(machine, its):
    lines = [_("Commissioning of {name}").format(name=its[-1]["name"]), ""]
    lines += ["%-24s %s" % pair for pair in _facts(machine, its)]
    lines += ["", _("Steps"), ""]
    for entry in _entries(its):
        lines.append("%s  %-6s %s" % (entry["when"], _("passed") if not entry["fault"] else _("FAULT"), entry["title"]))
        lines += ["    " + text for text in (_read(entry, its[-1]["unit"]), entry["sentence"], entry["remedy"] if entry["fault"] else "") if text]
    lines += ["", _("Not tried"), "", *("    " + text for text in _untried(its))]
    lines += ["", _("Settings"), ""]
    for record in its:
        lines += ["%s.%s = %s" % (record["name"], short, number(value)) for short, value in sorted(record["settings"].items())]
    lines += ["", _("Wiring"), ""]
    for record in its:
        lines.append("%s, %s %d" % (record["name"], _("identity"), record["identity"]))
        lines += ["    " + line for line in record["wiring"]]
    return "\n".join(lines + ["", "", "%s ____________________    %s ____________________" % (_("Date"), _("Signature")), ""])


STYLE = """body{font:15px sans-serif;max-width:56em;margin:2em auto;color:#111}table{border-collapse:collapse;width:100%}
td,th{border:1px solid #999;padding:.3em .5em;text-align:left;vertical-align:top}.good{color:#060}.bad{color:#a00;font-weight:bold}
svg{max-width:20em;height:auto}pre{white-space:pre-wrap}.sign td{height:3em}"""


def as_html(machine, its):
    escape = html.escape
    title = escape(_("Commissioning of {name}").format(name=its[-1]["name"]))
    parts = ["<!DOCTYPE html><html><head><meta charset='utf-8'><title>%s</title><style>%s</style></head><body><h1>%s</h1><table>" % (title, STYLE, title)]
    parts += ["<tr><th>%s</th><td>%s</td></tr>" % (escape(name), escape(value)) for name, value in _facts(machine, its)]
    parts.append("</table><h2>%s</h2><table><tr><th>%s</th><th>%s</th><th>%s</th><th>%s</th></tr>" % tuple(
        escape(text) for text in (_("Steps"), _("Time"), _("Step"), _("Read"), _("Result"))))
    for entry in _entries(its):
        text = entry["sentence"] + (" " + entry["remedy"] if entry["fault"] else "")
        parts.append("<tr><td>%s</td><td>%s</td><td>%s</td><td class='%s'>%s</td></tr>" % (
            escape(entry["when"][11:]), escape(entry["title"]), escape(_read(entry, its[-1]["unit"])), "bad" if entry["fault"] else "good", escape(text)))
    parts.append("</table>")
    letters = sorted({record["name"][0].upper() for record in its if record["kind"] == "stage"})
    parts += [pictures.drawing("stage", letter) for letter in letters if letter in "XYZ"]
    parts.append("<h2>%s</h2><ul>%s</ul>" % (escape(_("Not tried")), "".join("<li>%s</li>" % escape(text) for text in _untried(its))))
    parts.append("<h2>%s</h2><table>" % escape(_("Settings")))
    for record in its:
        parts += ["<tr><td>%s.%s</td><td>%s</td></tr>" % (escape(record["name"]), escape(short), escape(number(value)))
                  for short, value in sorted(record["settings"].items())]
    parts.append("</table><h2>%s</h2><pre>" % escape(_("Wiring")))
    parts += [escape("%s, %s %d\n" % (record["name"], _("identity"), record["identity"]) + "".join("    %s\n" % line for line in record["wiring"]))
              for record in its]
    parts.append("</pre><table class='sign'><tr><td>%s</td><td>%s</td></tr></table></body></html>\n" % (escape(_("Date")), escape(_("Signature"))))
    return "".join(parts)

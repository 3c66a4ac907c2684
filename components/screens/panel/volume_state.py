# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables, circles and uncertainty of the corrected volume, as plumb volume computes them. Without a screen."""

import json
import os
import subprocess
import tempfile
import time

from panel import texts
from panel.files import replace
from panel.squareness_state import angles
from panel.texts import _

FILE = "squareness_uncertainty.json"  # beside the list of changes
PATIENCE = 20  # s
HEAD = 4096  # bytes, of a file that may be a path of a ballbar


class Lacks(RuntimeError):
    """The reason why nothing can be computed."""


def tables(ini):
    """The files of error tables that squareness was started with."""
    value = ini.get("SQUARENESS", "TABLE", "none")
    return [] if value == "none" else value.split(":")


def assumed(ini):
    """Classes and sheets that state errors which nobody measured: [SQUARENESS]ASSUME, as sheet.csv:iso-10791."""
    return [source if source == "iso-10791" else os.path.join(ini.folder, source) for source in ini.get("SQUARENESS", "ASSUME").split(":") if source]


def box(ini):
    """The work space as plumb volume takes it, in mm. Raises Lacks."""
    unit = 25.4 if ini.get("TRAJ", "LINEAR_UNITS").lower().startswith("in") else 1.0
    sides = []
    for axis in "XYZ":
        try:
            low, high = (float(ini.get("AXIS_" + axis, name)) * unit for name in ("MIN_LIMIT", "MAX_LIMIT"))
        except ValueError:
            raise Lacks(_("The INI file has no limits of {axis}: [AXIS_{axis}]MIN_LIMIT and MAX_LIMIT.").format(axis=axis)) from None
        sides.append("%s=%r:%r" % (axis, low, high))
    return ",".join(sides)


def kept_uncertainty(folder):
    """{"angles": {name: {"angle", "date"}}, "causes": [{name: standard deviation in rad}]}: one cause may have set several angles."""
    try:
        with open(os.path.join(folder, FILE), encoding="ascii") as file:
            kept = json.load(file)
        angles_of_then = {name: {"angle": float(its["angle"]), "date": str(its["date"]), "by": str(its.get("by", ""))} for name, its in kept["angles"].items()}
        return {"angles": angles_of_then, "causes": [{name: float(factor) for name, factor in cause.items()} for cause in kept["causes"] if cause]}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):  # none, or cut off
        return {"angles": {}, "causes": []}


def instruments(result):
    """The methods of the measurements in an output of plumb squareness, as "square, opening"."""
    return ", ".join(dict.fromkeys(its["by"] for its in result.get("input", {}).get("measurements", ())))


def keep_uncertainty(folder, result):
    """Writes how sure the measured angles of an output of plumb squareness are, beside those of before. Raises OSError."""
    kept, new = kept_uncertainty(folder), [cause for cause in result["deviations"] if cause]
    measured = set().union(*new)
    former = [{name: factor for name, factor in cause.items() if name not in measured} for cause in kept["causes"]]
    angles_of_now = {its["name"]: {"angle": its["angle"], "date": time.strftime("%Y-%m-%d"), "by": instruments(result)} for its in result["settled"] if its["name"] in measured}
    content = {"angles": {**kept["angles"], **angles_of_now}, "causes": [cause for cause in former if cause] + new}
    replace(os.path.join(folder, FILE), json.dumps(content, indent=1))


def of_angles(folder, instance, values):
    """The options of plumb volume for the angles in force. An angle that another way has set has no uncertainty."""
    kept, options, known = kept_uncertainty(folder), [], set()
    for short, angle in angles(instance, values).items():
        name = short.upper()
        measured = kept["angles"].get(name)
        if measured and abs(measured["angle"] - angle) < 1e-9:
            known.add(name)
            options += ["--tilt", "%s=%rrad,u=0rad,date=%s,by=%s" % (name, float(angle), measured["date"], measured["by"].replace(",", " and"))]
        elif angle:
            options += ["--tilt", "%s=%rrad" % (name, float(angle))]
    for number, cause in enumerate(kept["causes"], 1):
        largest = max(map(abs, cause.values()))
        its = ["%s=%r" % (name, factor / largest) for name, factor in cause.items() if name in known]
        if its:
            name = next(iter(cause)) if len(cause) == 1 else _("measurement {number}").format(number=number)
            options += ["--common", ",".join([name, *its, "u=%rrad" % largest])]
    return options


def pivots(instance, values):
    unit = 25.4 if texts.MACHINE_UNIT[0] == "in" else 1.0
    found = {axis.upper(): float(instance.value(values, axis + "-pivot")) * unit for axis in "xyzuvw" if axis + "-pivot" in instance.pins}
    return [word for axis, value in found.items() if value for word in ("--pivot", "%s=%r" % (axis, value))]


def tool(instance, values):
    """The tool in force, from the gauge point to its tip, in mm."""
    unit = 25.4 if texts.MACHINE_UNIT[0] == "in" else 1.0
    lengths = [-float(instance.value(values, axis + "-tool-offset", 0.0)) * unit for axis in "xyz"]
    return ["--tool", "%s=%s" % (_("the tool in force"), ",".join("%r" % (length + 0.0) for length in lengths))]


def arguments(ini, chain, folder, instance, values):
    """Of plumb volume uncertainty. Raises Lacks."""
    found = tables(ini)
    if instance.value(values, "tables", 0) and not found:
        raise Lacks(_("[SQUARENESS]TABLE of the INI file does not name the tables in use."))
    return ["uncertainty", "--json", "--chain", chain, "--box", box(ini), *tool(instance, values), *of_angles(folder, instance, values), *pivots(instance, values),
            *[word for file in found for word in ("--table", file)], *[word for source in assumed(ini) for word in ("--assume", source)]]


def temperature(growths, values):
    """The temperature of the machine now, by the first valid sensor of axis_growth; nothing without one."""
    for growth in growths:
        for sensor in range(8):
            now = growth.value(values, "temperature-%d" % sensor)
            if now is not None and growth.value(values, "temperature-valid-%d" % sensor, False):
                return ["--temperature", "%rdegC" % float(now)]
    return []


def corners(places):
    """The places at both ends of each axis, for the first tool."""
    ends = [{least, most} for least, most in ((min(values), max(values)) for values in zip(*(its["at"] for its in places)))]
    return [its for its in places if its["tool"] == places[0]["tool"] and all(at in end for at, end in zip(its["at"], ends))]


# By their kind in the output. For gettext: _("The measurement of {of} is {first} days old, and valid for {second}: measure again.")
NOTES = {
    "old": "The measurement of {of} is {first} days old, and valid for {second}: measure again.",
    "age-unknown": "The age of the measurement of {of} is not known; it counts as {first} days.",  # for gettext: _("The age of the measurement of {of} is not known; it counts as {first} days.")
    "table-ends": "The table of {of} ends at {first} and {second} mm, within the work space: beyond, nothing was measured.",  # for gettext: _("The table of {of} ends at {first} and {second} mm, within the work space: beyond, nothing was measured.")
    "rotary": "The rotary axes stand at 0: {of}. Their errors, and other angles, are not in U.",  # for gettext: _("The rotary axes stand at 0: {of}. Their errors, and other angles, are not in U.")
}


# By the kind of an error in the list of plumb volume: its name.
KINDS = {
    "corner": "corner {axes}",  # for gettext: _("corner {axes}")
    "lost-motion": "lost motion {axes}",  # for gettext: _("lost motion {axes}")
    "repeatability": "repeatability {axes}",  # for gettext: _("repeatability {axes}")
    "second-axis": "an axis that bends another one",  # for gettext: _("an axis that bends another one")
    "growth": "growth by temperature",  # for gettext: _("growth by temperature")
    "bending": "bending by temperature",  # for gettext: _("bending by temperature")
    "drift": "drift of {axes}",  # for gettext: _("drift of {axes}")
}


def errors_in_words(errors):
    """The list of errors: (name, figure, source or how to measure) of each; errors that differ in the name alone are one. plumb volume
    says how an error is measured."""
    found = []
    for its in errors:
        last = its["name"].split()[-1]
        key = tuple(its[word] for word in ("kind", "state", "u", "unit", "by", "how"))
        if found and found[-1][0] == key:
            found[-1][1].append(last)
        else:
            found.append((key, [last]))
    rows = []
    for (kind, state, u, unit, by, how), names in found:
        name = _(KINDS.get(kind, "{axes}")).format(axes=" ".join(names))
        figure = _("unknown") if u is None else "%s %s" % (texts.number(float("%.3g" % (u * (1e3 if unit == "mm" else 1e6)))), {"mm": "\u00b5m", "rad": "\u00b5rad", "1": "\u00b5m/m"}[unit])
        words = {"unknown": _("{by}; measure: {how}") if by else _("measure: {how}"), "assumed": _("assumed: {by}"), "measured": _("measured: {by}")}[state]
        rows.append((name, figure, words.format(how=_(how), by=by)))
    return rows


def note_in_words(note):
    return _(NOTES[note["kind"]]).format(of=cause_in_words(note["of"]), first=texts.number(float(note["first"])), second=texts.number(float(note["second"])))


def cause_in_words(cause):
    """EXX, all rows together; drift EXX; lost motion X; second axis; growth; bending; repeatability."""
    together = ", all rows together"
    if cause.endswith(together):
        return _("{error}, all rows together").format(error=cause[:-len(together)])
    for words, kind in (("drift", "drift"), ("lost motion", "lost-motion"), ("repeatability", "repeatability"), ("second axis", "second-axis"), ("growth", "growth"), ("bending", "bending")):
        if cause.startswith(words):
            return _(KINDS[kind]).format(axes=cause[len(words):].strip()).strip()
    return cause


def circles(folder):
    """The newest files of a ballbar beside the INI file: {"off": [files], "on": [files]}, one for each direction."""
    found = {}
    for name in sorted(os.listdir(folder or ".")):
        path = os.path.join(folder, name)
        if not name.endswith(".csv") or not os.path.isfile(path):
            continue
        with open(path, encoding="utf-8", errors="replace") as file:
            head = dict(line[1:].strip().partition(":")[::2] for line in file.read(HEAD).splitlines() if line.startswith("#") and ":" in line)
        head = {key.strip(): value.strip() for key, value in head.items()}
        if head.get("direction") in ("CW", "CCW") and head.get("correction") in ("on", "off"):
            place = head["correction"], head["direction"]
            if place not in found or os.path.getmtime(path) > os.path.getmtime(found[place]):
                found[place] = path
    return {state: [found[state, way] for way in ("CCW", "CW") if (state, way) in found] for state in ("off", "on")}


class Question:
    """A call of plumb volume beside the screen: done() is False until answer() has the output or raises Lacks."""

    def __init__(self, program, given):
        self._output, self._errors, self._until = tempfile.TemporaryFile("w+"), tempfile.TemporaryFile("w+"), time.monotonic() + PATIENCE
        try:
            self._process = subprocess.Popen([program, *given], stdin=subprocess.DEVNULL, stdout=self._output, stderr=self._errors,
                                             env={**os.environ, "LC_ALL": "C.UTF-8"})
        except OSError as error:
            self._close()
            raise Lacks(str(error)) from None

    def _close(self):
        self._output.close()
        self._errors.close()

    def done(self):
        if self._process.poll() is None and time.monotonic() > self._until:
            self._process.kill()
            self._process.wait()
        return self._process.poll() is not None

    def answer(self):
        self._output.seek(0)
        self._errors.seek(0)
        output, lines = self._output.read(), self._errors.read().strip().splitlines()
        self._close()
        if self._process.returncode:
            raise Lacks(lines[0] if lines else "status %d" % self._process.returncode)
        return json.loads(output)

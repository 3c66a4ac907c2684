# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb squareness, which computes all that the page of squareness shows, by one document in and out. Without a screen."""

import copy
import json
import os
import subprocess

from panel import squareness_refusals, texts
from panel.squareness_state import angles
from panel.texts import _

PATIENCE = 20  # s

CHAINS = (
    ("w-X-Y.b-Z-C-t", "Table in X and Y, head in Z"),  # for gettext: _("Table in X and Y, head in Z")
    ("w-X.b-Y-Z-C-t", "Table in X, spindle in Y and Z"),  # for gettext: _("Table in X, spindle in Y and Z")
    ("w-Y.b-X-Z-C-t", "Table in Y, spindle in X and Z"),  # for gettext: _("Table in Y, spindle in X and Z")
    ("b-X-Y-Z-C-t", "Gantry: all axes carry the spindle"),  # for gettext: _("Gantry: all axes carry the spindle")
    ("w-Z.b-X-Y-C-t", "Table in Z, column in X and Y"),  # for gettext: _("Table in Z, column in X and Y")
    ("w-X.b-W-Y-Z-C-t", "Portal with cross rail W"),  # for gettext: _("Portal with cross rail W")
)

UNITS = ("mm/300mm", "um/m", "arcsec", "deg", "in/ft")


class Refused(RuntimeError):
    """The program's reason."""


def document(chain, instance, values):
    """The machine as it is: its chain, its readings of a tilt, and the angles in force that the chain can have."""
    axes = axes_of(chain)
    return {
        "chain": chain,
        "unit": "inch" if texts.MACHINE_UNIT[0] == "in" else "mm",
        "reading": "axis-direction" if instance.value(values, "axis-direction") else "component",
        "against": "bed" if instance.value(values, "to-bed") else "rail",
        "correction": "on",
        "leans": [],
        "in_force": [{"name": short.upper(), "angle": "%rrad" % float(angle)} for short, angle in angles(instance, values).items()
                     if angle and short[3].upper() in axes],
        "measurements": [],
    }


def run(given, program):
    """The whole output for a document. Raises Refused."""
    return _run([program, "--json", "--input", "-"], given)


def _run(command, given):
    try:
        done = subprocess.run(command, input=json.dumps(given), capture_output=True, text=True,
                              timeout=PATIENCE, check=False, env={**os.environ, "LC_ALL": "C.UTF-8"})
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Refused(str(error)) from None
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        raise Refused(squareness_refusals.in_words(lines[0]) if lines else "status %d" % done.returncode)
    return json.loads(done.stdout)


def corrections(chain, rotary, states, program):
    """The corrections by the letters of their axes, for each of several states of the inputs by their short names. Raises Refused."""
    return _run([program, "--corrections", "--input", "-"], {"chain": chain, "rotary": rotary, "states": states})["corrections"]


def with_lean(given, axis, direction, angle):
    """A copy with the lean of an axis, such as "0.02mm/300mm", in the place of one along the same line; '' takes it away."""
    found = copy.deepcopy(given)
    names = [axis + sign + direction[1] for sign in "+-"]
    found["leans"] = [lean for lean in found["leans"] if lean["lean"] not in names]
    if angle:
        found["leans"].append({"lean": axis + direction, "angle": angle})
    return found


def with_measurement(given, measurement):
    found = copy.deepcopy(given)
    found["measurements"].append(measurement)
    return found


def settings(result):
    """The pins and values of the angles that were measured: no other angle changes."""
    measured = {quantity["name"].lower() for quantity in result["quantities"]}
    return [(each["pin"], each["value"]) for each in result["settings"] if each["pin"] in measured]


def why_not(lean):
    """Why a lean alone corrects nothing."""
    base = lean["directions"][0][1]
    return _("{axis} turns all that it carries with it: the angles between the axes stay, and a correction moves no axis. If a square of "
             "{axis} and {base} showed a lean, give its readings: Square and indicator.").format(axis=lean["axis"], base=base)


def before_and_after(state):
    """A lean or a corner of the output in words, over a length of 1 m."""
    before = texts.in_micrometres(1000.0 * state["before"], "mm") if texts.MACHINE_UNIT[0] == "mm" else texts.number(state["before"] * 1e6, 3) + " \u00b5in/in"
    spread = state["settled"]["U"] if "settled" in state else state["U"]
    if spread is None:
        after = _("0 \u00b5m if the given angle is right")
    else:
        after = _("0 \u00b1{spread} \u00b5m (k=2)").format(spread=texts.number(float("%.2g" % (spread * 1e6))))
    return _("over 1 m before: {before}, after: {after}, straightness not included").format(before=before, after=after)


def axes_of(chain):
    return [letter for letter in chain if letter in "XYZUVW"]


def directions(axis):
    """To which an axis can lean."""
    own = {"U": "X", "V": "Y", "W": "Z"}.get(axis, axis)
    return [sign + letter for letter in "XYZ" if letter != own for sign in "+-"]


def square(moved, plunger, first, last, rise, uncertainty):
    """A square and an indicator: positions in mm, the reading at the last one in um."""
    return {"by": "square", "move": moved, "plunger": plunger, "at": "%s:%smm" % (first, last), "reads": "0:%sum" % rise, "u": "%sum" % uncertainty}


def diagonals(plane, rising, falling, uncertainty):
    return {"by": "diagonals", "plane": plane, "object": "part", "rising": "%smm" % rising, "falling": "%smm" % falling, "u": "%sum" % uncertainty}


def points(path, uncertainty):
    return {"by": "points", "file": path, "object": "artifact", "u": "%sum" % uncertainty}

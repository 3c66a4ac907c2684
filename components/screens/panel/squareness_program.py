# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb squareness, which computes all that the page of squareness shows. Without a screen."""

import json
import os
import subprocess

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


def run(chain, arguments, program):
    """The result for a chain and arguments such as ["--lean", "Y+X=0.02mm/300mm"]. Raises Refused."""
    try:
        done = subprocess.run([program, "--json", "--chain", chain, *arguments], capture_output=True, text=True,
                              timeout=PATIENCE, check=False, env={**os.environ, "LC_ALL": "C.UTF-8"})
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Refused(str(error)) from None
    if done.returncode:
        raise Refused(done.stderr.strip().splitlines()[0] if done.stderr.strip() else "status %d" % done.returncode)
    return json.loads(done.stdout)


def in_force(instance, values):
    """The arguments for the angles that are in force now."""
    found = []
    for short in instance.pins:
        if len(short) == 4 and short[0] == "e" and short[2] == "0" and values.get(instance.full(short)):
            found += ["--in-force", "%s=%rrad" % (short.upper(), float(values[instance.full(short)]))]
    return found


def axes_of(chain):
    return [letter for letter in chain if letter in "XYZUVW"]


def directions(axis):
    """To which an axis can lean."""
    own = {"U": "X", "V": "Y", "W": "Z"}.get(axis, axis)
    return [sign + letter for letter in "XYZ" if letter != own for sign in "+-"]


def lean(axis, direction, angle, unit):
    """Angle 0.02 in mm/300mm is 0.02mm/300mm."""
    return ["--lean", "%s%s=%s" % (axis, direction, with_unit(angle, unit))]


def with_unit(angle, unit):
    return angle + unit


def square(moved, plunger, first, last, rise, uncertainty):
    """A square and an indicator: positions in mm, the reading at the last one in um."""
    return ["--square", "move=%s,plunger=%s,at=%s:%smm,reads=0:%sum,u=%sum" % (moved, plunger, first, last, rise, uncertainty)]


def diagonals(plane, rising, falling, uncertainty):
    return ["--diagonals", "plane=%s,object=part,rising=%smm,falling=%smm,u=%sum" % (plane, rising, falling, uncertainty)]


def points(path, uncertainty):
    return ["--points", "file=%s,object=artifact,u=%sum" % (path, uncertainty)]

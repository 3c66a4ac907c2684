# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of chopping on a copy: Z strokes between two dead points, and returns without an offset."""

STROKE = 5  # mm
FEED = 20  # mm/s
TOLERANCE = 0.02  # mm
PATIENCE = 30  # s


def check(machinery):
    begin = machinery.inside("Z")
    machinery.move(Z=begin)
    machinery.set("chop.without-wheel", 1)  # a copy has no spindle
    lower, upper = sorted((begin, machinery.room("Z", STROKE)))
    following = [0]  # errors of the drive, in mm
    seen = [stroke(machinery, begin, lower, upper, *each, following) for each in (("G21", 1), ("G20", 25.4))]
    left = machinery.get("chop.offset") / machinery.unit
    faults = [name for name in ("z-stage", "interlock") if machinery.get(name + ".fault")]
    return [
        *seen,
        (follows(machinery, max(following)), True),
        ("stopped, it is back within %.6f mm" % abs(left), abs(left) < 1e-6),
        ("no fault", not machinery.get("chop.fault") and not faults),
    ]


def follows(machinery, error):
    """A statement on the following error of the strokes; a pid that works is wired, and its fault is named."""
    text = "the drive follows the strokes within %.4f mm" % error
    lacking = machinery.lacking_velocity("Z")
    if lacking:
        text += "; %s lacks the velocity of the stroke: net z-stage.drive-velocity to it" % " and ".join(lacking)
    return text


def stroke(machinery, begin, lower, upper, word, unit, following):
    """A statement on a stroke that a program in mm or inches commands from point R, and whether it holds."""
    machine, program = machinery.machine, machinery.unit * unit  # machine units of a unit of the program
    length = upper - lower
    machine.mdi(word)
    words = (upper / program, -length / program, (begin - upper) / program, 60 * FEED / unit)
    machine.mdi("G81.1 Z[%.6f - #<_abs_z> + #<_z>] Q%.6f R%.6f P%.6f" % words)
    waited, joint = 0, machinery.axes["Z"]["joints"][0]
    while machinery.get("chop.stroke-count") < 4 and not machinery.get("chop.fault") and waited < PATIENCE:
        machine.wait(0.05)
        waited += 0.05
        following.append(abs(machinery.get("joint.%d.f-error" % joint)) / machinery.unit)
    strokes = machinery.get("chop.stroke-count")
    ends = [machinery.get("chop.upper") - upper, machinery.get("chop.lower") - lower]
    off = [machinery.get("chop.upper-error"), machinery.get("chop.lower-error"), *ends]
    off = max(abs(each) / machinery.unit for each in off)
    machine.mdi("G80.1")
    text = "%s G81.1: Z strokes by %.4g %s, %d strokes, its dead points off by at most %.3f mm"
    unit_name = "mm" if machinery.unit == 1 else "in"
    return text % (word, length, unit_name, strokes, off), strokes >= 4 and off < TOLERANCE

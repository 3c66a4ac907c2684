# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of chopping on a copy: Z strokes between two dead points, and returns without an offset."""

STROKE = 5  # mm
FEED = 20  # mm/s
TOLERANCE = 0.02  # mm
PATIENCE = 30  # s


def check(machinery):
    unit, machine = machinery.unit, machinery.machine
    begin = machinery.inside("Z")
    machinery.move(Z=begin)
    lower, upper = sorted((begin, machinery.room("Z", STROKE)))
    for number, value in ((16, upper), (17, lower), (18, FEED * unit)):
        machine.mdi("M68 E%d Q%.6f" % (number, value))
    machine.mdi("M64 P16")
    waited = 0
    while machinery.get("chop.stroke-count") < 4 and not machinery.get("chop.fault") and waited < PATIENCE:
        machine.wait(0.5)
        waited += 0.5
    strokes, fault = machinery.get("chop.stroke-count"), machinery.get("chop.fault-code")
    off = [machinery.get("chop.upper-error") / unit, machinery.get("chop.lower-error") / unit]
    machine.mdi("M65 P16")
    machine.wait(5)
    left = machinery.get("chop.offset") / unit
    faults = [name for name in ("z-stage", "interlock") if machinery.get(name + ".fault")]
    length = "mm" if unit == 1 else "in"
    return [
        (
            "Z strokes by %.4g %s: %d strokes, its dead points off by %.3f and %.3f mm"
            % (upper - lower, length, strokes, *off),
            strokes >= 4 and max(map(abs, off)) < TOLERANCE,
        ),
        ("stopped, it is back within %.6f mm" % abs(left), abs(left) < 1e-6),
        ("no fault", not fault and not faults),
    ]

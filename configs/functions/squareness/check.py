# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of squareness on a copy: a tilt that is set moves the drive of the other axis."""

TILT = 2e-4  # rad
LENGTH = 50  # mm
TOLERANCE = 2e-3  # of the correction

# The axis that leans, the one that is corrected, and the tilt: for an axis that carries the tool.
LEANS = (
    ("Z", "X", "eb0z"),
    ("Z", "Y", "ea0z"),
    ("Y", "X", "ec0y"),
    ("X", "Y", "ec0x"),
    ("X", "Z", "eb0x"),
    ("Y", "Z", "ea0y"),
)


def check(machinery):
    micrometre = 1e-3 * machinery.unit
    carries_tool = machinery.ini("SQUARENESS", "CHAIN").partition(".b")[2].upper()
    possible = [lean for lean in LEANS if {lean[0], lean[1]} <= set(machinery.axes) and lean[0] in carries_tool]
    if not possible:
        return [("no fault; all axes carry the work, so that no single tilt is tried", not machinery.get("square.fault"))]
    moving, corrected, tilt = possible[0]
    joint = machinery.axes[corrected]["joints"][0]
    begin = machinery.inside(moving)
    machinery.move(**{moving: begin})
    end = machinery.room(moving, LENGTH)
    before = machinery.get("square." + tilt)

    def offset():
        machinery.machine.wait(1)
        return machinery.get(corrected.lower() + "-motor-cmd") - machinery.get("joint.%d.motor-pos-cmd" % joint)

    without = offset()
    machinery.set("square." + tilt, before + TILT)
    at_begin = offset()
    machinery.move(**{moving: end})
    at_end = offset()
    following = abs(machinery.get("joint.%d.f-error" % joint))
    fault = any(machinery.get(name + ".fault") for name in ("square", corrected.lower() + "-stage", "interlock"))
    machinery.set("square." + tilt, before)
    machinery.move(**{moving: begin})
    left = abs(offset() - without)
    expected, seen = TILT * abs(end - begin), abs(at_end - at_begin)
    if before:  # a tilt of the machine's own adds to it
        expected = abs(before + TILT) * abs(end - begin)
    length = "mm" if machinery.unit == 1 else "in"
    return [
        (
            "as %s travels %.4g %s, a tilt of %g um/m moves the drive of %s by %.3f um, of %.3f um"
            % (moving, abs(end - begin), length, TILT * 1e6, corrected, seen / micrometre, expected / micrometre),
            abs(seen - expected) < TOLERANCE * expected + 0.01 * micrometre,
        ),
        ("the following error is %.3f um" % (following / micrometre), following < 10 * micrometre),
        ("without the tilt the drive is back within %.3f um" % (left / micrometre), left < 0.01 * micrometre),
        ("no fault", not fault),
    ]

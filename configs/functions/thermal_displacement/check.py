# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of thermal_displacement on a copy: growth that a simulated load shows raises the axis Z."""

import os

GROWTH = 0.012  # mm
STEPS = 4  # in which it comes, one a cycle: at once it may be a shift
TOLERANCE = 0.005  # mm
PLUNGES = 3
MORE_CYCLES = 8
LONGEST = 300  # s, for a cycle
FEED = 60  # mm/min
APPROACH = 1.2  # mm above the work, in which the tool feeds
TIMED = 1.0  # mm of it, in which the clock of by-time runs
DEPTH = 0.7  # mm

CYCLE = """G90 G94 G49 G64
M64 P4
M66 P4 L3 Q30
o<cycle_start> call
S1000 M3
G4 P4
M68 E0 Q10
%s
M68 E0 Q0
M5
o<cycle_end> call
M2
"""


def check(machinery):
    mm = machinery.unit
    begin = machinery.inside("Z")
    safe = begin - (begin - machinery.room("Z", 8)) / 4
    work = min(safe, begin) - APPROACH * mm
    low = machinery.axes["Z"]["limits"][0]
    if work - DEPTH * mm < low:  # home is at the bottom
        safe = begin + (APPROACH + DEPTH + 1) * mm
        work = safe - APPROACH * mm
    plunge = "G53 G0 Z%.5f\no<growth_clock> call [%.5f]\nG53 G1 Z%.5f F%g\nG4 P0.3\nG53 G0 Z%.5f" % (
        work + APPROACH * mm,
        (APPROACH - TIMED) * mm,
        work - DEPTH * mm,
        FEED * mm,
        safe,
    )
    program = os.path.join(machinery.folder, "cycle.ngc")
    with open(program, "w", encoding="ascii") as file:
        file.write(("G21\n" if mm == 1 else "G20\n") + machinery.numbered(CYCLE) % "\n".join([plunge] * PLUNGES))

    machinery.set("growth.dry-run", False)
    machinery.set("growth.follow-speed", False)  # it does not grow by its speed
    machinery.set("growth.max-growth-rate", 0.002 * mm)  # a cycle of the trial takes seconds
    grow(machinery, work, 0)
    machinery.machine.mdi(machinery.numbered("M64 P2"))
    machinery.machine.run(program, LONGEST)
    learnt = machinery.get("growth.rows")
    seen = [("the first cycle learns %d contacts of %d" % (learnt, PLUNGES), learnt == PLUNGES)]
    before = machinery.get("growth.contacts-accepted")
    for step in range(STEPS):
        grow(machinery, work, (step + 1) * GROWTH / STEPS * mm)
        machinery.machine.run(program, LONGEST)
    accepted = machinery.get("growth.contacts-accepted") - before
    displacement = machinery.get("growth.displacement") / mm
    cycles, offset = 0, 0
    while cycles < MORE_CYCLES and not rises(offset):  # authority grows with each contact
        machinery.machine.run(program, LONGEST)
        cycles, offset = cycles + 1, machinery.get("axis.z.eoffset") / mm
    follows = abs(offset - machinery.get("growth.z-offset") / mm)
    time, marked = machinery.get("growth.contact-time"), machinery.get("growth.clock-start")
    faults = [name for name in ("growth", "z-axis-stage", "interlock") if machinery.get(name + ".fault")]
    return seen + [
        ("%d contacts of the next %d cycles are compared" % (accepted, STEPS), accepted >= 2 * STEPS),
        (
            "a spindle that is %.0f um longer is measured as %.1f um" % (GROWTH * 1e3, displacement * 1e3),
            abs(displacement - GROWTH) < TOLERANCE,
        ),
        ("after cycle %d Z is raised by %.1f um" % (1 + STEPS + cycles, offset * 1e3), rises(offset) and follows < 1e-3),
        (
            "the clock of by-time shows %.2f s for %.2f s%s" % (time, TIMED / FEED * 60, "" if marked else ", and has no mark"),
            abs(time - TIMED / FEED * 60) < 0.05 and marked,
        ),
        ("no fault" if not faults else "fault of " + ", ".join(faults), not faults),
    ]


def rises(offset):
    return 0.4 * GROWTH < offset < GROWTH + TOLERANCE


def grow(machinery, work, growth):
    """The tool meets the work while Z is higher by this growth."""
    joint = "joint.%d." % machinery.axes["Z"]["joints"][0]
    height = work + growth + machinery.get(joint + "motor-pos-fb") - machinery.get(joint + "pos-fb")
    machinery.set("check-cut.x-val-00", height - 1e-6)
    machinery.set("check-cut.x-val-01", height)

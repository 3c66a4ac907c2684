# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of centre_height on a copy: two lands that are entered give the height of a tool that is off centre, and a check is asked for."""

HEIGHT, RADIUS, STEP = 0.05, 5, 1  # mm


def check(machinery):
    get, put, unit = machinery.get, machinery.set, machinery.unit
    settings = {"centre.keyed": True, "centre.method": 1, "centre.cuts": 2, "centre.clearance-angle": 0, "centre.max-sigma": 0.1 * unit, "centre.largest-burr": 0}
    for index, y in enumerate((STEP, -STEP)):
        settings["centre.cut-diameter-%d" % index] = 2 * (RADIUS**2 + (y + HEIGHT) ** 2) ** 0.5 * unit
        settings["centre.cut-x-%d" % index] = RADIUS * unit
        settings["centre.cut-y-%d" % index] = y * unit
    before = {name: get(name) for name in [*settings, "centre.x-is-radius"]}
    put("centre.x-is-radius", False)
    for name, value in settings.items():
        put(name, value)
    for value in (False, True):
        put("centre.compute", value)
        machinery.machine.wait(0.1)
    names = ("height", "y-move", "move-allowed", "fault", "check-due")
    height, move, allowed, fault, check_due = (get("centre." + name) for name in names)
    put("centre.compute", False)
    for name, value in before.items():
        put(name, value)
    if "Y" in machinery.axes:
        moves = "after a check, Y may move by %.3f um"
    else:
        moves = "after a check, a shim raises the tool by %.3f um"
    return [
        ("two lands of a tool that is %g um high give %.3f um" % (1e3 * HEIGHT, 1e3 * height / unit), abs(height - HEIGHT * unit) < 1e-6 * unit),
        (moves % (1e3 * move / unit), check_due and not allowed and abs(move + HEIGHT * unit) < 1e-6 * unit),
        ("no fault", not fault),
    ]

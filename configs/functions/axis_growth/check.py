# SPDX-License-Identifier: GPL-2.0-or-later
"""The trial of axis_growth on a copy: an axis that grows with the spindle speed moves its drive."""

GROWTH = 0.02  # mm, of each axis
SPEED = 100  # rpm


def check(machinery):
    unit = machinery.unit
    letters = [letter for letter in "XYZ" if letter in machinery.axes]
    sensors = range(int(machinery.ini("AXIS_GROWTH", "SENSORS")))
    terms = ["%s-%s-%d" % (axis, term, sensor) for axis in "xyz" for term in ("growth", "slope") for sensor in sensors]
    settings = {"axis-growth." + term: 0 for term in terms}  # a sensor may not be here
    settings.update({"axis-growth.%s-speed-growth" % axis: GROWTH * unit for axis in "xyz"})
    settings.update({"axis-growth.%s-sigma" % axis: 0.001 * unit for axis in "xyz"})
    settings.update({"axis-growth.reference-speed": SPEED, "axis-growth.turning-time": 1, "axis-growth.stopped-time": 1})
    settings["axis-growth.max-rate"] = 0.05 * unit
    before = {name: machinery.get(name) for name in settings}

    def offsets():
        return [
            machinery.get(letter.lower() + "-motor-cmd") - machinery.get("joint.%d.motor-pos-cmd" % machinery.axes[letter]["joints"][0])
            for letter in letters
        ]

    without = offsets()
    for name, value in settings.items():
        machinery.set(name, value)
    machinery.machine.mdi("M3 S%d" % SPEED)
    machinery.machine.wait(12)
    speed = abs(machinery.get("spindle-speed-cmd"))
    moved = [after - first for after, first in zip(offsets(), without)]
    fault = machinery.get("axis-growth.fault")
    machinery.machine.mdi("M5")
    for name, value in before.items():
        if name != "axis-growth.max-rate":
            machinery.set(name, value)
    machinery.machine.wait(3)
    machinery.set("axis-growth.max-rate", before["axis-growth.max-rate"])
    left = max(abs(after - first) for after, first in zip(offsets(), without))
    expected = GROWTH * unit * (speed / SPEED) ** machinery.get("axis-growth.speed-exponent")
    error = max(abs(way - expected) for way in moved)
    return [
        (
            "a growth of %.3f um moves the drives of %s by %.3f um"
            % (1e3 * expected / unit, ", ".join(letters), 1e3 * moved[0] / unit),
            expected > 0 and error < 1e-4 * unit,
        ),
        ("without it the drives are back within %.3f um" % (1e3 * left / unit), left < 1e-4 * unit),
        ("no fault", not fault),
    ]

# SPDX-License-Identifier: GPL-2.0-or-later
"""The user's machine, as wiring needs it."""

import re

import hal_text

INCH = 25.4  # mm
MOTION = "motion-controller"
STEPGEN = {  # keys of the drive's own limits, as PnCconf and StepConf spell them, and as Mesa's configuration tool does
    "VELOCITY": ("STEPGEN_MAXVEL", "STEPGEN_MAX_VEL"),
    "ACCELERATION": ("STEPGEN_MAXACCEL", "STEPGEN_MAX_ACC"),
}


class Machine:
    """The HAL of a configuration, and its joints.

    halfiles    State after the HALFILEs, behind which ours comes
    complete    State with all that comes later: HALCMD lines, files of the screen
    joints      the numbers of the joints of each axis, by its letter
    ini         IniFile
    files       its HAL files, to name lines
    """

    def __init__(self, halfiles, complete, joints, ini, files):
        self.halfiles, self.complete, self.joints, self.ini, self.files = halfiles, complete, joints, ini, files
        self.twopass = bool(ini.get("HAL", "TWOPASS"))
        self.inch = is_inch(ini.get("TRAJ", "LINEAR_UNITS"))
        self.unit = 1 / INCH if self.inch else 1  # machine units in a millimetre
        self.axes = {
            letter: {"joints": numbers, "limits": self._travel(letter, numbers)} for letter, numbers in joints.items()
        }
        self.thread = halfiles.thread_with(MOTION)

    def at(self, *names):
        """' (FILE:LINE)' of the first of these names that the HAL files have."""
        for name in names:
            found = name and hal_text.where(name, self.files)
            if found:
                return " (%s)" % found
        return ""

    def output_keys(self):
        """(section, name) of the INI values that give motmod its options num_dio and num_aio, by the option."""
        keys = {}
        for option in ("num_dio", "num_aio"):
            for _place, line in hal_text.lines_with(option, self.files):
                found = re.search(r"\b%s=%s" % (option, hal_text.VALUE.pattern), line)
                if found:
                    keys[option] = found[1], found[2] or found[3]
        return keys

    def can_have_more_outputs(self):
        """Whether the line that loads motmod takes its options from the INI file."""
        from_ini = self.ini.get("EMCMOT", "EMCMOT") and self.at("[EMCMOT]EMCMOT", "[EMCMOT](EMCMOT)")
        keys = self.output_keys()
        return bool(from_ini and not any(self.at(option) and option not in keys for option in ("num_aio", "num_dio")))

    def in_use(self, pin):
        """The user's signal that joins this pin to another one, or None."""
        name = self.complete.signal_of(pin)
        signal = self.complete.signals.get(name)
        return name if signal and any(end and end != pin for end in [signal.writer, *signal.readers]) else None

    def loads(self, module):
        """Whether its HAL files load the module so that no other line can. TWOPASS joins the lines."""
        return module in self.halfiles.components and not self.twopass

    def _travel(self, letter, joints):
        """The limits of an axis: its own, or the limits of its joint."""
        return [
            self.ini.number("AXIS_" + letter, name, self.number(joints[0], name, default))
            for name, default in (("MIN_LIMIT", -100), ("MAX_LIMIT", 100))
        ]

    def limits(self, joint):
        """The limits of a joint, as text for setp: the INI values by name, where they are given."""
        section = "JOINT_%d" % joint
        return [
            "[%s]%s" % (section, name) if self.ini.get(section, name) else value
            for name, value in (("MIN_LIMIT", "-1e6"), ("MAX_LIMIT", "1e6"))
        ]

    def number(self, joint, name, default=1):
        """A number of the section of a joint; without one LinuxCNC's default."""
        return self.ini.number("JOINT_%d" % joint, name, default)

    def named(self, joint, name, default):
        """The word for setp: the INI value by name, where it is given."""
        section = "JOINT_%d" % joint
        return "[%s]%s" % (section, name) if self.ini.get(section, name) else "%g" % default

    def reserve(self, joint, name):
        """The part of the drive's speed or acceleration that motion leaves: what a STEPGEN has above motion, or a quarter more."""
        motion = self.number(joint, "MAX_" + name)
        drive = max(self.number(joint, spelling, 0) for spelling in STEPGEN[name])
        return drive - motion if drive > motion else motion / 4

    def travel(self, joint):
        """The distance between the limits of a joint, or a metre."""
        low, high = self.number(joint, "MIN_LIMIT", -1e6), self.number(joint, "MAX_LIMIT", 1e6)
        return min(high - low, 1000 * self.unit) if high > low else 1000 * self.unit

    def fastest(self, stroked):
        """The speed of the fastest axis. A stroke adds as much to the speed of its joint."""
        return max(
            self.number(joint, "MAX_VELOCITY") * (2 if letter in stroked else 1)
            for letter, numbers in self.joints.items()
            for joint in numbers
        )


def prefixes(letter, joints):
    """(prefix of its signals, joint) of each joint of an axis: x, or y and y2."""
    return [(letter.lower() + (str(number) if number > 1 else ""), joint) for number, joint in enumerate(joints, start=1)]


def joints_by_coordinates(ini):
    """The joints of each axis, by the coordinates of trivkins; none for other kinematics."""
    words = (ini.get("KINS", "KINEMATICS") or "").split()
    if not words or words[0] != "trivkins":
        return {}
    letters = next((word.split("=", 1)[1] for word in words if word.startswith("coordinates=")), "XYZABCUVW")
    count = int(ini.number("KINS", "JOINTS", len(letters)))
    coordinates = set((ini.get("TRAJ", "COORDINATES") or letters).replace(" ", "").upper())
    joints = {}
    for number, letter in enumerate(letters.upper()[:count]):
        if letter in coordinates:
            joints.setdefault(letter, []).append(number)
    return joints


def is_inch(units):
    """Whether [TRAJ]LINEAR_UNITS is the inch. It is a word, or the number of units in a millimetre."""
    units = (units or "mm").strip().lower()
    try:
        return abs(float(units) - 1 / INCH) < 1e-4
    except ValueError:
        return units in ("in", "inch", "imperial")

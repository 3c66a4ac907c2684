# SPDX-License-Identifier: GPL-2.0-or-later
"""The error tables that the user's HAL files load into squareness. They are read, never written."""

import os
import re
import shlex
import stat

from hal_text import VALUE

LONGEST = 4 << 20  # bytes, as squareness reads them
STEEPEST, FASTEST = 125, 0.9  # mm/s2, mm/s: reversal-acceleration and reversal-rate, the defaults
SEAL = re.compile(rb"# end, seal [0-9a-f]{8}, \d+ rows?")


def unsealed(ini, files, home):
    """A sentence for each table without a seal, with the command that seals it."""
    tables = dict.fromkeys(table for text in texts(ini, files) for table in loaded(text, ini, home))
    sentence = "The error table %s has no seal, so a damaged digit can go unseen. Check the table, then run: plumb squareness --table %s --seal"
    return [sentence % (table, shlex.quote(table)) for table in tables if lacks_seal(table)]


def compensated(machine, home):
    """A sentence for each table that repeats the compensation of LinuxCNC itself, and would correct it twice."""
    for letter, (path, columns) in scales(machine, home).items():
        for joint in machine.joints.get(letter, []):
            section = "JOINT_%d" % joint
            for name in ("COMP_FILE", "BACKLASH"):
                value = machine.ini.get(section, name)
                if value is None or (name == "BACKLASH" and is_zero(value)):
                    continue
                sentence = (
                    "LinuxCNC compensates joint %d by %s = %s of [%s], and the error table %s has %s of the same axis, %s: both "
                    "would correct it twice. Take the line over by plumb volume import, and delete it; or delete the columns."
                )
                yield sentence % (joint, name, value, section, path, " and ".join(columns), letter)


def own_compensation(machine, home):
    """A note for each joint that LinuxCNC compensates, and no table."""
    repeated = scales(machine, home)
    for letter, joints in machine.joints.items():
        for joint in joints if letter not in repeated else ():
            section = "JOINT_%d" % joint
            path, backlash = machine.ini.get(section, "COMP_FILE"), machine.ini.get(section, "BACKLASH")
            if path:
                kind = machine.ini.get(section, "COMP_FILE_TYPE") or "0"
                unit = " --unit inch" if machine.inch else ""
                yield (
                    "LinuxCNC compensates %s by COMP_FILE of [%s]; this stays. squareness corrects the same without steps of speed: "
                    "plumb volume import --from linuxcnc %s --axis %s --type %s%s --output %s.csv, then delete the line."
                    % (letter, section, shlex.quote(path), letter, kind, unit, letter.lower())
                )
            elif backlash is not None and not is_zero(backlash):
                yield (
                    "LinuxCNC compensates %s by BACKLASH = %s of [%s]; this stays. For a lost motion that varies along the travel measure "
                    "it with plumb volume reversal, then delete the line." % (letter, backlash, section)
                )


def slow_turns(machine, home):
    """A note for each joint whose stage passes the turn of a direction column too late with the defaults."""
    for letter, (path, columns) in scales(machine, home).items():
        if not any(column[-1] in "+-" for column in columns):
            continue
        for joint in machine.joints.get(letter, []):
            acceleration = machine.reserve(joint, "ACCELERATION") / 4
            rate = 0.9 * min(machine.unit, machine.reserve(joint, "VELOCITY"))
            if acceleration < STEEPEST * machine.unit or rate < FASTEST * machine.unit:
                yield (
                    "The stage of joint %d is slower than squareness turns %s. Set reversal-acceleration to at most %.4g and reversal-rate "
                    "to at most %.4g." % (joint, letter, acceleration, rate)
                )


def is_zero(text):
    try:
        return float(text.split("#")[0]) == 0
    except ValueError:
        return False


def scales(machine, home):
    """Of each axis whose scale a table has: the path of the table, and its columns of the scale."""
    found = {}
    for path in dict.fromkeys(table for text in texts(machine.ini, machine.files) for table in loaded(text, machine.ini, home)):
        for line in lines_of(path):
            fields = [field.strip() for field in line.decode("ascii", "replace").split(",")]
            for letter in "XYZUVW":
                own = "E%s%s" % ("XYZ"["XYZUVW".index(letter) % 3], letter)
                columns = [field for field in fields if field in (own, own + "+", own + "-")]
                if letter in fields and columns:
                    found[letter] = path, columns
    return found


def texts(ini, files):
    yield from ini.all("HAL", "HALCMD")
    for path in files:
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            yield file.read().replace("\\\n", " ")


def loaded(text, ini, home):
    """The paths in the lines that load squareness."""
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if words[:2] != ["loadrt", "squareness"]:
            continue
        for word in words[2:]:
            if word.startswith("table="):
                value = word[len("table=") :].replace("$(CONFIG_DIR)", home)
                value = VALUE.sub(lambda found: ini.get(found[1], found[2] or found[3]) or "", value)
                yield from filter(None, value.split(":") if value != "none" else ())


def lacks_seal(path):
    """Whether it is a table that can be read, without a seal in its last line."""
    lines = lines_of(path)
    return bool(lines) and not SEAL.fullmatch(lines[-1])


def lines_of(path):
    """The lines of a file that are not empty; none if it cannot be read."""
    try:
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                return []
            return [line for line in file.read(LONGEST).splitlines() if line.strip()]
    except OSError:
        return []

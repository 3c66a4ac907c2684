# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawn tables of lost motion and scale, through the files of other controls and back; and spoiled files."""

import csv
import dataclasses
import os
import random
import re
import subprocess

from support.simulations import BUILD

UM = 1000
# Name, option of plumb volume, and the resolution of the format in mm.
KINDS = {
    "COMP_FILE, type 0": (("linuxcnc", "--type", "0"), 1e-9),
    "COMP_FILE, type 1": (("linuxcnc", "--type", "1"), 1e-9),
    "COMP_FILE, inch": (("linuxcnc", "--type", "1", "--unit", "inch"), 25.4e-9),
    ".rtl": (("rtl",), 0.05e-3),
    ".COM": (("heidenhain",), 1e-6),
}


@dataclasses.dataclass
class Outcome:
    seed: int
    differences: dict  # kind -> largest difference, um
    spoiled: dict  # (kind, spoiling) -> how it ended, "" for right


def volume(*arguments):
    return subprocess.run([os.path.join(BUILD, "bin", "plumb-volume"), *arguments], capture_output=True, text=True, check=False)


def draw(seed):
    """Rows of position, E+ and E-, uneven, in mm."""
    drawn = random.Random(f"table {seed}")
    position, rows, up, down = drawn.uniform(-800, 0), [], 0.0, drawn.uniform(-0.02, 0.02)
    for _ in range(drawn.randint(2, 60)):
        rows.append((round(position, 3), up, down))
        step = drawn.uniform(5, 60)
        position += step
        up, down = (value + drawn.uniform(-1, 1) * 0.9e-4 * step for value in (up, down))
    return rows


def read_table(path):
    with open(path, encoding="ascii") as file:
        lines = [line for line in file if not line.startswith("#")]
    return [tuple(map(float, row)) for row in list(csv.reader(lines))[1:]]


def simulate(seed, folder):
    rows = draw(seed)
    table = os.path.join(folder, "x.csv")
    with open(table, "w", encoding="ascii") as file:
        file.write("X,EXX+,EXX-\n" + "".join(f"{position!r},{up!r},{down!r}\n" for position, up, down in rows) + f"# end, {len(rows)} rows\n")
    outcome = Outcome(seed, {}, {})
    for kind, (options, _resolution) in KINDS.items():
        name, *rest = options
        other, again = os.path.join(folder, "other"), os.path.join(folder, "again.csv")
        for done in (volume("export", "--to", name, table, "--axis", "X", "--output", other, *rest), volume("import", "--from", name, other, "--axis", "X", "--output", again, *rest)):
            if done.returncode:
                raise RuntimeError(f"table {seed}, {kind}: {done.stderr}")
        back = read_table(again)
        if len(back) != len(rows):
            raise RuntimeError(f"table {seed}, {kind}: {len(back)} of {len(rows)} rows")
        outcome.differences[kind] = max(abs(a - b) * UM for row, its in zip(rows, back) for a, b in zip(row, its))
        with open(other, encoding="ascii") as file:
            text = file.read()
        outcome.spoiled.update({(kind, spoiling): ended for spoiling, ended in spoil(random.Random(f"spoil {seed}"), kind, options, text, back, folder)})
    return outcome


def spoil(drawn, kind, options, text, rows, folder):
    """Each way to spoil the file, and how it ended: "" if it was taken rightly, or refused with the line."""
    name, *rest = options
    path, table = os.path.join(folder, "spoiled"), os.path.join(folder, "spoiled.csv")

    def take(changed, *more):
        with open(path, "w", encoding="ascii", newline="") as file:
            file.write(changed)
        if os.path.exists(table):
            os.remove(table)
        return volume("import", "--from", name, path, "--axis", "X", "--output", table, *rest, *more)

    def refused(changed):
        done = take(changed)
        if not done.returncode:
            return "was taken"
        if os.path.exists(table):
            return "left half a table"
        return "" if f"{path}: " in done.stderr else "was refused without its file: " + done.stderr

    def same(changed, expected, *more):
        done = take(changed, *more)
        if done.returncode:
            return "was refused: " + done.stderr
        return "" if all(abs(a - b) < 1e-9 for row, its in zip(expected, read_table(table)) for a, b in zip(row, its)) else "is another table"

    lines = text.splitlines(keepends=True)
    data = [i for i, line in enumerate(lines) if line.strip() and (name == "linuxcnc" or len(line.split()) == (4 if name == "heidenhain" else 3) and line.split()[0].isdigit())]
    one = drawn.choice(data)

    def at_one(change):
        return "".join(change(line) if i == one else line for i, line in enumerate(lines))

    yield "line ends of DOS", same(text.replace("\n", "\r\n"), rows)
    yield "decimal commas", refused(text.replace(".", ","))
    yield "half a line", refused(at_one(lambda line: " ".join(line.split()[:-1]) + "\n"))
    yield "a word for a number", refused(at_one(lambda line: " ".join([*line.split()[:-1], "none"]) + "\n"))
    if name == "linuxcnc":
        low, high = sorted((data[0], data[-1]))
        lines[low], lines[high] = lines[high], lines[low]
        yield "another order", refused("".join(lines))
        lines[low], lines[high] = lines[high], lines[low]
        yield "an empty line within", refused("".join([*lines[:high], "\n", *lines[high:]]))
        other = "0" if rest[1] == "1" else "1"
        done = volume("import", "--from", name, path, "--axis", "X", "--output", table, "--type", other, *rest[2:])
        yield "the other type", "" if done.returncode or max(abs(value) for _at, *values in rows for value in values) == 0 else "was taken"
    yield "the other sign, told", same(text, [(at, -up, -down) for at, up, down in rows], "--negate")
    done = take(text)
    largest = max(rows, key=lambda row: abs(row[1]))
    word = "short of" if largest[1] < 0 else "beyond"
    said = " ".join(done.stdout.split())
    stated = re.search(r"stands ([\d.]+) um (short of|beyond) its nominal place", said)
    right = stated and stated[2] == word and abs(float(stated[1]) - abs(largest[1]) * UM) < 0.00501  # half of the last digit
    yield "sign in words", "" if right else "says: " + said

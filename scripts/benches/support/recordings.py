# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of benches: recordings of the host, tables of results, and the error tables that squareness reads."""

import csv
import datetime
import os
import zlib

import numpy as np


def read_columns(path):
    """The columns of a recording, as arrays under their names."""
    with open(path, encoding="ascii") as file:
        header = file.readline().strip().split(",")
        return dict(zip(header, np.loadtxt(file, delimiter=",", ndmin=2).T))


def write_rows(path, header, rows):
    with open(path, "w", newline="", encoding="ascii") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def write_error_tables(path, tables, machine, temperature="20 degC"):
    """The tables are triples: the letter of an axis, the names of its errors, and rows of position and errors.

    The file appears whole under its name, or not at all.
    """
    lines, count = [], 0
    for letter, errors, rows in tables:
        lines.append(",".join([letter, *errors]))
        lines += [",".join(repr(float(value)) for value in row) for row in rows]
        count += len(rows)
    content = "".join(line + "\n" for line in lines)
    head = {"machine": machine, "date": datetime.date.today().isoformat(), "temperature": temperature}
    text = "".join(f"# {name}: {value}\n" for name, value in head.items()) + content
    text += f"# end, seal {zlib.crc32(text.encode('utf-8')):08x}, {count} rows\n"
    with open(path + ".new", "w", newline="", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(path + ".new", path)


def blank_table(letter, low, high):
    """A table that corrects nothing between two positions."""
    return letter, ["EX" + letter], [(low, 0), (high, 0)]

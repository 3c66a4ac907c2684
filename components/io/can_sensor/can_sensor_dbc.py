#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""Writes signals of a DBC file as a TOML file for can_sensor. See can_sensor_dbc(1)."""

import argparse
import contextlib
import io
import logging
import os
import re
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "python"))  # of a build
import plumb_program  # noqa: E402

LONGEST_NAME = 20  # of a channel of can_sensor
LONGEST_UNIT = 12
NO_SENDER = 0xFE  # of a J1939 message whose sender the file leaves open
UNITS = {"°C": "degC", "\N{DEGREE SIGN}": "deg", "µm": "um", "": "1"}


class Refusal(Exception):
    """The DBC file or the choice of signals is wrong; the text gives the reason."""


def read(path):
    """The matrix of a DBC file."""
    logging.disable(logging.CRITICAL)  # canmatrix reports formats that are not installed
    import canmatrix.formats

    said = io.StringIO()
    try:
        with open(path, "rb") as file, contextlib.redirect_stdout(said):
            encoding = encoding_of(file.read())
            file.seek(0)
            matrix = canmatrix.formats.load_flat(file, "dbc", dbcImportEncoding=encoding, dbcImportCommentEncoding=encoding)
    except OSError as error:
        raise Refusal("%s: %s" % (path, error)) from None
    except Exception as error:  # damaged text gives the parser exceptions of any kind
        raise Refusal("%s: no DBC file: %s" % (path, error)) from None
    if not matrix.frames:
        raise Refusal("%s: no DBC file with messages" % path)
    for frame in matrix.frames:
        frame.is_j1939 = "J1939PG" in str(frame.attribute("VFrameFormat", matrix, ""))
    for line in re.findall(r"error with line no: (\d+)", said.getvalue()):
        print("can_sensor_dbc: %s:%s is not read" % (path, line), file=sys.stderr)
    return matrix


def encoding_of(data):
    """UTF-8, or else the code page of Windows in which Vector's editor writes."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"


def signals_of(matrix):
    """Pairs of message and signal, without the multiplexers themselves unless they are asked for."""
    return [(frame, signal) for frame in matrix.frames for signal in frame.signals]


def chosen(matrix, wanted):
    """Triples of message, signal and name, for words [Message.]Signal[=name]."""
    result = []
    for word in wanted:
        path, _, name = word.partition("=")
        message, _, signal_name = path.rpartition(".")
        found = [(f, s) for f, s in signals_of(matrix) if s.name == signal_name and message in ("", f.name)]
        if not found:
            raise Refusal("there is no signal %s; --list prints all" % path)
        if len(found) > 1:
            raise Refusal("%s is in several messages: write %s" % (path, " or ".join("%s.%s" % (f.name, s.name) for f, s in found)))
        result.append((*found[0], name or pin_name(signal_name)))
    return result


def pin_name(name):
    """SpindleTorque_1 -> spindle-torque-1"""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower()
    return re.sub(r"[^a-z0-9]+", "-", words).strip("-")


def checked(names):
    seen = set()
    for name in names:
        if not re.fullmatch("[a-z0-9-]{1,%d}" % LONGEST_NAME, name):
            raise Refusal("%s is no name of 1 to %d of a-z, 0-9 and '-': write SIGNAL=name" % (name, LONGEST_NAME))
        if name in seen:
            raise Refusal("the name %s is there twice: write SIGNAL=name" % name)
        seen.add(name)


def number(value):
    """A decimal of the file as a TOML number: without a loss, up to the whole numbers that a double has."""
    if abs(value) > 1 << 53:
        return repr(float(value))
    text = format(value.normalize() if hasattr(value, "normalize") else value, "f")
    return text.rstrip("0").rstrip(".") if "." in text else text


def unit_of(signal):
    unit = UNITS.get(signal.unit, signal.unit)
    unit = "".join(c for c in unit if " " <= c <= "~" and c not in '"\\')
    return unit[:LONGEST_UNIT].strip() or "1"


def place(signal):
    """Start bit, length and order."""
    start = signal.get_startbit(bit_numbering=1)
    return start, signal.size, "intel" if signal.is_little_endian else "motorola"


def multiplexer_of(frame, signal):
    """A line, or nothing."""
    if signal.mux_val is None:
        return ""
    if signal.muxer_for_signal:
        owner = next((s for s in frame.signals if s.name == signal.muxer_for_signal), None)
    else:
        owner = next((s for s in frame.signals if s.is_multiplexer), None)
    if owner is None:
        raise Refusal("%s.%s has a multiplexer that the message does not have" % (frame.name, signal.name))
    if owner.mux_val is not None:
        raise Refusal("%s.%s has a multiplexer that is multiplexed itself, which can_sensor does not read" % (frame.name, signal.name))
    start, length, order = place(owner)
    ranges = signal.mux_val_grp or [[signal.mux_val, signal.mux_val]]
    if len(ranges) > 1:
        raise Refusal("%s.%s has %d ranges of its multiplexer, and can_sensor reads one" % (frame.name, signal.name, len(ranges)))
    first, last = ranges[0]
    to = ", to = %d" % last if last > first else ""
    return 'multiplexer = { start-bit = %d, length = %d, order = "%s", value = %d%s }\n' % (start, length, order, first, to)


def channel(frame, signal, name):
    start, length, order = place(signal)
    kind = "signed" if signal.is_signed else "unsigned"
    if signal.is_float:
        if length not in (32, 64):
            raise Refusal("%s.%s is a float of %d bits" % (frame.name, signal.name, length))
        kind = "f%d" % length
    lines = "\n[[link.channel]]  # %s.%s\n" % (frame.name, signal.name)
    lines += 'name = "%s"\n' % name
    identity = frame.arbitration_id
    if frame.is_j1939 and identity.j1939_source == NO_SENDER:
        lines += "pgn = %d\n" % identity.pgn
    elif identity.extended:
        lines += "id = 0x%08X\nextended = true\n" % identity.id
    else:
        lines += "id = 0x%03X\n" % identity.id
    lines += multiplexer_of(frame, signal)
    lines += 'start-bit = %d\nlength = %d\norder = "%s"\ntype = "%s"\n' % (start, length, order, kind)
    lines += 'scale = %s\noffset = %s\nunit = "%s"\n' % (number(signal.factor), number(signal.offset), unit_of(signal))
    if signal.min is not None and signal.max is not None and signal.min < signal.max:
        lines += "min = %s\nmax = %s\n" % (number(signal.min), number(signal.max))
    cycle = frame.effective_cycle_time  # ms; 0 for none
    if cycle:
        lines += "max-age = %s\n" % number(max(3 * cycle, 10) / 1000)
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.split(" See")[0])
    parser.add_argument("file", metavar="FILE.dbc", help="DBC file of the bus")
    parser.add_argument("signal", metavar="SIGNAL", nargs="*", help="[MESSAGE.]SIGNAL, or [MESSAGE.]SIGNAL=name of the channel")
    parser.add_argument("--interface", default="can0", help="interface of the bus (default: can0)")
    parser.add_argument("--link", default="bus", help="name of the link (default: bus)")
    parser.add_argument("--list", action="store_true", help="prints all signals of the DBC file")
    arguments = parser.parse_args()
    try:
        matrix = read(arguments.file)
        if arguments.list:
            for frame, signal in signals_of(matrix):
                print("%s.%s" % (frame.name, signal.name), unit_of(signal))
            return
        if not arguments.signal:
            raise Refusal("name the signals; --list prints all")
        triples = chosen(matrix, arguments.signal)
        checked([arguments.link, *(name for _, _, name in triples)])
        text = '[[link]]\nname = "%s"\ninterface = "%s"\n' % (arguments.link, arguments.interface)
        print(text + "".join(channel(*triple) for triple in triples), end="")
    except Refusal as refusal:
        sys.exit("can_sensor_dbc: %s" % refusal)


if __name__ == "__main__":
    plumb_program.run("can_sensor_dbc", main)

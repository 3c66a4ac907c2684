#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A DISPLAY without a screen: turns the machine on, homes it, runs G-code files, and ends.

The files stand behind the INI file in linuxcnc's command line; without any, [DISPLAY]OPEN_FILE runs. If LinuxCNC
reports an error to the operator, or does not answer, the exit status of linuxcnc is 1, and the last lines say why. With `--record FILE` the virtual-time host
writes a row of the axes' positions for each servo cycle.

If the first file is a Python script (NAME.py), the script works the machine instead, with the arguments behind it.
plumb_linuxcnc.py helps it.
"""

import argparse
import os
import signal
import sys

import linuxcnc
from plumb_linuxcnc import Machine, OperatorError, Overdue

PINS = ["axis.%s.pos-cmd" % letter for letter in "xyz"] + ["motion.current-vel", "motion.program-line"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-ini", required=True, help=argparse.SUPPRESS)  # linuxcnc gives it to every DISPLAY
    parser.add_argument("programs", nargs="*", metavar="FILE")
    parser.add_argument("--record", metavar="FILE", help="CSV file for a row of each servo cycle")
    parser.add_argument("--pins", type=lambda text: text.split(","), default=PINS, help="what to record instead")
    if len(sys.argv) > 3 and sys.argv[3].endswith(".py"):  # behind -ini FILE
        os.execv(sys.executable, [sys.executable, *sys.argv[3:]])
    arguments = parser.parse_args()
    programs = arguments.programs or [linuxcnc.ini(arguments.ini).find("DISPLAY", "OPEN_FILE")]

    signal.signal(signal.SIGTERM, lambda *_: sys.exit("headless.py was asked to end (SIGTERM) before its programs were done"))
    try:
        with Machine() as machine:
            for error in machine.errors:  # of the start, which go on
                print(error, file=sys.stderr)
            try:
                machine.turn_on()
                machine.home()
                if arguments.record:
                    with machine.recording(arguments.record, arguments.pins):
                        run(machine, programs)
                else:
                    run(machine, programs)
            finally:
                for message in machine.messages:
                    print(message)
    except (OperatorError, Overdue) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def run(machine, programs):
    for program in programs:
        machine.run(program)
        if machine.was_aborted():
            raise OperatorError("%s was aborted before its end, and LinuxCNC gave no reason" % program)
        print("%s is done" % program, flush=True)


if __name__ == "__main__":
    sys.exit(main())

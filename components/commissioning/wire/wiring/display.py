# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of a trial: looks at the HAL, or homes the machine, runs it and lets each function show that it lives."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import traceback

import linuxcnc
import plumb
from hal_state import SHOWN, State, thread_rows
from numbers_of_programs import renumbered
from plumb_linuxcnc import Machine, OperatorError, Overdue

MARGIN = 0.3  # part of the travel: the trial moves no farther
LONGEST_MOVE = 40  # mm
LONGEST_PROGRAM = 300  # s of the machine's time


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        task = json.load(file)
    try:
        found = {"look": look, "check": check}[task["task"]](task)
    except Overdue as error:
        sys.exit("plumb wire: %s" % error)
    path = os.path.join(task["folder"], "result.json")
    with open(path + ".new", "w", encoding="utf-8") as file:
        json.dump(found, file)
    os.rename(path + ".new", path)


def show():
    texts = {}
    for kind in SHOWN:
        command = ["halcmd", "-s", "show", kind]
        texts[kind] = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False).stdout
    return texts


def look(task):
    """The HAL now, and after the files that a screen would load."""
    started = show()
    said = ""
    for name in task["postgui"]:
        with tempfile.TemporaryFile("w+") as words:  # not a pipe, which programs that the file loads keep open
            command = ["halcmd", "-k", "-i", task["ini"], "-f", name]
            subprocess.run(command, stdin=subprocess.DEVNULL, stdout=words, stderr=subprocess.STDOUT, check=False)
            words.seek(0)
            said += words.read()
    return {"started": started, "postgui": show(), "said": said}


def check(task):
    """The results of the checks: a list of (statement, whether it holds)."""
    seen, overdue = [], False
    with Machine() as machine:
        try:
            machine.turn_on()
            seen.append(("the machine turns on", True))
            machine.home(timeout=600)
            seen.append(("it homes", True))
            if "thread" in task:
                seen.append(order(**task["thread"]))
            run_program(machine, task)
            seen.append(("it runs a program", True))
            for name, path in task["checks"].items():
                shown = load(path).check(Machinery(machine, task))
                seen += [("%s: %s" % (name, text), bool(holds)) for text, holds in shown]
        except Overdue as error:
            seen.append((str(error), False))
            overdue = True
        except (OperatorError, plumb.Refused, plumb.HostDied, linuxcnc.error, RuntimeError) as error:
            seen.append((str(error), False))
        except Exception:  # raised by the check of a function
            seen.append((traceback.format_exc(), False))
        messages = machine.messages + machine.errors
    return {"seen": seen, "messages": messages, "overdue": overdue}


def order(name, theirs, sequence):
    """Whether the functions stand together in the thread, with none of the machine's between them."""
    present = next(words[5:] for words in thread_rows(show()["thread"]) if words[2] == name)
    present = [function for function in present if function in theirs or function in sequence]
    begin = present.index(sequence[0]) if sequence[0] in present else 0
    wrong = next((pair for pair in zip(sequence, present[begin:]) if pair[0] != pair[1]), None)
    if wrong:
        return "%s has %s in the place of %s" % (name, wrong[1], wrong[0]), False
    return "%d functions stand around motion-controller in %s" % (len(sequence) - 1, name), present[begin:][: len(sequence)] == sequence


class Machinery:
    """The machine, its axes, and pins by name, for the check of a function.

    unit    machine units in a millimetre
    folder  a folder for files of the check
    names   the signals of this machine by the names that the function's files use
    """

    def __init__(self, machine, task):
        self.machine, self.unit, self.names, self.axes = machine, task["unit"], task["names"], task["axes"]
        self.folder, self.moved = task["folder"], task["moved"]

    def get(self, name):
        return self.machine.host.get(self.names.get(name, self.moved.get(name, name)))

    def numbered(self, text):
        """G-code with the numbers of outputs and inputs of this machine."""
        return renumbered(text, self.moved)

    def set(self, name, value):
        self.machine.host.set(name, value)

    def ini(self, section, name):
        return linuxcnc.ini(self.machine.status.ini_filename).find(section, name)

    def move(self, **positions):
        """A straight move in machine coordinates."""
        units = "G21" if self.unit == 1 else "G20"  # a trial before may have left others
        self.machine.mdi(units + " G53 G0 " + " ".join("%s%.6f" % item for item in positions.items()))
        self.machine.wait(0.3)

    def lacking_velocity(self, letter):
        """The feed-forward inputs of a drive behind the stage of an axis that do not have the velocity of the offset."""
        state, axis = State(show()), letter.lower()
        command = self.names.get(axis + "-motor-cmd", axis + "-motor-cmd")
        fed = [name + "-deriv" for name, pin in state.pins.items() if name.endswith(".command") and pin.signal == command]
        signals = {name: state.signals.get(state.signal_of(name)) for name in fed}
        return [name for name, signal in signals.items() if signal and signal.writer != axis + "-stage.drive-velocity"]

    def position(self, letter):
        self.machine.poll()
        return self.machine.status.position["XYZABCUVW".index(letter)]

    def inside(self, letter):
        """The place where the axis stands, or one beside it that is clear of the soft limits."""
        low, high = limits(self.axes[letter])
        edge = min(5 * self.unit, 0.1 * (high - low))
        return min(max(self.position(letter), low + edge), high - edge)

    def room(self, letter, length):
        """A move of at most this length, in mm, from here: its end, well within the soft limits."""
        here = self.inside(letter)
        low, high = limits(self.axes[letter])
        length = min(length * self.unit, MARGIN * (high - low))
        return here + length if high - here > here - low else here - length


def limits(axis):
    low, high = axis["limits"]
    return max(low, -1e4), min(high, 1e4)


def run_program(machine, task):
    """A program with a rapid and a feed of X, Y and Z, away from the nearer soft limit and back."""
    machinery = Machinery(machine, task)
    lines = ["%s G90 G94 G40 G49 G80" % ("G21" if task["unit"] == 1 else "G20")]
    for letter in sorted(set("XYZ") & set(task["axes"])):
        here, there = machinery.inside(letter), machinery.room(letter, LONGEST_MOVE)
        feed = 300 * task["unit"]
        lines += ["G53 G0 %s%.6f" % (letter, there), "G53 G1 %s%.6f F%g" % (letter, (here + there) / 2, feed)]
        lines += ["G53 G0 %s%.6f" % (letter, here)]
    path = os.path.join(task["folder"], "trial.ngc")
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(lines + ["M2"]) + "\n")
    machine.run(path, LONGEST_PROGRAM)


def load(path):
    specification = importlib.util.spec_from_file_location("check", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


if __name__ == "__main__":
    main()

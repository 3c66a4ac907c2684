# SPDX-License-Identifier: GPL-2.0-or-later
"""The starts of copies of a machine: to read its HAL, and to try the wiring."""

import os
import re

import hal_text
import writing
from hal_state import SHOWN, State
from machine import MOTION, Machine
from model_parts import WANTED_FALSE, WANTED_TRUE, demanded
from remedies import remedy
from sandbox import OWN
from stand_ins import ABSENT, StandIns
from step_rates import too_slow
from texts import Impossible, wrapped
from trial import NotStarted, Trial

BASIC_STEPS = 4  # of a trial: on, home, order, program
# A busy computer can stop LinuxCNC's programs for longer than a loss takes.
PATIENCE = "".join("setp interlock.service-timeout-%d 60\n" % service for service in (1, 4, 5))
ACTING = "setp interlock.commissioning false\n"  # the trial is what plumb commission does on the machine
SHOWN_WORDS = 12  # lines of LinuxCNC's
ATTEMPTS = 30  # to find types and directions of the pins of a driver


class Trials:
    """The trials of one machine, in a folder of their own. `plumb` is the program plumb; `later` is LaterFiles."""

    def __init__(self, home, folder, plumb, learnt, later):
        self.home, self.folder, self.plumb, self.later = home, folder, plumb, later
        self.learnt = dict(learnt or {})  # about the pins that stand in
        self.stand_ins = self.trial = None

    def look(self, ini, joints, name):
        """The Machine, as LinuxCNC makes it of an INI file without ours."""
        files = list(hal_text.halfiles(ini, self.home))
        postgui = [os.path.join(self.home, value.split()[0]) for value in ini.all("HAL", "POSTGUI_HALFILE") if value.split()]
        postgui = [path for path in postgui if os.path.isfile(path) and not path.endswith(".tcl")]
        written = ini.copy()
        for turn in range(ATTEMPTS):
            ini = written.copy()
            self.trial = Trial(ini, os.path.join(self.folder, name, str(turn)), self.plumb)
            self.stand_ins = StandIns(self.trial, ini, files, self.learnt)
            self._leave_out(self.trial, self.stand_ins)
            self.snapshot(self.trial, ini)
            try:
                found = self.trial.run("look", postgui=postgui)
                break
            except NotStarted as error:
                if lacks_kinematics(str(error), written) or not self.stand_ins.learn(str(error)):
                    raise Impossible("Your configuration does not start here, without anything of Plumb:\n%s" % advised(error, written)) from None
        else:
            raise Impossible("Your configuration does not start here: no pins could stand in for its drivers.")
        texts = {}
        for kind in found["started"]:
            texts[kind] = writing.read(self.trial.own, "show-" + kind)
        machine = Machine(State(texts), State(found["postgui"]), joints, written, files)
        if machine.thread is None:
            raise Impossible("No thread of this configuration runs motion-controller.")
        return machine

    def _leave_out(self, trial, stand_ins):
        """Takes the lines that use something of ours out of files of the user, where ours is not loaded."""
        pattern = self.later.pattern(stand_ins.nets)
        for path, text in stand_ins.texts.items():
            left = self.later.without(path, text, pattern)
            if left != text:
                stand_ins.texts[path] = left
                trial.place(path, left)

    @staticmethod
    def snapshot(trial, ini):
        """A last HALFILE that notes the HAL."""
        lines = ['if {[info procs ::tp::passnumber] ne "" && [::tp::passnumber] == 0} return']
        lines += ["exec halcmd -s show %s > %s/show-%s" % (kind, OWN, kind) for kind in SHOWN]
        ini.add("HAL", "HALFILE", trial.write("show.tcl", "\n".join(lines) + "\n"))

    def run(self, ini, files, wiring, functions):
        """The statements about the result, and LinuxCNC's messages. `ini` has the lines that put it in; files go by path."""
        machine = wiring.machine
        trial = Trial(ini, os.path.join(self.folder, "try"), self.plumb)
        self.release(machine)
        stand_ins = StandIns(trial, ini, machine.files, self.learnt)
        for name, text in files.items():
            trial.place(os.path.join(self.home, name), text)
        for function in functions:
            if function.check_hal:
                with open(function.check_hal, encoding="utf-8") as file:
                    text = renamed(file.read(), wiring, machine, functions)
                ini.add("HAL", "HALFILE", trial.write("%s.hal" % function.name, text))
        switches = "".join("setp %s 1\n" % wiring.switch_of(function) for function in functions)
        ini.add("HAL", "HALFILE", trial.write("patience.hal", PATIENCE + ACTING + switches))
        self.drive(ini, stand_ins)
        checks = {function.name: function.check for function in functions if function.check}
        settings = {"unit": machine.unit, "names": wiring.names, "axes": machine.axes, "checks": checks}
        settings["moved"] = wiring.numbers.moved
        settings["thread"] = {
            "name": machine.thread,
            "theirs": machine.complete.threads[machine.thread],
            "sequence": wiring.files.sequence,
        }
        try:
            found = trial.run("check", **settings)
        except NotStarted as error:
            raise Impossible("Your configuration does not start on the copy:\n%s" % advised(error, ini)) from None
        if found["overdue"]:  # a busy computer can upset LinuxCNC's programs on the faster clock
            found = trial.run("check", **settings)
        return found["seen"], found["messages"]

    def without_plumb(self, ini, machine, steps):
        """Whether the machine fails by itself, where it did not come through the first steps."""
        if steps > BASIC_STEPS:
            return ""
        trial = Trial(ini, os.path.join(self.folder, "bare"), self.plumb)
        stand_ins = StandIns(trial, ini, machine.files, self.learnt)
        self._leave_out(trial, stand_ins)
        self.drive(ini, stand_ins)
        try:
            seen = trial.run("check", unit=machine.unit, names={}, axes=machine.axes, checks={}, moved={})["seen"]
        except NotStarted:
            return " Your configuration does not start either when Plumb is left out."
        failed = [statement for statement, holds in seen if not holds]
        if not failed:
            return " Without Plumb it works."
        reasons = too_slow(machine) if "following error" in failed[0] else ()
        return "\n".join([" The same machine without Plumb fails too: %s." % failed[0], *(wrapped(reason, "- ") for reason in reasons)])

    def release(self, machine):
        """Learns the inputs from the hardware without which the machine does not turn on or the spindle is not at speed."""
        state, outputs = machine.complete, self.stand_ins.outputs()

        def writer_of(pin):
            signal = state.signals.get(state.signal_of(pin))
            return signal and signal.writer

        for wanted, value in ((WANTED_TRUE, True), (WANTED_FALSE, False)):
            for name in filter(wanted.fullmatch, state.pins):
                for writer, level in demanded(name, value, writer_of, lambda pin: state.pins[pin].owner, outputs):
                    if not any(writer in self.learnt.get(known, []) for known in ("true", "false")):
                        self.learnt.setdefault("true" if level else "false", []).append(writer)

    @staticmethod
    def drive(ini, stand_ins):
        """Lets joints home where they stand, whose feedback from hardware follows their commands."""
        begin_with_first_sequence(ini)
        if not stand_ins.outputs():
            return
        for joint in joints(ini):
            if ini.get("JOINT_%d" % joint, "HOME_SEARCH_VEL"):
                for name in ("HOME_SEARCH_VEL", "HOME_LATCH_VEL", "HOME_FINAL_VEL", "HOME_USE_INDEX"):
                    ini.set("JOINT_%d" % joint, name, "0")


def lacks_kinematics(words, ini):
    """Whether LinuxCNC has no module of the kinematics, for which nothing can stand in."""
    module = (ini.get("KINS", "KINEMATICS") or "").split()[:1]
    found = ABSENT.search(words)
    return bool(found) and [found[1]] == module


def advised(error, ini):
    """What to do, or else LinuxCNC's last words."""
    advice = remedy(str(error), ini)
    return wrapped(advice) if advice else "\n".join(str(error).split("\n")[-SHOWN_WORDS:])


def joints(ini):
    return range(int(ini.number("KINS", "JOINTS", 0)))


def begin_with_first_sequence(ini):
    """LinuxCNC homes all joints together only from sequence 0 or 1 on; some users home theirs one by one."""
    sections = ["JOINT_%d" % joint for joint in joints(ini)]
    sequences = {section: int(ini.number(section, "HOME_SEQUENCE", 0)) for section in sections}
    first = min(map(abs, sequences.values()), default=0)
    for section, sequence in sequences.items() if first > 1 else ():
        ini.set(section, "HOME_SEQUENCE", str(sequence - first + 1 if sequence > 0 else sequence + first - 1))


def renamed(text, wiring, machine, functions):
    """The HAL of a check with the signals of this machine. A signal that functions take and the user writes has the check's
    source in the trial; any other name of the user's is free for the user."""
    lines = []
    state = machine.halfiles
    taken = {words[0] for function in functions for words in function.nets(machine.axes)}
    for line in text.splitlines():
        words = line.split()
        if words and words[0] == "net":
            signal = wiring.names.get(words[1], words[1])
            if signal == words[1] and signal in state.signals and signal not in taken:
                signal = "plumb-check-" + signal
            _, writer, _ = hal_text.pins_of_net(words[1:])
            theirs = state.signals[signal].writer if writer and signal in state.signals else None
            if theirs:
                lines.append("unlinkp " + theirs)
            line = " ".join(["net", signal, *words[2:]])
        if words and words[0] == "addf":
            place = state.threads[machine.thread].index(MOTION) + len(wiring.files.before) + 2
            line = "addf %s %s %d" % (words[1], machine.thread, place)
        lines.append(line)
    return "\n".join(lines) + "\n"

# SPDX-License-Identifier: GPL-2.0-or-later
"""Joins the signals of parts and functions to the machine's signals."""

import fnmatch

import hal_text
import stages
from modules import is_once

# Inputs of LinuxCNC that hold something back while true: a signal of the user and ours are joined by `or`.
JOINED = ("motion.feed-inhibit", "motion.feed-hold", "motion.homing-inhibit", "halui.abort")


class Signals:
    """The nets of all parts and functions on this machine.

    names       the machine's signals by ours
    gates       Parts that join a signal of the user and ours
    unlinked    pins that the user's signals leave for a gate
    lacking     outputs and inputs for programs that motmod does not have yet
    problems    the conflicts, a sentence each
    notes       sentences for the user
    """

    def __init__(self, functions, parts, modules, machine):
        self.functions, self.modules, self.machine = functions, modules, machine
        self.freed, self.names = parts.freed, dict(parts.names)
        self.gates, self.unlinked, self.lacking, self.problems, self.notes = [], [], [], [], []
        self.writers = {}  # pin and owner, by signal
        nets = [(function.name, words) for function in functions for words in function.nets(machine.axes)]
        nets += [(parts.file, words) for part in parts.all for words in part.nets]
        wanted, joined = self._sort(nets)
        for (signal, pin), who in wanted.items():
            self._unify(signal, pin, who)
        self._prefix({words[0] for _, words in nets})
        for pin, signal in joined.items():
            self._join(pin, signal)

    def name(self, signal):
        """The signal of this machine."""
        return self.names.get(signal, signal)

    def _sort(self, nets):
        """The first owner of each (signal, pin) of the machine that the nets name, and the signal of each pin in JOINED."""
        state, wanted, joined = self.machine.complete, {}, {}
        for who, words in nets:
            signal, writer, readers = hal_text.pins_of_net(words)
            if writer and self.writers.setdefault(signal, (writer, who))[0] != writer:
                self.problems.append("%s and %s both write the signal %s." % (writer, self.writers[signal][0], signal))
            for pin in ([writer] if writer else []) + readers:
                if pin in self.freed or is_once(pin):
                    continue
                if pin in JOINED and pin in state.pins:
                    joined[pin] = signal
                elif pin in state.pins:
                    wanted.setdefault((signal, pin), who)
                elif not self.modules.has(pin):
                    self._note_missing(pin, who)
        return wanted, joined

    def _note_missing(self, pin, who):
        if pin.startswith(("motion.digital-", "motion.analog-")):
            self.lacking.append(pin)
        elif pin.startswith("halui."):
            self.problems.append("%s needs %s: write HALUI = halui into [HAL] of the INI file." % (who, pin))
        else:
            self.problems.append("%s needs the pin %s, which this LinuxCNC does not have." % (who, pin))

    def _unify(self, signal, pin, who):
        """Takes the signal that the user has at a pin for ours, where that means the same."""
        state, writer = self.machine.complete, self.writers.get(signal, (None, None))[0]
        theirs = state.signal_of(pin)
        if theirs is None:
            return
        other = state.signals[theirs]
        others = [end for end in [other.writer, *other.readers] if end and end != pin]
        own = any(fnmatch.fnmatch(pin, pattern) for function in self.functions for pattern in function.own_pins)
        is_source = state.pins[pin].direction == "OUT"
        if own and others:
            self.problems.append(
                "%s is in use: your signal %s joins it to %s%s, and %s needs it for %s. Use another one for yours."
                % (pin, theirs, ", ".join(others), self.machine.at(pin, theirs), who, signal)
            )
        elif not is_source and writer and other.writer and other.writer != writer:
            self.problems.append(
                "%s is in use: your signal %s brings it %s%s, and %s needs it for %s from %s. Only one can have it."
                % (pin, theirs, other.writer, self.machine.at(pin, theirs), who, signal, writer)
            )
        elif self.names.setdefault(signal, theirs) != theirs:
            self.problems.append(
                "%s is in your signal %s%s, and %s needs it in %s, as %s is."
                % (pin, theirs, self.machine.at(pin, theirs), who, self.names[signal], signal)
            )

    def _prefix(self, ours):
        """Renames each of our signals whose name the user has given to another one."""
        external = {name for function in self.functions for name in function.external_signals}
        known = {*self.machine.complete.signals, *self.machine.halfiles.signals}
        for signal in sorted(ours & known - external):
            self.names.setdefault(signal, "plumb-" + signal)

    def _join(self, pin, signal):
        """Joins our source of a pin that holds something back, and the user's."""
        theirs, early = self.machine.complete.signal_of(pin), self.machine.halfiles.signal_of(pin)
        if theirs and not early:
            self.problems.append(
                "%s is netted to the signal %s by a HALCMD line or a file of the screen%s. It must take %s too: move the line "
                "into a HALFILE." % (pin, theirs, self.machine.at(pin, theirs), signal)
            )
        elif theirs:
            self.unlinked.append(pin)
            self.names["your-" + theirs] = theirs
            self.gates.append(stages.either(signal, "your-" + theirs, pin))
            self.notes.append("%s keeps your signal %s; `or` joins it with %s." % (pin, theirs, self.name(signal)))

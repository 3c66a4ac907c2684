# SPDX-License-Identifier: GPL-2.0-or-later
"""Functions joined to a machine: parts, modules, signals, files."""

from hal_files import HalFiles
from interlock import switch
from modules import Modules
from numbers_of_programs import Numbers
from parts import Parts
from signals import Signals


class Wiring:
    """The functions joined to the machine.

    problems    the conflicts, a sentence each
    notes       sentences for the user
    names       the machine's signals by ours
    motmod      options that the loadrt line of motmod lacks: the number of its outputs
    files       HalFiles

    Without `commissioning` functions act at once: for a simulated machine.
    """

    def __init__(self, functions, machine, folder, numbers=None, commissioning=True):
        self.functions, self.machine = functions, machine
        self.notes, self.names, self.motmod = [], {}, {}
        self.numbers = numbers or Numbers(functions, machine, {})
        for function in functions:
            function.numbers = self.numbers
            function.stroked_by = {letter: other for other in functions if other is not function for letter in other.stroke}
            function.meet(machine.complete)
        parts = Parts(functions, machine, folder, commissioning)
        for part in parts.all:
            part.nets = [[self.numbers.moved.get(word, word) for word in net] for net in part.nets]
        modules = Modules(functions, parts.all, machine)
        self.problems = [*modules.presence_problems(), *parts.problems, *self.numbers.problems]
        if self.problems:
            return
        signals = Signals(functions, parts, modules, machine)
        modules = Modules(functions, parts.all + signals.gates, machine)
        self.problems = [*modules.name_problems(), *signals.problems, *modules.load_problems()]
        self.notes = parts.notes + signals.notes + self.numbers.notes
        self.names, self.motmod = signals.names, outputs(signals.lacking)
        self.passed = parts.passed
        self.files = HalFiles(functions, machine, folder, parts, modules, signals)

    def switch_of(self, function):
        """The pin by which the operator switches this function."""
        return switch(function.number)


def outputs(pins):
    """The options of motmod that give these pins of programs: num_dio, num_aio."""
    counts = {}
    for pin in pins:
        kind = "num_dio" if "digital" in pin else "num_aio"
        counts[kind] = max(counts.get(kind, 0), int(pin.rsplit("-", 1)[1]) + 1)
    return counts

# SPDX-License-Identifier: GPL-2.0-or-later
"""Pins, signals, functions and threads of a HAL, as `halcmd -s show` prints them."""

import collections

SHOWN = ("comp", "pin", "sig", "param", "thread")

Pin = collections.namedtuple("Pin", "owner type direction signal")
Signal = collections.namedtuple("Signal", "type writer readers")


class State:
    """The HAL at one moment: pins, signals and threads by name, components and the instances of each module."""

    def __init__(self, texts):
        self.components = {words[2] for words in _rows(texts["comp"], 3)}
        self.pins, self.signals, self.threads = {}, {}, {}
        for words in _rows(texts["pin"], 5):
            owner, kind, direction, _, name = words[:5]
            self.pins[name] = Pin(owner, kind, direction, words[6] if len(words) > 6 else None)
        for words in _rows(texts["sig"], 3):
            writer, readers = None, []
            for arrow, pin in zip(words[3::2], words[4::2]):
                if arrow == "<==":
                    writer = pin
                else:
                    readers.append(pin)
            self.signals[words[2]] = Signal(words[0], writer, readers)
        self.parameters = {words[4]: words[0] for words in _rows(texts["param"], 5)}
        self.values = {words[4]: words[3] for words in _rows(texts["param"], 5)}
        self.periods = {}  # of the threads, in ns
        for words in thread_rows(texts["thread"]):
            self.threads[words[2]] = words[5:]
            self.periods[words[2]] = words[0]

    def signal_of(self, pin):
        found = self.pins.get(pin)
        return found.signal if found else None

    def owner_of_prefix(self, instance):
        """The module whose pins or parameters begin with this name and a dot, or the component of this name."""
        for name, pin in self.pins.items():
            if name.startswith(instance + "."):
                return pin.owner
        for name, owner in self.parameters.items():
            if name.startswith(instance + "."):
                return owner
        return instance if instance in self.components else None

    def instances(self, module):
        """The instances of a module: the names of its pins up to the last dot."""
        return sorted({name.rsplit(".", 1)[0] for name, pin in self.pins.items() if pin.owner == module})

    def thread_with(self, function):
        return next((name for name, functions in self.threads.items() if function in functions), None)


def thread_rows(text):
    """A list for each thread: period, floating point, name, times and functions. LinuxCNC 2.10 shows a function a line."""
    rows = []
    for words in map(str.split, text.splitlines()):
        if len(words) == 1 and rows:
            rows[-1] += words
        elif len(words) >= 3:
            rows.append(words)
    return rows


def _rows(text, least):
    for line in text.splitlines():
        words = line.split()
        if len(words) >= least:
            yield words

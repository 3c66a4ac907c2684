# SPDX-License-Identifier: GPL-2.0-or-later
"""The HAL of this computer, for the panel and linuxcnc_link."""

import ctypes
import gc
import os
import subprocess
import sys

import hal

from panel.pin_lines import parse_parameters, parse_pins

OWN_REFERENCES = 2  # to an element of a list: from the list, and from the call which counts them
_release = ctypes.pythonapi.Py_DecRef
_release.argtypes, _release.restype = [ctypes.py_object], None

MEMORY_KEY = 0x48414C32  # of HAL's shared memory


class HalGone(RuntimeError):
    """LinuxCNC has ended, or no HAL runs."""


class Now:
    """The pins of this moment, each looked up when it is asked for: as values(), for a few of them."""

    def get(self, name, otherwise=None):
        try:
            return hal.get_value(name)
        except RuntimeError:
            return otherwise

    def __contains__(self, name):
        return self.get(name) is not None


class Hal:
    def __init__(self, component=None):
        """With a component without pins, unless the program has one."""
        if _memory() is None:
            raise HalGone("no HAL runs")
        if component is None:
            try:
                component = hal.component("plumb-panel-%d" % os.getpid())
            except (hal.error, RuntimeError) as error:
                raise HalGone(str(error)) from None
            component.ready()
        self._component = component
        self.memory = _memory()

    def is_gone(self):
        """Whether the HAL of the start has ended: a program keeps its memory, with values that stand still."""
        return is_gone(self.memory)

    def values(self):
        """All pins' values by name."""
        return _infos(hal.get_info_pins, "NAME", "VALUE")

    def signals(self):
        """The pin that writes each signal, by the signal's name."""
        return _infos(hal.get_info_signals, "NAME", "DRIVER")

    def pins(self):
        """All pins, by halcmd, which knows owners and signals."""
        return parse_pins(_halcmd("-s", "show", "pin"))

    def parameters(self):
        """All parameters' values by name."""
        return parse_parameters(_halcmd("-s", "show", "param"))

    def load_line(self, module):
        """The loadrt line of a module, "" without one."""
        return next((line for line in _halcmd("save", "comp").splitlines() if line.split()[:2] == ["loadrt", module]), "")

    def get(self, name):
        try:
            return hal.get_value(name)
        except RuntimeError:
            raise KeyError(name) from None

    def set(self, name, text):
        """Raises ValueError if HAL refuses it."""
        try:
            hal.set_p(name, text)
        except RuntimeError as error:
            raise ValueError(str(error)) from None

    def close(self):
        if not self.is_gone():
            self._component.exit()


def _infos(look, key, value):
    """A dictionary of two entries of the dictionaries that a look at HAL returns."""
    gc.disable()  # a collection while HAL is locked would hold up all that needs the lock
    try:
        infos = look()
    finally:
        gc.enable()
    found = {info[key]: info[value] for info in infos}
    if infos and sys.getrefcount(infos[0]) > OWN_REFERENCES:
        # LinuxCNC 2.9 keeps a reference to each of these dictionaries, 0.5 kB a pin and look.
        for info in infos:
            _release(info)
    return found


def _halcmd(*words):
    try:
        return subprocess.run(["halcmd", *words], capture_output=True, text=True, timeout=20, check=False).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise HalGone("halcmd does not answer: %s" % error) from None


def is_gone(memory):
    """Whether the HAL of this memory has ended."""
    return _memory() != memory


def _memory():
    """The number of HAL's shared memory; None without one."""
    try:
        with open("/proc/sysvipc/shm", encoding="ascii") as file:
            for line in list(file)[1:]:
                words = line.split()
                if int(words[0]) & 0xFFFFFFFF == MEMORY_KEY:
                    return int(words[1])
    except OSError:
        return 0  # the system does not tell: HAL is taken to live
    return None

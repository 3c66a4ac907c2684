# SPDX-License-Identifier: GPL-2.0-or-later
"""The inputs of a function as they are now, with validity and age, and the load of a spindle as a bar."""

import collections
import math
import statistics

from gi.repository import Gtk

from panel import texts
from panel.picture import Picture
from panel.texts import _, number, seconds, with_unit
from panel.widgets import card, column, grow, label, named, row, set_text


class LiveInputs(Gtk.Box):
    """A line for each input; an input of a sensor program has its validity and age."""

    def __init__(self, panel, instance, shorts):
        super().__init__(orientation=Gtk.Orientation.VERTICAL)
        self._panel, self._instance, self._lines = panel, instance, {}
        lines = column(spacing=2)
        for short in shorts:
            if short not in instance.pins:
                continue
            value, state = label("", "value", wrap=False), label("", "soft")
            words = [label(_(instance.declared.pin(short).get("sentence", "")), "soft")]
            name = [label(short)] if texts.PIN_NAMES[0] else []
            lines.pack_start(row(grow(column(*name, *words, spacing=0)), state, value), False, False, 0)
            self._lines[short] = value, state
        self.pack_start(card(label(_("Inputs now"), "value"), lines), True, True, 0)

    def show_values(self, values):
        for short, (value, state) in self._lines.items():
            now = self._instance.value(values, short)
            unit = self._instance.declared.pin(short).get("unit", "")
            text = _("gone") if now is None else with_unit(round(now, 4) if isinstance(now, float) and math.isfinite(now) else now, unit)
            set_text(value, text)
            set_text(state, state_of_input(self._panel.machine, self._instance, short, values))


def state_of_input(machine, instance, short, values):
    """Validity and age in words: from its sensor, or from the pins beside it."""
    number_ = short[len(short.rstrip("0123456789")):]
    stem = short[: len(short) - len(number_)]
    valid = instance.value(values, "%svalid-%s" % (stem, number_) if number_ else short + "-valid")
    age = instance.value(values, "%sage-%s" % (stem, number_) if number_ else short + "-age")
    writer = machine.writer(instance.full(short))
    for channel in machine.channels:
        if writer == channel.pins["value"]:
            valid, age = values.get(channel.pins["valid"]), values.get(channel.pins["age"])
    if short in instance.pins and not instance.pins[short].signal:
        return "\u25cb " + _("no signal")
    if writer and writer not in values:
        return "\u2716 " + _("gone")
    now = instance.value(values, short)
    if isinstance(now, float) and not math.isfinite(now):
        return "\u2716 " + _("not a number")
    aged = " " + _("{age} old").format(age=seconds(age) if age >= 10 else "%.1f s" % age) if isinstance(age, float) and math.isfinite(age) else ""
    if valid is None:
        return aged.strip()
    return ("\u2714 " + _("valid") if valid else "\u2716 " + _("not valid")) + aged


class LoadBar(Picture):
    """The load, and the rise over the usual one of the last seconds that is a contact."""

    LOOKS = 40  # of the last seconds

    def __init__(self, panel):
        super().__init__(panel, _("Load"), (300, 70))
        self._shown, self._loads = None, collections.deque(maxlen=self.LOOKS)

    def show_load(self, load, threshold, valid):
        if math.isfinite(load):
            self._loads.append(load)
        idle = statistics.median(self._loads) if self._loads else 0.0
        shown = (round(load, 2), round(idle, 2), threshold, valid)
        if shown == self._shown:
            return
        self._shown = shown
        words = _("Load {load} %, a contact at {contact} %").format(load=number(shown[0], 4), contact=number(round(idle + threshold, 2), 4))
        named(self, words if valid else _("The load is not valid"))
        self.queue_draw()

    def draw(self, pen, width, _height):
        if self._shown is None:
            return
        load, idle, threshold, valid = self._shown
        full = max(10.0, *(abs(each) for each in self._loads), idle + 2 * abs(threshold)) if self._loads else 10.0
        full = 10.0 * math.ceil(full / 10.0)

        def x(percent):
            return 8 + max(0.0, min(1.0, percent / full)) * (width - 16)

        pen.box(8, 8, width - 16, 26, "card", "line")
        if valid and math.isfinite(load):
            pen.box(8, 9, x(load) - 8, 24, "curve2" if load >= idle + threshold else "curve")
        pen.line((x(idle + threshold), 3), (x(idle + threshold), 40), width=3)
        pen.words(10, 58, self.get_accessible().get_name(), 15)

# SPDX-License-Identifier: GPL-2.0-or-later
"""The questions of thermal_displacement: why contacts have moved at once, and why the origin of the program has changed."""

import re
import time

from gi.repository import Gtk

from panel import effects
from panel.texts import _, in_micrometres
from panel.widgets import button, card, column, grow, label, row, set_text

NOT_GROWTH, GROWTH = "shift-is-not-growth", "shift-is-growth"  # pins
ZERO, BY_HAND, DEPTH = "change-is-zero", "change-is-growth", "change-is-depth"


class Question(Gtk.Box):
    """Buttons, each with its effect; seen while the question has no answer. `answers` are (name, what a press does, its effect as a label)."""

    def __init__(self, page, *answers):
        super().__init__(orientation=Gtk.Orientation.VERTICAL)
        self._page, self._words = page, label("", "warn")
        self._columns = [grow(column(button(name, answer, name=name), effect, spacing=4)) for name, answer, effect in answers]
        its = row(*self._columns, spacing=16)
        its.set_homogeneous(True)
        self._card = card(self._words, its)
        self.pack_start(self._card, True, True, 0)
        self.set_no_show_all(True)

    def _ask(self, text, values):
        """Without a text it has its answer."""
        if text:
            until = self._page.instance.sentence(values, "unanswered-code")
            set_text(self._words, " ".join(filter(None, ("\u25b2", text, until))))
            self._card.show_all()
        self.set_visible(bool(text))


class ShiftQuestion(Question):
    def __init__(self, page):
        self._effects = {pin: label("", "soft") for pin in (NOT_GROWTH, GROWTH)}
        super().__init__(page, (_("It is not growth"), self._is_not_growth, self._effects[NOT_GROWTH]), (_("It is growth"), self._is_growth, self._effects[GROWTH]))

        self._as_growth = self._columns[1]
        self._as_growth.show_all()
        self._as_growth.set_no_show_all(True)

    def show_question(self, values):
        size = self._page.get(values, "shift-size", 0.0)
        of_tool = bool(self._page.get(values, "shift-tool", 0))
        set_text(self._effects[NOT_GROWTH], _("The tool has another length. The reference follows, and the tool cuts as now: measure the tool to correct the depth.")
                 if of_tool else _("Work, zero, tool or drive have changed. The reference follows, and Z does not move."))
        self._as_growth.set_visible(not of_tool)  # the other tools stand
        set_text(self._effects[GROWTH], _("The spindle has grown. {effect}").format(effect=self._effect(values)) if size else "")
        self._ask(self._question(values, size) if size else "", values)

    def _question(self, values, size):
        tool = self._page.get(values, "shift-tool", 0)
        if not tool:
            return _("Contacts have moved by {shift} at once. What is it?").format(shift=in_micrometres(size))
        since = time.strftime("%H:%M", time.localtime(time.time() - self._page.get(values, "shift-age", 0.0)))
        text = _("Tool {tool} has cut deeper by {shift} since {since}. What is it?") if size > 0 else _("Tool {tool} has cut shallower by {shift} since {since}. What is it?")
        return text.format(tool=tool, shift=in_micrometres(abs(size)).lstrip("+"), since=since)

    def _moves(self, values):
        """Those that come at once."""
        page = self._page
        return effects.of_more_growth(page.instance, values, page.get(values, "shift-size", 0.0))

    def _effect(self, values):
        moves = self._moves(values)
        return effects.in_words(moves) if moves else _("Z moves by {shift} when the next cycle begins.").format(
            shift=in_micrometres(self._page.get(values, "shift-size", 0.0)))

    def _is_not_growth(self):
        self._page.panel.guard.once_asked(lambda: (_("Change the reference by {shift}? It stays so after a restart. Z does not move.").format(
            shift=in_micrometres(self._page.get(self._page.panel.values, "shift-size", 0.0))), []), _("Change the reference"),
            lambda: self._give(NOT_GROWTH, _("It is not growth")), must_be_safe=False)

    def _is_growth(self):
        """In a program that waits for the answer, Z may move."""
        page, values = self._page, self._page.panel.guard.values()
        must_be_safe = bool(self._moves(values)) and not page.get(values, "wait", False)
        page.panel.guard.once_asked(lambda: (" ".join((_("Correct the shift as growth?"), self._effect(page.panel.guard.values()))), []), _("Correct it"),
                                    lambda: self._give(GROWTH, _("It is growth")), must_be_safe=must_be_safe)

    def _give(self, short, action):
        """By the pin, or by the digital output that the configuration has netted to it."""
        page = self._page
        pin, panel = page.instance.full(short), page.panel
        output = re.fullmatch(r"motion\.digital-out-(\d+)", panel.machine.writer(pin))
        if output:
            number = int(output[1])
            panel.mdi("M64 P%d" % number, action, done=lambda: panel.mdi("M65 P%d" % number, action))
        else:
            panel.pulse(pin)


class OriginQuestion(Question):
    """Why a work offset or a tool length has changed."""

    def __init__(self, page):
        texts = (
            (ZERO, _("New zero, or tool measured"), _("The work or the tool has moved by as much. The reference follows.")),
            (BY_HAND, _("Growth corrected by hand"), _("The offset becomes smaller by as much at the next cycle, so that it counts once.")),
            (DEPTH, _("Another depth"), _("The parts keep the new depth, and the offset does not change.")),
        )
        super().__init__(page, *[(name, lambda pin=pin, name=name: self._give(pin, name), label(effect, "soft")) for pin, name, effect in texts])

    def show_question(self, values):
        size = self._page.get(values, "origin-change", 0.0)
        self._ask(_("Work offset or tool length of Z has changed by {change}. Why?").format(change=in_micrometres(size)) if size else "", values)

    def _give(self, pin, name):
        self._page.panel.guard.once_asked(lambda: (_("{reason}: is that right?").format(reason=name), []), name,
                                          lambda: self._page.panel.pulse(self._page.instance.full(pin)), must_be_safe=False)

# SPDX-License-Identifier: GPL-2.0-or-later
"""thermal_displacement: growth and offset over hours, contacts, and the buttons of the operator."""

import collections
import json
import time

from panel import effects, growth_state, references
from panel.chart import Chart, History
from panel.function_page import FunctionPage
from panel.growth_question import OriginQuestion, ShiftQuestion
from panel.growth_state import learning_steps
from panel.inputs import LoadBar
from panel.settings import REFERENCE, Write
from panel.texts import _, in_micrometres
from panel.widgets import Figures, button, card, clear, column, label, set_text

CONTACTS = 8  # shown in the list

_histories = {}  # by instance: pages are built again when components come


class GrowthPage(FunctionPage):
    function = "thermal_displacement"
    place = 1
    live = ("load", "z-position", "spindle-speed-cmd", "temperature")

    def content(self):
        history, contacts = _histories.setdefault(self.instance.name, (History(), collections.deque(maxlen=CONTACTS)))
        self._history, self._contacts, self._listed, self._seen = history, contacts, None, None
        self._figures = Figures(_("Growth"), _("Offset wanted"), _("Offset in force"), _("Uncertainty (k=2)"))
        scale = 25400.0 if self.panel.ini.get("TRAJ", "LINEAR_UNITS").lower().startswith("in") else 1000.0
        self._chart = Chart(self.panel, history, (_("Growth"), _("Offset in force")), "\u00b5m", scale)
        self._reference = label("", "soft")
        self._steps = label("")
        self._list = column(spacing=2)
        self._load = LoadBar(self.panel)
        self._questions = OriginQuestion(self), ShiftQuestion(self)
        return [*self._questions, self._figures, self._load, self._chart, card(label(_("Reference"), "value"), self._reference, self._steps),
                card(label(_("Last contacts"), "value"), self._list)]

    def buttons(self):
        its = [self.remedy("learn", button(_("Learn from the next part"), self._learn))]
        if "dry-run" in self.instance.settings():
            its.append(self.remedy("dry-run", button(_("Measure only on / off"), self._dry_run)))
        its.append(button(_("Take the offset back"), self._take_back))
        if "acknowledge" in self.instance.settings():
            its.append(self.remedy("acknowledge", button(_("Acknowledge"), self._acknowledge)))
        return its

    def observe(self, values):
        """Called at each look, seen or not: the history goes on behind other pages."""
        get = lambda short: self.get(values, short)  # noqa: E731
        added = self._history.add(float(get("growth-estimate")), float(get("applied-offset")))
        counted = get("contacts"), get("contacts-rejected")
        if self._seen is not None and counted[0] > self._seen[0]:
            rejected = counted[1] > self._seen[1]
            why = self.instance.sentence(values, "detail-code") if rejected else ""
            kind = _("learned") if get("learning") else _("accepted")
            self._contacts.appendleft((time.strftime("%H:%M:%S"), float(get("displacement")), float(get("displacement-sigma")), why, kind))
            self._history.mark(float(get("displacement")), float(get("displacement-sigma")), not rejected)
            added = True
        self._seen = counted
        if added and self.panel.page is self:
            self._chart.queue_draw()

    def entered(self):
        self._chart.queue_draw()

    def refresh(self, values):
        super().refresh(values)
        known = self.get(values, "growth-known", True)
        self._figures.show_value(_("Growth"), in_micrometres(float(self.get(values, "growth-estimate"))) if known else _("unknown"))
        for name, short in ((_("Offset wanted"), "z-offset"), (_("Offset in force"), "applied-offset")):
            self._figures.show_value(name, in_micrometres(float(self.get(values, short))))
        self._load.show_load(float(self.get(values, "load")), float(self.get(values, "threshold")), bool(self.get(values, "load-valid", True)))
        sigma = in_micrometres(2 * float(self.get(values, "offset-sigma"))).lstrip("+")
        self._figures.show_value(_("Uncertainty (k=2)"), "\u00b1" + sigma if known else _("unknown"))
        for question in self._questions:
            question.show_question(values)
        set_text(self._reference, growth_state.reference(self.instance, values))
        steps = learning_steps(self.instance, values)
        busy = self.get(values, "learn") or self.get(values, "learning")
        set_text(self._steps, "\n".join("%s %s" % ("\u2714" if done else "\u25cb", text) for text, done in steps) if busy else "")
        self._steps.set_visible(bool(busy))
        self._show_contacts()

    def _show_contacts(self):
        if self._listed == list(self._contacts):
            return
        self._listed = list(self._contacts)
        clear(self._list)
        for when, growth, sigma, why, kind in self._contacts:
            text = "%s   %s \u00b1%s   %s" % (when, in_micrometres(growth), in_micrometres(2 * sigma).lstrip("+"),
                                              "\u2716 " + _(why) if why else "\u2714 " + kind)
            self._list.pack_start(label(text), False, False, 0)
        self._list.show_all()

    # --- buttons ---

    def _learn(self):
        def question():
            values = self.panel.guard.values()
            text = _("Learn from the next part? The machine must be cold while no growth is known: it counts from there. Growth that is known is subtracted.")
            rows, moves = self.get(values, "rows"), effects.effect(self.panel.machine, [Write(self.instance, "learn", "1")], values)
            if rows:
                text += " " + _("A kept reference of this program is replaced; {count} contacts are kept.").format(count=rows)
            return text if moves else text + " " + _("Nothing moves now."), moves

        by_pin = "learn" in self.instance.settings()

        def learn():
            """The list of changes has the reference that the new one replaces."""
            records = references.read(self.panel.hal, self.instance)
            former = [(self.instance.name + REFERENCE, json.dumps(records), "")] if records else []
            if by_pin:
                self.panel.write(self.instance.full("learn"), "1", "learn", together=former)
            else:
                self.panel.mdi("M64 P2", _("Learn"), undo="M65 P2", together=former)

        self.panel.guard.once_asked(question, _("Learn"), learn, must_be_safe=not by_pin)

    def _dry_run(self):
        on = self.panel.hal.get(self.instance.full("dry-run"))
        text = _("Correct? Z follows the growth from the next cycle on.") if on else _("Measure only, and move Z no more?")
        self.panel.guard.change([Write(self.instance, "dry-run", "0" if on else "1")], _("Correct") if on else _("Measure only"), why="switch",
                                needed="operator", question=text, must_be_on=bool(on))

    def _take_back(self):
        def question():
            return _("Take the offset back?"), [effects.Move("Z", -float(self.get(self.panel.guard.values(), "applied-offset")), True)]

        self.panel.guard.once_asked(question, _("Take back"),
                                    lambda: self.panel.mdi("O <take_back> call", _("Take back")))

    def _acknowledge(self):
        self.panel.guard.at_once(_("Acknowledge"), lambda: self.panel.pulse(self.instance.full("acknowledge")))

# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a function: verdict, figures, buttons, and the way to all its pins."""

from panel.pages import Page, state_of
from panel.texts import _
from panel.widgets import Verdict, button, column, flow, label, scrolled


class FunctionPage(Page):
    heading = ""  # of the function, for the page and the navigation

    def __init__(self, panel, instance):
        self.instance = instance
        self.switch = panel.machine.switch_of(instance)
        super().__init__(panel)

    @property
    def key(self):
        return self.instance.module

    @property
    def title(self):
        alone = len(self.panel.machine.of(self.instance.module)) == 1
        return _(self.heading) if alone else "%s %s" % (_(self.heading), self.instance.name)

    def verdict(self, values):
        kind, text = state_of(self.instance, values)
        if kind == "good" and self.switch and not values.get(self.switch):
            return "off", _("Switched off.")
        return kind, text

    def build(self):
        self._verdict = Verdict()
        content = self.content()
        buttons = self.buttons()
        if self.switch and self.switch in self.panel.machine.pins and not self.panel.machine.pins[self.switch].signal:
            buttons += [button(_("Switch on / off"), self._toggle)]
        buttons.append(button(_("All pins and settings"), lambda: self.panel.open_component(self.instance)))
        return scrolled(column(label(self.title, "title"), self._verdict, flow(*buttons), *content))

    def content(self):
        return []

    def buttons(self):
        return []

    def get(self, values, short, otherwise=0):
        value = self.instance.value(values, short, otherwise)
        return otherwise if value is None else value

    def refresh(self, values):
        self._verdict.show_verdict(*self.verdict(values))

    def _toggle(self):
        on = bool(self.panel.hal.get(self.switch))
        action = _("Switch off") if on else _("Switch on")
        text = (_("Switch {name} off? Its offset returns to 0: the axes move by it.") if on
                else _("Switch {name} on? Its offset comes into force: the axes move by it.")).format(name=self.title)
        owner, short = self.panel.machine.owner_of(self.switch)
        self.panel.move(text, action, lambda: self.panel.settings.change(owner, short, "0" if on else "1", why="switch"))

# SPDX-License-Identifier: GPL-2.0-or-later
"""The page of a function: verdict, figures, buttons, and the way to all its pins."""

from panel import status
from panel.inputs import LiveInputs
from panel.pages import Page
from panel.texts import _
from panel.widgets import Verdict, button, column, emphasize, flow, label, scrolled


class FunctionPage(Page):
    function = ""  # the module that the page is about
    place = 100  # in the navigation
    live = ()  # the inputs that are shown as they are now

    def __init__(self, panel, instance):
        self.instance = instance
        self.switch = panel.machine.switch_of(instance)
        self._remedies = []
        super().__init__(panel)

    @property
    def key(self):
        return self.instance.module

    @property
    def title(self):
        return self.panel.machine.title_of(self.instance)

    def verdict(self, values):
        return status.kind_and_words(self.instance, values)

    def build(self):
        self._verdict = Verdict()
        content = self.content()
        buttons = self.buttons()
        if self.switch:
            buttons.append(self.remedy("switch", button(_("Switch on / off"), self._toggle)))
        buttons.append(button(_("All pins and settings"), lambda: self.panel.open_component(self.instance)))
        self._inputs = LiveInputs(self.panel, self.instance, self.live)
        return scrolled(column(label(self.title, "title"), self._verdict, flow(*buttons), *content, self._inputs))

    def content(self):
        return []

    def buttons(self):
        return []

    def remedy(self, name, its):
        """A button that ends a status, by its name in the declaration (hal/status.hpp): it stands out while the function has this status."""
        self._remedies.append((name, its))
        return its

    def get(self, values, short, otherwise=0):
        value = self.instance.value(values, short, otherwise)
        return otherwise if value is None else value

    def refresh(self, values):
        self._verdict.show_verdict(*self.verdict(values))
        wanted = status.of(self.instance, values).button
        for name, its in self._remedies:
            emphasize(its, name == wanted)
        self._inputs.show_values(values)

    def _toggle(self):
        is_on = self.panel.machine.switch_text(self.switch, True) == str(int(self.panel.hal.get(self.switch)))
        self.panel.guard.switch(self.switch, not is_on, self.title)

    def of(self):
        """The component that the page is about."""
        return self.instance.name


class PlainPage(FunctionPage):
    """The page of a function that has no page of its own."""

    def __init__(self, panel, instance):
        self.live = instance.inputs()
        super().__init__(panel, instance)


class EntryPage(Page):
    """A page that leads back to the page of its function, `page`."""

    page = None

    def of(self):
        return self.page.instance.name

# SPDX-License-Identifier: GPL-2.0-or-later
"""Several numbers beside one keypad: a touch on a line chooses the number that the keys change."""

import math

from panel.texts import _
from panel.widgets import Keypad, button, choose, column, grow, label, row


class EntryForm:
    """fields: (name, text at the start); words: a sentence above them; changed() is called after each key."""

    def __init__(self, fields, words="", changed=lambda: None):
        self.texts, self._buttons, self._chosen, self._tell = dict(fields), {}, None, changed
        self._keypad = Keypad("")
        self._keypad.entry.connect("changed", lambda _entry: self._changed())
        for name in self.texts:
            self._buttons[name] = button("", lambda name=name: self.choose(name), name=name)
        left = column(*([label(words)] if words else []), *self._buttons.values(), spacing=4)
        self.widget = row(grow(left), grow(self._keypad), spacing=16)
        self.choose(next(iter(self.texts)))

    def choose(self, name):
        self._chosen = None
        self._keypad.entry.set_text(self.texts[name])
        self._chosen = name
        self._show()

    def put(self, name, text):
        """Gives a field a text that nobody typed, and chooses it."""
        self.texts[name] = text
        self.choose(name)

    def _changed(self):
        if self._chosen:
            self.texts[self._chosen] = self._keypad.text
            self._show()
            self._tell()

    def _show(self):
        for name, its in self._buttons.items():
            its.get_child().set_text("%s: %s" % (name, self.texts[name] or "?"))
            choose(its, name == self._chosen)

    def lacking(self):
        """The first field without a text, as a request; '' if all have one."""
        name = next((name for name, text in self.texts.items() if not text), "")
        return _("Enter {name}.").format(name=name) if name else ""

    def number(self, name):
        """Raises ValueError with a sentence."""
        try:
            value = float(self.texts[name].replace(",", "."))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ValueError(_("{name}: \"{text}\" is no number.").format(name=name, text=self.texts[name]))
        return value

# SPDX-License-Identifier: GPL-2.0-or-later
"""Messages and questions below the page. They end with the page that they came from."""

from gi.repository import Gtk

from panel import style as styles
from panel.texts import _
from panel.widgets import button, clear, column, flow, grow, label, named, row, style


class Messages(Gtk.Box):
    def __init__(self):
        super().__init__(orientation=Gtk.Orientation.VERTICAL, spacing=6)
        style(self, "message")
        self.set_no_show_all(True)

    def say(self, text, kind="good"):
        """A message, until it is closed, another one comes, or another page is opened."""
        words = label(styles.SYMBOL[kind] + "  " + text, kind)
        self._show(row(grow(words), button(_("Close"), self.hush)))
        named(words, text)

    def ask(self, text, action, do):
        """Asks once; do() is called after a yes."""
        def yes():
            self.hush()
            do()

        self._show(column(label("\u25b2  " + text, "warn"), flow(button(action, yes, "main"), button(_("Cancel"), self.hush))))

    def _show(self, content):
        clear(self)
        self.pack_start(content, False, False, 0)
        self.set_no_show_all(False)
        self.show_all()

    def hush(self):
        clear(self)
        self.hide()
        self.set_no_show_all(True)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Widgets that all pages share. Each has an accessible name."""

import time

import gi

gi.require_version("Gtk", "3.0")
from gi.repository import Gtk, Pango  # noqa: E402

from panel.style import SYMBOL  # noqa: E402
from panel.texts import _  # noqa: E402


def style(widget, *classes):
    for name in classes:
        widget.get_style_context().add_class(name)
    return widget


def named(widget, name):
    widget.get_accessible().set_name(name)
    return widget


def label(text="", *classes, wrap=True, chars=0):
    widget = Gtk.Label(label=text, xalign=0)
    if wrap:
        widget.set_line_wrap(True)
        widget.set_line_wrap_mode(Pango.WrapMode.WORD_CHAR)
        if chars:
            widget.set_max_width_chars(chars)
    return style(widget, *classes)


def set_text(widget, text):
    """Only if it is another one: a new text draws the widget again."""
    if widget.get_text() != text:
        widget.set_text(text)


AGAIN, ELSEWHERE = 200, 450  # ms, within which a second press is no order: at the same button, and at one that came under the finger
NEAR = 24  # px
UNSEEN = 0.2  # s, for which a button must have been on the screen: a finger that comes sooner meant the page before
_last = {"time": 0, "place": (0, 0), "widget": None}


def is_new(widget):
    """Whether a button came to the screen just now."""
    return widget.since is None or time.monotonic() - widget.since < UNSEEN


def _is_meant(widget, repeats):
    """False for the second half of a double press; it may meet another button where the first one has opened a page or ended a question.
    False also for a press on a button that nobody can have seen yet."""
    if is_new(widget):
        return False
    event = Gtk.get_current_event()
    found, x, y = event.get_root_coords() if event else (False, 0, 0)
    if not found:
        return True
    now, same = event.get_time(), _last["widget"] is widget
    since = now - _last["time"]
    near = abs(x - _last["place"][0]) < NEAR and abs(y - _last["place"][1]) < NEAR
    if 0 <= since < (AGAIN if same else ELSEWHERE) and near and not (same and repeats):
        return False
    _last.update(time=now, place=(x, y), widget=widget)
    return True


def _came(widget):
    """It is seen from its first drawing on, which comes after the presses that wait."""
    def drawn(*_arguments):
        widget.since = time.monotonic()
        widget.disconnect(handler)

    if widget.since is not None:
        widget.since = None
        handler = widget.connect("draw", drawn)


def button(text, pressed, *classes, name=""):
    widget = Gtk.Button()
    words = Gtk.Label(label=text, justify=Gtk.Justification.CENTER)
    words.set_line_wrap(True)
    words.set_max_width_chars(18)  # longer words break, and buttons stand side by side
    widget.add(words)
    widget.since = 0.0
    widget.connect("map", _came)
    widget.connect("clicked", lambda its: _is_meant(its, "key" in classes) and pressed())
    widget.set_can_focus(False)  # keys belong to the screen around it
    named(widget, name or text.replace("\n", " "))
    return style(widget, *classes)


def choose(widget, chosen):
    """Shows a button as the chosen one of several."""
    context = widget.get_style_context()
    (context.add_class if chosen else context.remove_class)("chosen")


def emphasize(widget, wanted=True):
    """Shows a button as the one that leads on."""
    context = widget.get_style_context()
    (context.add_class if wanted else context.remove_class)("main")


def column(*children, spacing=8):
    return _boxed(Gtk.Orientation.VERTICAL, children, spacing)


def row(*children, spacing=8):
    return _boxed(Gtk.Orientation.HORIZONTAL, children, spacing)


def _boxed(orientation, children, spacing):
    box = Gtk.Box(orientation=orientation, spacing=spacing)
    for child in children:
        box.pack_start(child, getattr(child, "grows", False), True, 0)
    return box


def grow(widget):
    widget.grows = True
    widget.set_hexpand(True)
    return widget


def card(*children, spacing=6):
    return style(column(*children, spacing=spacing), "card")


def scrolled(child):
    window = Gtk.ScrolledWindow()
    window.set_policy(Gtk.PolicyType.NEVER, Gtk.PolicyType.AUTOMATIC)
    window.set_kinetic_scrolling(True)
    window.set_overlay_scrolling(False)
    child.set_margin_end(10)
    window.add(child)
    window.grows = True
    window.set_vexpand(True)
    return window


def flow(*children):
    """Children side by side, as many as fit."""
    box = Gtk.FlowBox(selection_mode=Gtk.SelectionMode.NONE, homogeneous=True, min_children_per_line=1, max_children_per_line=4, column_spacing=8, row_spacing=8)
    for child in children:
        box.add(child)
        child.get_parent().set_can_focus(False)
    return box


def clear(box):
    for child in box.get_children():
        child.destroy()


class Verdict(Gtk.Box):
    """A symbol and one sentence: good, warn, bad or off."""

    def __init__(self):
        super().__init__(orientation=Gtk.Orientation.HORIZONTAL, spacing=12)
        self._symbol = label("", "big", wrap=False)
        self._words = grow(label("", "verdict"))
        self._kind = None
        self.pack_start(self._symbol, False, False, 0)
        self.pack_start(self._words, True, True, 0)
        style(self, "card")

    def show_verdict(self, kind, text):
        if kind != self._kind:
            for widget in (self._symbol, self._words):
                for name in ("good", "warn", "bad", "wait", "off"):
                    widget.get_style_context().remove_class(name)
                style(widget, kind)
            self._kind = kind
        set_text(self._symbol, SYMBOL[kind])
        set_text(self._words, text)

    @property
    def text(self):
        return self._words.get_text()


class Figures(Gtk.FlowBox):
    """Large values with their names below: figures.show_value("growth", "+12.3 um")."""

    def __init__(self, *names):
        super().__init__(selection_mode=Gtk.SelectionMode.NONE, homogeneous=True, min_children_per_line=2, max_children_per_line=4,
                         column_spacing=4, row_spacing=4)
        self._values = {}
        for name in names:
            value = label("", "figure", wrap=False)
            self._values[name] = value
            self.add(card(value, label(name, "soft", chars=14), spacing=0))
        for child in self.get_children():
            child.set_can_focus(False)

    def show_value(self, name, text):
        set_text(self._values[name], text)
        if self._values[name].get_accessible().get_name() != name + ": " + text:
            named(self._values[name], name + ": " + text)


KEYS = ("789\u232b", "456\u00b1", "123.", "0e")


class Keypad(Gtk.Grid):
    """An entry and keys for fingers; only numbers that may be very small need an exponent."""

    def __init__(self, text="", whole=False, exponent=False):
        super().__init__(column_spacing=6, row_spacing=6)
        self.entry = named(Gtk.Entry(text=text), _("Value"))
        self.entry.set_hexpand(True)
        self.attach(self.entry, 0, 0, 4, 1)
        for line, keys in enumerate(KEYS, start=1):
            for place, key in enumerate(keys):
                if (key == "." and whole) or (key == "e" and not exponent):
                    continue
                its = button(key, lambda key=key: self.press(key), "key",
                             name={"\u232b": _("Delete"), "\u00b1": _("Sign"), "e": _("Exponent")}.get(key, key))
                its.set_hexpand(True)
                its.set_size_request(64, 52)
                self.attach(its, place, line, 2 if key == "0" and not exponent else 1, 1)
        empty = button(_("Clear"), lambda: self.entry.set_text(""))
        self.attach(empty, 2, 4, 2, 1)

    @property
    def text(self):
        return self.entry.get_text().replace("\u2212", "-")

    def press(self, key):
        text = self.text
        if key == "\u232b":
            text = text[:-1]
        elif key == "\u00b1":
            text = text[1:] if text.startswith("-") else "-" + text
        else:
            text += key
        self.entry.set_text(text)

# SPDX-License-Identifier: GPL-2.0-or-later
"""A file with the accessible names, texts and places of all widgets that are seen, for tests that press them."""

import json
import os

from gi.repository import Gtk

from panel.widgets import is_new

# Widgets that take input, and widgets that show a text or a picture.
LISTED = (Gtk.Actionable, Gtk.Editable, Gtk.Range, Gtk.ComboBox, Gtk.Expander, Gtk.EventBox, Gtk.DrawingArea, Gtk.Label)


class WidgetList:
    def __init__(self, path, window):
        self._path, self._window, self._looks = path, window, 0

    def write(self, is_seen):
        """With the number of looks, so that a test can wait for the next one; nobody reads half of it."""
        surface = self._window.get_window()
        if surface is None:
            return
        _, left, top = surface.get_origin()
        found = []
        self._walk(self._window, left, top, found, None)
        self._looks += 1
        text = json.dumps({"looks": self._looks, "seen": is_seen, "widgets": found})  # json.dump takes ten times as long
        with open(self._path + ".new", "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(self._path + ".new", self._path)

    def _walk(self, widget, left, top, found, view):
        if not widget.get_mapped() or widget.get_allocated_width() <= 1:
            return
        if isinstance(widget, LISTED) and not isinstance(widget, Gtk.Scrollbar):
            place = widget.translate_coordinates(self._window, 0, 0) or (0, 0)
            entry = {"kind": type(widget).__name__, "name": widget.get_accessible().get_name() or "",
                     "x": left + place[0], "y": top + place[1],
                     "width": widget.get_allocated_width(), "height": widget.get_allocated_height()}
            if isinstance(widget, Gtk.Button):
                entry["new"] = is_new(widget)
                entry["main"] = widget.get_style_context().has_class("main")
            if isinstance(widget, (Gtk.Label, Gtk.Entry)):
                entry["text"] = widget.get_text()
            if isinstance(widget, Gtk.Label):
                entry["cut"] = widget.get_layout().is_ellipsized() or widget.get_layout().get_pixel_size()[0] > widget.get_allocated_width() + 1
            middle = entry["y"] + entry["height"] // 2
            entry["scrolled"] = 0 if view is None or view[0] <= middle < view[1] else 1 if middle >= view[1] else -1
            if view:
                entry["view"] = view
            found.append(entry)
        if isinstance(widget, Gtk.ScrolledWindow):
            place = widget.translate_coordinates(self._window, 0, 0) or (0, 0)
            view = (top + place[1], top + place[1] + widget.get_allocated_height())
        if isinstance(widget, Gtk.Container):
            for child in widget.get_children():  # forall() would keep 2 kB at each look
                self._walk(child, left, top, found, view)

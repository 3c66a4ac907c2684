# SPDX-License-Identifier: GPL-2.0-or-later
"""The window: navigation on the left, a page on the right, messages and questions below."""

from gi.repository import Gdk, GLib, Gtk

from panel import style as styles
from panel.embedding import forward_keys, is_viewable, put_into
from panel.messages import Messages
from panel.texts import _
from panel.widgets import button, choose, clear, column, grow, label, row, scrolled, set_text, style

NARROW = 760  # px
SIDE = 184  # px
ROW = 4  # names of pages in a row, where it is narrow


class Window:
    """dark is the theme; into is the window of a screen around it, or None."""

    def __init__(self, size, into, dark, closed):
        self.dark, self._into = dark, into
        self.gtk = Gtk.Window(title="Plumb") if into is None else Gtk.Plug.new(into)
        self.gtk.set_default_size(*size)
        self.gtk.connect("destroy", lambda _window: closed())
        self._css = Gtk.CssProvider()
        Gtk.StyleContext.add_provider_for_screen(Gdk.Screen.get_default(), self._css, Gtk.STYLE_PROVIDER_PRIORITY_APPLICATION)
        self._buttons, self._names, self._navigation = {}, Gtk.Grid(row_spacing=4, column_spacing=4, column_homogeneous=True), []
        navigation = scrolled(self._names)
        navigation.grows = False
        navigation.set_hexpand(False)
        navigation.set_size_request(SIDE, -1)
        self._stack = Gtk.Box(orientation=Gtk.Orientation.VERTICAL)
        self._stack.set_border_width(8)
        self._stack.grows = True
        self.messages = Messages()
        self._standstill = style(label(""), "bad", "message")
        self._standstill.set_no_show_all(True)
        content = row(navigation, grow(self._stack), spacing=0)
        content.grows = True
        self._sides = content, navigation
        self.gtk.connect("size-allocate", lambda _window, place: self._arrange(place.width))
        self.gtk.add(style(column(content, self._standstill, self.messages, spacing=0), "plumb"))
        if into is None and size[0] < NARROW:
            self._put_navigation(True)  # before the window takes the width that the other arrangement needs
        self._theme()

    def _arrange(self, width):
        """Where it is narrow, the navigation stands in rows above the page: all of it is seen, also where a screen covers a part of the panel."""
        narrow = width < NARROW
        if narrow != (self._sides[0].get_orientation() == Gtk.Orientation.VERTICAL):
            GLib.idle_add(self._put_navigation, narrow)  # not while places are given out

    def _put_navigation(self, narrow):
        content, navigation = self._sides
        content.set_orientation(Gtk.Orientation.VERTICAL if narrow else Gtk.Orientation.HORIZONTAL)
        self._place_names(narrow)
        navigation.set_policy(Gtk.PolicyType.NEVER, Gtk.PolicyType.NEVER if narrow else Gtk.PolicyType.AUTOMATIC)
        navigation.set_size_request(-1 if narrow else SIDE, -1)
        navigation.set_vexpand(not narrow)
        return False

    def _place_names(self, narrow):
        for child in self._names.get_children():
            self._names.remove(child)
        for place, its in reversed(list(enumerate(self._navigation))):  # a grid goes through them backwards
            self._names.attach(its, place % ROW if narrow else 0, place // ROW if narrow else place, 1, 1)
            its.set_hexpand(True)
            context = its.get_style_context()
            (context.add_class if narrow else context.remove_class)("narrow")
        self._names.show_all()

    def _theme(self):
        Gtk.Settings.get_default().set_property("gtk-application-prefer-dark-theme", self.dark)
        Gtk.Settings.get_default().set_property("gtk-enable-animations", False)
        self._css.load_from_data(styles.css(self.dark).encode())

    def toggle_theme(self):
        self.dark = not self.dark
        self._theme()
        self.gtk.queue_draw()

    def show(self, by_number):
        """With its number on the standard output, where the screen around it asks for that."""
        self.gtk.show_all()
        if self._into is not None or by_number:
            Gdk.error_trap_push()  # the screen around it may end first, and its windows with it
        if self._into is not None:
            put_into(self.gtk, self._into)
            forward_keys(self.gtk)
        if by_number:
            print(self.gtk.get_window().get_xid(), flush=True)  # QtDragon reads this line, and never again

    def show_navigation(self, pages, opened):
        self._clear_navigation()
        for page in pages:
            its = button(page.title, lambda page=page: opened(page))
            self._buttons[page] = its
            self._navigation.append(its)
        self._place_names(self._sides[0].get_orientation() == Gtk.Orientation.VERTICAL)

    def _clear_navigation(self):
        clear(self._names)
        self._buttons, self._navigation = {}, []

    def show_page(self, page):
        """Old questions and messages go with the page that they came from."""
        self.messages.hush()
        self._empty()
        page.widget.set_vexpand(True)
        self._stack.pack_start(page.widget, True, True, 0)
        first = page
        while getattr(first, "back", None) is not None:
            first = first.back
        for each, its in self._buttons.items():
            choose(its, each is first)
        page.widget.show_all()

    def show_sentence(self, text):
        """Instead of pages. Within a view: alone in the window, a label that breaks its lines would make the window taller than a screen."""
        self.messages.hush()
        self._clear_navigation()
        self._empty()
        sentence = label(text, "title")
        sentence.set_margin_top(40)
        self._stack.pack_start(scrolled(sentence), True, True, 0)
        self._stack.show_all()

    def _empty(self):
        for child in self._stack.get_children():
            self._stack.remove(child)

    def show_standstill(self, text):
        """Why the values are old; '' if they are not."""
        set_text(self._standstill, styles.SYMBOL["bad"] + "  " + text)
        self._standstill.set_visible(bool(text))

    def is_seen(self):
        """Whether the window and all around it are on the screen."""
        window = self.gtk.get_window()
        if window is None:
            return False
        if self._into is None:
            return not window.get_state() & Gdk.WindowState.ICONIFIED
        try:
            return is_viewable(window.get_xid())
        except Exception:  # the screen around it is closing
            return False

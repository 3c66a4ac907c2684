# SPDX-License-Identifier: GPL-2.0-or-later
"""The window: navigation on the left, a page on the right, messages and questions below."""

import os
import signal
import sys
import threading
import time
import traceback

import gi

gi.require_version("Gtk", "3.0")
gi.require_version("Gdk", "3.0")
from gi.repository import Gdk, GLib, Gtk  # noqa: E402

from panel import access, hal_files, style as styles, texts  # noqa: E402
from panel.function_pages import function_pages  # noqa: E402
from panel.hal_access import Hal, HalGone  # noqa: E402
from panel.machine import Machine  # noqa: E402
from panel.pages import Changes, Component, Components, Edit, Overview, Sensors  # noqa: E402
from panel.settings import Refused, Settings  # noqa: E402
from panel.texts import _  # noqa: E402
from panel.widget_list import WidgetList  # noqa: E402
from panel.widgets import button, clear, column, flow, grow, label, named, row, scrolled, style  # noqa: E402

NARROW = 640  # px
STANDSTILL = 20  # s
ORPHANED = 5000  # ms until a panel within another screen ends after LinuxCNC
HIDDEN_PERIOD = 4  # looks of which one is done while the panel is hidden


class Panel:
    def __init__(self, options, ini, declared):
        self.options, self.ini, self.declared = options, ini, declared
        self.access = access.Access(options.access or ini.get("PLUMB", "ACCESS", "operator"))
        self.dark = (options.theme or ini.get("PLUMB", "THEME", "light")) == "dark"
        texts.MACHINE_UNIT[0] = "in" if ini.get("TRAJ", "LINEAR_UNITS").lower() in ("in", "inch", "imperial") else "mm"
        folder = ini.folder or os.environ.get("XDG_RUNTIME_DIR") or os.path.expanduser("~")
        self.hal, self.values, self.machine, self._names, self._looks = None, {}, None, None, 0
        self.settings = Settings(None, folder, options.user or texts.system_user(), ini.get("EMC", "MACHINE"))
        self.settings.kept_file = os.path.join(folder, ini.get("PLUMB", "SETTINGS", "panel.toml"))
        self.hal_file_values = hal_files.values_of_hal_files(ini) if ini.path else {}
        self.page = None
        self._beats, self._beaten, self._stands = None, time.monotonic(), False
        self._build()
        self._list = WidgetList(options.widgets, self.window) if options.widgets else None
        self._connect()
        GLib.timeout_add(options.period, self._tick)

    # --- the window ---

    def _build(self):
        options = self.options
        self.window = Gtk.Window(title="Plumb") if options.into is None else Gtk.Plug.new(options.into)
        self.window.set_default_size(*options.size)
        self.window.connect("destroy", lambda _window: Gtk.main_quit())
        self._css = Gtk.CssProvider()
        Gtk.StyleContext.add_provider_for_screen(Gdk.Screen.get_default(), self._css, Gtk.STYLE_PROVIDER_PRIORITY_APPLICATION)
        self._navigation = column(spacing=4)
        navigation = scrolled(self._navigation)
        navigation.grows = False
        navigation.set_hexpand(False)
        navigation.set_size_request(184, -1)
        self._stack = Gtk.Box(orientation=Gtk.Orientation.VERTICAL)
        self._stack.set_border_width(8)
        self._stack.grows = True
        self._message = style(Gtk.Box(orientation=Gtk.Orientation.VERTICAL, spacing=6), "message")
        self._message.set_no_show_all(True)
        text = _("The realtime threads stand still: these values are old. Is LinuxCNC still alive?")
        self._standstill = style(label(styles.SYMBOL["bad"] + "  " + text), "bad", "message")
        self._standstill.set_no_show_all(True)
        content = row(navigation, grow(self._stack), spacing=0)
        content.grows = True
        self._sides, self._narrow = (content, navigation), False
        self.window.connect("size-allocate", lambda _window, place: self._arrange(place.width))
        box = style(column(content, self._standstill, self._message, spacing=0), "plumb")
        self.window.add(box)
        self._theme()

    def _arrange(self, width):
        """Where it is narrow, the navigation is a row above the page."""
        content, navigation = self._sides
        wanted = Gtk.Orientation.VERTICAL if width < NARROW else Gtk.Orientation.HORIZONTAL
        if content.get_orientation() == wanted:
            return
        narrow = wanted == Gtk.Orientation.VERTICAL

        def change():
            content.set_orientation(wanted)
            self._navigation.set_orientation(Gtk.Orientation.HORIZONTAL if narrow else Gtk.Orientation.VERTICAL)
            self._navigation.set_valign(Gtk.Align.START if narrow else Gtk.Align.FILL)
            policies = (Gtk.PolicyType.AUTOMATIC, Gtk.PolicyType.NEVER) if narrow else (Gtk.PolicyType.NEVER, Gtk.PolicyType.AUTOMATIC)
            navigation.set_policy(*policies)
            navigation.set_size_request(-1 if narrow else 184, -1)
            navigation.set_vexpand(not narrow)
            self._narrow = narrow
            self._wrap_navigation()
            return False

        GLib.idle_add(change)  # not while places are given out

    def _wrap_navigation(self):
        """Words of a row stand in one line; they would break after each letter."""
        for child in self._navigation.get_children():
            words = child if isinstance(child, Gtk.Label) else child.get_child()
            words.set_line_wrap(not self._narrow)

    def _theme(self):
        Gtk.Settings.get_default().set_property("gtk-application-prefer-dark-theme", self.dark)
        Gtk.Settings.get_default().set_property("gtk-enable-animations", False)
        self._css.load_from_data(styles.css(self.dark).encode())

    def _toggle_theme(self):
        self.dark = not self.dark
        self._theme()
        self.window.queue_draw()

    def show(self):
        self.window.show_all()
        if self.options.into is not None or self.options.xid:
            Gdk.error_trap_push()  # the screen around it may end first, and its windows with it
        if self.options.into is not None:
            _into(self.window, self.options.into)
            _forward_keys(self.window)
        if self.options.xid:
            print(self.window.get_window().get_xid(), flush=True)  # QtDragon reads this line, and never again
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) == signal.SIG_IGN:
                continue  # as under nohup
            GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, number, Gtk.main_quit)

    # --- HAL ---

    def _connect(self):
        try:
            self.hal = self.settings.hal = Hal()
        except HalGone:
            self.hal = None
            self._alone(_("LinuxCNC does not run here. This screen waits for it."))
            return
        self._discover(self.hal.values())

    def _discover(self, values):
        """Builds the pages of the functions that there are."""
        try:
            self.machine = Machine(self.hal.pins(), self.declared)
        except HalGone as gone:
            self._alone(str(gone))
            return
        self._names, self.values = values.keys(), values
        former = self.page.title if self.page else None
        self.function_pages = function_pages(self)
        if self.machine.channels:
            self.function_pages.append(Sensors(self))
        self.pages = [Overview(self), *self.function_pages, Components(self), Changes(self)]
        self._rebuild_navigation()
        self.open(next((page for page in self.pages if page.title == former), self._first_page()))

    def _first_page(self):
        wanted = self.options.page
        return next((page for page in self.pages if wanted and wanted in (page.title, getattr(page, "key", ""))), self.pages[0])

    def _rebuild_navigation(self):
        clear(self._navigation)
        self._buttons = {}
        for page in self.pages:
            its = button(page.title, lambda page=page: self.open(page))
            self._buttons[page] = its
            self._navigation.pack_start(its, False, False, 0)
        theme = button(_("Light / dark"), self._toggle_theme)
        self._navigation.pack_end(theme, False, False, 0)
        self._navigation.pack_end(label(_(self.access.level), "soft"), False, False, 0)
        self._wrap_navigation()
        self._navigation.show_all()

    def _alone(self, text):
        """A sentence instead of pages."""
        self.machine, self.pages, self.page, self._names = None, [], None, None
        clear(self._navigation)
        clear_stack(self._stack)
        self._stack.pack_start(label(text, "title"), False, False, 40)
        self._stack.show_all()

    def _tick(self):
        goes_on = True
        try:
            goes_on = self._look()
            if self._list is not None:
                self._list.write(self._is_seen())
        except Exception:  # without this, GLib would never call it again, and old values would stay
            traceback.print_exc()
        return goes_on

    def _look(self):
        self._looks += 1
        if not self._is_seen() and self._looks % HIDDEN_PERIOD:
            return True
        if self.hal is None:
            if self._looks % 4 == 0:
                self._connect()
            return True
        if self.hal.is_gone():
            if self.options.into is None and not self.options.xid:
                self._alone(_("LinuxCNC has ended. This screen waits for the next start."))
                GLib.timeout_add(1000, _start_again)
            else:
                self._alone(_("LinuxCNC has ended."))
                GLib.timeout_add(ORPHANED, Gtk.main_quit)  # the screen around it may have crashed, and closes no window
            return False
        values = self.hal.values()
        if self._names is None or values.keys() != self._names:
            if any(_is_of_machine(name) for name in values.keys() ^ (self._names or set())):
                self._discover(values)
        self.values = values
        self._watch(values)
        for page in self.pages:
            observe = getattr(page, "observe", None)
            if observe:
                observe(values)
        if self.page is not None and self._is_seen():
            self.page.refresh(values)
        return True

    def _watch(self, values):
        """Says it when the realtime threads stand: their last values stay, and look as if all were well."""
        beats = [interlock.value(values, "heartbeat") for interlock in self.machine.of("interlock")]
        now = time.monotonic()
        if beats != self._beats:
            self._beats, self._beaten = beats, now
            self._stands = False
            self._standstill.hide()
        elif beats and not self._stands and now - self._beaten > STANDSTILL:
            self._stands = True
            self._standstill.show()

    def _is_seen(self):
        """Whether the window and all around it are on the screen."""
        window = self.window.get_window()
        if window is None:
            return False
        if self.options.into is None:
            return not window.get_state() & Gdk.WindowState.ICONIFIED
        try:
            return _is_viewable(window.get_xid())
        except Exception:  # the screen around it is closing
            return False

    # --- what pages use ---

    def open(self, page):
        for child in self._stack.get_children():
            self._stack.remove(child)
        self.page = page
        page.widget.set_vexpand(True)
        self._stack.pack_start(page.widget, True, True, 0)
        for each, its in self._buttons.items():
            context = its.get_style_context()
            (context.add_class if each is page else context.remove_class)("chosen")
        page.widget.show_all()
        page.entered()
        page.refresh(self.values)

    def open_component(self, instance):
        self.open(Component(self, instance))

    def edit(self, instance, short):
        self.open(Edit(self, instance, short, self.page))

    def kept_pins(self):
        try:
            return self.settings.kept()
        except Refused as refused:
            self.say(str(refused), "bad")
            return []

    def why_not_set(self, instance, short):
        """Why a setting may not be changed now; '' if it may. A setting that is in force may move the machine."""
        if self.values.get("halui.program.is-running"):
            return _("{pin} is not changed: a program runs.").format(pin=instance.full(short))
        return ""

    def say(self, text, kind="good"):
        """A message below the page, until it is closed or another one comes."""
        words = label(styles.SYMBOL[kind] + "  " + text, kind)
        self._show_message(row(grow(words), button(_("Close"), self.hush)))
        named(words, text)

    def ask(self, text, action, do):
        """Asks once; do() is called after a yes."""
        def yes():
            self.hush()
            do()

        self._show_message(column(label("\u25b2  " + text, "warn"),
                                  flow(button(action, yes, "main"), button(_("Cancel"), self.hush))))

    def _show_message(self, content):
        clear(self._message)
        self._message.pack_start(content, False, False, 0)
        self._message.set_no_show_all(False)
        self._message.show_all()

    def hush(self):
        clear(self._message)
        self._message.hide()
        self._message.set_no_show_all(True)

    def move(self, text, action, do, needed="operator", must_be_safe=True):
        """What a button that moves the machine does: refused with the reason, or asked once, then done."""
        def refused():
            why = self.access.refusal(needed)
            if not why and must_be_safe:
                why = access.unsafe(self.hal.values())
            if why:
                self.say(_("{action}: refused. {why}").format(action=action, why=why), "warn")
            return bool(why)

        if not refused():
            self.ask(text, action, lambda: refused() or self._do(do, action))

    def _do(self, do, action):
        try:
            do()
        except (ValueError, RuntimeError, KeyError) as error:
            self.say("%s: %s" % (action, error), "bad")

    def pulse(self, pin, time=300):
        """A rising edge at a pin, and its end. A pin that another screen has left true falls first."""
        def rise():
            self.hal.set(pin, "1")
            GLib.timeout_add(time, lambda: self.hal.set(pin, "0") and False)

        if self.hal.get(pin):
            self.hal.set(pin, "0")
            GLib.timeout_add(time, rise)  # which returns None, so that it is called once
        else:
            rise()

    def program(self, name):
        """The path of a program of this Plumb."""
        return os.path.join(self.options.programs, name)

    def mdi(self, line, action):
        """One MDI line, beside this thread: it may take seconds. Its refusal is said."""
        from panel.linuxcnc_access import mdi

        def work():
            try:
                mdi(line)
            except RuntimeError as error:
                GLib.idle_add(self.say, "%s: %s" % (action, error), "bad")

        threading.Thread(target=work, daemon=True).start()


def clear_stack(stack):
    for child in stack.get_children():
        stack.remove(child)


def _is_of_machine(name):
    """Programs such as halcmd and other screens come and go."""
    return not name.startswith(("plumb-panel-", "halcmd"))


def _start_again():
    os.execv(sys.executable, [sys.executable, *sys.argv])


_server = []


def _display():
    from Xlib import display

    if not _server:
        _server.append(display.Display())
    return _server[0]


def _is_viewable(xid):
    from Xlib import X

    return _display().create_resource_object("window", xid).get_attributes().map_state == X.IsViewable


def _into(plug, parent):
    """AXIS knows no XEMBED: its frame gets the window as a child, as GladeVCP's does."""
    server = _display()
    ours = server.create_resource_object("window", plug.get_window().get_xid())
    atom = server.intern_atom("_XEMBED_INFO")
    ours.change_property(atom, atom, 32, [0, 1])
    ours.reparent(parent, 0, 0)
    ours.map()
    server.sync()


def _forward_keys(plug):
    """Keys that no widget wants go to AXIS: F1 is its emergency stop, ESC stops a program."""
    target = os.environ.get("AXIS_FORWARD_EVENTS_TO")
    if not target:
        return
    from Xlib import X
    from Xlib.protocol import event

    server = _display()
    screen = server.create_resource_object("window", int(target, 0))

    def forward(_plug, key):
        kind = event.KeyPress if key.type == Gdk.EventType.KEY_PRESS else event.KeyRelease
        screen.send_event(kind(time=key.time, root=server.screen().root, window=screen, child=X.NONE, root_x=0, root_y=0,
                               event_x=0, event_y=0, same_screen=1, state=key.state & 0xFF, detail=key.hardware_keycode))
        server.flush()

    plug.connect_after("key-press-event", forward)
    plug.connect("key-release-event", forward)

# SPDX-License-Identifier: GPL-2.0-or-later
"""The panel: it finds the functions of the machine, looks at its pins, and opens pages."""

import os
import signal
import sys
import threading
import time

import gi

gi.require_version("Gtk", "3.0")
gi.require_version("Gdk", "3.0")
from gi.repository import GLib, Gtk  # noqa: E402

from panel import access, hal_files, status, texts  # noqa: E402
from panel.commissioning_page import Commissioning, is_required  # noqa: E402
from panel.function_pages import function_pages  # noqa: E402
from panel.guard import Guard  # noqa: E402
from panel.hal_access import Hal, HalGone, is_gone  # noqa: E402
from panel.machine import Machine  # noqa: E402
from panel.pages import Changes, Component, Components, Edit, Overview, Sensors  # noqa: E402
from panel.settings import MDI, Refused, Settings  # noqa: E402
from panel.task import Task  # noqa: E402
from panel.texts import _  # noqa: E402
from panel.widget_list import WidgetList  # noqa: E402
from panel.window import Window  # noqa: E402

ORPHANED = 5000  # ms until a panel within another screen ends after LinuxCNC
ENDING = 10  # s that LinuxCNC has to end in after it has ended its HAL programs
HIDDEN_PERIOD = 4  # a hidden panel skips all looks but one in so many
NETS_PERIOD = 8  # looks between two looks at the nets


class Panel:
    def __init__(self, options, ini, declared):
        self.options, self.ini, self.declared = options, ini, declared
        self.access = access.Access(options.access or ini.get("PLUMB", "ACCESS", "operator"))
        texts.PIN_NAMES[0] = self.access.level == "integrator"
        texts.MACHINE_UNIT[0] = "in" if ini.get("TRAJ", "LINEAR_UNITS").lower() in ("in", "inch", "imperial") else "mm"
        folder = ini.folder or os.environ.get("XDG_RUNTIME_DIR") or os.path.expanduser("~")
        self.hal, self.task, self.values, self.machine, self._names, self._nets, self._looks = None, None, {}, None, None, {}, 0
        self.settings = Settings(None, folder, options.user or texts.system_user(), ini.get("EMC", "MACHINE"))
        self.settings.kept_file = os.path.join(folder, ini.get("PLUMB", "SETTINGS", "panel.toml"))
        self.hal_file_values = hal_files.values_of_hal_files(ini) if ini.path else {}
        self.guard = Guard(self)
        self.page, self.pages, self.function_pages, self._opened = None, [], [], []
        self._beats, self._beaten, self._lived = None, time.monotonic(), set()
        self._ends = False
        self.window = Window(options.size, options.into, (options.theme or ini.get("PLUMB", "THEME", "light")) == "dark", Gtk.main_quit)
        self._list = WidgetList(options.widgets, self.window.gtk) if options.widgets else None
        sys.excepthook = self._failed
        self._connect()
        GLib.timeout_add(options.period, self._tick, priority=GLib.PRIORITY_DEFAULT_IDLE)  # after all is drawn, however busy the computer is

    @property
    def dark(self):
        return self.window.dark

    def show(self):
        self.window.show(self.options.xid)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) == signal.SIG_IGN:
                continue  # as under nohup
            GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, number, self._terminated if number == signal.SIGTERM else Gtk.main_quit)

    def close(self):
        if self.task is not None:
            self.task.close()
        if self.hal is not None:
            self.hal.close()
        self.task = self.hal = None

    # --- HAL ---

    def _connect(self):
        try:
            self.hal = self.settings.hal = Hal()
        except HalGone:
            self.hal = None
            self._alone(_("LinuxCNC does not run here. This screen waits for it."))
            return
        self.guard = Guard(self)
        self.task = Task()
        self._discover(self.hal.values())

    def _discover(self, values):
        """Builds the pages of the functions that there are. Pages of a component that has not changed stay, with all that is entered."""
        try:
            self._nets = self.hal.signals()
            machine = Machine(self.hal.pins(), self.declared)
        except HalGone as gone:
            self._alone(str(gone))
            return
        same = self.machine is not None and machine.signature() == self.machine.signature()
        former, kept = self.machine, self.page
        self.machine, self._names, self.values = machine, values.keys(), {**values, **self.task_values()}
        if same:
            return
        changed = machine.changed_since(former) if former else None
        old = {(type(page), page.instance.name): page for page in self.function_pages
               if changed is not None and getattr(page, "instance", None) and page.instance.name not in changed}
        self.function_pages = function_pages(self, old)
        if machine.channels:
            self.function_pages.append(Sensors(self))
        commissioning = [Commissioning(self)] if is_required(machine, values) else []
        self.pages = [Overview(self), *self.function_pages, *commissioning, Components(self), Changes(self)]
        self.window.show_navigation(self.pages, self.open)
        if kept is not None and kept not in self.pages and changed is not None and getattr(kept, "of", lambda: None)() not in {None, *changed}:
            return  # half entered
        if kept in self.pages:
            return
        self.open(self._again(kept) or self._first_page())

    def _again(self, former):
        """The page of a title now, or of a component that there still is; None without one."""
        if isinstance(former, Component) and (instance := self.machine.named(former.instance.name)):
            return Component(self, instance, self._again(former.back) or self._first_page())
        return next((page for page in self.pages if former is not None and page.title == former.title), None)

    def _first_page(self):
        wanted = self.options.page
        return next((page for page in self.pages if wanted and wanted in (page.title, getattr(page, "key", ""))), self.pages[0])

    def _alone(self, text):
        """A sentence instead of pages."""
        self.machine, self.pages, self.page, self._names, self.function_pages = None, [], None, None, []
        self.window.show_sentence(text)

    def task_values(self):
        return self.task.values() if self.task is not None else {}

    def _tick(self):
        try:
            self._look()
            if self._list is not None:
                self._list.write(self.window.is_seen())
        except Exception:  # without this, GLib would never call it again, and old values would stay
            self._failed(*sys.exc_info())
        return True

    def _look(self):
        if self._ends:
            return
        self._looks += 1
        seen = self.window.is_seen()
        if not seen and self._looks % HIDDEN_PERIOD:
            return
        if self.hal is None:
            if self._looks % 4 == 0:
                self._connect()
            return
        if self.hal.is_gone():
            self._end()
            return
        values = self.hal.values()
        if self._looks % NETS_PERIOD == 0 and self.hal.signals() != self._nets:
            self._discover(values)
        elif self._names is None or values.keys() != self._names:
            if any(_is_of_machine(name) for name in values.keys() ^ (self._names or set())):
                self._discover(values)
            else:
                self._names = values.keys()
        self.values = {**values, **self.task_values()}
        if self.machine is None:
            return
        self._watch(values)
        for page in self.pages:
            observe = getattr(page, "observe", None)
            if observe:
                observe(self.values)
        if self.page is not None and seen:
            self.page.refresh(self.values)
            self._beat(values)

    def _beat(self, values):
        """Tells linuxcnc_link that this screen is seen: what it shows needs no message over it. Beats of two screens differ as well."""
        if self._looks * self.options.period // 1000 != (self._looks - 1) * self.options.period // 1000:
            for name in values:
                if name.endswith(".panel-beat"):
                    self.hal.set(name, str(int(time.monotonic() * 1000) % (1 << 31)))

    def _terminated(self):
        """LinuxCNC ends all HAL programs when it ends: a panel in its own window stays, and waits for the next start."""
        if not self.options.stays or self.hal is None:
            Gtk.main_quit()
            return False
        self._ends = True
        memory, latest = self.hal.memory, time.monotonic() + ENDING
        self.close()  # HAL cannot end before
        self._alone(_("LinuxCNC ends."))

        def look():
            if is_gone(memory):
                self._end()
            elif time.monotonic() > latest:
                Gtk.main_quit()  # it was this panel that had to end
            else:
                return True
            return False

        GLib.timeout_add(100, look)
        return True

    def _end(self):
        self._ends = True
        self.close()
        if self.options.stays:
            self._alone(_("LinuxCNC has ended. This screen waits for the next start."))
            GLib.timeout_add(1000, _start_again)
        else:
            self._alone(_("LinuxCNC has ended."))
            GLib.timeout_add(ORPHANED, Gtk.main_quit)  # the screen around it may have crashed, and closes no window

    def _watch(self, values):
        """Shows it when LinuxCNC or its realtime threads have gone: the last values stay, and look as if all were well."""
        beats = [interlock.value(values, "heartbeat") for interlock in self.machine.of("interlock")]
        now = time.monotonic()
        if beats != self._beats:
            self._beats, self._beaten = beats, now
        lives = {"motion": "motion.motion-enabled" in values, "task": bool(self.values.get("task.alive"))}
        self._lived |= {name for name, alive in lives.items() if alive}
        if self._lived and not any(lives.values()):
            text = _("LinuxCNC has ended: these values are old.")
        elif beats and now - self._beaten > self.options.standstill:
            text = _("The realtime threads stand still: these values are old. Is LinuxCNC still alive?")
        elif "task" in self._lived and not lives["task"]:
            text = _("LinuxCNC's task does not answer. Has LinuxCNC ended?")
        else:
            text = ""
        self.window.show_standstill(text)

    # --- what pages use ---

    def open(self, page):
        self.page = page
        self.window.show_page(page)
        page.entered()
        page.refresh(self.values)
        self._forget_pages(page)

    def _forget_pages(self, page):
        """A page that no button leads back to is given up, with its memory."""
        needed = list(self.pages)
        while page is not None:
            needed.append(page)
            page = getattr(page, "back", None)
        for each in [each for each in self._opened if each not in needed]:
            each.widget.destroy()
        self._opened = needed

    def verdict_of(self, instance, values):
        """The status of a function, or the faults of another component."""
        page = next((page for page in self.function_pages if getattr(page, "instance", None) and page.instance.name == instance.name), None)
        return page.verdict(values) if page is not None else status.state_of(instance, values)

    def open_component(self, instance):
        self.open(Component(self, instance, self.page))

    def edit(self, instance, short):
        self.open(Edit(self, instance, short, self.page))

    def kept_pins(self):
        try:
            return self.settings.kept()
        except Refused as refused:
            self.say(str(refused), "bad")
            return []

    def _failed(self, kind, error, trace):
        """An error of the panel itself, as in a button."""
        sys.__excepthook__(kind, error, trace)
        self.say(_("This page is not complete: the panel has an error of its own ({error}).").format(error=error), "bad")

    def say(self, text, kind="good"):
        self.window.messages.say(text, kind)

    def ask(self, text, action, do):
        self.window.messages.ask(text, action, do)

    def conflict(self):
        """Another screen has changed a setting: its page shows the new value from now on."""
        seen = getattr(self.page, "look_again", None)
        if seen:
            seen()

    def write(self, pin, text, why="", together=()):
        """A pin of a button: written and logged, together with other changes (name, old, new)."""
        old = self.hal.get(pin)
        self.hal.set(pin, text)
        self._tell(self.settings.note_all([*together, (pin, _as_text(old), text)], why))

    def _tell(self, lost):
        """What could not be logged."""
        if lost:
            self.say(lost, "warn")

    def pulse(self, pin, time=300, ends=True):
        """A rising edge at a pin, and its end, unless it stays true. A pin that another screen has left true falls first."""
        def rise():
            self.hal.set(pin, "1")
            if ends:
                GLib.timeout_add(time, lambda: self.hal.set(pin, "0") and False)

        if self.hal.get(pin):
            self.hal.set(pin, "0")
            GLib.timeout_add(time, rise)  # which returns None, so that it is called once
        else:
            rise()
        self._tell(self.settings.note(pin, "0", "1", "button"))

    def program(self, name):
        """The path of a program of this Plumb."""
        return os.path.join(self.options.programs, name)

    def mdi(self, line, action, undo="", done=lambda: None, stays=False, together=()):
        """One MDI line. `undo` is a line that takes it back; done() is called after it, also after a refusal; LinuxCNC stays in MDI, or goes back.
        `together` are other changes (name, old, new) that belong to it."""
        from panel.linuxcnc_access import mdi

        self._beside(lambda: mdi(line, stays), action, undo, line, done, together)

    def start(self, program, action):
        """Opens a program in LinuxCNC, and starts it."""
        from panel.linuxcnc_access import start

        self._beside(lambda: start(program), action, "", os.path.basename(program))

    def abort(self, action):
        """LinuxCNC's abort of a program."""
        from panel.linuxcnc_access import abort

        self._beside(abort, action, "", "abort")

    def _beside(self, do, action, undo, line, done=lambda: None, together=()):
        """Beside this thread: LinuxCNC may take seconds. Its refusal is said."""
        def work():
            try:
                do()
            except RuntimeError as error:
                GLib.idle_add(self.say, "%s: %s" % (action, error), "bad")
            else:
                GLib.idle_add(lambda: self._tell(self.settings.note_all([*together, (MDI, undo, line)], "button")))
            finally:
                GLib.idle_add(done)

        threading.Thread(target=work, daemon=True).start()


def _as_text(value):
    return "%d" % value if isinstance(value, bool) else str(value)


def _is_of_machine(name):
    """Programs such as halcmd and other screens come and go."""
    return not name.startswith(("plumb-panel-", "halcmd"))


def _start_again():
    os.execv(sys.executable, [sys.executable, *sys.argv])

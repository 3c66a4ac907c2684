# SPDX-License-Identifier: GPL-2.0-or-later
"""The first power-on by finger: what has passed, and the steps of one function."""

import os

from commissioning import pictures
from commissioning.judging import Verdict as Judged
from commissioning.records import Records, findings
from commissioning.rig import NotReady, Rig
from commissioning.session import Session
from panel import settings as settings_module
from panel.linuxcnc_access import mdi
from panel.pages import Page
from panel.texts import _, unit_name
from panel.widgets import Keypad, Verdict, button, card, clear, column, flow, grow, label, named, row, scrolled

from gi.repository import GdkPixbuf, GLib, Gtk  # noqa: E402

BEATS = 100  # ms between two beats of a press
WIDTH = 330  # px of a picture
KINDS = {"ok": "good", "note": "off", "wrong": "warn"}


def is_required(machine, values):
    """Whether an interlock holds what was not commissioned."""
    return any(interlock.value(values, "commissioning") for interlock in machine.of("interlock"))


class Commissioning(Page):
    """What has passed; a button for each function that begins its steps."""

    key = "commissioning"

    @property
    def title(self):
        return _("Commissioning")

    def build(self):
        self._session, self._watched, self._press, self._hint = None, None, None, ""
        self._box = column()
        return scrolled(self._box)

    def of(self):
        return None

    # --- the machine ---

    def _rig(self):
        folder = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(settings_module.__file__))), "functions")
        panel = self.panel
        return Rig(panel.hal, panel.declared, panel.ini, folder, lambda line, stays=False: mdi(line, stays))

    def _records(self):
        return Records(os.path.join(self.panel.ini.folder or os.getcwd(), "plumb"), self.panel.ini.get("EMC", "MACHINE") or "machine")

    def entered(self):
        if self._session is None:
            self._show_state()

    def refresh(self, values):
        pass

    def _show_state(self):
        clear(self._box)
        self._box.pack_start(label(self.title, "title"), False, False, 0)
        try:
            rig = self._rig()
            rows = findings(rig, self._records())
        except (NotReady, KeyError, ValueError, OSError) as error:
            self._box.pack_start(label(str(error), "warn"), False, False, 0)
            self._box.show_all()
            return
        if rig.doubts():
            self._box.pack_start(flow(self._button(_("It is this machine: take over what passed"), lambda: self._answer_stores("accept")),
                                      button(_("It is another machine: begin new stores"), self._ask_to_renew)), False, False, 0)
        if rig.is_required():
            self._box.pack_start(label(_("A function acts only after it has passed here. Each step says what to do, and the way back."), "soft"), False, False, 0)
            passed = [place for place in (*rig.functions, *rig.stages) if rig.is_commissioned(place)]
            self._box.pack_start(flow(*(self._button(_("Begin {name}").format(name=place.name), lambda place=place: self._begin(place.name))
                                        for place in rig.functions if place not in passed)), False, False, 0)
            if passed:
                self._box.pack_start(label(_("After work on drive, encoder or screw: try again."), "soft"), False, False, 0)
                self._box.pack_start(flow(*(button(_("Try {name} again").format(name=place.name), lambda place=place: self._ask_to_try_again(place.name))
                                            for place in passed)), False, False, 0)
        for kind, sentence, _command in rows:
            verdict = Verdict()
            verdict.show_verdict(KINDS[kind], sentence)
            self._box.pack_start(verdict, False, False, 0)
        self._box.show_all()

    def _ask_to_renew(self):
        question = _("Replace the stores? You lose what passed, the learned references and the settings of the panel.")
        self.panel.guard.once_asked(lambda: (question, []), _("Replace the stores"), lambda: self._answer_stores("renew"), "integrator", must_be_safe=False,
                                    must_be_idle=True)

    def _answer_stores(self, pin):
        rig = self._rig()
        taken = rig.answer(pin)
        said = _("What passed counts again on this computer.") if pin == "accept" else _("New stores have replaced the old ones.")
        self.panel.say(said if taken else " ".join(rig.doubts()), "good" if taken else "bad")
        self._show_state()

    def _button(self, text, work):
        return button(text, lambda: self.panel.guard.at_once(self.title, work, "integrator"))

    # --- the steps ---

    def _begin(self, name, again=False):
        rig = self._rig()
        function, stage = rig.place(name)
        self._session = Session(rig, function, self._records(), self.panel.settings.who, stage=stage, again=again)
        self._show_step(None)

    def _ask_to_try_again(self, name):
        question = _("Try {name} again? It is held until it has passed, and its offset returns to 0.").format(name=name)
        self.panel.guard.once_asked(lambda: (question, []), _("Try again"), lambda: self._begin(name, again=True), "integrator", must_be_safe=False,
                                    must_be_idle=True)

    def _show_step(self, verdict):
        session, step = self._session, self._session.step
        clear(self._box)
        number, count = session.count
        self._box.pack_start(label("%d/%d  %s" % (number, count, step.title), "title"), False, False, 0)
        if verdict is not None:
            shown = Verdict()
            shown.show_verdict("good" if verdict.passed else "bad", " ".join(text for text in (verdict.sentence, verdict.remedy) if text))
            self._box.pack_start(shown, False, False, 0)
        words = column(label(step.look), label(_("Way back: {way}").format(way=step.back), "soft"))
        picture = self._picture(step)
        self._box.pack_start(row(grow(words), picture) if picture else words, False, False, 0)
        actions = []
        if step.holds:
            actions.append(self._hold_button(step))
        self._values, self._fields = {}, list(step.fields)
        go_on = [] if step.fields else [button(_("Go on"), self._answer)]
        self._box.pack_start(flow(*actions, *go_on, button(_("Give up"), self._give_up)), False, False, 0)
        if step.watches and step is not self._watched:
            self._watched = step
            GLib.timeout_add(BEATS, self._watch, step)
        self._asked = column()
        self._box.pack_start(self._asked, False, False, 0)
        self._ask_next()
        self._box.show_all()
        self.widget.get_vadjustment().set_value(0)

    def _ask_next(self):
        """One field at a time, with a keypad."""
        clear(self._asked)
        if not self._fields:
            return
        field = self._fields[0]
        self._pad = Keypad()
        entered = [label("%s: %s" % (done.label, self._values[done.key]), "soft") for done in self._session.step.fields if done.key in self._values]
        words = label("%s [%s]" % (field.label, unit_name(field.unit)), "value")
        self._asked.pack_start(card(*entered, row(grow(words), button(_("Enter"), self._enter)), self._pad), False, False, 0)
        self._asked.show_all()

    def _enter(self):
        field = self._fields[0]
        try:
            self._values[field.key] = float(self._pad.entry.get_text().replace("\u2212", "-").replace(",", "."))
        except ValueError:
            self.panel.say(_("Enter: {field}").format(field=field.label), "warn")
            return
        del self._fields[0]
        if self._fields:
            self._ask_next()
        else:
            self._answer()

    @staticmethod
    def _picture(step):
        if step.picture is None:
            return None
        try:
            loader = GdkPixbuf.PixbufLoader.new_with_type("svg")
            loader.write(pictures.drawing(*step.picture).encode())
            loader.close()
        except GLib.Error:
            return label(_("The drawing of this step needs the package librsvg2-common."), "soft")
        pixbuf = loader.get_pixbuf()
        height = pixbuf.get_height() * WIDTH // pixbuf.get_width()
        return named(Gtk.Image.new_from_pixbuf(pixbuf.scale_simple(WIDTH, height, GdkPixbuf.InterpType.BILINEAR)), _("Picture: {path}").format(path=step.title))

    def _hold_button(self, step):
        """Pressed it beats; a finger that leaves it, another page and a dead panel end the trial."""
        its = button(_("Press and hold"), lambda: None, "warn")
        its.connect("button-press-event", lambda *_event: self._begin_press(step))
        for signal in ("button-release-event", "leave-notify-event", "unmap"):
            its.connect(signal, lambda *_event: self._end_press(step))
        return its

    def _begin_press(self, step):
        if self._press is None:
            try:
                refused = step.begin_press()
            except (KeyError, ValueError, RuntimeError) as error:
                refused = Judged("state", str(error))
            if refused is not None:
                self._try(step.end_press)
                self._show_step(refused)
                return False
            self._hint = ""
            self._press = GLib.timeout_add(BEATS, self._beat, step)
        return False

    def _beat(self, step):
        self._try(step.beat)
        if step.hint != self._hint:
            self._hint = step.hint
            self.panel.say(step.hint)
        return True

    def _end_press(self, step):
        if self._press is not None:
            GLib.source_remove(self._press)
            self._press = None
            self._try(step.end_press)
        return False

    def _watch(self, step):
        """Beats for a step that watches, as long as it is the present one."""
        if self._session is None or self._session.step is not step:
            return False
        return self._try(step.beat)

    def _try(self, work):
        try:
            work()
        except (KeyError, ValueError, RuntimeError) as error:
            self.panel.say(str(error), "bad")
        return True

    def _answer(self):
        try:
            verdict = self._session.answer(self._values)
        except (KeyError, ValueError, RuntimeError, OSError) as error:
            verdict = Judged("state", str(error))
        if self._session.done:
            session = self._session
            path, _text = session.records.sheets(session.rig, session.function)
            session.close()
            self._session = None
            self.panel.say(_("{name} has passed, and may act. The sheet to sign: {path}").format(name=session.place.name, path=path))
            self._show_state()
        else:
            self._show_step(verdict)

    def _give_up(self):
        session, self._session = self._session, None
        self._try(session.close)
        self.panel.say(_("Ended. The function is off, and held."), "warn")
        self._show_state()

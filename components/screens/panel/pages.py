# SPDX-License-Identifier: GPL-2.0-or-later
"""A page of the panel, and those that every machine has."""

import time

from panel import misloaded, references, settings as settings_module, status
from panel.settings import CHAIN, MDI, REFERENCE, Write
from panel.texts import _, number, seconds, unit_name, with_unit
from panel.waiting import waiting
from panel.widgets import Verdict, button, card, clear, column, flow, grow, Keypad, label, named, row, scrolled, set_text

from gi.repository import Gtk  # noqa: E402


class Page:
    """`panel` is the Panel; refresh(values) shows new values and is called while the page is seen."""

    title = ""

    def __init__(self, panel):
        self.panel = panel
        self.widget = self.build()

    def build(self):
        raise NotImplementedError

    def refresh(self, values):
        pass

    def entered(self):
        """Called when the page comes to the front."""


class Overview(Page):
    """Every function of the machine with its verdict; a touch opens its page."""

    @property
    def title(self):
        return _("Overview")

    def build(self):
        self._verdicts = []
        box = column(label(_("Functions of this machine"), "title"))
        for page in self.panel.function_pages:
            verdict = Verdict()
            frame = Gtk.EventBox()
            frame.add(verdict)
            frame.connect("button-release-event", lambda *_arguments, page=page: self.panel.open(page))
            named(frame, page.title)
            box.pack_start(column(label(page.title, "value"), frame, spacing=4), False, False, 0)
            self._verdicts.append((page, verdict))
        if not self.panel.function_pages:
            box.pack_start(label(_("No function of Plumb is loaded. `plumb wire` wires one into your configuration.")), False, False, 0)
        self._waiting, self._faults = label("", "warn"), label("", "bad")
        box.pack_start(self._waiting, False, False, 0)
        box.pack_start(self._faults, False, False, 0)
        access = label(_("Access: {level}").format(level=_(self.panel.access.level)), "soft")
        box.pack_start(row(button(_("Light / dark"), self.panel.window.toggle_theme), access), False, False, 0)
        return scrolled(box)

    def refresh(self, values):
        for page, verdict in self._verdicts:
            verdict.show_verdict(*page.verdict(values))
        machine = self.panel.machine
        set_text(self._waiting, "\n".join("\u25b2 " + text for text in [*waiting(machine, values), *misloaded.warnings(machine, values)]))
        faults = []
        for instance in self.panel.machine.instances:
            kind, words = status.state_of(instance, values)
            is_shown = kind == "bad" or (kind == "warn" and instance.declared.statuses and not instance.value(values, "waiting"))
            if is_shown and not instance.is_function:
                faults.append(words if words.startswith(instance.name + " ") else "%s: %s" % (instance.name, words))
        set_text(self._faults, "\n".join(faults))


class Components(Page):
    """A list of all instances; a touch opens the page of one."""

    @property
    def title(self):
        return _("All components")

    def build(self):
        self._rows = []
        box = column(label(_("All components"), "title"), spacing=2)
        for instance in self.panel.machine.instances:
            words = label("", wrap=True)
            its = button(instance.name, lambda instance=instance: self.panel.open_component(instance), "row")
            its.remove(its.get_child())
            its.add(column(row(grow(label(instance.name, "value")), label(instance.module, "soft", wrap=False)),
                           label(_(instance.declared.summary), "soft"), words, spacing=2))
            box.pack_start(its, False, False, 0)
            self._rows.append((instance, words))
        return scrolled(box)

    def refresh(self, values):
        for instance, words in self._rows:
            set_text(words, self.panel.verdict_of(instance, values)[1])


# Of the settings, as the components declare them. For gettext: _("Required settings"), _("Settings of this machine"),
# _("Settings for experts"), _("Inputs without a signal")
LEVELS = (("must", "Required settings"), ("machine", "Settings of this machine"), ("expert", "Settings for experts"), ("", "Inputs without a signal"))


class Component(Page):
    """One instance: its faults in words, settings, inputs and outputs with units and sentences."""

    def __init__(self, panel, instance, back):
        self.instance, self.back = instance, back
        super().__init__(panel)

    @property
    def title(self):
        return self.instance.name

    def of(self):
        return self.instance.name

    def build(self):
        instance, panel = self.instance, self.panel
        self._values = {}
        self._verdict = Verdict()
        box = column(label("%s (%s)" % (instance.name, instance.module), "title"), label(_(instance.declared.summary), "soft"), self._verdict)
        sections = [(_(heading), [short for short in instance.settings() if instance.declared.pin(short).get("level", "") == level], True)
                    for level, heading in LEVELS]
        sections += [(_("Inputs from signals"), instance.inputs(), False), (_("Outputs"), instance.outputs(), False)]
        for heading, shorts, editable in sections:
            if not shorts:
                continue
            inside = column(spacing=0)
            inside.set_no_show_all(True)
            is_open = heading in (_("Required settings"), _("Settings of this machine"))
            its = button("", lambda *section: None, name=heading)
            its.connect("clicked", self._toggle, inside, heading, shorts, editable)
            box.pack_start(its, False, False, 0)
            box.pack_start(inside, False, False, 0)
            self._open(its, inside, heading, shorts, editable, is_open)
        return scrolled(box)

    def _toggle(self, its, inside, heading, shorts, editable):
        self._open(its, inside, heading, shorts, editable, not inside.get_visible())

    def _open(self, its, inside, heading, shorts, editable, is_open):
        its.get_child().set_text("%s %s (%d)" % ("\u25be" if is_open else "\u25b8", heading, len(shorts)))
        if is_open and not inside.get_children():
            self._fill(inside, shorts, editable)
            for child in inside.get_children():
                child.show_all()
            self.refresh(self.panel.values)
        inside.set_visible(is_open)

    def _fill(self, inside, shorts, editable):
        for short in shorts:
            declared = self.instance.declared.pin(short)
            value = label("", "value", wrap=False)
            value.set_xalign(1)
            words = column(label(short), label(_(declared.get("sentence", "")), "soft"), spacing=0)
            content = row(grow(words), value)
            if editable:
                its = button(short, lambda short=short: self.panel.edit(self.instance, short), "row")
                its.remove(its.get_child())
                its.add(content)
                inside.pack_start(its, False, False, 0)
            else:
                signal = self.instance.pins[short].signal
                if signal:
                    words.pack_start(label(_("signal {signal}").format(signal=signal), "soft"), False, False, 0)
                content.set_border_width(8)
                inside.pack_start(content, False, False, 0)
            self._values[short] = (value, declared.get("unit", ""))

    def refresh(self, values):
        self._verdict.show_verdict(*self.panel.verdict_of(self.instance, values))
        for short, (shown, unit) in self._values.items():
            now = self.instance.value(values, short)
            text = _("gone") if now is None else with_unit(now, unit)
            if short in self.instance.declared.codes and now:
                text = "%s: %s" % (now, _(self.instance.sentence(values, short)))
                shown.set_line_wrap(True)
                shown.set_max_width_chars(36)
            set_text(shown, text)


class Edit(Page):
    """One setting: its value now, in the HAL files, as saved, its last changes; a keypad to change it."""

    def __init__(self, panel, instance, short, back):
        self.instance, self.short, self.back = instance, short, back
        super().__init__(panel)

    @property
    def title(self):
        return self.instance.full(self.short)

    def build(self):
        panel, instance, short = self.panel, self.instance, self.short
        pin = instance.pins[short]
        declared = instance.declared.pin(short)
        self._unit = declared.get("unit", "")
        self._seen = panel.values.get(pin.name)
        self._now = label("", "big", wrap=False)
        facts = [label(pin.name, "title"), label(_(declared.get("sentence", ""))), self._now]
        limits = [("%s %s" % (words, with_unit(declared[key], self._unit))) for key, words in
                  (("minimum", _("at least")), ("maximum", _("at most"))) if key in declared]
        if limits:
            facts.append(label(", ".join(limits), "soft"))
        default = declared.get("default", 0)
        facts.append(label(_("Default: {value}").format(
            value=number(bool(default)) if pin.kind == "bit" else with_unit(float(default), declared.get("default_unit", self._unit))), "soft"))
        self._file = panel.hal_file_values.get(pin.name)
        facts.append(label(_("In {file}: {value}").format(file=self._file[1], value=with_unit(_number(self._file[0]), self._unit))
                           if self._file else _("No HAL file sets it."), "soft"))
        if short in misloaded.bounds_in_millimetres(instance, panel.values):
            facts.append(label("\u25b2 " + misloaded.in_millimetres(instance, short, panel.values), "warn"))
        self._kept = label("", "soft")
        self._history = label("", "soft")
        facts += [self._kept, self._history]
        left = column(*facts, spacing=6)
        actions = []
        if pin.kind == "bit":
            self._keypad = None
            actions += [button(_("On"), lambda: self._save("1"), "key", name=_("Switch on")),
                        button(_("Off"), lambda: self._save("0"), "key", name=_("Switch off"))]
            entry = column(*actions)
        else:
            self._keypad = Keypad("" if self._seen is None else number(self._seen, 9), whole=pin.kind != "float", exponent=pin.kind == "float")
            entry = column(row(grow(self._keypad.entry.get_parent()), label(unit_name(self._unit), "value", wrap=False)),
                           button(_("Save"), lambda: self._save(self._keypad.text), "main"))
        entry.set_size_request(300, -1)
        sides = flow(left, entry)  # one below the other where it is narrow
        sides.set_homogeneous(False)
        sides.set_min_children_per_line(1)
        sides.set_max_children_per_line(2)
        others = [button(_("Undo the last change"), self._undo)]
        if self._file:
            others.append(button(_("Back to the HAL file, and keep no value"), self._back_to_file))
        others.append(button(_("Close"), self.close))
        return scrolled(column(sides, flow(*others)))

    def close(self):
        self.panel.open(self.back)

    def of(self):
        return self.instance.name

    def look_again(self):
        self._seen = self.panel.hal.get(self.instance.full(self.short))

    def _save(self, text):
        name = self.instance.full(self.short)
        self.panel.guard.change([Write(self.instance, self.short, text, self._seen)], _("Save"), _("{pin} is now {value}."), then=self.look_again,
                                question="", asks=_("{pin} = {value}?").format(pin=name, value=text))

    def _undo(self):
        try:
            change = self.panel.settings.last_of(self.instance.full(self.short))
        except settings_module.Refused as refused:
            self.panel.say(str(refused), "warn")
            return
        self.panel.guard.undo(change, then=self.look_again)

    def _back_to_file(self):
        def follow():
            self.look_again()
            self.panel.settings.keep(self.instance.full(self.short), keep=False)

        self.panel.guard.change([Write(self.instance, self.short, self._file[0])], _("Back to the HAL file"),
                                _("{pin} is {value}, as in the HAL file, and follows it from now on."), why="HAL file", then=follow)

    def refresh(self, values):
        name = self.instance.full(self.short)
        now = values.get(name)
        set_text(self._now, _("{name} is not loaded any more.").format(name=name) if now is None else with_unit(now, self._unit))
        kept = name in self.panel.kept_pins()
        set_text(self._kept, self._kept_words(kept, values))
        changes = [change for change in self.panel.settings.log.all() if change.pin == name][-3:]
        set_text(self._history, "\n".join(_change_line(change, self._unit) for change in reversed(changes)))


    def _kept_words(self, kept, values):
        if not kept:
            return _("Not changed on a screen.")
        lost = self.panel.settings.retain_state(values)
        return "\u25b2 " + lost if lost else _("Saved by plumb-retain: this value wins over the HAL file.")


def _number(text):
    try:
        return float(text)
    except ValueError:
        return text


# What a change was: _("undo"), _("button"), _("switch"), _("section"), _("HAL file"), _("learn") for gettext.


def _change_line(change, unit):
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(change.time))
    words = references.as_words if change.pin.endswith(REFERENCE) else lambda text: with_unit(_number(text), unit)
    return "%s  %s: %s \u2192 %s%s" % (when, change.who, words(change.old), words(change.new),
                                       " (%s)" % _(change.why) if change.why else "")


class Changes(Page):
    """The change log, the newest first, with an undo for each."""

    @property
    def title(self):
        return _("Changes")

    def build(self):
        self._shown = None
        self._list = column(spacing=0)
        return scrolled(column(label(_("Changed settings"), "title"), self._list))

    def refresh(self, values):
        changes = self.panel.settings.log.all()
        if len(changes) == self._shown:
            return
        self._shown = len(changes)
        clear(self._list)
        if not changes:
            self._list.pack_start(label(_("No setting was changed on a screen."), "soft"), False, False, 0)
        for change in reversed(changes[-100:]):
            instance, short = self.panel.machine.owner_of(change.pin)
            unit = instance.declared.pin(short).get("unit", "") if instance else ""
            line = row(grow(column(label(change.pin, "value"), label(_change_line(change, unit), "soft"), spacing=0)))
            line.set_border_width(6)
            if self._can_undo(change, instance, short):
                line.pack_end(button(_("Undo"), lambda change=change: self.panel.guard.undo(change), name=_("Undo {pin}").format(pin=change.pin)), False, False, 0)
            if instance is not None:
                line.pack_end(button(_("Open"), lambda instance=instance, short=short: self.panel.edit(instance, short),
                                     name=_("Open {pin}").format(pin=change.pin)), False, False, 0)
            self._list.pack_start(line, False, False, 0)
        self._list.show_all()


    def _can_undo(self, change, instance, short):
        """The last change of a setting or of the chain, and a line of MDI that another one takes back."""
        if change.pin == MDI:
            return bool(change.old) and change is self.panel.settings.log.last(MDI)
        if change.pin.endswith(REFERENCE):
            return bool(change.old) and change is self.panel.settings.log.last(change.pin)
        settable = change.pin == CHAIN or (instance is not None and short in instance.settings())
        return settable and change.why != "button" and change is self.panel.settings.log.last(change.pin)


class Sensors(Page):
    """Every channel with value, age, validity, and why it is not valid."""

    @property
    def title(self):
        return _("Sensors")

    def verdict(self, values):
        bad = [channel.name for channel in self.panel.machine.channels if not values.get(channel.pins["valid"])]
        if bad:
            return "bad", _("No valid value: {names}.").format(names=", ".join(bad))
        return "good", _("All {count} channels are valid.").format(count=len(self.panel.machine.channels))

    def build(self):
        self._rows = []
        self._verdict = Verdict()
        box = column(label(_("Sensors"), "title"), self._verdict)
        for channel in self.panel.machine.channels:
            state, value, why = label("", "value", wrap=False), label("", "big", wrap=False), label("", "soft")
            box.pack_start(card(row(state, grow(label(channel.name, "value")), value), why), False, False, 0)
            self._rows.append((channel, state, value, why))
        return scrolled(box)

    def refresh(self, values):
        self._verdict.show_verdict(*self.verdict(values))
        for channel, state, value, why in self._rows:
            valid = values.get(channel.pins["valid"])
            set_text(state, "\u2714" if valid else "\u2716")
            now = values.get(channel.pins["value"])
            set_text(value, _("gone") if now is None else number(now))
            age = values.get(channel.pins["age"])
            text = _("Age {age}.").format(age=seconds(age)) if isinstance(age, float) else ""
            if not valid:
                text += " " + status.of_channel(channel, self.panel.declared, values)
            if values.get(channel.pins.get("error-count", "")):
                text += " " + _("{count} errors since the start.").format(count=values[channel.pins["error-count"]])
            set_text(why, text.strip())

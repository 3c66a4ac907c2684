# SPDX-License-Identifier: GPL-2.0-or-later
"""Strokes by the finger: their ends, their speed and their start, and the sections with a speed of their own."""

from panel import chopping_orders as orders
from panel.entry_form import EntryForm
from panel.function_page import EntryPage
from panel.settings import Write
from panel.texts import _, number, position, unit_name, with_unit
from panel.widgets import button, choose, column, flow, grow, label, row, scrolled, set_text

EXACT = 9  # digits


class StrokePage(EntryPage):
    """Ends and speed of the strokes, typed or taken from where the axis stands; then the start."""

    def __init__(self, panel, page):
        self.page = self.back = page
        self._extra = orders.is_extra(panel.ini)
        super().__init__(panel)

    @property
    def title(self):
        return _("Ends and start of the strokes")

    def build(self):
        get = self._get
        self._upper, self._lower, self._end = _("Upper dead point, {unit}"), _("Lower dead point, {unit}"), _("Point R, {unit}")
        self._upper, self._lower, self._end = (name.format(unit=unit_name("mu")) for name in (self._upper, self._lower, self._end))
        self._speed = _("Largest speed, {unit}/min").format(unit=unit_name("mu"))
        fields = [(self._upper, get("upper")), (self._lower, get("lower"))] + ([] if self._extra else [(self._end, get("position"))])
        if fields[0][1] == fields[1][1]:
            fields = [(name, None) for name, _value in fields[:2]] + fields[2:]
        fields.append((self._speed, 60 * get("feed") or None))
        self._form = EntryForm([(name, "" if value is None else number(round(value, 6), EXACT).replace("\u2212", "-")) for name, value in fields])
        self._here = label("", "value")
        taken = [button(_("Upper dead point here"), lambda: self._take(self._upper)), button(_("Lower dead point here"), lambda: self._take(self._lower))]
        if not self._extra:
            taken.append(button(_("Point R here"), lambda: self._take(self._end)))
        self._go = button("", self._start, "main", name=_("Start the strokes"))
        return scrolled(column(label(self.title, "title"), label(_("Positions of the joint, as without work offset and tool. Jog the axis and take its "
                                                                   "place, or type.")),
                               self._here, flow(*taken), self._form.widget,
                               flow(self._go, button(_("Back"), lambda: self.panel.open(self.page)))))

    def _get(self, short):
        return float(self.page.get(self.panel.values, short, 0.0))

    def _take(self, name):
        self._form.put(name, "%.4f" % (self._get("position") + self._get("offset")))

    def refresh(self, values):
        set_text(self._here, _("The axis stands at {place}.").format(place=position(self._get("position") + self._get("offset"))))
        set_text(self._go.get_child(), _("Change the strokes") if self._strokes() else _("Start the strokes"))

    def _strokes(self):
        return bool(self.page.get(self.panel.values, "stroking"))

    def _start(self):
        action = _("Change the strokes") if self._strokes() else _("Start the strokes")
        try:
            upper, lower = self._form.number(self._upper), self._form.number(self._lower)
            end = self._get("position") if self._extra or self._strokes() else self._form.number(self._end)
            stroke = orders.Stroke(upper, lower, end, self._form.number(self._speed) / 60)
            why = orders.refusal(self.page.instance, self.panel.guard.values(), stroke)
        except ValueError as error:
            why = str(error)
        if why:
            self.panel.say(_("{action}: refused. {why}").format(action=action, why=why), "warn")
            return
        words = _("Stroke between {upper} and {lower}, at most {speed}?").format(
            upper=with_unit(stroke.upper, "mu"), lower=with_unit(stroke.lower, "mu"), speed=orders.a_minute(stroke.speed))
        away = stroke.end - self._get("position")
        if not self._strokes() and abs(away) > 5e-7:
            words += " " + _("First the axis moves to point R, by {distance}.").format(distance=with_unit(round(away, 6), "mu"))
        self.panel.guard.once_asked(lambda: (words, []), _("Change now") if self._strokes() else _("Start"), lambda: self._order(stroke, action))

    def _order(self, stroke, action):
        page, panel = self.page, self.panel
        former = orders.Stroke(*(self._get(short) for short in ("upper", "lower", "position", "feed")))
        changes = self._strokes()
        if orders.way(page.instance, panel.ini) == "mdi":
            line = orders.change_line(stroke) if changes else orders.start_line(stroke, self._extra)
            panel.mdi(line, action, undo=orders.change_line(former) if changes else "G80.1", stays=True)
        else:
            for short, value in (("upper", stroke.upper), ("lower", stroke.lower), ("feed", stroke.speed)):
                panel.write(page.instance.full(short), repr(value), "button")
            if changes:
                panel.write(page.instance.full("shift"), "0" if panel.hal.get(page.instance.full("shift")) else "1", "button")
            else:
                panel.pulse(page.instance.full("run"), ends=False)
        panel.open(page)


class SectionsPage(EntryPage):
    """The sections of the settings; a touch changes one."""

    def __init__(self, panel, page):
        self.page = self.back = page
        super().__init__(panel)

    @property
    def title(self):
        return _("Sections of the stroke")

    def build(self):
        self._lines = []
        rows = []
        for place in orders.sections(self.page.instance):
            words = label("", "value")
            its = button("", lambda place=place: self.panel.open(SectionPage(self.panel, self, place)), "row", name=_("Section {number}").format(number=place + 1))
            its.remove(its.get_child())
            its.add(row(label("%d" % (place + 1), "value", wrap=False), grow(words)))
            rows.append(its)
            self._lines.append(words)
        self._program = label("", "warn")
        return scrolled(column(label(self.title, "title"), label(_("In a section the axis strokes at a part of its speed: slow in the work, fast in the air.")),
                               self._program, *rows, flow(button(_("Back"), lambda: self.panel.open(self.page)))))

    def refresh(self, values):
        count = self.page.get(values, "program-sections", 0)
        set_text(self._program, "\u25b2 " + _("The program gave {count} sections: they hold until the strokes end.").format(count=count) if count else "")
        self._program.set_visible(bool(count))
        for place, words in enumerate(self._lines):
            set_text(words, orders.section_in_words(self.page.instance, values, place))


class SectionPage(EntryPage):
    """One section: its ends as heights, its speed, and the strokes that it is in."""

    def __init__(self, panel, sections, place):
        self.page, self.back, self._place = sections.page, sections, place
        super().__init__(panel)

    @property
    def title(self):
        return _("Section {number}").format(number=self._place + 1)

    def build(self):
        self.look_again()
        kind, first, last, ratio = self._seen.values()
        is_height = kind in (orders.BOTH, orders.UPWARD, orders.DOWNWARD)
        self._first, self._last = (_("From, {unit}").format(unit=unit_name("mu")), _("To, {unit}").format(unit=unit_name("mu")))
        self._ratio = _("Speed, %")
        self._form = EntryForm([(self._first, "%.9g" % first if is_height else ""), (self._last, "%.9g" % last if is_height else ""),
                                (self._ratio, "%.4g" % (100 * ratio) if is_height else "50")],
                               _("Heights in the frame of the joint, as the dead points."))
        self._ways = {}
        for way, words in ((orders.BOTH, _("Both ways")), (orders.UPWARD, _("Upward only")), (orders.DOWNWARD, _("Downward only"))):
            self._ways[way] = button(words, lambda way=way: self._choose(way))
        self._choose(kind if is_height else orders.BOTH)
        return scrolled(column(label(self.title, "title"), flow(*self._ways.values()), self._form.widget,
                               flow(button(_("Save"), self._save, "main"), button(_("Remove"), self._remove),
                                    button(_("Back"), lambda: self.panel.open(self.back)))))

    def look_again(self):
        """The section as it is now."""
        self._seen = {part: self.panel.hal.get(self.page.instance.full(self._name(part))) for part in ("kind", "from", "to", "ratio")}

    def _name(self, part):
        return "section-%d-%s" % (self._place, part)

    def _choose(self, way):
        self._way = way
        for each, its in self._ways.items():
            choose(its, each == way)

    def _save(self):
        try:
            ends = sorted((self._form.number(self._first), self._form.number(self._last)))
            ratio = self._form.number(self._ratio) / 100
        except ValueError as error:
            self.panel.say(str(error), "warn")
            return
        if ends[0] == ends[1]:
            self.panel.say(_("The ends of a section must differ."), "warn")
            return
        self._write([("from", repr(ends[0])), ("to", repr(ends[1])), ("ratio", repr(ratio)), ("kind", str(self._way))], _("Save the section"))

    def _remove(self):
        self._write([("kind", "0")], _("Remove the section"))

    def _write(self, parts, action):
        instance = self.page.instance
        missing = next((self._name(part) for part, _text in parts if self._name(part) not in instance.settings()), "")
        if missing:
            self.panel.say(_("A signal drives {setting}: change it where the signal comes from.").format(setting=self.title), "warn")
            return
        question = _("{action}? The strokes change from the next one on.").format(action=action) if self.page.get(self.panel.values, "stroking") else ""
        self.panel.guard.change([Write(instance, self._name(part), text, self._seen[part]) for part, text in parts], action,
                                _("{name} is saved.").format(name=self.title), why="section", needed="operator", question=question,
                                then=lambda: self.panel.open(self.back))

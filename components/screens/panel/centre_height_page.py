# SPDX-License-Identifier: GPL-2.0-or-later
"""centre_height: the next step, the entry of diameters, and the result as a picture of tool and centre."""

import math

from gi.repository import Gtk

from panel import access, centre_height_state, style as styles, texts
from panel.function_page import FunctionPage
from panel.pages import Page
from panel.texts import _, in_micrometres, number, unit_name, with_unit
from panel.widgets import Figures, Keypad, button, card, choose, column, flow, grow, label, named, row, scrolled, set_text


class CentreHeightPage(FunctionPage):
    heading = "Centre height"  # for gettext: _("Centre height")
    _jogging = False  # a step is under way
    live = ("x-position-0", "y-position-0", "diameter")

    # Name, method, fewest cuts, and how to cut them.
    METHODS = (
        ("Two lands", 1, 2, "Each land beside the one before, at the same X: the first with Y above, the next below."),
        ("Two cuts", 0, 2, "Both cuts on one land at the present Y, the second one deeper. They do not show the sign."),
        ("Step of Y", 2, 2, "Cuts on one land, each deeper and at another Y."),
    )  # for gettext: _("Two cuts"), _("Two lands"), _("Step of Y")
    # for gettext: _("Each land beside the one before, at the same X: the first with Y above, the next below.")
    # for gettext: _("Both cuts on one land at the present Y, the second one deeper. They do not show the sign.")
    # for gettext: _("Cuts on one land, each deeper and at another Y.")
    LANDS = 1

    def content(self):
        self._picture = HeightPicture(self)
        self._figures = Figures(_("Height"), _("Uncertainty (k=2)"), _("Move of Y"), _("Cuts"))
        self._step, self._entered, self._sent = label("", "value"), label("", "soft"), []
        self._place = label("", "value")
        steps = (0.001, 0.01, 0.1) if texts.MACHINE_UNIT[0] == "in" else (0.01, 0.1, 1)
        jogs = [button("Y %s%g" % ("\u2212" if sign < 0 else "+", step), lambda by=sign * step: self._jog(by), "key", name="Y %+g" % (sign * step))
                for sign in (-1, 1) for step in (reversed(steps) if sign < 0 else steps)]
        moves = flow(*jogs)
        moves.set_max_children_per_line(3)
        return [card(label(_("Next step"), "soft"), self._step, self._entered), card(label(_("Move Y by a step"), "soft"), self._place, moves),
                self._figures, self._picture]

    def buttons(self):
        begin = [button(_("Begin: {method}").format(method=_(method[0])), lambda method=method: self.panel.open(BeginPage(self.panel, self, method)),
                        name=_(method[0])) for method in self.METHODS]
        interrupt = button(_("Interrupt"), lambda: self._do(_("Interrupt"), "abort", "M65 P11"))
        self._next = {  # the buttons of a step, by state-code; the first one leads on
            centre_height_state.CUTS: [button(_("The cut is done"), lambda: self._do(_("The cut is done"), "cut-done", "M451")), interrupt],
            centre_height_state.WAITS: [button(_("Enter the radius") if self.by_radius else _("Enter the diameter"),
                                               lambda: self.panel.open(DiameterPage(self.panel, self))), interrupt],
            centre_height_state.KNOWN: [button(_("Store the height: M454"), self._store), *begin],
            centre_height_state.INTERRUPTED: [button(_("Continue"), lambda: self._do(_("Continue"), "resume", "M453")), *begin],
        }
        self._begin = begin
        return [*begin, *[its[0] for its in self._next.values()], interrupt]

    def _jog(self, by):
        """One move of Y a touch, in machine coordinates: no tool and no origin is changed by it."""
        action = _("Move Y by a step")
        why = self.panel.access.refusal("operator") or access.unsafe(self.panel.guard.values())
        y = self.get(self.panel.values, "y-position-%d" % self.get(self.panel.values, "post"), 0.0)
        if why or self._jogging:
            self.panel.say(_("{action}: refused. {why}").format(action=action, why=why or _("An axis moves.")), "warn")
            return
        self._jogging = True
        self.panel.mdi("G53 G0 Y%.6f" % (y + by), action, done=self._jogged)

    def _jogged(self):
        self._jogging = False

    def guidance(self, values):
        """The next step in words, with the figures that it needs."""
        get = lambda short, otherwise=0.0: self.get(values, short, otherwise)  # noqa: E731
        state = get("state-code", 0)
        if state == centre_height_state.CUTS:
            cut = get("cut-number", 0) + 1
            if self.method(values) == self.LANDS:
                y = get("land-1-y") if cut % 2 else get("land-2-y")
                return _("Turn land {cut}: move Y by {y} from where you began, and X to a diameter of {diameter}. Then touch \"The cut is done\" "
                         "while the tool stands at its end.").format(cut=cut, y=with_sign(y), diameter=with_unit(get("land-diameter"), "mu"))
            return _("Turn cut {cut}. Then touch \"The cut is done\" while the tool stands at its end.").format(cut=cut)
        if state == centre_height_state.WAITS:
            if self.by_radius:
                return _("Retract X, stop the spindle, measure cut {cut}, and enter its radius.").format(cut=get("cut-number", 0) + 1)
            return _("Retract X, stop the spindle, measure cut {cut}, and enter its diameter.").format(cut=get("cut-number", 0) + 1)
        if state == centre_height_state.KNOWN:
            if get("on-centre", False):
                return _("The tool is on centre. Nothing is to do.")
            if get("hold", False):
                return _(self.instance.sentence(values, "hold-code"))
            return _("Store the height. Then move Y to 0, turn, and measure again until the tool is on centre.")
        if state == centre_height_state.INTERRUPTED:
            return _("Continue with the cuts that have their diameter, or begin again.")
        return _("Load the tool, start the spindle, move Y to 0, and choose a method.")

    def method(self, values):
        """That of the program, or of the pin."""
        return int(self.get(values, "program-method", 0)) - 1 if self.get(values, "program-method", 0) >= 1 else self.get(values, "method", 0)

    def begin(self, method, cuts, diameter):
        """`diameter` is a text of the operator. Raises ValueError."""
        value = float(diameter.replace(",", "."))
        if not value > 0 or not math.isfinite(value):
            raise ValueError(_("A diameter is above 0."))
        if "start" in self.instance.settings():
            for short, text in (("method", str(method)), ("cuts", str(cuts)), ("land-diameter", repr(value))):
                if short in self.instance.settings():
                    self.panel.write(self.instance.full(short), text, "button")
            self.panel.pulse(self.instance.full("start"))
        else:
            self.panel.mdi("M450 P%d Q%d D%r" % (method, cuts, value), _("Begin"))

    def _do(self, action, pin, line):
        """By the pin, where nothing else writes it; else by the M-code of the configuration."""
        def do():
            if pin in self.instance.settings():
                self.panel.pulse(self.instance.full(pin))
            else:
                self.panel.mdi(line, action)

        self.panel.guard.at_once(action, do)

    def enter(self, text):
        """The diameter of the last cut. Raises ValueError."""
        value = float(text.replace(",", "."))
        if not value > 0 or not math.isfinite(value):
            raise ValueError(_("A diameter is above 0."))
        self._sent[self.get(self.panel.values, "cut-number"):] = [value]
        if "entered" in self.instance.settings():
            self.panel.write(self.instance.full("entered-diameter"), repr(value), "button")
            self.panel.pulse(self.instance.full("entered"))
        else:
            self.panel.mdi("M452 P%r" % value, _("Enter the diameter"))

    @property
    def by_radius(self):
        """Whether the component takes the radius of a cut."""
        return self.get(self.panel.values, "gauge-kind") == 1

    def expected(self):
        """The diameter that a tool on centre leaves; 0 while it is unknown."""
        values = self.panel.values
        return self.get(values, "land-diameter", 0.0) if self.method(values) == self.LANDS else 0.0

    def _store(self):
        move = in_micrometres(self.get(self.panel.values, "y-move", 0.0))
        self.panel.guard.once_asked(_("Store the height in the tool table? Y moves by {move} with its next word.").format(move=move),
                        _("Store the height"), lambda: self.panel.mdi("M454", _("Store the height")))

    def refresh(self, values):
        super().refresh(values)
        set_text(self._step, self.guidance(values))
        set_text(self._place, "Y %.4f %s" % (self.get(values, "y-position-%d" % self.get(values, "post"), 0.0), unit_name("mu")))
        del self._sent[self.get(values, "cut-number") + 1:]
        taken = self._sent[: self.get(values, "cut-number")]
        lines = ["%d: %s" % (place, with_unit(value, "mu")) for place, value in enumerate(taken, start=1)]
        set_text(self._entered, _("Entered: {values}. A wrong one: interrupt, and begin again.").format(values=", ".join(lines)) if lines else "")
        self._entered.set_visible(bool(lines))
        wanted = self._next.get(self.get(values, "state-code"), self._begin)
        centred = self.get(values, "state-code") == centre_height_state.KNOWN and self.get(values, "on-centre")
        for its in {each for step in self._next.values() for each in step} | set(self._begin):
            its.get_parent().set_visible(its in wanted)
            context = its.get_style_context()
            (context.add_class if its is wanted[0] and wanted is not self._begin and not centred else context.remove_class)("main")
        valid = self.get(values, "value-valid")
        self._figures.show_value(_("Height"), in_micrometres(self.get(values, "height", 0.0)) if valid else "\u2013")
        self._figures.show_value(_("Uncertainty (k=2)"), "\u00b1" + centre_height_state.uncertainty(self.instance, values) if valid else "\u2013")
        self._figures.show_value(_("Move of Y"), in_micrometres(self.get(values, "y-move", 0.0)) if valid else "\u2013")
        self._figures.show_value(_("Cuts"), number(self.get(values, "cut-number")))
        self._picture.show_height(self.get(values, "height", 0.0) if valid else None, self.get(values, "sigma", 0.0))


def with_sign(value):
    return ("+" if value >= 0 else "") + with_unit(float(value), "mu")


class EntryPage(Page):
    """A page that leads back to that of the function."""

    page = None

    def of(self):
        return self.page.instance.name


class BeginPage(EntryPage):
    """Number of cuts and diameter of a method, before it begins."""

    CUTS = (2, 4, 6)

    def __init__(self, panel, page, method):
        self.page = self.back = page
        self._name, self._method, self._fewest, self._how = method
        super().__init__(panel)

    @property
    def title(self):
        return _("Begin: {method}").format(method=_(self._name))

    def build(self):
        self._keypad = Keypad("")
        self._choices = {}
        for cuts in self.CUTS:
            self._choices[cuts] = button(_("{count} cuts").format(count=cuts), lambda cuts=cuts: self._choose(cuts), "key")
        self._choose(self._fewest)
        return scrolled(column(label(self.title, "title"), label(_(self._how)), flow(*self._choices.values()),
                               label(_("Diameter to turn, without the error of the tool"), "value"),
                               row(grow(self._keypad), label(unit_name("mu"), "value", wrap=False)),
                               flow(button(_("Begin"), self._begin, "main"), button(_("Back"), lambda: self.panel.open(self.page)))))

    def _choose(self, cuts):
        self._cuts = cuts
        for each, its in self._choices.items():
            choose(its, each == cuts)

    def _begin(self):
        refusal = self.panel.access.refusal("operator")
        try:
            if refusal:
                raise ValueError(refusal)
            self.page.begin(self._method, self._cuts, self._keypad.text)
        except ValueError as error:
            self.panel.say(_("\"{text}\" is no diameter: {why}").format(text=self._keypad.text, why=error), "bad")
            return
        self.panel.open(self.page)


class DiameterPage(EntryPage):
    """The entry of a measured diameter, judged at once."""

    def __init__(self, panel, page):
        self.page = self.back = page
        super().__init__(panel)

    @property
    def title(self):
        return _("Radius of the cut") if self.page.by_radius else _("Diameter of the cut")

    def build(self):
        self._keypad = Keypad("")
        self._judged = label("", "value")
        self._keypad.entry.connect("changed", lambda _entry: self._judge())
        return scrolled(column(label(self.title, "title"), row(grow(self._keypad), label(unit_name("mu"), "value", wrap=False)), self._judged,
                               flow(button(_("Enter"), self._enter, "main"), button(_("Back"), lambda: self.panel.open(self.page)))))

    def _judge(self):
        """At each key: whether the diameter can be that of this cut."""
        kind, text = plausible(self._keypad.text, self.page.expected(), self.page.by_radius)
        for each in ("good", "warn"):
            self._judged.get_style_context().remove_class(each)
        self._judged.get_style_context().add_class(kind)
        self._judged.set_text(text)

    def _enter(self):
        refusal = self.panel.access.refusal("operator")
        kind, words = plausible(self._keypad.text, self.page.expected(), self.page.by_radius)
        try:
            if refusal:
                raise ValueError(refusal)
            if kind == "warn":
                raise ValueError(words.replace("\u25b2 ", ""))
            self.page.enter(self._keypad.text)
        except ValueError as error:
            self.panel.say(_("\"{text}\" is no diameter: {why}").format(text=self._keypad.text, why=error), "bad")
            return
        self.panel.open(self.page)


def plausible(text, expected, by_radius=False):
    """Kind and sentence of an entry, before it is sent: a diameter, or the radius that the component takes. `expected` is the diameter."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return "good", ""
    if not expected or not math.isfinite(value):
        return "good", ""
    expected = expected / 2 if by_radius else expected
    shown = with_unit(float(expected), "mu")
    other = (2.0, _("That is the diameter: enter the radius.")) if by_radius else (0.5, _("That is the radius: enter the diameter."))
    for factor, words in (other, (1 / 25.4, _("That is in inches: enter it in the unit of the machine.")),
                          (25.4, _("That is in millimetres: enter it in the unit of the machine."))):
        if abs(value / (expected * factor) - 1) < 0.1:
            return "warn", "\u25b2 " + words
    if abs(value / expected - 1) > 0.2:
        words = _("The programmed radius is {expected}. Measure again.") if by_radius else _("The programmed diameter is {expected}. Measure again.")
        return "warn", "\u25b2 " + words.format(expected=shown)
    return "good", _("{difference} from the programmed {expected}.").format(difference=in_micrometres(value - expected), expected=shown)


class HeightPicture(Gtk.DrawingArea):
    """The work from its end, its axis, and the tool's edge with its uncertainty; heights are enlarged."""

    def __init__(self, page):
        super().__init__()
        self._page, self._height = page, None
        self.set_size_request(300, 210)
        self.connect("draw", self._draw)
        named(self, _("Tool and centre"))

    def show_height(self, height, sigma):
        if (height, sigma) != self._height:
            self._height = (height, sigma)
            self.queue_draw()

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._page.panel.dark
        middle, radius = height / 2, height * 0.44
        centre = width * 0.35
        cairo.set_line_width(2)
        cairo.arc(centre, middle, radius, 0, 2 * math.pi)
        cairo.set_source_rgb(*styles.colour(dark, "pick"))
        cairo.fill_preserve()
        cairo.set_source_rgb(*styles.colour(dark, "line"))
        cairo.stroke()
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.set_dash([12, 4, 2, 4])
        cairo.move_to(8, middle)
        cairo.line_to(width - 8, middle)
        cairo.stroke()
        cairo.set_dash([])
        if not self._height or self._height[0] is None or not math.isfinite(self._height[0]):
            return
        its, sigma = self._height
        largest = max(abs(its) + 2 * sigma, 1e-6)
        scale = radius * 0.6 / largest
        edge = middle - its * scale
        cairo.set_source_rgb(*styles.colour(dark, "curve2"))
        cairo.move_to(centre + radius * 0.85, edge)
        cairo.line_to(width - 30, edge)
        cairo.line_to(width - 30, edge + 34)
        cairo.line_to(centre + radius * 0.85 + 16, edge + 34)
        cairo.close_path()
        cairo.fill()
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.set_line_width(3)
        cairo.move_to(centre + radius * 0.85, edge - 2 * sigma * scale)
        cairo.line_to(centre + radius * 0.85, edge + 2 * sigma * scale)
        cairo.stroke()
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(17)
        cairo.move_to(centre + radius + 12, edge - 8 if its >= 0 else edge + 54)
        cairo.show_text(in_micrometres(float(its)))

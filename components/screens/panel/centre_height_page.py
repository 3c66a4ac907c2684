# SPDX-License-Identifier: GPL-2.0-or-later
"""centre_height: the next step, the entry of diameters, and the result as a picture of tool and centre."""

import math

from panel import access, centre_height_state, status, texts
from panel.function_page import EntryPage, FunctionPage
from panel.picture import Picture
from panel.texts import _, in_micrometres, number, unit_name, with_unit
from panel.widgets import Figures, Keypad, button, card, choose, clear, column, flow, grow, label, row, scrolled, set_text


class CentreHeightPage(FunctionPage):
    function = "centre_height"
    place = 3
    _turns = False  # M455 turns the lands, by hand
    live = ("x-position-0", "y-position-0", "diameter")

    # Name, method, fewest cuts, and how to cut them.
    METHODS = (
        ("Two lands", 1, 4, "The machine turns each land and stops the spindle; you measure it. Put the tool clear in X, where the lands begin: each takes 3 mm of Z."),
        ("Two cuts", 0, 2, "Both cuts on one land at the present Y, the second one deeper. They do not show the sign."),
        ("Step of Y", 2, 2, "Cuts on one land, each deeper and at another Y."),
    )  # for gettext: _("Two cuts"), _("Two lands"), _("Step of Y")
    # for gettext: _("The machine turns each land and stops the spindle; you measure it. Put the tool clear in X, where the lands begin: each takes 3 mm of Z.")
    # for gettext: _("Both cuts on one land at the present Y, the second one deeper. They do not show the sign.")
    # for gettext: _("Cuts on one land, each deeper and at another Y.")
    LANDS = 1
    SAME_Y = 0.001  # mu
    LENGTH, FEED = 3, 200  # of a land, mm and mm/min
    SMALLEST = 0.9  # to which the trial stock may be turned, of the lands

    def content(self):
        self._picture = HeightPicture(self)
        self._figures = Figures(_("Height"), _("Uncertainty (k=2)"), _("Move of Y"), _("Cuts"))
        self._step, self._sent, self._shown = label("", "value"), [], None
        self._ys, self._y_origin = {}, None  # where the cuts were ended here, and where Y was at the beginning
        self._entered = column(spacing=4)
        self._expected_now = {}  # the diameter that centre_height expects, by cut
        self._seconds = {}  # readings a quarter turn further, by cut
        return [card(label(_("Next step"), "soft"), self._step, self._entered), self._figures, self._picture]

    def buttons(self):
        begin = [self.remedy("start", button(_("Begin: {method}").format(method=_(method[0])), lambda method=method: self.panel.open(
            BeginPage(self.panel, self, method)), name=_(method[0]))) for method in self.METHODS]
        interrupt = button(_("Interrupt"), lambda: self._do(_("Interrupt"), "abort", "O <height_abort> call"))
        enter = button(_("Enter the radius") if self.by_radius else _("Enter the diameter"), lambda: self.panel.open(DiameterPage(self.panel, self)))
        resume = button(_("Continue"), lambda: self._do(_("Continue"), "resume", "M453"))
        self._turn_button = self.remedy("cut-done", button(_("Turn the next land"), self._turn))
        self._next = {  # the buttons of a step, by step
            centre_height_state.CUTS: [self.remedy("cut-done", button(_("The cut is done"), self._end_cut)), interrupt],
            centre_height_state.WAITS: [self.remedy("enter", enter), interrupt],
            centre_height_state.KNOWN: [self.remedy("store", button(_("Store the height: M454"), self._store)), *begin],
            centre_height_state.INTERRUPTED: [self.remedy("resume", resume), *begin],
        }
        self._begin = begin
        return [*begin, self._turn_button, *[its[0] for its in self._next.values()], interrupt]

    def _y(self):
        """Of this moment: values of the last look may be those before a move."""
        return self.panel.hal.get(self.instance.full("y-position-%d" % self.get(self.panel.values, "post")))

    def _end_cut(self):
        self._ys[self.get(self.panel.values, "cut-number") + 1] = self._y()
        self._do(_("The cut is done"), "cut-done", "M451")

    def _turn(self):
        """M453 clears X, moves Y, starts the spindle, turns the land, clears X and stops the spindle."""
        cut = self.get(self.panel.values, "cut-number") + 1
        self._expected_now[cut] = self.get(self.panel.values, "next-diameter", 0.0)
        if not self.get(self.panel.values, "check-due"):
            self._ys[cut] = self._y_of_land(cut)
        self._do(_("Turn the next land"), "resume", "M453")

    def guidance(self, values):
        """The next step in words, with the figures that it needs."""
        get = lambda short, otherwise=0.0: self.get(values, short, otherwise)  # noqa: E731
        state = centre_height_state.step(self.instance, values)
        if self._turns and (state == centre_height_state.CUTS or get("check-due", False)):
            if get("check-due", False):
                return _("Touch \"Turn the next land\": the check, 0.1 mm deeper into the last land. The spindle starts.")
            return _("Touch \"Turn the next land\". The spindle starts.")
        if state == centre_height_state.CUTS:
            cut = get("cut-number", 0) + 1
            if self.method(values) == self.LANDS:
                y = self._y_of_land(cut)
                return _("Turn land {cut}: move Y by {y} from where you began, and X to a diameter of {diameter}. Then touch \"The cut is done\" "
                         "while the tool stands at its end.").format(cut=cut, y=with_sign(y), diameter=with_unit(get("land-diameter"), "mu"))
            return _("Turn cut {cut}. Then touch \"The cut is done\" while the tool stands at its end.").format(cut=cut)
        if state == centre_height_state.WAITS:
            if self.by_radius:
                return _("Retract X, stop the spindle, measure cut {cut}, and enter its radius.").format(cut=get("cut-number", 0) + 1)
            if self._turns:
                return _("Wait until the spindle stands. Measure the land that was turned last, and enter its diameter.")
            return _("Retract X, stop the spindle, measure cut {cut}, and enter its diameter.").format(cut=get("cut-number", 0) + 1)
        if state == centre_height_state.KNOWN:
            its = status.of(self.instance, values)
            if its.button == "store":
                return _("Store the height. Then move Y to 0, turn, and measure again until the tool is on centre.")
            return its.remedy or _("The tool is on centre. Nothing to do.")
        if state == centre_height_state.INTERRUPTED:
            return _("Continue with the cuts that have their diameter, or begin again.")
        return _("Load the tool, start the spindle, move Y to 0, and choose a method.")

    def method(self, values):
        """That of the program, or of the pin."""
        return int(self.get(values, "program-method", 0)) - 1 if self.get(values, "program-method", 0) >= 1 else self.get(values, "method", 0)

    def begin(self, method, cuts, diameter, stock=""):
        """`diameter` and `stock` are texts of the operator. Raises ValueError."""
        value = diameter_of(diameter)
        self._sent, self._ys, self._y_origin, self._expected_now, self._seconds, self._turns = [], {}, self._y(), {}, {}, False
        if "start" in self.instance.settings():
            for short, text in (("method", str(method)), ("cuts", str(cuts)), ("land-diameter", repr(value))):
                if short in self.instance.settings():
                    self.panel.write(self.instance.full(short), text, "button")
            self.panel.pulse(self.instance.full("start"))
        elif method == self.LANDS:
            self._turns = True
            self._ys[1] = self._y_of_land(1)
            inch = 25.4 if texts.MACHINE_UNIT[0] == "in" else 1
            own = texts.for_program
            self.panel.mdi("M455 D[%s] E[%s] Z[#<_z>] K[%s] Q%d P[%s] R[#<_x> / [1 + #<_lathe_diameter_mode>]] L1" % (
                own(value), own(diameter_of(stock)), own(self.LENGTH / inch), cuts // 2, own(self.FEED / inch)), _("Begin"))
        else:
            self.panel.mdi("M450 P%d Q%d D[%s]" % (method, cuts, texts.for_program(value)), _("Begin"))

    def _do(self, action, pin, line):
        """By the pin, where nothing else writes it; else by the M-code of the configuration."""
        def do():
            if pin in self.instance.settings():
                self.panel.pulse(self.instance.full(pin))
            else:
                self.panel.mdi(line, action)

        self.panel.guard.at_once(action, do)

    def off(self, values):
        """Why no M-code runs now; '' if it does, or if pins give the orders."""
        return "" if "start" in self.instance.settings() else access.unsafe(values)

    def takes_none(self, values, cut):
        """Why no diameter is taken now: of the cut that waits, or of one that has its diameter; '' if it is."""
        state = centre_height_state.step(self.instance, values)
        takes = state not in (0, centre_height_state.INTERRUPTED) if cut else state == centre_height_state.WAITS
        return "" if takes else " ".join(status.kind_and_words(self.instance, values)[1:])

    def reads_twice(self, cut):
        """Whether the cut that waits, or one that was entered before, has two readings, a quarter turn apart."""
        return cut in self._seconds if cut else self.get(self.panel.values, "reads-twice", False)

    def enter(self, text, cut=0, second=""):
        """The diameter of the last cut, or of one that was entered before, and a second reading if it has one. Raises ValueError."""
        value = diameter_of(text)
        former = self.value_of(cut)
        number = cut or self.get(self.panel.values, "cut-number") + 1
        words = former_words = ""
        if second:
            words, former_words = (" R[%s]" % texts.for_program(its) for its in (diameter_of(second), self._seconds.get(number, value)))
            self._seconds[number] = diameter_of(second)
        if "entered" in self.instance.settings():
            self.panel.write(self.instance.full("entered-cut"), str(cut), "button")
            self.panel.write(self.instance.full("entered-diameter"), repr(value), "button")
            if "second-diameter" in self.instance.settings():
                self.panel.write(self.instance.full("second-diameter"), repr(diameter_of(second) if second else 0.0), "button")
            self.panel.pulse(self.instance.full("entered"))
        else:
            undo = "M452 P[%s]%s Q%d" % (texts.for_program(former), former_words, cut) if cut else "M452 Q-%d" % number
            self.panel.mdi("M452 P[%s]" % texts.for_program(value) + words + (" Q%d" % cut if cut else ""), _("Enter the diameter"), undo=undo)
        if cut:
            self._sent[cut - 1] = value
        else:
            self._sent[self.get(self.panel.values, "cut-number"):] = [value]

    def value_of(self, cut):
        """What was entered here for a cut; None for another one."""
        return self._sent[cut - 1] if 0 < cut <= len(self._sent) else None

    def _show_entered(self, values):
        """A button for each diameter, which corrects it."""
        count = self.get(values, "cut-number")
        if not centre_height_state.step(self.instance, values):
            self._sent.clear()
        del self._sent[count + 1:]
        if self._sent[:count] == self._shown:
            return
        self._shown = self._sent[:count]
        clear(self._entered)
        for cut, value in enumerate(self._shown, start=1):
            if value is not None:
                text = _("Correct cut {cut}: {value}").format(cut=cut, value=with_unit(value, "mu"))
                self._entered.pack_start(button(text, lambda cut=cut: self.panel.open(DiameterPage(self.panel, self, cut)),
                                                name=_("Correct cut {cut}").format(cut=cut)), False, False, 0)
        self._entered.show_all()

    @property
    def by_radius(self):
        """Whether the component takes the radius of a cut."""
        return self.get(self.panel.values, "gauge-kind") == 1

    def expected(self, cut):
        """The diameter that a tool on centre leaves; 0 while it is unknown."""
        values = self.panel.values
        if self._expected_now.get(cut):
            return self._expected_now[cut]
        if self.method(values) != self.LANDS:
            return 0.0
        y = self._ys[cut] - self._y_origin if self._y_origin is not None and cut in self._ys else self._y_of_land(cut)
        return 2 * math.hypot(self.get(values, "land-diameter", 0.0) / 2, y)

    def _y_of_land(self, cut):
        """Land 1, land 2, land 2, land 1: wear and warming cancel."""
        return self.get(self.panel.values, "land-1-y" if cut % 4 in (0, 1) else "land-2-y", 0.0)

    def twin(self, cut):
        """A cut at the same Y that was entered here, and its value; None, None without one."""
        for other, value in enumerate(self._sent, start=1):
            known = other != cut and value is not None and other in self._ys and cut in self._ys
            if known and self.method(self.panel.values) == self.LANDS and abs(self._ys[other] - self._ys[cut]) < self.SAME_Y:
                return other, value
        return None, None

    def scatter(self):
        """By which two cuts at the same Y may differ in diameter."""
        values = self.panel.values
        return 5 * math.hypot(self.get(values, "gauge-sigma", 0.0), 2 * self.get(values, "cut-repeatability", 0.0))

    def _store(self):
        smallest = self.SMALLEST * self.get(self.panel.values, "land-diameter", 0.0)
        line = "M454 D[%s]" % texts.for_program(smallest) if self._turns else "M454"
        then = _("The spindle starts, and a land 0.1 mm deeper must show it; the trial stock is turned to no less than {diameter}.").format(
            diameter=with_unit(smallest, "mu")) if self._turns else _("It is not checked by a land.")
        self.panel.guard.once_asked(lambda: (_("Store the height in the tool table? Y moves by {move} with its next word.").format(
            move=in_micrometres(self.get(self.panel.values, "y-move", 0.0))) + " " + then, []),
                        _("Store the height"), lambda: self.panel.mdi(line, _("Store the height")))

    def refresh(self, values):
        super().refresh(values)
        set_text(self._step, self.guidance(values))
        self._show_entered(values)
        state = centre_height_state.step(self.instance, values)
        may_store = status.of(self.instance, values).button == "store"
        wanted = self._next.get(state, self._begin) if state != centre_height_state.KNOWN or may_store else self._begin
        if self._turns and (state == centre_height_state.CUTS or self.get(values, "check-due")):
            wanted = [self._turn_button, *self._next[centre_height_state.CUTS][1:]]
        for its in {each for step in self._next.values() for each in step} | {self._turn_button, *self._begin}:
            its.get_parent().set_visible(its in wanted)
        valid = self.get(values, "value-valid")
        self._figures.show_value(_("Height"), in_micrometres(self.get(values, "height", 0.0)) if valid else "\u2013")
        self._figures.show_value(_("Uncertainty (k=2)"), "\u00b1" + centre_height_state.uncertainty(self.instance, values) if valid else "\u2013")
        self._figures.show_value(_("Move of Y"), in_micrometres(self.get(values, "y-move", 0.0)) if valid else "\u2013")
        self._figures.show_value(_("Cuts"), number(self.get(values, "cut-number")))
        self._picture.show_height(self.get(values, "height", 0.0) if valid else None, self.get(values, "sigma", 0.0))


def diameter_of(text):
    """Raises ValueError."""
    value = float(text.replace(",", "."))
    if not value > 0 or not math.isfinite(value):
        raise ValueError(_("A diameter is above 0."))
    return value


def with_sign(value):
    return ("+" if value >= 0 else "") + with_unit(float(value), "mu")


class BeginPage(EntryPage):
    """Number of cuts and diameter of a method, and of lands the diameter of the stock, before it begins."""

    CUTS = (2, 4, 8)

    def __init__(self, panel, page, method, diameter=""):
        self.page = self.back = page
        self._of, self._diameter = method, diameter  # of the first page
        self._name, self._method, self._fewest, self._how = method
        super().__init__(panel)

    @property
    def title(self):
        return _("Begin: {method}").format(method=_(self._name))

    @property
    def _asks_for_stock(self):
        return self._method == self.page.LANDS and "start" not in self.page.instance.settings()

    def build(self):
        self._keypad = Keypad("")
        self._choices, cuts = {}, []
        if not self._diameter:
            for count in self.CUTS:
                self._choices[count] = button(_("{count} cuts").format(count=count), lambda count=count: self._choose(count), "key")
            self._choose(self._fewest)
            cuts = [label(_(self._how)), flow(*self._choices.values())]
        asked = _("Diameter of the stock, measured") if self._diameter else _("Diameter to turn, without the error of the tool")
        last = self._diameter or not self._asks_for_stock
        return scrolled(column(label(self.title, "title"), *cuts, label(asked, "value"),
                               row(grow(self._keypad), label(unit_name("mu"), "value", wrap=False)),
                               flow(button(_("Begin"), self._begin, "main") if last else button(_("Next"), self._ask, "main"),
                                    button(_("Back"), lambda: self.panel.open(self.page)))))

    def _choose(self, cuts):
        self._cuts = cuts
        for each, its in self._choices.items():
            choose(its, each == cuts)

    def _ask(self):
        """The next page, for the stock."""
        try:
            diameter_of(self._keypad.text)
        except ValueError as error:
            self._refuse(error)
            return
        following = BeginPage(self.panel, self.page, self._of, self._keypad.text)
        following._cuts = self._cuts
        self.panel.open(following)

    def _refuse(self, error):
        self.panel.say(_("\"{text}\" was not entered: {why}").format(text=self._keypad.text, why=error), "bad")

    def _begin(self):
        refusal = self.panel.access.refusal("operator") or self.page.off(self.panel.guard.values())
        if refusal:
            self.panel.say(_("{action}: refused. {why}").format(action=_("Begin"), why=refusal), "warn")
            return
        try:
            if self._diameter:
                self.page.begin(self._method, self._cuts, self._diameter, self._keypad.text)
            else:
                self.page.begin(self._method, self._cuts, self._keypad.text)
        except ValueError as error:
            self._refuse(error)
            return
        self.panel.open(self.page)


class DiameterPage(EntryPage):
    """The entry of a measured diameter, judged when it is entered: of the cut that waits, or of `cut`, whose entry was wrong. What is expected does not
    show before: who knows it reads it."""

    def __init__(self, panel, page, cut=0, first=""):
        self.page = self.back = page
        self._corrects, self._first = cut, first  # the first of two readings
        self._cut = cut or page.get(panel.values, "cut-number") + 1
        super().__init__(panel)

    @property
    def title(self):
        text = _("Radius of cut {cut}") if self.page.by_radius else _("Diameter of cut {cut}")
        return text.format(cut=self._cut) + (_(", a quarter turn further") if self._first else "")

    def build(self):
        former = self.page.value_of(self._corrects)
        self._keypad = Keypad("")
        facts = [] if former is None else [label(_("Entered before: {value}").format(value=with_unit(former, "mu")), "value")]
        return scrolled(column(label(self.title, "title"), *facts, row(grow(self._keypad), label(unit_name("mu"), "value", wrap=False)),
                               flow(button(_("Enter"), self._enter, "main"), button(_("Back"), lambda: self.panel.open(self.page)))))

    def _plausible(self):
        other, value = self.page.twin(self._cut)
        return plausible(self._keypad.text, self.page.expected(self._cut), self.page.by_radius, other, value, self.page.scatter())

    def _enter(self):
        kind, words = self._plausible()
        if kind == "doubt":
            self.panel.ask(_("{why} Enter it all the same?").format(why=words[2:]), _("Enter all the same"), self._send)
        else:
            self._send()

    def _send(self):
        refusal = self.panel.access.refusal("operator") or self.page.takes_none(self.panel.guard.values(), self._corrects)
        if refusal:
            action = _("Enter the radius") if self.page.by_radius else _("Enter the diameter")
            self.panel.say(_("{action}: refused. {why}").format(action=action, why=refusal), "warn")
            return
        kind, words = self._plausible()
        try:
            if kind == "warn":
                raise ValueError(words[2:])
            if self.page.reads_twice(self._corrects) and not self._first:
                diameter_of(self._keypad.text)
                self.panel.open(DiameterPage(self.panel, self.page, self._corrects, self._keypad.text))
                return
            self.page.enter(self._first or self._keypad.text, self._corrects, self._keypad.text if self._first else "")
        except ValueError as error:
            self.panel.say(_("\"{text}\" was not entered: {why}").format(text=self._keypad.text, why=error), "bad")
            return
        self.panel.open(self.page)
        if words:
            self.panel.say(words[2:], "good" if kind == "good" else "off")


def plausible(text, expected, by_radius=False, other=None, value_of_other=None, scatter=0.0):
    """Kind and sentence of an entry, before it is sent: a diameter, or the radius that the component takes.

    `expected` is the diameter that a tool on centre leaves. `other` is a cut at the same Y that was entered before: only it can confirm an entry.
    """
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return "off", ""
    if not expected or not math.isfinite(value):
        return "off", ""
    expected = expected / 2 if by_radius else expected
    shown = with_unit(round(float(expected), 4), "mu")
    slip = (2.0, _("That is the diameter: enter the radius.")) if by_radius else (0.5, _("That is the radius: enter the diameter."))
    for factor, words in (slip, (1 / 25.4, _("That is in inches: enter it in the unit of the machine.")),
                          (25.4, _("That is in millimetres: enter it in the unit of the machine."))):
        if abs(value / (expected * factor) - 1) < 0.1:
            return "warn", "\u25b2 " + words
    if abs(value / expected - 1) > 0.2:
        words = _("A tool on centre leaves the radius {expected}. Measure again.") if by_radius else _("A tool on centre leaves the diameter {expected}. Measure again.")
        return "warn", "\u25b2 " + words.format(expected=shown)
    if other is not None:
        away = in_micrometres(value - value_of_other)
        if abs(value - value_of_other) > scatter:
            return "doubt", "\u25b2 " + _("{difference} from cut {cut} at the same Y. Read it again.").format(difference=away, cut=other)
        return "good", "\u2714 " + _("{difference} from cut {cut} at the same Y.").format(difference=away, cut=other)
    return "off", "\u25cb " + _("{difference} from {expected}, which a tool on centre leaves. No other cut confirms it yet.").format(
        difference=in_micrometres(value - expected), expected=shown)


class HeightPicture(Picture):
    """The work from its end, its axis, and the tool's edge with its uncertainty; heights are enlarged."""

    def __init__(self, page):
        super().__init__(page.panel, _("Tool and centre"), (300, 210))
        self._height = None

    def show_height(self, height, sigma):
        if (height, sigma) != self._height:
            self._height = (height, sigma)
            self.queue_draw()

    def draw(self, pen, width, height):
        middle, radius = height / 2, height * 0.44
        centre = width * 0.35
        pen.disc(centre, middle, radius, "pick", "line")
        pen.line((8, middle), (width - 8, middle), dashes=(12, 4, 2, 4))
        if not self._height or self._height[0] is None or not math.isfinite(self._height[0]):
            return
        tip, sigma = self._height
        scale = radius * 0.6 / max(abs(tip) + 2 * sigma, 1e-6)
        x, edge, end = centre + radius * 0.85, middle - tip * scale, width - 30
        pen.shape((x, edge), (end, edge), (end, edge + 34), (x + 16, edge + 34), colour="curve2")
        pen.line((x, edge - 2 * sigma * scale), (x, edge + 2 * sigma * scale), width=3)
        pen.words(centre + radius + 12, edge - 8 if tip >= 0 else edge + 54, in_micrometres(float(tip)), 17)

# SPDX-License-Identifier: GPL-2.0-or-later
"""chopping: what the axis does, its stroke and sections, and the buttons of the operator."""

import math

from panel import chopping_orders as orders, effects
from panel.chopping_stroke_page import SectionsPage, StrokePage
from panel.function_page import FunctionPage
from panel.picture import Picture
from panel.texts import _, in_micrometres, number, position, with_unit
from panel.widgets import Figures, button, card, label, set_text


class ChoppingPage(FunctionPage):
    function = "chopping"
    place = 4
    live = ("position", "joint-feedback", "applied-offset")

    def content(self):
        self._picture = StrokePicture(self)
        self._figures = Figures(_("Upper dead point"), _("Lower dead point"), _("Strokes"), _("Cycle time"), _("Out of the work within"), _("Speed of the stroke"),
                                _("Point R"), _("Command"), _("Measured"))
        self._learned = label("")
        return [self._figures, self._picture, card(label(_("Learned correction"), "value"), self._learned)]

    def buttons(self):
        """Those whose pins have no other writer. They set pins alone, so LinuxCNC's task and io may be dead."""
        own = self.instance.settings()
        its = []
        if "stop" in own:
            its.append(self.remedy("stop", button(_("Stop strokes"), self._stop, "stop")))
        if "feed-hold" in own:
            its.append(self.remedy("hold", button(_("Hold / go on"), self._hold)))
        if "go-to-end" in own:
            its.append(self.remedy("to-end", button(_("To point R"), self._withdraw)))
        if orders.way(self.instance, self.panel.ini):
            its.append(self.remedy("start", button(_("Ends and start"), lambda: self.panel.open(StrokePage(self.panel, self)))))
        if orders.sections(self.instance):
            its.append(button(_("Sections"), lambda: self.panel.open(SectionsPage(self.panel, self))))
        if "override" in own:
            its += [button(_("Slower"), lambda: self._faster(-0.05)), button(_("Faster"), lambda: self._faster(0.05))]
        return its

    def _stop(self):
        """The end of strokes comes without a question, on each screen."""
        self.panel.guard.at_once(_("Stop strokes"), lambda: self.panel.pulse(self.instance.full("stop")), needed="view")

    def _withdraw(self):
        def question():
            values = self.panel.guard.values()
            away = effects.Move(_("the stroking axis"), -float(self.get(values, "offset")), True)
            return _("Move the axis to point R?"), [] if self.get(values, "active") else [away]

        self.panel.guard.once_asked(question, _("Move the axis"), lambda: self.panel.pulse(self.instance.full("go-to-end")), must_be_safe=False)

    def _hold(self):
        """A hold comes at once; the axis goes on after a question."""
        pin = self.instance.full("feed-hold")
        if not self.panel.hal.get(pin):
            self.panel.guard.at_once(_("Hold / go on"), lambda: self.panel.write(pin, "1", "button"), needed="view")
        else:
            self.panel.guard.once_asked(lambda: (_("Go on with the strokes?"), []), _("Go on"), lambda: self.panel.write(pin, "0", "button"), must_be_safe=False)

    def _faster(self, step):
        pin = self.instance.full("override")
        self.panel.guard.at_once(_("Faster") if step > 0 else _("Slower"), lambda: self.panel.write(
            pin, "%.2f" % min(1.5, max(0.05, self.panel.hal.get(pin) + step)), "button"))

    def refresh(self, values):
        super().refresh(values)
        get = lambda short, otherwise=0.0: self.get(values, short, otherwise)  # noqa: E731
        self._figures.show_value(_("Speed of the stroke"), "%.0f %%" % (100 * get("override", 1.0)))
        self._figures.show_value(_("Upper dead point"), position(get("measured-upper")))
        self._figures.show_value(_("Lower dead point"), position(get("measured-lower")))
        self._figures.show_value(_("Strokes"), number(get("stroke-count", 0)))
        self._figures.show_value(_("Cycle time"), "%.3f s" % get("actual-cycle-time"))
        self._figures.show_value(_("Out of the work within"), "%.1f s" % get("way-out-time"))
        self._figures.show_value(_("Point R"), position(get("end-position")))
        self._figures.show_value(_("Command"), position(get("command")))
        self._figures.show_value(_("Measured"), position(get("measured-position")))
        set_text(self._learned, _("above {upper}, below {lower}; errors {upper_error} and {lower_error}; {state}").format(
            upper=in_micrometres(get("upper-correction")), lower=in_micrometres(get("lower-correction")),
            upper_error=in_micrometres(get("upper-error")), lower_error=in_micrometres(get("lower-error")),
            state=_("learned") if get("learned", False) else _("not learned")))
        self._picture.show_values({short: get(short) for short in StrokePicture.SHORTS})


class StrokePicture(Picture):
    """The region of the stroke with its sections, and where the axis is."""

    SHORTS = ("upper", "lower", "phase", "command", "offset", "position") + tuple(
        "section-%d-%s" % (place, part) for place in range(orders.MOST_SECTIONS) for part in ("kind", "from", "to", "ratio"))

    def __init__(self, page):
        super().__init__(page.panel, _("Stroke and sections"), (300, 230))
        self._values = None

    def show_values(self, values):
        if values != self._values:
            self._values = values
            self.queue_draw()

    def draw(self, pen, width, height):
        values = self._values
        if not values:
            return
        upper, lower = values["upper"], values["lower"]
        span = upper - lower
        if not math.isfinite(span) or span <= 0:
            return
        top, bottom, left = 26, height - 26, width * 0.3

        def y(place):
            return bottom - (place - lower) / span * (bottom - top)

        pen.box(left, top, 60, bottom - top, "pick", "good", 3)
        for place in range(orders.MOST_SECTIONS):
            kind, start, end, ratio = (values["section-%d-%s" % (place, part)] for part in ("kind", "from", "to", "ratio"))
            if not kind:
                continue
            if kind == 1:  # phases, as heights on the way up
                start, end = (lower + span * (1 - math.cos(math.radians(phase))) / 2 for phase in (start, end))
            pen.box(left + 64, y(max(start, end)), 40, abs(y(start) - y(end)), "curve2")
            pen.words(left + 112, (y(start) + y(end)) / 2 + 5, "%g %%" % (ratio * 100), 16)
        for place, words in ((upper, _("upper")), (lower, _("lower"))):
            pen.words(10, y(place) + 6, "%s %s" % (words, with_unit(round(place, 4), "mu")), 16)
        here = values["position"] + values["offset"]
        if math.isfinite(here):
            pen.disc(left + 30, max(top - 8, min(bottom + 8, y(here))), 9)

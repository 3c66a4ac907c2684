# SPDX-License-Identifier: GPL-2.0-or-later
"""chopping and thermal_growth_test."""

import collections
import math
import os
import subprocess

from gi.repository import Gtk

from panel import style as styles
from panel.chart import Chart, History
from panel.function_page import FunctionPage
from panel.growth_logs import last_log
from panel.growth_test_state import LiveDrift, remaining
from panel.pages import state_of
from panel.texts import _, in_micrometres, number, seconds
from panel.widgets import Figures, button, card, label, named, set_text


class ChoppingPage(FunctionPage):
    heading = "Chopping"  # for gettext: _("Chopping")

    def verdict(self, values):
        kind, text = super().verdict(values)
        if kind != "bad" and self.get(values, "withdrawing") and not self.get(values, "held"):
            return "warn", _("The axis is on its way to point R.")
        if kind != "bad" and self.get(values, "feed-wait"):
            return "warn", _("Moves wait until the axis is at point R. Jogs do not wait: jog another axis, not this one.")
        if kind != "good":
            return kind, text
        if self.get(values, "held"):
            return "warn", _("The axis stands for a hold.")
        if self.get(values, "active"):
            return "good", _("Strokes. {count} strokes so far.").format(count=self.get(values, "stroke-count"))
        if not self.get(values, "enable", True):
            return "off", _("At rest. Strokes are not permitted now.")
        return "off", _("At rest.")

    def content(self):
        self._picture = StrokePicture(self)
        self._figures = Figures(_("Upper dead point"), _("Lower dead point"), _("Strokes"), _("Cycle time"), _("Speed of the stroke"),
                                _("Point R"), _("Command"), _("Measured"))
        self._learned = label("")
        return [self._figures, self._picture, card(label(_("Learned correction"), "value"), self._learned)]

    def buttons(self):
        """Those whose pins have no other writer. They set pins alone, so LinuxCNC's task and io may be dead."""
        own = self.instance.settings()
        its = []
        if "stop" in own:
            its.append(button(_("Stop"), self._stop))
        if "go-to-end" in own:
            its.append(button(_("To point R"), lambda: self.panel.move(
                _("Move the axis to point R?"), _("Move the axis"), lambda: self.panel.pulse(self.instance.full("go-to-end")), must_be_safe=False)))
        if "feed-hold" in own:
            its.append(button(_("Hold / go on"), self._hold))
        if "override" in own:
            its += [button(_("Slower"), lambda: self._faster(-0.05)), button(_("Faster"), lambda: self._faster(0.05))]
        return its

    def _stop(self):
        """The end of strokes comes without a question."""
        refusal = self.panel.access.refusal("operator")
        if refusal:
            self.panel.say(refusal, "warn")
        else:
            self.panel.pulse(self.instance.full("stop"))

    def _hold(self):
        """A hold comes at once; the axis goes on after a question."""
        pin = self.instance.full("feed-hold")
        refusal = self.panel.access.refusal("operator")
        if refusal:
            self.panel.say(refusal, "warn")
        elif not self.panel.hal.get(pin):
            self.panel.hal.set(pin, "1")
        else:
            self.panel.move(_("Go on with the strokes?"), _("Go on"), lambda: self.panel.hal.set(pin, "0"), must_be_safe=False)

    def _faster(self, step):
        refusal = self.panel.access.refusal("operator")
        if refusal:
            self.panel.say(refusal, "warn")
            return
        pin = self.instance.full("override")
        self.panel.hal.set(pin, "%.2f" % min(1.5, max(0.05, self.panel.hal.get(pin) + step)))

    def refresh(self, values):
        super().refresh(values)
        get = lambda short, otherwise=0.0: self.get(values, short, otherwise)  # noqa: E731
        self._figures.show_value(_("Speed of the stroke"), "%.0f %%" % (100 * get("override", 1.0)))
        self._figures.show_value(_("Upper dead point"), "%.4f" % get("measured-upper"))
        self._figures.show_value(_("Lower dead point"), "%.4f" % get("measured-lower"))
        self._figures.show_value(_("Strokes"), number(get("stroke-count", 0)))
        self._figures.show_value(_("Cycle time"), "%.3f s" % get("actual-cycle-time"))
        self._figures.show_value(_("Point R"), "%.4f" % get("end-position"))
        self._figures.show_value(_("Command"), "%.4f" % get("command"))
        self._figures.show_value(_("Measured"), "%.4f" % get("measured-position"))
        set_text(self._learned, _("above {upper}, below {lower}; errors {upper_error} and {lower_error}; {state}").format(
            upper=in_micrometres(get("upper-correction")), lower=in_micrometres(get("lower-correction")),
            upper_error=in_micrometres(get("upper-error")), lower_error=in_micrometres(get("lower-error")),
            state=_("learned") if get("learned", False) else _("not learned")))
        self._picture.show_values({short: get(short) for short in StrokePicture.SHORTS})


class StrokePicture(Gtk.DrawingArea):
    """The region of the stroke with its sections, and where the axis is."""

    SHORTS = ("upper", "lower", "phase", "command", "offset", "position") + tuple(
        "section-%d-%s" % (place, part) for place in range(4) for part in ("kind", "from", "to", "ratio"))

    def __init__(self, page):
        super().__init__()
        self._page, self._values = page, None
        self.set_size_request(300, 230)
        self.connect("draw", self._draw)
        named(self, _("Stroke and sections"))

    def show_values(self, values):
        if values != self._values:
            self._values = values
            self.queue_draw()

    def _draw(self, _area, cairo):
        values = self._values
        if not values:
            return
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._page.panel.dark
        upper, lower = values["upper"], values["lower"]
        span = upper - lower
        if not math.isfinite(span) or span <= 0:
            return
        top, bottom, left = 26, height - 26, width * 0.3

        def y(place):
            return bottom - (place - lower) / span * (bottom - top)

        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(16)
        cairo.rectangle(left, top, 60, bottom - top)
        cairo.set_source_rgb(*styles.colour(dark, "pick"))
        cairo.fill_preserve()
        cairo.set_source_rgb(*styles.colour(dark, "good"))
        cairo.set_line_width(3)
        cairo.stroke()
        for place in range(4):
            kind, start, end, ratio = (values["section-%d-%s" % (place, part)] for part in ("kind", "from", "to", "ratio"))
            if not kind:
                continue
            if kind == 1:  # phases, as heights on the way up
                start, end = (lower + span * (1 - math.cos(math.radians(phase))) / 2 for phase in (start, end))
            cairo.rectangle(left + 64, y(max(start, end)), 40, abs(y(start) - y(end)))
            cairo.set_source_rgb(*styles.colour(dark, "curve2"))
            cairo.fill()
            cairo.set_source_rgb(*styles.colour(dark, "text"))
            cairo.move_to(left + 112, (y(start) + y(end)) / 2 + 5)
            cairo.show_text("%g %%" % (ratio * 100))
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        for place, words in ((upper, _("upper")), (lower, _("lower"))):
            cairo.move_to(10, y(place) + 6)
            cairo.show_text("%s %.3f" % (words, place))
        here = values["position"] + values["offset"]
        if math.isfinite(here):
            at = max(top - 8, min(bottom + 8, y(here)))
            cairo.arc(left + 30, at, 9, 0, 2 * math.pi)
            cairo.fill()


_temperatures, _changes, _drifts = {}, {}, {}  # by instance: pages are built again when components come


class GrowthTestPage(FunctionPage):
    heading = "Growth test"  # for gettext: _("Growth test")

    def verdict(self, values):
        kind, text = state_of(self.instance, values)
        if kind == "bad":
            return kind, text
        if self.get(values, "stop-reason"):
            return "good", _(self.instance.sentence(values, "stop-reason-code"))
        if self.get(values, "state"):
            return "good", _(self.instance.sentence(values, "state-code"))
        return "off", _("No test runs.")

    def content(self):
        self._history = _temperatures.setdefault(self.instance.name, History(every=20))
        self._changes = _changes.setdefault(self.instance.name, collections.deque(maxlen=3 * 180))  # three hours
        self._figures = Figures(_("Elapsed"), _("Remaining"), _("Pass"), _("Change"))
        count = int(self.panel.values.get(self.instance.full("sensors"), 0))
        names = [_("Sensor {number}").format(number=place) for place in range(min(count, 3))]
        self._chart = Chart(self.panel, self._history, names, "\u00b0C")
        self._sensors = label("")
        self._bore, self._drift = label(""), label("")
        self._moved = _drifts.setdefault(self.instance.name, LiveDrift())
        return [self._figures, card(label(_("Temperatures"), "value"), self._sensors), self._chart,
                card(label(_("Drift of the bores without compensation, in X, Y and Z"), "value"), self._drift),
                card(label(_("Last bore"), "value"), self._bore)]

    def buttons(self):
        return [button(_("Stop the test"), self._stop), button(_("Make and open the report"), self._report)]

    def observe(self, values):
        get = lambda short: self.get(values, short, 0)  # noqa: E731
        self._moved.observe(get("visit"), get("at-bore"), not get("repeat"), (int(get("bore-key")), bool(get("turned"))),
                            tuple(float(get("bore-" + axis)) for axis in "xyz"))
        count = int(self.get(values, "sensors"))
        if not self._history.add(*[float(self.get(values, "temperature-%d" % place)) for place in range(min(count, 3))]):
            return
        elapsed = float(self.get(values, "elapsed", 0.0))
        if self._changes and elapsed < self._changes[-1][0]:  # another test
            self._changes.clear()
        self._changes.append((elapsed, float(self.get(values, "temperature-change", 0.0))))
        if self.panel.page is self:
            self._chart.queue_draw()

    def remaining(self, values):
        """The remaining time in words: the likely one with its bounds, or the bounds alone."""
        get = lambda short: float(self.get(values, short, 0.0))  # noqa: E731
        low, likely, high = remaining(self._changes, get("threshold"), get("elapsed"), get("minimum-time"), get("maximum-time"))
        bounds = "%s \u2013 %s" % (seconds(low), seconds(high))
        return bounds if likely is None else "%s (%s)" % (seconds(likely), bounds)

    def refresh(self, values):
        super().refresh(values)
        runs = self.get(values, "state") and not self.get(values, "stop-reason")
        self._figures.show_value(_("Elapsed"), seconds(self.get(values, "elapsed", 0.0)))
        self._figures.show_value(_("Remaining"), self.remaining(values) if runs else "\u2013")
        self._figures.show_value(_("Pass"), number(self.get(values, "pass")))
        change = self.get(values, "temperature-change", 0.0)
        self._figures.show_value(_("Change"), "\u2013" if change >= 1000 else "%.2f K" % change)
        lines = []
        for place in range(int(self.get(values, "sensors"))):
            valid = self.get(values, "temperature-valid-%d" % place)
            lines.append("%s %d: %s \u00b0C" % ("\u2714" if valid else "\u2716", place, number(float(self.get(values, "temperature-%d" % place)), 4)))
        set_text(self._sensors, "    ".join(lines) or _("No sensor is set up."))
        lines = [(_("Bore {number}, turned:") if turned else _("Bore {number}:")).format(number=bore) + "  " + "   ".join(map(in_micrometres, drift))
                 for (bore, turned), drift in sorted(self._moved.now.items())]
        set_text(self._drift, "\n".join(lines) or _("No bore has been probed since this screen began."))
        set_text(self._bore, "X %.4f   Y %.4f   Z %.4f   \u2300 %.4f" % tuple(
            self.get(values, short, 0.0) for short in ("bore-x", "bore-y", "bore-z", "bore-diameter")))

    def _stop(self):
        """The program's abort: LinuxCNC's own."""
        def abort():
            from panel.linuxcnc_access import abort as linuxcnc_abort

            linuxcnc_abort()

        self.panel.move(_("Stop the test? The program is aborted; the test can be resumed."), _("Stop the test"), abort, must_be_safe=False)

    def _report(self):
        folder = self.panel.ini.folder or "."
        try:
            log = last_log(os.path.join(folder, "logs"))
        except ValueError as error:
            self.panel.say(str(error), "warn")
            return
        if log is None:
            self.panel.say(_("There is no log of a test in {folder}.").format(folder=os.path.join(folder, "logs")), "warn")
            return
        output = os.path.join(folder, "report")
        done = subprocess.run([self.panel.program("plumb-growth"), "report", log, "--output", output],
                              capture_output=True, text=True, timeout=120, check=False)
        report = os.path.join(output, "report.html")
        if done.returncode:
            self.panel.say((done.stderr.strip().splitlines() or ["plumb growth"])[0], "bad")
            return
        subprocess.Popen(["xdg-open", report], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.panel.say(_("The report of {log} is {file}.").format(log=os.path.basename(log), file=report))

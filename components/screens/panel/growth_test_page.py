# SPDX-License-Identifier: GPL-2.0-or-later
"""thermal_growth_test: progress, temperatures, drift of the bores, stop and report."""

import collections
import contextlib
import os
import re
import subprocess

from panel import growth_test_state
from panel.chart import Chart, History
from panel.function_page import FunctionPage
from panel.growth_plan_card import PlanCard
from panel.growth_test_state import LiveDrift, remaining
from panel.texts import _, in_micrometres, number, position, seconds
from panel.widgets import Figures, button, card, label, set_text

RESUME, PLANNED = "resume.ngc", "planned.ngc"
CALL = re.compile(r"o<growth_test> call", re.I)


def programs_of_tests(ini):
    """[DISPLAY]OPEN_FILE, planned.ngc and resume.ngc, if they are beside the INI file and call the test."""
    found = []
    for name in (ini.get("DISPLAY", "OPEN_FILE"), PLANNED, RESUME):
        with contextlib.suppress(OSError):
            with open(os.path.join(ini.folder, name), encoding="utf-8", errors="replace") as file:
                if any(CALL.match(line.strip()) for line in file):
                    found.append(name)
    return found


_temperatures, _changes, _drifts = {}, {}, {}  # by instance: pages are built again when components come


class GrowthTestPage(FunctionPage):
    function = "thermal_growth_test"
    place = 5
    live = ("x-position", "y-position", "z-position", "table-position", "probe")

    def content(self):
        self._history = _temperatures.setdefault(self.instance.name, History(every=20))
        self._changes = _changes.setdefault(self.instance.name, collections.deque(maxlen=3 * 180))  # three hours
        self._figures = Figures(_("Elapsed"), _("Remaining"), _("Pass"), _("Change"))
        count = self._number_of_sensors()
        names = [_("Sensor {number}").format(number=place) for place in range(min(count, 3))]
        self._chart = Chart(self.panel, self._history, names, "\u00b0C")
        self._sensors = label("")
        self._bore, self._drift = label(""), label("")
        self._moved = _drifts.setdefault(self.instance.name, LiveDrift())
        return [self._figures, card(label(_("Temperatures"), "value"), self._sensors), self._chart,
                card(label(_("Drift of the bores without compensation, in X, Y and Z"), "value"), self._drift),
                card(label(_("Last bore"), "value"), self._bore), PlanCard(self.panel)]

    def _number_of_sensors(self):
        return sum(short.startswith("temperature-valid-") for short in self.instance.pins)

    def buttons(self):
        starts = [self.remedy("resume" if name == RESUME else "start", button(_("Start {program}").format(program=name), lambda name=name: self._start(name)))
                  for name in programs_of_tests(self.panel.ini)]
        return [button(_("Stop the test"), self._stop, "stop"), *starts, self.remedy("report", button(_("Make and open the report"), self._report))]

    def observe(self, values):
        get = lambda short: self.get(values, short, 0)  # noqa: E731
        self._moved.observe(get("visit"), get("at-bore"), not get("repeat"), (int(get("bore-key")), bool(get("turned"))),
                            tuple(float(get("bore-" + axis)) for axis in "xyz"))
        count = self._number_of_sensors()
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
        runs = self.get(values, "state-code") and not self.get(values, "stop-reason") and self.get(values, "state-code") != growth_test_state.INTERRUPTED
        self._figures.show_value(_("Elapsed"), seconds(self.get(values, "elapsed", 0.0)))
        self._figures.show_value(_("Remaining"), self.remaining(values) if runs else "\u2013")
        self._figures.show_value(_("Pass"), number(self.get(values, "pass")))
        change = self.get(values, "temperature-change", 0.0)
        self._figures.show_value(_("Change"), "\u2013" if change >= 1000 else "%.2f K" % change)
        lines = []
        for place in range(self._number_of_sensors()):
            valid = self.get(values, "temperature-valid-%d" % place)
            age = float(self.get(values, "temperature-age-%d" % place, 0.0))
            lines.append("%s %d: %s \u00b0C, %s" % ("\u2714" if valid else "\u2716", place, number(float(self.get(values, "temperature-%d" % place)), 4),
                                                  _("{age} old").format(age=seconds(age))))
        set_text(self._sensors, "\n".join(lines) or _("No sensor is set up."))
        lines = [(_("Bore {number}, turned:") if turned else _("Bore {number}:")).format(number=bore) + "  " + "   ".join(map(in_micrometres, drift))
                 for (bore, turned), drift in sorted(self._moved.now.items())]
        set_text(self._drift, "\n".join(lines) or _("No bore has been probed since this screen began."))
        set_text(self._bore, "   ".join("%s %s" % (name, position(self.get(values, short, 0.0))) for name, short in (
            ("X", "bore-x"), ("Y", "bore-y"), ("Z", "bore-z"), ("\u2300", "bore-diameter"))))

    def _start(self, name):
        action = _("Start {program}").format(program=name)
        interrupted = self.get(self.panel.values, "state-code") == growth_test_state.INTERRUPTED
        if name == RESUME and not growth_test_state.resumable(self.panel.machine, self.panel.values):
            why = self.verdict(self.panel.values)[1] if interrupted else _("There is no interrupted test.")
            self.panel.say(_("{action}: refused. {why}").format(action=action, why=why), "warn")
            return
        self.panel.guard.once_asked(lambda: (_("Start {program}? The axes move, and the probe touches.").format(program=name), []), action,
                                    lambda: self.panel.start(os.path.join(self.panel.ini.folder, name), action))

    def _stop(self):
        """LinuxCNC's own abort, at once."""
        self.panel.guard.at_once(_("Stop the test"), lambda: self.panel.abort(_("Stop the test")), needed="view")

    def _report(self):
        """Of the last log."""
        folder = self.panel.ini.folder or "."
        output = os.path.join(folder, "report")
        done = subprocess.run([self.panel.program("plumb-growth"), "report", os.path.join(folder, "logs"), "--output", output],
                              capture_output=True, text=True, timeout=120, check=False)
        report = os.path.join(output, "report.html")
        if done.returncode:
            self.panel.say((done.stderr.strip().splitlines() or ["plumb growth"])[0], "bad")
            return
        with contextlib.suppress(OSError):  # without xdg-open the message names the file
            subprocess.Popen(["xdg-open", report], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.panel.say(_("The report of {log} is {file}.").format(log=os.path.basename(done.stdout.split("\n", 1)[0]), file=report))

# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of squareness, circles before and after, the diagonals, and how sure the corrected volume is."""

import os

from panel import volume_state
from panel.function_page import EntryPage
from panel.texts import _, number
from panel.volume_pictures import CirclePicture, TableChart
from panel.volume_state import Lacks, Question
from panel.widgets import button, card, clear, column, flow, grow, label, row, scrolled, set_text

DRAWS = "500"  # machines: U within 4 %


def tenths(value):
    """Of a micrometre, of a length in mm."""
    return number(round(value * 1000, 1) + 0.0, 4)


def two_digits(value):
    return number(float("%.2g" % value))


def error_list(errors):
    """A line for each error of plumb volume or plumb squareness."""
    return column(*[label("%s   %s   %s" % its, "soft") for its in volume_state.errors_in_words(errors)], spacing=2)


class VolumePage(EntryPage):
    def __init__(self, panel, page):
        self.page = page
        self._questions, self._found = {}, {}
        super().__init__(panel)

    @property
    def title(self):
        return _("Tables and uncertainty")

    def build(self):
        self._line, self._notes = label(_("plumb volume computes ..."), "value"), label("", "warn")
        self._notes.set_no_show_all(True)
        self._tables, self._circles, self._diagonals, self._corners, self._errors = column(), column(), column(spacing=4), column(spacing=4), column(spacing=4)
        return scrolled(column(label(self.title, "title"), flow(button(_("Back"), lambda: self.panel.open(self.page))),
                               card(label(_("Uncertainty of a distance on the work (k=2)"), "value"), self._line, self._notes, self._corners),
                               card(label(_("Errors of this machine: standard uncertainty, and its source"), "value"), self._errors),
                               card(label(_("Body diagonals of the work space"), "value"), self._diagonals),
                               card(label(_("Error tables"), "value"), self._tables), card(label(_("Circles by ballbar"), "value"), self._circles)))

    def entered(self):
        panel, instance = self.panel, self.page.instance
        self._found = {}
        for box in (self._tables, self._circles, self._diagonals, self._corners, self._errors):
            clear(box)
        try:
            values = panel.hal.values()
            given = volume_state.arguments(panel.ini, panel.guard.loaded_chain(), os.path.dirname(panel.settings.log.path), instance, values)
            given += volume_state.temperature(panel.machine.of("axis_growth"), values)
            self._questions = {"volume": self._ask([*given, "--draws", DRAWS])}
        except Lacks as why:
            self._questions = {}
            self._say_lack(why)
        files = volume_state.circles(panel.ini.folder)
        try:
            self._questions.update({state: self._ask(["circle", "--json", *its]) for state, its in files.items() if its})
        except Lacks as why:
            self._circles.pack_start(label("\u25b2 %s" % why, "warn"), False, False, 0)
        if not any(files.values()):
            words = _("There is no path of a ballbar beside the INI file: a CSV file with the lines # direction: CCW and # correction: off, or on, in its head.")
            self._circles.pack_start(label(words, "soft"), False, False, 0)
        self.widget.show_all()

    def _ask(self, given):
        return Question(self.panel.program("plumb-volume"), given)

    def _say_lack(self, why):
        set_text(self._line, "\u2013")
        self._show_notes("\u25b2 %s" % why)

    def _show_notes(self, text):
        set_text(self._notes, text)
        self._notes.set_no_show_all(not text)
        self._notes.set_visible(bool(text))

    def refresh(self, values):
        for name in [name for name, question in self._questions.items() if question.done()]:
            try:
                self._found[name] = self._questions.pop(name).answer()
            except Lacks as why:
                if name == "volume":
                    self._say_lack(why)
                else:
                    self._circles.pack_start(label("\u25b2 %s" % why, "warn"), False, False, 0)
                    self._circles.show_all()
                continue
            if name == "volume":
                self._show_volume(self._found[name])
        if self._found.keys() & {"off", "on"} and not self._questions.keys() & {"off", "on"} and not self._circles.get_children():
            self._show_circles()

    def _show_volume(self, its):
        place = {"at": "X %.0f Y %.0f Z %.0f" % tuple(its["worst_at"]), "tool": its["tool"],
                 "length": number(round(its["over"] / 1000, 2), 3)}
        notes = ["\u25b2 " + volume_state.note_in_words(note) for note in its["notes"]]
        if its["U"] is None:
            text = _("After correction: U is unknown, for no error has an uncertainty.")
        else:
            words = _("After correction at least \u00b1 {U} \u00b5m over {length} m, worst at {at} with {tool}.") if its["at_least"] else _("After correction \u00b1 {U} \u00b5m over {length} m, worst at {at} with {tool}.")
            text = words.format(U=two_digits(its["U"] * 1000), **place)
        if its["rest"] >= 0.05e-3:
            text += " " + _("Known and not corrected: {rest} \u00b5m.").format(rest=tenths(its["rest"]))
        unknown = [error for error in its["errors"] if error["state"] == "unknown"]
        if unknown:
            text += " " + _("{count} of {all} errors are unknown.").format(count=len(unknown), all=len(its["errors"]))
        if its.get("shares"):
            text += " " + _("Largest share: {cause}, {part} %.").format(cause=volume_state.cause_in_words(its["shares"][0]["of"]), part="%.0f" % (100 * its["shares"][0]["part"]))
        set_text(self._line, text)
        self._show_notes("\n".join(notes))
        self._show_corners(its)
        self._errors.pack_start(error_list(its["errors"]), False, False, 0)
        for each in its["diagonals"]:
            U = _("unknown") if each["U"] is None else two_digits(each["U"] * 1000)
            words = _("{name}, {length} mm: {before} without, {after} \u00b1 {U} \u00b5m with correction").format(
                name=each["name"], length="%.0f" % each["length"], before=tenths(each["without"]), after=tenths(each["rest"]), U=U)
            self._diagonals.pack_start(label(words), False, False, 0)
        self._diagonals.pack_start(label(_("As predicted from the angles and tables. Equal diagonals do not prove a good volume."), "soft"), False, False, 0)
        for axis, errors in sorted(its["tables"].items()):
            charts = []
            for error, table in errors.items():
                unit, scale = ("\u00b5m", 1e3) if table["unit"] == "mm" else ("\u00b5rad", 1e6)
                sure = _("no uncertainty given") if table["u"] is None else "\u00b1%s %s (k=2)" % (two_digits(2 * table["u"] * scale), unit)
                charts.append(column(label("%s   %s" % (error, sure), "soft"), TableChart(self.panel, error, table), spacing=2))
            self._tables.pack_start(label(_("Axis {axis}").format(axis=axis), "value"), False, False, 0)
            self._tables.pack_start(flow(*charts), False, False, 0)
        if not its["tables"]:
            self._tables.pack_start(label(_("squareness has no error table."), "soft"), False, False, 0)
        self.widget.show_all()

    def _show_corners(self, its):
        """U of the corners of the work space."""
        words = [_("{at}: \u00b1{U} \u00b5m").format(at="X %.0f Y %.0f Z %.0f" % tuple(corner["at"]), U=two_digits(corner["U"] * 1000))
                 for corner in volume_state.corners(its["places"])]
        causes = _("Corners, from the known causes alone:") if its["at_least"] else _("Corners of the work space:")
        self._corners.pack_start(label(causes, "soft"), False, False, 0)
        self._corners.pack_start(flow(*map(label, words)), False, False, 0)
        if its["unknown_direction"] > 0:
            text = _("While a direction of motion is not known, up to {lost} \u00b5m of lost motion add: from the start and after machine on, until each axis has moved.")
            self._corners.pack_start(label(text.format(lost=tenths(its["unknown_direction"])), "soft"), False, False, 0)

    def _show_circles(self):
        """Both at the same scale."""
        names = {"off": _("before"), "on": _("after")}
        seen = [(state, self._found[state]) for state in ("off", "on") if state in self._found]
        largest = max(abs(deviation) for _state, its in seen for path in its["paths"] for _angle, deviation in path["points"]) or 1e-6
        pictures, lines = [], []
        for state, its in seen:
            pictures.append(grow(CirclePicture(self.panel, "%s: %s" % (its["plane"], names[state]), its["paths"], largest)))
            opening, both = its["opening"], its["both_directions"]
            lines.append(_("{state}: largest {F} \u00b5m; corner {opening} \u00b1{U} \u00b5rad").format(
                state=names[state], F=tenths(max(its["F_most"], -its["F_least"])), opening=number(round(opening["value"] * 1e6, 1), 4),
                U=two_digits(opening["U"] * 1e6)) + ("" if both else " " + _("with the lag of the drives: one direction alone")))
        words = _("Not seen: equal scales of both axes, and errors along the third axis.")
        for child in (row(*pictures) if len(pictures) < 3 else flow(*pictures), *map(label, lines), label(words, "soft")):
            self._circles.pack_start(child, False, False, 0)
        self._circles.show_all()

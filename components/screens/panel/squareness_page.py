# SPDX-License-Identifier: GPL-2.0-or-later
"""squareness: what is corrected now, and the way from a leaning machine to a square one."""

import os
import re

from panel import chains, squareness_program as program, squareness_state, status
from panel.entry_form import EntryForm
from panel.function_page import FunctionPage
from panel.pages import Page
from panel.settings import Write
from panel.squareness_pictures import ChainPicture, LeanPicture, VolumePicture
from panel.texts import _, in_micrometres, number, with_unit
from panel.volume_page import VolumePage, error_list
from panel.volume_state import keep_uncertainty
from panel.widgets import Figures, Keypad, button, card, choose, column, flow, grow, label, row, scrolled, style


class SquarenessPage(FunctionPage):
    function = "squareness"
    place = 2
    live = ("x-position", "y-position", "z-position", "z-tool-offset")

    def content(self):
        self._figures = Figures("X", "Y", "Z")
        self._errors = Figures("X", "Y", "Z")
        self._angles, self._pending = label(""), label("", "warn")
        return [self._pending, card(label(_("Correction that the axes have"), "value"), self._figures),
                card(label(_("Error of the tip without it"), "value"), self._errors), card(label(_("Angles that are set"), "value"), self._angles)]

    def buttons(self):
        return [button(_("Measure and set up"), lambda: self.panel.open(ChainStep(self.panel, Work(self.panel, self))), "main"),
                button(_("Tables and uncertainty"), lambda: self.panel.open(VolumePage(self.panel, self)))]

    def refresh(self, values):
        super().refresh(values)
        corrections = squareness_state.corrections(self.panel.machine, self.instance, values)
        for letter in "XYZ":
            self._figures.show_value(letter, in_micrometres(float(corrections[letter])))
            self._errors.show_value(letter, in_micrometres(float(self.get(values, letter.lower() + "-error", 0.0))))
        lines = ["%s  %s \u00b5m/m" % (short.upper(), number(angle * 1e6, 4))
                 for short, angle in squareness_state.angles(self.instance, values).items() if angle]
        lines += ["%s  %s" % (short.upper(), with_unit(value, "mu") if short[1] in "xyz" else number(value * 1e6, 4) + " \u00b5m/m")
                  for short, value in squareness_state.rotary_errors(self.instance, values).items()]
        self._angles.set_text("\n".join(lines) or _("None: nothing is corrected."))
        pending = self.panel.guard.pending_chain()
        self._pending.set_visible(bool(pending))
        self._pending.set_text("\u25b2 " + pending if pending else "")


class Work:
    """What the steps have found so far: the document of plumb squareness, and its answer."""

    def __init__(self, panel, page):
        self.panel, self.page, self.instance = panel, page, page.instance
        self.former_chain = panel.guard.loaded_chain()
        self.chain = self.former_chain or program.CHAINS[0][0]
        self.document = self.result = None
        self.seen = {}  # the angles that the document adds to

    @property
    def new_chain(self):
        return self.chain != self.former_chain

    def begin(self, chain):
        """Returns whether plumb squareness knows the chain."""
        values = self.panel.hal.values()
        self.chain, self.seen = chain, squareness_state.angles(self.instance, values)
        given = program.document(chain, self.instance, values)
        acts = status.of(self.instance, values).kind in ("good", "warn")
        given["correction"] = "on" if acts else "off"
        return self.compute(given)

    def renew(self):
        """Adds what was measured to the angles of now. Returns whether plumb squareness accepts it."""
        values = self.panel.hal.values()
        self.seen = squareness_state.angles(self.instance, values)
        return self.compute({**self.document, "in_force": program.document(self.chain, self.instance, values)["in_force"]})

    def compute(self, document):
        """Takes a document over, if plumb squareness accepts it; else its reason is said. Returns whether it does."""
        try:
            self.result = program.run(document, self.panel.program("plumb-squareness"))
        except program.Refused as refused:
            self.panel.say(_("Refused: {why}").format(why=refused), "bad")
            return False
        self.document = document
        return True

    def is_measured(self):
        return bool(self.document["leans"] or self.document["measurements"])


class Step(Page):
    """One step; the buttons below go on and back."""

    heading = ""

    def __init__(self, panel, work, back=None):
        self.work, self.back = work, back or work.page
        super().__init__(panel)

    @property
    def title(self):
        return _(self.heading)

    def build(self):
        buttons = [button(_("Back"), lambda: self.panel.open(self.back)), button(_("Cancel"), lambda: self.panel.open(self.work.page))]
        return scrolled(column(label(self.title, "title"), *self.content(), flow(*self.further(), *buttons)))

    def content(self):
        return []

    def further(self):
        return []

    def of(self):
        return self.work.instance.name

    def go(self, step, *arguments):
        self.panel.open(step(self.panel, self.work, self, *arguments))


class ChainStep(Step):
    heading = "1. Which axis carries what?"  # for gettext: _("1. Which axis carries what?")

    def content(self):
        # A chain with other axes has other pins, and needs other nets.
        parallel = re.findall("[UVW]", self.work.chain)
        known = [(chain, name) for chain, name in program.CHAINS if re.findall("[UVW]", chain) == parallel]
        if self.work.chain not in [chain for chain, _name in known]:
            known.insert(0, (self.work.chain, "This machine"))  # for gettext: _("This machine")
        choices = []
        for chain, name in known:
            its = button(_(name), lambda chain=chain: self._choose(chain), name=chain)
            its.remove(its.get_child())
            words = label(_(name), "soft", chars=24)
            its.add(column(ChainPicture(self.panel, chain), words, label(chain, "mono"), spacing=2))
            if chain == self.work.former_chain:
                style(its, "chosen")
            choices.append(its)
        return [label(_("Touch the picture of your machine. The axes next to the bed stand lowest.")), flow(*choices),
                label(_("For a chain with another axis, such as W, change [SQUARENESS]CHAIN in the INI file, and wire again."), "soft")]

    def _choose(self, chain):
        if self.work.begin(chain):
            self.go(LeansStep)


class LeansStep(Step):
    """All leans of the chain, with what is in force and what was measured; measurements of squares and parts come first."""

    heading = "2. What was measured?"  # for gettext: _("2. What was measured?")

    def content(self):
        self._measured, self._leans = column(spacing=4), column(spacing=4)
        self._how = {
            "on": button(_("Measured with the correction on: add to the present angle"), lambda: self._measured_with("on")),
            "off": button(_("Measured with the correction off: replace the present angle"), lambda: self._measured_with("off"))}
        return [flow(button(_("Square and indicator"), lambda: self.go(AxisStep)),
                     button(_("Diagonals of a part"), lambda: self.go(DiagonalsStep)),
                     button(_("Probed square or ring"), lambda: self.go(PointsStep))),
                self._measured, label(_("Or touch a lean that you know. A lean that you do not enter stays as it is.")), self._leans,
                flow(*self._how.values())]

    def further(self):
        return [button(_("What it will do"), self._next, "main")]

    def entered(self):
        self._show()

    def _show(self):
        for box in (self._measured, self._leans):
            for child in box.get_children():
                child.destroy()
        for place, each in enumerate(self.work.document["measurements"]):
            words = label(_measurement_in_words(each), "value")
            self._measured.pack_start(row(grow(words), button(_("Remove"), lambda place=place: self._remove(place))), False, False, 0)
        for lean in sorted(self.work.result["leans"], key=lambda its: not its["can_correct"]):
            self._leans.pack_start(self._line(lean), False, False, 0)
        for how, its in self._how.items():
            choose(its, how == self.work.document["correction"])
            its.set_visible(bool(self.work.document["in_force"]))
        self._measured.show_all()
        self._leans.show_all()

    def _line(self, lean):
        plus, minus = lean["directions"]
        name = _("{axis} leans to {plus} or {minus}").format(axis=lean["axis"], plus=plus, minus=minus.replace("-", "\u2212"))
        if not lean["can_correct"]:
            return column(label(name, "value"), label("\u25cb " + program.why_not(lean), "soft"), spacing=2)
        facts = []
        if lean["in_force"]:
            facts.append(_("set: {lean}").format(lean=lean_in_words(lean["in_force"])))
        if lean["measured"]:
            facts.append(_("measured: {lean}").format(lean=lean_in_words(lean["measured"])))
        if lean["measured"] and lean["settled"]:
            facts.append(_("then: {lean}").format(lean=lean_in_words(lean["settled"])))
        its = button(name, lambda: self.go(LeanStep, lean), "row", name="%s %s" % (lean["axis"], lean["name"]))
        its.remove(its.get_child())
        its.add(row(grow(column(label(name, "value"), label("   ".join(facts) or _("not entered"), "soft"), spacing=2)),
                    label(lean["name"], "soft", wrap=False)))
        return its

    def _measured_with(self, how):
        if self.work.compute({**self.work.document, "correction": how}):
            self._show()

    def _remove(self, place):
        left = [each for number_, each in enumerate(self.work.document["measurements"]) if number_ != place]
        if self.work.compute({**self.work.document, "measurements": left}):
            self._show()

    def _next(self):
        if self.work.is_measured():
            self.go(ResultStep)
        else:
            self.panel.say(_("Enter a lean or a measurement."), "warn")


def lean_in_words(angle):
    """An angle of the output, as a lean of its + end."""
    if not angle["angle"]:
        return "0"
    text = _("{angle} \u00b5m/m to {direction}").format(angle=number(abs(angle["um_per_m"]), 4), direction=angle["leans"].replace("-", "\u2212"))
    return text + (" \u00b1%s (k=2)" % number(float("%.2g" % (angle["U"] * 1e6))) if angle["U"] else "")


def _measurement_in_words(given):
    if given["by"] == "square":
        return _("Square: {axis} moves, plunger {direction}, reads {reads}").format(
            axis=given["move"], direction=given["plunger"].replace("-", "\u2212"), reads=given["reads"].split(":")[1].replace("um", " \u00b5m"))
    if given["by"] == "diagonals":
        return _("Diagonals: {rising} and {falling}").format(rising=given["rising"], falling=given["falling"])
    return _("Probed points: {file}").format(file=os.path.basename(given["file"]))


class LeanStep(Step):
    """To which side an axis leans, and by how much."""

    def __init__(self, panel, work, back, lean):
        self._lean, self._direction, self._unit = lean, "", program.UNITS[0]
        super().__init__(panel, work, back)

    @property
    def title(self):
        return _("To which side does the + end of {axis} lean?").format(axis=self._lean["axis"])

    def content(self):
        axis = self._lean["axis"]
        self._keypad = Keypad("")
        self._sides, self._units = {}, {}
        for direction in self._lean["directions"]:
            its = button("", lambda direction=direction: self._choose_side(direction),
                         name=_("{axis} leans to {direction}").format(axis=axis, direction=direction))
            its.remove(its.get_child())
            its.add(LeanPicture(self.panel, axis, direction, (200, 130)))
            self._sides[direction] = its
        for unit in program.UNITS:
            self._units[unit] = button(unit.replace("um", "\u00b5m"), lambda unit=unit: self._choose_unit(unit), name=_("Unit {unit}").format(unit=unit))
        self._choose_unit(self._unit)
        return [label(_("Touch the picture whose arrow shows to which side the + end lies. X goes to the right, Y to the back, Z upward.")),
                row(grow(flow(*self._sides.values())), grow(self._keypad), spacing=16), flow(*self._units.values())]

    def further(self):
        return [button(_("Enter"), self._enter, "main"), button(_("Remove"), lambda: self._take(""))]

    def _choose_side(self, direction):
        self._direction = direction
        for each, its in self._sides.items():
            choose(its, each == direction)

    def _choose_unit(self, unit):
        self._unit = unit
        for each, its in self._units.items():
            choose(its, each == unit)

    def _enter(self):
        if not self._direction:
            self.panel.say(_("Touch one of the pictures."), "warn")
        elif not self._keypad.text:
            self.panel.say(_("Enter an angle."), "warn")
        else:
            self._take(self._keypad.text + self._unit)

    def _take(self, angle):
        direction = self._direction or self._lean["directions"][0]
        if self.work.compute(program.with_lean(self.work.document, self._lean["axis"], direction, angle)):
            self.panel.open(self.back)


class AxisStep(Step):
    heading = "Square and indicator: which axis moves?"  # for gettext: _("Square and indicator: which axis moves?")

    def content(self):
        axes = sorted(set(program.axes_of(self.work.chain)) | set("XYZ"), key="XYZUVW".index)
        return [ChainPicture(self.panel, self.work.chain), label(_("The indicator touches one leg of the square while this axis moves along it.")),
                flow(*[button(axis, lambda axis=axis: self.go(PlungerStep, axis), "key", name=_("Axis {axis}").format(axis=axis)) for axis in axes])]


class PlungerStep(Step):
    heading = "Square and indicator: where does the plunger point?"  # for gettext: _("Square and indicator: where does the plunger point?")

    def __init__(self, panel, work, back, axis):
        self._axis = axis
        super().__init__(panel, work, back)

    def content(self):
        return [flow(*[button(direction.replace("-", "\u2212"), lambda direction=direction: self.go(SquareStep, self._axis, direction), "key",
                              name=_("Plunger {direction}").format(direction=direction)) for direction in program.directions(self._axis)])]


class Readings(Step):
    """Several numbers; one at a time is entered by the keypad."""

    def fields(self):
        raise NotImplementedError

    def measurement(self, values):
        raise NotImplementedError

    def words(self):
        return ""

    def content(self):
        self._form = EntryForm(self.fields(), self.words())
        return [self._form.widget]

    def further(self):
        return [button(_("Enter"), self._enter, "main")]

    def _enter(self):
        lacking = self._form.lacking()
        if lacking:
            self.panel.say(lacking, "warn")
        elif self.work.compute(program.with_measurement(self.work.document, self.measurement(list(self._form.texts.values())))):
            form = self
            while not isinstance(form, LeansStep):
                form = form.back
            self.panel.open(form)


class SquareStep(Readings):
    heading = "Square and indicator: readings"  # for gettext: _("Square and indicator: readings")

    def __init__(self, panel, work, back, axis, direction):
        self._axis, self._direction = axis, direction
        super().__init__(panel, work, back)

    def fields(self):
        return [(_("From, mm"), "0"), (_("To, mm"), "300"), (_("Indicator reads more, \u00b5m"), ""), (_("Uncertainty of a reading, \u00b5m"), "1")]

    def words(self):
        return _("True one leg of the square along {base}. Touch the other leg, the plunger towards {direction}; move {axis}.").format(
            base=self._direction[1], direction=self._direction, axis=self._axis)

    def measurement(self, values):
        return program.square(self._axis, self._direction, *values)


class DiagonalsStep(Readings):
    heading = "Diagonals of a part"  # for gettext: _("Diagonals of a part")

    def fields(self):
        return [(_("Rising diagonal, mm"), ""), (_("Falling diagonal, mm"), ""), (_("Uncertainty, \u00b5m"), "2")]

    def words(self):
        return _("A square that was cut in X and Y. The rising diagonal goes from X\u2212Y\u2212 to X+Y+.")

    def measurement(self, values):
        return program.diagonals("XY", *values)


class PointsStep(Step):
    heading = "Probed square or ring"  # for gettext: _("Probed square or ring")

    def content(self):
        folder = self.panel.ini.folder or "."
        files = sorted(name for name in os.listdir(folder) if name.endswith(".csv"))
        buttons = [button(name, lambda name=name: self._choose(os.path.join(folder, name))) for name in files]
        text = _("Touch the file of probed points.") if files else _("There is no CSV file beside the INI file: probe first.")
        return [label(text), flow(*buttons)]

    def _choose(self, path):
        if self.work.compute(program.with_measurement(self.work.document, program.points(path, "1"))):
            self.panel.open(self.back)


class ResultStep(Step):
    heading = "3. What it will do"  # for gettext: _("3. What it will do")

    def content(self):
        result = self.work.result
        lines = []
        for lean in result["leans"]:
            if lean["measured"] and lean["settled"]:
                lines += [label("%s  %s" % (lean["name"], lean_in_words(lean["settled"])), "value"), label(program.before_and_after(lean), "soft")]
        corners = []
        for corner in result["corners"]:
            words = _("not measured now") if corner["basis"] in ("none", "in force") else program.before_and_after(corner)
            corners.append(label("%s\u2013%s: %s" % (corner["axes"][0], corner["axes"][1], words), "soft"))
        useless = [label("\u25b2 %s: %s" % (lean["name"], program.why_not(lean)), "warn") for lean in result["leans"]
                   if lean["measured"] and not lean["can_correct"] and not self.work.document["measurements"]]
        return [card(*lines), *useless, card(label(_("Angles between the axes"), "value"), *corners),
                card(label(_("Errors of this machine: standard uncertainty, and its source"), "value"), error_list(result["errors"])),
                row(grow(VolumePicture(self.panel, result["slopes_before"], _("before"))),
                    grow(VolumePicture(self.panel, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], _("after"))))]

    def further(self):
        return [button(_("Test move"), lambda: self.go(TestStep), "main")]


class TestStep(Step):
    heading = "4. Test move, and save"  # for gettext: _("4. Test move, and save")

    def content(self):
        found = [label(_("Set up a square, one leg trued along the base axis. Touch the other leg with the indicator, set it to 0, and move by "
                         "jogging: first with the present settings, then after Save. With the right sign it reads 0."))]
        for move in self.work.result["moves"]:
            base = move["base"] or _("the table")
            text = _("{axis} by {travel} mm, the base {base}, the plunger towards {plunger}").format(
                axis=move["moved"], travel=number(move["travel"]), base=base, plunger=move["plunger"].replace("-", "\u2212"))
            after = in_micrometres(0.0)
            if "uncertainty" in move:
                after = "0 \u00b1%s (k=2)" % in_micrometres(2 * move["uncertainty"]).lstrip("+")
            lines = [label(text, "value"), label(_("before: {reading}").format(reading=in_micrometres(move["rise"])) + "   " +
                                                 _("after: {reading}").format(reading=after))]
            for name, rise in move["wrong"].items():
                lines.append(label(_("if {name} has the wrong sign: {reading}").format(name=name, reading=in_micrometres(rise)), "warn"))
            found.append(card(*lines))
        if not self.work.result["moves"]:
            found.append(label("\u25b2 " + _("No indicator shows these angles."), "warn"))
        if self.work.new_chain:
            found.append(label("\u25b2 " + _("The chain becomes {chain}. It takes force when LinuxCNC starts again.").format(chain=self.work.chain), "warn"))
        return found

    def further(self):
        return [button(_("Save"), self._save, "main")]

    def look_again(self):
        """Another screen has changed an angle: what it will do is another thing now."""
        if self.work.renew():
            self.back.back.go(ResultStep)

    def _save(self):
        work, instance = self.work, self.work.instance
        writes = [Write(instance, short, value, work.seen.get(short)) for short, value in program.settings(work.result) if short in instance.settings()]
        if not writes:
            self.panel.say(_("Nothing to save: no angle was found that this machine can set."), "warn")
            return
        chain = None
        if work.new_chain:
            try:
                chain = (chains.place(self.panel.ini), work.former_chain, work.chain)
            except OSError as error:
                self.panel.say("%s: %s" % (error.filename, error.strerror), "bad")
                return
            axes = program.axes_of(work.chain)
            writes += [Write(instance, short, "0") for short, angle in squareness_state.angles(instance, self.panel.hal.values()).items()
                       if angle and short[3].upper() not in axes and short in instance.settings()]
            if work.page.switch:  # first: the angles are for the new chain
                owner, short = self.panel.machine.owner_of(work.page.switch)
                writes.insert(0, Write(owner, short, self.panel.machine.switch_text(work.page.switch, False), lasts=False))  # after the start it is on again
        angles = ", ".join("%s %s \u00b5m/m" % (write.short.upper(), number(float(write.text) * 1e6, 4)) for write in writes if write.instance is instance)
        saved = _("Saved: {settings}.").format(settings=angles)
        if work.new_chain:
            saved += " " + _("The chain takes force when LinuxCNC starts again; until then the correction is off.")
        self.panel.guard.change(writes, _("Save the angles"), saved, why="squareness", chain=chain, question=_("Save {angles}?").format(angles=angles),
                                then=self._saved)

    def _saved(self):
        try:
            keep_uncertainty(os.path.dirname(self.panel.settings.log.path), self.work.result)
        except OSError as error:
            self.panel.say("%s: %s" % (error.filename, error.strerror), "warn")
        self.panel.open(self.work.page)

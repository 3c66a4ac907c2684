# SPDX-License-Identifier: GPL-2.0-or-later
"""squareness: what is corrected now, and the way from a leaning machine to a square one, a step a page."""

import os
import re

from panel import squareness_program as program
from panel.function_page import FunctionPage
from panel.pages import Page
from panel.settings import Refused
from panel.squareness_pictures import ChainPicture, LeanPicture, VolumePicture
from panel.texts import _, in_micrometres, number
from panel.widgets import Figures, Keypad, button, card, column, flow, grow, label, row, scrolled, style

ANGLE = re.compile(r"e[abc]0[xyzuvw]$")


class SquarenessPage(FunctionPage):
    heading = "Squareness"  # for gettext: _("Squareness")

    def content(self):
        self._figures = Figures("X", "Y", "Z")
        self._errors = Figures("X", "Y", "Z")
        self._angles = label("")
        return [card(label(_("Correction now"), "value"), self._figures), card(label(_("Error of the tip without it"), "value"), self._errors), card(label(_("Angles in force"), "value"), self._angles)]

    def buttons(self):
        return [button(_("Measure and set up"), lambda: self.panel.open(ChainStep(self.panel, Work(self.panel, self))), "main")]

    def verdict(self, values):
        kind, text = super().verdict(values)
        if kind != "good":
            return kind, text
        if not any(self.angles(values).values()) and not self.get(values, "tables"):
            return "off", _("No angle is set: nothing is corrected.")
        return "good", _("Corrects the tilts that were measured.")

    def angles(self, values):
        return {short.upper(): self.get(values, short, 0.0) for short in self.instance.pins if ANGLE.match(short)}

    def refresh(self, values):
        super().refresh(values)
        for letter in "XYZ":
            self._figures.show_value(letter, in_micrometres(float(self.get(values, letter.lower() + "-correction", 0.0))))
            self._errors.show_value(letter, in_micrometres(float(self.get(values, letter.lower() + "-error", 0.0))))
        lines = ["%s  %s \u00b5m/m" % (name, number(angle * 1e6, 4)) for name, angle in self.angles(values).items() if angle]
        self._angles.set_text("\n".join(lines) or _("None: nothing is corrected."))


class Work:
    """What the steps have found so far."""

    def __init__(self, panel, page):
        self.panel, self.page, self.instance = panel, page, page.instance
        self.former_chain = panel.ini.get("SQUARENESS", "CHAIN")
        self.chain = self.former_chain or program.CHAINS[0][0]
        self.axis = self.direction = ""
        self.arguments = []
        self.result = None

    def compute(self, arguments, add):
        """Returns whether plumb squareness accepts them; says its reason otherwise."""
        arguments = list(arguments)
        if add:
            arguments += program.in_force(self.instance, self.panel.hal.values())
        try:
            self.result = program.run(self.chain, arguments, self.panel.program("plumb-squareness"))
        except program.Refused as refused:
            self.panel.say(str(refused), "bad")
            return False
        self.arguments = arguments
        return True


class Step(Page):
    """One step; the buttons below go on and back."""

    heading = ""

    def __init__(self, panel, work, before=None):
        self.work, self.before = work, before
        super().__init__(panel)

    @property
    def title(self):
        return _(self.heading)

    def build(self):
        back = self.before or self.work.page
        buttons = [button(_("Back"), lambda: self.panel.open(back)), button(_("Cancel"), lambda: self.panel.open(self.work.page))]
        return scrolled(column(label(self.title, "title"), *self.content(), flow(*buttons, *self.further())))

    def content(self):
        return []

    def further(self):
        return []

    def go(self, step, *arguments):
        self.panel.open(step(self.panel, self.work, self, *arguments))


class ChainStep(Step):
    heading = "1. Which axis carries what?"  # for gettext: _("1. Which axis carries what?")

    def content(self):
        chains = list(program.CHAINS)
        if self.work.chain not in [chain for chain, _name in chains]:
            chains.insert(0, (self.work.chain, "This machine"))  # for gettext: _("This machine")
        choices = []
        for chain, name in chains:
            its = button(_(name), lambda chain=chain: self._choose(chain), name=chain)
            its.remove(its.get_child())
            words = label(_(name), "soft", chars=24)
            its.add(column(ChainPicture(self.panel, chain), words, label(chain, "mono"), spacing=2))
            if chain == self.work.former_chain:
                style(its, "chosen")
            choices.append(its)
        return [label(_("Touch the picture of your machine. The axes next to the bed stand lowest.")), flow(*choices)]

    def _choose(self, chain):
        self.work.chain = chain
        self.go(AxisStep)


class AxisStep(Step):
    heading = "2. Which axis leans?"  # for gettext: _("2. Which axis leans?")

    def content(self):
        axes = [button(axis, lambda axis=axis: self._choose(axis), "key", name=_("Axis {axis}").format(axis=axis))
                for axis in _chain_axes(self.work.chain)]
        return [ChainPicture(self.panel, self.work.chain),
                label(_("Touch the axis whose + end is off, by a square held against another axis. "
                        "With diagonals of a part or probed points you need not know it.")),
                flow(*axes),
                flow(button(_("Diagonals of a part"), lambda: self.go(DiagonalsStep)),
                     button(_("Probed square or ring"), lambda: self.go(PointsStep)))]

    def _choose(self, axis):
        self.work.axis = axis
        self.go(DirectionStep)


def _chain_axes(chain):
    return sorted(set(program.axes_of(chain)) | set("XYZ"), key="XYZUVW".index)


class DirectionStep(Step):
    heading = "3. To which side does its + end lean?"  # for gettext: _("3. To which side does its + end lean?")

    def content(self):
        choices = []
        for direction in program.directions(self.work.axis):
            its = button("", lambda direction=direction: self._choose(direction),
                         name=_("{axis} leans to {direction}").format(axis=self.work.axis, direction=direction))
            its.remove(its.get_child())
            its.add(LeanPicture(self.panel, self.work.axis, direction, (220, 150)))
            choices.append(its)
        return [label(_("Touch the picture whose arrow shows to which side the + end lies. X goes to the right, Y to the back, Z upward.")),
                flow(*choices)]

    def _choose(self, direction):
        self.work.direction = direction
        self.go(AngleStep)


class AngleStep(Step):
    heading = "4. By how much?"  # for gettext: _("4. By how much?")

    def content(self):
        self._unit = program.UNITS[0]
        self._keypad = Keypad("")
        self._units = {}
        for unit in program.UNITS:
            self._units[unit] = button(unit.replace("um", "\u00b5m"), lambda unit=unit: self._choose(unit), name=_("Unit {unit}").format(unit=unit))
        self._choose(self._unit)
        text = _("{axis} leans to {direction}. Enter the angle, or what an indicator reads more over a travel.").format(
            axis=self.work.axis, direction=self.work.direction)
        return [row(grow(column(LeanPicture(self.panel, self.work.axis, self.work.direction), label(text))), grow(self._keypad), spacing=16),
                flow(*self._units.values())]

    def _choose(self, unit):
        self._unit = unit
        for each, its in self._units.items():
            context = its.get_style_context()
            (context.add_class if each == unit else context.remove_class)("chosen")

    def further(self):
        return [button(_("Next"), lambda: self._next(False), "main"),
                button(_("It remained with the correction on: add it"), lambda: self._next(True)),
                button(_("Square and indicator instead"), lambda: self.go(SquareStep))]

    def _next(self, add):
        text = self._keypad.text
        if not text:
            self.panel.say(_("Enter an angle."), "warn")
        elif self.work.compute(program.lean(self.work.axis, self.work.direction, text, self._unit), add):
            self.go(ResultStep)


class Readings(Step):
    """Several numbers; one at a time is entered by the keypad."""

    def fields(self):
        raise NotImplementedError

    def arguments(self, values):
        raise NotImplementedError

    def picture(self):
        return None

    def content(self):
        self._texts, self._buttons, self._chosen = {}, {}, None
        self._keypad = Keypad("")
        self._keypad.entry.connect("changed", lambda entry: self._changed())
        for name, start in self.fields():
            self._texts[name] = start
            self._buttons[name] = button("", lambda name=name: self._choose(name), name=name)
        self._choose(next(iter(self._texts)))
        left = column(*([self.picture()] if self.picture() else []), *self._buttons.values(), spacing=4)
        return [row(grow(left), grow(self._keypad), spacing=16)]

    def _choose(self, name):
        self._chosen = None
        self._keypad.entry.set_text(self._texts[name])
        self._chosen = name
        self._show()

    def _changed(self):
        if self._chosen:
            self._texts[self._chosen] = self._keypad.text
            self._show()

    def _show(self):
        for name, its in self._buttons.items():
            its.get_child().set_text("%s: %s" % (name, self._texts[name] or "?"))
            context = its.get_style_context()
            (context.add_class if name == self._chosen else context.remove_class)("chosen")

    def further(self):
        return [button(_("Next"), lambda: self._next(False), "main"),
                button(_("It remained with the correction on: add it"), lambda: self._next(True))]

    def _next(self, add):
        lacking = [name for name, text in self._texts.items() if not text]
        if lacking:
            self.panel.say(_("Enter {name}.").format(name=lacking[0]), "warn")
        elif self.work.compute(self.arguments(list(self._texts.values())), add):
            self.go(ResultStep)


class SquareStep(Readings):
    heading = "4. Square and indicator"  # for gettext: _("4. Square and indicator")

    def fields(self):
        return [(_("From, mm"), "0"), (_("To, mm"), "300"), (_("Indicator reads more, \u00b5m"), ""), (_("Uncertainty of a reading, \u00b5m"), "1")]

    def picture(self):
        return label(_("True one leg of the square along {base}. Touch the other leg, the plunger towards {direction}; move {axis}.").format(
            base=self.work.direction[1], direction=self.work.direction, axis=self.work.axis))

    def arguments(self, values):
        return program.square(self.work.axis, self.work.direction, *values)


class DiagonalsStep(Readings):
    heading = "3. Diagonals of a part"  # for gettext: _("3. Diagonals of a part")

    def fields(self):
        return [(_("Rising diagonal, mm"), ""), (_("Falling diagonal, mm"), ""), (_("Uncertainty, \u00b5m"), "2")]

    def picture(self):
        return label(_("A square that was cut in X and Y. The rising diagonal goes from X\u2212Y\u2212 to X+Y+."))

    def arguments(self, values):
        return program.diagonals("XY", *values)


class PointsStep(Step):
    heading = "3. Probed square or ring"  # for gettext: _("3. Probed square or ring")

    def content(self):
        folder = self.panel.ini.folder or "."
        files = sorted(name for name in os.listdir(folder) if name.endswith(".csv"))
        buttons = [button(name, lambda name=name: self._choose(os.path.join(folder, name))) for name in files]
        text = _("Touch the file of probed points.") if files else _("There is no CSV file beside the INI file: probe first.")
        return [label(text), flow(*buttons)]

    def _choose(self, path):
        if self.work.compute(program.points(path, "1"), False):
            self.go(ResultStep)


class ResultStep(Step):
    heading = "5. What it will do"  # for gettext: _("5. What it will do")

    def content(self):
        result = self.work.result
        lines = []
        for quantity in result["settled"]:
            text = "%s  %s \u00b5m/m" % (quantity["name"], number(quantity["angle"] * 1e6, 4))
            if "leans" in quantity:
                text += "   " + _("{axis} leans to {direction}").format(axis=quantity["name"][3], direction=quantity["leans"])
            if "uncertainty" in quantity:
                text += "   \u00b1%s (k=2)" % number(2 * quantity["uncertainty"] * 1e6, 2)
            lines.append(text)
        notes = [label(note, "soft") for note in result["notes"] + result["unseen"]]
        return [card(*[label(line, "value") for line in lines]),
                row(grow(VolumePicture(self.panel, result["slopes"], _("before"))),
                    grow(VolumePicture(self.panel, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], _("after")))),
                *notes]

    def further(self):
        return [button(_("Test move"), lambda: self.go(TestStep), "main")]


class TestStep(Step):
    heading = "6. Test move, and save"  # for gettext: _("6. Test move, and save")

    def content(self):
        found = [label(_("Set up a square, one leg trued along the base axis. Touch the other leg with the indicator, set it to 0, and move by "
                         "jogging: first with the present settings, then after Save. With the right sign it reads 0."))]
        for move in self.work.result["moves"]:
            base = move["base"] or _("the table")
            text = _("{axis} by {travel} mm, the base {base}, the plunger towards {plunger}").format(
                axis=move["moved"], travel=number(move["travel"]), base=base, plunger=move["plunger"])
            lines = [label(text, "value"), label(_("before: {reading}").format(reading=in_micrometres(move["rise"])) + "   " +
                                                 _("after: {reading}").format(reading=in_micrometres(0.0)))]
            for name, rise in move["wrong"].items():
                lines.append(label(_("if {name} has the wrong sign: {reading}").format(name=name, reading=in_micrometres(rise)), "warn"))
            found.append(card(*lines))
        if self.work.chain != self.work.former_chain:
            found.append(label("\u25b2 " + _("The chain becomes {chain}. It takes force when LinuxCNC starts again.").format(chain=self.work.chain), "warn"))
        return found

    def further(self):
        return [button(_("Save"), self._ask, "main")]

    def _ask(self):
        text = _("Save these angles? The correction changes: the axes move by it.")
        self.panel.move(text, _("Save the angles"), self._save, needed="integrator")

    def _save(self):
        instance, saved = self.work.instance, []
        settings = [(each["pin"], each["value"]) for each in self.work.result["settings"]]
        named_pins = {pin for pin, _value in settings}
        # An angle that this result does not have is no longer in force.
        settings += [(short, "0") for short in instance.settings() if ANGLE.match(short) and short not in named_pins
                     and self.panel.hal.get(instance.full(short))]
        new_chain = self.work.chain != self.work.former_chain
        try:
            if new_chain:
                write_chain(self.panel.ini, self.work.chain)
                if self.work.page.switch:  # the angles are for the new chain
                    self.panel.hal.set(self.work.page.switch, "0")
            for pin, value in settings:
                if value.startswith("[") or pin not in instance.settings():
                    continue
                self.panel.settings.change(instance, pin, value, why="squareness")
                saved.append("%s %s" % (pin, value))
            text = _("Saved: {settings}.").format(settings=", ".join(saved))
            if new_chain:
                text += " " + _("The chain takes force when LinuxCNC starts again; until then the correction is off.")
        except (Refused, OSError, ValueError) as error:
            self.panel.say(str(error), "bad")
            return
        lost = self.panel.settings.retain_state(self.panel.hal.values())
        self.panel.open(self.work.page)
        self.panel.say(text + (" " + lost if lost else ""), "warn" if lost else "good")


def write_chain(ini, chain):
    """Changes [SQUARENESS]CHAIN in the file that has it. Raises OSError."""
    path = ini.place("SQUARENESS", "CHAIN")
    if path.endswith(".expanded"):  # which LinuxCNC makes of the user's file at each start
        path = _source_of(path[: -len(".expanded")])
    if not path:
        raise OSError(2, _("[SQUARENESS] of the INI file has no CHAIN"), ini.path)
    with open(path, encoding="utf-8") as file:
        text = file.read()
    with open(path, "w", encoding="utf-8") as file:
        file.write(re.sub(r"(?m)^(\s*CHAIN\s*=\s*).*$", lambda found: found[1] + chain, text, count=1))


def _source_of(path):
    from panel.hal_files import Ini

    return Ini(path).place("SQUARENESS", "CHAIN")

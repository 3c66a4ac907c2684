# SPDX-License-Identifier: GPL-2.0-or-later
"""squareness: what is corrected now, and the way from a leaning machine to a square one, a step a page."""

import os
import re

from gi.repository import Gtk

from panel import squareness_program as program, style as styles
from panel.function_page import FunctionPage
from panel.pages import Page
from panel.settings import Refused
from panel.texts import _, in_micrometres, number
from panel.widgets import Figures, Keypad, button, card, column, flow, grow, label, named, row, scrolled, style

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


class Picture(Gtk.DrawingArea):
    """A machine by its chain: the work on its axes on the left, the tool on its axes on the right, the bed below."""

    def __init__(self, panel, chain, lean=None):
        super().__init__()
        self._panel, self._chain, self._lean = panel, chain, lean
        self.set_size_request(220, 150)
        self.connect("draw", self._draw)
        named(self, _("Machine {chain}").format(chain=chain))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        text, line, fill = (styles.colour(dark, name) for name in ("text", "good", "pick"))
        work, tool = _sides(self._chain)
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(17)

        def block(x, y, w, h, words):
            cairo.rectangle(x, y, w, h)
            cairo.set_source_rgb(*fill)
            cairo.fill_preserve()
            cairo.set_source_rgb(*line)
            cairo.set_line_width(2)
            cairo.stroke()
            extents = cairo.text_extents(words)
            cairo.set_source_rgb(*text)
            cairo.move_to(x + (w - extents.width) / 2, y + h / 2 + 6)
            cairo.show_text(words)

        base = height - 26
        block(8, base, width - 16, 22, _("bed"))
        step = min(26, (base - 14) / max(len(work) + 1, len(tool) + 1))
        for place, axis in enumerate(work):
            block(14 + place * 5, base - (place + 1) * step, width * 0.42 - place * 10, step - 3, axis)
        block(14 + len(work) * 5 + 16, base - (len(work) + 1) * step, width * 0.42 - len(work) * 10 - 32, step - 3, _("work"))
        for place, axis in enumerate(tool):
            block(width * 0.55 + place * 5, base - (place + 1) * step, width * 0.42 - place * 10, step - 3, axis)
        block(width * 0.55 + len(tool) * 5 + 16, base - (len(tool) + 1) * step, width * 0.42 - len(tool) * 10 - 32, step - 3, _("tool"))


def _sides(chain):
    """Axes from the bed outwards: those that carry the work, and those that carry the tool."""
    before, after = (chain.split("b", 1) + [""])[:2] if "b" in chain else ("", chain)
    tool = program.axes_of(after)
    work = list(reversed(program.axes_of(before)))
    if not before:
        work = [axis for axis in "XYZ" if axis not in tool]
    return work, tool


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
            its.add(column(Picture(self.panel, chain), words, label(chain, "mono"), spacing=2))
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
        return [Picture(self.panel, self.work.chain),
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
        arrows = {"+": "\u2192", "-": "\u2190"}
        choices = []
        for direction in program.directions(self.work.axis):
            text = "%s %s%s" % (arrows[direction[0]], direction.replace("-", "\u2212"), "")
            choices.append(button(text, lambda direction=direction: self._choose(direction), "key",
                                  name=_("{axis} leans to {direction}").format(axis=self.work.axis, direction=direction)))
        return [LeanPicture(self.panel, self.work.axis, ""), flow(*choices)]

    def _choose(self, direction):
        self.work.direction = direction
        self.go(AngleStep)


class LeanPicture(Gtk.DrawingArea):
    """An axis that stands, and dashed as it leans."""

    def __init__(self, panel, axis, direction):
        super().__init__()
        self._panel, self._axis, self._direction = panel, axis, direction
        self.set_size_request(260, 150)
        self.connect("draw", self._draw)
        named(self, _("Axis {axis}").format(axis=axis))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        middle, foot = width / 2, height - 20
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(18)
        leans = (1, -1) if not self._direction else (1 if self._direction[0] == "+" else -1,)
        for lean in leans:
            cairo.set_source_rgb(*styles.colour(dark, "curve2"))
            cairo.set_dash([10, 6])
            cairo.set_line_width(4)
            cairo.move_to(middle, foot)
            cairo.line_to(middle + lean * 46, 22)
            cairo.stroke()
        cairo.set_dash([])
        cairo.set_source_rgb(*styles.colour(dark, "curve"))
        cairo.set_line_width(4)
        cairo.move_to(middle, foot)
        cairo.line_to(middle, 22)
        cairo.stroke()
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(middle - 8, 16)
        cairo.show_text("+" + self._axis)
        if self._direction:
            cairo.move_to(middle + leans[0] * 70 - 14, 40)
            cairo.show_text(self._direction.replace("-", "\u2212"))


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


class VolumePicture(Gtk.DrawingArea):
    """The working volume as the axes draw it, its errors enlarged."""

    def __init__(self, panel, slopes, words):
        super().__init__()
        self._panel, self._slopes, self._words = panel, slopes, words
        self.set_size_request(240, 190)
        self.connect("draw", self._draw)
        named(self, _("Working volume {words}").format(words=words))

    def _draw(self, _area, cairo):
        width, height = self.get_allocated_width(), self.get_allocated_height()
        dark = self._panel.dark
        largest = max((abs(self._slopes[i][k]) for i in range(3) for k in range(3) if i != k), default=0)
        scale = 0.22 / largest if largest > 1e-9 else 0

        def project(point, slopes):
            x, y, z = (sum(point[i] * (slopes[i][k] if i == k else slopes[i][k] * scale) for i in range(3)) for k in range(3))
            size = min(width, height) * 0.42
            return width * 0.34 + (x + 0.45 * y) * size, height * 0.80 - (z + 0.32 * y) * size

        corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        edges = [(a, b) for a in corners for b in corners if sum(p != q for p, q in zip(a, b)) == 1 and a < b]
        ideal = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
        for slopes, name, dashes, thick in ((ideal, "soft", [4, 4], 1.5), (self._slopes, "curve2" if scale else "curve", [], 3)):
            cairo.set_source_rgb(*styles.colour(dark, name))
            cairo.set_dash(dashes)
            cairo.set_line_width(thick)
            for a, b in edges:
                cairo.move_to(*project(a, slopes))
                cairo.line_to(*project(b, slopes))
            cairo.stroke()
        cairo.select_font_face("DejaVu Sans")
        cairo.set_font_size(16)
        cairo.set_source_rgb(*styles.colour(dark, "text"))
        cairo.move_to(8, 20)
        cairo.show_text("%s: %s" % (self._words, _("{error} \u00b5m over 1 m").format(error="%.0f" % (largest * 1e6))))


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

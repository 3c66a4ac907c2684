# SPDX-License-Identifier: GPL-2.0-or-later
"""The machine under commissioning: interlock with its functions and stages, as HAL has them now."""

import glob
import importlib
import os
import re
import time

from commissioning.judging import Verdict
from panel.machine import Machine
from panel.texts import _

LOOK = 0.02  # s between two looks
RETURN = 10  # s for an offset to come or to go
MDI = 1  # s for which LinuxCNC's task shows a line of MDI as a program
ANSWER = 0.5  # s in which plumb-retain sees a pin
SLOW = 0.1  # override of the feed in air
MOST_SHOWN = 4
ORDER = 4  # fault-code of interlock
DOUBTS = (8, 9, 10, 11)  # fault-code of plumb-retain: it waits for an answer
JOINT_INPUTS = ("position", "homed", "motion-enabled", "permit", "trial", "joint-command", "drive-feedback")
JOINT_OUTPUTS = ("drive-command", "joint-feedback", "state")
AXIS_INPUTS = ("permit", "trial", "motion-type", "motion-enabled", "all-homed", "offset-request", "offset-in-force")
AXIS_OUTPUTS = ("counts", "counts-scale", "offset-enable", "state")
OF_LINUXCNC = re.compile(r"(joint|axis|motion|spindle|halui|iocontrol|ini|linuxcnc-link|linuxcnc-alive)\.")


class NotReady(RuntimeError):
    """The machine cannot be commissioned as it is; the message gives the reason."""


class Place:
    """A function or a stage, and its number at interlock."""

    def __init__(self, kind, number, instance):
        self.kind, self.number, self.instance = kind, number, instance
        self.name, self.module = instance.name, instance.module

    @property
    def key(self):
        return "%s %s" % (self.kind, self.name)


class Rig:
    """`hal` has values(), pins(), get(name), set(name, text); `mdi` runs one line of G-code; `clock` and `sleep` are the computer's."""

    def __init__(self, hal, declared, ini, functions_folder, mdi, sleep=time.sleep, clock=time.monotonic):
        self.hal, self.declared, self.ini, self.mdi = hal, declared, ini, mdi
        self.sleep, self.clock = sleep, clock
        self.folder = functions_folder
        self.look()

    def look(self):
        """Reads the wiring again."""
        self.machine = Machine(self.hal.pins(), self.declared)
        locks = self.machine.of("interlock")
        if not locks:
            raise NotReady(_("No interlock is loaded: run plumb wire."))
        self.lock = locks[0]
        self.stages = list(self._places("stage", "stage"))
        self.functions = list(self._places("function", "compensation"))

    def _places(self, kind, role):
        """Each function or stage, by the nets of its row."""
        for number in range(32):
            full = [self.lock.full("%s-%s-%d" % (kind, word, number)) for word in ("state", "permit")]
            if full[0] not in self.machine.pins:
                return
            owners = [self.machine.owner_of(other)[0] for name in full for other in self.ends(self.machine.pins[name].signal) if other != name]
            found = next((owner for owner in owners if owner is not None and owner.declared.role == role), None)
            if found is not None:
                yield Place(kind, number, found)

    def ends(self, signal):
        """Names of the pins at a signal."""
        return [pin.name for pin in self.machine.pins.values() if signal and pin.signal == signal]

    def function(self, name):
        """A function by its own name or by its module's; None without one."""
        return next((place for place in self.functions if name in (place.name, place.module)), None)

    def stages_of(self, function):
        """The stages that apply its offset."""
        its = self.get(self.lock, "function-stages-%d" % function.number)
        return [stage for stage in self.stages if int(its) >> stage.number & 1]

    def place(self, name):
        """A function and None, or the first function of a stage and the stage. Raises NotReady."""
        function = self.function(name)
        stage = next((stage for stage in self.stages if stage.name == name), None)
        if function is None and stage is not None:
            function = self.function_of(stage)
        if function is None:
            raise NotReady(_("No function or stage is named {name}.").format(name=name))
        return function, stage

    def function_of(self, stage):
        """The first one whose offset the stage applies; None without one."""
        return next((function for function in self.functions if stage.name in [each.name for each in self.stages_of(function)]), None)

    # --- values ---

    def get(self, instance, short):
        return self.hal.get(instance.full(short))

    def set(self, instance, short, value):
        self.hal.set(instance.full(short), str(value))

    def has(self, pin):
        return pin in self.machine.pins

    def is_required(self):
        """Whether interlock holds what was not commissioned."""
        return self.has(self.lock.full("commissioning")) and bool(self.get(self.lock, "commissioning"))

    def identity(self, place):
        return int(self.get(self.lock, "%s-identity-%d" % (place.kind, place.number)))

    def passed(self, place):
        return int(self.get(self.lock, "%s-passed-%d" % (place.kind, place.number)))

    def is_commissioned(self, place):
        return self.identity(place) != 0 and self.identity(place) == self.passed(place)

    def let_pass(self, place):
        self.set(self.lock, "%s-passed-%d" % (place.kind, place.number), self.identity(place))

    def doubts(self):
        """A sentence for each store that plumb-retain does not restore without an answer."""
        return ["%s: %s" % (store.name, _(store.declared.sentence("fault-code", int(self.get(store, "fault-code"))))) for store in self._doubted()]

    def must_be_answered(self):
        """Raises NotReady while a store waits: what passes now would not be kept."""
        if self.doubts():
            raise NotReady(" ".join(self.doubts()))

    def answer(self, pin):
        """To each such store: accept, or renew. Returns whether none waits any more."""
        for store in self._doubted():
            self.set(store, pin, 0)
            self.sleep(ANSWER)
            self.set(store, pin, 1)
        return self.await_condition(lambda: not self._doubted())

    def _doubted(self):
        return [store for store in self.machine.of("plumb-retain") if int(self.get(store, "fault-code")) in DOUBTS]

    def take_back(self, place):
        self.set(self.lock, "%s-passed-%d" % (place.kind, place.number), 0)

    @property
    def unit(self):
        """Machine units in a millimetre."""
        return 1 / 25.4 if self.ini.get("TRAJ", "LINEAR_UNITS", "mm").lower() in ("in", "inch", "imperial") else 1.0

    @property
    def axes(self):
        return [letter for letter in self.ini.get("TRAJ", "COORDINATES", "XYZ").upper() if letter.isalpha()]

    def joint_of(self, stage):
        """The number of the joint that a stage of a joint moves; None for the stage of an axis."""
        found = re.match(r"joint\.(\d+)\.", self.machine.writer(stage.instance.full("joint-command"))) if stage.module == "joint_offset" else None
        return int(found[1]) if found else None

    def letter_of(self, stage):
        """The axis along which a stage acts; "" if it is not known."""
        if stage.module == "axis_offset":
            found = re.match(r"axis\.(\w)\.", self.machine.writer(stage.instance.full("offset-in-force")))
            return found[1].upper() if found else ""
        return stage.name[0].upper() if stage.name[0] in "xyzabcuvw" and stage.name[1:2] in "-2" else ""

    # --- what the machine must be like ---

    def unready(self, measures=False):
        """Sentences about what hinders a move by hand; with `measures` the spindle may turn."""
        found = []
        if not self.is_required():
            found.append(_("Commissioning is off at interlock, as on a simulated machine: setp {pin} true, or run plumb wire.").format(
                pin=self.lock.full("commissioning")))
        if not self.get(self.lock, "motion-enabled"):
            found.append(_("The machine is off: turn it on."))
        if not self.get(self.lock, "all-homed"):
            found.append(_("The machine is not homed: home all axes."))
        if not self.await_condition(lambda: not self.get(self.lock, "program-running"), MDI):
            found.append(_("A program runs: end it."))
        if not measures and self.get(self.lock, "spindle-speed") != 0:
            found.append(_("The spindle turns: stop it."))
        return found

    def too_fast(self):
        """A sentence about an override that is above 10 %; "" without one, and where nothing shows it."""
        for pin, words in (("halui.feed-override.value", _("The feed override is at {percent} %.")),
                           ("halui.rapid-override.value", _("The rapid override is at {percent} %."))):
            if self.has(pin) and float(self.hal.get(pin)) > SLOW + 0.001:
                return words.format(percent=round(100 * float(self.hal.get(pin))))
        return ""

    def places(self):
        """Where the joints are measured, by their numbers."""
        joints = (re.fullmatch(r"joint\.(\d+)\.pos-fb", pin) for pin in self.machine.pins)
        return {int(found[1]): float(self.hal.get(found[0])) for found in joints if found}

    def place_of_joint(self, letter):
        """Where LinuxCNC has the joint of an axis."""
        return float(self.hal.get("joint.%d.pos-fb" % self.ini.get("TRAJ", "COORDINATES", "XYZ").upper().replace(" ", "").find(letter)))

    def await_condition(self, condition, seconds=RETURN):
        """Whether it came in time. A trial has no beat meanwhile: only who presses beats."""
        ends = self.clock() + seconds
        while not condition():
            if self.clock() > ends:
                return False
            self.sleep(LOOK)
        return True

    # --- wiring that can be seen without a move ---

    def wiring_verdict(self, function):
        """The first fault that the nets show; None if they show none."""
        self.look()
        if self.get(self.lock, "fault-code") == ORDER:
            return Verdict("order", _("A function of Plumb is in a wrong place of its thread, or in none."), _("Run plumb doctor --running: it gives the commands."))
        missing = self.missing_nets(function)
        if missing:
            shown = ", ".join(missing[:MOST_SHOWN]) + (", ..." if len(missing) > MOST_SHOWN else "")
            return Verdict("net", _("A net is missing, or nothing writes it: {pins}.").format(pins=shown), _("Net it, as in the files of plumb wire."))
        return self._of_another_row() or self._commanded(function) or self._swapped(function)

    def _of_another_row(self):
        """A net between a row of interlock and another stage or function than the row's."""
        rows = {(place.kind, place.number): place for place in (*self.stages, *self.functions)}
        places = {place.name: place for place in rows.values()}
        for pin in self.machine.pins.values():
            found = re.fullmatch(re.escape(self.lock.name) + r"\.(stage|function)-[a-z-]+-(\d+)", pin.name)
            others = () if not found else self._readers(pin) if pin.output else [self.machine.writer(pin.name)]
            for other in others:
                owner, _short = self.machine.owner_of(other)
                its = places.get(owner.name) if owner is not None else None
                if its is not None and its.kind == found[1] and its.number != int(found[2]):
                    return Verdict("net", _("{pin} is netted to {other}, which has the row {row}.").format(pin=pin.name, other=other, row=its.number),
                                   _("Net {pin} to its own stage or function, as in the files of plumb wire.").format(pin=pin.name))
        return None

    def missing_nets(self, function):
        """Pins of a function and of its stages that lack a signal, or the other end of it."""
        missing = [] if self._writer(self.machine.pins[self.lock.full("spindle-speed")]) else [self.lock.full("spindle-speed")]
        its = importlib.import_module("commissioning.functions." + function.module)
        unused = its.unused(self, function.instance) if hasattr(its, "unused") else ()
        if hasattr(its, "needs"):
            missing += [function.instance.full(short) for short in its.needs(self, function.instance) if not self._writer(function.instance.pins[short])]
        for short, letter, _signal, is_read in self._lines_of(function):
            name = function.instance.full(short)
            pin = self.machine.pins.get(name)
            if pin is None or short in unused or (letter not in ("", *"abc") and letter.upper() not in self.axes):
                continue
            if not (self._readers(pin) or not is_read if pin.output else self._writer(pin)):
                missing.append(name)
        for stage in self.stages_of(function):
            inputs, outputs = (JOINT_INPUTS, JOINT_OUTPUTS) if stage.module == "joint_offset" else (AXIS_INPUTS, AXIS_OUTPUTS)
            missing += [stage.instance.full(short) for short in inputs if not self._writer(self.machine.pins[stage.instance.full(short)])]
            missing += [stage.instance.full(short) for short in outputs if not self._readers(self.machine.pins[stage.instance.full(short)])]
        for short, _letter, pin in self._outputs_of(function):
            if not self._stages_at(pin):
                missing.append(pin.name)
        return missing

    def _writer(self, pin):
        """Whether something can write the signal of an input: an output, a pin that goes both ways, or a driver without a direction."""
        return any(other != pin.name and self.machine.pins[other].output for other in self.ends(pin.signal))

    def _readers(self, pin):
        return [other for other in self.ends(pin.signal) if other != pin.name and not self.machine.pins[other].output]

    def _nets_of(self, function):
        """Short names of the pins that the HAL file of a function nets, with the letter of an axis that a machine may lack."""
        return ((short, letter) for short, letter, _signal, _is_read in self._lines_of(function))

    def _lines_of(self, function):
        """The same with the signal, and whether LinuxCNC or interlock reads it."""
        path = os.path.join(self.folder, function.module, function.module + ".hal")
        if not os.path.exists(path):
            return
        with open(path, encoding="utf-8") as file:
            text = file.read()
        names = re.search(r"^loadrt %s +names=([\w.-]+)" % function.module, text, re.M)
        name = names[1] if names else function.name
        for line in text.splitlines():
            words = line.split()
            if words[:1] != ["net"]:
                continue
            found = re.match(r"([xyzuvwabc])-", words[1])
            own = [word[len(name) + 1:] for word in words[2:] if word.startswith(name + ".")]
            is_read = "state" in own or any("." in word and not word.startswith(name + ".") for word in words[2:])
            for short in own:
                yield short, found[1] if found else "", words[1], is_read
                for other, letter in self._repetitions(function, short):
                    yield other, letter, words[1], is_read

    def _repetitions(self, function, short):
        """Pins of more axes and rows than the HAL file of the function has, as plumb wire repeats its lines for Z and 0; with the letter
        of an axis."""
        for other in function.instance.pins:
            if function.instance.declared.pin(other).get("only_with"):
                if short.startswith("z-") and other[1:] == short[1:]:
                    yield other, other[0]
                elif short.endswith("-0") and re.sub(r"-\d+$", "-0", other) == short:
                    yield other, ""

    def _commanded(self, function):
        """A commanded position where the HAL file of the function nets a measured one."""
        for short, _letter, signal, _is_read in self._lines_of(function):
            pin = function.instance.pins.get(short)
            writer = self.machine.writer(pin.name) if pin and not pin.output and signal.endswith(("-fb", "-measured")) else ""
            if writer.endswith("pos-cmd"):
                return Verdict("net", _("{pin} has the commanded position, {writer}.").format(pin=pin.name, writer=writer),
                               _("Net the measured position, joint.N.motor-pos-fb, to it."))
        return None

    def _outputs_of(self, function):
        """Outputs of a function that a stage must take: short name, letter, pin."""
        path = os.path.join(self.folder, function.module, "wire.toml")
        if not os.path.exists(path):
            return
        for short, pin in function.instance.pins.items():
            found = re.fullmatch(r"([xyzuvw])-(correction|offset)", short)
            if pin.output and found and (short, found[1]) in set(self._nets_of(function)) and found[1].upper() in self.axes:
                yield short, found[1].upper(), pin

    def _stages_at(self, pin):
        """The stages whose sources read an output."""
        names = {stage.name: stage for stage in self.stages}
        found = []
        for reader in self._readers(pin):
            owner, short = self.machine.owner_of(reader)
            if owner is not None and short.startswith("offset-") and owner.name in names:
                found.append(names[owner.name])
        return found

    def _letter_of_pin(self, pin):
        """The axis of a pin of a joint or of a stage; "" for another one."""
        coordinates = self.ini.get("TRAJ", "COORDINATES", "XYZ").upper().replace(" ", "")
        found = re.match(r"joint\.(\d+)\.", pin)
        if found:
            return coordinates[int(found[1])] if int(found[1]) < len(coordinates) else ""
        return next((self.letter_of(stage) for stage in self.stages if pin.startswith(stage.name + ".")), "")

    def _swapped(self, function):
        for short, pin in function.instance.pins.items():
            found = re.fullmatch(r"([xyzuvw])-(position|velocity|velocity-cmd|motor-offset)(-\d)?", short)
            writer = self.machine.writer(pin.name) if found and not pin.output else ""
            its = self._letter_of_pin(writer)
            if its and its != found[1].upper():
                return Verdict("joint", _("{pin} has the signal of {its}: the joints are swapped.").format(pin=pin.name, its=its),
                               _("Net that of {letter} to it.").format(letter=found[1].upper()))
        for _short, letter, pin in self._outputs_of(function):
            for stage in self._stages_at(pin):
                its = self.letter_of(stage)
                if its and its != letter:
                    sentence = _("{pin} goes to the stage of {its}: the joints are swapped.")
                    return Verdict("joint", sentence.format(pin=pin.name, its=its), _("Net it to the stage of {letter}.").format(letter=letter))
        coordinates = self.ini.get("TRAJ", "COORDINATES", "XYZ").upper().replace(" ", "")
        for stage in self.stages_of(function):
            joint, letter = self.joint_of(stage), self.letter_of(stage)
            if joint is not None and letter and joint < len(coordinates) and letter in coordinates and coordinates[joint] != letter:
                sentence = _("{stage} stands at joint {joint}, which is {its}: the joints are swapped.")
                return Verdict("joint", sentence.format(stage=stage.name, joint=joint, its=coordinates[joint]),
                               _("Net it to the joint of {letter}.").format(letter=letter))
            for short, pin in stage.instance.pins.items():
                for other in () if joint is None else self._readers(pin) if pin.output else [self.machine.writer(pin.name)]:
                    found = re.match(r"joint\.(\d+)\.", other)
                    if found and int(found[1]) != joint:
                        return Verdict("joint", _("{pin} is netted to {other}, and {stage} stands at joint {joint}.").format(
                            pin=pin.name, other=other, stage=stage.name, joint=joint), _("Net it to the joint of the stage."))
        return None

    def through_others(self, function):
        """Inputs that neither LinuxCNC nor Plumb writes, with the pin that does: its scale and its sign are somebody else's."""
        found = {}
        for place, shorts in [(function, function.instance.inputs()),
                              *((stage, JOINT_INPUTS if stage.module == "joint_offset" else AXIS_INPUTS) for stage in self.stages_of(function))]:
            for short in shorts:
                pin = self.machine.pins.get(place.instance.full(short))
                writer = self.machine.writer(pin.name) if pin and not pin.output and short != "drive-feedback" else ""
                if writer and not OF_LINUXCNC.match(writer) and self._is_of_the_machine(writer):
                    found[pin.name] = writer
            command = place.instance.full("drive-command")
            if self.machine.writer(place.instance.full("drive-feedback")) == command and self.has(command):
                found[place.instance.full("drive-feedback")] = command
        return found

    def read_by_programs(self, function):
        """Outputs that a program reads, with the pin by which it does."""
        pins = (function.instance.pins.get(short) for short, _letter in self._nets_of(function))
        return {pin.name: reader for pin in pins if pin is not None and pin.output for reader in self._readers(pin) if reader.startswith("motion.")}

    def _is_of_the_machine(self, writer):
        """Whether a pin is a driver's, or that of a plant in its place."""
        owner, _short = self.machine.owner_of(writer)
        return owner is None or owner.declared.role == "plant"

    # --- trials ---

    def begin_press(self, stage, offset):
        """A trial of a stage; beat() must follow at least five times a second, as long as somebody presses. interlock ends it otherwise."""
        self._begin()
        self.take_back(stage)
        self.set(self.lock, "trial-offset", repr(float(offset)))
        self._try("trial-stage", stage)

    def begin_trial(self, function, measures=False):
        """Permits a function. What is tried has not passed until it passes again. With `measures` no stage moves, and the spindle may turn."""
        self._begin()
        self.take_back(function)
        self.set(self.lock, "trial-measures", int(measures))
        self._try("trial-function", function)

    def _begin(self):
        """interlock does not go on with the trial of a program that was killed: its number must have gone."""
        if max(int(self.get(self.lock, short)) for short in ("trial-stage", "trial-function")) < 0:
            return
        beat = self.get(self.lock, "trial-beat")
        self.sleep(0.3)
        if self.get(self.lock, "trial-beat") != beat:
            raise NotReady(_("Another program runs a trial: end it first."))
        self.end_press()
        self.sleep(0.05)

    def _try(self, short, place):
        self.set(self.lock, short, place.number)
        self.beat()

    def beat(self):
        self.set(self.lock, "trial-beat", int(not self.get(self.lock, "trial-beat")))

    def end_press(self):
        """Ends both kinds of trial at once."""
        self.set(self.lock, "trial-stage", -1)
        self.set(self.lock, "trial-function", -1)
        self.set(self.lock, "trial-offset", 0)
        self.set(self.lock, "trial-measures", 0)

    def applied(self, stage):
        return float(self.get(stage.instance, "applied-offset"))

    def joints_of(self, function):
        """Its stages at the joints; the offset of an axis returns with the next cycle."""
        return [stage for stage in self.stages_of(function) if stage.module == "joint_offset"]

    def back_at_0(self, function, within):
        return all(abs(self.applied(stage)) < within for stage in self.joints_of(function))

    def has_switch(self, function):
        """Whether the operator has a switch of his own, with a signal."""
        return bool(self.machine.pins[self.lock.full("function-switch-%d" % function.number)].signal)

    def switch(self, function, on):
        if not self.has_switch(function):
            self.set(self.lock, "function-switch-%d" % function.number, int(on))

    def end_cycle(self):
        """A program that was killed may have left the cycle running."""
        if self.get(self.lock, "cycle-running") and not self.get(self.lock, "program-running") and self.get(self.lock, "motion-enabled"):
            self.mdi("M65 P0")

    def is_on(self, function):
        return bool(self.get(self.lock, "function-switch-%d" % function.number))

    def close(self):
        self.end_press()

    def inputs(self, function):
        """Values of the inputs of a function that have a signal, by their names."""
        values, names = self.hal.values(), map(function.instance.full, function.instance.inputs())
        return {name: values[name] for name in names if name in values}

    # --- for the records ---

    def wiring(self, place):
        """A line for each pin of an instance that has a signal."""
        lines = []
        for short, pin in place.instance.pins.items():
            if not pin.signal or place.instance.declared.is_of_records(short):
                continue
            others = sorted(other for other in self.ends(pin.signal) if self.machine.pins[other].output != pin.output and not other.startswith("linuxcnc-link."))
            lines.append("%s %s %s" % (short, ">" if pin.output else "<", " ".join(others) or "signal " + pin.signal))
        return lines

    def settings(self, place):
        """The settings that are not at their defaults, and those whose sign counts."""
        values = {}
        for short in place.instance.settings():
            declared = place.instance.declared.pin(short)
            if "level" not in declared:  # a signal, or a button
                continue
            value = self.get(place.instance, short)
            if value != declared.get("default") or (declared.get("turns") and value):
                values[short] = value
        return values

    def scales(self, place):
        """Pins and parameters named scale, by their names, of the drives and sensors at the other ends of the signals."""
        others = {self.machine.pins[other].name.rpartition(".")[0] for pin in place.instance.pins.values() if pin.kind == "float" for other in self.ends(pin.signal)}
        others.discard(place.name)
        values = {name: pin.value for name, pin in self.machine.pins.items() if not pin.output and not pin.signal}
        values.update(self.hal.parameters())
        return {name: value for name, value in sorted(values.items())
                if name.rpartition(".")[0] in others and "scale" in name.rpartition(".")[2] and self.machine.owner_of(name)[0] is None}

    def options(self, place):
        """The options of its loadrt line, but for the names."""
        return [word for word in self.hal.load_line(place.module).split()[2:] if not word.startswith("names=")]


def function_names(folder):
    return sorted(os.path.basename(os.path.dirname(path)) for path in glob.glob(os.path.join(folder, "*", "wire.toml")))

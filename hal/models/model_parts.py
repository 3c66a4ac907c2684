# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts of models: how their pins move. A driver's own parts come from its model file; the travel of the INI gives
switches. Nets show the motor of each encoder, and the command that each input of a spindle follows."""

import collections
import re

from texts import Impossible

RAMP = 1000 / 60  # revolutions per second, in a second, of a spindle
HEADROOM = 1.2  # the speed of a drive at its full output, as a multiple of MAX_VELOCITY
NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")  # LinuxCNC reads no further
MARGIN = {"mm": 5.0, "inch": 0.2}  # from the start to a home switch, and from a soft limit to a limit switch
# Inputs that hold a machine back, by the value with which it works.
WANTED_TRUE = re.compile(r".*emc-enable-in|.*\.ok-in|.*\.at-speed|motion\.enable")
WANTED_FALSE = re.compile(
    r"joint\.\d+\.(neg-lim-sw-in|pos-lim-sw-in|amp-fault-in|home-sw-in)|.*\.fault-in|spindle\.\d+\.(inhibit|amp-fault-in)|"
    r"motion\.(probe-input|feed-inhibit|feed-hold|homing-inhibit|jog-inhibit)|"
    r"plasmac\.(float-switch|breakaway|ohmic-probe)|"
    r"halui\.(abort|estop\.activate|machine\.off|program\.(stop|pause))"
)
LOGIC = {  # inputs of a module, and their values, that give its output a value
    ("not", True): (("in", False),),
    ("not", False): (("in", True),),
    **{(module, value): (("in", value),) for module in ("debounce", "dbounce", "timedelay") for value in (True, False)},
    ("or2", True): (("in0", True),),
    ("or2", False): (("in0", False), ("in1", False)),
    ("and2", True): (("in0", True), ("in1", True)),
    ("and2", False): (("in0", False),),
}


def number_in(ini, section, name, usual, kind):
    """A number of the INI file."""
    value = ini.get(section, name) or usual
    found = NUMBER.match(str(value))
    try:
        return kind(found[1] if found else value)
    except ValueError:
        raise Impossible("%s: [%s]%s = %s is no %s number" % (ini.path, section, name, value, "whole" if kind is int else "decimal")) from None


def demanded(pin, value, writer_of, owner_of, outputs, passed=frozenset()):
    """The outputs of drivers, and their values, that give a pin this value: straight or through logic."""
    writer = writer_of(pin)
    if not writer or writer in passed:
        return
    if writer in outputs:
        yield writer, value
        return
    head = writer.rpartition(".")[0]
    for name, wanted in LOGIC.get((owner_of(writer), value), ()):
        yield from demanded("%s.%s" % (head, name), wanted, writer_of, owner_of, outputs, passed | {writer})


def add(stand_ins, follows):
    """Adds the parts to the models."""
    Parts(stand_ins).add(stand_ins.files, follows)


class Parts:
    def __init__(self, stand_ins):
        self.nets, self.ini, self.text, self.told = stand_ins.nets, stand_ins.ini, stand_ins.all, stand_ins.told
        self.drivers, self.bus = stand_ins.models, stand_ins.ethercat
        self.models = [*stand_ins.models.values(), *stand_ins.program_models.values()]
        self.signals = {pin: signal for signal, (pins, _) in self.nets.items() for pin in pins}
        self.kinds = {row[0]: row for model in self.models for row in model["pins"]}
        self.outputs = {name for name, row in self.kinds.items() if row[2] == "OUT"}
        self.instances = {}
        for line in re.findall(r"^\s*(?:hal\s+)?loadrt\s+(.*)$", self.text, re.M):
            module, *options = line.split()
            names = [option[6:].strip("\"'").split(",") for option in options if option.startswith("names=")]
            for instance in names[0] if names else [module, module.replace("_", "-")]:
                self.instances[instance] = module

    def add(self, files, follows):
        for model in self.drivers.values():
            names = [row[0] for row in model["pins"]]
            for file in files:
                for part in file.parts:
                    model["parts"] += _of_file(part, names)
        self._drives_of_the_bus()
        self._joints(follows)
        self._spindles()
        if not follows:
            self._inputs()
            self._switches()

    def _writer(self, pin):
        """The pin that writes the signal of a pin: the one that an arrow calls so, else the output of a driver."""
        signal = self.signals.get(pin)
        if signal is None:
            return None
        pins, sources = self.nets[signal]
        sources = {other for other in sources if self.told(other)[1] != "IN"}  # HAL ignores arrows
        found = [other for other in pins if other != pin and (other in sources or other in self.outputs or _is_output(other))]
        return found[0] if found else None

    def _owner(self, pin):
        head = pin.rpartition(".")[0]
        return self.instances.get(head) or self.instances.get(re.sub(r"(\.\d+)+$", "", head))

    def _part(self, pin):
        """The part that writes a pin, or None."""
        for model in self.models:
            for part in model["parts"]:
                if any(name == pin and role in ("position", "velocity", "rpm", "out") for role, name in part["pins"].items()):
                    return part
        return None

    def _model(self, pin):
        return next(model for model in self.models if any(row[0] == pin for row in model["pins"]))

    def _set(self, pin):
        """The value that the user's files set, or None."""
        found = re.search(r"^\s*(?:HALCMD\s*=\s*)?(?:hal\s+)?setp\s+%s\s+(\S+)" % re.escape(pin), self.text, re.M)
        number = found and NUMBER.fullmatch(found[1])
        return float(number[1]) if number else None

    def _reached(self, signal):
        """The inputs that a signal reaches, straight and through components with numbers: the product of the gains up to
        each of them, and the components."""
        found, waiting = {}, collections.deque([(signal, 1.0, ())])
        passed = {signal}
        while waiting:
            signal, factor, heads = waiting.popleft()
            for pin in self.nets[signal][0]:
                if pin in found or (self.kinds.get(pin) or self.told(pin))[-2 if pin in self.kinds else 1] == "OUT":
                    continue
                found[pin] = factor, heads
                head = pin.rpartition(".")[0]
                if pin in self.kinds or not self._owner(pin):
                    continue
                gain = (self._set(head + ".gain") or 1.0) if self._owner(pin) == "scale" else 1.0
                for other, theirs in self.signals.items():
                    if other.rpartition(".")[0] == head and theirs not in passed and self.told(other) == ["float", "OUT"]:
                        passed.add(theirs)
                        waiting.append((theirs, factor * gain, (*heads, head)))
        return found

    def _drives_of_the_bus(self):
        """Drives by the objects in the file of an EtherCAT bus, with the pins that HAL files name."""
        for drive in self.bus.drives:
            pins = {role: pin for role, pin in drive.items() if pin in self.kinds}
            if "control" in pins and "status" in pins:
                model = self._model(pins["control"])
                model["parts"] = [part for part in model["parts"] if part["pins"].get("control") != pins["control"]]
                model["parts"].append({"kind": "drive", "pins": pins, "numbers": {}})

    def _actuator(self, joint, position):
        """How an output moves the encoder whose position closes a loop to it: a step generator's position, or gain, greatest
        speed and what enables a drive. None without a loop outside the driver."""
        back = self._reached(self.signals[position])
        there = self._reached(self.signals["joint.%d.motor-pos-cmd" % joint])
        for pin, (factor, heads) in there.items():
            if pin not in back or pin not in self.kinds or not heads or self.kinds[pin][1] != "float":
                continue
            measured = {self.signals.get(other) for other in self._part(position)["pins"].values()}
            if sum(self.signals.get(other + ".feedback") in measured for other in heads if other + ".feedback" in self.signals) > 1:
                return None  # a loop of the speed in a loop of the position: a drive in torque mode
            for part in (part for model in self.models for part in model["parts"]):
                if part["kind"] == "stepgen" and pin in (part["pins"].get("command"), part["pins"].get("velocity-command")):
                    return {"source": self._position_of(part, pin)}, {}
            fastest = number_in(self.ini, "JOINT_%d" % joint, "MAX_VELOCITY", 1, float) * HEADROOM
            head = pin.rpartition(".")[0]
            ends = [head + ".scale", pin + "-scalemax", *(other + ".maxoutput" for other in heads)]
            full = next(filter(None, map(self._set, ends)), 1.0)
            tuned = next(filter(None, (self._set(other + ".FF1") for other in heads)), None)
            gain = abs(1 / (tuned * factor)) if tuned else fastest / abs(full)
            pins = {"source": pin}
            on = self.signals.get("joint.%d.amp-enable-out" % joint)
            enables = [other for other in self.nets[on][0] if other in self.kinds and other.startswith(head + ".")] if on else []
            if enables:
                pins["enable"] = enables[0]
            return pins, {"gain": gain if factor > 0 else -gain, "most": max(fastest, gain * abs(full))}
        return None

    def _position_of(self, stepgen, command):
        """The pin of a step generator's position. The user's files need not name it."""
        if "position" not in stepgen["pins"]:
            stepgen["pins"]["position"] = command.rpartition(".")[0] + ".position-fb"
            self._model(command)["pins"].append([stepgen["pins"]["position"], "float", "OUT", 0])
        return stepgen["pins"]["position"]

    def _joints(self, follows):
        """The feedback of joints: a step generator moves by its own command, all else as its joint is commanded."""
        drives = any(part["kind"] == "drive" and {"position", "target"} <= set(part["pins"]) for model in self.models for part in model["parts"])
        for joint in range(number_in(self.ini, "KINS", "JOINTS", 0, int)):
            command = self.signals.get("joint.%d.motor-pos-cmd" % joint)
            writer = self._writer("joint.%d.motor-pos-fb" % joint)
            if not command or writer not in self.outputs:
                continue
            part = self._part(writer)
            if part and not follows and (part["kind"] == "stepgen" or (part["kind"] == "cia402" and drives)):
                continue
            if part and part["kind"] == "encoder":
                actuator = None if follows else self._actuator(joint, writer)
                part["pins"].update(actuator[0] if actuator else {"source": command})
                part["numbers"].update(actuator[1] if actuator else {})
                continue
            if part:
                self._model(writer)["parts"].remove(part)
            self._model(writer)["parts"].append({"kind": "encoder", "pins": {"position": writer, "source": command}})

    def _spindles(self):
        for spindle in range(number_in(self.ini, "TRAJ", "SPINDLES", 1, int)):
            source = "spindle.%d.speed-out-rps" % spindle
            for pin in ("revs", "speed-in"):
                part = self._part(self._writer("spindle.%d.%s" % (spindle, pin)))
                if part and part["kind"] == "encoder" and "source" not in part["pins"]:
                    part["pins"]["source"] = source
                    part["numbers"] = {"ramp": RAMP}
            for ready, level in demanded("spindle.%d.at-speed" % spindle, True, self._writer, self._owner, self.outputs):
                if level:
                    pins = {"out": ready, "source": source}
                    self._model(ready)["parts"].append({"kind": "at-speed", "pins": pins, "numbers": {"ramp": RAMP}})
            self._speeds(spindle, source)

    def _speeds(self, spindle, source):
        """Speeds that a driver or a program measures: those that reach the spindle's speed-in, or are compared with its command."""
        commands = set()  # inputs of components
        for name in ("speed-out", "speed-out-abs", "speed-out-rps", "speed-out-rps-abs"):
            signal = self.signals.get("spindle.%d.%s" % (spindle, name))
            commands.update(self._reached(signal) if signal else ())
        for output in sorted(self.outputs):
            signal = self.signals.get(output)
            if not signal or self.kinds[output][1] != "float" or self._part(output):
                continue
            found = {}
            for pin, (gain, _) in self._reached(signal).items():
                head, _, name = pin.rpartition(".")
                other = {"in1": head + ".in2", "in2": head + ".in1"}.get(name)
                if self._owner(pin) == "near" and other in commands:
                    found["near"] = self.signals[other], gain
                elif pin == "spindle.%d.speed-in" % spindle:
                    found["speed-in"] = source, gain
            if found:  # the compared pins show the unit in the user's files
                follows, gain = found.get("near") or found["speed-in"]
                part = {"kind": "speed", "pins": {"in": follows, "source": source, "out": output}, "numbers": {"factor": 1 / gain, "ramp": RAMP}}
                self._model(output)["parts"].append(part)

    def _inputs(self):
        """Inputs that hold the machine back have the values with which it works."""
        for wanted, value in ((WANTED_TRUE, True), (WANTED_FALSE, False)):
            for pin in self.signals:
                if wanted.fullmatch(pin):
                    for output, level in demanded(pin, value, self._writer, self._owner, self.outputs):
                        self.kinds[output][3] = int(level)

    def _switches(self):
        """Home and limit switches, at their places of the travel. The machine starts a little before its home switch."""
        margin = MARGIN["inch" if (self.ini.get("TRAJ", "LINEAR_UNITS") or "mm").lower() in ("inch", "in", "imperial") else "mm"]
        switches = {}
        for joint in range(number_in(self.ini, "KINS", "JOINTS", 0, int)):
            command = self.signals.get("joint.%d.motor-pos-cmd" % joint)
            if not command:
                continue
            def number(name, section="JOINT_%d" % joint):
                return number_in(self.ini, section, name, 0, float)
            search, home = number("HOME_SEARCH_VEL"), number("HOME_OFFSET")
            direction = -1 if search < 0 else 1
            start = home - direction * margin if search else number("HOME")
            room = margin + search**2 / 2 / max(number("MAX_ACCELERATION"), 1e-6)
            places = [("home-sw-in", home, direction)] if search else []
            if number("MAX_LIMIT") > number("MIN_LIMIT"):
                ends = [number("MIN_LIMIT"), number("MAX_LIMIT"), *([home] if search else [])]
                places += [("neg-lim-sw-in", min(ends) - room, -1), ("pos-lim-sw-in", max(ends) + room, 1)]
            own = {}  # a switch for home and limit has one place on a side
            for name, place, side in places:
                for output, level in demanded("joint.%d.%s" % (joint, name), True, self._writer, self._owner, self.outputs):
                    if own.setdefault((output, side), name) == name:
                        switches.setdefault(output, (level, []))[1].append((command, start, place, side))
        for output, (level, each) in switches.items():
            part = {"kind": "switch", "pins": {"out": output}, "numbers": {"inverted": int(not level)}}
            for index, (command, start, place, side) in enumerate(each):
                part["pins"]["source-%d" % index] = command
                part["numbers"].update({"start-%d" % index: start, "place-%d" % index: place, "direction-%d" % index: side})
            model = self._model(output)
            for other in model["parts"]:
                if other["kind"] == "inverse" and other["pins"]["out"] == output:  # the other of both follows then
                    other["pins"] = {"out": other["pins"]["in"], "in": output}
            model["parts"].insert(0, part)


def _is_output(pin):
    return re.search(r"(\.|-)out\d*(-not)?$|\.(ok-out|output)$", pin) is not None


def _of_file(part, names):
    """The parts of a model with these pins, by a part of its file."""
    heads = {}
    for name in names:
        if part.get("each"):
            for found in reversed(list(re.finditer(r"\.", name))):
                head, tail = name[: found.start()], name[found.end() :]
                if re.fullmatch(part["of"], head) and re.fullmatch(part["each"], tail):
                    heads[name] = (head, tail)
                    break
        else:
            head = name.rpartition(".")[0]
            if re.fullmatch(part["of"], head):
                heads[head] = (head, "")
    made = []
    for head, own in heads.values():
        tails = [name[len(head) + 1 :] for name in names if name.startswith(head + ".")]
        pins = {}
        for role, wanted in part["pins"].items():
            without = re.fullmatch(r"\$\{without (.*)\}", wanted)
            wanted = re.escape(own) if wanted == "$" else re.escape(own.replace(without[1], "")) if without else wanted
            found = next((tail for tail in tails if re.fullmatch(wanted, tail)), None)
            if found is not None:
                pins[role] = "%s.%s" % (head, found)
        if len(pins) > 1 or (pins and part["kind"] == "encoder"):
            made.append({"kind": part["kind"], "pins": pins, "numbers": dict(part.get("numbers", {}))})
    return made

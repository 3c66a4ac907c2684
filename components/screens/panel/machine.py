# SPDX-License-Identifier: GPL-2.0-or-later
"""Which functions a machine has: instances of components, found by the owners and the names of the pins."""

import collections

from panel import naming
from panel.texts import _

Channel = collections.namedtuple("Channel", "name module pins")
Channel.__doc__ = "A sensor's channel; pins are full names by their last words: value, age, valid, fault, fault-code."
SensorLink = collections.namedtuple("SensorLink", "name module owner fault_code")
SensorLink.__doc__ = "The link of a sensor program to its devices; fault_code is the full name of a pin."

OFF_PIN = "function-off-"  # of interlock: true is off


def is_on(write):
    """Whether the write of a switch switches on."""
    return (write.text.lower() in ("1", "true")) != write.short.startswith(OFF_PIN)


class Instance:
    """One instance of a component: its pins by short name."""

    def __init__(self, name, declared, pins):
        self.name, self.declared, self.pins = name, declared, pins

    @property
    def module(self):
        return self.declared.name

    @property
    def is_function(self):
        return self.declared.role == "compensation"

    def full(self, short):
        return self.name + "." + short

    def value(self, values, short, otherwise=None):
        return values.get(self.name + "." + short, otherwise)

    def sentence(self, values, short):
        """The sentence of a code pin now, in words, with the values of the settings that it names."""
        return naming.named(self, values, self.declared.sentence(short, self.value(values, short, 0)))

    def signature(self):
        return self.declared.name, tuple((short, pin.signal) for short, pin in self.pins.items())

    def settings(self):
        """Short names of the inputs that a screen may set: those without a signal, and not plumb-retain's."""
        return [short for short, pin in self.pins.items() if not pin.output and not pin.signal and not self.declared.is_of_records(short)]

    def inputs(self):
        return [short for short, pin in self.pins.items() if not pin.output and pin.signal and not self.declared.is_of_records(short)]

    def outputs(self):
        return [short for short, pin in self.pins.items() if pin.output and not self.declared.is_of_records(short)]


class Machine:
    """All that the pins of one moment show."""

    def __init__(self, pins, declared):
        self.pins = {pin.name: pin for pin in pins}
        self.instances = _instances(pins, declared)
        self.channels = _channels(pins, declared)
        self.links = _links(pins, declared)
        self._readers = collections.defaultdict(list)
        for pin in pins:
            if pin.signal and not pin.output:
                self._readers[pin.signal].append(pin.name)
        self._stages = {}
        self._writers = {pin.signal: pin.name for pin in pins if pin.signal and pin.output}

    def signature(self):
        """What pages depend on: the components with their pins and signals, and the channels."""
        return {each.name: each.signature() for each in self.instances}, [channel[:2] for channel in self.channels]

    def changed_since(self, former):
        """Names of the components that are not as they were in a former machine."""
        now, then = self.signature()[0], former.signature()[0]
        return {name for name in now.keys() | then.keys() if now.get(name) != then.get(name)}

    def title_of(self, instance):
        """As pages and messages call it: its title, with its name where there are several."""
        title = _(instance.declared.title) if instance.declared.title else ""
        return title if title and len(self.of(instance.module)) == 1 else ("%s %s" % (title, instance.name)).strip()

    def of(self, *modules):
        return [instance for instance in self.instances if instance.module in modules]

    def functions(self):
        return [instance for instance in self.instances if instance.is_function]

    def named(self, name):
        return next((instance for instance in self.instances if instance.name == name), None)

    def writer(self, pin):
        """The pin that writes the signal at a pin, '' without one."""
        there = self.pins.get(pin)
        return self._writers.get(there.signal, "") if there and there.signal else ""

    def stages_of(self, instance):
        """The stages that take the outputs of a function, by the letters of their axes."""
        if instance.name not in self._stages:
            found = {}
            for short, pin in instance.pins.items():
                letter = short[0].upper()
                if not pin.output or not pin.signal or short[1:] not in ("-correction", "-offset"):
                    continue
                for reader in self._readers[pin.signal]:
                    owner, there = self.owner_of(reader)
                    if owner is not None and owner.declared.role == "stage" and there.startswith("offset-"):
                        found[letter] = owner
            self._stages[instance.name] = found
        return self._stages[instance.name]

    def sources_of(self, stage):
        return [short for short, pin in stage.pins.items() if short.startswith("offset-") and short[-1].isdigit() and pin.signal]

    def permission(self, instance):
        """The interlock that permits a function, and the function's number there; None, -1 without one."""
        owner, short = self.owner_of(self.writer(instance.full("permit")))
        if owner is not None and short.startswith("function-permit-"):
            return owner, int(short.rsplit("-", 1)[1])
        return None, -1

    def switched_by(self, pin):
        """The function that a pin switches; None for another pin."""
        return next((each for each in self.functions() if self.switch_of(each) == pin), None)

    def switching(self, write):
        """The instance that a write switches, and whether on; None, False for another write."""
        its = self.switched_by(write.name) or (write.instance if write.short == "enable" else None)
        return its, its is not None and is_on(write)

    def switch_text(self, pin, on):
        """What a switch is to be for on or off."""
        return "1" if on != self.owner_of(pin)[1].startswith(OFF_PIN) else "0"

    def owner_of(self, pin):
        """The instance of a pin, and its short name; None, '' for a pin of another component."""
        for instance in self.instances:
            if pin.startswith(instance.name + ".") and pin[len(instance.name) + 1:] in instance.pins:
                return instance, pin[len(instance.name) + 1:]
        return None, ""

    def switch_of(self, instance):
        """The pin by which the interlock switches a function, or the function's own enable; '' if another signal drives it."""
        owner, number = self.permission(instance)
        if owner is not None:
            shorts = ("function-switch-%d" % number, "%s%d" % (OFF_PIN, number))
            return next((owner.full(short) for short in shorts if not owner.pins[short].signal), "")
        return instance.full("enable") if "enable" in instance.pins and not instance.pins["enable"].signal else ""


def _instances(pins, declared):
    by_owner, found = collections.defaultdict(dict), []
    by_name = {each.name: each for each in declared.values() if each.is_users}
    own = collections.defaultdict(dict)  # pins of the instances that messages.toml names
    for pin in pins:
        name, _dot, short = pin.name.rpartition(".")
        if name in by_name and short in by_name[name].pins:
            own[name][short] = pin
        else:
            by_owner[pin.owner][pin.name] = pin
    found += [Instance(name, by_name[name], there) for name, there in own.items()]
    for owner, its in by_owner.items():
        module = declared.get(owner)
        modules = [module] if module else [each for each in declared.values() if not each.is_of_sensors]
        groups = collections.defaultdict(dict)
        for name, pin in its.items():
            for each in modules:
                short = _short(name, each)
                if short:
                    groups[each.name, name[: -len(short) - 1]][short] = pin
        best = {}  # the module that has most of its pins there, by instance
        for (name, instance), there in groups.items():
            share = len(there) / len(declared[name].pins)
            if module or (share == 1 and len(there) == len(its)):
                if share > best.get(instance, (0, ""))[0]:
                    best[instance] = (share, name)
        for instance, (_, name) in best.items():
            order = {short: place for place, short in enumerate(declared[name].pins)}
            there = groups[name, instance]
            found.append(Instance(instance, declared[name], {short: there[short] for short in sorted(there, key=order.get)}))
    return sorted(found, key=lambda each: (not each.is_function, each.module if each.is_function else "", each.name))


def _short(name, declared):
    """The longest declared name at the end of a pin's name."""
    parts = name.split(".")
    for start in range(1, len(parts)):
        short = ".".join(parts[start:])
        if short in declared.pins:
            return short
    return ""


def _sensor_program(owner, names, programs):
    """The sensor program of a component: by its name, or the one whose pins are nearest to its pins."""
    def unlike(program):
        own = {short.rsplit(".", 1)[1] for short in program.pins if not short.startswith("OUTPUT.")}
        return len(own ^ {name.rsplit(".", 1)[1] for name in names})

    by_name = [each.name for each in programs if owner.replace("-", "_").startswith(each.name)]
    return by_name[0] if by_name else min(programs, key=unlike).name


def _channels(pins, declared):
    """The channels of sensor programs: groups of pins value, age and valid."""
    names = {pin.name: pin for pin in pins}
    programs = [each for each in declared.values() if each.is_of_sensors]
    found = []
    for pin in pins:
        if not pin.name.endswith(".value") or (pin.owner in declared and declared[pin.owner] not in programs):
            continue
        stem = pin.name[: -len(".value")]
        if stem + ".age" in names and stem + ".valid" in names:
            module = _sensor_program(pin.owner, [each.name for each in pins if each.owner == pin.owner], programs)
            parts = ("value", "age", "valid", "fault", "fault-code", "error-count")
            found.append(Channel(stem, module, {part: stem + "." + part for part in parts if stem + "." + part in names}))
    return found


def _links(pins, declared):
    """The links of sensor programs: groups of pins connected, round-trip, error-count and fault-code."""
    names = {pin.name for pin in pins}
    programs = [each for each in declared.values() if each.is_of_sensors]
    found = []
    for pin in pins:
        stem = pin.name.removesuffix(".connected")
        if stem != pin.name and {stem + ".fault-code", stem + ".error-count", stem + ".round-trip"} <= names:
            module = _sensor_program(pin.owner, [each.name for each in pins if each.owner == pin.owner], programs)
            found.append(SensorLink(stem, module, pin.owner, stem + ".fault-code"))
    return found

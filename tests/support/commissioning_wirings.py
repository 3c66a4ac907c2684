# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawn faults in the wiring of a function and its stages: a net that is missing, swapped, from another row, scaled, reversed, or the command; and
an output that a program reads in the place of another one."""

import re

SPARE = "spare"  # a mult2 of commissioning_machines
KINDS = ("missing", "swapped", "row", "sign", "twice", "command", "output")


class Wirings:
    """`do` carries out lines of HAL."""

    def __init__(self, rig, function, random, do):
        rig.look()
        self.rig, self.random, self.do = rig, random, do
        self.places = [rig.function(function.name), *rig.stages_of(function)]
        self.pins = [pin for place in self.places for short, pin in place.instance.pins.items()
                     if pin.signal and not place.instance.declared.is_of_records(short) and self._counts(pin)]
        lock = re.compile(r"interlock\.(function|stage)-(enable|status|permit|in-force)-\d+")
        self.pins += [pin for pin in rig.machine.pins.values() if lock.fullmatch(pin.name) and pin.signal and not pin.output
                      and any(pin.signal == its.signal for place in self.places for its in place.instance.pins.values())]

    def _counts(self, pin):
        """A pin whose signal goes to messages or to a screen alone is no part of the wiring that counts, nor is the source of another function."""
        owner, _short = self.rig.machine.owner_of(self.rig.machine.writer(pin.name))
        if owner is not None and owner.declared.role == "compensation" and owner.name not in [place.name for place in self.places]:
            return False
        others = [self.rig.machine.pins[name] for name in self.rig.ends(pin.signal) if name != pin.name]
        return not pin.output or any(not other.output and not re.match(r"linuxcnc-link\.|panel", other.name) for other in others)

    def put(self):
        """Draws a fault, and wires it. Returns what it is, and the lines that take it back."""
        while True:
            kind, pin = self.random.choice(KINDS), self.random.choice(self.pins)
            lines = getattr(self, "_" + kind)(pin)
            if lines:
                what, there, back = lines
                for line in there:
                    self.do(line)
                return "%s: %s" % (kind, what), back

    def _missing(self, pin):
        return pin.name, ["unlinkp " + pin.name], ["net %s %s" % (pin.signal, pin.name)]

    def _other(self, pin, pattern):
        """Another pin of the same kind, whose name differs in the match alone."""
        found = re.search(pattern, pin.name)
        if not found or pin.output:
            return None
        before, behind = re.escape(pin.name[: found.start()]), re.escape(pin.name[found.end() :])
        others = [other for other in self.rig.machine.pins.values() if re.fullmatch(before + pattern + behind, other.name)
                  and other.name != pin.name and other.signal and other.signal != pin.signal and not other.output]
        return self.random.choice(others) if others else None

    def _exchange(self, pin, other):
        pairs = ((pin, other.signal), (other, pin.signal))
        there = ["unlinkp %s" % pin.name, "unlinkp %s" % other.name] + ["net %s %s" % (signal, its.name) for its, signal in pairs]
        back = ["unlinkp %s" % pin.name, "unlinkp %s" % other.name] + ["net %s %s" % (its.signal, its.name) for its, _signal in pairs]
        return "%s and %s" % (pin.name, other.name), there, back

    def _swapped(self, pin):
        other = self._other(pin, r"(?<=[.])[xyz](?=-)|^[xyz](?=-)")
        return self._exchange(pin, other) if other else None

    def _row(self, pin):
        other = self._other(pin, r"\d+$")
        if other:
            return self._exchange(pin, other)
        found = re.fullmatch(r"(?P<what>.*\.(permit|enable|interlock-status))", pin.name)
        others = [its for its in self.rig.machine.pins.values() if found and its.name.rpartition(".")[2] == pin.name.rpartition(".")[2]
                  and its.name != pin.name and its.kind == pin.kind and its.signal and its.signal != pin.signal and not its.output]
        return self._exchange(pin, self.random.choice(others)) if others else None

    def _output(self, pin):
        """A program reads another output in the place of this one."""
        read = self.rig.read_by_programs(self.places[0])
        others = [name for name in read if name != pin.name and self.rig.machine.pins[name].kind == pin.kind]
        if pin.name not in read or not others:
            return None
        other = self.rig.machine.pins[self.random.choice(others)]
        ends = [(read[pin.name], pin.signal), (read[other.name], other.signal)]
        gone = ["unlinkp " + end for end, _signal in ends]
        return ("%s and %s" % (pin.name, other.name), [*gone, "net %s %s" % (ends[1][1], ends[0][0]), "net %s %s" % (ends[0][1], ends[1][0])],
                [*gone, *("net %s %s" % (signal, end) for end, signal in ends)])

    def _scaled(self, pin, gain):
        if pin.output or pin.kind != "float":
            return None
        there = ["unlinkp " + pin.name, "setp %s.in1 %g" % (SPARE, gain), "net %s %s.in0" % (pin.signal, SPARE), "addf %s servo-thread 1" % SPARE,
                 "net drawn %s.out %s" % (SPARE, pin.name)]
        back = ["unlinkp " + pin.name, "unlinkp %s.in0" % SPARE, "unlinkp %s.out" % SPARE, "delf %s servo-thread" % SPARE,
                "net %s %s" % (pin.signal, pin.name)]
        return pin.name, there, back

    def _sign(self, pin):
        return self._scaled(pin, -1)

    def _twice(self, pin):
        return self._scaled(pin, 2)

    def _command(self, pin):
        """The command in the place of the feedback."""
        found = re.fullmatch(r"joint\.(\d+)\.(motor-)?pos-fb|(\w)-stage\.joint-feedback|fault-(\w)-fb\.out|(?:artifact\.|fault-growth-test-)(\w)-position(?:\.out)?",
                             self.rig.machine.writer(pin.name) or "")
        if not found or pin.output:
            return None
        joint = found[1] or "xyz".index(found[3] or found[4] or found[5])
        command = self.rig.machine.pins["joint.%s.motor-pos-cmd" % joint].signal
        return pin.name, ["unlinkp " + pin.name, "net %s %s" % (command, pin.name)], ["unlinkp " + pin.name, "net %s %s" % (pin.signal, pin.name)]

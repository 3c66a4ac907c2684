# SPDX-License-Identifier: GPL-2.0-or-later
"""Attacks on thermal_displacement: what happens to the mill of configs/mill/bench.hal, to its load or to its program."""

import dataclasses

import numpy as np

from support.mill_machine import every_end_mill_is_a_gauge, unlink

TEACH = 1800  # s from the start of an attack's run to its begin


def program_event(host, jitter=0.0):
    """Coolant comes on 1.5 mm above the work, and the load rises as by a cut."""
    host.set("drive.coolant-load", 6)
    host.set("program.coolant-height", 1.5)
    host.set("program.coolant-jitter", jitter)


def force(host, number, **values):
    """The event of that number in every cycle from now on."""
    for name, value in values.items():
        host.set("program.event-" + name, value)
    host.set("program.event", number)


CHIP, STOCK, LONGER, OVERRIDE, SPEED_CHANGE = 2, 3, 5, 6, 10  # events of sim_part_program


def replay(host, height):
    host.set("mill.growth-replay", height)
    host.set("mill.use-replay", True)


@dataclasses.dataclass
class Attack:
    """`prepare(host)` before the learning cycle; `events`: (s since the attack began, function of the host)."""

    name: str
    prepare: object = lambda host: None
    events: tuple = ()


def steps(times, function):
    return tuple((time, lambda host, time=time: function(host, time)) for time in times)


def chip_after_a_pause():
    return (
        (0, lambda host: host.set("program.run", False)),
        (5400, lambda host: (force(host, CHIP, height=0.04, operation=10), host.set("program.run", True))),
        (5700, lambda host: host.set("program.event", 0)),
    )


def one_gauge(host):
    """Operation 40 alone."""
    host.set("growth.exclude-operation-1", 10)


def every_gauge(host):
    every_end_mill_is_a_gauge(host)


def chiller(host):
    """The spindle's chiller holds its growth at 12 um, then at 17 um at another speed."""
    host.set("program.sides-speed", 3000)
    replay(host, 0)


def short_filter(host):
    host.set("drive.lag", 0.02)


def stock(height):
    return ((0, lambda host: force(host, STOCK, height=height)),)


ATTACKS = [
    Attack("none"),
    Attack("event of the program", program_event),
    Attack("event of the program, jitter 10 ms", lambda host: program_event(host, 0.01)),
    Attack("event of the program at one of two tools", lambda host: (every_gauge(host), program_event(host, 0.001), host.set("drive.coolant-load", 3))),
    Attack("poor reference", lambda host: (host.set("drive.white-noise", 4), host.set("drive.flicker-noise", 2)),
           ((-TEACH + 290, lambda host: (host.set("drive.white-noise", 0.3), host.set("drive.flicker-noise", 0.1))),)),
    Attack("load dead at 0", events=((0, lambda host: unlink(host, "growth.load", 0)),)),
    Attack("load frozen", events=((0, lambda host: unlink(host, "growth.load", 11.3)),)),
    Attack("load not a number", events=((0, lambda host: unlink(host, "growth.load", float("nan"))),)),
    Attack("gauge tool 30 um longer", one_gauge, ((0, lambda host: force(host, LONGER, height=0.03, operation=40)),)),
    Attack("two gauges 37 um apart", every_gauge, ((0, lambda host: force(host, LONGER, height=0.037, operation=40)),)),
    Attack("sister tool", events=((0, lambda host: unlink(host, "growth.tool-number", 9)),)),
    Attack("chiller, another speed", chiller,
           (*steps(range(-1500, 0, 60), lambda host, time: replay(host, 0.012 * (1 - np.exp(-(time + 1500) / 600)))),
            (0, lambda host: host.set("program.sides-speed", 20000)),
            *steps(range(0, 3600, 60), lambda host, time: replay(host, 0.012 + 0.005 * (1 - np.exp(-time / 600)))))),
    Attack("chip after a pause", events=chip_after_a_pause()),
    Attack("override of 70 % on the only gauge", one_gauge, ((0, lambda host: force(host, OVERRIDE, factor=0.7, operation=40)),)),
    Attack("speed changes on the approach", one_gauge, ((0, lambda host: force(host, SPEED_CHANGE, factor=0.9, operation=40)),)),
    Attack("interrupted surface", events=((0, lambda host: host.set("program.blank-repeatability", 0.012)),)),
    Attack("step of 20 um", every_gauge, (*steps([-900], lambda host, time: replay(host, 0.01)), (0, lambda host: replay(host, 0.03)))),
]

SHIFTS = [  # of all contacts, on machines that grow by little
    Attack("the only tool 30 um longer", short_filter, ((0, lambda host: force(host, LONGER, height=0.03, operation=10)),)),
    Attack("blanks 25 um higher", short_filter, stock(0.025)),
    Attack("a chamfer, 25 um lower", short_filter, stock(-0.025)),
    Attack("a fixture 50 um higher", short_filter, stock(0.05)),
    Attack("15 ms more latency of the load", lambda host: (short_filter(host), host.set("growth.load-latency", 0.015)),
           ((0, lambda host: host.set("growth.load-latency", 0)),)),
    Attack("filter of the drive 20 to 50 ms", short_filter, ((0, lambda host: host.set("drive.lag", 0.05)),)),
]


def attack_named(name):
    return next(attack for attack in ATTACKS + SHIFTS if attack.name == name)

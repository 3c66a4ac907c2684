# SPDX-License-Identifier: GPL-2.0-or-later
"""Why the machine waits, in sentences, from the requests of interlock."""

from panel.texts import _

SERVICES, FUNCTIONS = 8, 6
ALL = (1 << SERVICES) - 1
# By the pin that shows whether it lives. For gettext: _("LinuxCNC's task"), _("LinuxCNC's io")
PROGRAMS = {"task-heartbeat": "LinuxCNC's task", "io-heartbeat": "LinuxCNC's io"}


def waiting(machine, values):
    found = []
    for interlock in machine.of("interlock"):
        lost = bool(interlock.value(values, "feed-service-lost"))
        if lost:
            found.append(_loss(machine, interlock, values))
        for short, text in (("feed-inhibit", _("The next move waits until no offset and no correction of the tool changes.")),
                            ("probing-refused", _("Probing is refused: take the offset back first.")),
                            ("feed-held", _("The feed is held for long.")),
                            ("homing-inhibit", _("Homing waits: an offset is in force. Take it back, or switch the function off.")),
                            ("uncompensated", _("An axis lacks its offset until the next cycle begins."))):
            if interlock.value(values, short) and not (lost and short == "feed-inhibit"):
                found.append(text)
    return found


def _loss(machine, interlock, values):
    """What holds the feed: services that do not answer now, or functions that a lost one has put off."""
    services = _of_the_feed(interlock, values)
    if services:
        names = ", ".join(_service(machine, interlock, number) for number in services)
        return _("No answer from {services}: the feed is held. Start LinuxCNC again.").format(services=names)
    functions = [number for number in range(FUNCTIONS) if interlock.value(values, "function-lost-%d" % number)]
    names = ", ".join(_function(machine, interlock, number) for number in functions)
    return _("{functions}: off because a service was lost, and the feed is held. When the service answers again, turn the switch off "
             "and on.").format(functions=names)


def _of_the_feed(interlock, values):
    """The lost services that hold the feed."""
    lost = [number for number in range(SERVICES) if interlock.value(values, "service-lost-%d" % number)]
    needed = 0
    for short in ("feed-services", *("function-urgent-%d" % number for number in range(FUNCTIONS))):
        sum_of = interlock.value(values, short, 0)
        needed |= sum_of if 0 <= sum_of <= ALL else ALL
    return [number for number in lost if needed & 1 << number]


def _service(machine, interlock, number):
    program, dot, pin = machine.writer(interlock.full("service-heartbeat-%d" % number)).partition(".")
    if pin in PROGRAMS:
        return _(PROGRAMS[pin])
    return program if dot else _("service {number}").format(number=number)


def _function(machine, interlock, number):
    enable = interlock.full("function-enable-%d" % number)
    names = [each.name for each in machine.instances if machine.writer(each.full("enable")) == enable]
    return names[0] if names else _("function {number}").format(number=number)

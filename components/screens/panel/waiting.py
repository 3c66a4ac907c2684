# SPDX-License-Identifier: GPL-2.0-or-later
"""Why the machine waits, in sentences, from the requests of interlock."""

from panel import services
from panel.texts import _


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
            if short == "homing-inhibit" and interlock.value(values, "all-homed"):
                continue  # nobody homes in production, where offsets are in force
            if interlock.value(values, short) and not (lost and short == "feed-inhibit"):
                found.append(text)
    return found


def _loss(machine, interlock, values):
    """What holds the feed: services that do not answer now, or functions that a lost one has put off."""
    lost = _of_the_feed(interlock, values)
    if lost:
        return _("No answer from {services}: the feed is held. Start LinuxCNC again.").format(services=services.names(machine, interlock, lost))
    functions = [number for number in range(services.FUNCTIONS) if interlock.value(values, "function-lost-%d" % number)]
    names = ", ".join(services.function(machine, interlock, number) for number in functions)
    return _("{functions}: off because a service was lost, and the feed is held. When the service answers again, turn the switch off "
             "and on.").format(functions=names)


def _of_the_feed(interlock, values):
    """The lost services that hold the feed."""
    needed = set()
    for short in ("feed-services", *("function-urgent-%d" % number for number in range(services.FUNCTIONS))):
        needed |= set(services.of_sum(interlock.value(values, short, 0)))
    return [number for number in sorted(needed) if interlock.value(values, "service-lost-%d" % number)]

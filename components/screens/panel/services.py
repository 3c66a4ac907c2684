# SPDX-License-Identifier: GPL-2.0-or-later
"""The services and functions of interlock by the names of their programs and components."""

from panel.texts import _

SERVICES, FUNCTIONS = 8, 6
ALL = (1 << SERVICES) - 1
# By the pin that shows whether it lives. For gettext: _("LinuxCNC's task"), _("LinuxCNC's io")
PROGRAMS = {"task-heartbeat": "LinuxCNC's task", "io-heartbeat": "LinuxCNC's io"}


def of_sum(total):
    """The numbers of services in a sum such as function-services; one out of range stands for all."""
    its = total if total is not None and 0 <= total <= ALL else ALL
    return [number for number in range(SERVICES) if its & 1 << number]


def names(machine, interlock, numbers):
    return ", ".join(service(machine, interlock, number) for number in numbers)


def service(machine, interlock, number):
    program, dot, pin = machine.writer(interlock.full("service-heartbeat-%d" % number)).partition(".")
    if pin in PROGRAMS:
        return _(PROGRAMS[pin])
    return program if dot else _("service {number}").format(number=number)


def function(machine, interlock, number):
    enable = interlock.full("function-enable-%d" % number)
    found = [each.name for each in machine.instances if machine.writer(each.full("enable")) == enable]
    return found[0] if found else _("function {number}").format(number=number)

# SPDX-License-Identifier: GPL-2.0-or-later
"""What a function does now: a kind and a sentence, from its pins, its interlock, its stages and LinuxCNC. Without a screen.

The kinds are good (it acts), wait (it acts as soon as something comes that will), off (by the operator, or nothing to do),
warn (somebody has to do something) and bad (a fault or a loss).
"""

import collections

from panel import services
from panel.texts import _

Status = collections.namedtuple("Status", "kind text")


def gone(instance, values):
    """A component that is not there, or an output that is no number; None with neither."""
    if not any(pin.name in values for pin in instance.pins.values()):
        return Status("bad", _("{name} is not loaded any more.").format(name=instance.name))
    for short in instance.outputs():
        value = instance.value(values, short)
        if isinstance(value, float) and value != value:
            return Status("bad", _("{pin} is not a number.").format(pin=instance.full(short)))
    return None


def not_a_number(instance, values):
    """An input that is no number; None without one."""
    for short in (*instance.inputs(), *instance.settings()):
        value = instance.value(values, short)
        if isinstance(value, float) and value != value:
            return Status("warn", _("{pin} is not a number.").format(pin=instance.full(short)))
    return None


def fault(instance, values):
    if not instance.value(values, "fault"):
        return None
    return Status("bad", _(instance.sentence(values, "fault-code")) or _("A fault is active."))


def withheld(machine, instance, values):
    """Who keeps a function from acting: a lost or late service, the operator, or the part program. None if nobody does."""
    interlock, number = machine.permission(instance)
    if interlock is None:
        own = instance.full("enable")
        return Status("off", _("Switched off.")) if own in values and not values[own] else None

    def get(short):
        return interlock.value(values, "%s-%d" % (short, number))

    needed = services.of_sum(get("function-services"))
    late = services.names(machine, interlock, [each for each in needed if interlock.value(values, "service-ok-%d" % each) is False])
    if get("function-lost"):
        lost = services.names(machine, interlock, [each for each in needed if interlock.value(values, "service-lost-%d" % each)])
        if get("function-enable"):
            return Status("warn", _("Acts until the program ends, then goes off: no answer from {services}.").format(services=lost or _("a service")))
        if lost:
            return Status("bad", _("Off: no answer from {services}. Start LinuxCNC again.").format(services=lost))
        if late:
            return Status("warn", _("Off: {services} is not ready.").format(services=late))
        return Status("bad", _("Off because a service was lost. It answers again: turn the switch off and on."))
    if get("function-enable"):
        return None
    if not get("function-switch"):
        return Status("off", _("Switched off."))
    if get("function-suspend"):
        return Status("wait", _("Suspended by the part program."))
    if late:
        return Status("warn", _("Off: {services} is not ready.").format(services=late))
    why = _(interlock.sentence(values, "fault-code"))
    return Status("warn", _("Off by interlock: {why}").format(why=why) if why else _("Off by interlock."))


def machine_waits(values, homed=None):
    """Why the machine moves no axis now; '' if it may. `homed` is a pin of the function, in the place of LinuxCNC's."""
    if values.get("motion.motion-enabled") is False:
        return _("The machine is off.")
    if (values.get("motion.is-all-homed") if homed is None else homed) is False:
        return _("The machine is not homed.")
    return ""


def bounded(instance, values):
    """A statement of the component that is no fault, such as limited or unsettled; None without one."""
    for short in instance.declared.codes:
        if short not in ("fault-code", "state-code", "stop-reason-code", "hold-code") and instance.value(values, short[: -len("-code")]):
            return Status("warn", _(instance.sentence(values, short)))
    return None


def stages_fault(machine, instance, values):
    """The fault of a stage that takes an output of the function; None without one."""
    for stage in machine.stages_of(instance).values():
        found = fault(stage, values)
        if found:
            return Status("bad", "%s: %s" % (stage.name, found.text))
    return None


def program_state(values):
    """idle, running or paused; '' if nobody knows."""
    if values.get("task.alive") and "task.program" in values:
        return values["task.program"]
    if values.get("halui.program.is-paused"):
        return "paused"
    if values.get("halui.program.is-running"):
        return "running"
    for name in ("linuxcnc-alive.program-running", "halui.program.is-idle"):
        if name in values:
            return "running" if bool(values[name]) == name.endswith("running") else "idle"
    return ""

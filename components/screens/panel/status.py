# SPDX-License-Identifier: GPL-2.0-or-later
"""What a function does now, as its component says by its status-code, in words. Without a screen."""

import collections
import math

from panel.texts import _, in_micrometres, with_unit

Status = collections.namedtuple("Status", "kind text remedy button", defaults=("", ""))
Status.__doc__ = """kind is good, wait, off, warn or bad; remedy is a sentence, and button the name of the one that does it:
switch, acknowledge, learn, dry-run, to-end, hold, stop, start, resume, report, enter, store."""

# The quantity of a status, by its pin. For gettext: _("Standard deviation"), _("Contacts"), _("Strokes"), _("Offset"), _("Distance")
QUANTITIES = {"offset-sigma": "Standard deviation", "contacts": "Contacts", "rows": "Contacts", "stroke-count": "Strokes", "offset": "Offset",
              "stands-off-by": "Distance"}
SMALL = ("offset-sigma",)  # shown in micrometres


def of(instance, values):
    """The status of a function."""
    if not any(pin.name in values for pin in instance.pins.values()):
        return Status("bad", _("{name} is not loaded any more.").format(name=instance.name), _("Start LinuxCNC again."))
    its = instance.declared.statuses.get(instance.value(values, "status-code", 0))
    if its is None:
        return Status("bad", _("{name} is not called: no thread runs its function update.").format(name=instance.name), _("Run plumb doctor --running."))
    return Status(its["kind"], " ".join(filter(None, (_(its["sentence"]), _detail(instance, values, its["detail"])))), _(its["remedy"]), its["button"])


def kind_and_words(instance, values):
    """Sentence and remedy together, for one line."""
    its = of(instance, values)
    return its.kind, " ".join(filter(None, (its.text, its.remedy)))


def _detail(instance, values, short):
    """The sentence of a code, or a quantity; '' without one."""
    now = instance.value(values, short)
    if short in instance.declared.codes:
        return instance.sentence(values, short)
    if now is None or (isinstance(now, float) and not math.isfinite(now)):
        return ""
    unit = instance.declared.pin(short).get("unit", "")
    shown = in_micrometres(float(now)).lstrip("+") if short in SMALL else with_unit(round(now, 4), unit)
    return "%s: %s." % (_(QUANTITIES.get(short, short)), shown)


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

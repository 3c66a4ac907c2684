# SPDX-License-Identifier: GPL-2.0-or-later
"""thermal_displacement in one plain line. Without a screen."""

from panel.status import Status, fault, gone, machine_waits, stages_fault, withheld
from panel.texts import _, in_micrometres, seconds


LOAD_NOT_VALID, OFFSET_RETURNS = 1, (2, 3)  # doubt-code


def status(machine, instance, values):
    """Whether the growth is corrected now, and how well."""
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    found = gone(instance, values)
    if found:
        return found
    found = fault(instance, values)
    if found:
        return Status("bad", _("Not trusted: {why}").format(why=found.text))
    keeper = withheld(machine, instance, values)
    if keeper and keeper.kind == "bad":
        return keeper
    doubt = _(instance.sentence(values, "doubt-code")) if get("doubt") else ""
    if not get("load-valid", True):
        lost = _("The load is lost: its sensor reports no valid value.")
        if doubt and get("doubt-code") == LOAD_NOT_VALID:
            return Status("bad", doubt)  # which names the load, too
        return Status("bad", "%s %s" % (lost, doubt) if doubt and get("doubt-code") in OFFSET_RETURNS else lost)
    return (_of_reference(instance, values) or keeper or (Status("warn", _("Not trusted: {why}").format(why=doubt)) if doubt else None)
            or _of_offset(machine, instance, values))


def _of_reference(instance, values):
    """Learning, and whether there is a reference; None with a good one."""
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    if get("learning"):
        return Status("good", _("Learning from this part. {count} contacts so far.").format(count=get("contacts")))
    if get("learn"):
        return Status("good", _("Learns from the next part."))
    if get("learning-failed"):
        return Status("warn", _("Nothing was learnt: {why}").format(why=_(instance.sentence(values, "learning-failed-code"))))
    if get("reference-refused"):
        return Status("bad", _("Not trusted: {why} Acknowledge, or learn again.").format(why=_(instance.sentence(values, "refusal-code"))))
    if get("reference-valid"):
        return None
    if not get("rows"):
        return Status("warn", _("Not working: there is no reference for this program. Learn from a part on the cold machine."))
    if not get("cycle-running"):
        return Status("wait", _("Waits for the program: a reference of {count} contacts is kept. Do not learn again: it comes into force as a "
                                "cycle of its program begins.").format(count=get("rows")))
    return Status("warn", _("Not working: the kept reference of {count} contacts is of another program or other tools. Learning replaces it.").format(
        count=get("rows")))


def _of_offset(machine, instance, values):
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    if get("dry-run"):
        return Status("off", _("Dry run: the growth is measured, and Z is not moved."))
    why = machine_waits(values)
    if why:
        return Status("wait", _("{why} Z is not corrected now.").format(why=why))
    found = stages_fault(machine, instance, values)
    if found:
        return found
    if not get("growth-known"):
        return Status("warn", _("Waiting for the first contact: the growth is not known yet."))
    for stage in machine.stages_of(instance).values():
        if stage.value(values, "uncompensated") or stage.value(values, "armed") is False:
            return Status("wait", _("Z has no offset until the next cycle begins."))
        if stage.value(values, "limited"):
            return Status("warn", _("A bound of {stage} keeps the whole correction from {axis}.").format(stage=stage.name, axis="Z"))
    if get("limited"):
        return Status("warn", _("The growth is larger than max-offset: Z is corrected by a part of it."))
    sigma = 2 * get("offset-sigma", 0.0)
    return Status("good", _("Working, \u00b1{sigma}.").format(sigma=in_micrometres(sigma).lstrip("+")))


def reference(instance, values):
    """The reference and its contacts in words."""
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    if get("reference-refused"):
        return _("Refused: {why}").format(why=_(instance.sentence(values, "refusal-code")))
    if not get("reference-valid"):
        if get("rows"):
            return _("{count} contacts are kept, of another program or before its cycle begins.").format(count=get("rows"))
        return _("There is none for this program and these tools.")
    text = _("Valid, of {count} contacts, with a standard deviation of {sigma}.").format(
        count=get("rows"), sigma=in_micrometres(float(get("reference-sigma", 0.0))).lstrip("+"))
    if not get("growth-known"):
        return text + " " + _("No contact has counted since the start.")
    if get("contact-age", 0.0) > 0:
        return text + " " + _("No contact has counted for {age}.").format(age=seconds(float(get("contact-age", 0.0))))
    return text


def learning_steps(instance, values):
    """The steps of learning, each with whether it is done."""
    get = lambda short: instance.value(values, short, 0)  # noqa: E731
    learnt = bool(get("reference-valid")) and not get("learn") and not get("learning")
    return [
        (_("Learning is requested."), bool(get("learn") or get("learning") or learnt)),
        (_("A part begins (M64 P0)."), bool(get("learning") or learnt)),
        (_("Contacts are found."), bool((get("learning") and get("contacts")) or learnt)),
        (_("The part is complete, and the reference is valid."), learnt),
    ]

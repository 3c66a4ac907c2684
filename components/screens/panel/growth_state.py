# SPDX-License-Identifier: GPL-2.0-or-later
"""thermal_displacement in one plain line. Without a screen."""

import math

from panel.texts import _, in_micrometres


def verdict(instance, values):
    """Kind and sentence: whether the growth is corrected now, and how well."""
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    if instance.full("fault") not in values:
        return "bad", _("{name} is not loaded any more.").format(name=instance.name)
    for short in ("growth-estimate", "z-offset", "applied-offset", "offset-sigma"):
        if not math.isfinite(get(short, 0.0)):
            return "bad", _("{pin} is not a number.").format(pin=instance.full(short))
    if get("fault"):
        return "bad", _("Not trusted: {why}").format(why=_(instance.sentence(values, "fault-code")))
    if not get("load-valid", True):
        return "bad", _("The load is lost: its sensor reports no valid value.")
    if get("learning"):
        return "good", _("Learning from this part. {count} contacts so far.").format(count=get("contacts"))
    if get("learn"):
        return "good", _("Learns from the next part.")
    if get("learning-failed"):
        return "warn", _("Nothing was learnt: {why}").format(why=_(instance.sentence(values, "learning-failed-code")))
    if get("reference-refused"):
        return "bad", _("Not trusted: {why} Acknowledge, or learn again.").format(why=_(instance.sentence(values, "refusal-code")))
    if not get("reference-valid"):
        return "warn", _("Not working: there is no reference for this program. Learn from a part on the cold machine.")
    if not get("enable"):
        return "off", _("Switched off.")
    if get("doubt"):
        return "warn", _("Not trusted: {why}").format(why=_(instance.sentence(values, "doubt-code")))
    if get("dry-run"):
        return "off", _("Dry run: the growth is measured, and Z is not moved.")
    if not get("growth-known"):
        return "warn", _("Waiting for the first contact: the growth is not known yet.")
    if get("limited"):
        return "warn", _("The growth is larger than max-offset: Z is corrected by a part of it.")
    sigma = 2 * get("offset-sigma", 0.0)
    return "good", _("Working, \u00b1{sigma}.").format(sigma=in_micrometres(sigma).lstrip("+"))


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

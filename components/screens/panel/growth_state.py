# SPDX-License-Identifier: GPL-2.0-or-later
"""The reference of thermal_displacement in words. Without a screen."""

from panel.texts import _, in_micrometres, seconds


def reference(instance, values):
    """The reference and its contacts in words."""
    def get(short, otherwise=0):
        return instance.value(values, short, otherwise)

    if get("reference-refused"):
        return _("It is refused.")
    if not get("reference-valid"):
        if get("rows"):
            return _("{count} contacts are kept, of other programs or tools.").format(count=get("rows"))
        return _("There is none for this program and these tools.")
    text = _("Valid, with a standard deviation of {sigma}; {count} contacts of all programs are kept.").format(
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

# SPDX-License-Identifier: GPL-2.0-or-later
"""Why the machine waits, as interlock says it. Without a screen."""

from panel.texts import _


def waiting(machine, values):
    sentences = (interlock.sentence(values, "waiting-code") for interlock in machine.of("interlock"))
    return [_(sentence) for sentence in sentences if sentence]

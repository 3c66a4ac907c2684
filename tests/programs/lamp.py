#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A component of a user, with the two pins that linuxcnc_link tells: lamp.status-code and lamp.detail-code, from lamp.status and lamp.detail.

Its texts are in MESSAGES, for messages.toml.
"""

import time

MESSAGES = """\
[lamp]
title = "Lamp"
[lamp.statuses.1]
kind = "bad"
sentence = "The lamp is dark."
remedy = "Replace it."
[lamp.statuses.2]
kind = "warn"
tell = "behind-panel"
sentence = "The lamp flickers."
[lamp.codes.detail-code]
7 = "The thread is broken."
"""


def main():
    import hal

    component = hal.component("lamp")
    for name in ("status", "detail"):
        component.newpin(name, hal.HAL_S32, hal.HAL_IN)
        component.newpin(name + "-code", hal.HAL_S32, hal.HAL_OUT)
    component.ready()
    while True:
        for name in ("status", "detail"):
            component[name + "-code"] = component[name]
        time.sleep(0.02)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""An [APPLICATIONS]APP of mill_config_test: looks at the wiring of the panel beside AXIS, and ends AXIS."""

import json
import subprocess

import plumb
from plumb_linuxcnc import Machine


def value(host, pin):
    """None while there is no such pin."""
    try:
        return host.get(pin)
    except plumb.Refused:
        return None


with Machine() as machine:
    host = machine.host
    machine.wait_for(lambda _: value(host, "pyvcp.load"), "the panel, and a load that is not 0")
    machine.wait_for(lambda _: value(host, "pyvcp.compensate"), "its checkbutton")
    machine.turn_on()
    machine.home()
    seen = {"compensates": host.get("growth.enable")}
    host.halcmd("unlinkp", "pyvcp.learn")  # the button, which this program presses
    host.set("learn-button", True)
    machine.wait_for(lambda _: host.get("growth.learn"), "the request to learn")
with open("panel.json", "w") as file:
    json.dump(seen, file)
subprocess.run(["axis-remote", "--quit"], check=True)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Traps that a finger sets plumb panel in more than one screen."""

import os

from tree import BUILD

SENSORS = """[[link]]
name = "cabinet"
tcp = "127.0.0.1:1"
[[link.channel]]
name = "spindle-load"
table = "holding"
register = 0
type = "s16"
unit = "%"
every = 0.5
max-age = 3
min = 0
max = 200
max-rate = 5000
"""


def enter_an_incomplete_lean(finger, chain):
    """Half of a form, which must outlast all that follows."""
    finger.open("Squareness", "Measure and set up")
    finger.open("Measure and set up", chain)
    finger.open(chain, "Y EC0Y")
    finger.press("Y EC0Y")
    finger.type("0.04")


def stop_in_the_form(finger, machine, seen):
    """An emergency stop leaves the half-filled form, which goes on after it; nothing has been written."""
    machine.emergency_stop()
    finger.rest()
    seen["stopped entries"] = [each["text"] for each in finger.widgets() if each["kind"] == "Entry"]


def lose_a_sensor(finger, host, seen):
    """The real modbus_sensor, of a device that does not answer: the half-filled form stays, the page Sensors comes, and the load is lost."""
    path = os.path.abspath("sensors.toml")
    with open(path, "w") as file:
        file.write(SENSORS)
    host.halcmd("unloadusr", "linuxcnc-link")  # its message of the lost sensor would cover the buttons of a screen
    done = host.halcmd("loadusr", "-W", os.path.join(BUILD, "bin", "modbus_sensor"), "--file", path)
    if done.status:
        raise AssertionError(done.output)
    host.command("net test-load-valid modbus-sensor.spindle-load.valid => growth.load-valid")
    finger.until(lambda: finger.find("Sensors"), "the page of the sensors")
    seen["entries"] = [each["text"] for each in finger.widgets() if each["kind"] == "Entry"]
    finger.press("Sensors")
    seen["lost sensor"] = finger.await_text("No valid value: modbus-sensor.spindle-load.")
    finger.press("Growth of Z")
    seen["input"] = finger.await_text("\u2716 not valid")
    finger.press("Overview")
    finger.await_text("No valid value: modbus-sensor.spindle-load.")

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill/sensors.ini in a complete LinuxCNC: a Modbus device that goes and comes back, and no CAN."""

import os
import unittest

import linuxcnc_runs
from linuxcnc_runs import own_folder, read_recording
from starts import starts


class Sensors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = linuxcnc_runs.copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "sensors.ini"))
        its, _ = linuxcnc_runs.work(folder, ini, "mill_sensors.py")
        cls.facts, cls.told = its["facts"], its["errors"] + its["messages"]
        cls.shift = read_recording(os.path.join(machine, "shift.csv"))

    def test_a_temperature_comes_over_modbus(self):
        self.assertAlmostEqual(self.facts["nose"], -1.5)
        self.assertEqual(self.facts["alive"], [True, False])

    def test_without_can_no_load_is_valid_and_nothing_moves(self):
        self.assertEqual(self.facts["without CAN"], [False, False, False])
        self.assertEqual(self.shift["growth.load-valid"].max(), 0)
        self.assertEqual(abs(self.shift["axis.z.eoffset"]).max(), 0)

    def test_the_operator_gets_a_message_for_each_lost_link_and_none_of_its_channels(self):
        for message in ("can-sensor.drives: ", "Growth of Z: The load is lost", "modbus-sensor.cabinet: "):
            self.assertTrue(any(one.startswith(message) for one in self.told), (message, self.told))
        self.assertFalse(any("The link is not connected" in one for one in self.told), self.told)

    def test_no_cycle_begins_without_linuxcnc_link(self):
        self.assertEqual(self.facts["link"], [True, True, True])
        self.assertEqual(*self.facts["without link"])


tearDownModule = starts("mill/sensors.ini")


if __name__ == "__main__":
    linuxcnc_runs.main(Sensors, __doc__)

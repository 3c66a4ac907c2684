# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench growth_sensors: the faults that it makes, its figures, and a short day of one machine."""

import unittest

import numpy as np

import growth_sensors
from growth_sensors import BEGIN, NAMES, STEP, Faults


class Spoilt(unittest.TestCase):
    def test_a_fault_begins_in_work_and_spoils_its_sensor_alone(self):
        faults, cold, warm = Faults(), [20.0, 20.0, 20.0], [30.0, 24.0, 21.0]
        for time in range(0, BEGIN, STEP):
            spoilt = faults.spoilt(cold, time)
        self.assertTrue(all(values == cold for values in spoilt.values()))  # cold, swapped sensors agree
        faults.spoilt(cold, BEGIN)
        spoilt = faults.spoilt(warm, BEGIN + 3600)
        self.assertEqual(spoilt["bed +20 K"], [30, 44, 21])
        self.assertEqual(spoilt["spindle and bed swapped"], [24, 30, 21])
        self.assertEqual(spoilt["spindle frozen"], [20, 24, 21])
        self.assertEqual(spoilt["spindle drifts 3 K/h"], [33, 24, 21])
        self.assertEqual(spoilt["spindle's loose, half"], [25.5, 24, 21])

    def test_the_effect_counts_until_the_sensor_is_named(self):
        effect = np.array([0, 4, 12, 30.0])
        self.assertEqual(growth_sensors.before(effect, np.array([False, True, True, True])), (4, True))
        self.assertEqual(growth_sensors.before(effect, np.array([False] * 4)), (30, False))


class Figures(unittest.TestCase):
    def test_harmless_faults_do_not_count_and_late_names_do(self):
        named = [(3.0, True)] * len(NAMES)
        late = [(15.0, True)] + named[1:]
        harmless = [(2.0, False)] * len(NAMES)
        outcomes = [{"named": its, "span": harmless, "named falsely": 0.01, "span falsely": 0.03} for its in (named, late, harmless)]
        text = "\n".join(growth_sensors.figures(outcomes))
        self.assertIn("named before 10 um: 95.0 %", text)
        self.assertIn("false doubt: 1.0 % of the clean time; by span alone 3.0 %", text)


class Machine(unittest.TestCase):
    def test_a_wrong_sensor_is_named_and_a_clean_machine_is_not_in_doubt(self):
        found = growth_sensors.simulate(0, 3002, 3600, lambda seconds: True)
        for name in ("bed +20 K", "air +80 K", "spindle +4 K"):
            effect, told = found["named"][NAMES.index(name)]
            self.assertTrue(told, name)
            self.assertLess(effect, 10, name)
        self.assertEqual(found["named falsely"], 0)


if __name__ == "__main__":
    unittest.main()

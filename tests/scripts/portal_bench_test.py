# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/portal/bench.hal: first the disease, then the cure; and every direction in which a machine can lean."""

import math
import os
import sys
import unittest

import numpy as np

import portal
from plumb_folder import TemporaryFolder
from support import portal_machine
from support.portal_machine import ARCSEC, UM

ERRORS = [f"portal.truth-{axis}-error" for axis in "xyz"]


def no_news(_):
    return True


class Path(unittest.TestCase):
    """The configuration as it is, its axes on their way."""

    def setUp(self):
        import plumb

        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        self.host.load(portal_machine.CONFIG)
        self.host.command("start")

    def expect_errors_below(self, limit):
        """In every period from now on, mm."""
        for name in ERRORS:
            self.host.expect(f"abs(error) < {limit}", error=name)

    def largest(self, seconds):
        """The largest of the tip errors, um."""
        largest = 0
        for _ in range(seconds):
            self.host.run(1)
            largest = max(largest, UM * math.hypot(*self.host.get(ERRORS)))
        return largest

    def test_without_correction_the_tip_misses_by_all_that_the_tilts_make(self):
        self.host.set("square.enable", False)
        self.assertGreater(self.largest(60), 40)
        self.assertEqual(self.host.get(["x-stage.applied-offset", "square.x-correction"]), [0, 0])

    def test_with_correction_no_period_on_the_way_has_an_error(self):
        self.host.run(5)  # it ramps in while the axes start
        self.expect_errors_below(1e-8)
        self.host.run(60)
        self.assertEqual(self.host.violations(), [])
        self.assertEqual(self.host.get(["square.fault-code", "square.limited-code", "x-stage.fault-code"]), [0, 0, 0])

    def test_correction_comes_and_goes_by_its_ramp(self):
        rate = self.host.get("square.max-rate")
        for axis in "xyz":
            self.host.set(f"{axis}-path.amplitude", 0)  # at rest, where the correction moves by its ramp alone
        self.host.set("w-path.amplitude", 0)
        self.host.run(20)
        self.host.expect(
            f"x_rate * x_rate + y_rate * y_rate + z_rate * z_rate <= {rate} * {rate} * 1.000001",
            **{axis: f"{axis}-stage.applied-offset" for axis in "xyz"},
        )
        for enabled in (False, True):
            self.host.set("square.enable", enabled)
            self.host.run(3)
            self.assertEqual(self.host.get("square.ramping"), False)
            self.assertEqual(abs(self.host.get("x-stage.applied-offset")) > 0.01, enabled)
        self.assertEqual(self.host.violations(), [])

    def test_tool_change_in_motion_is_ramped_and_then_exact(self):
        rate = self.host.get("square.max-rate")
        self.host.run(5)
        for axis in "xyz":  # beside the ramp, changes by motion: 160 mm/s by 50 urad, and W's share
            self.host.expect(f"abs(applied_rate) <= {rate} + 0.02", applied=f"{axis}-stage.applied-offset")
        for length, radial in ((90, 0), (400, 50), (0, 0)):
            for part, pin in (("portal", "tool-length"), ("square", "z-tool-offset")):
                self.host.set(f"{part}.{pin}", length)
                self.host.set(f"{part}.radial-offset", radial)
            self.host.run(0.01)
            self.assertTrue(self.host.get("square.ramping"))
            self.host.run(2)
            self.assertLess(UM * math.hypot(*self.host.get(ERRORS)), 1e-5)
        self.assertEqual(self.host.violations(), [])

    def test_drives_follow_no_worse_than_the_speed_of_the_correction_times_their_lag(self):
        gain = 30  # 1/s, of machine 0
        columns = {"correction": "square.{}-correction", "command": "{}-stage.drive-command", "place": "portal.{}-position"}
        columns.update({"wanted": "{}-motion.out", "ideal": "portal.truth-{}-nominal"})
        self.host.run(5)
        with TemporaryFolder() as folder:
            path = os.path.join(folder, "path.csv")
            names = {(None, "rail"): "portal.w-position"}
            names.update({(axis, column): name.format(axis) for axis in "xyz" for column, name in columns.items()})
            self.host.record(path, list(names.values()), 0.001)
            self.host.run(20)
            rows = np.loadtxt(path, delimiter=",", skiprows=1)[1:, 1:]
        recorded = dict(zip(names, rows.T))
        other = {"x": 0, "y": 25, "z": recorded[None, "rail"] - 250}  # rail and tool, in the tip's place
        for axis in "xyz":
            correction, command, place, wanted, ideal = (recorded[axis, column] for column in columns)
            alone = wanted - (ideal - other[axis])  # following error without correction
            more = np.max(np.abs(command - place - alone))
            bound = np.max(np.abs(np.diff(correction))) / 0.001 / gain
            self.assertGreater(bound, 1e-5)
            self.assertLess(more, bound + 1e-6)

    def test_a_machine_that_is_not_straight_keeps_what_no_tilt_describes(self):
        self.host.set("portal.seed", 7)
        self.host.set("portal.tilt-drift", 0)
        self.host.run(5)
        for axis in "xyz":
            self.host.expect(
                "abs(error - beyond) < 1e-6",  # a nanometre: the rest of second order
                error=f"portal.truth-{axis}-error",
                beyond=f"portal.truth-{axis}-beyond-tilts",
            )
        self.assertGreater(self.largest(30), 10)
        self.assertEqual(self.host.violations(), [])


class Cube(unittest.TestCase):
    """At rest in its points, on both machines."""

    def test_however_a_machine_leans_the_tip_is_where_it_should_be(self):
        # 100 arcsec each way, 400 mm of tool and 50 mm of radial offset; to 0.01 um, and the disease is a millimetre.
        for kind, number in (("column", 2 * (3**2 - 1)), ("portal", 4 * (3**4 - 1))):
            with self.subTest(kind):
                worst = portal_machine.every_direction(kind, 100 * ARCSEC, 2, no_news)
                print("\n" + "\n".join(portal.worst_lines(worst)), file=sys.stderr)
                self.assertEqual(worst.cases, number)
                self.assertGreater(worst.without, 700)
                self.assertGreaterEqual(worst.compensated, 0)
                self.assertLess(worst.compensated, 0.01)

    def test_tilts_take_out_what_they_make_and_tables_nearly_all(self):
        for kind in portal_machine.CHAINS:
            with self.subTest(kind):
                visits = portal_machine.simulate(kind, 5, 2, no_news).visits
                without, tilts, tables = (visits[run] for run in portal_machine.RUNS)
                self.assertGreater(without.lengths.max(), 80)
                self.assertGreater(without.left_by_tilts, 60)  # nothing is corrected: all of it
                self.assertLess(tilts.left_by_tilts, 0.001)
                self.assertGreater(tilts.lengths.max(), 10)
                self.assertLess(tilts.lengths.max(), 0.8 * without.lengths.max())
                self.assertLess(tables.lengths.max(), 0.1)

    def test_a_wrong_setting_is_seen(self):
        wrong = {
            "square.ea0w": -40e-6,
            "square.z-tool-offset": 0,
            "square.radial-offset": 50,
            "square.axis-direction": True,
            "square.to-bed": True,
            "square.z-tool-follows": False,
        }
        with portal_machine.new_host("portal") as host:
            machine = portal_machine.Machine(host, "portal")
            machine.tilt(portal_machine.draw_tilts("portal", 0))
            machine.mount(portal_machine.Tool(250, 25, 90))
            far = (1000, 1000, -1000, 600)
            self.assertLess(math.hypot(*machine.go(far)[:3]), 1e-6)
            for pin, value in wrong.items():
                right = host.get(pin)
                host.set(pin, value)
                self.assertGreater(math.hypot(*machine.settled()[:3]), 0.5, pin)
                host.set(pin, right)
                self.assertLess(math.hypot(*machine.settled()[:3]), 1e-6, pin)


if __name__ == "__main__":
    unittest.main()

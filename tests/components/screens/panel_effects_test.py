# SPDX-License-Identifier: GPL-2.0-or-later
"""Each setting of each function is written at a standing offset: what the panel announces is compared with the motion."""

import os
import re
import sys
import unittest

import plumb
from tree import BUILD, ROOT

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from long import long
from panel import effects, machine  # noqa: E402
from panel.declared import read_all  # noqa: E402
from panel.pin_lines import parse_pins  # noqa: E402
from panel.settings import Write  # noqa: E402

DECLARED, _damaged = read_all(os.path.join(BUILD, "share", "plumb"))
PROGRAM = os.path.join(BUILD, "bin", "plumb-squareness")
um = 1e-3
SEEN = 0.2 * um  # a smaller motion is none: stages count in 0.1 um
SETTLED = 2  # s


def pins(host):
    return parse_pins(host.halcmd("-s", "show", "pin").output)


def family(short):
    return re.sub(r"^[xyzuvw]-|-\d+$", "", short)


class Standing(unittest.TestCase):
    """A scene with its functions at standing offsets; `moving` has the pin of each axis that a component moves."""

    CHAIN = "w-X.b-W-Y-Z-C-t", "", PROGRAM

    def announced(self, instance, short, text):
        return effects.effect(self.machine, [Write(instance, short, text)], self.values, self.CHAIN)

    def look(self):
        found = pins(self.host)
        self.machine, self.values = machine.Machine(found, DECLARED), {pin.name: pin.value for pin in found}

    def tries(self, instance, short):
        """Other values within the declared range."""
        pin, declared = instance.pins[short], instance.declared.pin(short)
        now = self.values[pin.name]
        if pin.kind == "bit":
            return ["1" if not now else "0"]
        wide = {"rad": 3e-4, "mu": 20.0}.get(declared.get("unit"), 5.0)
        found = [now + 1, now - 1, 0] if pin.kind != "float" else [now * 1.5 + 0.001, now * 0.5, now * 0.01, -now * 0.5, now + wide, now - wide, 0.5, 0.0]
        return [repr(value) for value in dict.fromkeys(found) if value != now and declared.get("minimum", value) <= value <= declared.get("maximum", value)]

    def check(self, name, moving, skip=(), settled=SETTLED):
        """Returns the settings that moved an axis."""
        instance = self.machine.named(name)
        moved, announced = {}, set()
        for short in instance.settings():
            if short in skip or short == "heartbeat":  # interlock's: a stage without its beat holds
                continue
            self.assertFalse(self.host.get(instance.full("fault")), "before " + short)
            former = self.host.get(instance.full(short))
            for text in self.tries(instance, short):
                moves = self.announced(instance, short, text)
                before = [self.host.get(pin) for pin in moving.values()]
                self.host.command("setp %s %s" % (instance.full(short), text))
                self.host.run(settled)
                by = {axis: self.host.get(pin) - then for (axis, pin), then in zip(moving.items(), before)}
                refused = self.host.get(instance.full("fault"))
                if not refused and any(not move.exact or abs(move.by) > SEEN for move in moves):
                    announced.add(short)
                self.host.command("setp %s %r" % (instance.full(short), int(former) if isinstance(former, bool) else former))
                self.host.run(settled)
                with self.subTest(instance.full(short), text=text, former=former, by=by):
                    if not refused:
                        self.compare(moves, by)
                    for pin, then in zip(moving.values(), before):
                        self.assertAlmostEqual(self.host.get(pin), then, delta=SEEN, msg="after the former value")
                if max(map(abs, by.values())) > SEEN:
                    moved[short] = by
        for short in announced:  # without the axis and the number: not each sensor is in the law
            with self.subTest(instance.full(short)):
                self.assertIn(family(short), set(map(family, moved)), "a move was announced, and no value moves an axis")
        return moved

    def compare(self, moves, by):
        for axis, distance in by.items():
            exact = [move.by for move in moves if move.axis == axis and move.exact]
            bound = sum(abs(move.by) for move in moves if move.axis == axis and not move.exact)
            if bound:
                self.assertLess(abs(distance), bound + SEEN, axis)
            else:
                self.assertAlmostEqual(distance, sum(exact), delta=SEEN, msg=axis)


class Portal(Standing):
    """A growth that has been corrected, between two cycles, and a leaning portal."""

    @classmethod
    def setUpClass(cls):
        cls.host = plumb.Host(modules=[os.path.join(BUILD, "specimens")])
        cls.addClassCleanup(cls.host.close)
        for line in ("source %s/configs/mill/bench.hal" % ROOT, "source %s/tests/support/all_live.hal" % ROOT, "setp program.cycle-interval 2000",
                     "setp growth.hold-time 100000", "start", "sets z-homed 1"):
            cls.host.command(line)
        cls.host.run(2200)  # a part that is learned, and one that is corrected
        for line in ("x-path.amplitude 0", "y-path.amplitude 0", "tools.amplitude 0", "x-path.offset 20", "y-path.offset 30", "square.max-rate 5",
                     *("%s-stage.%s 5" % (axis, rate) for axis in "xy" for rate in ("ramp-rate", "max-rate")), "growth.max-rate 1", "z-offset-stage.max-rate 1"):
            cls.host.command("setp " + line)
        for axis in "zw":
            cls.host.command("net other-stage-%s square.%s-correction" % (axis, axis))
        cls.host.command("unlinkp growth.motion-type")
        cls.host.command("setp growth.motion-type 1")  # the tool is clear
        cls.host.run(10)

    def setUp(self):
        self.look()

    def test_squareness(self):
        moving = {axis: "square.%s-correction" % axis.lower() for axis in "XYZW"}
        moved = self.check("square", moving, skip=("reload",))
        wanted = {"enable", "ea0y", "axis-direction", "w-tool-follows", "radial-offset", "max-correction", "max-angle", "w-pivot", "to-bed"}
        self.assertEqual(wanted - set(moved), set())

    def test_a_stage_of_a_joint(self):
        moved = self.check("x-stage", {"x-stage": "x-stage.applied-offset"})
        self.assertEqual({"enable", "offset-1", "offset-2", "offset-3"} - set(moved), set())

    def test_a_stage_of_an_axis_that_is_armed(self):
        moved = self.check("z-offset-stage", {"z-offset-stage": "z-axis.offset"}, skip=("clear", "scale"))
        self.assertEqual(set(moved), {"enable", "offset-1", "offset-2", "offset-3", "max-offset"})
        scale = [Write(self.machine.named("z-offset-stage"), "scale", "0.001")]
        self.assertEqual(effects.effect(self.machine, scale, self.values, self.CHAIN), [])
        self.assertTrue(effects.needs_rest(self.machine, scale, self.values), "it must not change while a cycle runs")

    def test_growth(self):
        """What returns it is tried last: nothing follows the growth before the next cycle."""
        last = ("enable", "dry-run")
        self.assertGreater(self.host.get("growth.z-offset"), 20 * um)
        self.assertEqual(self.check("growth", {"Z": "growth.z-offset"}, skip=last), {})
        growth = self.machine.named("growth")
        for short in ("max-offset", "tolerance"):
            self.assertTrue(effects.waits_for_cycle(self.machine, [Write(growth, short, "0.001")], self.values))
        (move,) = self.announced(growth, "dry-run", "1")
        self.host.command("setp growth.dry-run 1")
        self.host.run(SETTLED)
        self.assertEqual(self.host.get("growth.z-offset"), 0)
        self.assertAlmostEqual(move.by, -self.values["growth.z-offset"], delta=SEEN)
        self.look()
        write = [Write(growth, "dry-run", "0")]
        self.assertEqual(effects.effect(self.machine, write, self.values, self.CHAIN), [])
        self.assertTrue(effects.waits_for_cycle(self.machine, write, self.values))
        self.host.command("setp growth.dry-run 0")
        self.host.run(SETTLED)
        self.assertEqual(self.host.get("growth.z-offset"), 0, "until the next cycle")


@long
class Trunnion(Standing):
    """squareness of a machine whose table turns about A and C."""

    CHAIN = "w-C-A-X-Y.b-Z-t", "AC", PROGRAM
    LINES = ("loadrt threads name1=servo-thread period1=1000000", "loadrt squareness names=square interlock=no chain=w-C-A-X-Y.b-Z-t rotary=AC", "setp square.max-speed 100000",
             "setp square.max-rotary-speed 100000", "setp square.max-rate 10", "setp square.x-position 120", "setp square.y-position -80", "setp square.z-position -60",
             "setp square.a-position 30", "setp square.c-position 70", "setp square.ec0y 0.0002", "setp square.ea0y -0.0001", "setp square.ez0a 0.02",
             "setp square.ex0c 0.03", "setp square.ea0c 0.0003", "setp square.a-z-pivot -40", "setp square.z-tool-offset 90", "setp square.all-homed 1",
             "setp square.enable 1", "addf square.update servo-thread", "start")

    def test_squareness_with_rotary_axes(self):
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in self.LINES:
            self.host.command(line)
        self.host.run(5)
        self.look()
        moved = self.check("square", {axis: "square.%s-correction" % axis.lower() for axis in "XYZ"}, skip=("reload",))
        self.assertEqual({"ez0a", "ex0c", "ea0c", "eb0a", "a-z-pivot"} - set(moved), set())


@long
class Warm(Standing):
    """axis_growth beside two warm sensors."""

    LINES = ("loadrt threads name1=servo-thread period1=1000000", "loadrt axis_growth names=warm interlock=no sensors=2", "setp warm.x-growth-0 0.001", "setp warm.y-growth-0 -0.002",
             "setp warm.z-growth-0 0.004", "setp warm.x-slope-1 1e-5", "setp warm.z-speed-growth 0.01", "setp warm.x-position 100", "setp warm.y-position 200",
             "setp warm.z-position -100", "setp warm.smoothing 0.1",
             "setp warm.turning-time 1", "setp warm.stopped-time 1", "setp warm.max-rate 5", "setp warm.max-speed 100000", "setp warm.all-homed 1",
             "setp warm.enable 1", "addf warm.update servo-thread", "start")

    def test_axis_growth(self):
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in self.LINES:
            self.host.command(line)
        self.host.run(2)
        for line in ("zero-set 1", "temperature-0 30", "temperature-1 23", "spindle-speed 4000"):  # it warms after the work zero
            self.host.command("setp warm." + line)
            self.host.run(2)
        self.host.run(40)
        self.look()
        moved = self.check("warm", {axis: "warm.%s-offset" % axis.lower() for axis in "XYZ"}, settled=30, skip=("zero-set",))
        self.assertEqual({"enable", "x-growth-0", "z-speed-growth", "max-offset"} - set(moved), set())


class Away(Standing):
    """chopping, stopped away from point R."""

    LINES = ("loadrt threads name1=servo-thread period1=1000000", "loadrt chopping names=chop interlock=no sections=4", "setp chop.upper 5", "setp chop.lower -25",
             "setp chop.position 10", "setp chop.feed 100", "setp chop.min-limit -100", "setp chop.max-limit 100", "setp chop.motion-enabled 1",
             "setp chop.homed 1", "setp chop.stop-kind 2", "addf chop.update servo-thread", "start")

    def test_chopping(self):
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in (*self.LINES, "setp chop.run 1"):
            self.host.command(line)
        self.host.run(2.1)
        self.host.command("setp chop.run 0")
        self.host.run(2)
        self.look()
        self.assertGreater(abs(self.values["chop.offset"]), 1)
        self.assertEqual(self.check("chop", {"chop": "chop.offset"}, skip=("run", "go-to-end", "motion-enabled", "homed")), {})
        (move,) = self.announced(self.machine.named("chop"), "go-to-end", "1")
        self.host.command("setp chop.go-to-end 1")
        self.host.run(5)
        self.assertAlmostEqual(self.host.get("chop.offset") - self.values["chop.offset"], move.by, delta=SEEN)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""What plumb-panel says of each function, and of the moves of a write, against the real components on the virtual-time host."""

import os
import re
import stat
import sys
import types
import unittest

import plumb
from tree import BUILD, ROOT, own_folder

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from panel import chains, effects, growth_state, hal_files, machine, misloaded, squareness_program, status, texts, waiting  # noqa: E402
from panel.declared import Declared, read_all  # noqa: E402
from panel.pin_lines import Pin, parse_pins  # noqa: E402
from panel.settings import Write  # noqa: E402

DECLARED, _damaged = read_all(os.path.join(BUILD, "share", "plumb"))
PROGRAM = os.path.join(BUILD, "bin", "plumb-squareness")
CHAIN = "w-Z.b-X-Y-C-t"
COMPUTED = CHAIN, "", PROGRAM
um = 1e-3

STAGES = [line for axis in "xyz" for line in (
    "net %s-correction square.%s-correction => %s-stage.offset-0" % (axis, axis, axis),
    "net on => %s-stage.motion-enabled" % axis, "net homed => %s-stage.homed" % axis,
    "setp %s-stage.min-limit -1000" % axis, "setp %s-stage.max-limit 1000" % axis, "setp %s-stage.joint-acceleration 1000" % axis,
    "setp %s-stage.offset-acceleration 500" % axis, "addf %s-stage.update servo-thread" % axis)]
STAGES += [line for number, axis in enumerate("xyz") for line in (
    "net %s-permit interlock.stage-permit-%d => %s-stage.permit" % (axis, number, axis),
    "net %s-state %s-stage.state => interlock.stage-state-%d" % (axis, axis, number))]


class Machinery(unittest.TestCase):
    """Functions on a host, with motion's pins by signals on and homed."""

    LINES, NUMBER = (), 0  # lines of HAL, and the number of stages

    def setUp(self):
        self.host = plumb.Host(modules=[os.path.join(BUILD, "specimens")])
        self.addCleanup(self.host.close)
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt interlock names=interlock stages=%d" % self.NUMBER,
                     "loadrt peers names=peers", "net program peers.service-state-0 => interlock.service-state-0", *self.LINES, "addf peers.update servo-thread",
                     "addf interlock.update servo-thread", "start"):
            self.host.command(line)
        self.host.run(0.05)
        self.look()

    def look(self):
        self.machine = machine.Machine(parse_pins(self.host.halcmd("-s", "show", "pin").output), DECLARED)

    def values(self, **more):
        found = {pin.name: pin.value for pin in parse_pins(self.host.halcmd("-s", "show", "pin").output)}
        return {**found, **{name.replace("__", ".").replace("_", "-"): value for name, value in more.items()}}

    def status(self, name):
        return status.of(self.machine.named(name), self.values())

    def assert_status(self, name, kind, text, remedy=None):
        its = self.status(name)
        self.assertEqual((its.kind, its.text), (kind, text))
        if remedy is not None:
            self.assertEqual(its.remedy, remedy)

    def beat(self, times):
        """Service 0 lives for half a second each."""
        for _ in range(times):
            self.do("setp peers.service-heartbeat-0 %d" % (not self.host.get("peers.service-heartbeat-0")), time=0.5)

    def do(self, *lines, time=0.05):
        for line in lines:
            self.host.command(line)
        self.host.run(time)


class Squareness(Machinery):
    NUMBER = 3
    LINES = (
        "loadrt squareness names=square chain=" + CHAIN, "loadrt joint_offset names=x-stage,y-stage,z-stage", "newsig on bit", "newsig homed bit",
        "net on interlock.motion-enabled", "net homed interlock.all-homed square.all-homed",
        "net square-permit interlock.function-permit-0 => square.permit", "net square-state square.state => interlock.function-state-0", "setp interlock.function-services-0 1",
        "net stages-ramping interlock.ramping => square.stages-ramping",
        "setp square.max-speed 100", "setp square.ec0y -0.00016", "setp square.ea0y 0.00012", "setp square.y-position 150",
        "setp square.x-position 40", "setp square.z-position -70", "setp square.z-tool-offset 90", "setp square.y-pivot 10",
        "addf square.update servo-thread", *STAGES)

    def ready(self):
        self.do("setp interlock.function-switch-0 1", "sets on 1", "sets homed 1", time=3)

    def test_it_corrects_only_while_the_axes_have_the_correction(self):
        self.ready()
        self.assert_status("square", "good", "Corrects the tilts that were measured.")
        self.assertGreater(abs(self.host.get("x-stage.applied-offset")), 10 * um)
        for lines, kind, text in (
                (("sets on 0",), "wait", "The machine is off."),
                (("sets on 1", "sets homed 0"), "wait", "The machine is not homed."),
                (("sets homed 1", "setp interlock.function-switch-0 0"), "off", "Switched off."),
                (("setp interlock.function-switch-0 1", "setp interlock.function-suspend-0 1"), "wait", "Suspended by the part program."),
                (("setp interlock.function-suspend-0 0",), "good", "Corrects the tilts that were measured."),
                (("setp x-stage.max-rate 0",), "bad", "The stage of an axis has a fault, and does not follow."),
                (("setp square.max-rate 0",), "bad", "A fault is active. " + DECLARED["squareness"].sentence("fault-code", 4) +
                 " square.max-rate: 0 mm/s is out of range: at least 0.000001 mm/s.")):
            with self.subTest(lines):
                self.do(*lines, time=3)
                self.assert_status("square", kind, text)

    def test_on_the_way_it_does_not_correct_yet(self):
        self.do("setp interlock.function-switch-0 1", "sets on 1", "sets homed 1", time=0.1)
        self.assert_status("square", "wait", "The axes move to their correction.")
        self.do("setp interlock.function-switch-0 0", time=3)
        self.do("setp x-stage.max-offset 0.001", "setp interlock.function-switch-0 1", time=3)
        self.assert_status("square", "warn", "A limit of a stage prevents the full offset of its axis.")
        self.do("setp interlock.function-stages-0 6")  # of another function
        self.assert_status("square", "good", "Corrects the tilts that were measured.")

    def test_each_stage_and_interlock_say_what_they_do(self):
        self.assert_status("x-stage", "wait", "The machine is off.")
        self.assert_status("interlock", "off", "No function is switched on.")
        self.do("setp interlock.function-switch-0 1")
        self.assert_status("interlock", "wait", "The machine is off.")
        self.do("sets on 1")
        self.assert_status("x-stage", "wait", "The machine is not homed.")
        self.do("sets homed 1", time=3)
        self.assert_status("x-stage", "good", "The joint has the offset of its sources.")
        self.assert_status("interlock", "good", "All functions that are switched on compensate.")
        self.assertFalse(self.host.get("interlock.attention"))
        for lines, stage, of_interlock in (
                (("setp x-stage.offset-acceleration 0",), ("bad", "A fault is active. A limit is not set or out of range: min-limit (\u22121000 mm) below max-limit (1000 mm) (both to 1e9), "
                         "joint-acceleration (1000 mm/s2) or offset-acceleration (0 mm/s2) (0.001 to 1e9); the last good set stays in force, and "
                         "without one no offset is applied."),
                 ("bad", "A stage has a fault, and its axis does not follow.")),
                (("setp x-stage.offset-acceleration 500", "setp x-stage.min-limit -0.01", "setp x-stage.max-limit 0.01"),
                 ("warn", "The joint does not have all of its offset."), ("warn", "A limit of a stage prevents the full offset of its axis.")),
                (("setp interlock.function-suspend-0 1",), None, ("wait", "Suspended by the part program.")),
                (("setp peers.service-ready-0 0",), None,
                 ("warn", "A function is switched on, and a service that it needs is missing.")),
                (("setp interlock.feed-services 256",), None,
                 ("bad", "A fault is active. " + DECLARED["interlock"].sentence("fault-code", 2).replace("feed-services", "feed-services (256)")))):
            with self.subTest(lines):
                self.do(*lines, time=3)
                if stage:
                    self.assert_status("x-stage", *stage)
                self.assert_status("interlock", *of_interlock)
                self.assertEqual(self.host.get("interlock.attention"), of_interlock[0] in ("bad", "warn"))

    def test_a_stage_without_a_source_has_nothing_to_do(self):
        self.ready()
        self.do("setp square.ec0y 0", "setp square.ea0y 0", time=3)
        self.assert_status("x-stage", "off", "No source asks for an offset.")

    def test_interlock_names_the_cause_of_a_wait(self):
        self.ready()
        self.do("setp square.max-rate 0.0005", "setp square.z-tool-offset 190", time=0.1)
        self.assert_status("interlock", "wait", "The next move waits until the axes have their offsets.")
        self.do(time=6)
        self.assert_status("interlock", "warn", "The machine waits. " + DECLARED["interlock"].sentence("waiting-code", 3))
        self.do("setp square.max-rate 1")
        self.assertEqual(self.status("interlock").kind, "good")

    def test_an_axis_offset_waits_for_its_cycle_and_for_the_end_of_probing(self):
        self.do("loadrt axis_offset names=z-axis interlock=no", "addf z-axis.update servo-thread", "setp z-axis.offset-0 0.03")
        self.look()
        self.assert_status("z-axis", "wait", "The machine is off.")
        self.do("setp z-axis.motion-enabled 1")
        self.assert_status("z-axis", "wait", "The machine is not homed.")
        self.do("setp z-axis.all-homed 1")
        self.assert_status("z-axis", "wait", "The axis lacks its offset.", "It gets it when the next cycle begins.")
        self.do("setp z-axis.motion-type 5", "setp z-axis.arm 1")
        self.assert_status("z-axis", "wait", "Waits for the end of a probing move.")
        self.do("setp z-axis.motion-type 0", time=0.01)
        self.assert_status("z-axis", "wait", "The axis moves to its offset.")
        self.do("setp z-axis.scale 1")
        self.assertEqual(self.status("z-axis").kind, "bad")
        self.assertTrue(self.host.get("z-axis.attention"))

    def test_without_an_angle_there_is_nothing_to_correct(self):
        self.ready()
        self.do("setp square.ec0y 0", "setp square.ea0y 0", time=3)
        self.assert_status("square", "off", "No angle is set: nothing is corrected.")

    def test_a_lost_service_is_no_switch(self):
        self.do("setp interlock.service-timeout-0 1")
        self.do("setp interlock.function-switch-0 0", "sets on 1", "sets homed 1")
        self.beat(4)
        self.do("setp interlock.function-switch-0 1")
        self.beat(8)
        self.assertEqual(self.status("square").kind, "good")
        self.do("setp interlock.program-running 1", time=3)
        self.assert_status("square", "warn", "Goes off when the program ends: plumb-retain (service 0) does not answer.")
        self.do("setp interlock.program-running 0")
        self.assert_status("square", "bad", "Off: plumb-retain (service 0) does not answer.", "Start LinuxCNC again.")
        self.beat(4)
        self.assert_status("square", "bad", "Off: a service was lost, and answers again.", "Turn the switch off and on.")
        self.assertEqual(self.status("square").button, "switch")
        self.do("setp interlock.function-switch-0 0")
        self.assert_status("square", "off", "Switched off.")

    def test_a_service_that_is_not_ready_is_named(self):
        self.do("setp peers.service-ready-0 0", "setp interlock.function-switch-0 1", "sets on 1", "sets homed 1")
        self.assert_status("square", "warn", "Off: plumb-retain (service 0) is not ready.")

    def test_a_number_from_outside_permits_nothing(self):
        self.ready()
        self.do("unlinkp square.permit")
        for number in (0, 1, 24, 4294967295, self.host.get("interlock.function-permit-0"), self.host.get("interlock.stage-permit-0")):
            self.do("setp square.permit %d" % number)
            self.assert_status("square", "bad", "Held: the function and interlock do not hear each other.")
            self.assertFalse(self.host.get("square.enabled"))
        self.assertTrue(self.host.get("square.attention"))

    def test_a_function_that_no_thread_runs_says_so(self):
        self.host.command("loadrt thermal_growth_test names=stands interlock=no")
        self.look()
        its = self.status("stands")
        self.assertEqual(its.kind, "bad")
        self.assertIn("no thread runs", its.text)

    def test_homing_waits_only_for_a_machine_that_is_not_homed(self):
        self.ready()
        self.assertTrue(self.host.get("interlock.homing-inhibit"))
        self.assertEqual(waiting.waiting(self.machine, self.values()), [])
        self.do("sets homed 0", time=0.02)
        self.assertIn("Homing waits", waiting.waiting(self.machine, self.values())[0])

    def applied(self):
        return [self.host.get(axis + "-stage.applied-offset") for axis in "xyz"]

    def test_the_moves_of_a_write_are_announced(self):
        self.ready()
        square = self.machine.named("square")
        switch, number = self.machine.owner_of("interlock.function-switch-0")
        self.do("setp square.max-rate 1", *("setp %s-stage.%s 1" % (axis, rate) for axis in "xyz" for rate in ("ramp-rate", "max-rate")))
        for writes in ([(square, "ec0y", "-0.0001")], [(square, "ea0y", "0.0003"), (square, "ec0x", "0.00005")], [(square, "eb0z", "0.0001")],
                       [(square, "ea0z", "-0.00007")], [(square, "ec0x", "0")], [(switch, number, "0")], [(switch, number, "1")]):
            with self.subTest(writes=[write[1:] for write in writes]):
                before = self.applied()
                moves = effects.effect(self.machine, [Write(*write) for write in writes], self.values(), COMPUTED)
                self.do(*("setp %s %s" % (owner.full(short), text) for owner, short, text in writes), time=3)
                moved = dict(zip("XYZ", (after - then for after, then in zip(self.applied(), before))))
                self.assertTrue(all(move.exact for move in moves), moves)
                for axis in "XYZ":
                    announced = sum(move.by for move in moves if move.axis == axis)
                    self.assertAlmostEqual(announced, moved[axis], delta=0.1 * um, msg=axis)
                self.assertTrue(any(abs(by) > 1 * um for by in moved.values()))

    def test_without_plumb_squareness_an_angle_has_a_bound(self):
        self.ready()
        moves = effects.effect(self.machine, [Write(self.machine.named("square"), "axis-direction", "1")], self.values())
        self.assertEqual([(move.axis, move.exact) for move in moves], [("X", False), ("Y", False), ("Z", False)])
        self.assertIn("at most", effects.in_words(moves))

    def test_a_function_that_the_panel_does_not_know_moves_within_its_declared_bounds(self):
        at_once = {"type": "float", "output": False, "effect": "at once"}
        declared = Declared({"name": "new_function", "role": "compensation", "moves": {"z-offset": {"bound": "max-offset"}},
                             "pins": {"gain": at_once, "max-offset": at_once}})
        shorts = {"enable": "bit", "gain": "float", "max-offset": "float", "z-offset": "float", "name": "float"}
        new = machine.Instance("new", declared, {short: Pin("new." + short, "new", kind, short == "z-offset", "", "") for short, kind in shorts.items()})
        known = types.SimpleNamespace(switched_by=lambda pin: None, named=lambda name: new, stages_of=lambda function: {})
        values = {"new.enable": True, "new.gain": 1.0, "new.max-offset": 0.5, "new.z-offset": 0.25, "new.name": 1.0}
        for text, is_on, moves in (("gain 2", True, [("Z", 0.75, False)]), ("max-offset 1", True, [("Z", 1.25, False)]), ("name 2", True, []),
                                   ("enable 0", True, [("Z", -0.25, True)]), ("gain 2", False, []), ("enable 1", False, [("Z", 0.75, False)])):
            with self.subTest(text, on=is_on):
                write = Write(new, *text.split())
                self.assertEqual(effects.effect(known, [write], {**values, "new.enable": is_on}), [effects.Move(*move) for move in moves])

    def test_an_angle_that_moves_nothing_here_changes_the_path_of_a_program(self):
        self.ready()
        self.do("setp square.y-position 10")  # the pivot
        square = self.machine.named("square")
        write = [Write(square, "ec0y", "-0.0003")]
        self.assertEqual([move for move in effects.effect(self.machine, write, self.values(), COMPUTED) if move.axis == "X"], [])
        self.assertTrue(effects.needs_rest(self.machine, write, self.values()))
        for short, text in (("ec0y", "-0.00016"), ("max-rate", "0.5")):  # the present value, and a rate
            self.assertFalse(effects.needs_rest(self.machine, [Write(square, short, text)], self.values()))
        self.do("setp interlock.function-switch-0 0", time=3)
        self.assertFalse(effects.needs_rest(self.machine, write, self.values()))

    def test_a_saved_lean_changes_that_lean(self):
        self.do("setp square.axis-direction 1", "setp square.eb0z 0.00007")
        square, values = self.machine.named("square"), self.values()
        given = squareness_program.document(CHAIN, square, values)
        self.assertEqual(given["reading"], "axis-direction")
        result = squareness_program.run(squareness_program.with_lean(given, "Y", "+X", "1um/m"), PROGRAM)
        (pin, value), = squareness_program.settings(result)
        self.assertEqual(pin, "ec0y")
        self.assertAlmostEqual(float(value), -0.000161, delta=1e-9)

    def test_what_cannot_correct_is_not_offered_and_says_why(self):
        given = squareness_program.document("w-X-Y.b-Z-C-t", self.machine.named("square"), {})
        lean = next(each for each in squareness_program.run(given, PROGRAM)["leans"] if each["name"] == "EC0Y")
        self.assertFalse(lean["can_correct"])
        self.assertIn("Square and indicator", squareness_program.why_not(lean))


class Refusals(unittest.TestCase):
    """plumb squareness, as the page of squareness asks it."""

    SQUARE = {"by": "square", "move": "Y", "plunger": "+X", "at": "0:300mm", "reads": "0:48um", "u": "1um"}

    def lean(self, angle):
        return {"leans": [{"lean": "Y+Z", "angle": angle}]}

    def square(self, *more, **changed):
        return {"correction": "off", "measurements": [{**self.SQUARE, **changed}, *more]}

    def diagonals(self, rising, falling):
        return {"correction": "off", "measurements": [squareness_program.diagonals("XY", rising, falling, "2")]}

    def points(self, name, text):
        path = os.path.join(own_folder(self), name)
        if text:
            with open(path, "w") as file:
                file.write(text)
        return {"correction": "off", "measurements": [squareness_program.points(path, "1")]}

    def test_each_is_a_sentence_of_the_panel_without_names_of_options(self):
        seen = []
        for given, words in (
                (self.lean("1.2.3mm/300mm"), "\"1.2.3mm"),
                (self.lean(".mm/300mm"), "\".mm/300mm\" is no number."),
                (self.lean("80deg"), "Y cannot lean to +Z by 1.396 rad: at most 0.1 rad. Check the unit."),
                ({"correction": "on", "in_force": [{"name": "EC0X", "angle": "0.09rad"}], "leans": [{"lean": "X+Y", "angle": "0.09rad"}]},
                 "EC0X would be 0.18 rad: at most 0.1 rad."),
                ({**self.square(), "leans": [{"lean": "Y+X", "angle": "0.0001rad"}]}, "EC0Y was entered, and follows from a measurement, too."),
                (self.square(at="5:5mm"), "The positions are all the same: move the axis between two readings."),
                (self.square(reads="0:4e9um"), "4e9um is longer than 1 km."),
                (self.square(u="0um"), "The uncertainty is smaller than anybody can measure. Enter the uncertainty of your indicator."),
                (self.square(reads="0:48000um"), "The readings rise too steeply. Check their units."),
                (self.square({**self.SQUARE, "reads": "0:480um"}), "Two measurements of Y and X contradict each other by 216 times"),
                (self.diagonals("0", "100"), "A diagonal must be longer than 0."),
                (self.diagonals("100", "200"), "Diagonals of 100 and 200 mm are not those of a rectangle. Measure again."),
                (self.points("none.csv", ""), "none.csv: there is no such file."),
                (self.points("heads.csv", "X,Y\n"), "heads.csv: there are no rows in it."),
                (self.points("odd.csv", "a,b\n1,2\n"), "odd.csv, line 1: \"a\" is no column of probed points.")):
            with self.subTest(words), self.assertRaises(squareness_program.Refused) as refused:
                squareness_program.run({"chain": "w-X-Y.b-Z-C-t", **given}, PROGRAM)
            text = str(refused.exception)
            self.assertIn(words, text)
            self.assertNotIn("[", text)
            seen.append(text)
        self.assertEqual(len(set(seen)), len(seen))


class Named(Machinery):
    """A setting that keeps a component from its work is named, with its value and its limit."""

    LINES = ("loadrt joint_offset names=x-stage interlock=no", "loadrt thermal_displacement names=growth interlock=no", "setp x-stage.min-limit 50", "setp x-stage.max-limit -20",
             "addf growth.update servo-thread", "addf x-stage.update servo-thread")

    def test_limits_that_contradict_each_other_have_their_values(self):
        self.do("setp x-stage.joint-acceleration 1000", "setp x-stage.offset-acceleration 500")
        self.assertRegex(self.status("x-stage").text, "min-limit \\(50 mm\\) below max-limit \\(\u221220 mm\\)")

    def test_a_value_out_of_its_range_has_its_limit(self):
        self.do("setp growth.max-rate 2")
        self.assertTrue(self.status("growth").text.endswith("growth.max-rate: 2 mm/s is out of range: at most 1 mm/s."), self.status("growth").text)


class ForOperators(unittest.TestCase):
    """No sentence that an operator reads has the name of a pin: a status and its remedy for all, and codes at this access."""

    def names(self, declared, text):
        text = re.sub(r"\{[a-z0-9-]+\}", "", text)  # a value stands there
        return [word for word in re.findall(r"[a-z]+(?:-[a-z0-9]+)+", text) if word in declared.pins]

    def test_no_status_and_no_remedy_names_a_pin(self):
        for declared in DECLARED.values():
            for its in declared.statuses.values():
                self.assertEqual(self.names(declared, its["sentence"] + its["remedy"]), [], declared.name)

    def test_codes_have_words_for_an_operator_and_names_for_an_integrator(self):
        count = 0
        for declared in DECLARED.values():
            instance = machine.Instance("its", declared, {short: Pin("its." + short, "its", each["type"], each["output"], 0, "")
                                                          for short, each in declared.pins.items()})
            for pin, sentences in declared.codes.items():
                for code, sentence in sentences.items():
                    for values in ({"its." + pin: code}, {"its." + pin: code, **{"its." + short: -1e9 for short in declared.pins if short != pin}}):
                        texts.PIN_NAMES[0] = True
                        self.assertEqual(set(self.names(declared, sentence)) - set(self.names(declared, instance.sentence(values, pin))), set())
                        texts.PIN_NAMES[0] = False
                        self.addCleanup(texts.PIN_NAMES.__setitem__, 0, True)
                        self.assertEqual(self.names(declared, instance.sentence(values, pin)), [])
                        count += bool(self.names(declared, sentence))
        self.assertGreater(count, 50)


class Misloaded(Machinery):
    LINES = ("loadrt axis_offset names=z-stage,y-stage interlock=no unit=mm,inch", "loadrt thermal_displacement names=growth,other interlock=yes,no", "setp growth.max-offset 0.01",
             "setp other.max-offset 0.01", "net growth-permit interlock.function-permit-0 => growth.permit")

    def test_a_default_in_mm_that_counts_as_inches_is_told(self):
        self.assertEqual([text for text in misloaded.warnings(self.machine, self.values()) if "inch" in text], [])
        texts.MACHINE_UNIT[0] = "in"
        self.addCleanup(texts.MACHINE_UNIT.__setitem__, 0, "mm")
        self.assertEqual([text for text in misloaded.warnings(self.machine, self.values()) if "inch" in text],
                         ["z-stage.max-offset is 0.15 in, 3.81 mm: its default in mm counts as inches. Load axis_offset with unit=inch, or change it."])

    def test_a_function_without_interlock_is_told(self):
        self.assertEqual([text.split(":")[0] for text in misloaded.warnings(self.machine, self.values())], ["other works without interlock"])


class Growth(Machinery):
    LINES = ("loadrt thermal_displacement names=growth", "net growth-permit interlock.function-permit-0 => growth.permit", "setp interlock.function-services-0 1",
             "net growth-state growth.state => interlock.function-state-0",
             "setp interlock.function-switch-0 1", "setp interlock.motion-enabled 1", "setp interlock.all-homed 1", "addf growth.update servo-thread")
    ROW = {"operation": 10, "tool": 1, "occurrence": 1, "feed": -2, "feed-override": 1, "time-constant": 0.03, "cycles": 1, "program-id": 7, "tool-set-id": 3}

    def restore(self):
        for name, value in self.ROW.items():
            self.host.command("setp growth.restore-%s %s" % (name, value))
        self.do("setp growth.restore 1")
        self.assertEqual(self.host.get("growth.rows"), 1)

    def test_kept_rows_wait_and_nobody_is_sent_to_learn(self):
        self.assert_status("growth", "warn", "There is no reference: nothing is corrected.", "Learn from a part on the cold machine.")
        self.restore()
        self.do("setp interlock.motion-enabled 0", "setp interlock.all-homed 0")  # in the morning
        self.assert_status("growth", "wait", "A reference is kept, and waits for its program. Contacts: 1.", "Start the program. Do not learn again.")
        self.assertEqual(self.status("growth").button, "")
        self.do("setp growth.program-id 8", "setp growth.tool-set-id 3", "setp growth.cycle-running 1")
        self.assertEqual(self.status("growth").kind, "warn")  # no reference is of this program
        self.assertIn(DECLARED["thermal_displacement"].sentence("detail-code", 21), self.status("growth").text)

    def test_its_program_brings_the_reference_into_force(self):
        self.restore()
        self.do("setp growth.program-id 7", "setp growth.tool-set-id 3", "setp growth.cycle-running 1")
        self.assert_status("growth", "wait", "Waits for the first contact: the growth is not known yet.")
        self.do("setp growth.dry-run 1")
        self.assert_status("growth", "off", "Measure only: the growth is measured, and Z is not moved.")
        self.do("setp interlock.motion-enabled 0")
        self.assert_status("growth", "wait", "The machine is off.")

    def test_retain_that_died_is_not_switched_off(self):
        self.do("setp interlock.service-timeout-0 1")
        self.do("setp interlock.function-switch-0 0")
        self.assert_status("growth", "off", "Switched off.", "Switch it on.")
        self.beat(4)
        self.do("setp interlock.function-switch-0 1")
        self.beat(2)
        self.assertIn("no reference", self.status("growth").text)
        self.do(time=3)
        self.assert_status("growth", "bad", "Off: plumb-retain (service 0) does not answer.", "Start LinuxCNC again.")

    def test_a_lost_load_goes_before_learning(self):
        self.do("setp growth.learn 1")
        self.assert_status("growth", "wait", "Learns from the next part.")
        self.do("setp growth.load-valid 0")
        self.assert_status("growth", "bad", "The load is lost: its sensor reports no valid value.")

    def test_a_contact_that_never_came_has_no_age(self):
        works = {"reference-valid": True, "enable": True, "growth-known": True, "offset-sigma": 0.0015, "rows": 5}

        def text(**pins):
            return growth_state.reference(self.machine.named("growth"), {**self.values(), **{"growth." + n.replace("_", "-"): v for n, v in {
                **works, **{name.replace("_", "-"): value for name, value in pins.items()}}.items()}})

        self.assertIn("No contact has counted since the start.", text(growth_known=False))
        self.assertNotIn("ago", text(growth_known=False))
        self.assertIn("No contact has counted for 90 s.", text(contact_age=90.0))
        self.assertNotIn("No contact", text())


class Chopping(Machinery):
    LINES = ("loadrt chopping names=chop interlock=no sections=4", "setp chop.upper 5", "setp chop.lower -25", "setp chop.position 10", "setp chop.feed 100",
             "setp chop.min-limit -100", "setp chop.max-limit 100", "setp chop.motion-enabled 1", "setp chop.homed 1", "net z chop.command chop.joint-feedback",
             "addf chop.update servo-thread")

    def test_held_at_rest_and_away_from_point_r_are_three_states(self):
        self.assert_status("chop", "off", "At rest at point R.")
        self.do("setp chop.run 1", time=2.1)
        self.assertEqual(self.status("chop").kind, "good")
        self.do("setp chop.feed-hold 1", time=0.01)
        self.assertRegex(self.status("chop").text, "^A hold is ordered")
        self.do(time=1)
        self.assertEqual(self.status("chop").kind, "warn")
        self.assertRegex(self.status("chop").text, "^Held: the axis stands away from point R.* Offset: .*mm")
        self.do("setp chop.feed-hold 0", "setp chop.stop-kind 2", "setp chop.run 0", time=2)
        self.assertFalse(self.host.get("chop.at-end"))
        offset = ("\u2212%.4f" % -self.host.get("chop.offset")).rstrip("0").rstrip(".")
        self.assert_status("chop", "warn", "The axis stands away from point R. Offset: %s mm." % offset, "Move the axis to point R.")
        self.assertEqual(self.status("chop").button, "to-end")
        self.do("setp chop.motion-enabled 0")
        self.assertIn("The machine is off, and the axis stands away from point R.", self.status("chop").text)
        self.do("setp chop.motion-enabled 1", "setp chop.go-to-end 1", time=0.05)
        self.assert_status("chop", "warn", "The axis is on its way to point R.")
        self.do(time=3)
        self.assert_status("chop", "off", "At rest at point R.")

    def test_where_machine_off_ended_a_stroke_is_not_point_r(self):
        self.do("setp chop.stage-released 0", "setp chop.run 1", time=2.1)
        self.do("setp chop.feed-hold 1", time=2)
        stood = self.host.get("chop.command")
        self.do("setp chop.motion-enabled 0", "setp chop.stage-released 1", "setp chop.run 0", "setp chop.feed-hold 0")
        self.do("setp chop.position %r" % stood, "setp chop.stage-released 0", "setp chop.motion-enabled 1")
        self.assertEqual(self.host.get("chop.offset"), 0, "no offset comes from it")
        away = ("\u2212%.4f" % (10 - stood)).rstrip("0").rstrip(".")
        self.assert_status("chop", "warn", "The axis stands away from where the stroke began. Distance: %s mm." % away,
                           "Jog it clear, or start strokes from here.")
        self.do("setp chop.position 10")
        self.assert_status("chop", "off", "At rest at point R.")

    def test_a_refused_stroke_is_bad(self):
        self.do("setp chop.homed 0", "setp chop.run 1")
        self.assert_status("chop", "bad", "A fault is active. " + DECLARED["chopping"].sentence("fault-code", 1))

    def test_the_speed_0_is_a_hold(self):
        self.do("setp chop.run 1", time=2)
        self.do("setp chop.override 0", time=1)
        self.assertIn("Held by the speed 0", self.status("chop").text)


class GrowthTest(Machinery):
    LINES = ("loadrt thermal_growth_test names=test interlock=no sensors=1", "addf test.update servo-thread")

    def test_a_program_that_died_is_no_pass(self):
        self.assert_status("test", "off", "No test runs.")
        self.do("setp test.running 1", "setp test.pass-running 1", time=1)
        self.assert_status("test", "good", "The test runs. " + DECLARED["thermal_growth_test"].sentence("state-code", 1))
        self.do("setp test.program-paused 1")
        self.assertIn("paused", self.status("test").text)
        self.do("setp test.program-paused 0", "setp test.program-running 0", time=0.5)
        self.assertEqual(self.status("test").kind, "good")  # it may be the end that comes now
        self.do(time=1)
        self.assert_status("test", "bad", "The program of the test has ended without its end: nothing is probed.",
                           "Start LinuxCNC again, then resume.ngc.")
        self.do("setp test.running 0")
        self.assertNotEqual(self.status("test").kind, "good")

    def test_a_test_is_resumed_only_when_its_log_was_given_back(self):
        self.do("setp test.running 1", "setp test.pass-running 1", "setp test.at-bore 1", time=1)
        self.do("setp test.running 0", time=0.1)
        self.assertEqual(self.status("test").kind, "warn")
        self.assertIn("refused before a restart", self.status("test").text)
        self.do("setp test.resumable 1")
        self.assert_status("test", "warn", "The test was interrupted.", "Start resume.ngc to go on.")


class CentreHeight(Machinery):
    LINES = ("loadrt centre_height names=centre interlock=no", "setp centre.tolerance 0.005", "setp centre.gauge-sigma 0.0005", "addf centre.update servo-thread")

    def test_only_on_centre_is_good(self):
        self.assert_status("centre", "off", "No tool is measured.")
        self.do("setp centre.start 1")
        self.assert_status("centre", "wait", "Waits for the next cut.")
        self.do("setp centre.abort 1")
        self.assert_status("centre", "warn", "The measurement is interrupted.", "Resume it, or begin again.")


class Programs(unittest.TestCase):
    """Whether a program runs, whatever is loaded beside LinuxCNC."""

    def test_task_is_asked_first_and_halui_may_be_left_out(self):
        for values, state in (
                ({"task.alive": True, "task.program": "running", "halui.program.is-running": False}, "running"),
                ({"task.alive": True, "task.program": "paused"}, "paused"),
                ({"task.alive": False, "halui.program.is-running": True}, "running"),
                ({"halui.program.is-paused": True, "halui.program.is-running": True}, "paused"),
                ({"linuxcnc-alive.program-running": True}, "running"),
                ({}, "")):
            with self.subTest(values):
                self.assertEqual(status.program_state(values), state)

    def test_channels_of_a_program_with_another_name_are_found(self):
        pins = [Pin("load." + part, "load", kind, True, value, "") for part, kind, value in (
            ("value", "float", 1.0), ("age", "float", 0.1), ("valid", "bit", True))]
        self.assertEqual([channel.name for channel in machine.Machine(pins, DECLARED).channels], ["load"])


    def test_a_program_with_another_name_is_known_by_its_pins(self):
        link = [("line." + part, "s32") for part in ("connected", "heartbeat", "round-trip", "error-count", "fault", "fault-code")]
        channel = [("line.load." + part, "float") for part in ("value", "age", "valid", "error-count", "fault", "fault-code")]
        for more, program in (((), "modbus_sensor"), ((("line.frame-count", "s32"),), "can_sensor")):
            pins = [Pin(name, "line", kind, True, 0.0, "") for name, kind in (*link, *channel, *more)]
            self.assertEqual([channel.module for channel in machine.Machine(pins, DECLARED).channels], [program])


class Chains(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.path = os.path.join(self.folder, "machine.ini")

    def write(self, text, path=None):
        with open(path or self.path, "w") as file:
            file.write(text)

    def read(self, path=None):
        with open(path or self.path) as file:
            return file.read()

    def test_the_chain_of_its_section_changes_and_nothing_else(self):
        text = "[OTHER]\nCHAIN = other\n\n[SQUARENESS]\n# CHAIN = old\nCHAIN = w-Z.b-X-Y-C-t\nX = 1\n"
        self.write(text)
        chains.write(self.path, "b-X-Y-Z-C-t")
        self.assertEqual(self.read(), text.replace("\nCHAIN = w-Z.b-X-Y-C-t", "\nCHAIN = b-X-Y-Z-C-t"))

    def test_the_file_keeps_owner_and_mode_and_is_never_half_written(self):
        self.write("[SQUARENESS]\nCHAIN = w-Z.b-X-Y-C-t\n")
        os.chmod(self.path, 0o640)
        if os.geteuid() == 0:
            os.chown(self.path, 1234, 2345)
        before = os.stat(self.path)
        with open(self.path) as reader:  # of before the change
            chains.write(self.path, "b-X-Y-Z-C-t")
            self.assertIn("w-Z.b", reader.read())
        after = os.stat(self.path)
        self.assertEqual(stat.S_IMODE(after.st_mode), 0o640)
        self.assertEqual((after.st_uid, after.st_gid), (before.st_uid, before.st_gid))
        self.assertNotEqual(after.st_ino, before.st_ino)
        self.assertEqual(os.listdir(self.folder), ["machine.ini"])

    def test_a_file_without_a_chain_stays_and_is_named(self):
        self.write("[SQUARENESS]\nX = 1\n")
        with self.assertRaises(OSError) as error:
            chains.write(self.path, "b-X-Y-Z-C-t")
        self.assertEqual(error.exception.filename, self.path)
        self.assertEqual(self.read(), "[SQUARENESS]\nX = 1\n")

    def test_a_link_out_of_the_folder_is_not_followed(self):
        other = os.path.join(own_folder(self), "other.ini")
        self.write("[SQUARENESS]\nCHAIN = w-Z.b-X-Y-C-t\n", other)
        os.symlink(other, self.path)
        with self.assertRaisesRegex(OSError, "it is a link, which is not followed"):
            chains.place(hal_files.Ini(self.path))

    def test_a_link_stays_a_link_and_an_included_file_is_found(self):
        included, link = os.path.join(self.folder, "own.inc"), os.path.join(self.folder, "square.inc")
        self.write("[SQUARENESS]\nCHAIN = w-Z.b-X-Y-C-t\n", included)
        os.symlink(included, link)
        self.write("[EMC]\nMACHINE = m\n#INCLUDE square.inc\n")
        ini = hal_files.Ini(self.path)
        chains.write(chains.place(ini), "b-X-Y-Z-C-t")
        self.assertTrue(os.path.islink(link))
        self.assertEqual(chains.in_file(ini), "b-X-Y-Z-C-t")
        self.assertEqual(ini.get("SQUARENESS", "CHAIN"), "w-Z.b-X-Y-C-t", "what LinuxCNC was started with")


if __name__ == "__main__":
    unittest.main()

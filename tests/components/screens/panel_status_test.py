# SPDX-License-Identifier: GPL-2.0-or-later
"""What plumb-panel says of each function, and of the moves of a write, against the real components on the virtual-time host."""

import os
import stat
import sys
import unittest

import plumb
from tree import BUILD, ROOT, own_folder

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from panel import centre_height_state, chains, chopping_state, effects, growth_state, growth_test_state, hal_files  # noqa: E402
from panel import machine, plain_state, squareness_program, squareness_state, status, waiting  # noqa: E402
from panel.declared import read_all  # noqa: E402
from panel.pin_lines import Pin, parse_pins  # noqa: E402
from panel.settings import Write  # noqa: E402

DECLARED, _damaged = read_all(os.path.join(BUILD, "share", "plumb"))
PROGRAM = os.path.join(BUILD, "bin", "plumb-squareness")
CHAIN = "w-Z.b-X-Y-C-t"
um = 1e-3

STAGES = [line for axis in "xyz" for line in (
    "net %s-correction square.%s-correction => %s-stage.offset-0" % (axis, axis, axis),
    "net heartbeat => %s-stage.heartbeat" % axis,
    "net on => %s-stage.motion-enabled" % axis, "net homed => %s-stage.homed" % axis,
    "setp %s-stage.min-limit -1000" % axis, "setp %s-stage.max-limit 1000" % axis, "setp %s-stage.joint-acceleration 1000" % axis,
    "setp %s-stage.offset-acceleration 500" % axis, "addf %s-stage.update servo-thread" % axis)]


class Machinery(unittest.TestCase):
    """Functions on a host, with motion's pins by signals on and homed."""

    LINES = ()

    def setUp(self):
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt interlock names=interlock", *self.LINES,
                     "addf interlock.update servo-thread", "start"):
            self.host.command(line)
        self.host.run(0.05)
        self.look()

    def look(self):
        self.machine = machine.Machine(parse_pins(self.host.halcmd("-s", "show", "pin").output), DECLARED)

    def values(self, **more):
        found = {pin.name: pin.value for pin in parse_pins(self.host.halcmd("-s", "show", "pin").output)}
        return {**found, **{name.replace("__", ".").replace("_", "-"): value for name, value in more.items()}}

    def beat(self, times):
        """Service 0 lives for half a second each."""
        for _ in range(times):
            self.do("setp interlock.service-heartbeat-0 %d" % (not self.host.get("interlock.service-heartbeat-0")), time=0.5)

    def do(self, *lines, time=0.05):
        for line in lines:
            self.host.command(line)
        self.host.run(time)


class Squareness(Machinery):
    LINES = (
        "loadrt squareness names=square chain=" + CHAIN, "loadrt joint_offset names=x-stage,y-stage,z-stage", "newsig on bit", "newsig homed bit",
        "net on interlock.motion-enabled", "net homed interlock.all-homed square.all-homed", "net heartbeat interlock.heartbeat",
        "net square-on interlock.function-enable-0 => square.enable", "setp interlock.function-services-0 1",
        "setp square.max-speed 100", "setp square.ec0y -0.00016", "setp square.ea0y 0.00012", "setp square.y-position 150",
        "setp square.x-position 40", "setp square.z-position -70", "setp square.z-tool-offset 90", "setp square.y-pivot 10",
        "addf square.update servo-thread", *STAGES)

    def status(self, **more):
        enabled = {"motion.motion-enabled": bool(self.host.get("on")), "motion.is-all-homed": bool(self.host.get("homed"))}
        return squareness_state.status(self.machine, self.machine.named("square"), {**self.values(**more), **enabled})

    def ready(self):
        self.do("setp interlock.function-switch-0 1", "sets on 1", "sets homed 1", time=3)

    def test_it_corrects_only_while_the_axes_have_the_correction(self):
        self.ready()
        self.assertEqual(self.status(), ("good", "Corrects the tilts that were measured."))
        self.assertGreater(abs(self.host.get("x-stage.applied-offset")), 10 * um)
        for lines, kind, words in (
                (("sets on 0",), "wait", "The machine is off. Nothing is corrected."),
                (("sets on 1", "sets homed 0"), "wait", "The machine is not homed. Nothing is corrected."),
                (("sets homed 1", "setp interlock.function-switch-0 0"), "off", "Switched off."),
                (("setp interlock.function-switch-0 1", "setp interlock.function-suspend-0 1"), "wait", "Suspended by the part program."),
                (("setp interlock.function-suspend-0 0",), "good", "Corrects"),
                (("setp square.max-rate 0",), "bad", DECLARED["squareness"].sentence("fault-code", 4))):
            with self.subTest(lines):
                self.do(*lines, time=3)
                its = self.status()
                self.assertEqual(its.kind, kind)
                self.assertIn(words, its.text)

    def test_on_the_way_and_short_of_it_it_does_not_correct_yet(self):
        self.do("setp interlock.function-switch-0 1", "sets on 1", "sets homed 1", time=0.1)
        self.assertEqual(self.status(), ("wait", "The axes move to their correction."))
        self.do("setp interlock.function-switch-0 0", time=3)
        self.do("setp x-stage.max-offset 0.001", "setp interlock.function-switch-0 1", time=3)
        self.assertEqual(self.status().kind, "warn")
        self.assertIn("stage", self.status().text)

    def test_a_dead_stage_is_named(self):
        self.ready()
        self.do("setp x-stage.max-rate 0", time=1)
        self.assertEqual(self.status().kind, "bad")
        self.assertIn("x-stage: ", self.status().text)

    def test_a_lost_service_is_no_switch(self):
        self.do("setp interlock.service-timeout-0 1")
        self.do("setp interlock.function-switch-0 0", "sets on 1", "sets homed 1")
        self.beat(4)
        self.do("setp interlock.function-switch-0 1")
        self.beat(8)
        self.assertEqual(self.status().kind, "good")
        self.do(time=3)
        self.assertEqual(self.status(), ("bad", "Off: no answer from service 0. Start LinuxCNC again."))
        self.beat(4)
        self.assertIn("turn the switch off and on", self.status().text)

    def test_a_service_that_is_not_ready_is_named(self):
        self.do("setp interlock.service-ready-0 0", "setp interlock.function-switch-0 1", "sets on 1", "sets homed 1")
        self.assertEqual(self.status(), ("warn", "Off: service 0 is not ready."))

    def test_homing_waits_only_for_a_machine_that_is_not_homed(self):
        self.do("setp interlock.stage-in-force-0 1")
        self.ready()
        self.assertTrue(self.host.get("interlock.homing-inhibit"))
        self.assertEqual(waiting.waiting(self.machine, self.values()), [])
        self.do("sets homed 0")
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
                moves = effects.effect(self.machine, [Write(*write) for write in writes], self.values(), (CHAIN, PROGRAM))
                self.do(*("setp %s %s" % (owner.full(short), text) for owner, short, text in writes), time=3)
                moved = dict(zip("XYZ", (after - then for after, then in zip(self.applied(), before))))
                self.assertTrue(all(move.exact for move in moves), moves)
                for axis in "XYZ":
                    announced = sum(move.by for move in moves if move.axis == axis)
                    self.assertAlmostEqual(announced, moved[axis], delta=0.1 * um, msg=axis)
                self.assertTrue(any(abs(by) > 1 * um for by in moved.values()))

    def test_other_settings_have_a_bound_and_none_that_moves_nothing(self):
        self.ready()
        square = self.machine.named("square")
        moves = effects.effect(self.machine, [Write(square, "axis-direction", "1")], self.values(), (CHAIN, PROGRAM))
        self.assertEqual([(move.axis, move.exact) for move in moves], [("X", False), ("Y", False), ("Z", False)])
        self.assertIn("at most", effects.in_words(moves))
        for short, text in (("max-rate", "0.5"), ("ec0y", "-0.00016")):
            self.assertEqual(effects.effect(self.machine, [Write(square, short, text)], self.values(), (CHAIN, PROGRAM)), [])

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


class Growth(Machinery):
    LINES = ("loadrt thermal_displacement names=growth", "net growth-on interlock.function-enable-0 => growth.enable", "setp interlock.function-services-0 1",
             "setp interlock.function-switch-0 1", "addf growth.update servo-thread")
    WORKS = {"reference-valid": True, "enable": True, "growth-known": True, "offset-sigma": 0.0015, "rows": 5}

    def status(self, **pins):
        own = {"growth." + name.replace("_", "-"): value for name, value in {**self.WORKS, **{n.replace("_", "-"): v for n, v in pins.items()}}.items()}
        return growth_state.status(self.machine, self.machine.named("growth"), {**self.values(), "motion.motion-enabled": True, **own})

    def test_kept_rows_wait_and_nobody_is_sent_to_learn(self):
        its = self.status(reference_valid=False)
        self.assertEqual(its.kind, "wait")
        self.assertIn("a reference of 5 contacts is kept. Do not learn again", its.text)
        self.assertIn("Learning replaces it", self.status(reference_valid=False, cycle_running=True).text)
        self.assertIn("Learn from a part", self.status(reference_valid=False, rows=0).text)

    def test_retain_that_died_is_not_switched_off(self):
        self.do("setp interlock.service-timeout-0 1")
        self.do("setp interlock.function-switch-0 0")
        self.beat(4)
        self.do("setp interlock.function-switch-0 1")
        self.beat(2)
        self.assertEqual(self.status().kind, "good")
        self.do(time=3)
        self.assertEqual(self.status(enable=False), ("bad", "Off: no answer from service 0. Start LinuxCNC again."))

    def test_a_contact_that_never_came_has_no_age(self):
        def text(**pins):
            return growth_state.reference(self.machine.named("growth"), {**self.values(), **{"growth." + n.replace("_", "-"): v for n, v in {
                **self.WORKS, **{name.replace("_", "-"): value for name, value in pins.items()}}.items()}})

        self.assertIn("No contact has counted since the start.", text(growth_known=False))
        self.assertNotIn("ago", text(growth_known=False))
        self.assertIn("No contact has counted for 90 s.", text(contact_age=90.0))
        self.assertNotIn("No contact", text())

    def test_a_lost_load_says_what_the_offset_does(self):
        codes = DECLARED["thermal_displacement"].codes["doubt-code"]
        self.assertEqual(self.status(load_valid=False, doubt=True, doubt_code=1), ("bad", codes[1]))
        self.assertEqual(self.status(load_valid=False, doubt=True, doubt_code=3), ("bad", "The load is lost: its sensor reports no valid value. " + codes[3]))
        self.assertEqual(self.status(load_valid=False, doubt=True, doubt_code=4), ("bad", "The load is lost: its sensor reports no valid value."))

    def test_off_or_not_homed_z_is_not_corrected(self):
        for pins, words in (({"motion.motion-enabled": False}, "The machine is off."), ({"motion.is-all-homed": False}, "not homed")):
            own = {"growth." + name: value for name, value in self.WORKS.items()}
            its = growth_state.status(self.machine, self.machine.named("growth"), {**self.values(), **own, **pins})
            self.assertEqual(its.kind, "wait")
            self.assertIn(words, its.text)


class Chopping(Machinery):
    LINES = ("loadrt chopping names=chop", "setp chop.upper 5", "setp chop.lower -25", "setp chop.position 10", "setp chop.feed 100",
             "setp chop.min-limit -100", "setp chop.max-limit 100", "setp chop.motion-enabled 1", "setp chop.homed 1", "addf chop.update servo-thread")

    def status(self):
        return chopping_state.status(self.machine, self.machine.named("chop"), self.values())

    def test_held_at_rest_and_away_from_point_r_are_three_states(self):
        self.assertEqual(self.status(), ("off", "At rest at point R."))
        self.do("setp chop.run 1", time=2.1)
        self.assertEqual(self.status().kind, "good")
        self.do("setp chop.feed-hold 1", time=0.01)
        self.assertEqual(self.status().kind, "warn")
        self.assertRegex(self.status().text, "^A hold is ordered")
        self.do(time=1)
        self.assertEqual(self.status().kind, "warn")
        self.assertRegex(self.status().text, r"^Held: the axis stands .*mm from point R")
        self.do("setp chop.feed-hold 0", "setp chop.stop-kind 2", "setp chop.run 0", time=2)
        self.assertFalse(self.host.get("chop.at-end"))
        its = self.status()
        self.assertEqual(its.kind, "warn")
        self.assertIn("Stands %s mm from point R." % ("\u2212%.4f" % -self.host.get("chop.offset")).rstrip("0").rstrip("."), its.text)
        self.do("setp chop.motion-enabled 0")
        self.assertIn("The machine is off. Stands", self.status().text)
        self.do("setp chop.motion-enabled 1", "setp chop.go-to-end 1", time=3)
        self.assertEqual(self.status(), ("off", "At rest at point R."))

    def test_a_refused_stroke_is_bad_and_where_the_axis_is(self):
        self.do("setp chop.homed 0", "setp chop.run 1")
        self.assertEqual(self.status(), ("bad", DECLARED["chopping"].sentence("fault-code", 1) + " At rest at point R. The machine is not homed."))

    def test_the_speed_0_is_a_hold(self):
        self.do("setp chop.run 1", time=2)
        self.do("setp chop.override 0", time=1)
        self.assertIn("Held by the speed 0", self.status().text)


class GrowthTest(Machinery):
    LINES = ("loadrt thermal_growth_test names=test", "setp test.sensors 1", "addf test.update servo-thread")

    def status(self, **more):
        return growth_test_state.status(self.machine, self.machine.named("test"), {**self.values(), **more})

    def test_a_program_that_died_is_no_pass(self):
        self.do("setp test.running 1", "setp test.pass-running 1", time=1)
        for source in ({"task.alive": True, "task.program": "running"}, {"halui.program.is-running": True}, {}):
            self.assertEqual(self.status(**source), ("good", DECLARED["thermal_growth_test"].sentence("state-code", 1)))
        for source in ({"task.alive": True, "task.program": "idle"}, {"linuxcnc-alive.program-running": False}, {"halui.program.is-idle": True}):
            with self.subTest(source):
                self.assertEqual(self.status(**source).kind, "bad")
                self.assertIn("The program of the test has ended without its end", self.status(**source).text)
        self.assertIn("paused", self.status(**{"task.alive": True, "task.program": "paused"}).text)

    def test_a_test_is_resumed_only_when_its_log_was_given_back(self):
        self.do("setp test.running 1", "setp test.pass-running 1", "setp test.at-bore 1", time=1)
        self.do("setp test.running 0", time=0.1)
        its = self.status(**{"test.state": True, "test.state-code": 5})
        self.assertEqual(its.kind, "warn")
        self.assertIn("after LinuxCNC has started again", its.text)
        self.assertNotIn("good", its)

    def test_the_end_of_time_is_no_success(self):
        self.assertEqual(self.status(**{"test.stop-reason": True, "test.stop-reason-code": 1}).kind, "good")
        self.assertEqual(self.status(**{"test.stop-reason": True, "test.stop-reason-code": 2}).kind, "warn")


class CentreHeight(Machinery):
    LINES = ("loadrt centre_height names=centre", "addf centre.update servo-thread")

    def test_only_on_centre_is_good(self):
        centre = self.machine.named("centre")
        for pins, kind, words in (
                ({"state-code": 3, "height": 0.098, "sigma": 0.002}, "warn", "The tool is +98.0 \u00b5m off centre"),
                ({"state-code": 3, "on-centre": True}, "good", "The tool is on centre."),
                ({"state-code": 4}, "bad", "The cuts give no height"),
                ({"state-code": 5}, "warn", "The procedure is interrupted"),
                ({"state-code": 2}, "wait", "Measure the diameter"),
                ({}, "off", "Begin with one")):
            with self.subTest(**pins):
                its = centre_height_state.status(self.machine, centre, {**self.values(), **{"centre." + name: value for name, value in pins.items()}})
                self.assertEqual(its.kind, kind)
                self.assertIn(words, its.text)


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


class Plain(unittest.TestCase):
    """A function without a page of its own, such as axis_growth, has a verdict from what all functions have."""

    def status(self, **given):
        declared = DECLARED["axis_growth"]
        pins = [Pin("warm." + short, "axis_growth", pin["type"], pin["output"], 0, "") for short, pin in declared.pins.items()]
        values = {**{pin.name: 0.0 for pin in pins}, "warm.enable": True, **{"warm." + short.replace("_", "-"): value for short, value in given.items()}}
        its = machine.Machine(pins, DECLARED)
        self.assertEqual([each.name for each in its.functions()], ["warm"])
        return plain_state.status(its, its.functions()[0], values)

    def test_it_shows_offset_doubt_fault_and_switch(self):
        self.assertEqual(self.status(z_offset=-0.012)[0], "good")
        self.assertIn("Z \u221212", self.status(z_offset=-0.012)[1].replace("-12", "\u221212"))
        codes = DECLARED["axis_growth"].codes
        doubt, fault = next(iter(codes["doubt-code"])), next(iter(codes["fault-code"]))
        self.assertEqual(self.status(doubt=True, doubt_code=doubt), ("warn", codes["doubt-code"][doubt]))
        self.assertEqual(self.status(fault=True, fault_code=fault), ("bad", codes["fault-code"][fault]))
        self.assertEqual(self.status(enable=False)[0], "off")
        self.assertEqual(self.status(x_offset=float("nan"))[0], "bad")


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

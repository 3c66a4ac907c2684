# SPDX-License-Identifier: GPL-2.0-or-later
"""What plumb-panel does without a screen: it finds functions, changes settings, and judges, on the virtual-time host."""

import math
import os
import random
import re
import resource
import sys
import time
import unittest
import unittest.mock

import panel_texts
import plumb
from tree import BUILD, ROOT, own_folder

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from commissioning.records import Records  # noqa: E402
from panel import access, changes, files, growth_test_state, hal_files, machine, references, settings, status, texts, waiting  # noqa: E402
from panel.declared import read_all  # noqa: E402
from panel.pin_lines import Pin, parse_pins  # noqa: E402

PATIENCE = 60  # s of real time, for an event that takes a moment
SIGNS = 0, 4, 5  # of life: plumb-retain, LinuxCNC's task and io as services of interlock
DECLARED, DAMAGED = read_all(os.path.join(BUILD, "share", "plumb"))


class HostHal:
    """As panel.hal_access.Hal, of a host."""

    def __init__(self, host):
        self.host = host

    def pins(self):
        return parse_pins(self.host.halcmd("-s", "show", "pin").output)

    def values(self):
        return {pin.name: pin.value for pin in self.pins()}

    def get(self, name):
        try:
            return self.host.get(name)
        except plumb.Refused:
            raise KeyError(name) from None

    def set(self, name, text):
        done = self.host.halcmd("setp", name, text)
        if done.status:
            raise ValueError(done.output)


class WithHost(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.start()

    def start(self):
        self.host = plumb.Host(modules=[os.path.join(BUILD, "specimens")])
        self.addCleanup(self.host.close)
        for line in (
            "loadrt threads name1=servo-thread period1=1000000",
            "loadrt thermal_displacement names=growth",
            "loadrt interlock count=1",
            "setp interlock.0.function-stages-0 0",
            "loadrt squareness names=square interlock=no chain=w-X-Y.b-Z-C-t",
            "net growth-permit interlock.0.function-permit-0 => growth.permit",
            "net growth-state growth.state => interlock.0.function-state-0",
            "net load growth.load",
            "addf growth.update servo-thread",
            "addf square.update servo-thread",
            "addf interlock.0.update servo-thread",
            "start",
        ):
            self.host.command(line)
        self.host.run(0.01)
        self.hal = HostHal(self.host)
        self.machine = machine.Machine(self.hal.pins(), DECLARED)
        self.growth = self.machine.named("growth")

    def screen(self, who="anna"):
        return settings.Settings(self.hal, self.folder, who, "mill", settle=lambda: self.host.run(0.05))


class RunningHal(HostHal):
    """Time passes at each look."""

    def get(self, name):
        self.host.run(0.002)
        return super().get(name)


class References(WithHost):
    """The reference of thermal_displacement, read and given back by a screen."""

    ROWS = [{"operation": 10, "tool": tool, "occurrence": 1, "feed": -2.0, "feed-override": 1.0, "time-constant": 0.03, "cycles": 1, "program-id": 7,
             "tool-set-id": 3, "coordinate": 0.1 * tool} for tool in (1, 2, 3)]

    def setUp(self):
        super().setUp()
        self.hal = RunningHal(self.host)

    def whole(self, rows):
        fields = [name for name in self.growth.pins if name.startswith("row-") and name != "row-shown"]
        return [{name[4:]: row.get(name[4:], 0) for name in fields} for row in rows]

    def test_what_was_given_is_read_and_a_former_one_takes_the_place_of_a_new_one(self):
        references.give(self.hal, self.growth, self.whole(self.ROWS))
        former = references.read(self.hal, self.growth)
        self.assertEqual([[row[name] for name in ("tool", "coordinate", "feed")] for row in former],
                         [[row[name] for name in ("tool", "coordinate", "feed")] for row in self.ROWS])
        references.give(self.hal, self.growth, self.whole([{**self.ROWS[0], "coordinate": 5.0}]))
        self.assertEqual(self.host.get("growth.rows"), 1)
        self.assertFalse(references.same(references.read(self.hal, self.growth), former))
        references.give(self.hal, self.growth, former)
        self.assertTrue(references.same(references.read(self.hal, self.growth), former))
        self.assertEqual(self.host.get(["growth.row", "growth.restore", "growth.forget"]), [-1, False, False], "as plumb-retain leaves them")

    def test_a_record_that_is_refused_is_said(self):
        with self.assertRaisesRegex(settings.Refused, "growth refuses the former reference"):
            references.give(self.hal, self.growth, self.whole([{**self.ROWS[0], "feed": 2.0}]))

    def test_a_component_that_no_thread_runs_is_said(self):
        references.give(self.hal, self.growth, self.whole(self.ROWS))
        self.host.command("stop")
        with unittest.mock.patch.object(references, "PATIENCE", 0.2), self.assertRaisesRegex(settings.Refused, "no thread runs it"):
            references.read(self.hal, self.growth)

    def test_a_learning_and_its_former_reference_are_one_deed(self):
        screen = self.screen()
        screen.note_all([("growth reference", "[]", ""), (settings.MDI, "M65 P2", "M64 P2")], "button")
        for change in screen.log.all():
            self.assertEqual(screen.undoing(change, self.machine), ([], "", ["M65 P2"], [(self.growth, "[]")]))
        screen.note_all([("growth reference", "[{}]", "[]")], "undo")
        with self.assertRaisesRegex(settings.Conflict, "was changed again since"):
            screen.undoing(screen.log.all()[0], self.machine)


class Discovery(WithHost):
    def test_declarations_are_whole(self):
        self.assertEqual(DAMAGED, [])
        self.assertGreaterEqual(len([each for each in DECLARED.values() if each.role == "compensation"]), 6)

    def test_instances_are_found_by_their_owners_and_pins(self):
        found = {each.name: each.module for each in self.machine.instances}
        self.assertEqual(found, {"growth": "thermal_displacement", "square": "squareness", "interlock.0": "interlock"})
        self.assertEqual([each.is_function for each in self.machine.instances], [True, True, False], "functions come first")

    def test_inputs_with_a_signal_and_pins_of_records_are_no_settings(self):
        chosen = self.growth.settings()
        self.assertIn("window", chosen)
        for short in ("load", "permit", "restore-tool", "row", "kept", "z-offset"):
            self.assertNotIn(short, chosen)
        self.assertIn("load", self.growth.inputs())

    def test_the_switch_of_a_function_is_that_of_the_interlock(self):
        self.assertEqual(self.machine.switch_of(self.growth), "interlock.0.function-switch-0")
        self.assertEqual(self.machine.switch_of(self.machine.named("square")), "square.enable")

    def test_where_a_signal_drives_the_switch_interlock_takes_off_by_its_own_pin(self):
        self.host.command("net door-closed interlock.0.function-switch-0")
        self.host.command("sets door-closed 1")
        found = machine.Machine(self.hal.pins(), DECLARED)
        growth = found.named("growth")
        pin = found.switch_of(growth)
        self.assertEqual(pin, "interlock.0.function-off-0")
        off = settings.Write(*found.owner_of(pin), found.switch_text(pin, False))
        self.assertEqual(found.switching(off), (growth, False))
        self.host.run(0.01)
        self.assertTrue(self.hal.get("growth.enabled"))
        self.screen().switch_off([off])
        self.host.run(0.01)
        self.assertFalse(self.hal.get("growth.enabled"))
        self.screen().change_all([off._replace(text=found.switch_text(pin, True))])
        self.assertTrue(self.hal.get("growth.enabled"))

    def test_a_machine_without_components_has_no_instances(self):
        self.assertEqual(machine.Machine([], DECLARED).instances, [])


class Channels(unittest.TestCase):
    """The channels of sensor programs, whatever the program's component is called."""

    PARTS = (("value", "float", 12.5), ("age", "float", 0.5), ("valid", "bit", True), ("fault-code", "s32", 0))

    def channels(self, owner, stem):
        pins = [Pin("%s.%s" % (stem, part), owner, kind, True, value, "") for part, kind, value in self.PARTS]
        return [(each.name, each.module) for each in machine.Machine(pins, DECLARED).channels]

    def test_those_of_each_sensor_program_are_found(self):
        for owner, stem in (("can_sensor", "can-sensor.spindle-load"), ("modbus_sensor", "modbus-sensor.column-front"), ("modbus_sensor", "gauge.height")):
            with self.subTest(owner, stem=stem):
                self.assertEqual(self.channels(owner, stem), [(stem, owner)])

    def test_those_under_another_name_of_the_component_are_found(self):
        self.assertEqual(self.channels("can-sensor-2", "can-sensor-2.load"), [("can-sensor-2.load", "can_sensor")])
        self.assertEqual(self.channels("gauges", "gauges.height"), [("gauges.height", "modbus_sensor")])

    def test_pins_of_another_component_are_none(self):
        self.assertEqual(self.channels("interlock", "interlock.0"), [])


class Changing(WithHost):
    def test_a_change_is_written_and_logged(self):
        self.screen("anna").change(self.growth, "window", "0.125", seen=self.hal.get("growth.window"))
        self.assertEqual(self.hal.get("growth.window"), 0.125)
        change = self.screen().log.all()[-1]
        self.assertEqual((change.who, change.pin, change.old, change.new), ("anna", "growth.window", "0.5", "0.125"))
        self.assertLess(abs(change.time - time.time()), 3600)

    def test_bad_values_are_refused_with_pin_and_value(self):
        for short, text in (("window", "abc"), ("window", "nan"), ("window", "inf"), ("window", ""), ("tool-number", "1.5"),
                            ("tool-number", "3000000000"), ("dry-run", "2")):
            with self.subTest(short, text=text):
                before = self.hal.get("growth." + short)
                with self.assertRaises(settings.Refused) as refused:
                    self.screen().change(self.growth, short, text)
                self.assertIn("growth." + short, str(refused.exception))
                self.assertIn(text, str(refused.exception))
                self.assertEqual(self.hal.get("growth." + short), before)
        self.assertEqual(self.screen().log.all(), [])

    def test_a_value_that_the_component_refuses_is_taken_back(self):
        with self.assertRaises(settings.Refused) as refused:
            self.screen().change(self.growth, "gate-cap", "0.001")  # below gate-floor
        sentence = DECLARED["thermal_displacement"].sentence("detail-code", 6)
        for words in ("growth.gate-cap", "0.001 mm", sentence):
            self.assertIn(words, str(refused.exception))
        self.assertEqual(self.hal.get("growth.gate-cap"), 0.06)
        self.assertEqual(self.hal.get("growth.detail-code"), 0)
        self.assertEqual(self.screen().log.all(), [])

    def test_a_value_out_of_the_declared_range_is_not_written(self):
        for text, words in (("-0.5", "\u22120.5 mm/s is out of range: at least 0 mm/s"), ("2", "2 mm/s is out of range: at most 1 mm/s")):
            with self.subTest(text):
                with self.assertRaises(settings.Refused) as refused:
                    self.screen().change(self.growth, "max-rate", text)
                self.assertIn("growth.max-rate: " + words, str(refused.exception))
        self.assertEqual(self.hal.get("growth.max-rate"), 0.01)
        self.assertEqual(self.screen().log.all(), [])

    def test_a_comma_is_a_decimal_point(self):
        self.screen().change(self.growth, "window", "0,25")
        self.assertEqual(self.hal.get("growth.window"), 0.25)

    def test_of_two_screens_the_second_one_is_told_of_the_first(self):
        anna, bert = self.screen("anna"), self.screen("bert")
        seen = self.hal.get("growth.window")
        anna.change(self.growth, "window", "0.25", seen=seen)
        with self.assertRaises(settings.Conflict) as conflict:
            bert.change(self.growth, "window", "0.3", seen=seen)
        self.assertEqual(conflict.exception.change.who, "anna")
        self.assertEqual(self.hal.get("growth.window"), 0.25)
        bert.change(self.growth, "window", "0.3", seen=0.25)
        self.assertEqual([change.new for change in anna.log.all()], ["0.25", "0.3"])

    def test_undo_puts_back_the_value_of_before(self):
        screen = self.screen()
        screen.change(self.growth, "window", "0.25")
        self.undo(screen, "growth.window")
        self.assertEqual(self.hal.get("growth.window"), 0.5)
        self.assertEqual(screen.log.all()[-1].why, "undo")
        with self.assertRaises(settings.Refused):
            screen.last_of("growth.gate-floor")

    def undo(self, screen, pin):
        writes, _chain, _lines, _former = screen.undoing(screen.last_of(pin), self.machine)
        return screen.change_all(writes, "undo")

    def test_undo_puts_all_back_that_was_written_together(self):
        screen = self.screen()
        square = self.machine.named("square")
        screen.change_all([settings.Write(square, "ec0x", "0.0001"), settings.Write(square, "ea0y", "0.0002")], "squareness")
        screen.change(self.growth, "window", "0.25")
        self.undo(screen, "square.ec0x")
        self.assertEqual([self.hal.get("square.ec0x"), self.hal.get("square.ea0y")], [0, 0])
        self.assertEqual(self.hal.get("growth.window"), 0.25)

    def test_undo_of_a_request_is_not_kept_over_a_restart(self):
        screen = self.screen()
        screen.change_all([settings.Write(self.growth, "learn", "1", lasts=False)])
        self.undo(screen, "growth.learn")
        self.assertFalse(self.hal.get("growth.learn"))
        self.assertEqual(screen.kept(), [])

    def test_a_deed_that_was_changed_since_is_not_undone_in_part(self):
        screen = self.screen()
        square = self.machine.named("square")
        screen.change_all([settings.Write(square, "ec0x", "0.0001"), settings.Write(square, "ea0y", "0.0002")], "squareness")
        screen.change(square, "ea0y", "0.0003")
        with self.assertRaisesRegex(settings.Conflict, "square.ea0y was changed again since"):
            self.undo(screen, "square.ec0x")
        self.assertEqual([self.hal.get("square.ec0x"), self.hal.get("square.ea0y")], [0.0001, 0.0003])

    def test_of_settings_that_are_written_together_all_are_taken_back_if_one_is_refused(self):
        screen = self.screen()
        square = self.machine.named("square")
        self.host.command("setp square.max-speed 100")
        self.host.run(0.01)
        with self.assertRaisesRegex(settings.Refused, "square refuses"):
            screen.change_all([settings.Write(square, "ec0x", "0.0001"), settings.Write(square, "max-speed", "0")])
        self.assertEqual([self.hal.get("square.ec0x"), self.hal.get("square.max-speed")], [0, 100])
        self.assertEqual(screen.log.all(), [])

    def test_a_component_that_is_gone_is_named(self):
        self.host.command("stop")
        self.host.command("unloadrt thermal_displacement")
        with self.assertRaises(settings.Refused) as refused:
            self.screen().change(self.growth, "window", "0.25")
        self.assertIn("growth.window", str(refused.exception))

    def test_a_folder_that_cannot_be_written_is_named_and_nothing_changes(self):
        screen = settings.Settings(self.hal, os.path.join(self.folder, "nowhere"), "anna", settle=lambda: None)
        with self.assertRaises(settings.Refused) as refused:
            screen.change(self.growth, "window", "0.25")
        self.assertIn("nowhere", str(refused.exception))
        self.assertEqual(self.hal.get("growth.window"), 0.5)

    def test_a_torn_line_of_the_log_is_left_out(self):
        self.screen().change(self.growth, "window", "0.25")
        with open(os.path.join(self.folder, "panel_changes.log"), "a") as file:
            file.write('{"time": 1,\n{"ti')
        self.assertEqual(len(self.screen().log.all()), 1)
        self.screen().change(self.growth, "window", "0.35")
        self.assertEqual([change.new for change in self.screen().log.all()], ["0.25", "0.35"])

    def test_no_change_with_a_flipped_bit_is_shown_or_undone(self):
        screen, path = self.screen(), os.path.join(self.folder, "panel_changes.log")
        screen.change(self.growth, "window", "0.25")
        screen.change(self.growth, "window", "0.35")
        with open(path, "rb") as file:
            good = file.read()
        first = good.index(b"\n") + 1
        for bit in range(8 * first, 8 * len(good)):
            flipped = bytearray(good)
            flipped[bit // 8] ^= 1 << bit % 8
            with open(path, "wb") as file:
                file.write(flipped)
            self.assertEqual([change.new for change in changes.ChangeLog(path).all()], ["0.25"], (bit, bytes(flipped)))
        with self.assertRaisesRegex(settings.Conflict, "was changed meanwhile"):
            self.undo(self.screen(), "growth.window")  # of 0.25, which is not in force
        self.assertEqual(self.hal.get("growth.window"), 0.35)

    def test_changes_of_before_have_no_checksum(self):
        with open(os.path.join(self.folder, "panel_changes.log"), "w", encoding="ascii") as file:
            file.write('{"time": 1.5, "who": "anna", "pin": "growth.window", "old": "0.125", "new": "0.5", "why": ""}\n')
        self.undo(self.screen(), "growth.window")
        self.assertEqual(self.hal.get("growth.window"), 0.125)


class Unwritable(WithHost):
    """A log that cannot be written: Off comes before it, and no sentence says what the pins do not."""

    def full_disk(self):
        """No file grows beyond the log, which is long."""
        before, size = resource.getrlimit(resource.RLIMIT_FSIZE), 1 << 20
        with open(os.path.join(self.folder, "panel_changes.log"), "wb") as file:
            file.write(b"x" * (size - 1) + b"\n")
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_FSIZE, before)
        return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, before)

    def off(self):
        owner, short = self.machine.owner_of(self.machine.switch_of(self.growth))
        return [settings.Write(owner, short, "0")]

    def test_off_comes_before_the_log_and_its_lock_and_a_change_of_another_screen(self):
        for blocked in ("panel_changes.log", "panel_changes.log.lock"):
            with self.subTest(blocked):
                self.host.command("setp interlock.0.function-switch-0 1")
                os.mkdir(os.path.join(self.folder, blocked))  # as one of root, also for root
                screen = self.screen()
                done = screen.switch_off([self.off()[0]._replace(seen=False)])
                self.assertEqual(screen.log.all()[-1].new, "0")
                self.assertFalse(self.hal.get("interlock.0.function-switch-0"))
                self.assertEqual(done.values, [False])
                if not blocked.endswith("lock"):
                    self.assertIn("The change could not be logged: ", done.lost)
                os.rmdir(os.path.join(self.folder, blocked))

    def test_off_waits_for_no_lock(self):
        self.host.command("setp interlock.0.function-switch-0 1")
        with self.screen("bert").log.alone():
            self.assertEqual(self.screen().switch_off(self.off()).lost, "")
        self.assertFalse(self.hal.get("interlock.0.function-switch-0"))
        self.assertEqual(self.screen().log.all()[-1].pin, "interlock.0.function-switch-0")

    def test_without_the_lock_a_setting_is_not_changed_and_says_so(self):
        os.mkdir(os.path.join(self.folder, "panel_changes.log.lock"))
        with self.assertRaisesRegex(settings.Refused, "^growth.window is not changed. .*panel_changes.log.lock: Is a directory.$"):
            self.screen().change(self.growth, "window", "0.125")
        self.assertEqual(self.hal.get("growth.window"), 0.5)

    def test_on_a_full_disk_the_change_is_told_and_can_be_undone_on_this_screen(self):
        screen = self.screen()
        room = self.full_disk()
        done = screen.change_all([settings.Write(self.growth, "window", "0.125")])
        self.assertEqual(self.hal.get("growth.window"), 0.125)
        self.assertRegex(done.lost, "^The change could not be logged: .*panel_changes.log: ")
        writes, *_rest = screen.undoing(screen.last_of("growth.window"), self.machine)
        screen.change_all(writes, "undo")
        self.assertEqual(self.hal.get("growth.window"), 0.5)
        room()
        screen.change(self.growth, "window", "0.25")
        self.assertEqual([change.new for change in self.screen().log.all()], ["0.125", "0.5", "0.25"], "what waited came with the next one")

    def test_a_value_that_cannot_be_put_back_is_told_as_the_pin_has_it(self):
        class Stuck(HostHal):
            """HAL refuses the way back, as when another writer came."""

            def set(self, name, text):
                if float(text) == 0.06:
                    raise ValueError("HAL refuses")
                super().set(name, text)

        screen = self.screen()
        screen.hal = Stuck(self.host)
        with self.assertRaisesRegex(settings.Refused, "growth.gate-cap is 0.001 mm now.$"):
            screen.change(self.growth, "gate-cap", "0.001")  # below gate-floor


class Links(WithHost):
    """A link leads into another file: none is followed, not by commission either."""

    def setUp(self):
        super().setUp()
        self.victim = os.path.join(own_folder(self), "victim")
        with open(self.victim, "w") as file:
            file.write("as it was\n")

    def link(self, name):
        os.symlink(self.victim, os.path.join(self.folder, name))

    def check(self):
        with open(self.victim) as file:
            self.assertEqual(file.read(), "as it was\n")

    def test_the_log_is_not_written_through_a_link(self):
        self.link("panel_changes.log")
        done = self.screen().change_all([settings.Write(self.growth, "window", "0.125")])
        self.assertIn("panel_changes.log: it is a link, which is not followed.", done.lost)
        self.assertEqual(self.hal.get("growth.window"), 0.125)
        self.check()

    def test_a_lock_that_is_a_link_or_a_pipe_is_refused(self):
        path = os.path.join(self.folder, "panel_changes.log.lock")
        for make in (lambda: self.link("panel_changes.log.lock"), lambda: os.mkfifo(path)):
            make()
            with self.assertRaisesRegex(settings.Refused, "growth.window is not changed."):
                self.screen().change(self.growth, "window", "0.125")
            os.unlink(path)
        self.check()

    def test_kept_settings_records_sheets_and_pictures_are_not_written_through_a_link(self):
        for name in ("panel.toml", "commissioned.json", "squareness_uncertainty.json", "commissioned_squareness.html"):
            self.link(name)
            with self.subTest(name), self.assertRaisesRegex(OSError, "it is a link, which is not followed"):
                files.replace(os.path.join(self.folder, name), "another")
        records = Records(self.folder, "mill")
        with self.assertRaises(OSError):
            records._write({})  # noqa: SLF001
        self.check()


class Keeping(WithHost):
    """A changed setting outlives a restart, by the real plumb-retain."""

    def until(self, condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            self.host.run(0.01)
            time.sleep(0.002)

    def retain(self):
        path = os.path.join(self.folder, "panel.toml")
        if not os.path.exists(path):
            with open(path, "w") as file:
                file.write('machine = "mill"\nevery = 0.05\n')
        program = os.path.join(BUILD, "bin", "plumb-retain")
        self.host.command("loadusr -Wn panel-settings %s panel-settings --file %s --period 0.01" % (program, path))
        self.until(lambda: self.hal.get("panel-settings.restored"), "restored")

    def stored(self):
        try:
            with open(os.path.join(self.folder, "panel.retained")) as file:
                return file.read()
        except FileNotFoundError:
            return ""

    def test_a_changed_setting_wins_over_the_hal_file_after_a_restart(self):
        self.retain()
        screen = self.screen()
        self.assertEqual(screen.retain_state(self.hal.values()), "")
        screen.change(self.growth, "window", "0.125")
        self.until(lambda: '"growth.window" = 0.125' in self.stored(), self.stored())
        screen.change(self.growth, "gate-floor", "0.015")
        self.until(lambda: '"growth.gate-floor" = 0.015' in self.stored(), self.stored())
        self.host.close()
        self.start()
        self.host.command("setp growth.window 0.3")  # the HAL file's
        self.retain()
        self.assertEqual(self.hal.get("growth.window"), 0.125)
        self.assertEqual(self.hal.get("growth.gate-floor"), 0.015)
        self.assertEqual(self.screen().kept(), ["growth.gate-floor", "growth.window"])
        self.screen().keep("growth.window", keep=False)
        self.until(lambda: '"growth.window"' not in self.stored(), self.stored())

    def test_a_store_that_is_bound_to_its_computer_stays_so(self):
        with open(os.path.join(self.folder, "panel.toml"), "w") as file:
            file.write('machine = "mill"\nbound = true\n')
        self.screen().keep("growth.window")
        with open(os.path.join(self.folder, "panel.toml")) as file:
            self.assertIn("\nbound = true\n", file.read())

    def test_without_retain_the_screen_says_that_a_change_is_lost(self):
        self.assertIn("lost", self.screen().retain_state(self.hal.values()))


class Verdicts(WithHost):
    def test_a_component_that_is_gone_is_said(self):
        self.assertEqual(status.of(self.growth, {}).kind, "bad")

    def test_the_detail_of_a_status_is_the_sentence_of_its_code(self):
        codes = DECLARED["thermal_displacement"].codes
        faulty = next(number for number, its in DECLARED["thermal_displacement"].statuses.items() if its["sentence"] == "A fault is active.")
        its = status.of(self.growth, {**self.hal.values(), "growth.status-code": faulty, "growth.detail-code": 1})
        self.assertEqual((its.kind, its.text), ("bad", "A fault is active. " + codes["detail-code"][1]))

    def test_the_machine_is_moved_only_while_it_is_safe(self):
        safe = {"motion.motion-enabled": True, "motion.is-all-homed": True, "motion.motion-type": 0, "halui.program.is-running": False,
                "halui.program.is-idle": True}
        self.assertEqual(access.unsafe(safe), "")
        for pin, value in (("motion.motion-enabled", False), ("motion.is-all-homed", False), ("motion.motion-type", 2),
                           ("halui.program.is-running", True)):
            with self.subTest(pin):
                self.assertNotEqual(access.unsafe({**safe, pin: value}), "")
        self.assertNotEqual(access.unsafe({}), "")
        nobody = {pin: value for pin, value in safe.items() if not pin.startswith("halui.")}
        self.assertIn("LinuxCNC does not answer", access.unsafe({**nobody, "task.alive": False}))
        self.assertEqual(access.unsafe({**nobody, "task.alive": True, "task.program": "idle"}), "")

    def test_each_level_may_do_what_lower_ones_may(self):
        may = {level: [not access.Access(level).refusal(needed) for needed in access.LEVELS] for level in access.LEVELS}
        self.assertEqual(may, {"view": [True, False, False], "operator": [True, True, False], "integrator": [True, True, True]})
        with self.assertRaises(ValueError):
            access.Access("boss")


class Waiting(WithHost):
    CHANGES = "The next move waits until no offset and no correction of the tool changes."

    def setUp(self):
        super().setUp()
        for line in (
            "unlinkp interlock.0.function-state-0",
            "loadrt peers names=peers",
            "addf peers.update servo-thread 1",
            "net peer-0 peers.function-state-0 => interlock.0.function-state-0",
            "net stage-0 peers.stage-state-0 => interlock.0.stage-state-0",
            *("net program-%d peers.service-state-%d => interlock.0.service-state-%d" % (number, number, number) for number in SIGNS),
            "setp interlock.0.function-services-0 49",
            "setp interlock.0.function-urgent-0 32",
            "setp interlock.0.feed-services 16",
            "setp interlock.0.program-running 1",
            *("setp interlock.0.service-timeout-%d 1" % number for number in SIGNS),
        ):
            self.host.command(line)
        self.beat(*SIGNS)
        self.host.command("setp interlock.0.function-switch-0 1")
        self.beat(*SIGNS)

    def beat(self, *services):
        """Lets a second and a half pass in which only these services live."""
        for _ in range(5):
            for number in services:
                pin = "peers.service-heartbeat-%d" % number
                self.host.set(pin, not self.host.get(pin))
            self.host.run(0.3)

    def sentences(self):
        return waiting.waiting(self.machine, self.hal.values())

    def test_a_change_of_an_offset_is_said_while_no_service_is_lost(self):
        self.assertEqual(self.sentences(), [])
        self.host.command("setp peers.function-settling-0 1")
        self.host.run(0.01)
        self.assertEqual(self.sentences(), [self.CHANGES])
        self.host.command("setp interlock.0.feed-held-delay 0")
        self.host.run(0.01)
        self.assertEqual(self.sentences(), ["The feed is held for long: an offset or a correction of the tool does not come to rest."])

    def test_the_first_service_that_holds_the_feed_is_named_and_no_offset(self):
        lost = "The feed is held: %s does not answer. Start LinuxCNC again."
        for living, name in (((0, 5), "LinuxCNC's task (service 4)"), ((0, 4), "LinuxCNC's io (service 5)"), ((0,), "LinuxCNC's task (service 4)"),
                             ((), "LinuxCNC's task (service 4)")):  # plumb-retain holds no feed
            with self.subTest(living):
                self.beat(*SIGNS)
                self.host.command("setp interlock.0.function-switch-0 0")
                self.host.run(0.01)
                self.host.command("setp interlock.0.function-switch-0 1")
                self.beat(*SIGNS)
                self.assertEqual(self.sentences(), [])
                self.beat(*living)
                self.assertTrue(self.hal.get("interlock.0.feed-service-lost"))
                self.assertEqual(self.sentences(), [lost % name])

    def test_a_sum_out_of_range_stands_for_all_services(self):
        self.host.command("setp interlock.0.feed-services 256")
        self.beat(4, 5)
        self.assertEqual(self.sentences(), ["The feed is held: plumb-retain (service 0) does not answer. Start LinuxCNC again."])

    def test_a_function_that_is_off_after_a_loss_is_said(self):
        self.beat(0, 4)
        self.beat(*SIGNS)
        self.assertEqual(self.sentences(), ["A function is off because a service was lost, and the feed is held. When the service answers again, "
                                            "turn the switch of the function off and on."])

    def test_refused_probing_and_an_axis_without_its_offset_are_said(self):
        for lines, text in ((("setp peers.stage-probing-refused-0 1",), "Probing is refused: remove the offset first."),
                            (("setp peers.stage-probing-refused-0 0", "setp interlock.0.probing-refused-time 0",
                              "setp peers.stage-uncompensated-0 1", "setp interlock.0.uncompensated-delay 0"),
                             "An axis lacks its offset until the next cycle begins.")):
            for line in lines:
                self.host.command(line)
            self.host.run(0.01)
            self.assertEqual(self.sentences(), [text])

    def test_a_loss_that_holds_no_feed_is_not_said_here(self):
        self.beat(4, 5)
        self.assertEqual(self.sentences(), [])


class GrowthTest(unittest.TestCase):
    """A machine warms with a time constant of an hour; its temperatures change by 8 K an hour at first, and scatter."""

    THRESHOLD, CONSTANT, MINUTE, HOUR = 0.5, 3600.0, 60.0, 3600.0

    def changes(self, until, scatter=0.03):
        numbers = random.Random(7)
        return [(when, 8 * math.exp(-when / self.CONSTANT) * (1 + scatter * numbers.gauss(0, 1))) for when in range(0, int(until), 60)]

    def remaining(self, elapsed, **more):
        times = {"shortest": 0.0, "longest": 12 * self.HOUR, **more}
        return growth_test_state.remaining(self.changes(elapsed), self.THRESHOLD, elapsed, times["shortest"], times["longest"])

    def test_a_plan_in_words_has_equal_cycles_together_and_each_term(self):
        cycles = [{"rpm": 8000, "door": False}] * 2 + [{"rpm": 0, "door": False}, {"rpm": 0, "door": True}]
        plan = {"work_min": 30, "cycles": cycles, "machine": {"log": "/tmp/logs/growth-1.csv"},
                "terms": [{"name": "temperature of the structure", "unit": "um/K", "after": 0.66, "hour_more": 0.5}]}
        self.assertEqual(growth_test_state.plan_in_words(plan), [
            "4 cycles of 30 min work and a pass:", "2 \u00d7 8000 rpm   1 \u00d7 rest   1 \u00d7 rest, shop door open",
            "temperature of the structure: \u00b10.7 \u00b5m/K, after another hour \u00b10.5", "For the machine of growth-1.csv."])

    def test_the_drift_of_a_bore_is_that_since_its_first_visit(self):
        drift, visits = growth_test_state.LiveDrift(), 4  # visits before this screen began
        drift.observe(visits, False, True, (7, False), (9, 9, 9))
        self.assertEqual(drift.now, {})

        def visit(bore, turned, position, counts=True):
            drift.observe(visits, True, True, (bore, turned), (9, 9, 9))
            for _ in range(2):  # meanwhile the program has another bore in mind
                drift.observe(visits, False, counts, (3, True), position)

        for growth in (0, 1, 2):
            for bore, turned in ((1, False), (1, True), (2, False)):
                visits += 1
                visit(bore, turned, (bore + growth, 10 * turned, -growth))
        moved = {key: (2, 0, -2) for key in ((1, False), (1, True), (2, False))}
        self.assertEqual(drift.now, moved)
        visit(2, False, (math.nan, 0, 0))
        visit(2, False, (50, 0, 0), counts=False)
        self.assertEqual(drift.now, moved)
        drift.observe(0, False, True, (1, False), (9, 9, 9))  # another test
        self.assertEqual(drift.now, {})

    def test_the_remaining_time_is_that_of_the_exponential(self):
        warm = self.CONSTANT * math.log(8 / self.THRESHOLD)
        for elapsed in (0.5 * self.HOUR, self.HOUR, 2 * self.HOUR):
            low, likely, high = self.remaining(elapsed)
            with self.subTest(elapsed):
                self.assertAlmostEqual(likely, warm - elapsed, delta=high - low)
                self.assertLess(low, warm - elapsed + 2 * self.MINUTE)
                self.assertGreater(high, warm - elapsed - 2 * self.MINUTE)
        self.assertAlmostEqual(self.remaining(2 * self.HOUR)[1], warm - 2 * self.HOUR, delta=5 * self.MINUTE)
        early, late = self.remaining(0.5 * self.HOUR), self.remaining(2 * self.HOUR)
        self.assertLess(late[2] - late[0], early[2] - early[0])

    def test_it_is_within_the_times_of_the_test(self):
        self.assertEqual(self.remaining(2 * self.HOUR, shortest=6 * self.HOUR)[:2], (4 * self.HOUR, 4 * self.HOUR))
        self.assertEqual(self.remaining(self.HOUR, longest=1.5 * self.HOUR)[1:], (0.5 * self.HOUR, 0.5 * self.HOUR))

    def test_without_changes_only_the_bounds_are_known(self):
        for changes in ([], [(60.0 * place, 1000.0) for place in range(20)], [(60.0, 1.0)] * 20):
            self.assertEqual(growth_test_state.remaining(changes, 0.5, 3600, 7200, 36000), (3600, None, 32400))

    def test_a_machine_that_does_not_settle_takes_the_whole_time(self):
        growing = [(60.0 * place, 1 + 0.01 * place) for place in range(60)]
        self.assertEqual(growth_test_state.remaining(growing, 0.5, 3600, 0, 36000)[1:], (32400, 32400))


class Texts(unittest.TestCase):
    def test_german_words_have_the_values_of_their_text(self):
        german = panel_texts.translated()
        wanted = {**panel_texts.of_sources(), **panel_texts.of_declarations(BUILD)}
        there = [text for text in wanted if german.get(text)]
        self.assertGreater(len(there), 0.95 * len(wanted))
        for text in there:
            with self.subTest(text, place=wanted[text]):
                values = [sorted(re.findall(r"\{\w+\}", each)) for each in (text, german[text])]
                self.assertEqual(*values)

    def test_every_text_of_the_panel_itself_has_german_words(self):
        own = {text: file for text, file in panel_texts.of_sources().items() if not file.endswith("_page.py")}  # a new page may lack them
        self.assertGreater(len(own), 150)
        self.assertEqual(panel_texts.without_words(own), {})

    def test_a_pin_without_german_words_is_listed_and_its_text_stays_english(self):
        self.assertEqual(panel_texts.without_words({"A pin of tomorrow.": "axis_offset.json"}), {"A pin of tomorrow.": "axis_offset.json"})
        texts.choose(os.path.join(BUILD, "share", "locale"), "de")
        self.addCleanup(texts.choose, "", "en")
        self.assertEqual(texts._("A pin of tomorrow."), "A pin of tomorrow.")

    def test_the_built_texts_are_german(self):
        texts.choose(os.path.join(BUILD, "share", "locale"), "de")
        self.addCleanup(texts.choose, "", "en")
        self.assertEqual(texts._("Overview"), "\u00dcbersicht")


class HalFiles(unittest.TestCase):
    def test_settings_of_a_shipped_machine_are_read(self):
        ini = hal_files.Ini(os.path.join(ROOT, "configs", "mill", "axis.ini"))
        found = hal_files.values_of_hal_files(ini)
        self.assertEqual(found["growth.window" if "growth.window" in found else "growth.max-rate"][0], "0.1")
        self.assertEqual(found["square.ec0y"], ("-0.00016", "square_settings.hal"))
        self.assertEqual(ini.get("SQUARENESS", "CHAIN"), "w-Z.b-X-Y-C-t")
        self.assertEqual(found["x-stage.offset-acceleration"][0], "500")


if __name__ == "__main__":
    unittest.main()

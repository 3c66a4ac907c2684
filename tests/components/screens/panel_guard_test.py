# SPDX-License-Identifier: GPL-2.0-or-later
"""Each setting, changed while something is wrong: what the panel says against what the pins do. The screen is a robot that says yes."""

import os
import re
import resource
import sys
import unittest

import plumb
from tree import BUILD, ROOT, own_folder

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from long import long
from panel import access, effects, machine, settings  # noqa: E402
from panel.declared import read_all  # noqa: E402
from panel.guard import Guard  # noqa: E402
from panel.hal_files import Ini  # noqa: E402
from panel.pin_lines import parse_pins  # noqa: E402
from panel.settings import Write  # noqa: E402

DECLARED, _damaged = read_all(os.path.join(BUILD, "share", "plumb"))
READY = {"motion.motion-enabled": True, "motion.is-all-homed": True, "motion.motion-type": 0, "task.alive": True, "task.program": "idle"}
SAID_UNCHANGED = ("is not changed.", ": refused. ", " refuses ", " is out of range: ")


class HostHal:
    def __init__(self, host):
        self.host = host

    def values(self):
        return {pin.name: pin.value for pin in parse_pins(self.host.halcmd("-s", "show", "pin").output)}

    def get(self, name):
        return self.host.get(name)

    def set(self, name, text):
        done = self.host.halcmd("setp", name, text)
        if done.status:
            raise ValueError(done.output)


class Robot:
    """What a Guard needs of a panel; it says yes to each question, and remembers what it was told."""

    def __init__(self, test, level, around):
        self.hal, self.machine, self.access, self.ini = test.hal, test.machine, access.Access(level), Ini("")
        self.settings = settings.Settings(self.hal, test.folder, "robot", "mill", settle=lambda: test.host.run(0.02))
        self.settings.keep = lambda name, keep=True: None
        self.around, self.said, self.asked = around, [], []

    def task_values(self):
        return self.around

    def program(self, name):
        return os.path.join(BUILD, "bin", name)

    def say(self, text, kind="good"):
        self.said.append(text)

    def ask(self, text, action, do):
        self.asked.append(text)
        do()

    def conflict(self):
        pass


class Said(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt thermal_displacement names=growth", "loadrt joint_offset names=x-stage interlock=no",
                     "loadrt interlock names=interlock", "net permit interlock.function-permit-0 => growth.permit", "net state growth.state => interlock.function-state-0", "addf growth.update servo-thread", "addf x-stage.update servo-thread",
                     "addf interlock.update servo-thread", "setp x-stage.min-limit -100", "setp x-stage.max-limit 100",
                     "setp x-stage.joint-acceleration 2000", "setp x-stage.offset-acceleration 1000", "setp interlock.function-services-0 0", "setp interlock.function-stages-0 0", "start"):
            self.host.command(line)
        self.host.run(0.05)
        self.hal = HostHal(self.host)
        self.machine = machine.Machine(parse_pins(self.host.halcmd("-s", "show", "pin").output), DECLARED)

    def full_disk(self):
        """No file grows beyond the log, which is long."""
        before, size = resource.getrlimit(resource.RLIMIT_FSIZE), 1 << 20
        with open(os.path.join(self.folder, "panel_changes.log"), "wb") as file:
            file.write(b"x" * (size - 1) + b"\n")
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_FSIZE, before)

    def foreign_log(self):
        for name in ("panel_changes.log", "panel_changes.log.lock"):
            os.mkdir(os.path.join(self.folder, name))

    def others(self):
        """(instance, pin, another value) of the settings."""
        for instance in self.machine.instances:
            for short in instance.settings():
                if re.search(r"-[1-9]\d*$", short):
                    continue  # of a row, as its first one
                pin, now, declared = instance.pins[short], self.host.get(instance.full(short)), instance.declared.pin(short)
                other = {"bit": str(int(not now)), "float": repr(now * 0.75 + 0.001)}.get(pin.kind, str(now + 1 if now != declared.get("maximum") else now - 1))
                yield instance, short, now, other

    def try_all(self, level, around):
        """Returns how many were changed. What is said must be what the pins show."""
        changed = 0
        for instance, short, former, other in self.others():
            robot, name = Robot(self, level, around), instance.full(short)
            Guard(robot).change([Write(instance, short, other, former)], "Save", "{pin} is now {value}.")
            now, said = self.host.get(name), " ".join(robot.said)
            with self.subTest(name, level=level, other=other, said=said):
                self.assertTrue(said)
                is_changed = not settings.same(now, former)
                changed += is_changed
                self.assertEqual(is_changed, not any(words in said for words in SAID_UNCHANGED))
            self.host.command("setp %s %r" % (name, int(former) if isinstance(former, bool) else former))
        self.host.run(0.05)
        return changed

    @long
    def test_while_all_is_well(self):
        self.assertGreater(self.try_all("integrator", READY), 100)

    @long
    def test_on_a_full_disk(self):
        self.full_disk()
        self.assertGreater(self.try_all("integrator", READY), 100)

    def test_with_a_log_of_somebody_else_nothing_changes(self):
        self.foreign_log()
        self.assertEqual(self.try_all("integrator", READY), 1, "the stage alone, which is switched off")

    def test_who_may_only_look_changes_nothing(self):
        self.assertEqual(self.try_all("view", READY), 1, "the stage alone, which is switched off")

    def test_while_a_program_runs_nothing_changes_that_moves_at_once(self):
        self.try_all("integrator", {**READY, "task.program": "running"})
        for instance, short, _former, other in self.others():
            write = Write(instance, short, other)
            if effects.needs_rest(self.machine, [write], self.hal.values()) and self.machine.switching(write)[0] is None:
                robot = Robot(self, "integrator", {**READY, "task.program": "running"})
                Guard(robot).change([write], "Save")
                self.assertEqual(robot.said, ["Save: refused. A program runs."], write.name)

    @long
    def test_under_an_emergency_stop(self):
        self.assertGreater(self.try_all("integrator", {**READY, "motion.motion-enabled": False}), 100)

    def test_off_is_accepted_in_each_case(self):
        self.foreign_log()
        for around in (READY, {**READY, "task.program": "running"}, {**READY, "motion.motion-enabled": False}, {**READY, "task.alive": False}):
            for level in access.LEVELS:
                for name in ("interlock.function-switch-0", "x-stage.enable"):
                    self.host.command("setp %s 1" % name)
                    self.host.run(0.01)
                    robot = Robot(self, level, around)
                    Guard(robot).change([Write(*self.machine.owner_of(name), "0")], "Switch off")
                    self.assertFalse(self.host.get(name), (level, around, robot.said))
                    self.assertIn("The change could not be logged", " ".join(robot.said))

    def test_off_that_interlock_does_not_see_returns_the_offset_in_a_program_and_says_so(self):
        for line in ("setp x-stage.motion-enabled 1", "setp x-stage.homed 1", "setp x-stage.offset-0 0.02"):
            self.host.command(line)
        for program in ("running", "paused", "idle"):
            self.host.command("setp x-stage.enable 1")
            self.host.run(1)
            self.assertAlmostEqual(self.host.get("x-stage.applied-offset"), 0.02)
            robot = Robot(self, "operator", {**READY, "task.program": program})
            Guard(robot).change([Write(*self.machine.owner_of("x-stage.enable"), "0")], "Switch off")
            self.host.run(0.1)
            self.assertLess(self.host.get("x-stage.applied-offset"), 0.015)
            self.assertEqual("In a program the offset returns at once, also in a cut." in robot.asked[0], program != "idle", robot.asked)
            self.assertIn("It moves: x-stage", robot.asked[0])


if __name__ == "__main__":
    unittest.main()

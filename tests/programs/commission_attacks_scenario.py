#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of the campaign of commissioning: its session dies in every step, or meets drawn faults in the wiring, beside other functions.

    commission_attacks_scenario.py die FUNCTION SEED STEPS WAY...    in the first steps; WAY: kill, stop, hang, or "one" that is drawn in each step
    commission_attacks_scenario.py wire FUNCTION SEED COUNT
"""

import contextlib
import os
import random
import signal
import sys
import time
import traceback

import plumb
from commission_scenario import Axes, Column, Growth, Grows, Lathe, Mill
from commissioning_attacks import MACHINE_OF
from commissioning_wirings import Wirings
from plumb_linuxcnc import Machine, OperatorError
from scenario import run

WAYS = ("kill", "stop", "hang")
STATES = ("held", "off", "on", "busy")
AWAKE = 15  # writes of a program that goes on after a pause
PATIENCE = 400  # s, for a step


class Attacks:
    """Each function has its session while the others pass, act and change. A machine has disturb_FUNCTION, begin_FUNCTION and settle()."""

    @property
    def columns(self):
        return ["scene", *self.its.columns]

    @property
    def its(self):
        return MACHINE_OF[sys.argv[2]]

    def work(self):
        from commissioning_robot import Robot

        self.silence = 0.5 * self.host.get("interlock.clock-speed")
        self.robot = Robot(self, self.plant)
        self.facts.update(tries=[], findings=[], speed=self.host.get("interlock.clock-speed"))
        what, self.function, seed, *more = sys.argv[1:]
        self.random = random.Random("%s %s" % (self.function, seed))
        self.changes = random.Random(seed)  # how many there are depends on the computer
        self.patiently(self.machine.turn_on)
        self.patiently(self.machine.home)
        self.before()
        self.machine.wait(6)  # interlock looks at the wiring, and plumb-retain restores
        if what == "die":
            self.die(int(more[0]), more[1:])
        else:
            self.wire(int(more[0]))

    # --- a session that ends in each step ---

    def die(self, steps, ways):
        from commissioning.session import Session

        for row in range(len(self.its.stages)):
            self.host.set("interlock.stage-passed-%d" % row, 0)
        rig = self.robot.rig()
        rig.let_pass(rig.function(self.function))  # which the session takes back
        session = Session(rig, rig.function(self.function), self.robot.records, "robot")
        self.facts["steps"], again = [], None
        while not session.done:
            title = session.step.title
            if again is None:
                self.facts["steps"].append(title)
                for way in self.random.choices(WAYS) if "one" in ways else ways:
                    self.attack(session, way)
                if len(self.facts["steps"]) == steps:
                    break
            self.begin("step")
            session.step.begin()
            verdict = self.robot.work(session)
            if not verdict.passed and session.step.title == title:
                if again:
                    self.facts["findings"].append("after the attacks \"%s\" ends with: %s" % (title, verdict.sentence))
                    break
                again = verdict
                self.calm(session)
            else:
                again = None
        self.begin("end")
        session.close()

    def attack(self, session, way):
        """Beside the other functions in drawn states the session goes into its step, and comes to an end at a drawn write of a pin."""
        others = self.draw_others(session)
        point = self.random.choice((self.random.randint(1, 9), self.random.randint(10, 25)))
        self.begin("try")
        self.facts["tries"].append({"scene": len(self.scenes), "step": session.step.title, "way": way, "point": point, "others": others})
        child = os.fork()
        if child == 0:
            try:
                self.work_and_die(session, way, point)
            except BaseException:  # noqa: BLE001 - the parent must not go on twice
                self.note_child(traceback.format_exc())
            finally:
                os._exit(0)
        latest, status = self.host.time + PATIENCE, None
        while status is None:
            done, found = os.waitpid(child, os.WNOHANG | os.WUNTRACED)
            status = found if done else None
            if self.host.time > latest:
                raise RuntimeError("the step %s does not end" % session.step.title)
            self.pass_time(0.1)
        self.pass_time(self.silence + 3)
        if os.WIFSTOPPED(status):
            os.kill(child, signal.SIGCONT)
            while os.waitpid(child, os.WNOHANG)[0] == 0:
                self.pass_time(0.1)
            self.pass_time(self.silence + 3)
        self.begin("between")
        step, steps = session.count
        if 1 < step < steps and session.rig.passed(session.function):
            self.facts["findings"].append("%s has passed, and its session ended in \"%s\"" % (self.function, session.step.title))
        self.calm(session)

    def note_child(self, text):
        with open("children.txt", "a") as file:
            file.write("%s\n%s\n" % (self.facts["tries"][-1], text))

    def work_and_die(self, session, way, point):
        """In a process of its own."""
        machine = Machine()
        self.machine.__dict__.update(machine.__dict__)
        self.host.__dict__.update(plumb.Host(attach=os.environ["RTAPI_FIFO_PATH"]).__dict__)
        self.machine._host = self.host
        writes, write = [0], self.robot.hal.set

        def dying(name, text):
            write(name, text)
            writes[0] += 1
            if writes[0] == point:
                self.end_child(way)
            elif writes[0] == point + AWAKE:
                os._exit(0)

        self.robot.hal.set = dying
        session.step.begin()
        self.robot.work(session)
        if writes[0] < point:
            self.end_child(way)

    def end_child(self, way):
        if way == "hang":
            self.machine.wait(1.3 * self.silence)
        else:
            os.kill(os.getpid(), signal.SIGKILL if way == "kill" else signal.SIGSTOP)

    def pass_time(self, seconds):
        """Other functions change meanwhile."""
        ends = self.host.time + seconds
        while self.host.time < ends:
            for number, state in self.others.items():
                if state == "busy":
                    getattr(self, "disturb_" + self.its.functions[number], lambda: None)()
            time.sleep(0.1)

    def draw_others(self, session):
        """Of each other function its state: held, off, on, or busy."""
        rig, its = session.rig, session.function
        self.others = {}
        for place in rig.functions:
            if place.number == its.number:
                continue
            state = self.others[place.number] = self.random.choice(STATES)
            mine = [stage.number for stage in rig.stages_of(its)]
            for stage in rig.stages_of(place):
                if stage.number not in mine:
                    rig.let_pass(stage)
            rig.take_back(place) if state == "held" else rig.let_pass(place)
            rig.switch(place, state in ("on", "busy"))
        self.machine.wait(1)
        for number, state in self.others.items():
            if state == "busy":
                with contextlib.suppress(OperatorError):  # with the machine off it begins nothing
                    getattr(self, "begin_" + self.its.functions[number], lambda: None)()
        return {self.its.functions[number]: state for number, state in self.others.items()}

    def calm(self, session):
        """A person comes back: the machine is on and at rest, all other functions are off, and what was lent is given back."""
        rig = session.rig
        self.others = {}
        for place in rig.functions:
            rig.switch(place, False)
        self.rest_others()
        session.give_back()
        self.patiently(self.machine.abort)
        self.patiently(self.machine.turn_on)
        status = self.machine.poll()
        if not all(status.homed[: status.joints]):
            self.patiently(self.machine.home)
        self.machine.command.feedrate(1)
        self.machine.command.rapidrate(1)
        rig.end_press()
        for line in ("G90 G21 M5", *self.settling):
            with contextlib.suppress(OperatorError):  # G80.1 after a machine off
                self.machine.mdi(line)
        self.settle()
        self.machine.wait(2)

    gain = ""  # of the command to a drive
    settling = ()  # lines that end what a session or another function has begun

    def settle(self):
        """Takes back what stays."""

    # --- drawn faults in the wiring ---

    def wire(self, count):
        rig = self.robot.rig()
        wirings = Wirings(rig, rig.function(self.function), self.random, self.do)
        self.begin("wire")
        for _turn in range(count):
            what, undo = wirings.put()
            self.others = {}
            try:
                self.machine.wait(3)
                found = self.robot.commission(self.function)
            except (OperatorError, RuntimeError, KeyError, ValueError) as error:
                found = {"fault": "error", "sentence": "%s: %s" % (type(error).__name__, error), "passed": False, "step": "", "sheet": ""}
            for line in undo:
                self.do(line)
            for place in (*rig.functions, *rig.stages):
                rig.take_back(place)
            self.facts["tries"].append({"wiring": what, **{key: found[key] for key in ("fault", "sentence", "passed", "step", "sheet")}})
            self.again()

    def again(self):
        """A simulated drive follows while the machine is off, and a doubled command takes it far away: it comes back to 0 without a move."""
        if self.gain:
            self.patiently(self.machine.turn_off)
            for gain in (0, 1):
                for letter in "xyz":
                    self.host.set(self.gain % letter, gain)
                self.machine.wait(0.5)
            self.machine.command.unhome(-1)
        else:
            self.rest_unhomed()
        self.patiently(self.machine.turn_on)
        self.patiently(self.machine.home)
        for line in self.settling:
            with contextlib.suppress(OperatorError):
                self.machine.mdi(line)
        self.fresh()
        self.machine.wait(3)

    def fresh(self):
        """For the next try."""


class Shop(Attacks, Mill):
    """The mill, whose Z strokes, too. An offset of the thermal function always waits for the next cycle."""

    ends = Column.ends
    square = Column.square
    gain = "fault-%s-cmd.in1"
    settling = ("G80.1", "M65 P0", "M68 E0 Q0")

    def draw_others(self, session):
        if self.function != "thermal_displacement":
            self.host.set("z-axis-stage.offset-1", 0.03)
        return super().draw_others(session)

    def disturb_thermal_displacement(self):
        self.host.set("z-axis-stage.offset-1", self.changes.uniform(-0.03, 0.03))

    def disturb_squareness(self):
        self.host.set("square.ec0y", -self.changes.uniform(0.0001, 0.0003))

    def begin_chopping(self):
        if self.host.get("interlock.function-enable-2"):
            self.machine.mdi("G21 G81.1 Z[#5422] Q-1 R0 P30", wait=False)
            self.machine.wait(2)

    def rest_others(self):
        self.host.set("z-axis-stage.offset-1", 0)
        self.host.set("square.ec0y", -0.00016)

    def settle(self):
        """As the panel does."""
        for line in ("M64 P3", "G4 P3", "M65 P3") if self.host.get("axis.z.eoffset") else ():
            self.patiently(lambda line=line: self.machine.mdi(line))


class Growing(Grows, Attacks):
    def disturb_axis_growth(self):
        self.temperature(self.changes.randrange(2), self.changes.uniform(0.9, 1.3))

    def rest_others(self):
        for number in range(2):
            self.temperature(number, 1)

    fresh = rest_others

    def settle(self):
        """axis_growth returns slowly."""
        self.await_condition(lambda: all(abs(self.host.get(stage + ".applied-offset")) < 1e-6 for stage in self.its.stages), "the return")


class Turning(Growing, Lathe):
    """The lathe, whose axes grow."""

    plant = {letter.upper(): letter + "-drive.out" for letter in "xyz"}
    settling = ("M453",)

    def fresh(self):
        super().fresh()
        self.lands = 0
        for value in (1, 0):
            self.host.set("lathe.new-stock", value)
            self.machine.wait(0.1)

    def settle(self):
        """A session that died has cut the bar."""
        super().settle()
        self.fresh()

    def begin_centre_height(self):
        self.machine.mdi("M450 P1 Q2 D10 E10.6")


class Warm(Growing, Growth):
    """A machine that grows, with the artifact on its table."""

    plant, gain = Axes.plant, "%s-with.gain0"
    settling = ("M65 P24",)

    def begin_thermal_growth_test(self):
        """A test whose program has gone."""
        self.machine.mdi("M64 P24")


SCENARIOS = {"shop": Shop, "turning": Turning, "warm": Warm}

if __name__ == "__main__":
    sys.exit(run(SCENARIOS[MACHINE_OF[sys.argv[2]].name], recording="attacks.csv" if sys.argv[1] == "die" else None))

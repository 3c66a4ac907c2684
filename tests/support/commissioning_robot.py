# SPDX-License-Identifier: GPL-2.0-or-later
"""A person with an indicator on a simulated machine: does what each step of plumb commission says, and reads the true positions."""

import contextlib
import os
import sys
import threading
import time

BUILD = os.environ["PLUMB_BUILD"] if "PLUMB_BUILD" in os.environ else os.environ["BUILD"]
SHARE = os.path.join(BUILD, "share", "plumb")
sys.path.insert(0, SHARE)
from commissioning import steps  # noqa: E402
from commissioning.functions import axis_growth, centre_height, chopping, squareness, thermal_displacement, thermal_growth_test  # noqa: E402
from commissioning.records import Records, findings  # noqa: E402
from commissioning.rig import Rig  # noqa: E402
from commissioning.session import Session  # noqa: E402
from panel import declared, hal_files  # noqa: E402
from panel.hal_access import Hal  # noqa: E402

MOST_STEPS = 60
LET_GO = "Let go."
SHIM = 0.1  # mm


class Pressed(Rig):
    """Counts its beats."""

    beats = 0

    def beat(self):
        self.beats += 1
        super().beat()


class Robot:
    """`plant` is the pin of the true place of each axis, by its letter; `scenario` has machine, host and facts."""

    def __init__(self, scenario, plant):
        self.scenario, self.plant = scenario, plant
        self.machine, self.host = scenario.machine, scenario.host
        self.hal = Hal()
        self.records = Records(os.path.join(os.getcwd(), "plumb"), "simulated")
        self.known = declared.read_all(SHARE)[0]
        self.presses, self.crept, self.with_one_axis, self.unpressed = 0, 0.0, "", 0

    def rig(self):
        status = self.machine.poll()
        ini = hal_files.Ini(status.ini_filename)
        return Pressed(self.hal, self.known, ini, os.path.join(SHARE, "functions"), self.mdi, sleep=self.machine.wait, clock=lambda: self.host.time)

    def mdi(self, line, stays=False):
        self.machine.mdi(line, wait=not line.startswith("G81.1"))

    def ends(self, letter):
        """Of a travel along a square, in mm."""
        return getattr(self.scenario, "ends", {}).get(letter, (-60, 20))

    def place(self, letter):
        return self.host.get(self.plant[letter]) if letter in self.plant else 0.0

    def commission(self, name, who="robot"):
        """Works through all steps until one names a fault twice. Returns fault, sentence, title of the last step, and whether it passed."""
        rig = self.rig()
        function = rig.function(name)
        session = Session(rig, function, self.records, who)
        verdict, title, began, self.presses = None, "", self.host.time, 0
        try:
            for _turn in range(MOST_STEPS):
                title = session.step.title
                verdict = self.work(session)
                step = session.step
                if session.done or (not verdict.passed and verdict.fault != "returns" and step.title == title):
                    break
        finally:
            session.close()
        self.machine.wait(1)
        sheet = ""
        if session.done:
            with open(session.records.sheets(rig, function)[1], encoding="utf-8") as file:
                sheet = file.read()
        effort = {"presses": self.presses, "readings": sum(len(entry["read"]) for entry in session.log), "steps": len(session.log),
                  "seconds": self.host.time - began}
        return {"effort": effort, "crept": self.crept, "with_one_axis": self.with_one_axis, "unpressed": self.unpressed, "sheet": sheet, "fault": verdict.fault, "sentence": verdict.sentence, "remedy": verdict.remedy, "step": title, "passed": session.done,
                "acts": bool(rig.get(rig.lock, "function-enable-%d" % function.number)), "commissioned": rig.is_commissioned(function),
                "titles": [entry["title"] for entry in session.log], "sentences": [entry["sentence"] for entry in session.log]}

    def state(self):
        """The rows of plumb doctor --machine."""
        return findings(self.rig(), self.records)

    def work(self, session):
        step = session.step
        for kind, act in ACTS.items():
            if isinstance(step, kind):
                return session.answer(act(self, session, step))
        return session.answer(self.press(step, lambda _turn: None) if step.holds else {})

    def press(self, step, look, turns=20, wait=0.1):
        """Presses, looks at each beat, and lets go. Returns {}."""
        self.presses += 1
        beats = step.rig.beats
        refused = step.begin_press()
        self.unpressed = max(self.unpressed, step.rig.beats - beats - 1)
        if refused is not None:
            step.end_press()
            if isinstance(step, steps.StageMoves):  # whose finish() names it
                return {}
            raise RuntimeError(refused.sentence)
        for turn in range(turns):
            step.beat()
            self.machine.wait(wait)
            look(turn)
            if step.hint == LET_GO:
                break
        step.end_press()
        self.machine.wait(1)
        return {}

    def creeps(self, letter, seconds):
        """How far an axis goes by itself."""
        place = self.place(letter)
        self.machine.wait(seconds)
        return abs(self.place(letter) - place)

    def hold(self, step, letter):
        """Presses for two seconds. Returns the readings of an indicator at an axis."""
        zero, reading = self.place(letter), {}
        self.press(step, lambda _turn: reading.update(pressed=self.place(letter) - zero))
        return {"pressed": 0.0, "released": self.place(letter) - zero, **reading}

    @contextlib.contextmanager
    def watching(self, step):
        """Beats as the programs do while they wait for an answer."""
        ended = []

        def beat():
            while not ended:  # an Event does not know the faster clock
                step.beat()
                time.sleep(0.05)

        thread = threading.Thread(target=beat)
        thread.start()
        try:
            yield
        finally:
            ended.append(True)
            thread.join()


def _stage(robot, session, step):
    return robot.hold(step, session.rig.letter_of(step.stage))


def _other(robot, session, step):
    return robot.hold(step, step.letter)


def _go(robot, line):
    robot.machine.mdi(line)
    robot.machine.wait(1)


def _one_end(robot, session, step):
    _go(robot, "G53 G0 %s%g" % (step.move.letter, robot.ends(step.move.letter)[0] * session.rig.unit))
    return {}


def _other_end(robot, session, step):
    _go(robot, "G53 G0 %s%g" % (step.move.letter, robot.ends(step.move.letter)[1] * session.rig.unit))
    return {}


def _square(robot, step):
    return robot.scenario.square(step.move.direction) - getattr(robot, "square_zero", 0.0)


def _without(robot, session, step):
    _go(robot, "G53 G1 F%g %s%.4f" % (2000 * session.rig.unit, step.move.letter, step.move.end[0]))
    robot.square_zero = 0.0
    robot.square_zero = _square(robot, step)
    _go(robot, "G53 G1 F%g %s%.4f" % (2000 * session.rig.unit, step.move.letter, step.move.start[0]))
    return {"read": _square(robot, step)}


def _with_it(robot, session, step):
    reading = {}
    if type(step) is squareness.WithIt:
        _go(robot, "G53 G1 F%g %s%.4f" % (2000 * session.rig.unit, step.move.letter, step.move.end[0]))
    robot.press(step, lambda _turn: reading.update(read=_square(robot, step)))
    return reading


def _in_air(robot, session, step):
    robot.machine.command.feedrate(0.1)
    robot.machine.command.rapidrate(0.1)
    robot.machine.wait(0.5)

    for axes in ("X", "XYZ"):

        def move(turn, axes=axes):
            if turn == 3:
                robot.machine.mdi("G91 G0 " + " ".join("%s%g" % (axis, -8 * session.rig.unit) for axis in axes), wait=False)

        robot.press(step, move, 40)
        robot.with_one_axis = robot.with_one_axis or step.finish({}).sentence
    robot.machine.mdi("G90")
    robot.machine.command.feedrate(1)
    robot.machine.command.rapidrate(1)
    robot.machine.wait(0.5)
    return {}


def _off_and_on(robot, session, step):
    return robot.press(step, lambda _turn: None, 600)


def _load(robot, session, step):
    _go(robot, "M3 S3000")
    robot.machine.wait(4)
    return {"shown": robot.host.get("drive.load")}


def _place_of_z(robot, session, step):
    _go(robot, "G53 G0 Z-20")
    return {"shown": robot.place("Z")}


def _touch(robot, session, step):
    with robot.watching(step):
        robot.scenario.touch()
    return {}


def _rise(robot, session, step):
    _go(robot, "M5")
    robot.machine.wait(2)
    return robot.hold(step, "Z")


def _stroke(robot, session, step):
    robot.stroke_zero = robot.place("Z")
    places = []
    robot.press(step, lambda _turn: places.append(robot.place("Z") - robot.stroke_zero), 500, 0.02)
    robot.crept = robot.creeps("Z", 5)
    return {"upper": max(places), "lower": min(places)}


def _hold_the_stroke(robot, session, step):
    robot.press(step, lambda _turn: None, 300)
    robot.crept = max(robot.crept, robot.creeps("Z", 5))
    return {}


def _stop(robot, session, step):
    def stop(turn):
        if turn == 20:
            robot.machine.emergency_stop()

    return robot.press(step, stop, 30)


def _on(robot, session, step):
    robot.scenario.before_on()
    robot.machine.turn_on()
    if not all(robot.machine.poll().homed[: robot.machine.status.joints]):
        robot.machine.home()
    robot.machine.wait(2)
    return {}


def _here(robot, session, step):
    _go(robot, "G53 G0 X0 Y0 Z-10")
    return {}


def _there(robot, session, step):
    _go(robot, "G53 G0 X20 Y30 Z0")
    return {}


def _at_r(robot, session, step):
    robot.press(step, lambda _turn: None, 200)
    robot.machine.wait(2)
    return {"read": robot.place("Z") - robot.stroke_zero}


def _warm(robot, session, step):
    return {"shown": robot.scenario.warm(step.sensor)}


def _first(robot, session, step):
    robot.scenario.measure(0.0)
    return {}


def _shim(robot, session, step):
    robot.scenario.measure(SHIM)
    return {"shim": SHIM}


ACTS = {
    steps.OtherJoint: _other, steps.StageMoves: _stage, squareness.Begin: _one_end, squareness.End: _other_end, squareness.WithoutIt: _without,
    squareness.WithItHere: _with_it, steps.InAir: _in_air, steps.OffAndOn: _off_and_on, chopping.Hold: _hold_the_stroke, thermal_displacement.Load: _load, thermal_displacement.Place: _place_of_z, thermal_displacement.Touch: _touch,
    thermal_displacement.VerifyStep: _rise, chopping.Stroke: _stroke, chopping.Stop: _stop, chopping.AgainAtRest: _on, steps.EmergencyStop: _stop,
    chopping.Return: _at_r, thermal_growth_test.Here: _here, thermal_growth_test.There: _there, steps.OnAgain: _on, axis_growth.Warm: _warm, centre_height.First: _first, centre_height.WithShim: _shim, thermal_growth_test.First: _first, thermal_growth_test.Moved: _shim,
}

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of commission_linuxcnc_test and of scripts/bench commission: commissions a function with each fault in its wiring.

    commission_scenario.py FUNCTION FAULT...
"""

import contextlib
import os
import re
import subprocess
import sys
import time
import traceback

import linuxcnc
from plumb_linuxcnc import OperatorError
from scenario import Scenario, run

INCH = 25.4
ORDER = "delf {instance}.update servo-thread; addf {instance}.update servo-thread 1"


class Machine(Scenario):
    """`stage_letters` have a stage at their joints. A fault of a drive is a gain between command and drive."""

    function = instance = ""
    letters = "XYZ"
    plant = {}
    net = ""  # a pin whose net is missing
    measured = ""  # a pin of a measured place of Z
    turning = None  # a setting, and a value of the other sign

    def work(self):
        from commissioning_robot import Robot

        self.robot = Robot(self, self.plant)
        self.facts["table"] = {}
        for fault in sys.argv[2:]:
            self.begin(fault)
            self.facts["table"][fault] = self.with_fault(fault)

        if "terminal" in dir(self):
            self.terminal()

    def with_fault(self, fault):
        self.rest_unhomed()
        undo = getattr(self, "put_" + fault.replace("-", "_"), self.put_nothing)()
        try:
            self.patiently(self.machine.turn_on)
            self.patiently(self.machine.home)
            self.before()
            self.machine.wait(6)  # interlock looks at the wiring, and plumb-retain restores
            found = self.robot.commission(self.function)
            if found["passed"]:
                self.look_at_state(found)
        except Exception as error:  # noqa: BLE001 - it stands in the table
            found = {"fault": "error", "sentence": "%s: %s" % (type(error).__name__, error), "passed": False, "trace": traceback.format_exc()}
        finally:
            self.patiently(self.machine.turn_off)
            for line in undo:
                self.do(line)
            for pin in re.findall(r"interlock\.(?:function|stage)-passed-\d+", subprocess.run(["halcmd", "-s", "show", "pin"], stdout=subprocess.PIPE, text=True, check=True).stdout):
                self.host.set(pin, 0)
        found["after"] = self.host.get("interlock.function-passed-0")
        return found

    def look_at_state(self, found):
        found["state"] = self.robot.state()
        if self.turning:
            pin, value = self.turning
            before = self.host.get(pin)
            self.host.set(pin, value)
            self.machine.wait(6)
            found["state_with_another_sign"] = self.robot.state()
            self.host.set(pin, before)

    def rest_unhomed(self):
        """At 0, where no gain moves anything, and off. A joint that homes where it stands would call another place 0."""
        self.patiently(self.machine.turn_on)
        status = self.machine.poll()
        if not all(status.homed[: status.joints]):
            self.patiently(self.machine.home)
        self.machine.wait(1)
        self.machine.mdi("G53 G0 " + " ".join("%s0" % letter for letter in "XYZ"))
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.turn_off()
        self.machine.command.unhome(-1)
        self.machine.wait_for(lambda status: not any(status.homed), "unhoming")

    def patiently(self, work):
        """Messages about the fault that was put in end nothing."""
        for _turn in range(10):
            try:
                return work()
            except OperatorError:
                pass
        return work()

    def do(self, lines):
        for line in lines.split("; "):
            self.host.command(line)

    def before(self):
        """What a person does first."""

    def before_on(self):
        """After the emergency stop, with the machine still off."""

    # --- faults: each returns the lines that take it back ---

    def put_nothing(self):
        return []

    def gains(self, letter, gain):
        self.do("setp fault-%s-cmd.in1 %r; setp fault-%s-fb.in1 %r" % (letter.lower(), gain, letter.lower(), 1 / gain))

    def put_drive_sign(self):
        self.gains(self.letters[0], -1.0)
        return self.gains_back()

    def put_drive_inch(self):
        self.gains(self.letters[0], 1 / INCH)
        return self.gains_back()

    def put_drive_25(self):
        self.gains(self.letters[0], INCH)
        return self.gains_back()

    def gains_back(self):
        letter = self.letters[0].lower()
        return ["setp fault-%s-cmd.in1 1" % letter, "setp fault-%s-fb.in1 1" % letter]

    def put_drive_swapped(self):
        """The first axis drives the second one, and is measured there."""
        one, other = self.letters[0].lower(), self.letters[1].lower()
        self.do(self.swap(one, other))
        return [self.swap(one, other, back=True)]

    def swap(self, one, other, back=False):
        pairs = ((one, one), (other, other)) if back else ((one, other), (other, one))
        lines = []
        for letter in (one, other):
            lines += ["unlinkp fault-%s-cmd.in0" % letter, "unlinkp fault-%s-fb.out" % letter]
        for signal, letter in pairs:
            lines += ["net %s-motor-cmd fault-%s-cmd.in0" % (signal, letter), "net %s-motor-fb fault-%s-fb.out" % (signal, letter)]
        return "; ".join(lines)

    def put_drive_dead(self):
        letter = self.letters[0].lower()
        self.do("unlinkp fault-%s-cmd.in0" % letter)
        self.do("net %s-motor-cmd spare.in0" % letter)
        self.do("setp fault-%s-cmd.in0 0" % letter)
        self.do("unlinkp fault-%s-fb.out; net %s-motor-fb fault-echo.out" % (letter, letter))
        self.do("net %s-motor-cmd fault-echo.in0" % letter)
        return ["unlinkp fault-echo.out; unlinkp fault-echo.in0; net %s-motor-fb fault-%s-fb.out" % (letter, letter),
                "unlinkp spare.in0; net %s-motor-cmd fault-%s-cmd.in0" % (letter, letter)]

    def put_net(self):
        signal = self.signal_of(self.net)
        self.do("unlinkp " + self.net)
        return ["net %s %s" % (signal, self.net)]

    def signal_of(self, pin):
        """The signal at a pin, by halcmd."""
        shown = subprocess.run(["halcmd", "-s", "show", "pin", pin], stdout=subprocess.PIPE, text=True, check=True).stdout
        for line in shown.splitlines():
            words = line.split()
            if words[4] == pin:
                return words[6]
        raise RuntimeError("%s has no signal" % pin)

    def put_command(self):
        """The function gets the commanded position, not the measured one."""
        signal = self.signal_of(self.measured)
        self.do("unlinkp %s; net %s %s" % (self.measured, self.signal_of("joint.2.motor-pos-cmd"), self.measured))
        return ["unlinkp %s; net %s %s" % (self.measured, signal, self.measured)]

    def put_order(self):
        self.do("delf %s.update servo-thread; addf %s.update servo-thread 1" % (self.instance, self.instance))
        return ["delf %s.update servo-thread" % self.instance, "addf %s.update servo-thread %d" % (self.instance, self.place_in_thread())]

    def place_in_thread(self):
        names = subprocess.run(["halcmd", "-s", "show", "thread"], stdout=subprocess.PIPE, text=True, check=True).stdout.split()
        names = names[5:]
        return names.index("motion-controller") + 1


class Column(Machine):
    function, instance = "squareness", "square"
    plant = {"X": "portal.x-position", "Y": "portal.y-position", "Z": "portal.z-position"}
    net = "square.x-velocity"
    ends = {"Y": (-70, 30)}  # mm: both errors along Y can be seen
    turning = ("square.ec0y", 0.00016)

    def square(self, direction):
        """What an indicator against the blade reads."""
        return self.host.get("portal.truth-%s-error" % direction.lower())

    def put_sign(self):
        self.host.set("square.ec0y", 0.00016)
        return ["setp square.ec0y -0.00016"]

    def put_second_sign(self):
        """The tilt of Y with the smaller error."""
        its = self.host.get("square.ea0y")
        self.host.set("square.ea0y", -its)
        return ["setp square.ea0y %r" % its]

    def put_position(self):
        """The position of X has the wrong sign, which no tilt of this machine shows."""
        signal = self.signal_of("square.x-position")
        self.do("unlinkp square.x-position; setp spare.in1 -1; net %s spare.in0; net turned spare.out square.x-position" % signal)
        self.do("addf spare servo-thread 1")
        return ["delf spare servo-thread; unlinkp square.x-position; unlinkp spare.in0; unlinkp spare.out; net %s square.x-position" % signal]

    def put_other_source(self):
        """Another source of a stage under trial asks for more than the trial."""
        self.do("setp x-stage.offset-1 0.9")
        return ["setp x-stage.offset-1 0"]

    def put_swapped(self):
        self.do("unlinkp x-stage.offset-0; unlinkp y-stage.offset-0; net x-correction y-stage.offset-0; net y-correction x-stage.offset-0")
        return ["unlinkp x-stage.offset-0; unlinkp y-stage.offset-0; net x-correction x-stage.offset-0; net y-correction y-stage.offset-0"]


    def terminal(self):
        """The program itself: by hand, undone, and two steps with a press whose sign is wrong."""
        self.rest_unhomed()
        self.patiently(self.machine.turn_on)
        self.patiently(self.machine.home)
        self.host.set("interlock.function-switch-0", 1)
        self.facts["by_hand_on"] = self.plumb("commission", "squareness", "--by-hand", "--who", "K. Braun")
        self.host.set("interlock.function-switch-0", 0)
        self.facts["by_hand"] = self.plumb("commission", "squareness", "--by-hand", "--who", "K. Braun")
        self.machine.wait(1)
        self.facts["doctor"] = self.plumb("doctor", "--machine")
        self.facts["again"] = self.plumb("commission", "x-stage", "--again", "--who", "K. Braun")
        self.facts["after_again"] = [self.host.get("interlock.%s-passed-%d" % place) == self.host.get("interlock.%s-identity-%d" % place)
                                     for place in (("stage", 0), ("stage", 1), ("function", 0))]
        self.facts["undo"] = self.plumb("commission", "squareness", "--undo")
        self.machine.wait(1)
        self.facts["doctor_undone"] = self.plumb("doctor", "--machine")
        words = [os.path.join(os.environ["BUILD"], "bin", "plumb"), "commission", "squareness", "--who", "H. Meier", "--language", "en"]
        self.facts["terminal"] = self.pressed_and_let_go(words)
        if "The stage itself applied" in self.facts["terminal"][0]:  # the program stood still: see pressing()
            self.facts.setdefault("standstills", []).append("the press ended early")
            self.facts["terminal"] = self.pressed_and_let_go(words)
        self.facts["killed"] = [self.killed(words, delay) for delay in (0, 0.3)]
        self.facts["stopped"] = self.stopped()

    def pressed_and_let_go(self, words):
        """The output of the program and its status."""
        process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        process.stdin.write("\n\npress\n")
        process.stdin.flush()
        try:
            self.await_condition(lambda: abs(self.host.get("x-stage.applied-offset") - 0.01) < 1e-6, "the press")
        except RuntimeError as error:
            process.kill()
            raise RuntimeError("%s: %s" % (error, process.communicate()[0])) from None
        process.stdin.write("let go\n")
        process.stdin.flush()
        self.await_condition(lambda: self.host.get("x-stage.applied-offset") == 0, "the return")
        process.stdin.write("-0.0100\n0\nq\n")
        process.stdin.flush()
        return process.communicate()[0], process.returncode

    def killed(self, words, delay):
        """The program is killed when the joint begins to move, or a moment later: offset and stage of the trial then, and after another beat."""
        process = self.pressing(words)
        time.sleep(delay)
        process.kill()
        process.wait()
        began = self.host.time
        self.await_condition(lambda: self.host.get("x-stage.applied-offset") == 0, "the return")
        took = self.host.time - began
        for turn in range(5):
            self.host.set("interlock.trial-beat", turn % 2)
            self.machine.wait(0.1)
        return took, self.host.get("x-stage.applied-offset"), self.host.get("interlock.trial-stage")

    def pressing(self, words):
        """The program, once the joint moves. interlock ends a trial whose program stood still for half a second: then once more."""
        for last in (False, True):
            process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True)
            process.stdin.write("\n\npress\n")
            process.stdin.flush()
            try:
                self.await_condition(lambda: self.host.get("x-stage.applied-offset") > 0, "the press")
            except RuntimeError as error:
                process.kill()
                process.wait()
                if last:
                    raise
                self.facts.setdefault("standstills", []).append(str(error))
            else:
                return process

    def stopped(self):
        """The emergency stop in the step of +0.010 mm: the offset before, while the machine is off, and on again with the button still pressed."""
        rig = self.robot.rig()
        stage, seen = rig.stages[0], []

        def press(seconds):
            for _turn in range(int(seconds / 0.1)):
                rig.beat()
                self.machine.wait(0.1)
            seen.append(rig.applied(stage))

        rig.begin_press(stage, 0.01)
        press(2)
        self.patiently(self.machine.emergency_stop)
        press(1)
        self.patiently(self.machine.turn_on)
        press(2)
        rig.end_press()
        return seen

    @staticmethod
    def plumb(*words):
        done = subprocess.run([os.path.join(os.environ["BUILD"], "bin", "plumb"), *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        return done.stdout, done.returncode


class Mill(Machine):
    function, instance, letters = "thermal_displacement", "growth", "ZXY"
    plant = {"X": "portal.x-position", "Y": "portal.y-position", "Z": "portal.z-position"}
    net, measured = "growth.load", "growth.z-position"

    def put_driven(self):
        """A signal holds a setting that a step needs."""
        self.do("newsig driven bit; sets driven true; net driven growth.dry-run")
        return ["unlinkp growth.dry-run; delsig driven"]

    def touch(self):
        """The work stands 250 mm below the nose of the spindle as Z is at 0; tool 1 is 50 mm long."""
        for line in ("M3 S3000", "G4 P4", "G53 G0 Z-195", "G53 G1 Z-201 F60", "G4 P0.5", "G53 G0 Z-150"):
            self.machine.mdi(line)
        self.machine.wait(1)

    def before(self):
        self.machine.mdi("T1 M6")

    def put_part(self):
        """The load comes as a part of 1."""
        self.host.set("fault-growth-load.in1", 0.01)
        return ["setp fault-growth-load.in1 1"]

    def put_swapped(self):
        self.do("unlinkp growth.z-position; net x-joint-fb growth.z-position")
        return ["unlinkp growth.z-position; net z-joint-fb growth.z-position"]

    def put_sign(self):
        """The load falls when the spindle works."""
        self.host.set("fault-growth-load.in1", -1.0)
        return ["setp fault-growth-load.in1 1"]


class Grinder(Machine):
    function, instance, letters = "chopping", "chop", "ZXY"
    plant = {"X": "x-drive.out", "Y": "y-drive.out", "Z": "grinder.truth-position"}
    net, measured = "chop.position", "chop.joint-feedback"

    def put_swapped(self):
        self.do("unlinkp z-stage.joint-command; net x-motor-cmd z-stage.joint-command")
        return ["unlinkp z-stage.joint-command; net z-joint-cmd z-stage.joint-command"]


class Lathe(Machine):
    function, instance = "centre_height", "centre"
    net = "centre.x-position-0"
    lands = 0

    def measure(self, shim):
        self.host.set("mux-gen.01.in-float-01", 0.05 + shim)
        self.machine.mdi("G10 L2 P1 Z%g" % (-4 * self.lands))  # fresh ones
        self.lands += 1
        try:  # the function itself refuses some entries, and says why
            self.machine.run("commission_height.ngc")
        except OperatorError as error:
            self.facts.setdefault("refused", []).append(str(error))
        self.machine.wait(1)

    def scale_diameter(self, factor):
        self.host.set("fault-centre-diameter.in1", factor)
        return ["setp fault-centre-diameter.in1 1"]

    def put_inch(self):
        return self.scale_diameter(1 / INCH)

    def put_radius(self):
        return self.scale_diameter(0.5)

    def put_sign(self):
        self.host.set("fault-centre-y-position-0.in1", -1.0)
        return ["setp fault-centre-y-position-0.in1 1"]

    def put_swapped(self):
        self.do("unlinkp centre.x-position-0; unlinkp fault-centre-y-position-0.in0; net y-position centre.x-position-0; "
                "net x-position fault-centre-y-position-0.in0")
        return ["unlinkp centre.x-position-0; unlinkp fault-centre-y-position-0.in0; net x-position centre.x-position-0; "
                "net y-position fault-centre-y-position-0.in0"]


class Growth(Machine):
    function, instance = "thermal_growth_test", "growth-test"
    net, measured = "growth-test.probe", "growth-test.z-position"

    def put_sensor(self):
        """The HAL file of the function leaves its sensors to the user."""
        signal = self.signal_of("growth-test.temperature-2")
        self.do("unlinkp growth-test.temperature-2")
        return ["net %s growth-test.temperature-2" % signal]

    def measure(self, shim):
        self.host.set("artifact.use-replay", 1)
        self.host.set("artifact.replay-x", -shim)  # of the machine, against the artifact
        with contextlib.suppress(OperatorError):
            self.machine.run("commission_bore.ngc")
        self.machine.wait(1)

    def scaled(self, factor):
        self.host.set("fault-growth-test-x-position.in1", factor)
        return ["setp fault-growth-test-x-position.in1 1"]

    def put_sign(self):
        return self.scaled(-1.0)

    def put_inch(self):
        return self.scaled(1 / INCH)

    def put_25(self):
        return self.scaled(INCH)

    def put_swapped(self):
        self.do("unlinkp fault-growth-test-x-position.in0; unlinkp growth-test.y-position; net y-measured fault-growth-test-x-position.in0; "
                "net x-measured growth-test.y-position")
        return ["unlinkp fault-growth-test-x-position.in0; unlinkp growth-test.y-position; net x-measured fault-growth-test-x-position.in0; "
                "net y-measured growth-test.y-position"]


class Grows:
    """axis_growth acts by two temperatures, each of which a hand can warm."""

    def temperature(self, number, gain):
        self.host.set("fault-axis-growth-temperature-%d.in1" % number, gain)

    def warm(self, number):
        """By a fifth. Returns what a thermometer shows."""
        pin = "fault-axis-growth-temperature-%d." % number
        self.temperature(number, 1.2)
        self.machine.wait(1)
        return 1.2 * self.host.get(pin + "in0")


class Axes(Grows, Machine):
    function, instance = "axis_growth", "axis-growth"
    plant = {letter.upper(): "artifact.%s-position" % letter for letter in "xyz"}
    net = "axis-growth.temperature-1"

    def before_on(self):
        """The offsets need 15 s to return: a step waits for 10 s."""
        most = max(abs(self.host.get("axis-growth.%s-offset" % letter)) for letter in "xyz")
        self.host.set("axis-growth.max-rate", most / 15)

    def with_fault(self, fault):
        for number in range(2):
            self.temperature(number, 1)
        return super().with_fault(fault)

    def put_sign(self):
        signal = self.signal_of("axis-growth.temperature-0")
        self.do("unlinkp axis-growth.temperature-0; setp spare.in1 -1; net %s spare.in0; net turned spare.out axis-growth.temperature-0; addf spare servo-thread" % signal)
        return ["delf spare servo-thread; unlinkp axis-growth.temperature-0; unlinkp spare.in0; unlinkp spare.out; net %s axis-growth.temperature-0" % signal]

    def put_swapped(self):
        """The sensors have each other's number."""
        pins = ["fault-axis-growth-temperature-%d.out" % number for number in range(2)]
        lines = ["unlinkp " + pin for pin in pins]
        signals = [self.signal_of(pin) for pin in pins]
        self.do("; ".join([*lines, "net %s %s" % (signals[1], pins[0]), "net %s %s" % (signals[0], pins[1])]))
        return [*lines, *("net %s %s" % pair for pair in zip(signals, pins))]

    def put_unread(self):
        self.do("unlinkp axis-growth.z-offset")
        return ["net z-growth-offset axis-growth.z-offset"]


MACHINES = {its.function: its for its in (Column, Mill, Grinder, Lathe, Growth, Axes)}

if __name__ == "__main__":
    sys.exit(run(MACHINES[sys.argv[1]]))

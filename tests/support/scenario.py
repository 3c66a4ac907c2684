# SPDX-License-Identifier: GPL-2.0-or-later
"""A scenario on a complete LinuxCNC in virtual time, which LinuxCNC starts as its DISPLAY.

    class Shift(Scenario):
        columns = ["scene", "joint.0.pos-cmd"]

        def work(self):
            self.play(self.turn_on, self.cut)
        ...

    sys.exit(run(Shift, recording="shift.csv"))

The recording has a row for each servo cycle, with the number of the scene. In the folder of the INI file facts.json has the
names of the scenes, the facts that the scenario noted, and the messages to the operator. linuxcnc_runs.py reads it.
"""

import contextlib
import json
import os
import subprocess

import linuxcnc
from plumb_linuxcnc import Machine, OperatorError, Overdue

WORKED = 42  # exit status, no one else's
LONGEST = 300  # seconds of the machine's time: a file is read beside it


class Scenario:
    columns = []  # pins of recordings

    def __init__(self, machine):
        self.machine = machine
        self.host = machine.host
        self.scenes = []
        self.facts = {}

    def work(self):
        raise NotImplementedError

    def end(self):
        self.machine.turn_off()

    def play(self, *scenes):
        for scene in scenes:
            self.begin(scene.__name__)
            scene()
            self.rest()

    def begin(self, scene):
        self.scenes.append(scene)
        self.host.set("scene", len(self.scenes))

    def record(self, scene):
        """A recording of one scene, NAME.csv, while the block runs."""
        self.scenes.append(scene)
        return self.machine.recording(scene + ".csv", self.columns)

    @staticmethod
    def processes(*components):
        """The processes that have these components in HAL: inihal is LinuxCNC's task, iocontrol its io."""
        shown = subprocess.run(["halcmd", "-s", "show", "comp", *components], stdout=subprocess.PIPE, text=True, check=True)
        return [int(line.split()[3]) for line in shown.stdout.splitlines() if line]

    def signal(self, number, scene, *components):
        """Begins a scene, in which these processes get a signal. Returns them."""
        processes = self.processes(*components)
        self.begin(scene)
        for process in processes:
            os.kill(process, number)
        return processes

    def await_message(self, words):
        """Waits until the operator has read an error with these words."""
        self.await_condition(lambda: self.machine.poll() and any(words in text for text in self.machine.errors), words)

    def message_of(self, action):
        """Returns what the operator reads in an action and the 20 s after it, of a computer that may be busy."""
        texts = []
        for each in (action, lambda: self.machine.wait_for(lambda status: False, "a message", 20)):
            try:
                each()
            except (OperatorError, Overdue) as error:
                texts.append(str(error))
        return "; ".join(texts)

    def rest(self):
        """Long enough for the drives to come to where they are commanded to 1e-9 mm: 50 ms is 16 time constants."""
        self.machine.wait(0.1)

    def await_pin(self, pin, value):
        self.await_condition(lambda: self.host.get(pin) == value, "%s %s" % (pin, value))

    def await_condition(self, condition, what):
        """Waits for a condition of pins; messages to the operator do not end it."""
        latest = self.host.time + LONGEST
        while not condition():
            if self.host.time > latest:
                raise RuntimeError("%s did not come" % what)
            self.machine.wait(0.005)

    def jog(self, number, distance, speed, is_joint=False):
        """Jogs an axis, or a joint, and waits until LinuxCNC has ended the jog: until then it changes no mode. Messages to the
        operator do not end the wait."""

        def place():
            status = self.machine.poll()
            position, moving = (status.joint_position, status.joint) if is_joint else (status.position, status.axis)
            return position[number], moving[number]["velocity"]

        def is_there():
            position, velocity = place()
            return abs(position - end) < 1e-3 and velocity == 0

        end = place()[0] + distance
        self.machine.command.jog(linuxcnc.JOG_INCREMENT, is_joint, number, speed, distance)
        self.await_condition(is_there, "the end of the jog")


def run(scenario, recording=None, facts="facts.json"):
    """Works through a scenario, in one recording if this has a name; returns the exit status."""
    with Machine() as machine:
        shift = scenario(machine)
        try:
            with machine.recording(recording, shift.columns) if recording else contextlib.nullcontext():
                shift.work()
            if recording:
                shift.end()
        finally:
            with open(facts, "w") as file:
                noted = {"errors": machine.errors, "messages": machine.messages}
                json.dump({"scenes": shift.scenes, "facts": shift.facts, **noted}, file)
    return WORKED

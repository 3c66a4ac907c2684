#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_face_linuxcnc_test: faces that are ground to size, and stopped at each moment."""

import contextlib
import sys

from plumb_linuxcnc import OperatorError, Overdue
from scenario import Scenario, run

WHEELS = 3


class Shift(Scenario):
    columns = [
        "scene",
        "chop.command",
        "chop.infeed-offset",
        "x-stage.applied-offset",
        "joint.0.pos-cmd",
        "chop.program-word",
        "face.truth-face",
    ]

    def work(self):
        self.play(self.turn_on, self.wheels, self.gauge, self.two_strokes, self.dressing)
        moments = {
            "stroke": lambda: self.host.get("chop.velocity") < -40,
            "infeed": lambda: abs(self.deep() / 0.01 - round(self.deep() / 0.01)) > 0.05,
            "spark_out": lambda: self.host.get("chop.sparking-out") == 1,
        }
        stops = {"abort": self.machine.abort, "emergency_stop": self.machine.emergency_stop, "off": self.machine.turn_off}
        for moment, is_there in moments.items():
            for name, stop in stops.items():
                self.stopped("%s_%s" % (name, moment), moment, is_there, stop)

    def deep(self):
        return -self.host.get("chop.infeed-offset")

    def turn_on(self):
        self.machine.turn_on()
        self.machine.home()
        self.await_pin("chop.enabled", 1)

    def new_face(self, seed=0):
        self.machine.mdi("G54 G0 X20")
        self.host.set("face.seed", seed)
        self.host.set("face.fresh", 1)
        self.machine.wait(0.05)
        self.host.set("face.fresh", 0)

    def state(self):
        return [self.host.get("face.truth-" + name) for name in ("face", "wear", "deflection")]

    def wheels(self):
        """Drawn ones: what they leave when the infeed has ended, and after the spark-out strokes."""
        self.facts["wheels"] = []
        for seed in range(WHEELS):
            self.new_face(seed)
            self.machine.start("face.ngc")
            self.await_pin("chop.infeed-done", 0)
            self.await_pin("chop.infeed-done", 1)
            before = self.state()
            self.machine.wait_until_idle()
            self.facts["wheels"].append([before, self.state()])

    def gauge(self):
        self.new_face()
        self.host.set("face.size", -0.2)
        self.machine.run("gauge.ngc")
        self.host.set("face.size", -10)
        self.facts["gauge"] = self.state()

    def two_strokes(self):
        self.new_face()
        self.machine.run("rough_finish.ngc")
        self.facts["two_strokes"] = self.state()

    def dressing(self):
        before = self.machine.poll().g5x_offset[0]
        self.machine.run("dress.ngc")
        self.facts["dressing"] = self.machine.poll().g5x_offset[0] - before
        self.machine.mdi("G10 L2 P1 X0")

    def stopped(self, name, moment, is_there, stop):
        """Then the program once more, to its end."""
        self.new_face()
        self.begin(name)
        self.machine.start("face.ngc")
        deepest = 0.15 if moment == "spark_out" else 0.05
        self.await_condition(lambda: self.deep() > deepest and is_there(), moment)
        deep = self.deep()
        self.begin(name + "_stopped")
        with contextlib.suppress(OperatorError, Overdue):
            stop()
            self.machine.wait(2)
        with contextlib.suppress(OperatorError):
            self.machine.turn_on()
        self.await_pin("chop.active", 0)
        self.machine.wait(1)
        self.facts[name] = [deep, self.deep()]
        self.begin(name + "_again")
        self.machine.run("face.ngc")
        self.facts[name] += self.state()


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

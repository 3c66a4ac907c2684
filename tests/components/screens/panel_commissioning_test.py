# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel: the first power-on by finger, on the virtual-time host."""

import os
import re
import time
import unittest
import zlib

import plumb
from screen import Finger, Screen
from tree import BUILD, own_folder

STAGES = [line for number, axis in enumerate("xy") for line in (
    "net %s-cmd %s-stage.drive-command %s-drive.in" % (axis, axis, axis), "net %s-fb %s-drive.out %s-stage.drive-feedback" % (axis, axis, axis),
    "net %s-place %s-joint.out %s-stage.position %s-stage.joint-command square.%s-position" % (axis, axis, axis, axis, axis),
    "net %s-joint-fb %s-stage.joint-feedback %s-joint.in" % (axis, axis, axis), "net on %s-stage.motion-enabled" % axis,
    "net homed %s-stage.homed" % axis, "net %s-permit interlock.stage-permit-%d %s-stage.permit" % (axis, number, axis), "net %s-correction square.%s-correction %s-stage.offset-0" % (axis, axis, axis),
    "net %s-state %s-stage.state interlock.stage-state-%d" % (axis, axis, number), "net trial interlock.trial %s-stage.trial" % axis, "setp %s-stage.min-limit -100" % axis,
    "setp %s-stage.max-limit 100" % axis, "setp %s-stage.joint-acceleration 2000" % axis, "setp %s-stage.offset-acceleration 1000" % axis,
    "setp %s-drive.gain 1" % axis, "addf %s-stage.update-feedback servo-thread" % axis)]
INPUTS = ("x-velocity", "y-velocity", "z-position", "z-velocity", "x-tool-offset", "y-tool-offset", "z-tool-offset", "path-velocity")
LINES = [
    "loadrt threads name1=servo-thread period1=1000000", "loadrt lowpass names=x-drive,y-drive,x-joint,y-joint",
    "loadrt mux2 names=" + ",".join("of-" + pin for pin in (*INPUTS, "own", "spindle")), "loadrt or2 names=switch,homing,mode", "loadrt conv_bit_s32 names=type",
    "loadrt squareness names=square", "loadrt joint_offset names=x-stage,y-stage", "loadrt interlock names=interlock stages=2",
    "net on switch.out interlock.motion-enabled", "net homed homing.out interlock.all-homed square.all-homed", "setp switch.in0 1", "setp homing.in0 1",
    "net spindle of-spindle.out interlock.spindle-speed", "net coordinated mode.out square.coordinated", "net type type.out square.motion-type",
    "net on square.motion-enabled", "net own of-own.out square.x-backlash-corr square.y-backlash-corr",
    "net square-permit interlock.function-permit-0 square.permit", "net square-state square.state interlock.function-state-0",
    "net stages-ramping interlock.ramping square.stages-ramping", *("net of-%s of-%s.out square.%s" % (pin, pin, pin) for pin in INPUTS),
    "setp interlock.function-stages-0 3", "setp interlock.function-services-0 0", "setp interlock.commissioning true", "setp interlock.trial-limit 0.25",
    "setp square.max-speed 100", *STAGES, "addf switch servo-thread", "addf homing servo-thread", "addf mode servo-thread", "addf square.update servo-thread",
    "addf x-stage.update servo-thread", "addf y-stage.update servo-thread", "addf interlock.update servo-thread", "addf x-drive servo-thread",
    "addf y-drive servo-thread", "start"]


PANEL = os.path.join(BUILD, "bin", "plumb-panel")
PANEL_WITH_AN_ERROR = """
import os, runpy, sys

del sys.argv[0]
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(sys.argv[0])), "share", "plumb"))
from panel.app import Panel

def opened(panel, page, was=Panel.open):
    was(panel, page)
    if page.title == "Changes":
        1 / 0

Panel.open = opened
runpy.run_path(sys.argv[0], run_name="__main__")
"""


class Commissioning(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.screen = Screen(cls)

    def setUp(self):
        self.folder = own_folder(self)
        self.ini = os.path.join(self.folder, "machine.ini")
        with open(self.ini, "w") as file:
            file.write("[EMC]\nMACHINE = test\n[PLUMB]\nACCESS = integrator\n[TRAJ]\nCOORDINATES = XY\nLINEAR_UNITS = mm\n")
        self.begin()

    def begin(self, **options):
        self.host = plumb.Host(options=options)
        self.addCleanup(self.host.close)
        for line in LINES:
            self.host.command(line)

    def panel(self, *options, program=(PANEL,)):
        widgets = os.path.join(self.folder, "panel.widgets")
        words = ["env", "DISPLAY=" + self.screen.display, "NO_AT_BRIDGE=1", "LANGUAGE=", "LC_ALL=C.UTF-8", *program,
                 "--ini", self.ini, "--user", "finger", "--widgets", widgets, "--period", "40"]
        self.host.halcmd("loadusr", *words, *options)
        return Finger(self.screen.display, widgets, self.between)

    def between(self):
        try:
            self.host.run(0.05)
        except plumb.HostDied:
            pass
        time.sleep(0.05)  # no faster than the panel beats

    def retain(self, instance="commissioned", **values):
        """plumb-retain with a store of before it was bound to a computer."""
        values = {name.replace("_", "-").replace("-", ".", 1): value for name, value in values.items()}
        rest = 'machine = "test"\n\n[pins]\n%s\n[records]\n' % "".join('"%s" = %r\n' % item for item in values.items())
        toml = 'machine = "test"\nbound = true\nevery = 0.05\npins = [%s]\n' % ", ".join('"%s"' % name for name in values)
        for name, text in (("machine-id", "0123456789abcdef\n"), (instance + ".toml", toml),
                           (instance + ".retained", "# retain 1, CRC-32 of the rest: %08x\n%s" % (zlib.crc32(rest.encode()), rest))):
            with open(os.path.join(self.folder, name), "w") as file:
                file.write(text)
        self.host.halcmd("loadusr", "-Wn", instance, "env", "XDG_STATE_HOME=" + self.folder, "PLUMB_MACHINE_ID=%s/machine-id" % self.folder,
                         os.path.join(BUILD, "bin", "plumb-retain"), instance, "--file", os.path.join(self.folder, instance + ".toml"))

    def kept(self):
        with open(os.path.join(self.folder, "commissioned.retained")) as file:
            return {name: int(value) for name, value in re.findall(r'^"interlock\.(\S+)" = (\S+)$', file.read(), re.M)}

    def hold(self, finger):
        """Until the stage has moved, and the panel has seen it."""
        finger.hold("Press and hold")
        finger.until(lambda: abs(self.host.get("x-stage.applied-offset") - 0.01) < 1e-6, "the move")
        for _turn in range(8):
            self.between()

    def test_what_passed_on_another_computer_counts_when_the_finger_says_so(self):
        while not self.host.get("interlock.stage-identity-0"):
            self.between()
        identity = self.host.get("interlock.stage-identity-0")
        self.retain(interlock_stage_passed_0=identity)
        self.retain("panel-settings", square_ec0y=0.0002)
        finger = self.panel()
        finger.press("Commissioning")
        finger.await_text("panel-settings: The store does not say from which computer it is, as before it was bound.")
        finger.await_text("stage x-stage has not passed, and is held.")
        self.assertEqual([self.host.get(pin) for pin in ("interlock.stage-passed-0", "square.ec0y")], [0, 0])
        finger.press("It is this machine: take over what passed")
        finger.await_text("What passed counts again on this computer.")
        finger.until(lambda: self.host.get("interlock.stage-passed-0") == identity, "the restored pass")
        self.assertEqual(self.host.get("square.ec0y"), 0.0002, "one answer counts for all stores")

    def test_a_stage_moves_while_the_finger_presses_and_passes_by_its_readings(self):
        self.retain(interlock_stage_passed_0=7, interlock_stage_passed_1=9)
        finger = self.panel()
        finger.press("Commissioning")
        finger.await_text("stage x-stage has not passed, and is held.")
        finger.press("Begin square")
        finger.await_text("commissioned: The store does not say from which computer it is, as before it was bound.")
        finger.press("It is another machine: begin new stores")
        finger.await_text("Replace the stores? You lose what passed, the learned references and the settings of the panel.")
        self.assertEqual(self.kept(), {"stage-passed-0": 7, "stage-passed-1": 9})
        finger.press("Replace the stores")
        finger.await_text("New stores have replaced the old ones.")
        self.take(finger, "panel_state")
        finger.press("Begin square")
        finger.await_text("1/")
        finger.press("Go on")
        finger.await_text("At rest")
        finger.press("Go on")
        finger.await_text("x-stage moves X by +0.010 mm")
        self.hold(finger)
        self.take(finger, "panel_stage")
        finger.let_go()
        finger.until(lambda: self.host.get("x-stage.applied-offset") == 0, "the return")
        for reading in ("-0.010", "0"):
            finger.type(reading)
            finger.press("Enter")
        finger.await_text("The sign is wrong.")
        self.take(finger, "panel_fault")
        self.assertEqual(self.host.get("interlock.stage-passed-0"), 0)
        self.hold(finger)
        finger.let_go()
        for reading in ("0.010", "0"):
            finger.type(reading)
            finger.press("Enter")
        finger.await_text("y-stage moves Y by +0.010 mm")
        self.assertNotEqual(self.host.get("interlock.stage-passed-0"), 0)
        passed = {"stage-passed-0": self.host.get("interlock.stage-passed-0"), "stage-passed-1": 0}
        finger.until(lambda: self.kept() == passed, "the new store")
        finger.press("Give up")
        finger.await_text("function square has not passed, and is held.")
        self.assertEqual(self.host.get("interlock.function-enable-0"), False)

    def test_after_work_on_a_drive_its_stage_is_tried_again_and_its_function_keeps_its_pass(self):
        self.host.set("square.ec0y", 0.0001)
        places = ("stage-%s-0", "stage-%s-1", "function-%s-0")
        while not all(self.host.get("interlock." + place % "identity") for place in places):
            self.between()
        for _turn in range(60):  # interlock looks once a second
            self.between()
        for place in places:
            self.host.set("interlock." + place % "passed", self.host.get("interlock." + place % "identity"))
        passed = [self.host.get("interlock." + place % "passed") for place in places]
        finger = self.panel()
        finger.press("Commissioning")
        finger.await_text("After work on drive, encoder or screw: try again.")
        finger.press("Try x-stage again")
        finger.await_text("Try x-stage again? It is held until it has passed, and its offset returns to 0.")
        self.assertEqual([self.host.get("interlock." + place % "passed") for place in places], passed)
        finger.press("Try again")
        finger.await_text("1/3  Wiring")
        self.assertEqual([self.host.get("interlock." + place % "passed") for place in places], [0, *passed[1:]])
        finger.press("Go on")
        finger.await_text("At rest")
        finger.press("Go on")
        self.hold(finger)
        finger.let_go()
        for reading in ("0.010", "0"):
            finger.type(reading)
            finger.press("Enter")
        finger.await_text("x-stage has passed, and may act.")
        self.assertEqual([self.host.get("interlock." + place % "passed") for place in places], passed)

        finger.press("Try square again")
        finger.press("Try again")
        finger.await_text("Wiring")
        self.assertEqual([self.host.get("interlock." + place % "passed") for place in places], [0, 0, 0])
        finger.press("Go on")
        finger.await_text("At rest")
        self.host.set("square.ec0y", -0.0001)
        for _turn in range(60):
            self.between()
        finger.press("Go on")
        finger.await_text("The wiring or a sign changed meanwhile.")

    def test_a_rotary_axis_of_the_chain_needs_its_nets(self):
        self.host.close()
        self.begin(**{"squareness.chain": "w-A-X-Y.b-Z-t", "squareness.rotary": "A"})
        self.wiring_is_refused("A net is missing, or nothing writes it: square.a-position, square.a-velocity.")

    def test_a_net_to_another_row_of_interlock_is_named(self):
        for line in ("unlinkp x-stage.permit", "unlinkp y-stage.permit", "net x-permit y-stage.permit", "net y-permit x-stage.permit"):
            self.host.command(line)
        self.wiring_is_refused("interlock.stage-permit-0 is netted to y-stage.permit, which has the row 1.")

    def test_a_function_and_a_stage_that_interlock_does_not_hear_are_named(self):
        for pin in ("interlock.function-state-0", "interlock.stage-state-1"):
            self.host.command("unlinkp " + pin)
        self.wiring_is_refused("A net is missing, or nothing writes it: square.state, y-stage.state.")

    def wiring_is_refused(self, words):
        finger = self.panel()
        finger.press("Commissioning")
        finger.press("Begin square")
        finger.press("Go on")
        finger.await_text(words)

    def test_what_the_panel_cannot_draw_it_says(self):
        breaks = os.path.join(self.folder, "breaks.py")
        with open(breaks, "w") as file:
            file.write(PANEL_WITH_AN_ERROR)
        finger = self.panel(program=("GDK_PIXBUF_MODULE_FILE=/dev/null", "/usr/bin/python3", breaks, PANEL))
        finger.press("Commissioning")
        finger.press("Begin square")
        finger.press("Go on")
        finger.await_text("The drawing of this step needs the package librsvg2-common.")
        finger.press("Changes")
        finger.await_text("This page is not complete: the panel has an error of its own (division by zero).")

    def take(self, finger, name):
        """A picture of the panel into the folder PLUMB_PICTURES, if there is one."""
        if os.environ.get("PLUMB_PICTURES"):
            finger.shot(os.path.join(os.environ["PLUMB_PICTURES"], name + ".png"))


if __name__ == "__main__":
    unittest.main()

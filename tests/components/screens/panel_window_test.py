# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb panel in a window on the virtual-time host: fingers press, and HAL answers."""

import json
import math
import os
import time
import unittest

import plumb
from screen import Finger, Screen
from support.growth_tests import PLAN, run_test
from tree import BUILD, ROOT, own_folder

LINES = (
    "loadrt threads name1=servo-thread period1=1000000",
    "loadrt thermal_displacement names=growth interlock=no",
    "loadrt squareness names=square interlock=no chain=w-X-Y.b-Z-C-t",
    "addf growth.update servo-thread",
    "addf square.update servo-thread",
    "start",
)
ALL_FUNCTIONS = (
    "loadrt centre_height names=centre interlock=no",
    "loadrt chopping names=chop interlock=no sections=4",
    "loadrt thermal_growth_test names=test interlock=no",
)
# Buttons to press one after the other, by the page.
DEEPER = {
    "Squareness": ("Measure and set up", "w-X-Y.b-Z-C-t", "Y EA0Y", "Back", "Square and indicator", "Axis Y", "Plunger +X"),
    "Centre height": ("Two lands",),
    "All components": ("growth", "Settings for experts", "window"),
}


class Window(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.screen = Screen(cls)

    def setUp(self):
        self.folder = own_folder(self)
        self.ini = os.path.join(self.folder, "machine.ini")
        with open(self.ini, "w") as file:
            file.write("[EMC]\nMACHINE = test\n[PLUMB]\nACCESS = integrator\n")
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in LINES:
            self.host.command(line)

    def panel(self, *options, name="panel", program=(os.path.join(BUILD, "bin", "plumb-panel"),)):
        widgets = os.path.join(self.folder, name + ".widgets")
        words = ["env", "DISPLAY=" + self.screen.display, "NO_AT_BRIDGE=1", "LANGUAGE=", "LC_ALL=C.UTF-8", "INI_FILE_NAME=" + self.ini,
                 *program, "--user", name, "--widgets", widgets, "--period", "20"]
        self.host.halcmd("loadusr", *words, *options)
        return Finger(self.screen.display, widgets, self.between)

    def panel_with(self, values):
        """One that takes these values of outputs in the place of those that the component has; see show()."""
        self.show(values)
        return self.panel(program=("/usr/bin/python3", os.path.join(ROOT, "scripts", "panel_with_values.py"), self.values_file(), BUILD))

    def show(self, values):
        with open(self.values_file() + ".new", "w") as file:
            json.dump(values, file)
        os.replace(self.values_file() + ".new", self.values_file())

    def values_file(self):
        return os.path.join(self.folder, "values.json")

    def between(self):
        try:
            self.host.run(0.05)
        except plumb.HostDied:
            pass
        time.sleep(0.01)

    def test_a_setting_is_changed_by_the_finger_alone(self):
        finger = self.panel()
        finger.press("All components")
        finger.press("growth")
        finger.press("tolerance")
        for _ in range(6):
            finger.press("Delete")
        finger.type("0.004")
        finger.press("Save")
        finger.until(lambda: self.host.get("growth.tolerance") == 0.004, "growth.tolerance = 0.004")
        finger.await_text("growth.tolerance is now 0.004 mm.")
        finger.press("Undo the last change")
        finger.await_text("Undone: growth.tolerance 0.002 mm again.")
        self.assertEqual(self.host.get("growth.tolerance"), 0.002)
        finger.press("Clear")
        finger.type("-1")
        finger.press("Save")
        finger.await_text("growth.tolerance: \u22121 mm is out of range: at least 0 mm.")
        self.assertEqual(self.host.get("growth.tolerance"), 0.002)

    def test_a_pin_that_gets_a_net_is_no_setting_any_more(self):
        finger = self.panel()
        finger.press("All components")
        finger.press("growth")
        self.assertFalse(finger.find_text("Inputs from signals"))
        self.host.command("net of-another-screen growth.tolerance")
        finger.await_text("Inputs from signals (1)")

    def test_who_may_only_look_changes_nothing(self):
        finger = self.panel("--access", "view")
        finger.press("Growth of Z")
        finger.press("Learn from the next part")
        finger.await_text('This screen has the access "view"')
        self.assertFalse(self.host.get("growth.learn"))

    def test_who_may_only_look_stops_and_holds_strokes_and_switches_off_whatever_the_log_is(self):
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread", "setp chop.upper 5", "setp chop.lower -25", "setp chop.position 10",
                     "setp chop.feed 100", "setp chop.min-limit -100", "setp chop.max-limit 100", "setp chop.motion-enabled 1", "setp chop.homed 1",
                     "setp chop.stop-kind 2", "setp chop.run 1"):
            self.host.command(line)
        for name in ("panel_changes.log", "panel_changes.log.lock"):
            os.mkdir(os.path.join(self.folder, name))  # no panel can write them
        finger = self.panel("--access", "view")
        finger.press("Chopping")
        finger.await_text("The axis strokes.")
        finger.press("Hold / go on")
        finger.until(lambda: self.host.get("chop.feed-hold"), "the hold")
        finger.await_text("The change could not be logged: ")
        finger.press("Hold / go on")
        finger.await_text('This screen has the access "view"')
        self.assertTrue(self.host.get("chop.feed-hold"))
        self.host.command("setp chop.feed-hold 0")
        finger.rest()
        finger.press("Stop strokes")
        finger.until(lambda: not self.host.get("chop.active"), "the stop")
        finger.press("Switch on / off")
        finger.await_text("Switch Chopping off?")
        finger.press("Switch off")
        finger.until(lambda: not self.host.get("chop.enable"), "off")
        finger.await_text("The change could not be logged: ")
        finger.press("Switch on / off")
        finger.await_text('This screen has the access "view"')
        self.assertFalse(self.host.get("chop.enable"))

    def test_a_button_that_moves_is_refused_with_the_reason_and_asks_once(self):
        finger = self.panel("--access", "operator")
        finger.press("Growth of Z")
        finger.await_text("Switched off. Switch it on.")
        self.assertEqual(self.leading(finger), ["Switch on / off"])
        finger.press("Switch on / off")
        finger.await_text("LinuxCNC's motion is not loaded.")
        finger.press("Learn from the next part")  # which moves nothing
        finger.press("Cancel")
        self.assertFalse(self.host.get("growth.learn"))
        finger.press("Learn from the next part")
        finger.press("Learn")
        finger.until(lambda: self.host.get("growth.learn"), "growth.learn")

    def leading(self, finger):
        """The buttons that stand out: those which end the status of the function."""
        finger.rest()
        return [each["name"] for each in finger.widgets() if each.get("main")]

    def test_a_component_that_is_unloaded_and_a_value_that_is_not_a_number_are_said(self):
        finger = self.panel()
        finger.press("Squareness")
        self.host.command("stop")
        self.host.command("unloadrt squareness")
        finger.until(lambda: not finger.find("Squareness"), "the page of squareness to go")
        self.host.command("net growth-nan growth.load")
        self.host.set("growth-nan", float("nan"))
        self.host.command("start")
        finger.press("All components")
        finger.await_text("A fault is active. The load is invalid.")

    def test_looks_at_the_pins_keep_no_memory(self):
        program = os.path.join(ROOT, "tests", "programs", "panel_memory.py")
        done = self.host.halcmd("loadusr", "-w", "/usr/bin/python3", program, os.path.join(ROOT, "components", "screens"))
        self.assertEqual(done.status, 0, done.output)

    def test_the_page_of_a_growth_test_shows_state_and_remaining_time(self):
        for line in ("loadrt thermal_growth_test names=test interlock=no sensors=2", "addf test.update servo-thread", "setp test.running 1"):
            self.host.command(line)
        finger = self.panel()
        finger.press("Growth test")
        finger.await_text("The machine warms between two passes.")
        finger.await_text("4.0 h \u2013 12.0 h")
        self.host.command("setp test.temperature-valid-1 0")
        finger.await_text("\u2716 1: 20 \u00b0C")
        for line in ("temperature-valid-1 1", "pass-running 1"):
            self.host.command("setp test." + line)
        self.host.run(1)
        self.host.command("setp test.running 0")
        finger.await_text("The test was interrupted.")
        finger.until(lambda: "Remaining: \u2013" in [each["name"] for each in finger.widgets()], "no time that remains")
        finger.press("Write growth_plan.ngc")
        finger.await_text("Choose how long the test may last.")
        finger.press("Plan 4 h")
        finger.await_text("growth on another day: \u00b1")
        finger.await_text("For a usual machine")
        finger.press("Write growth_plan.ngc")
        finger.await_text("The next test of planned.ngc has these cycles.")
        finger.press("Write the plan")
        path = os.path.join(os.path.dirname(self.ini), "growth_plan.ngc")
        finger.until(lambda: os.path.exists(path), "the file")
        with open(path, encoding="ascii") as file, open(os.path.join(ROOT, "configs", "growth", "growth_plan.ngc"), encoding="ascii") as shipped:
            self.assertEqual(file.read(), shipped.read())

    def test_plan_and_report_of_the_last_log_are_made_by_the_finger(self):
        logs = os.path.join(self.folder, "logs")
        os.mkdir(logs)
        run_test(logs, 3, plan=PLAN)
        self.host.command("loadrt thermal_growth_test names=test interlock=no")
        finger = self.panel()
        finger.press("Growth test")
        finger.press("Plan 2 h")
        finger.await_text("For the machine of growth-3.csv.")
        finger.press("Make and open the report")
        finger.await_text("The report of growth-3.csv is %s." % os.path.join(self.folder, "report", "report.html"))
        with open(os.path.join(self.folder, "report", "report.html"), encoding="utf-8") as page:
            self.assertIn("simulated 3", page.read())
        os.rename(logs, logs + "-gone")
        finger.press("Make and open the report")
        finger.await_text(logs + ": ")  # where it looked

    def test_a_shift_of_contacts_is_answered_by_the_finger(self):
        not_growth, growth = (self.host.expect("given == 0", given="growth.shift-is-" + answer) for answer in ("not-growth", "growth"))
        asks = {"growth.shift-size": 0.03, "growth.unanswered-code": 2, "growth.doubt": True, "growth.enable": True, "growth.cycle-running": True,
                "motion.motion-enabled": True, "motion.is-all-homed": True, "task.alive": True, "task.program": "running"}
        finger = self.panel_with(asks)
        finger.press("Growth of Z")
        finger.await_text("Contacts have moved by +30.0 \u00b5m at once. What is it? If nobody answers, the next part waits.")
        finger.await_text("The reference follows, and Z does not move.")
        finger.await_text("The spindle has grown. It moves: Z +30.0 \u00b5m.")
        finger.press("It is growth")
        finger.await_text("Correct it: refused. A program runs.")
        finger.press("It is not growth")
        finger.await_text("Change the reference by +30.0 \u00b5m?")
        finger.press("Cancel")
        self.show({**asks, "growth.wait": True})  # the program waits for the answer
        finger.rest()
        finger.press("It is growth")
        finger.await_text("Correct the shift as growth? It moves: Z +30.0 \u00b5m.")
        self.assertEqual(self.answers(), set())
        finger.press("Correct it")
        finger.until(lambda: self.answers() == {growth}, "the answer")
        finger.until(lambda: not self.host.get("growth.shift-is-growth"), "the end of the pulse")
        finger.press("It is not growth")
        finger.press("Change the reference")
        finger.until(lambda: self.answers() == {growth, not_growth}, "the other answer")
        self.show({**asks, "growth.shift-size": -0.018, "growth.shift-tool": 5})
        finger.await_text("Tool 5 has cut shallower by 18.0 \u00b5m since ")
        finger.until(lambda: not finger.find("It is growth"), "only the answer that is possible")
        self.assertTrue(finger.find("It is not growth"))
        self.show(asks)
        finger.until(lambda: finger.find("It is growth"), "both answers for all tools")
        self.show({})
        finger.until(lambda: not finger.find("It is growth"), "the end of the question")

    def test_a_question_that_has_changed_is_asked_again(self):
        on = {"motion.motion-enabled": True, "motion.is-all-homed": True, "motion.motion-type": 0, "task.alive": True, "task.program": "idle"}
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread"):
            self.host.command(line)
        given = self.host.expect("given == 0", given="chop.go-to-end")
        finger = self.panel_with({**on, "chop.offset": 0.5})
        finger.press("Chopping")
        finger.press("To point R")
        finger.await_text("Move the axis to point R? It moves: the stroking axis \u2212500.0 \u00b5m.")
        self.show({**on, "chop.offset": 30.0})
        finger.rest()
        finger.press("Move the axis")
        finger.await_text("The question has changed. Move the axis to point R? It moves: the stroking axis \u221230 mm.")
        self.assertEqual(self.answers(), set())
        finger.press_answer("Move the axis")
        finger.until(lambda: self.answers() == {given}, "the order")

    def test_an_operator_reads_measure_only_and_no_pin_names(self):
        for access, named in (("operator", False), ("integrator", True)):
            finger = self.panel("--access", access, name=access)
            finger.press("Growth of Z")
            finger.await_text("Load of the spindle or Z motor")
            finger.until(lambda finger=finger: finger.find("Measure only on / off"), "the button")
            self.assertEqual(bool(finger.find_text("z-position")), named)
            self.assertFalse(finger.find_text("ry run"))
            finger.end()

    def test_growth_without_a_contact_is_unknown(self):
        finger = self.panel_with({"growth.growth-known": False})
        finger.press("Growth of Z")
        finger.until(lambda: {"Growth: unknown", "Uncertainty (k=2): unknown"} <= {each["name"] for each in finger.widgets()}, "no growth that is known")
        self.show({"growth.growth-known": True, "growth.growth-estimate": 0.012})
        finger.until(lambda: "Growth: +12.0 \u00b5m" in [each["name"] for each in finger.widgets()], "the growth")

    def test_a_panel_that_outlives_linuxcnc_says_so(self):
        finger = self.panel_with({"motion.motion-enabled": True, "task.alive": True, "task.program": "idle"})
        finger.press("All components")
        self.show({"motion.motion-enabled": True, "task.alive": False})
        finger.await_text("LinuxCNC's task does not answer. Has LinuxCNC ended?")
        self.show({})
        finger.await_text("LinuxCNC has ended: these values are old.")
        self.show({"motion.motion-enabled": True, "task.alive": True, "task.program": "idle"})
        finger.until(lambda: not finger.find_text("these values are old"), "the message to go")

    def test_a_change_of_the_origin_gets_its_reason_by_the_finger(self):
        finger = self.panel_with({"growth.origin-change": 0.008, "growth.doubt": True, "growth.enable": True, "motion.motion-enabled": True,
                                   "motion.is-all-homed": True})
        finger.press("Growth of Z")
        finger.await_text("Work offset or tool length of Z has changed by +8.0 \u00b5m. Why?")
        for pin, name in (("zero", "New zero, or tool measured"), ("growth", "Growth corrected by hand"), ("depth", "Another depth")):
            given = self.host.expect("given == 0", given="growth.change-is-" + pin)
            finger.press(name)
            finger.await_text(name + ": is that right?")
            finger.press_answer(name)
            finger.until(lambda: given in self.answers(), "the answer")
        self.show({})
        finger.until(lambda: not finger.find("Another depth"), "the end of the question")

    def answers(self):
        """Those that were given in a period."""
        return {each.id for each in self.host.violations()}

    def test_strokes_are_held_at_once_and_go_on_after_a_question(self):
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread", "setp chop.upper 5", "setp chop.lower -25",
                     "setp chop.section-0-kind 2", "setp chop.section-0-from -20", "setp chop.section-0-to -5", "setp chop.section-0-ratio 0.5"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Chopping")
        finger.press("Hold / go on")
        finger.until(lambda: self.host.get("chop.feed-hold"), "the hold")
        finger.press("Hold / go on")
        finger.await_text("Go on with the strokes?")
        self.assertTrue(self.host.get("chop.feed-hold"))
        finger.press("Go on")
        finger.until(lambda: not self.host.get("chop.feed-hold"), "the end of the hold")
        finger.press("Faster")
        finger.until(lambda: self.host.get("chop.override") == 1.05, "the faster stroke")
        finger.await_text("105 %")

    def test_strokes_and_a_section_by_pins_and_one_undo_takes_the_section_back(self):
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread", "setp chop.position 10", "setp chop.min-limit -100",
                     "setp chop.max-limit 100", "setp chop.motion-enabled 1", "setp chop.homed 1"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        for name in ("Chopping", "Sections", "Section 1", "From, mm"):
            finger.press(name)
        finger.type("-20")
        finger.press("To, mm")
        finger.type("-5")
        finger.press("Save")
        finger.until(lambda: self.host.get("chop.section-0-kind") == 2, "the section")
        finger.await_text("\u221220 mm to \u22125 mm, 50 % of the speed, both ways")
        self.assertEqual(self.host.get(["chop.section-0-from", "chop.section-0-to", "chop.section-0-ratio"]), [-20, -5, 0.5])
        finger.press("Section 1")
        finger.await_text("Heights in the frame of the joint")
        self.host.command("setp chop.section-0-kind 3")  # by another screen
        finger.press("Remove")
        finger.await_text("chop.section-0-kind was changed meanwhile: it was 2 and is 3.")
        self.host.command("setp chop.section-0-kind 2")
        finger.press("Back")
        finger.press("Back")
        finger.press("Ends and start")
        finger.press("Upper dead point here")
        finger.press("Lower dead point, mm")
        finger.type("-30")
        finger.press("Largest speed, mm/min")
        finger.type("3000")
        finger.press("Start the strokes")
        finger.await_text("LinuxCNC's motion is not loaded.")
        self.assertFalse(self.host.get("chop.active"))
        finger.press("Changes")
        finger.press("Undo chop.section-0-kind")
        finger.press("Undo")
        finger.until(lambda: self.host.get("chop.section-0-kind") == 0, "no section")
        self.assertEqual(self.host.get(["chop.section-0-from", "chop.section-0-to", "chop.section-0-ratio"]), [0, 0, 1])

    def test_a_page_shows_the_sections_that_there_are(self):
        for line in ("loadrt chopping names=none,one interlock=no sections=0,1", "addf none.update servo-thread"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Chopping none")
        finger.until(lambda: finger.find("Hold / go on"), "the page")
        self.assertFalse(finger.find("Sections"))
        finger.press("Chopping one")
        finger.press("Sections")
        finger.until(lambda: finger.find("Section 1"), "the section")
        self.assertFalse(finger.find("Section 2"))

    def test_the_second_half_of_a_double_press_is_no_order(self):
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Growth of Z")
        finger.press("Learn from the next part")
        finger.await_text("The machine must be cold")
        finger.press_twice("Cancel")  # the page comes under the finger
        finger.rest()
        self.assertFalse(self.host.get("growth.learn"))
        finger.press("Chopping")
        finger.press_twice("Hold / go on")  # at once on, and no question whether to go on
        finger.until(lambda: self.host.get("chop.feed-hold"), "the hold")
        finger.rest()
        self.assertFalse(finger.find_text("Go on with the strokes?"))
        finger.press("Faster")
        finger.press("Faster")
        finger.until(lambda: abs(self.host.get("chop.override") - 1.1) < 1e-9, "two steps by two presses")

    def test_a_press_while_the_page_changes_is_no_order_on_the_new_page(self):
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Chopping")
        finger.rest()
        hold = finger.find("Hold / go on")
        finger.press("Overview")
        finger.rest()
        finger.press_places(finger.find("Chopping"), hold)  # where the other page has another thing, or nothing
        finger.rest()
        self.assertTrue(finger.find("Hold / go on"), "the new page")
        self.assertFalse(self.host.get("chop.feed-hold"))
        finger.press("Hold / go on")
        finger.until(lambda: self.host.get("chop.feed-hold"), "the hold")

    def test_moves_that_have_changed_are_asked_again(self):
        self.set_square("setp square.axis-direction 0", "setp square.ea0y -0.0001", "setp square.z-position 100", "setp square.all-homed 1",
                        "setp square.enable 1", "setp square.max-rate 5")
        finger = self.panel()
        self.host.run(2)
        for name in ("Squareness", "All pins and settings", "ea0y", "Clear"):
            finger.press(name)
        finger.type("0")
        finger.press("Save")
        announced = finger.await_text("It moves: ")
        self.host.command("setp square.z-position -200")
        self.host.run(2)
        finger.press_answer("Save")
        again = finger.await_text("The moves have changed.")
        self.assertNotEqual(announced, again)
        self.assertEqual(self.host.get("square.ea0y"), -0.0001)
        finger.press_answer("Save")
        finger.until(lambda: self.host.get("square.ea0y") == 0, "the angle")

    def test_a_setting_in_a_motion_and_a_question_under_an_emergency_stop_write_nothing(self):
        self.set_square("setp square.axis-direction 0", "setp square.ea0y -0.0001", "setp square.z-position 100", "setp square.all-homed 1",
                        "setp square.enable 1", "setp square.max-rate 5")
        self.host.run(2)
        on = {"motion.motion-enabled": True, "motion.is-all-homed": True, "motion.motion-type": 0, "task.alive": True, "task.program": "idle"}
        finger = self.panel_with({**on, "motion.motion-type": 2})
        for name in ("Squareness", "All pins and settings", "ea0y", "Clear"):
            finger.press(name)
        finger.type("0")
        finger.press("Save")
        finger.await_text("Save: refused. An axis moves.")
        self.show(on)
        finger.rest()
        finger.press("Save")
        finger.await_text("It moves: ")
        self.show({**on, "task.program": "running"})
        finger.rest()
        finger.press_answer("Save")
        finger.await_text("Save: refused. A program runs.")
        self.assertEqual(self.host.get("square.ea0y"), -0.0001)
        self.host.command("setp square.enable 0")
        self.show(on)
        finger.press("Squareness")
        finger.press("Switch on / off")
        finger.await_text("Switch Squareness on?")
        self.show({**on, "motion.motion-enabled": False})
        finger.rest()
        finger.press_answer("Switch on")
        finger.await_text("Switch on: refused. The machine is off.")
        self.assertFalse(self.host.get("square.enable"))

    def test_two_panels_at_once_and_the_second_one_sees_what_the_first_one_did(self):
        first = self.panel(name="first")
        for name in ("All components", "growth", "Settings for experts", "window", "Clear"):
            first.press(name)
        first.type("0.25")
        second = self.panel("--size", "1000x700", name="second")  # before the first one
        for name in ("All components", "growth", "Settings for experts", "window", "Clear"):
            second.press(name)
        second.type("0.3")
        second.press("Save")
        second.until(lambda: self.host.get("growth.window") == 0.3, "the setting of the second one")
        second.end()
        first.press("Save")
        first.await_text("was changed meanwhile by second")
        self.assertEqual(self.host.get("growth.window"), 0.3)

    def test_linuxcnc_that_ends_under_a_question_is_said_and_nothing_is_written(self):
        finger = self.panel("--access", "operator")
        finger.press("Growth of Z")
        finger.press("Learn from the next part")
        finger.await_text("The machine must be cold")
        self.host.command("stop")
        self.host.command("unloadrt thermal_displacement")
        finger.until(lambda: not finger.find("Growth of Z"), "the page to go")
        self.assertFalse(finger.find("Learn"), "the question of a page that is gone")

    def test_strokes_end_by_pins_alone(self):
        """No LinuxCNC is here: neither task nor io lives."""
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread", "setp chop.upper 5", "setp chop.lower -25", "setp chop.position 10",
                     "setp chop.feed 100", "setp chop.min-limit -100", "setp chop.max-limit 100", "setp chop.motion-enabled 1", "setp chop.homed 1",
                     "setp chop.stop-kind 2", "setp chop.run 1"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Chopping")
        finger.await_text("The axis strokes.")
        finger.press("Stop strokes")
        finger.until(lambda: not self.host.get("chop.active"), "the stop")
        self.assertNotEqual(self.host.get("chop.offset"), 0)
        finger.await_text("The axis stands away from point R.")
        self.assertEqual(self.leading(finger), ["To point R"])
        finger.until(lambda: not self.host.get("chop.stop"), "the end of the pulse")
        self.host.command("setp chop.go-to-end 1")  # and it stays, as a screen leaves it that ends meanwhile
        finger.until(lambda: self.host.get("chop.at-end"), "the axis at R")
        self.host.command("setp chop.run 0")
        self.host.run(0.1)
        self.host.command("setp chop.run 1")
        finger.await_text("The axis strokes.")
        finger.press("To point R")
        finger.press("Move the axis")
        finger.await_text("At rest at point R.")
        self.assertEqual(self.leading(finger), ["Ends and start"])
        self.assertEqual(self.host.get("chop.offset"), 0)
        self.assertTrue(self.host.get("chop.run"))

    def open_chain(self, finger, chain):
        finger.press("Squareness")
        finger.press("Measure and set up")
        finger.press(chain)

    def set_square(self, *more):
        with open(self.ini, "a") as file:
            file.write("[SQUARENESS]\nCHAIN = w-X-Y.b-Z-C-t\n")
        for line in ("setp square.max-speed 100", "setp square.ea0z 0.00002", "setp square.eb0x -0.00003", "setp square.axis-direction 1", *more):
            self.host.command(line)

    def test_the_chains_of_a_choice_have_the_axes_of_the_machine(self):
        self.set_square()
        finger = self.panel()
        finger.press("Squareness")
        finger.press("Measure and set up")
        finger.until(lambda: finger.find("b-X-Y-Z-C-t"), "a chain of X, Y and Z")
        self.assertFalse(finger.find("w-X.b-W-Y-Z-C-t"))
        finger.await_text("For a chain with another axis, such as W, change [SQUARENESS]CHAIN")

    def enter_lean(self, finger, lean, direction, angle):
        finger.press(lean)
        finger.press(direction)
        finger.type(angle)
        finger.press("Enter")

    def test_a_saved_lean_changes_that_lean_and_undo_takes_the_whole_save_back(self):
        self.set_square()
        finger = self.panel()
        self.open_chain(finger, "w-X-Y.b-Z-C-t")
        self.enter_lean(finger, "Y EA0Y", "Y leans to +Z", "0.03")
        finger.press("What it will do")
        finger.press("Test move")
        finger.await_text("4. Test move, and save")
        self.host.command("setp square.ea0y 0.00002")  # by another screen
        finger.press("Save")
        finger.press("Save the angles")
        finger.await_text("square.ea0y was changed meanwhile: it was 0 rad and is 0.00002 rad.")
        finger.await_text("over 1 m before: +80.0 \u00b5m")  # what it will do now
        self.assertEqual(self.angles(), [0.00002, 0])
        self.host.command("setp square.ea0y 0")
        self.open_chain(finger, "w-X-Y.b-Z-C-t")
        self.enter_lean(finger, "Y EA0Y", "Y leans to +Z", "0.03")
        self.enter_lean(finger, "X EC0X", "X leans to +Y", "0.015")
        finger.press("Measured with the correction off: replace the present angle")
        finger.press("What it will do")
        finger.await_text("EA0Y  100 \u00b5m/m to +Z")
        finger.press("Test move")
        finger.press("Save")
        finger.press("Save the angles")
        finger.until(lambda: self.angles() == [0.0001, 0.00005], "the saved angles")
        finger.await_text("Saved: ")
        self.assertEqual(self.others(), [0.00002, -0.00003, True])
        finger.press("Changes")
        finger.press("Undo square.ec0x")
        finger.await_text("Undo 2 changes")
        finger.press("Undo")
        finger.until(lambda: self.angles() == [0, 0], "both angles as before")
        self.assertEqual(self.others(), [0.00002, -0.00003, True])

    def angles(self):
        return self.host.get(["square.ea0y", "square.ec0x"])

    def others(self):
        return self.host.get(["square.ea0z", "square.eb0x", "square.axis-direction"])

    def measure(self, name, text):
        with open(os.path.join(self.folder, name), "w") as file:
            file.write(text)

    def test_a_square_of_a_table_in_x_and_y_corrects_with_its_uncertainty(self):
        self.set_square("setp square.axis-direction 0")
        self.measure("x.csv", "# u: EXX 0.5e-3, EXX+ 0.1e-3\nX,EXX+,EXX-,EYX\n0,-0.005,0.005,0\n800,-0.005,0.005,0\n# end, 2 rows\n")
        for state, opening in (("off", 1e-4), ("on", 1e-5)):
            rows = "".join("%d,%.6f\n" % (angle, 100 - opening * 50 * math.sin(math.radians(2 * angle))) for angle in range(360))
            for direction in ("CW", "CCW"):
                head = "".join("# %s: %s\n" % each for each in (("plane", "XY"), ("radius", 100), ("feed", 1000), ("direction", direction), ("object", "part"), ("correction", state)))
                self.measure("%s_%s.csv" % (state, direction), head + "angle,radius\n" + rows)
        with open(self.ini, "a") as file:
            file.write("TABLE = %s\n" % os.path.join(self.folder, "x.csv"))
            file.writelines("[AXIS_%s]\nMIN_LIMIT = %d\nMAX_LIMIT = %d\n" % limits for limits in (("X", 0, 800), ("Y", 0, 600), ("Z", -500, 0)))
        finger = self.panel()
        self.open_chain(finger, "w-X-Y.b-Z-C-t")
        finger.await_text("Y turns all that it carries with it")
        self.assertFalse(finger.find("Y EC0Y"), "a lean that corrects nothing is offered")
        for name in ("Square and indicator", "Axis Y", "Plunger +X", "Indicator reads more, \u00b5m"):
            finger.press(name)
        finger.type("48")
        finger.press("Enter")
        finger.press("What it will do")
        finger.await_text("after: 0 \u00b19.4 \u00b5m (k=2), straightness not included")
        finger.await_text("X\u2013Z: not measured now")
        for name in ("Test move", "Save", "Save the angles", "Tables and uncertainty"):
            finger.press(name)
        # The square is known, and set two angles; the two others have another source.
        finger.await_text("After correction at least \u00b1 ")
        finger.await_text("errors are unknown.")
        finger.await_text("measured: EC0X (square, ")
        finger.await_text("corner XZ   unknown   EB0X, without u; measure: square and indicator")
        finger.await_text("PPP, 1118 mm: ")
        finger.until(lambda: finger.find("Table of EXX"), "the plot")
        finger.await_text("EXX   \u00b11 \u00b5m (k=2)")
        finger.await_text("EYX   no uncertainty given")
        finger.until(lambda: finger.find("Circle XY: before") and finger.find("Circle XY: after"), "the circles")
        finger.await_text("before: largest 5 \u00b5m; corner 100 \u00b1")
        finger.await_text("after: largest 0.5 \u00b5m")
        finger.press("Back")
        for name in ("ea0z", "eb0x"):
            self.host.command("setp square.%s 0" % name)
        self.measure("x.csv", "# u: EXX 0.5e-3, EXX+ 0.1e-3, EYX 1e-6\nX,EXX+,EXX-,EYX\n0,-0.005,0.005,0\n800,-0.005,0.005,0\n# end, 2 rows\n")
        finger.press("Tables and uncertainty")
        finger.await_text("After correction at least \u00b1 ")
        finger.await_text("worst at X ")
        finger.await_text("Largest share: measurement 1, ")
        finger.await_text("Corners, from the known causes alone:")
        finger.await_text("up to 5 \u00b5m of lost motion add")
        finger.press("Back")
        self.measure("x.csv", "X,EXX\n")
        finger.press("Tables and uncertainty")
        finger.await_text("x.csv")
        self.assertFalse(finger.find("Table of EXX"))

    def test_nothing_is_switched_on_between_a_new_chain_and_the_next_start(self):
        self.set_square("setp square.axis-direction 0")
        os.chmod(self.ini, 0o664)
        finger = self.panel()
        self.open_chain(finger, "b-X-Y-Z-C-t")
        self.enter_lean(finger, "Y EC0Y", "Y leans to +X", "0.03")
        for name in ("What it will do", "Test move", "Save", "Save the angles"):
            finger.press(name)
        finger.await_text("The chain b-X-Y-Z-C-t is saved, and LinuxCNC runs with w-X-Y.b-Z-C-t: start LinuxCNC again.")
        with open(self.ini) as file:
            self.assertIn("CHAIN = b-X-Y-Z-C-t", file.read())
        self.assertEqual(os.stat(self.ini).st_mode & 0o777, 0o664)
        finger = self.panel(name="second")  # before the first one; it reads the changed file, and the list of changes
        finger.press("Squareness")
        finger.await_text("LinuxCNC runs with w-X-Y.b-Z-C-t")
        finger.press("Switch on / off")
        finger.await_text("Switch on: refused. The chain b-X-Y-Z-C-t is saved")
        finger.press("All components")
        finger.press("square")
        finger.press("Inputs without a signal")
        finger.press("enable")
        finger.press("Switch on")
        finger.await_text("refused. The chain b-X-Y-Z-C-t is saved")
        self.assertFalse(self.host.get("square.enable"))
        finger.press("Changes")
        finger.press("Undo [SQUARENESS]CHAIN")
        finger.press("Undo")
        finger.until(lambda: self.host.get("square.ec0y") == 0, "the angle of before")
        with open(self.ini) as file:
            self.assertIn("CHAIN = w-X-Y.b-Z-C-t", file.read())

    def restore(self, coordinate):
        """A reference of one contact, as plumb-retain or a cycle would make it."""
        row = {"operation": 10, "tool": 1, "occurrence": 1, "feed": -2, "feed-override": 1, "time-constant": 0.03, "cycles": 1, "program-id": 7,
               "tool-set-id": 3, "coordinate": coordinate}
        for line in ("forget 1", "forget 0", *("restore-%s %s" % each for each in row.items()), "restore 1", "restore 0", "row 0"):
            self.host.command("setp growth." + line)
            self.host.run(0.01)
        self.assertEqual(self.host.get("growth.row-coordinate"), coordinate)

    def test_a_new_reference_is_taken_back_with_its_request_and_again(self):
        self.restore(0.25)
        finger = self.panel("--access", "operator")
        finger.press("Growth of Z")
        finger.press("Learn from the next part")
        finger.await_text("A kept reference of this program is replaced; 1 contacts are kept.")
        finger.press("Learn")
        finger.until(lambda: self.host.get("growth.learn"), "the request")
        self.restore(0.5)  # the part has been learned
        finger.press("Changes")
        finger.press("Undo growth reference")
        finger.await_text("Put the former reference in force again (contacts: 1)?")
        finger.press("Undo")
        finger.await_text("The former reference is in force.")
        self.assertEqual(self.coordinate(), 0.25)
        self.assertFalse(self.host.get("growth.learn"))
        finger.press("Undo growth reference")  # of the undo
        finger.await_text("Put the former reference in force again")
        finger.press("Undo")
        finger.await_text("The former reference is in force.")
        self.assertEqual(self.coordinate(), 0.5, "the new one")

    def coordinate(self):
        self.host.command("setp growth.row 0")
        self.host.run(0.01)
        return self.host.get("growth.row-coordinate")

    def test_a_question_dies_with_its_page(self):
        finger = self.panel("--access", "operator")
        finger.press("Growth of Z")
        finger.press("Learn from the next part")
        finger.await_text("Learn from the next part? The machine must be cold")
        finger.press("Overview")
        finger.rest()
        self.assertFalse(finger.find("Learn"))
        finger.press("Growth of Z")
        finger.press("Switch on / off")
        finger.await_text("refused")
        finger.press("Squareness")
        finger.rest()
        self.assertFalse(finger.find_text("refused"))
        self.assertFalse(self.host.get("growth.learn"))

    def test_a_new_pin_throws_no_entry_away(self):
        self.set_square()
        finger = self.panel()
        self.open_chain(finger, "w-X-Y.b-Z-C-t")
        finger.press("Y EA0Y")
        finger.type("0.04")
        for line in ("loadrt and2 names=other", "loadrt thermal_growth_test names=late interlock=no", "newsig later float", "net later growth.load"):
            self.host.command(line)
        finger.until(lambda: finger.find("Growth test"), "the page of the new component")
        self.assertEqual([each["text"] for each in finger.widgets() if each["kind"] == "Entry"], ["0.04"])
        finger.press("Y leans to +Z")
        finger.press("Enter")
        finger.await_text("measured: 133.3 \u00b5m/m to +Z")

    def test_a_gauge_of_radii_is_never_asked_for_a_diameter(self):
        for line in ("loadrt centre_height names=centre interlock=no", "addf centre.update servo-thread", "setp centre.gauge-kind 1", "setp centre.method 1",
                     "setp centre.land-diameter 10", "setp centre.cuts 2"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Centre height")
        for pin in ("start", "cut-done"):
            self.host.command("setp centre.%s 1" % pin)
            self.host.run(0.05)
        finger.await_text("Waits for the measurement of this cut.")
        finger.until(lambda: finger.find("Enter the radius"), "the button of the radius")
        asked = [text for text in finger.texts() if "enter" in text.lower() or "measure" in text.lower()]
        self.assertIn("Enter the radius", asked)
        self.assertEqual([text for text in asked if "diameter" in text and "radius" not in text], [])
        finger.press("Enter the radius")
        finger.type("10")
        finger.press("Enter")
        finger.await_text("\"10\" was not entered: That is the diameter: enter the radius.")
        finger.press("Clear")
        finger.type("5.1")
        self.host.command("setp centre.abort 1")  # by an emergency stop
        self.host.run(0.05)
        finger.press("Enter")
        finger.await_text("Enter the radius: refused. The measurement is interrupted.")
        self.host.run(0.5)
        self.assertEqual(self.host.get(["centre.entered", "centre.cut-number", "centre.status-code"]), [False, 0, 48])

    def test_buttons_are_in_the_list_of_changes(self):
        for line in ("loadrt chopping names=chop interlock=no sections=4", "addf chop.update servo-thread"):
            self.host.command(line)
        finger = self.panel("--access", "operator")
        finger.press("Chopping")
        finger.press("Hold / go on")
        finger.until(lambda: self.host.get("chop.feed-hold"), "the hold")
        finger.press("Stop strokes")
        finger.press("Growth of Z")
        finger.press("Acknowledge")
        finger.press("Changes")
        for pin in ("chop.feed-hold", "chop.stop", "growth.acknowledge"):
            finger.await_text(pin)

    def test_the_inputs_and_the_load_are_live(self):
        for line in ("newsig spindle-load float", "net spindle-load growth.load", "sets spindle-load 12.5", "setp growth.threshold 3",
                     "loadrt axis_growth names=axes interlock=no", "net spindle-load axes.temperature-0"):  # axis_growth has no page of its own
            self.host.command(line)
        self.host.set("growth.enable", True)
        finger = self.panel()
        finger.press("Growth of Z")
        finger.until(lambda: finger.find("Load 12.5 %, a contact at 15.5 %"), "the bar of the load")
        self.host.command("sets spindle-load 20")
        finger.until(lambda: finger.find("Load 20 %, a contact at 15.5 %"), "the load of a contact")
        self.host.command("setp growth.load-valid 0")
        finger.until(lambda: finger.find("The load is not valid"), "the lost load")
        finger.await_text("\u2716 not valid")
        finger.await_text("The load is lost")
        finger.press("Growth of the axes")
        finger.await_text("temperature-0")
        finger.await_text("20 \u00b0C")

    def test_a_lost_sensor_is_named_and_so_is_the_load_that_it_measures(self):
        """The real modbus_sensor, of a device that does not answer."""
        path = os.path.join(self.folder, "sensors.toml")
        with open(path, "w") as file:
            file.write('[[link]]\nname = "cabinet"\ntcp = "127.0.0.1:1"\n[[link.channel]]\nname = "spindle-load"\ntable = "holding"\nregister = 0\n'
                       'type = "s16"\nunit = "%"\nevery = 0.5\nmax-age = 3\nmin = 0\nmax = 200\nmax-rate = 5000\n')
        self.host.command("loadusr -W %s --file %s" % (os.path.join(BUILD, "bin", "modbus_sensor"), path))
        self.host.command("net load modbus-sensor.spindle-load.value => growth.load")
        for line in ("loadrt joint_offset names=x-stage,y-stage interlock=no", "addf x-stage.update servo-thread"):
            self.host.command(line)
        self.host.command("net load-valid modbus-sensor.spindle-load.valid => growth.load-valid")
        self.host.set("growth.enable", True)
        finger = self.panel()
        finger.press("Sensors")
        finger.await_text("No valid value: modbus-sensor.spindle-load.")
        finger.await_text("modbus-sensor.spindle-load")
        finger.press("Growth of Z")
        finger.await_text("The load is lost: its sensor reports no valid value.")
        finger.await_text("\u2716 not valid")
        finger.press("Overview")
        finger.await_text("The load is lost")
        finger.await_text("No valid value: modbus-sensor.spindle-load.")
        finger.await_text("x-stage: A fault is active. A limit is not set or out of range: min-limit (0 mm) below max-limit (0 mm) ")
        finger.await_text("y-stage is not called: no thread runs its function update.")

    def test_no_text_promises_retain_where_there_is_none(self):
        finger = self.panel()
        for name in ("All components", "growth", "Settings for experts", "window", "Clear"):
            finger.press(name)
        finger.type("0.25")
        finger.press("Save")
        finger.await_text("No plumb-retain keeps the settings of this screen")
        finger.rest()
        self.assertFalse(finger.find_text("Saved by plumb-retain"))

    def test_threads_that_stand_are_said(self):
        self.host.command("loadrt interlock names=interlock")
        self.host.command("addf interlock.update servo-thread")
        finger = self.panel("--standstill", "3")
        finger.press("All components")
        self.host.command("stop")
        finger.await_text("The realtime threads stand still")
        self.host.command("start")
        finger.until(lambda: not finger.find_text("The realtime threads stand still"), "the message to go")

    def test_every_widget_has_a_name_and_no_text_is_cut(self):
        """On the pages of all functions, and those that their buttons open."""
        for line in ALL_FUNCTIONS:
            self.host.command(line)
        for language, size in (("en", "720x560"), ("de", "500x560")):
            finger = self.panel("--language", language, "--size", size, name="small" + language)
            finger.until(lambda finger=finger: len(finger.widgets()) > 5, "the window")
            for page in [each["name"] for each in finger.widgets() if each["kind"] == "Button" and each["name"] not in ("Light / dark", "Hell / dunkel")]:
                finger.press(page)
                finger.rest()
                self.check(finger, language, page)
                for name in DEEPER.get(page, ()) if language == "en" else ():
                    finger.press(name)
                    finger.rest()
                    self.check(finger, page, name)

    def check(self, finger, *place):
        for each in finger.widgets():
            with self.subTest(place=place, **each):
                self.assertTrue(each["name"] or each["kind"] == "Label")
                self.assertFalse(each.get("cut"))


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb commission: what a reading says, what the sheet has, and what has changed since; without a machine."""

import os
import sys
import types
import unittest

from tree import BUILD, own_folder

sys.path.insert(0, os.path.join(BUILD, "share", "plumb"))
from commissioning import pictures  # noqa: E402
from commissioning.functions import squareness, thermal_displacement  # noqa: E402
from commissioning.judging import judge, judge_press  # noqa: E402
from commissioning.records import Records, changes, findings  # noqa: E402
from panel.texts import VERSION  # noqa: E402

TOLERANCE = 0.003


class Judging(unittest.TestCase):
    def test_each_usual_mistake_has_its_name(self):
        for read, fault in ((0.010, ""), (0.0125, ""), (-0.010, "sign"), (0.254, "inch"), (-0.254, "inch"), (0.02, "twice"), (0.005, "half"), (10, "thousand"),
                            (0, "nothing"), (1, "percent"), (0.06, "size")):
            with self.subTest(read):
                self.assertEqual(judge(0.010, read, TOLERANCE).fault, fault)

    def test_a_mistake_is_one_of_its_kind(self):
        """An angle is no diameter, and a load has no backlash."""
        for kind, read, fault, words in (("angle", 0.02, "twice", "half of the real one"), ("angle", 0.005, "half", "twice the real one"), ("angle", 0.254, "size", "fits none"),
                                         ("load", 0.1, "ten", "10 V is taken for 1 V"), ("load", 0.02, "size", "fits none"), ("load", 1, "percent", "percent"), ("temperature", 0.02, "size", "fits none")):
            with self.subTest((kind, read)):
                verdict = judge(0.010, read, TOLERANCE, kind=kind)
                self.assertEqual(verdict.fault, fault)
                self.assertIn(words, verdict.sentence)
                for word in ("diameter", "radius", *(("backlash",) if kind in ("load", "temperature") else ())):
                    self.assertNotIn(word, verdict.sentence + verdict.remedy)

    def test_the_steps_of_an_angle_and_of_a_load_name_its_mistakes(self):
        move = types.SimpleNamespace(letter="Y", direction="X", start=(0, None, 0), travel=300, expected=-0.024, tilts=lambda _: {"ec0y": -0.024}, names=lambda _: "ec0y", look=lambda _: (0, None, 0))
        pins = {"load": 3.0, "load-valid": True, "spindle-speed-cmd": 3000}
        rig = types.SimpleNamespace(unit=1, get=lambda _instance, name: pins[name], sleep=lambda _: pins.update(load=300.0))
        session = types.SimpleNamespace(rig=rig, tolerance=TOLERANCE, function=types.SimpleNamespace(instance=types.SimpleNamespace(full=str)))
        step = squareness.WithoutIt(session, move)
        self.assertTrue(step.finish({"read": 0.024}).passed)
        self.assertIn("the angle that is set is twice the real one", step.finish({"read": 0.012}).sentence)
        step = thermal_displacement.Load(session)
        step.begin()
        self.assertIn("10 V is taken for 1 V", step.finish({"shown": 30.0}).sentence)

    def test_too_little_shows_at_a_larger_press(self):
        self.assertEqual(judge(0.010, 0.010 / 25.4, TOLERANCE).fault, "nothing")
        self.assertEqual(judge(0.050, 0.050 / 25.4, TOLERANCE).fault, "millimetre")

    def test_nothing_but_the_asked_value_passes(self):
        for number in range(-300, 301):
            read = number / 10000
            self.assertEqual(judge(0.010, read, TOLERANCE).passed, abs(read - 0.010) <= TOLERANCE + 1e-12, read)

    def test_a_joint_that_stays_is_named(self):
        self.assertEqual(judge_press(0.010, 0.010, 0.009, TOLERANCE).fault, "stayed")
        self.assertEqual(judge_press(0.010, 0.010, 0.001, TOLERANCE).fault, "")

    def test_every_fault_has_a_remedy(self):
        for read in (-0.010, 0.254, 0, 1, 10, 0.06):
            self.assertTrue(judge(0.010, read, TOLERANCE).remedy)


class Place:
    kind, number, name, module, key = "function", 0, "square", "squareness", "function square"


class Machine:
    """A machine whose wiring and settings are these."""

    unit, stages, functions, asked = 1, [], [Place], ()

    def __init__(self):
        self.lines, self.values, self.number, self.kept, self.required = ["enable < interlock.function-enable-0"], {"ec0y": -1e-4}, 7, 7, True
        self.drives, self.words = {"step.0.scale": 200.0}, ["chain=w-X-Y.b-Z-C-t"]

    def wiring(self, _place):
        return self.lines

    def settings(self, _place):
        return self.values

    def scales(self, _place):
        return self.drives

    def options(self, _place):
        return self.words

    def identity(self, _place):
        return self.number

    def passed(self, _place):
        return self.kept

    def take_back(self, _place):
        self.kept = 0

    def is_commissioned(self, _place):
        return self.number == self.kept

    def is_required(self):
        return self.required

    def doubts(self):
        return self.asked

    def stages_of(self, _function):
        return []


class Sheets(unittest.TestCase):
    def setUp(self):
        VERSION[0] = "1.2"
        self.machine, self.records = Machine(), Records(own_folder(self), "mill 3 <new>")
        log = [{"title": "A step", "read": {"pressed": 0.0101}, "fault": "", "sentence": "Asked 0.01, read 0.0101.", "remedy": "", "when": "2026-01-01 10:00:00"}]
        self.records.note(self.machine, Place, "H. Meier", log, TOLERANCE, minutes=12)

    def read(self, path):
        with open(path, encoding="utf-8") as file:
            return file.read()

    def test_sheet_has_all_that_is_signed(self):
        for path in self.records.sheets(self.machine, Place):
            text = self.read(path)
            for words in ("H. Meier", "0.0101", "0.003 mm", "Plumb 1.2", "square.ec0y", "enable &lt; " if path.endswith("html") else "enable < ", "Signature"):
                self.assertIn(words, text, path)
        self.assertNotIn("<new>", self.read(self.records.sheets(self.machine, Place)[0]))

    def test_state_says_by_whom_and_what_changed(self):
        self.assertEqual(findings(self.machine, self.records)[0][0], "ok")
        self.assertIn("signed by H. Meier", findings(self.machine, self.records)[0][1])
        self.machine.number, self.machine.values, self.machine.lines = 8, {"ec0y": 1e-4}, ["enable < other.out"]
        kind, sentence, command = findings(self.machine, self.records)[0]
        self.assertEqual((kind, command), ("wrong", "plumb commission squareness"))
        self.assertIn("changed since", sentence)
        changed = changes(self.machine, Place, self.records.all()[Place.key])
        self.assertEqual(changed, ["new: enable < other.out", "gone: enable < interlock.function-enable-0", "ec0y was \u22120.0001 and is 0.0001"])

    def test_scales_options_and_the_unit_are_compared(self):
        self.assertEqual(changes(self.machine, Place, self.records.all()[Place.key]), [])
        self.machine.drives, self.machine.words, self.machine.unit = {"step.0.scale": -200.0, "step.0.position-scale": 5.0}, [], 1 / 25.4
        self.assertEqual(changes(self.machine, Place, self.records.all()[Place.key]), [
            "step.0.position-scale was its default and is 5", "step.0.scale was 200 and is \u2212200",
            "The loadrt line was chain=w-X-Y.b-Z-C-t and is empty", "LINEAR_UNITS was mm and is in"])

    def test_a_lent_setting_is_known_after_a_kill_and_not_in_another_linuxcnc(self):
        for value in (True, False):
            self.records.lend(5, "growth.dry-run", value)
        self.records.lend(5, "growth.verify-step", 0.0)
        again = Records(self.records.folder, "mill")
        self.assertEqual(again.lent(5), {"growth.dry-run": True, "growth.verify-step": 0.0})
        self.assertEqual(again.lent(6), {})
        with open(os.path.join(self.records.folder, "lent.json"), "w") as file:
            file.write('{"memory": 5, "pi')
        self.assertEqual(again.lent(5), {})
        again.lend_nothing()
        again.lend_nothing()

    def test_a_damaged_file_of_records_is_refused(self):
        for text in ("", "{", "[]", '{"places": {"function square": 1}}'):
            with open(self.records.path, "w") as file:
                file.write(text)
            with self.assertRaises(ValueError, msg=text):
                self.records.all()

    def test_a_store_in_doubt_comes_first_with_its_command(self):
        self.machine.asked, self.machine.kept = ["The store is from another computer."], 0
        self.assertEqual(findings(self.machine, self.records)[0], ("wrong", "The store is from another computer.", "plumb commission --accept"))

    def test_a_bit_set_by_hand_says_so(self):
        self.records.note(self.machine, Place, "K. Braun", [], 0, by_hand=True)
        self.assertIn("set by hand by K. Braun", findings(self.machine, self.records)[0][1])
        self.assertIn("nothing was measured", self.read(self.records.sheets(self.machine, Place)[1]))
        self.records.take_back(self.machine, [Place])
        self.assertFalse(self.machine.is_commissioned(Place))
        self.machine.kept = self.machine.number
        self.assertIn("no record says by whom", findings(self.machine, self.records)[0][1])

    def test_a_simulated_machine_says_that_it_is_off(self):
        self.machine.required = False
        self.assertEqual([row[0] for row in findings(self.machine, self.records)], ["note"])


class Pictures(unittest.TestCase):
    def test_each_is_a_drawing(self):
        import xml.dom.minidom

        for name in pictures.PICTURES:
            for letter in ("X", "Y", "Z"):
                xml.dom.minidom.parseString(pictures.drawing(name, letter))


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""What linuxcnc_link tells the operator, by the declarations of real components; and buttons of statuses, which pages have."""

import glob
import os
import re
import sys
import unittest

import plumb
from tree import BUILD, ROOT, own_folder

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from panel import texts, voice  # noqa: E402
from panel.declared import read_all  # noqa: E402
from panel.pin_lines import Pin, parse_pins  # noqa: E402

SHARE = os.path.join(BUILD, "share", "plumb")
DECLARED, DAMAGED = read_all(SHARE)
WITH_STATUS = [module for module in DECLARED.values() if module.statuses]
LAMP = """
[lamp]
title = "Lamp"
[lamp.statuses.1]
kind = "bad"
sentence = "The lamp is dark."
remedy = "Replace it."
[lamp.statuses.2]
kind = "off"
sentence = "The lamp is off."
[lamp.codes.detail-code]
7 = "The thread is broken."
"""


def own(case, text):
    """The declarations with these changes."""
    path = os.path.join(own_folder(case), "messages.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return read_all(SHARE, path)[0]


def pins_of(module, name):
    """At their defaults; a length is in mm."""
    return [Pin("%s.%s" % (name, short), module.name, pin["type"], pin["output"], float(pin["default"]) if pin["type"] == "float" else int(pin["default"]), "")
            for short, pin in module.pins.items()]


class Speaker:
    """A voice, and the pins of a machine as a dictionary."""

    def __init__(self, pins, declared=None):
        self.voice, self.values, self.now = voice.Voice(DECLARED if declared is None else declared), {pin.name: pin.value for pin in pins}, 0
        self.strangers = self.voice.meet(pins)

    def say(self, seen=False, after=0, **values):
        """What is told when these pins change."""
        self.now += after
        self.values.update({name.replace("__", ".").replace("_", "-"): value for name, value in values.items()})
        found = list(self.voice.news(self.values, self.now, seen))
        for news in found:
            self.voice.told(news)
        return [(news.tell, news.text) for news in found]


class Statuses(unittest.TestCase):
    """Each status of each component that has some."""

    def test_each_is_told_as_it_declares_and_once(self):
        told = dict.fromkeys(("error", "text", "behind-panel", "never"), 0)
        for module in WITH_STATUS:
            for number, its in module.statuses.items():
                if its["detail"] == "fault-code":
                    continue  # the fault is told
                with self.subTest(module=module.name, status=number):
                    speaker = Speaker(pins_of(module, "its"))
                    seen = speaker.say(seen=True, its__status_code=number) + speaker.say(seen=True, after=its["after"])
                    self.assertEqual(len(seen), its["tell"] in ("error", "text"))
                    then = speaker.say(after=its["after"])
                    self.assertEqual(len(then), its["tell"] == "behind-panel")
                    if its["tell"] != "never":
                        self.assertTrue((seen + then)[0][1].startswith("%s: %s" % (module.title or "its", its["sentence"])), seen + then)
                    self.assertEqual(speaker.say(after=100), [], "told once")
                    told[its["tell"]] += 1
        self.assertGreater(min(told.values()), 5, told)

    def test_a_bad_status_is_told_by_itself_or_by_the_one_that_causes_it(self):
        causes = {"functions of Plumb are in a wrong order", "stage of an axis has a fault", "A stage has a fault", "does not answer"}
        for module in WITH_STATUS:
            for number, its in module.statuses.items():
                if its["kind"] == "bad" and its["tell"] == "never":
                    self.assertTrue(any(cause in its["sentence"] for cause in causes), (module.name, number))

    def test_no_message_is_longer_than_linuxcnc_shows_and_each_has_its_detail(self):
        self.addCleanup(texts.choose, "", "en")
        for language in ("en", "de"):
            texts.choose(os.path.join(BUILD, "share", "locale"), language)
            for module in WITH_STATUS:
                for number, its in module.statuses.items():
                    for code in module.codes.get(its["detail"], [0]) if its["detail"] != "fault-code" else ():
                        speaker = Speaker(pins_of(module, "its"))
                        if code:
                            speaker.values["its." + its["detail"]] = code
                        for tell, text in speaker.say(its__status_code=number) + speaker.say(after=its["after"]):
                            with self.subTest(language=language, module=module.name, status=number, code=code):
                                self.assertLessEqual(len(text.encode()), 250)
                                self.assertTrue(text.endswith((".", "?")), text)
                                if not code:
                                    self.assertIn(texts._(its["sentence"]), text)
                                else:  # the value of a setting stands behind its name
                                    detail, shown = (re.sub(r" \([^)]*\)", "", words).replace("-", " ") for words in (texts._(module.codes[its["detail"]][code]), text))
                                    self.assertIn(detail.split("{")[0][:20], shown)

    def test_a_status_must_last_as_long_as_it_declares(self):
        speaker = Speaker(pins_of(DECLARED["squareness"], "square"))
        self.assertEqual(speaker.say(square__status_code=16), [])
        self.assertEqual(speaker.say(after=29), [])
        self.assertEqual(speaker.say(square__status_code=2), [])
        self.assertEqual(speaker.say(after=2, square__status_code=16), [])
        self.assertEqual([tell for tell, _ in speaker.say(after=31)], ["text"])

    def test_a_pause_ends_no_question_and_an_answer_does(self):
        speaker = Speaker(pins_of(DECLARED["thermal_displacement"], "growth"))
        asks, machine_off, works = 53, 5, 40
        self.assertEqual(len(speaker.say(growth__status_code=asks, growth__shift_size=0.03)), 1)
        self.assertEqual(speaker.say(growth__status_code=machine_off), [])
        self.assertEqual(speaker.say(growth__status_code=asks), [])
        self.assertEqual(speaker.say(growth__status_code=works), [])
        self.assertEqual(len(speaker.say(growth__status_code=asks)), 1)

    def test_another_detail_is_told_again(self):
        speaker = Speaker(pins_of(DECLARED["squareness"], "square"))
        first, second = (speaker.say(square__status_code=43, square__limited_code=code) for code in (1, 2))
        self.assertNotEqual(first, second)
        self.assertEqual([len(first), len(second)], [1, 1])

    def test_the_size_of_a_question_is_told(self):
        speaker = Speaker(pins_of(DECLARED["thermal_displacement"], "growth"))
        ((tell, text),) = speaker.say(growth__status_code=53, growth__shift_size=-0.0304)
        self.assertEqual(tell, "text")
        self.assertRegex(text, r"^Growth of Z: All contacts moved at once, .*\. Size: \u221230\.4 \u00b5m\. .*growth_answer.*$")


class Faults(unittest.TestCase):
    def test_each_fault_of_a_function_has_its_cause(self):
        for module in DECLARED.values():
            if "fault" in module.pins and module.statuses:
                self.assertTrue(module.codes.get(module.fault_code), module.name)

    def test_each_fault_is_told_once_and_when_it_comes_again(self):
        for module in DECLARED.values():
            if module.is_of_sensors:
                continue
            for code in module.codes.get("fault-code", ()):
                with self.subTest(module=module.name, fault=code):
                    speaker = Speaker(pins_of(module, "its"))
                    ((tell, _text),) = speaker.say(its__fault_code=code)
                    self.assertEqual(tell, module.told.get("fault", {}).get("tell", "error"))
                    self.assertEqual(speaker.say(), [])
                    self.assertEqual(speaker.say(its__fault_code=0), [])
                    self.assertEqual(len(speaker.say(its__fault_code=code)), 1)

    def test_what_linuxcnc_did_not_take_comes_again(self):
        speaker = Speaker(pins_of(DECLARED["plumb-retain"], "plumb-retain"))
        speaker.values["plumb-retain.fault-code"] = 4
        self.assertEqual(len(list(speaker.voice.news(speaker.values, 0))), 1)
        self.assertEqual(len(speaker.say()), 1)

    def test_a_channel_of_a_sensor_is_told(self):
        pins = [Pin("can-sensor.load." + short, "can-sensor", "s32", True, 0, "") for short in ("value", "age", "valid", "fault", "fault-code")]
        speaker = Speaker(pins)
        self.assertEqual(speaker.say(), [])
        ((tell, text),) = speaker.say(can_sensor__load__fault_code=3)
        self.assertEqual((tell, text), ("error", "can-sensor.load: " + DECLARED["can_sensor"].codes["CHANNEL.fault-code"][3]))

    def test_a_link_of_a_sensor_is_told_once_and_not_by_each_of_its_channels(self):
        for module, owner in (("can_sensor", "can-sensor"), ("modbus_sensor", "modbus-sensor")):
            with self.subTest(module=module):
                its = DECLARED[module].pins
                pins = [Pin("%s.%s" % (owner, short.replace("LINK", "bus").replace("CHANNEL", channel)), owner, pin["type"], True, 0, "")
                        for channel in ("load", "heat") for short, pin in its.items() if not short.startswith("OUTPUT.") and (channel == "load" or "LINK" not in short)]
                self.assertIn("not connected", DECLARED[module].codes["CHANNEL.fault-code"][voice.DISCONNECTED])
                speaker = Speaker(pins)
                self.assertEqual(speaker.say(), [])
                for code, sentence in DECLARED[module].codes["LINK.fault-code"].items():
                    broken = {owner.replace("-", "_") + "__load__fault_code": 2, owner.replace("-", "_") + "__heat__fault_code": 2}
                    said = speaker.say(**{owner.replace("-", "_") + "__bus__fault_code": code}, **broken)
                    self.assertEqual(said, [("error", "%s.bus: %s" % (owner, sentence))])


class Risen(unittest.TestCase):
    def test_a_bit_is_told_with_the_values_of_its_pins(self):
        speaker = Speaker(pins_of(DECLARED["thermal_displacement"], "growth"))
        told = speaker.say(growth__learnt=True, growth__rows=5, growth__reference_sigma=0.0012)
        self.assertEqual(told, [("text", "Growth of Z: Learned from this part. The reference is uncertain by 1.2 \u00b5m; 5 contacts of all programs are kept.")])
        self.assertEqual(speaker.say(growth__rows=6), [], "once, whatever the values do")
        self.assertEqual(speaker.say(growth__learnt=False), [])
        self.assertEqual(len(speaker.say(growth__learnt=True)), 1)

    def test_a_tool_that_is_asked_about_is_named_once_with_how_long_it_has_cut_deeper(self):
        speaker = Speaker(pins_of(DECLARED["thermal_displacement"], "growth"))
        ((_, text),) = speaker.say(growth__status_code=56, growth__unanswered_code=4, growth__shift_tool=5, growth__shift_size=0.018, growth__shift_age=840.0)
        self.assertIn("Tool 5 has cut deeper for 14 min: 18.0 \u00b5m.", text)
        self.assertEqual(speaker.say(growth__shift_age=1800.0), [])

    def test_a_load_that_shows_z_roughly_is_told_with_how_roughly_and_what_to_do(self):
        speaker = Speaker(pins_of(DECLARED["thermal_displacement"], "growth"))
        advice = "This load shows Z only to about 12.0 \u00b5m. Leave it on Measure only, or learn from a steady plunge, not from interrupted milling."
        self.assertEqual(speaker.say(growth__poor_load=True, growth__reference_sigma=0.012), [("text", "Growth of Z: " + advice)])
        ((_, text),) = speaker.say(growth__status_code=44, growth__detail_code=14, growth__displacement_sigma=0.012)
        self.assertIn(advice, text)

    def test_a_code_stands_there_as_its_sentence(self):
        speaker = Speaker(pins_of(DECLARED["interlock"], "interlock"))
        ((tell, text),) = speaker.say(interlock__feed_service_lost=True, interlock__waiting_code=12)
        self.assertEqual((tell, text), ("error", "Interlock: The feed is held: LinuxCNC's io (service 5) does not answer. Start LinuxCNC again."))

    def test_inches_are_told_in_micrometres(self):
        self.addCleanup(texts.MACHINE_UNIT.__setitem__, 0, "mm")
        texts.MACHINE_UNIT[0] = "in"
        speaker = Speaker(pins_of(DECLARED["thermal_displacement"], "growth"))
        ((_, text),) = speaker.say(growth__learnt=True, growth__rows=5, growth__reference_sigma=0.0001)
        self.assertIn("2.5 \u00b5m", text)


class OnTheHost(unittest.TestCase):
    """Real components, whose pins come and go."""

    def setUp(self):
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        self.voice = voice.Voice(DECLARED)
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt interlock", "addf interlock.update servo-thread", "start"):
            self.host.command(line.replace("loadrt interlock", "loadrt interlock names=interlock"))

    def told(self):
        self.host.run(0.05)
        pins = parse_pins(self.host.halcmd("-s", "show", "pin").output)
        self.voice.meet(pins)
        found = list(self.voice.news({pin.name: pin.value for pin in pins}, self.host.time))
        for news in found:
            self.voice.told(news)
        return [news.text for news in found]

    def test_an_instance_that_comes_late_is_told_and_the_others_are_not_told_again(self):
        self.host.command("setp interlock.feed-services 999")
        ((first),) = self.told()
        self.assertTrue(first.startswith("Interlock: One of function-services"), first)
        self.host.command("loadrt joint_offset names=x-stage,y-stage interlock=no")
        self.host.command("addf x-stage.update servo-thread")
        late = self.told()
        self.assertEqual([text.split(":")[0] for text in late], ["x-stage"], late)
        self.assertIn("out of range", late[0])

    def test_a_setting_out_of_range_is_named_with_its_value(self):
        self.host.command("loadrt squareness names=square")
        self.host.command("addf square.update servo-thread")
        self.host.command("setp square.max-speed 100")
        self.assertEqual(self.told(), [])
        self.host.command("setp square.settling-time -3")
        ((text),) = self.told()
        self.assertIn("square.settling-time: \u22123 s is out of range", text)


class Own(unittest.TestCase):
    """messages.toml of the user."""

    def test_a_component_of_his_own_joins_by_two_pins_and_a_text(self):
        for name in ("lamp", "lamp.0"):  # of loadusr, and of loadrt lamp
            pins = [Pin("%s.%s" % (name, short), "lamp", "s32", True, 0, "") for short in ("status-code", "detail-code", "voltage")]
            speaker = Speaker(pins, own(self, LAMP))
            self.assertEqual(speaker.strangers, [])
            self.assertEqual(speaker.say(**{name.replace(".", "__") + "__status_code": 2}), [])
            told = speaker.say(**{name.replace(".", "__") + "__status_code": 1, name.replace(".", "__") + "__detail_code": 7})
            self.assertEqual(told, [("error", "Lamp: The lamp is dark. The thread is broken. Replace it.")])

    def test_a_bit_of_any_instance_gets_a_text(self):
        declared = own(self, '[door-open.told.out]\ntell = "text"\nsentence = "Close the door."\n')
        speaker = Speaker([Pin("%s.%s" % (name, short), "not", "bit", short == "out", 0, "") for name in ("door-open", "other") for short in ("in", "out")], declared)
        self.assertEqual(speaker.say(other__out=True), [])
        self.assertEqual(speaker.say(door_open__out=True), [("text", "door-open: Close the door.")])

    def test_he_changes_when_a_status_is_told(self):
        changes = '[joint_offset.statuses.41]\nafter = 2\n[squareness.statuses.43]\ntell = "never"\n'
        declared = own(self, changes)
        stage = Speaker(pins_of(DECLARED["joint_offset"], "x-stage"), declared)
        self.assertEqual(stage.say(x_stage__status_code=41), [])
        self.assertEqual(len(stage.say(after=2)), 1)
        self.assertEqual(Speaker(pins_of(DECLARED["squareness"], "square"), declared).say(square__status_code=43, square__limited_code=1), [])

    def test_an_instance_without_texts_is_named_once(self):
        pins = [Pin("lamp.status-code", "lamp", "s32", True, 0, "")]
        speaker = Speaker(pins)
        self.assertEqual(len(speaker.strangers), 1)
        self.assertTrue(speaker.strangers[0].startswith("lamp has a status-code, and no texts"))
        self.assertEqual(speaker.voice.meet(pins), [])
        self.assertEqual(speaker.say(lamp__status_code=1), [])

    def test_a_wrong_file_is_refused_with_the_place(self):
        for text, words in (
            ("[lamp\n", "Expected ']'"),
            ("lamp = 1\n", "lamp is no table: write [lamp]"),
            ('[[message]]\npin = "a"\n', "[[message]] is of Plumb 0.2"),
            ("[lamp]\ncolour = 1\n", "[lamp]: unknown key 'colour', none of title, statuses, codes, told"),
            ("[lamp.statuses.x]\n", "[lamp.statuses.x]: x is no number"),
            ('[lamp.statuses.1]\nkind = "sad"\n', "[lamp.statuses.1]: kind is none of good, wait, off, warn, bad"),
            ('[lamp.statuses.1]\nkind = "bad"\n', "[lamp.statuses.1]: there is no sentence"),
            ('[squareness.statuses.43]\ntell = "loud"\n', "[squareness.statuses.43]: tell is none of never, behind-panel, text, error"),
            ('[squareness.statuses.43]\nafter = "long"\n', "[squareness.statuses.43]: after is no number of seconds"),
            ('[lamp.codes]\ndetail-code = "x"\n', "lamp.codes.detail-code is no table"),
            ("[lamp.codes.detail-code]\n1 = 2\n", "[lamp.codes.detail-code]: write NUMBER = \"SENTENCE\""),
            ('[door.told.out]\nsentence = "Close it."\n', "[door.told.out]: tell is none of"),
        ):
            with self.subTest(words):
                with self.assertRaisesRegex(ValueError, "messages.toml: .*" + re.escape(words)):
                    own(self, text)


class Buttons(unittest.TestCase):
    """The names of buttons: declared by hal/status.hpp, and registered by the page of each function."""

    PAGES = os.path.join(ROOT, "components", "screens", "panel")

    def registered(self, module):
        """By the function's own page; every page has `switch`."""
        found = {"switch"}
        for path in glob.glob(os.path.join(self.PAGES, "*_page.py")):
            with open(path, encoding="utf-8") as file:
                text = file.read()
            if re.search(r'^    function = "%s"$' % module.name, text, re.M):
                found |= {name for call in re.findall(r"self\.remedy\(([^()]*)", text) for name in re.findall(r'"([a-z-]+)"', call)}
        return found

    def test_each_button_of_a_status_stands_on_the_page_of_its_function_and_no_other(self):
        self.assertEqual(DAMAGED, [])
        functions = [module for module in DECLARED.values() if module.role == "compensation"]
        self.assertGreaterEqual(len(functions), 6)
        for module in functions:
            declared = {its["button"] for its in module.statuses.values() if its["button"]}
            with self.subTest(module.name):
                self.assertEqual(self.registered(module), declared)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""linuxcnc_link and plumb-retain in a complete LinuxCNC, ten times faster than the clock, on two days.

PLUMB_BUILD names the build folder.
"""

import glob
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import types
import unittest
import unittest.mock

import linuxcnc_runs
from linuxcnc_runs import BUILD, ROOT, copy_configuration, own_folder

sys.path[:0] = [os.path.join(BUILD, "python"), os.path.join(ROOT, "components", "io", "linuxcnc_link")]
import linuxcnc_link  # noqa: E402
import plumb  # noqa: E402

LINK = os.path.join(BUILD, "bin", "linuxcnc_link")
PATIENCE = 100  # s, for an event that takes a few

HAL = """\
loadrt thermal_displacement names=growth
addf growth.update servo-thread
loadusr -Wn linuxcnc-link {build}/bin/linuxcnc_link --messages $(CONFIG_DIR)/messages.toml --messages $(CONFIG_DIR)/door.toml
loadusr -W {build}/bin/plumb-retain --file $(CONFIG_DIR)/mill.toml
"""

RETAIN = """\
machine = "mill"
pins = ["growth.window"]
records = ["growth"]
every = 0.5
"""

MESSAGES = """\
[[message]]
pin = "refused"
kind = "error"
text = "The reference is refused: {code}"
codes = "thermal_displacement refusal-code"

[[message]]
pin = "hint"
text = "Let it warm up"

[[message]]
pin = "shown"
kind = "display"
text = "Look here"
"""

DOOR = """\
[[message]]
pin = "door"
text = "Close the door {code}."
[message.codes]
2 = "at the back"
"""

PROGRAMS = {
    "main.ngc": "(o<none> call)\n; o<none> call\no<first> call [1]\nO<second>CALL\no<first> call\nM2\n",
    "first.ngc": "o<first> sub\no<second> call\no<first> endsub\n",
    "second.ngc": "o<second> sub\nG0 X1\no<second> endsub\n",
    "none.ngc": "o<none> sub\no<none> endsub\n",
    "alone.ngc": "G0 X0\nM2\n",
}


class Days(unittest.TestCase):
    """The facts of the scenario on the first day, and on the second, after a restart of LinuxCNC."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        machine = copy_configuration("three_axis", folder)
        files = dict(PROGRAMS, **{"link.hal": HAL.format(build=BUILD), "messages.toml": MESSAGES, "door.toml": DOOR, "mill.toml": RETAIN})
        for name, text in files.items():
            with open(os.path.join(machine, name), "w") as file:
                file.write(text)
        ini = linuxcnc_runs.own_ini(os.path.join(machine, "three_axis.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = link.hal"))
        cls.facts = []
        for _ in range(2):
            its, cls.said = linuxcnc_runs.work(folder, ini, "link_scenario.py")
            cls.facts.append(its["facts"])

    def test_what_was_kept_is_in_force_on_the_second_day(self):
        self.assertEqual(self.facts[0]["in force"], [0.5, 0, 0])
        self.assertEqual(self.facts[1]["in force"], [0.125, 1, 0], self.said)

    def test_no_program_is_known_before_one_is_loaded(self):
        self.assertEqual(self.facts[0]["without a program"], 0)

    def test_the_tool_set_is_that_of_the_table_with_any_tool_in_the_spindle(self):
        before, after, measured = self.facts[0]["tools"]
        self.assertEqual(before, after)
        self.assertEqual(before, measured, "another length along Z is no other tool")
        self.assertNotEqual(before, 0)

    def test_the_operator_reads_the_messages(self):
        refused = "The reference is refused: %s"
        sentences = plumb.declarations("thermal_displacement")["codes"]["refusal-code"]
        self.assertEqual(
            self.facts[0]["messages"],
            [
                [refused % sentences[1]],
                [refused % sentences[2]],
                [refused % "code 9"],
                ["Let it warm up"],
                ["Look here"],
                ["Close the door at the back."],
            ],
        )


class Zero(unittest.TestCase):
    """zero-set rises when the offsets of the coordinate system in force change, and at nothing else."""

    def status(self, system=1, x=0.0, shift=0.0):
        return types.SimpleNamespace(g5x_index=system, g5x_offset=(x, 0, 0, 5), g92_offset=(0, shift, 0, 0))

    def test_a_touch_off_and_g92_are_a_new_zero_for_a_moment(self):
        zero = linuxcnc_link.WorkZero()
        self.assertFalse(zero.is_set(self.status(), 0))
        self.assertFalse(zero.is_set(self.status(), 1))
        self.assertTrue(zero.is_set(self.status(x=2.5), 2))
        self.assertTrue(zero.is_set(self.status(x=2.5), 2.4))
        self.assertFalse(zero.is_set(self.status(x=2.5), 2.6))
        self.assertTrue(zero.is_set(self.status(x=2.5, shift=1), 3))

    def test_another_coordinate_system_and_the_same_values_again_are_none(self):
        zero = linuxcnc_link.WorkZero()
        for now, status in enumerate((self.status(), self.status(2, 7), self.status(2, 7), self.status())):
            self.assertFalse(zero.is_set(status, now))


class Stamp(unittest.TestCase):
    def test_another_content_with_the_time_of_the_former_one_is_seen(self):
        path = os.path.join(own_folder(self), "part.ngc")
        with open(path, "w", encoding="ascii") as file:
            file.write("G0 X0\n")
        before, stamp = os.stat(path), linuxcnc_link.stamp(path)
        with open(path, "w", encoding="ascii") as file:
            file.write("G0 X9\n")
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
        self.assertEqual((os.stat(path).st_mtime_ns, os.stat(path).st_size), (before.st_mtime_ns, before.st_size))
        self.assertNotEqual(linuxcnc_link.stamp(path), stamp)


class Values(unittest.TestCase):
    def message(self, **more):
        return linuxcnc_link.Message({"pin": "learnt", "text": "{rows} contacts, {sigma}", "values": {"rows": "count", "sigma": "um"}, **more}, "here", ("de",))

    def test_values_come_into_the_text_when_it_is_shown(self):
        message = self.message(translated={"de": "{sigma}: {rows} Kontakte"})
        self.assertEqual(message.pins, ["learnt", "learnt-rows", "learnt-sigma"])
        pins = {"learnt": True, "learnt-rows": 5, "learnt-sigma": 0.0012}
        self.assertEqual(message.new_text(pins), "1.2 \u00b5m: 5 Kontakte")
        self.assertIsNone(message.new_text(pins))
        inches = {"learnt": True, "learnt-rows": 5, "learnt-sigma": 0.0001}
        self.assertEqual(self.message().new_text(inches, False, 25400), "5 contacts, 2.5 \u00b5m")

    def test_two_messages_share_the_codes_of_a_pin(self):
        codes = {"codes": {"1": "A shift.", "2": "No load."}, "values": {}}
        shift = self.message(**{**codes, "text": "{code} {size}", "values": {"size": "um"}, "only": [1]})
        others = self.message(**codes, text="{code}", **{"except": [1]})
        pins = {"learnt": True, "learnt-code": 1, "learnt-size": 0.03}
        self.assertEqual([message.new_text(pins) for message in (shift, others)], ["A shift. 30.0 \u00b5m", None])
        pins["learnt-code"] = 2
        self.assertEqual([message.new_text(pins) for message in (shift, others)], [None, "No load."])

    def test_values_that_are_not_in_the_texts_are_refused(self):
        for wrong in ({"values": {"rows": "count"}, "text": "contacts"}, {"values": {"rows": "inch"}}, {"translated": {"de": "{rows}"}}):
            with self.assertRaises(linuxcnc_link.SettingsError):
                self.message(**wrong)


class Settings(unittest.TestCase):
    """A wrong file of messages is reported, and nothing is loaded."""

    def refused(self, text, words):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(text)
            file.flush()
            ended = subprocess.run(
                ["/usr/bin/python3", LINK, "--messages", file.name], capture_output=True, text=True, timeout=PATIENCE
            )
            self.assertEqual(ended.returncode, 1)
            self.assertEqual(ended.stderr.strip(), "linuxcnc_link: %s: %s" % (file.name, words))

    def test_wrong_files_are_reported(self):
        good = '[[message]]\npin = "a"\ntext = "b"\n'
        for text, words in (
            ('[[mesage]]\npin = "a"\n', "unknown key 'mesage'"),
            ('[message]\npin = "a"\n', "message is no list of tables: write [[message]]"),
            (good + good, "there are two pins a"),
            (good + '[[message]]\npin = "connected"\ntext = "b"\n', "there are two pins connected"),
            (good + '[[message]]\npin = "c"\n', "message 2: there is no text"),
            (good + "colour = 1\n", "message 1: unknown key 'colour'"),
            (good + 'kind = "shout"\n', "message 1: kind = 'shout' is none of error, text, display"),
            (good.replace('"a"', '"A_b"'), "message 1: pin = 'A_b' is not of a-z, 0-9 and -, at most 24"),
            (good + "codes = 3\n", "message 1: codes is neither a table nor a module and its pin"),
            (
                good + "codes = 'axis_offset'\n",
                "message 1: codes: 'axis_offset' is not a module and its pin, as 'axis_offset fault-code'",
            ),
            (
                good + good.replace('"a"', '"c"') + "codes = 'thermal fault-code'\n",
                "message 2: codes: cannot find the declarations of 'thermal' in %s or %s"
                % (os.path.join(os.path.abspath(BUILD), "share", "plumb"), os.path.abspath(os.path.join(BUILD, "..", "..", "share", "plumb"))),
            ),
            (
                good + "codes = 'thermal_displacement fault'\n",
                "message 1: codes: thermal_displacement has no codes of 'fault', only of: doubt-code, fault-code, learning-failed-code, refusal-code, rejection-code, status-code",
            ),
            (good.replace('"b"', '"b {code}"') + "except = [2]\n[message.codes]\n1 = 'y'\n", "message 1: except: 2 is none of its codes"),
            (good + "except = 2\n", "message 1: except is no list of codes"),
            (good.replace('"b"', '"b {code}"') + "only = ['1']\n[message.codes]\n1 = 'y'\n", "message 1: only: 1 is none of its codes"),
            (good + "only = []\nexcept = []\n", "message 1: only and except do not go together"),
            (good + "[message.codes]\nx = 'y'\n", "message 1: codes: invalid literal for int() with base 10: 'x'"),
            (good + "[message.codes]\n1 = 2\n", "message 1: codes: 1 has no text"),
            (good + "[message.codes]\n1 = 'y'\n", "message 1: {code} in the text and codes belong together"),
            (good.replace('"b"', '"%s"' % ("b" * 251)), "message 1: longer than 250 characters: '%s'" % ("b" * 251)),
        ):
            with self.subTest(words):
                self.refused(text, words)

    def test_pin_that_two_files_have_is_reported_with_both(self):
        folder = own_folder(self)
        command = ["/usr/bin/python3", LINK]
        for name in ("one.toml", "two.toml"):
            with open(os.path.join(folder, name), "w") as file:
                file.write('[[message]]\npin = "%s"\ntext = "b"\n[[message]]\npin = "a"\ntext = "b"\n' % name[:3])
            command += ["--messages", os.path.join(folder, name)]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(ended.returncode, 1)
        self.assertEqual(
            ended.stderr,
            "linuxcnc_link: %s/two.toml: there are two pins a; the other one is in %s/one.toml\n" % (folder, folder),
        )

    def test_a_file_that_cannot_be_read_is_reported_with_its_line(self):
        self.refused('[[message]]\npin = \n', "Invalid value (at line 2, column 7)")
        ended = subprocess.run(["/usr/bin/python3", LINK, "--messages", "/nowhere.toml"], capture_output=True, text=True)
        self.assertEqual(ended.stderr, "linuxcnc_link: /nowhere.toml: No such file or directory\n")


class Statuses(unittest.TestCase):
    """The message of a status-code, in each status of each function."""

    def test_only_a_bad_status_is_told_and_with_its_remedy(self):
        for module in ("axis_growth", "chopping", "squareness", "thermal_displacement", "thermal_growth_test"):
            message = linuxcnc_link.Message({"pin": "its", "text": "It: {code}", "codes": module + " status-code"}, "here")
            statuses = plumb.declarations(module)["statuses"]
            told = 0
            for code, its in statuses.items():
                with self.subTest(module=module, code=code):
                    text = message.new_text({"its": its["kind"] in ("warn", "bad"), "its-code": int(code)})
                    if its["kind"] == "bad" and not its["detail"]:
                        self.assertEqual(text, "It: %s %s" % (its["sentence"], its["remedy"]))
                        self.assertIsNone(message.new_text({"its": True, "its-code": int(code)}), "told once")
                        told += 1
                    else:
                        self.assertIsNone(text)
            self.assertGreaterEqual(told, 8 + 1, "each lost service, and more")


class BehindThePanel(unittest.TestCase):
    """What plumb panel shows lies over it only when it is not seen any more."""

    def message(self, on_panel):
        return linuxcnc_link.Message({"pin": "doubt", "text": "The growth is in doubt.", "on-panel": on_panel}, "a message")

    def test_a_message_waits_while_the_panel_is_seen_and_comes_when_it_is_not(self):
        its = self.message(True)
        self.assertIsNone(its.new_text({"doubt": True}, panel_is_seen=True))
        self.assertEqual(its.new_text({"doubt": True}, panel_is_seen=False), "The growth is in doubt.")
        self.assertIsNone(its.new_text({"doubt": True}, panel_is_seen=False), "once")

    def test_a_message_whose_cause_has_gone_meanwhile_never_comes(self):
        its = self.message(True)
        self.assertIsNone(its.new_text({"doubt": True}, panel_is_seen=True))
        self.assertIsNone(its.new_text({"doubt": False}, panel_is_seen=True))
        self.assertIsNone(its.new_text({"doubt": False}, panel_is_seen=False))

    def test_another_message_comes_at_once(self):
        self.assertEqual(self.message(False).new_text({"doubt": True}, panel_is_seen=True), "The growth is in doubt.")

    def test_the_panel_is_seen_for_three_seconds_after_each_beat(self):
        now = [100.0]
        component = {"panel-beat": 7}
        with unittest.mock.patch.object(linuxcnc_link.time, "monotonic", lambda: now[0]):
            link = linuxcnc_link.Link(component, [])
            self.assertFalse(link._panel_is_seen(), "a beat of before")
            component["panel-beat"] = 8
            self.assertTrue(link._panel_is_seen())
            now[0] += 2.9
            self.assertTrue(link._panel_is_seen())
            now[0] += 0.2
            self.assertFalse(link._panel_is_seen())


class Shipped(unittest.TestCase):
    """The messages of the configurations and of the functions, and the pins of programs that the functions take."""

    def test_no_two_functions_take_the_same_pin_of_programs(self):
        owners = {}
        for path in glob.glob(os.path.join(ROOT, "configs", "functions", "*", "*.hal")):
            with open(path) as file:
                text = re.sub(r"#.*", "", file.read())
            for pin in re.findall(r"\bmotion\.(?:digital|analog)-(?:in|out)-\d\d\b", text):
                owners.setdefault(pin, set()).add(os.path.basename(os.path.dirname(path)))
        self.assertGreater(len(owners), 20)
        self.assertEqual({pin: its for pin, its in owners.items() if len(its) > 1}, {})

    def test_codes_are_those_of_the_pin_that_is_netted_to_the_message(self):
        folders = [os.path.join(ROOT, "configs", name) for name in ("mill", "portal", "lathe", "grinder")]
        folders += [os.path.dirname(path) for path in self.of_functions()]
        self.assertGreaterEqual(len(folders), 4 + 6)
        for folder in folders:
            paths = glob.glob(os.path.join(folder, "*messages.toml"))
            self.assertTrue(paths, folder)
            ini = self.text(glob.glob(os.path.join(folder, "*.in[ic]")))
            hal = self.text(glob.glob(os.path.join(folder, "*.hal")))
            if os.path.basename(folder) == "thermal_growth_test":  # its log is loaded last, as the file of this machine does
                hal += self.text([os.path.join(ROOT, "configs", "growth", "log.hal")])
            hal += self.text(os.path.join(folder, path) for path in set(re.findall(r"(?m)^HALFILE = ((?:functions|growth_test)/.+\.hal)", ini)))
            modules = {}
            for module, names in re.findall(r"^loadrt (\w+) +names=(\S+)", hal, re.M):
                key = re.fullmatch(r"\[\w+\](\w+)", names)  # a value of the INI files
                for instances in re.findall(rf"(?m)^{key[1]} *= *(\S+)", ini) if key else [names]:
                    modules.update(dict.fromkeys(instances.split(","), module))
            for path, message in ((path, message) for path in paths for message in self.messages(path)):
                with self.subTest(folder=os.path.basename(folder), file=os.path.basename(path), pin=message["pin"]):
                    self.assertRegex(hal, r"(?m)^net .* (linuxcnc|sensor)-link\.%s( |$)" % message["pin"])
                    if "{code}" not in message["text"]:
                        continue
                    signal = re.search(r"^net (\S+) .*(?:linuxcnc|sensor)-link\.%s-code\b" % message["pin"], hal, re.M)[1]
                    writer = re.search(rf"^net {signal} +([\w-]+)\.(?:[\w-]+\.)*([\w-]+)( |$)", hal, re.M)
                    instance, pin = writer[1], writer[2]
                    program = instance.replace("-", "_").replace("plumb_", "plumb-")
                    module, codes = message["codes"].split()
                    self.assertEqual((modules.get(instance, program), pin), (module, codes.replace("CHANNEL.", "")))
                    self.assertTrue(plumb.declarations(module)["codes"][codes])

    def test_functions_of_one_machine_share_no_pin(self):
        linuxcnc_link.read_messages(*self.of_functions())
        own = {message["pin"]: message for path in self.of_functions() for message in self.messages(path)}
        shared = 0
        for path in glob.glob(os.path.join(ROOT, "configs", "*", "*messages.toml")):
            linuxcnc_link.read_messages(path)
            for message in self.messages(path):
                if message["pin"] in own:
                    self.assertEqual(message, own[message["pin"]], path)
                    shared += 1
        self.assertGreater(shared, 20)

    def test_a_status_is_not_told_where_another_message_tells_its_cause(self):
        told = {"interlock-fault": [8], "x-fault": [9], "retain-lost": [24], "io-lost": [29], "strokes-lost": [7, 24, 25, 28, 29]}
        statuses = 0
        for path in glob.glob(os.path.join(ROOT, "configs", "*", "*messages.toml")):
            messages = linuxcnc_link.read_messages(path)
            pins = {"x-fault" if re.fullmatch("[xyz]-fault", message.pin) else message.pin for message in messages}
            others = {code for pin in pins for code in told.get(pin, ())}
            for message in messages:
                if message.only_listed:
                    statuses += 1
                    with self.subTest(path=path, pin=message.pin):
                        self.assertLessEqual(others, set(message.left_out))
                        for code in others:
                            self.assertIsNone(message.new_text({message.pin: True, message.pin + "-code": code}))
                        self.assertIn("Turn the switch off and on" if 7 not in others else "service 2", " ".join(
                            str(message.new_text({message.pin: True, message.pin + "-code": code})) for code in (7, 26)))
        self.assertGreaterEqual(statuses, 6)

    @staticmethod
    def of_functions():
        return glob.glob(os.path.join(ROOT, "configs", "functions", "*", "*_messages.toml"))

    @staticmethod
    def messages(path):
        with open(path, "rb") as file:
            return tomllib.load(file)["message"]

    @staticmethod
    def text(paths):
        texts = []
        for path in paths:
            with open(path) as file:
                texts.append(file.read())
        return "\n".join(texts)


if __name__ == "__main__":
    unittest.main()

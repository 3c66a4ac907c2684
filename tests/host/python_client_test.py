# SPDX-License-Identifier: GPL-2.0-or-later
"""The Python client, against a real host. PLUMB_BUILD names the build folder."""

import ast
import importlib.util
import math
import os
import shutil
import signal
import sys
import threading
import unittest

import plumb
from tree import own_folder


class Options(unittest.TestCase):
    """Options of modules, in the place of those in loadrt lines."""

    def test_given_ones_replace_those_of_the_line_and_join_the_others(self):
        options = {"threads.period1": 4000000, "threads.name2": "slow", "threads.period2": 8000000, "lowpass.names": "one,two"}
        with plumb.Host(options=options) as host:
            host.command("loadrt threads name1=fast period1=1000000")
            host.command("loadrt lowpass names=it")
            threads = host.halcmd("-s", "show", "thread").output
            self.assertRegex(threads, r"(?m)^ *4000000 .*\bfast\b")
            self.assertRegex(threads, r"(?m)^ *8000000 .*\bslow\b")
            self.assertEqual(host.get(["one.gain", "two.gain"]), [0, 0])
            with self.assertRaisesRegex(plumb.Refused, "it.gain"):
                host.get("it.gain")

    def test_one_that_the_module_does_not_have_is_refused_when_it_is_loaded(self):
        with plumb.Host(options={"lowpass.nmaes": "one"}) as host:
            with self.assertRaisesRegex(plumb.Refused, "Unknown parameter .nmaes=one"):
                host.command("loadrt lowpass names=it")

    def test_one_without_a_module_is_refused(self):
        with self.assertRaisesRegex(plumb.HostDied, "MODULE.NAME=VALUE"):
            plumb.Host(options={"names": "one"})


class Filter(unittest.TestCase):
    """A filter without lag: out follows in a period later than it is set."""

    def setUp(self):
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        for line in (
            "loadrt threads name1=servo-thread period1=1000000",
            "loadrt lowpass names=it",
            "addf it servo-thread",
            "setp it.gain 1",
            "start",
        ):
            self.host.command(line)
        self.folder = own_folder(self)

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            file.write(text)
        return path

    def test_a_filter_follows_its_input(self):
        self.host.set("it.in", 2.5)
        ran = self.host.run(1)
        self.assertEqual(ran, plumb.Ran(time=1.0, ran=1.0, ended=""))
        self.assertEqual(self.host.get("it.out"), 2.5)
        self.assertEqual(self.host.get(["it.in", "it.gain"]), [2.5, 1.0])
        self.assertEqual(self.host.time, 1.0)

    def test_values_keep_their_types(self):
        self.host.command("loadrt not names=not")
        self.host.command("loadrt conv_s32_u32 names=convert")
        self.host.set("not.in", True)
        self.host.set("convert.in", -7)
        self.assertIs(self.host.get("not.in"), True)
        self.assertEqual(self.host.get("convert.in"), -7)
        self.assertIsInstance(self.host.get("convert.in"), int)
        self.assertIsInstance(self.host.get("it.in"), float)
        for value in (math.inf, -math.inf, 1e308, 0.1 + 0.2):
            self.host.set("it.in", value)
            self.assertEqual(self.host.get("it.in"), value)
        self.host.set("it.in", math.nan)
        self.assertTrue(math.isnan(self.host.get("it.in")))

    def test_many_pins_are_set_at_once_and_a_refusal_among_them_is_raised_when_all_are_answered(self):
        self.host.set({"it.in": 3, "it.gain": 0.5})
        self.assertEqual(self.host.get(["it.in", "it.gain"]), [3, 0.5])
        self.host.set({})
        with self.assertRaisesRegex(plumb.Refused, "'nothing'"):
            self.host.set({"it.in": 4, "nothing": 1, "it.gain": 1})
        self.assertEqual(self.host.get(["it.in", "it.gain"]), [4, 1])
        names = ["more%d" % number for number in range(12)]
        self.host.command("loadrt sum2 names=" + ",".join(names))
        pins = [name + pin for name in names for pin in (".in0", ".in1", ".gain0", ".gain1", ".offset", ".in0")]
        self.host.set({pin: number for number, pin in enumerate(pins)})
        self.assertEqual(self.host.get("more11.offset"), 70)

    def test_refusals_are_in_the_hosts_words(self):
        self.host.command("net input it.in")
        with self.assertRaisesRegex(plumb.Refused, "it.in.*connected to a signal"):
            self.host.set("it.in", 1)
        with self.assertRaisesRegex(plumb.Refused, "'nothing'"):
            self.host.get("nothing")
        with self.assertRaisesRegex(plumb.Refused, "no_such_module"):
            self.host.command("loadrt no_such_module")

    def test_files_are_loaded_with_the_values_of_an_ini_file(self):
        ini = self.write("machine.ini", "[FILTER]\nGAIN = 0.5\n")
        self.host.load(self.write("right.hal", "setp it.gain [FILTER]GAIN\n"), ini)
        self.assertEqual(self.host.get("it.gain"), 0.5)
        with self.assertRaisesRegex(plumb.Refused, "wrong.hal:2:.*it.gian"):
            self.host.load(self.write("wrong.hal", "\nsetp it.gian 1\n"))

    def test_halcmd_answers_even_after_a_failure(self):
        status, output = self.host.halcmd("getp", "it.gain")
        self.assertEqual((status, output.strip()), (0, "1"))
        self.assertNotEqual(self.host.halcmd("getp", "nothing").status, 0)

    def test_progress_is_reported_and_stops_a_run(self):
        calls = []

        def progress(seconds):
            calls.append(seconds)
            return len(calls) < 3

        ran = self.host.run(1e8, progress)
        self.assertEqual(len(calls), 3)
        self.assertEqual(calls, sorted(calls))
        self.assertLess(calls[-1], 1e8)
        self.assertGreaterEqual(ran.ran, calls[-1])
        self.assertEqual(self.host.time, ran.time)  # answers and requests are still in step
        self.assertEqual(self.host.get("it.gain"), 1.0)

    def test_an_interrupt_stops_a_run(self):
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            self.host.run(1e8)
        timer.join()
        self.assertGreater(self.host.time, 0)
        self.assertLess(self.host.time, 1e8)
        before = self.host.time
        self.host.run(1)
        self.assertAlmostEqual(self.host.time, before + 1)

    def test_records(self):
        file = os.path.join(self.folder, "record.csv")
        self.host.set("it.in", 3)
        identity = self.host.record(file, ["it.in", "it.out"], every=0.002)
        self.host.run(0.004)
        self.host.stop_recording(identity)
        self.host.run(1)
        with open(file) as lines:
            self.assertEqual(lines.read(), "time,it.in,it.out\n0,3,0\n0.002,3,3\n0.004,3,3\n")

    def test_replays_to_the_end_of_the_file(self):
        self.assertEqual(self.host.replay(self.write("ramp.csv", "time,it.in\n0,10\n1,20\n")), 1.0)
        self.assertEqual(self.host.run(0.5).ended, "")
        self.assertAlmostEqual(self.host.get("it.out"), 15, delta=0.011)
        self.assertEqual(self.host.run(3600), plumb.Ran(1.0, 0.5, "replay"))
        samples = self.write("samples.txt", "4\n5\n6\n")
        self.assertAlmostEqual(self.host.replay(samples, ["it.in"], 0.001), 0.002)

    def test_expectations(self):
        small = self.host.expect("x < 2.5", x="it.out")
        self.host.expect("finite(x)", x="it.out")
        for value in (1, 2, 3, 4, 1):
            self.host.set("it.in", value)
            self.host.run(0.001)
        self.assertEqual(self.host.violations(), [plumb.Violation(small, 2, 0.003, {"x": 3.0})])

    def test_programs_are_named(self):
        self.assertEqual(self.host.programs(), [])
        self.host.command("loadusr sleep 1000")
        self.assertEqual(self.host.programs(), ["sleep"])

    def test_a_second_client_shares_the_host(self):
        with plumb.Host(attach=self.host.socket) as second:
            second.set("it.in", 4)
            second.run(0.001)
        self.assertEqual(self.host.get("it.out"), 4.0)

    def test_a_dead_host_is_quoted(self):
        self.host.command('loadrt message names=m messages="the spindle is on fire"')
        self.host.command("addf m servo-thread")
        self.host.run(0.001)
        self.host.set("m.trigger", True)
        self.host.run(0.001)
        os.kill(self.host.process, signal.SIGKILL)
        with self.assertRaisesRegex(plumb.HostDied, r"died \(signal 9\); its last words: (.|\n)*on fire"):
            self.host.run(1)
        with self.assertRaises(plumb.HostDied):
            self.host.get("it.out")


class Start(unittest.TestCase):
    def test_it_fails_with_the_reason(self):
        with self.assertRaisesRegex(plumb.HostDied, "no virtual-time host at /no/such/socket"):
            plumb.Host(attach="/no/such/socket")
        with self.assertRaises(FileNotFoundError):
            plumb.Host(executable="/no/such/plumb-host")
        with self.assertRaisesRegex(plumb.HostDied, "control-fd"):
            plumb.Host(executable="/bin/ls")

    def test_closing_ends_the_host(self):
        with plumb.Host() as host:
            path = host.socket
            self.assertTrue(os.path.exists(path))
        self.assertFalse(os.path.exists(os.path.dirname(path)))
        with self.assertRaises(plumb.HostDied):
            host.run(1)


class Source(unittest.TestCase):
    def test_it_needs_the_standard_library_only(self):
        with open(plumb.__file__, "rb") as file:
            text = file.read()
        self.assertTrue(text.isascii())
        for node in ast.walk(ast.parse(text)):
            for name in getattr(node, "names", []) if isinstance(node, (ast.Import, ast.ImportFrom)) else []:
                self.assertIn(name.name.split(".")[0], sys.stdlib_module_names)


class Declarations(unittest.TestCase):
    def installed(self, prefix):
        """The client as it lies in an installation."""
        folder = os.path.join(prefix, "lib", "python3", "dist-packages")
        os.makedirs(folder)
        path = shutil.copy(plumb.__file__, folder)
        spec = importlib.util.spec_from_file_location("installed_plumb", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    def test_a_module_is_known_by_its_declarations(self):
        declared = plumb.declarations("thermal_displacement")
        self.assertEqual(declared["name"], "thermal_displacement")
        self.assertEqual(declared["pins"]["window"]["default"], 0.5)
        self.assertIn("update", declared["functions"])
        self.assertEqual(sorted(declared["codes"]), ["check-code", "detail-code", "status-code", "unanswered-code"])
        statuses = {str(code): text for code, text in declared["codes"]["status-code"].items()}
        self.assertEqual(statuses, {code: its["sentence"] for code, its in declared["statuses"].items()})
        for texts in declared["codes"].values():
            for text in texts.values():
                self.assertRegex(text, r"^[A-Z].* .*\.$")

    def test_a_program_has_declarations_too(self):
        self.assertEqual(plumb.declarations("plumb-retain")["pins"]["restored"]["type"], "bit")
        self.assertEqual(plumb.declarations("retain"), plumb.declarations("plumb-retain"))  # codes of messages of before

    def test_an_installation_has_its_own(self):
        prefix = own_folder(self)
        installed = self.installed(prefix)
        share = os.path.join(prefix, "share", "plumb")
        os.makedirs(share)
        with open(os.path.join(share, "lowpass.json"), "w") as file:
            file.write('{"name": "lowpass", "codes": {"fault-code": {"3": "It is cold."}}}')
        declared = installed.declarations("lowpass")
        self.assertEqual(declared["codes"], {"fault-code": {3: "It is cold."}})
        self.assertEqual((declared["pins"], declared["options"]), ({}, {}))
        with open(os.path.join(share, "lowpass.json"), "w") as file:
            file.write('{"name": "lowp')
        with self.assertRaisesRegex(ValueError, "share/plumb/lowpass.json is damaged: "):
            installed.declarations("lowpass")

    def test_options_of_a_load_line_decide_on_pins(self):
        growth, square = plumb.declarations("axis_growth"), plumb.declarations("squareness")
        for declared, short, options, there in (
            (growth, "temperature-0", {}, True), (growth, "temperature-1", {}, False), (growth, "temperature-1", {"sensors": "2"}, True),
            (growth, "temperature-2", {"sensors": "2"}, False), (growth, "temperature-4", {"sensors": "4"}, False),
            (growth, "enable", {}, False), (growth, "enable", {"interlock": "no"}, True),
            (square, "w-position", {}, False), (square, "w-position", {"chain": "w-X.b-W-Y-Z-C-t"}, True),
            (square, "to-bed", {"chain": "w-X.b-V-Y-Z-C-t"}, True), (square, "c-position", {}, False), (square, "c-position", {"rotary": "AC"}, True),
            (square, "max-rotary-speed", {"rotary": "B"}, True), (square, "max-rotary-speed", {}, False),
        ):
            self.assertEqual(plumb.has_pin(declared, short, options), there, (short, options))

    def test_a_module_that_is_not_there_is_named(self):
        share = os.path.join(os.path.abspath(os.environ["PLUMB_BUILD"]), "share", "plumb")
        for name in ("therm", "", "../plumb/thermal_displacement"):
            with self.assertRaises(FileNotFoundError) as raised:
                plumb.declarations(name)
            self.assertIn("cannot find the declarations of '%s' in %s" % (name, share), str(raised.exception))


if __name__ == "__main__":
    unittest.main()

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
import types
import unittest

import linuxcnc_runs
from linuxcnc_runs import BUILD, ROOT, copy_configuration, own_folder

sys.path[:0] = [os.path.join(BUILD, "python"), os.path.join(BUILD, "share", "plumb"), os.path.join(ROOT, "components", "io", "linuxcnc_link"),
                os.path.join(ROOT, "tests", "programs")]
import lamp  # noqa: E402
import linuxcnc_link  # noqa: E402
import plumb  # noqa: E402

LINK = os.path.join(BUILD, "bin", "linuxcnc_link")
PATIENCE = 100  # s, for an event that takes a few

HAL = """\
loadrt thermal_displacement names=growth
addf growth.update servo-thread
loadusr -Wn linuxcnc-link {build}/bin/linuxcnc_link
loadusr -W {build}/bin/plumb-retain --file $(CONFIG_DIR)/mill.toml
"""

RETAIN = """\
machine = "mill"
pins = ["growth.window"]
records = ["growth"]
every = 0.5
"""

# LinuxCNC loads it when its screen is there.
LATE = """\
loadrt squareness names=square
addf square.update servo-thread
loadusr -Wn lamp {root}/tests/programs/lamp.py
loadusr -Wn stranger /usr/bin/python3 {machine}/stranger.py
"""

STRANGER = """\
import hal, time
component = hal.component("stranger")
component.newpin("status-code", hal.HAL_S32, hal.HAL_OUT)
component.ready()
time.sleep(1e6)
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
        files = dict(PROGRAMS, **{"link.hal": HAL.format(build=BUILD), "messages.toml": lamp.MESSAGES, "mill.toml": RETAIN,
                               "late.hal": LATE.format(root=ROOT, machine=machine), "stranger.py": STRANGER})
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

    def test_comments_blanks_case_and_numbers_of_lines_make_no_other_program(self):
        before, after = self.facts[0]["edited comments"]
        self.assertEqual(before, after)

    def test_the_tool_set_is_that_of_the_table_with_any_tool_in_the_spindle(self):
        before, after, measured = self.facts[0]["tools"]
        self.assertEqual(before, after)
        self.assertEqual(before, measured, "another length along Z is no other tool")
        self.assertNotEqual(before, 0)

    def test_the_operator_reads_the_messages_of_all_instances(self):
        told = self.facts[0]["messages"]
        growth, square = (plumb.declarations(module)["codes"] for module in ("thermal_displacement", "squareness"))
        self.assertEqual(told["of the start"], [])
        self.assertEqual(len(told["a fault"]), 1)
        self.assertTrue(told["a fault"][0].startswith("Growth of Z: A fault is active. " + growth["detail-code"][6]), told["a fault"])
        self.assertEqual(told["the same fault"], [])
        late = sorted(told["late"])
        self.assertEqual(len(late), 2, late)
        self.assertTrue(late[0].startswith("Squareness: The max speed"), late)
        self.assertIn("not set", late[0])
        self.assertTrue(square["fault-code"][10].startswith("The max-speed is not set"))
        self.assertTrue(late[1].startswith("stranger has a status-code, and no texts"), late)
        self.assertEqual(told["of the user"], ["Lamp: The lamp is dark. The thread is broken. Replace it."])
        self.assertEqual(told["behind the panel"], [[], ["Lamp: The lamp flickers. The thread is broken."]])

    def test_a_wrong_file_ends_the_program_with_the_place(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[lamp]\ncolour = 1\n")
            file.flush()
            ended = subprocess.run(["/usr/bin/python3", LINK, "--messages", file.name], capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(ended.returncode, 1)
        self.assertEqual(ended.stderr, "linuxcnc_link: %s: [lamp]: unknown key 'colour', none of title, statuses, codes, told\n" % file.name)


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


class BehindThePanel(unittest.TestCase):
    def test_the_panel_is_seen_for_three_seconds_after_each_beat(self):
        component = {"panel-beat": 7}
        beats = linuxcnc_link.PanelBeats(component)
        self.assertFalse(beats.are_heard(100), "a beat of before")
        component["panel-beat"] = 8
        self.assertTrue(beats.are_heard(100))
        self.assertTrue(beats.are_heard(102.9))
        self.assertFalse(beats.are_heard(103.1))


class Shipped(unittest.TestCase):
    def test_no_two_functions_take_the_same_pin_of_programs(self):
        owners = {}
        for path in glob.glob(os.path.join(ROOT, "configs", "functions", "*", "*.hal")):
            with open(path) as file:
                text = re.sub(r"#.*", "", file.read())
            for pin in re.findall(r"\bmotion\.(?:digital|analog)-(?:in|out)-\d\d\b", text):
                owners.setdefault(pin, set()).add(os.path.basename(os.path.dirname(path)))
        self.assertGreater(len(owners), 20)
        self.assertEqual({pin: its for pin, its in owners.items() if len(its) > 1}, {})

    def test_no_configuration_nets_a_message(self):
        own = "program-id|tool-set-id|connected|identify|identified|heartbeat|state|compensation-side|panel-beat|zero-set|work-offset"
        nets = 0
        for path in glob.glob(os.path.join(ROOT, "configs", "**", "*.hal"), recursive=True):
            with open(path) as file:
                text = re.sub(r"#.*", "", file.read())
            nets += len(re.findall(r"\blinuxcnc-link\.", text))
            self.assertEqual(re.findall(r"\blinuxcnc-link\.(?!(?:%s)\b)\S+" % own, text), [], path)
        self.assertGreater(nets, 10)
        self.assertEqual(glob.glob(os.path.join(ROOT, "configs", "**", "*messages.toml"), recursive=True), [])


if __name__ == "__main__":
    unittest.main()

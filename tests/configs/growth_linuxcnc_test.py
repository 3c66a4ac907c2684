#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/growth: a growth test by the G-code in a complete LinuxCNC, killed and resumed; on a trunnion; without a table; and with
axis_growth as the compensation."""

import contextlib
import csv
import glob
import json
import os
import signal
import subprocess
import time
import unittest

from linuxcnc_runs import (
    BUILD,
    PATIENCE,
    at_the_end,
    change,
    copy_configuration,
    finish,
    own_folder,
    own_ini,
    run_to_the_end,
    start,
    um,
)
from long import long
from starts import starts

SHORT = "#<_growth_rounds> = 1\n#<_growth_dwell> = 6\n#<_growth_feed> = 60\n"

# From the end of the first cycle on the maximum time is over.
SHORT_HAL = """loadrt flipflop names=cycled
loadrt mux2 names=longest
setp longest.in0 100000
setp longest.in1 1
setp growth-test.minimum-time 1
setp artifact.tau-turning 5
setp artifact.sensor-lag 1
net longest longest.out => growth-test.maximum-time
net test-cycle => cycled.set
net cycled cycled.out => longest.sel
addf cycled servo-thread
addf longest servo-thread
"""


def logs(machine):
    return sorted(glob.glob(os.path.join(machine, "logs", "growth-*.csv")))


def records(machine, kind):
    (path,) = logs(machine)
    with open(path, encoding="ascii") as file:
        return [line for line in csv.reader(file) if line and line[0] == kind]


def report(machine):
    (path,) = logs(machine)
    done = subprocess.run([os.path.join(BUILD, "bin", "plumb-growth"), "report", path, "--json"], check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)["tests"][0]


def program(machine, name, call, settings=SHORT):
    with open(os.path.join(machine, name), "w", encoding="ascii") as file:
        file.write("o<settings> call\n%so<growth_test> call %s\nM2\n" % (settings, call))


def shortened(machine, ini):
    """The test stops after its first cycle, however long the computer takes for it."""
    with open(os.path.join(machine, "short.hal"), "w", encoding="ascii") as file:
        file.write(SHORT_HAL)
    return own_ini(os.path.join(machine, ini), HAL=at_the_end("HALFILE = short.hal"))


def gone(folder):
    """Until the programs of a killed LinuxCNC have left its folder."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        busy = False
        for path in glob.glob("/proc/[0-9]*/cmdline"):
            try:
                with open(path, "rb") as file:
                    busy = busy or (folder.encode() in file.read() and int(path.split("/")[2]) != os.getpid())
            except OSError:
                continue
        if not busy:
            return
        time.sleep(0.05)
    raise AssertionError("programs of a killed LinuxCNC are still there")


def running(word):
    """The programs that have this word on their command line."""
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        with contextlib.suppress(OSError), open(path, "rb") as file:
            if word.encode() in file.read().split(b"\0"):
                yield int(path.split("/")[2])


def run(folder, machine, ini, *arguments):
    """Exit status and output."""
    return run_to_the_end(machine, lambda: start(folder, ini, *arguments))


class KilledAndResumed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = own_folder(cls)
        cls.machine = copy_configuration("growth", cls.folder)
        mirrored = "#<_growth_mirrored> = 1\n" + SHORT
        program(cls.machine, "short.ngc", "[1] [1] [1] [0]", mirrored)
        program(cls.machine, "again.ngc", "[1] [1] [1] [1]", mirrored)
        ini = shortened(cls.machine, "growth.ini")
        cls.kill_after_touches(ini, 15)
        cls.kept = len(records(cls.machine, "touch"))
        cls.status, cls.output = run(cls.folder, cls.machine, ini, "again.ngc")
        cls.results = report(cls.machine) if cls.status == 0 else None

    @classmethod
    def kill_after_touches(cls, ini, count):
        process = start(cls.folder, ini, "short.ngc")
        end = time.monotonic() + PATIENCE
        while not logs(cls.machine) or len(records(cls.machine, "touch")) < count:
            if time.monotonic() > end or process.poll() is not None:
                raise AssertionError("no touches came:\n" + finish(process)[1])
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        gone(cls.folder)

    def test_the_test_goes_on_in_the_same_log_to_its_end(self):
        self.assertEqual(self.status, 0, self.output)
        self.assertIn("again.ngc is done", self.output)
        events = [line[9] for line in records(self.machine, "event")]
        self.assertEqual(events[0], "begin")
        self.assertIn("resumed", events)
        self.assertIn("stop", events)
        self.assertEqual(events[-1], "end")
        self.assertGreater(len(records(self.machine, "touch")), self.kept)

    def test_passes_are_mirrored(self):
        last = records(self.machine, "event")[-1][3]
        order = [(line[6], line[7]) for line in records(self.machine, "event") if line[9] == "measured" and line[3] == last]
        self.assertEqual(order, [("0", "0"), ("1", "0"), ("0", "0"), ("0", "1"), ("1", "1"), ("0", "1")])  # turned, compensated

    def test_each_touch_has_the_direction_and_the_place_of_its_bore(self):
        for line in records(self.machine, "touch"):
            x, y, z = (float(value) for value in line[10:13])
            axis = {"X": x, "Y": y + 60, "Z": z + 137 + 12}[line[9][1]]
            expected = 12 if line[9][0] == "+" else -12
            if line[9][1] == "Z":
                expected = 12
            self.assertLess(abs(axis - expected), 0.2, line)

    def test_both_states_and_orientations_are_in_the_results(self):
        self.assertEqual({(s["turned"], s["compensated"]) for s in self.results["series"]}, {(a, b) for a in (False, True) for b in (False, True)})
        for series in self.results["series"]:
            for point in series["points"]:
                self.assertLess(abs(point["diameter_mm"] - 30), 50 * um)
                self.assertLess(point["scatter_mm"], 10 * um)  # a period is 1 um here
            if not series["compensated"]:
                self.assertTrue(all(value == 0 for point in series["points"] for value in point["compensation_mm"]))
        self.assertTrue(any(abs(value) > um for s in self.results["series"] if s["compensated"] for p in s["points"] for value in p["compensation_mm"]))


@long
class Trunnion(unittest.TestCase):
    def test_a_trunnion_and_one_state_are_probed(self):
        folder = own_folder(type(self))
        machine = copy_configuration("growth", folder)
        cool_down = "#<_growth_cool_down> = 2\n#<_growth_rest> = 1\n"
        program(machine, "trunnion.ngc", "[1] [1] [0] [0]", "#<_growth_trunnion> = 1\n" + cool_down + SHORT)
        change(os.path.join(machine, "growth.toml"), "folder       =", 'table        = "A"\nfolder       =')
        status, output = run(folder, machine, shortened(machine, "trunnion.ini"))
        self.assertEqual(status, 0, output)
        results = report(machine)
        self.assertEqual([(s["turned"], s["compensated"]) for s in results["series"]], [(False, False), (True, False)])
        self.assertIn("Only one state was probed", results["compensation"]["sentence"])
        self.assertEqual(len(results["orientations"]), 1)
        self.assertEqual({(len(s["points"]), len(s["cool_down"])) for s in results["series"]}, {(2, 2)})
        self.assertTrue(results["practice"]["artifact"]["applied"])


@long
class Single(unittest.TestCase):
    def test_a_program_that_is_aborted_without_a_message_is_not_called_done(self):
        folder = own_folder(type(self))
        machine = copy_configuration("growth", folder)
        with open(os.path.join(machine, "aborts.ngc"), "w", encoding="ascii") as file:
            file.write("M64 P0\nG4 P30\nM2\n")
        with open(os.path.join(machine, "abort.hal"), "w", encoding="ascii") as file:
            file.write("net own-abort motion.digital-out-00 => halui.abort\n")
        ini = own_ini(os.path.join(machine, "growth.ini"), HAL=at_the_end("HALFILE = abort.hal"))
        status, output = run(folder, machine, ini, "aborts.ngc")
        self.assertEqual(status, 1, output)
        self.assertNotIn("aborts.ngc is done", output)
        self.assertIn("aborts.ngc was aborted before its end, and LinuxCNC gave no reason", output)

    def test_a_log_that_has_died_is_told(self):
        folder = own_folder(type(self))
        machine = copy_configuration("growth", folder)
        begun = os.path.join(machine, "begun")
        with open(os.path.join(machine, "waits.ngc"), "w", encoding="ascii") as file:
            file.write("(LOGOPEN,%s)\n(LOGCLOSE)\nG4 P300\nM2\n" % begun)
        process = start(folder, os.path.join(machine, "growth.ini"), "waits.ngc")
        end = time.monotonic() + PATIENCE
        while not os.path.exists(begun) and time.monotonic() < end and process.poll() is None:
            time.sleep(0.05)
        for number in running(os.path.join(machine, "growth.toml")):
            os.kill(number, signal.SIGKILL)
        status, output = finish(process)
        self.assertEqual(status, 1, output)
        self.assertIn("growth_log (service 6) does not answer. The growth test is not written. Start growth_log again", output)
        self.assertNotIn("waits.ngc is done", output)

    def test_a_sphere_without_table_and_second_state_is_probed_with_temperature_control(self):
        folder = own_folder(type(self))
        machine = copy_configuration("growth", folder)
        program(machine, "sphere.ngc", "[1] [0] [0] [0]", "#<_growth_cooling> = 1\n#<_growth_by_plan> = 1\n#<_growth_first> = 9\n" + SHORT)
        plan = os.path.join(machine, "growth_plan.ngc")
        change(plan, "#<_growth_planned> = 5", "#<_growth_planned> = 2")
        change(plan, "#<_growth_minutes> = 30", "#<_growth_minutes> = 0.1")
        change(plan, "EQ 2]\n  #<_growth_speed> = 8000", "EQ 2]\n  #<_growth_speed> = 2000")
        status, output = run(folder, machine, shortened(machine, "growth.ini"), "sphere.ngc")
        self.assertEqual(status, 0, output)
        self.assertIn("Growth test: ", output)  # that it has reached its end
        results = report(machine)
        self.assertEqual([(s["bore"], s["turned"], s["compensated"]) for s in results["series"]], [(9, False, False)])
        for point in results["series"][0]["points"]:
            self.assertLess(abs(point["diameter_mm"] - 20), 50 * um)
            self.assertTrue(all(abs(value) < 50 * um for value in point["deviation_mm"]), point)  # none is null
        self.assertEqual({line[8] for line in records(machine, "touch")}, {"1"})  # temperature control
        ends = [float(line[2]) for line in records(machine, "event") if line[9] == "cycle-end"]
        self.assertEqual(len(ends), 2)  # both cycles of the plan, though the time was over after the first
        speeds = [(float(line[2]), float(line[3])) for line in records(machine, "speed")]
        self.assertGreater(max(speed for time, speed in speeds if time <= ends[0] + 5), 2100)
        self.assertTrue(500 < max(speed for time, speed in speeds if time > ends[0] + 5) < 2001, speeds)


class Identified(unittest.TestCase):
    def test_axis_growth_with_the_settings_of_a_file_is_the_compensation_under_test(self):
        folder = own_folder(type(self))
        machine = copy_configuration("growth", folder)
        program(machine, "short.ngc", "[1] [0] [1] [0]")
        with open(os.path.join(machine, "identified_settings.hal"), "w", encoding="ascii") as file:
            lines = {"z-growth-0": 0.001, "z-sigma": 0.0005, "reference-0": 20, "rise-low-0": -2, "rise-high-0": 30, "smoothing": 1, "harmless": 0.1}
            file.writelines("setp axis-growth.%s %g\n" % line for line in lines.items())
        status, output = run(folder, machine, shortened(machine, "identified.ini"), "short.ngc")
        self.assertEqual(status, 0, output)
        results = report(machine)
        visits = [(line[3], line[7]) for line in records(machine, "event") if line[9] == "measured"]
        self.assertEqual([state for number, state in visits if number == "1"], ["0", "1"] * 2)  # the first bore again, in both states
        off, on = (next(s["points"] for s in results["series"] if s["compensated"] == state) for state in (False, True))
        self.assertTrue(all(value == 0 for point in off for value in point["compensation_mm"]))
        warmest = max(float(line[4]) for line in records(machine, "temperature") if line[3] == "1")
        applied = max(point["compensation_mm"][2] for point in on)
        self.assertGreater(applied, 2 * um)
        self.assertLess(applied, (warmest - 20 + 0.5) * um)  # 1 um for 1 K
        self.assertEqual([point["compensation_mm"][0] for point in on], [0] * len(on))
        for without, compensated in zip(off, on):
            left = without["deviation_mm"][2] - (compensated["compensation_mm"][2] - on[0]["compensation_mm"][2])
            self.assertLess(abs(compensated["deviation_mm"][2] - left), 5 * um)


# Touches on the cold machine, works for five minutes, and touches twice.
TOUCHES = """
from plumb_linuxcnc import Machine

with Machine() as machine:
    machine.turn_on()
    machine.home()
    host = machine.host

    def touch():
        machine.run("touch.ngc")
        print("touch", *(host.get("axis-growth." + pin) for pin in ("touch-code", "z-offset", "z-touch-change")))

    machine.mdi("M64 P30")  # the compensation is on
    touch()
    machine.mdi("M3 S8000")
    machine.wait(300)
    machine.mdi("M5")
    touch()
    touch()
    machine.wait(30)
    print("end", host.get("axis-growth.z-offset"))
"""


class TouchedReference(unittest.TestCase):
    def test_two_touches_of_a_fixed_surface_correct_the_law(self):
        folder = own_folder(type(self))
        machine = copy_configuration("growth", folder)
        with open(os.path.join(machine, "touches.py"), "w", encoding="ascii") as file:
            file.write(TOUCHES)
        with open(os.path.join(machine, "identified_settings.hal"), "w", encoding="ascii") as file:
            lines = {"z-growth-0": 0.002, "reference-0": 20, "smoothing": 1, "max-rate": 0.01}
            file.writelines("setp axis-growth.%s %g\n" % line for line in lines.items())
        ini = own_ini(os.path.join(machine, "identified.ini"))
        status, output = run(folder, machine, ini, "touches.py")
        self.assertEqual(status, 0, output)
        lines = [line.split() for line in output.splitlines()]
        touches = [tuple(map(float, line[1:])) for line in lines if line[:1] == ["touch"]]
        self.assertEqual([touch[0] for touch in touches], [1, 3, 4], output)  # the reference, the first one, the law is corrected
        end = next(float(line[1]) for line in lines if line[:1] == ["end"])
        self.assertGreater(end - touches[1][1], 4 * um, output)  # the law is too small by a quarter
        self.assertLess(end - touches[1][1], 15 * um, output)


tearDownModule = starts("growth/growth.ini", "growth/trunnion.ini", "growth/identified.ini")


if __name__ == "__main__":
    unittest.main()

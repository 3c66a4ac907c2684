#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire --apply, --check, --remove and --undo on a sample of LinuxCNC: the INI file comes back byte for byte."""

import os
import re
import subprocess
import sys
import unittest
import unittest.mock

from tree import BUILD, own_folder
from wire_sample import AXIS_MM, Sample, plumb_wire, read, write

sys.path[1:1] = [os.path.join(BUILD, "share", "plumb", name) for name in ("wiring", "models")]
import applying  # noqa: E402
from texts import Impossible  # noqa: E402


def read_bytes(path):
    with open(path, "rb") as file:
        return file.read()


class Apply(Sample):
    def wire_ini(self, *arguments):
        return plumb_wire(*arguments, "--ini", self.ini(AXIS_MM))

    def test_it_is_applied_checked_removed_and_undone(self):
        # Line ends of DOS, no end of the last line, and rights of the user's own
        text = read_bytes(self.ini(AXIS_MM)).replace(b"\n", b"\r\n").rstrip()
        with open(self.ini(AXIS_MM), "wb") as file:
            file.write(text)
        os.chmod(self.ini(AXIS_MM), 0o640)
        home = os.path.dirname(self.ini(AXIS_MM))
        names = set(os.listdir(home))

        status, output, flat = self.wire_ini("squareness", "axis_growth", "--apply")
        self.assertEqual(status, 0, output)
        applied = read_bytes(self.ini(AXIS_MM))
        self.assertEqual(applied.count(b"\n"), applied.count(b"\r\n"))
        self.assertRegex(flat, r"Changed axis_mm.ini; axis_mm.ini.before-plumb is the file as it was .* \d+ \+ HALFILE = plumb/plumb.hal")
        self.assertEqual(read_bytes(self.ini(AXIS_MM) + ".before-plumb"), text)
        self.assertEqual(os.stat(self.ini(AXIS_MM)).st_mode & 0o777, 0o640)
        # LinuxCNC starts with each function off.
        self.assertNotIn("function-switch", read(os.path.join(self.folder(AXIS_MM), "stages.hal")))
        self.assertIn("`setp interlock.function-switch-1 1` (axis_growth)", flat)
        lines = applied.decode().split("\r\n")
        for line in ("HALFILE = plumb/order.tcl", "CHAIN = w-X-Y.b-Z-C-t", "ACCESS = operator", "SETTINGS = plumb/panel.toml"):
            self.assertIn(line, lines)
        self.assertFalse([line for line in lines if line.startswith("#INCLUDE")])  # which LinuxCNC would not find here

        self.assertEqual(self.wire_ini("--check")[0], 0)
        # A file of the user's with a pin and a signal of ours keeps its place behind ours.
        write(os.path.join(home, "mine.hal"), "loadrt sum2 names=mine\nnet mine-in square.x-error \\\n  => mine.in0\nnet x-correction => mine.in1\n")
        write(self.ini(AXIS_MM), applied.decode().replace("HALFILE = plumb/order.tcl", "HALFILE = plumb/order.tcl\r\nHALFILE = mine.hal"))
        status, output, flat = self.wire_ini("squareness", "--apply")
        self.assertEqual(status, 0, output)
        files = re.findall(r"(?m)^HALFILE = (\S+)\r$", read_bytes(self.ini(AXIS_MM)).decode())
        self.assertEqual(files[-3:], ["plumb/plumb.hal", "plumb/order.tcl", "mine.hal"])
        self.assertRegex(read(os.path.join(self.folder(AXIS_MM), "squareness.hal")), r"(?m)^net x-correction ")
        self.assertEqual(self.wire_ini("--check")[0], 0)
        os.unlink(os.path.join(home, "mine.hal"))
        write(self.ini(AXIS_MM), applied.decode())
        write(self.ini(AXIS_MM), re.sub(r"(?s)(\[JOINT_0\].*?MAX_ACCELERATION *= *)[\d.]+", r"\g<1>400", applied.decode()))
        status, output, flat = self.wire_ini("--check")
        self.assertEqual(status, 1, output)
        self.assertIn("stages.hal would be another: -setp x-stage.offset-acceleration", flat)

        # The other function keeps its number.
        status, output, flat = self.wire_ini("--remove", "squareness")
        self.assertEqual(status, 0, output)
        self.assertIn("setp interlock.function-services-1 0\n", read(os.path.join(self.folder(AXIS_MM), "stages.hal")))
        self.assertFalse(os.path.exists(os.path.join(self.folder(AXIS_MM), "squareness.hal")))

        status, output, flat = self.wire_ini("--undo")
        self.assertEqual(status, 0, output)
        edited = re.sub(rb"(?s)(\[JOINT_0\].*?MAX_ACCELERATION *= *)[\d.]+", rb"\g<1>400", text)
        self.assertEqual(read_bytes(self.ini(AXIS_MM)), edited)
        self.assertEqual(set(os.listdir(home)) - names, {"plumb"})
        status, output, flat = self.wire_ini("--undo")
        self.assertEqual(status, 1)
        self.assertIn("has no changes of plumb wire --apply", flat)


class Applied(unittest.TestCase):
    """The changes of files, without LinuxCNC."""

    def setUp(self):
        self.home = own_folder(self)
        self.ini = os.path.join(self.home, "my.ini")
        self.before = "[HAL]\nHALFILE = a.hal\n[TRAJ]\nMAX = 3"
        self.after = "[HAL]\nHALFILE = a.hal\nHALFILE = plumb.hal\n[TRAJ]\nMAX = 4\n[SQUARENESS]\nCHAIN = x\n"
        write(self.ini, self.before)
        os.mkdir(os.path.join(self.home, "plumb"))

    def applied(self):
        return applying.Applied(os.path.join(self.home, "plumb"), self.home, self.ini)

    def test_lines_of_the_user_stay_and_ours_go(self):
        self.applied().apply({self.ini: (self.before, self.after)})
        self.assertEqual(read(self.ini), self.after)
        write(self.ini, "# mine\n" + self.after.replace("[TRAJ]\n", "HALFILE = b.hal\n[TRAJ]\nMIN = 1\n"))
        again = self.applied()
        self.assertEqual(again.undo(), ["my.ini"])
        self.assertEqual(read(self.ini), "# mine\n[HAL]\nHALFILE = a.hal\nHALFILE = b.hal\n[TRAJ]\nMIN = 1\nMAX = 3")
        self.assertEqual(again.notes, [])

    def test_a_line_of_ours_that_the_user_has_changed_stays_and_is_named(self):
        self.applied().apply({self.ini: (self.before, self.after)})
        write(self.ini, self.after.replace("CHAIN = x", "CHAIN = y"))
        again = self.applied()
        again.undo()
        self.assertIn("CHAIN = y", read(self.ini))
        self.assertEqual(len(again.notes), 1)
        self.assertIn("`CHAIN = x`", again.notes[0])

    def test_any_place_at_which_it_breaks_off_can_be_undone(self):
        for call in ("os.rename", "os.fsync"):
            for number in range(6):
                self.setUp()
                real, left = getattr(os, call[3:]), [number]

                def fails(*arguments, real=real, left=left, **more):
                    left[0] -= 1
                    if left[0] < 0:
                        raise OSError(28, "No space left on device")
                    return real(*arguments, **more)

                with unittest.mock.patch(call, side_effect=fails):
                    try:
                        self.applied().apply({self.ini: (self.before, self.after)})
                    except (OSError, applying.writing.PartlyWritten):
                        pass
                self.assertIn(read(self.ini), (self.before, self.after))
                again = self.applied()
                self.assertEqual(again.without(self.ini, read(self.ini)), self.before)
                self.assertFalse([name for name in os.listdir(self.home) if name.endswith(".new")])

    def test_it_refuses_while_linuxcnc_runs_there(self):
        program = "import time; print(flush=True); time.sleep(60)"
        with subprocess.Popen(
            [sys.executable, "-c", program, "-ini", "my.ini"], cwd=self.home, stdout=subprocess.PIPE
        ) as process:
            self.addCleanup(process.kill)
            process.stdout.readline()
            with self.assertRaisesRegex(Impossible, r"LinuxCNC runs with \S+/my.ini \(process %d\)" % process.pid):
                self.applied().apply({self.ini: (self.before, self.after)})
            process.kill()
        self.assertEqual(read(self.ini), self.before)

    def test_a_link_is_refused(self):
        os.rename(self.ini, self.ini + ".there")
        os.symlink(self.ini + ".there", self.ini)
        with self.assertRaisesRegex(Impossible, "is a link to"):
            self.applied().apply({self.ini: (self.before, self.after)})


if __name__ == "__main__":
    unittest.main()

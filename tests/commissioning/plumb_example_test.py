# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb example: what a copy has. The tests of each configuration run such a copy in LinuxCNC."""

import os
import re
import stat
import subprocess
import unittest

from tree import BUILD, ROOT, own_folder

CONFIGURATIONS = ["grinder", "growth", "lathe", "mill", "portal", "three_axis"]


def files_in(folder):
    return {os.path.relpath(os.path.join(place, name), folder) for place, _, names in os.walk(folder) for name in names}


class Example(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)

    def example(self, *words):
        program = os.path.join(BUILD, "bin", "plumb")
        return subprocess.run([program, "example", *words], cwd=self.folder, capture_output=True, text=True, timeout=60, check=False)

    def test_a_copy_has_what_its_files_name_and_no_other_function(self):
        done = self.example("grinder")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout.splitlines()[1], "Start it with  linuxcnc grinder/axis.ini")
        copy = files_in(os.path.join(self.folder, "grinder"))
        self.assertEqual({name for name in copy if name.startswith("functions/")},
                         {"functions/plumb_order.tcl"} | {"functions/chopping/" + name for name in
                          os.listdir(os.path.join(ROOT, "configs", "functions", "chopping"))
                          if name.endswith(".ngc") or name in ("chopping.hal", "chopping_infeed.hal")})
        self.assertLessEqual({"grinder.ini", "stages.hal", "on_abort.ngc", "bench.hal", "README.md", "common/headless.py"}, copy)

    def test_each_place_that_a_copy_names_is_in_it_and_none_is_a_link(self):
        for name in CONFIGURATIONS:
            self.assertEqual(self.example(name, "my-" + name).returncode, 0)
            folder = os.path.join(self.folder, "my-" + name)
            for path in files_in(folder):
                place = os.path.join(folder, path)
                self.assertTrue(stat.S_ISREG(os.lstat(place).st_mode), path)
                if path.endswith((".ini", ".inc", ".hal")):
                    with open(place, encoding="utf-8") as file:
                        lines = [line for line in file if line[0] != "#" or line.startswith("#INCLUDE")]
                    for named in re.findall(r"\b(?:common|functions)/[\w./-]*\w", "".join(lines)):
                        self.assertTrue(os.path.exists(os.path.join(folder, named)), "%s of %s names %s" % (path, name, named))

    def test_each_file_of_settings_in_a_copy_is_in_force(self):
        for name in CONFIGURATIONS:
            self.assertEqual(self.example(name, name).returncode, 0)
            folder = os.path.join(self.folder, name)
            copy, halfiles = files_in(folder), set()
            for path in filter(lambda path: path.endswith((".ini", ".inc")), copy):
                with open(os.path.join(folder, path), encoding="utf-8") as file:
                    halfiles |= set(re.findall(r"^HALFILE *= *(\S+)", file.read(), re.M))
            self.assertEqual({path for path in copy if path.endswith("settings.hal")} - halfiles, set(), name)

    def test_programs_of_a_copy_can_be_started(self):
        self.example("lathe", "it")
        for name in ("common/headless.py", "functions/centre_height/M159", "functions/centre_height/tool_table_check"):
            self.assertTrue(os.access(os.path.join(self.folder, "it", name), os.X_OK), name)

    def test_nothing_is_overwritten(self):
        for kind in ("folder", "file", "dangling link"):
            path = os.path.join(self.folder, kind)
            {"folder": os.mkdir, "file": lambda name: open(name, "w").close(), "dangling link": lambda name: os.symlink("nowhere", name)}[kind](path)
            done = self.example("mill", kind)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr, "plumb example: %s is there already; give another folder: plumb example mill FOLDER\n" % path)
        self.assertEqual(files_in(os.path.join(self.folder, "folder")), set())

    def test_a_path_that_linuxcnc_cannot_read_is_refused(self):
        done = self.example("mill", "my mill")
        self.assertEqual(done.returncode, 1)
        self.assertIn("my mill has a blank, and LinuxCNC cannot read these INI files there", done.stderr)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "my mill")))

    def test_a_folder_that_cannot_be_written_is_named(self):
        with open(os.path.join(self.folder, "file"), "w"):
            pass
        done = self.example("mill", "file/mill")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("plumb example: nothing was copied: %s" % os.path.join(self.folder, "file"), done.stderr)

    def test_an_unknown_name_is_answered_by_the_list(self):
        done = self.example("mil")
        self.assertEqual(done.returncode, 2)
        self.assertIn("there is no configuration 'mil'; is it mill? There are", done.stderr)
        listed = re.findall(r"^  (\w+) ", self.example().stderr, re.M)
        self.assertEqual(listed, CONFIGURATIONS)
        for name in ("../mill", "functions", "common", ""):
            self.assertEqual(self.example(name).returncode, 2, name)
        self.assertEqual(files_in(self.folder), set())


if __name__ == "__main__":
    unittest.main()

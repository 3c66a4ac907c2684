# SPDX-License-Identifier: GPL-2.0-or-later
"""Temporary folders: gone at the end of their program, removed after its death, and never while it lives."""

import os
import signal
import subprocess
import sys
import unittest

import plumb_folder
from plumb_folder import TemporaryFolder
from tree import own_folder

# Makes a folder, says its path, and lives until its input ends.
PROGRAM = """
import sys, plumb_folder
folder = plumb_folder.TemporaryFolder(sys.argv[1])
print(folder.name, flush=True)
sys.stdin.read()
"""
# Makes folders beside others that do the same, and looks whether it has them.
MAKER = """
import os, sys, plumb_folder
sys.stdin.readline()
for _ in range(300):
    with plumb_folder.TemporaryFolder(sys.argv[1]) as folder:
        open(os.path.join(folder, "file"), "x").close()
"""
APART = ["unshare", *([] if os.geteuid() == 0 else ["--user", "--map-current-user"]), "--pid", "--fork", "--mount-proc", "--kill-child"]
APART_WORKS = subprocess.run([*APART, "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0


class Folders(unittest.TestCase):
    def setUp(self):
        self.place = own_folder(self)

    def start(self, program, prefix=()):
        environment = {**os.environ, "PYTHONPATH": os.path.dirname(plumb_folder.__file__)}
        process = subprocess.Popen([*prefix, sys.executable, "-c", program, self.place], env=environment, stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        return process

    def folder_of(self, process):
        path = process.stdout.readline().strip()
        self.assertTrue(os.path.isdir(path), path)
        return path

    def killed(self):
        process = self.start(PROGRAM)
        path = self.folder_of(process)
        process.send_signal(signal.SIGKILL)
        process.wait()
        return path

    def test_the_folder_ends_with_its_block(self):
        with TemporaryFolder(self.place) as folder:
            os.makedirs(os.path.join(folder, "deep", "er"))
        self.assertEqual(os.listdir(self.place), [])

    def test_the_folder_ends_with_its_program(self):
        process = self.start(PROGRAM)
        path = self.folder_of(process)
        process.communicate()
        self.assertFalse(os.path.exists(path))

    def test_the_folder_of_a_killed_program_is_removed_by_the_next_one(self):
        path = self.killed()
        os.makedirs(os.path.join(path, "deep", "er"))
        os.chmod(os.path.join(path, "deep"), 0)
        with TemporaryFolder(self.place) as folder:
            self.assertEqual(os.listdir(self.place), [os.path.basename(folder)])

    @unittest.skipUnless(APART_WORKS, "this computer gives no namespace of processes")
    def test_a_folder_lives_with_its_program_in_another_namespace_of_processes(self):
        inside, outside = self.start(PROGRAM, APART), self.start(PROGRAM)
        paths = [self.folder_of(inside), self.folder_of(outside)]
        for prefix in (APART, ()):
            process = self.start(PROGRAM, prefix)
            self.folder_of(process)
            process.communicate()
            self.assertEqual([path for path in paths if not os.path.isdir(path)], [])

    def test_other_folders_stay(self):
        names = ["plumb-temporary-", "plumb-temporary-of-mine", "my-plumb-temporary-abcdef", "plumb-wire-12-abcdef"]
        for name in names:
            os.mkdir(os.path.join(self.place, name))
        with TemporaryFolder() as elsewhere:
            os.symlink(elsewhere, os.path.join(self.place, "plumb-temporary-abcdef"))
            with TemporaryFolder(self.place):
                pass
            self.assertEqual(sorted(os.listdir(self.place)), sorted([*names, "plumb-temporary-abcdef"]))
            self.assertTrue(os.path.isdir(elsewhere))

    @unittest.skipUnless(os.geteuid() == 0, "only root can make a folder of another user")
    def test_a_folder_of_another_user_stays(self):
        path = self.killed()
        os.chown(path, 65534, 65534)
        with TemporaryFolder(self.place):
            self.assertTrue(os.path.isdir(path))

    def test_nobody_removes_a_folder_that_is_just_being_made(self):
        makers = [self.start(MAKER) for _ in range(4)]
        for maker in makers:
            maker.stdin.write("go\n")
            maker.stdin.flush()
        self.assertEqual([maker.communicate()[1] for maker in makers], [""] * 4)
        self.assertEqual(os.listdir(self.place), [])


if __name__ == "__main__":
    unittest.main()

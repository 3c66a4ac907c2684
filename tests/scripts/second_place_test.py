# SPDX-License-Identifier: GPL-2.0-or-later
"""The tests that hide /tmp, or move into other namespaces, pass for a clone that lies in /tmp.

The clone is seen in a folder of /tmp, and its own place is empty.
"""

import os
import shutil
import subprocess
import unittest

from tree import BUILD, ROOT, own_folder

PATIENCE = 200  # s

# As the root of a new mount namespace. $1 is the clone, $2 its second place, $3 and $4 the user.
MOVE = """
set -e
mkdir "$2"
mount --rbind "$1" "$2"
mount -t tmpfs tmpfs "$1"
cd "$2"
export PLUMB_SOURCE="$2" PLUMB_BUILD="$2/$5"
user=$3 group=$4
shift 5
[ "$user" = 0 ] || set -- unshare --user --map-user=$user --map-group=$group -- "$@"
exec "$@"
"""

# One of each kind of isolation.
PROGRAM = ["tests/tests", "--gtest_filter=HostSocket.*:StockRtapi.*:PlumbRunFiles.*:PlumbRunOnAMachine.*"]
SCRIPTS = (
    "commands/plumb_wire_files_test.py Sandbox",
    "components/io/plumb_retain_stock_test.py",
    "host/halrun_cases_test.py Stock",
)
ON_A_BUS = "components/io/can_sensor_test.py Bus.test_a_flexible_frame_has_64_bytes"


class SecondPlace(unittest.TestCase):
    def setUp(self):
        build = os.path.relpath(BUILD, ROOT)
        if build.startswith(".."):
            self.skipTest("the build lies outside the clone")
        users = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
        self.spaces = ["unshare", *users, "--mount", "--propagation", "private", "--", "sh", "-c", MOVE, "sh", ROOT]
        self.rest = [str(os.geteuid()), str(os.getegid()), build]

    def run_there(self, *words):
        place = os.path.join(own_folder(self), "clone")
        done = subprocess.run([*self.spaces, place, *self.rest, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, encoding="utf-8", errors="replace", timeout=PATIENCE, check=False)
        if "unshare: unshare failed" in done.stdout:
            self.skipTest("the kernel gives no namespaces")
        self.assertEqual(done.returncode, 0, done.stdout[-5000:])

    def test_in_cpp(self):
        program, *options = PROGRAM
        self.run_there(os.path.join(self.rest[-1], program), *options)

    def test_in_python(self):
        for words in SCRIPTS:
            with self.subTest(words):
                self.run_there(*test(words))

    def test_on_a_bus(self):
        self.run_there("env", "PLUMB_TEST_HAS_A_BUS=1", "tests/support/can_vm", str(PATIENCE), own_folder(self), *test(ON_A_BUS))


class Blank(unittest.TestCase):
    def test_the_tests_name_the_reason_and_end(self):
        folder = os.path.join(own_folder(self), "my clone", "scripts")
        os.makedirs(folder)
        program = shutil.copy(os.path.join(ROOT, "scripts", "test"), folder)
        done = subprocess.run([program], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("my clone, has a blank", done.stderr.splitlines()[0])


def test(words):
    """The command that runs a test in Python."""
    script, *names = words.split()
    return ["/usr/bin/python3", "tests/support/run.py", "tests/" + script, *names]


if __name__ == "__main__":
    unittest.main()

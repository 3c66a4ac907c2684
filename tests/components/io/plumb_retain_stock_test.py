# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb-retain, the real program, on LinuxCNC's own realtime side.

Also for the thread sanitizer: the virtual-time host does not run under that.
"""

import os
import shutil
import subprocess
import unittest

import stock_linuxcnc
from tree import BUILD, own_folder

RETAIN = os.path.join(BUILD, "bin", "plumb-retain")
PATIENCE = 30  # s of real time


class Stock(unittest.TestCase):
    """On LinuxCNC's own realtime side, by halrun."""

    HAL = """\
loadrt threads name1=servo-thread period1=1000000
loadrt lowpass names=filter
setp filter.in 1.5
loadusr -W {retain} --file {folder}/mill.toml
start
loadusr -w sh until_restored
loadusr -w halcmd getp filter.in
setp filter.in {value}
loadusr -w sh until_saved {value}
"""

    def test_values_outlive_halrun(self):
        folder = own_folder(self)
        tried = subprocess.run(stock_linuxcnc.closed_in(["true"], folder), env=stock_linuxcnc.ENVIRONMENT,
                               capture_output=True, text=True)
        if tried.returncode:
            self.skipTest("the kernel gives no namespaces: " + tried.stderr)
        with open(folder + "/mill.toml", "w") as file:
            file.write('machine = "m"\npins = ["filter.in"]\nevery = 0.05\n')
        with open(folder + "/until_restored", "w") as file:
            file.write("until halcmd getp plumb-retain.restored | grep -q TRUE; do sleep 0.02; done\n")
        with open(folder + "/until_saved", "w") as file:
            file.write('until grep -q "filter.in.*$1" mill.retained; do sleep 0.02; done\n')
        retain = shutil.copy(RETAIN, folder)
        seen = []
        for value in (2.5, 3.5, 4.5):
            with open(folder + "/mill.hal", "w") as file:
                file.write(self.HAL.format(retain=retain, folder=folder, value=value))
            done = subprocess.run(
                stock_linuxcnc.closed_in(["halrun", "-f", "mill.hal"], folder),
                cwd=folder,
                env=stock_linuxcnc.ENVIRONMENT,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("ThreadSanitizer", done.stderr)
            seen.append(done.stdout.strip())
        self.assertEqual(seen, ["1.5", "2.5", "3.5"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on machines that reach out of their folder: it reads them, and changes nothing outside its own."""

import os
import re
import shutil
import unittest

from tree import own_folder
from wire_sample import AXIS_MM, Sample, read, write

MACHINE = "sim/a`id`$(id)'\"[exit];&{*\\#$HOME\u00b0/axis_mm.ini"  # names for a shell, for Tcl and for halcmd
WINDOW = "#!/usr/bin/python3\nimport tkinter\ntkinter.Tk()\n"
# It ends with 1 unless the computer refuses each of its writes, and accepts those into the copy and into memory.
WRITER = """#!/bin/sh
outside={outside}
touch "$CONFIG_DIR/here" "$HOME/here" /tmp/here /dev/shm/here || exit 1
refused=0
for path in $outside/pos.txt $outside/new $outside/shared/new $HOME/deep/old /etc/plumb-wire-test /usr/plumb-wire-test; do
  (: >> $path) 2>/dev/null && exit 1
done
rm -f $outside/tools.tbl 2>/dev/null && exit 1
mv $outside/pos.txt $outside/moved 2>/dev/null && exit 1
chmod 777 $outside/pos.txt 2>/dev/null && exit 1
touch $outside/pos.txt 2>/dev/null && exit 1
mount -o remount,bind,rw / 2>/dev/null && exit 1
ls /dev/ttyS* /dev/ttyUSB* /dev/mem /run/dbus /run/user >/dev/null 2>&1 && exit 1
[ $(ls /sys/class/net | wc -l) = 1 ] || [ $(wc -l < /proc/net/dev) = 3 ] || exit 1
exit 0
"""


class Outside(Sample):
    def setUp(self):
        super().setUp()
        self.outside, self.home = own_folder(self), own_folder(self)
        self.roots += [self.outside, self.home]
        os.rename(os.path.dirname(self.ini(AXIS_MM)), os.path.dirname(self.ini(MACHINE)))
        self.machine = os.path.dirname(self.ini(MACHINE))
        for folder in (os.path.join(self.outside, "shared"), os.path.join(self.outside, "tools"), os.path.join(self.home, "deep")):
            os.mkdir(folder)
        for name in ("linuxcnc_print.txt", "linuxcnc_debug.txt", "deep/old", ".tool.mmap"):
            write(os.path.join(self.home, name), "mine\n")

    def put(self, name, text, mode=0o644):
        write(os.path.join(self.outside, name), text)
        os.chmod(os.path.join(self.outside, name), mode)

    def test_a_machine_that_reaches_out_in_every_way_is_wired_and_nothing_outside_changes(self):
        up = os.path.relpath(self.outside, self.machine)
        self.put("driver.hal", "loadrt hal_parport cfg=0x378\nnet lamp spindle.0.brake => parport.0.pin-02-out\n")
        self.put("linked.hal", "loadrt hal_gpio reset=7\nnet valve spindle.0.locked => hal_gpio.bcm-07-out\n")
        self.put("shared/third.hal", "loadrt uparport\n")
        self.put("pos.txt", "1.5\n2.5\n3.5\n")
        self.put("view", WINDOW, 0o755)
        self.put("tools/gs2_vfd", WINDOW, 0o755)
        self.put("writer", WRITER.format(outside=self.outside), 0o755)
        self.put("machine.var", "5161\t0.000000\n5220\t1.000000\n")
        shutil.copy(os.path.join(self.machine, "sim_mm.tbl"), os.path.join(self.outside, "tools.tbl"))
        os.symlink(up + "/linked.hal", os.path.join(self.machine, "mine.hal"))
        os.symlink(up + "/shared", os.path.join(self.machine, "shared"))
        os.symlink(up + "/tools", os.path.join(self.machine, "bin"))
        os.symlink(up + "/shared", os.path.join(self.machine, ".plumb-wire"))
        lines = [
            "loadusr -Wn ../../x %s/view" % up,
            "loadusr -Wn drive gs2_vfd",
            "loadusr -w %s/writer" % self.outside,
            "source shared/third.hal",
            "loadusr -w cmp [TRAJ]POSITION_FILE %s/pos.txt" % self.outside,
            *("loadusr -w test -w " + name for name in ("[TRAJ]POSITION_FILE", "[RS274NGC]PARAMETER_FILE", "[EMCIO]TOOL_TABLE")),
        ]
        write(os.path.join(self.machine, "programs.hal"), "\n".join(lines) + "\n")
        write(os.path.join(self.machine, "escape.tcl"), "exec %s/writer\n" % self.outside)
        ini = read(self.ini(MACHINE))
        display = re.search(r"^\[DISPLAY\].*?(?=^\[)", ini, re.M | re.S)[0]
        self.put("display.inc", display)
        last = "HALFILE = simulated_home.hal\n"
        halfiles = ["%s/driver.hal" % self.outside, "mine.hal", "programs.hal", "escape.tcl"]
        for old, new in (
            (display, ""),
            ("= sim_mm.var", "= %s/machine.var" % up),
            ("= sim_mm.tbl", "= %s/tools.tbl" % self.outside),
            ("= position_mm.txt", "= %s/pos.txt" % up),
            (last, last + "".join("HALFILE = %s\n" % name for name in halfiles) + "HALCMD = loadusr -w %s/writer\n" % up),
            ("[TRAJ]\n", "[APPLICATIONS]\nAPP = %s/writer\n[TRAJ]\n" % up),
        ):
            self.assertIn(old, ini)
            ini = ini.replace(old, new, 1)
        write(self.ini(MACHINE), ini + "#INCLUDE %s/display.inc\n" % up)

        status, output, flat = self.wire(MACHINE, "squareness", HOME=self.home)
        self.assertEqual(status, 0, output)
        self.assertIn("here: hal_parport, hal_gpio, uparport.", flat)
        self.assertIn("here: hal_manualtoolchange, ../../x, drive.", flat)
        self.assertIn("%s lies outside" % os.path.join(self.outside, "display.inc"), flat)
        patch = read(os.path.join(self.folder(MACHINE), "ini.patch"))
        self.assertEqual(re.findall(r"^\+\+\+ (.*)$", patch, re.M), ["b/axis_mm.ini"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The files of plumb wire: it writes below its folders alone, all of them or none, and its trial cannot write elsewhere."""

import errno
import fcntl
import importlib.machinery
import importlib.util
import json
import os
import random
import re
import select
import socket
import subprocess
import sys
import termios
import types
import unittest
from unittest import mock

import linuxcnc
from plumb_folder import TemporaryFolder
from tree import BUILD, ROOT, own_folder
from wire_sample import plumb_wire, read, snapshot, write

WIRING = os.path.join(BUILD, "share", "plumb", "wiring")
sys.path[1:1] = [WIRING, os.path.join(BUILD, "share", "plumb", "models")]
import copies  # noqa: E402
import driver_pages  # noqa: E402
import error_tables  # noqa: E402
from hal_files import HalFiles  # noqa: E402
import hal_text  # noqa: E402
import later_files  # noqa: E402
import rotary_axes  # noqa: E402
import stand_ins  # noqa: E402
import trial  # noqa: E402
import trials  # noqa: E402
import writing  # noqa: E402
from ini_file import IniFile  # noqa: E402
from hal_state import State  # noqa: E402
from machine import Machine  # noqa: E402
from output import Output  # noqa: E402
from remedies import remedy  # noqa: E402
from step_rates import too_slow  # noqa: E402
from texts import Impossible  # noqa: E402

ODD_NAMES = ("a blank", "$(touch ran)", "`touch ran`", "it's", 'a"quote', "a;touch ran", "new\nline", "[exit]", "{", "$x", "\\", "*")


class Writing(unittest.TestCase):
    def setUp(self):
        root = own_folder(self)
        self.own, self.outside = os.path.join(root, "own"), os.path.join(root, "outside")
        for folder in (self.own, self.outside):
            os.mkdir(folder)
        self.victim = os.path.join(self.outside, "victim")
        write(self.victim, "mine\n")
        self.addCleanup(lambda: self.assertEqual(read(self.victim), "mine\n"))

    def refused(self, name):
        before = snapshot(os.path.dirname(self.own))
        with self.assertRaises(Impossible) as caught:
            writing.write_all(self.own, [("first", "new\n"), (name, "ruined\n")])
        self.assertEqual(snapshot(os.path.dirname(self.own)).keys(), before.keys())
        return str(caught.exception)

    def test_a_name_that_leads_out_is_refused(self):
        for name in ("../outside/victim", self.victim, "a/../../outside/victim", "..", "", "a/"):
            self.assertIn("writes nothing outside %s" % self.own, self.refused(name))

    def test_a_folder_that_is_a_link_is_refused(self):
        os.symlink(self.outside, os.path.join(self.own, "linked"))
        self.assertIn("%s/linked must be a folder" % self.own, self.refused("linked/victim"))

    def test_a_link_at_the_name_is_replaced_and_not_followed(self):
        for name in ("plumb.hal", "plumb.hal.new"):
            os.symlink(self.victim, os.path.join(self.own, name))
        os.link(self.victim, os.path.join(self.own, "hard"))
        for name in ("plumb.hal", "hard"):
            writing.write(self.own, name, "new\n")
            self.assertEqual(read(os.path.join(self.own, name)), "new\n")
            self.assertFalse(os.path.islink(os.path.join(self.own, name)))
        self.assertEqual(sorted(os.listdir(self.own)), ["hard", "plumb.hal", "plumb.hal.new"])

    def test_a_full_disk_leaves_the_files_as_they_were(self):
        for name in ("plumb.hal", "stages.hal"):
            write(os.path.join(self.own, name), "old\n")
        before = snapshot(self.own)
        full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        with mock.patch("os.fsync", side_effect=[None, full]), self.assertRaises(OSError):
            writing.write_all(self.own, [("plumb.hal", "new\n"), ("stages.hal", "new\n"), ("more/third", "new\n")], lasting=True)
        self.assertEqual({name: found[2] for name, found in snapshot(self.own).items()},
                         {name: found[2] for name, found in before.items()})

    def test_a_folder_in_the_place_of_a_file_is_named(self):
        os.mkdir(os.path.join(self.own, "plumb.inc"))
        self.assertIn("plumb.inc is a folder", self.refused("plumb.inc"))

    def test_the_folder_of_the_output_is_no_link_and_has_no_link_that_is_read(self):
        ini = os.path.join(self.own, "my.ini")
        write(ini, "[KINS]\nKINEMATICS = trivkins\n[TRAJ]\nCOORDINATES = XYZ\n")
        os.symlink(self.outside, os.path.join(self.own, "plumb"))
        status, _, flat = plumb_wire("squareness", "--ini", ini)
        self.assertEqual(status, 1)
        self.assertIn("%s/plumb is a link" % self.own, flat)
        os.unlink(os.path.join(self.own, "plumb"))
        os.mkdir(os.path.join(self.own, "plumb"))
        os.symlink(self.victim, os.path.join(self.own, "plumb", "plumb.inc"))
        write(os.path.join(self.own, "plumb", ".written.json"), json.dumps({"ini": "my.ini", "functions": [], "files": {}}))
        with self.assertRaisesRegex(Impossible, "plumb.inc is a link"):
            Output(os.path.join(self.own, "plumb"), self.own, "my.ini").inc({}, {})


class Manifest(unittest.TestCase):
    """The list of files in the folder of plumb wire, and its ends halfway."""

    def setUp(self):
        self.home = own_folder(self)
        self.folder = os.path.join(self.home, "plumb")
        self.manifest = os.path.join(self.folder, ".written.json")

    def output(self):
        return Output(self.folder, self.home, "my.ini")

    def write(self, **texts):
        self.output().write({name + ".hal": text for name, text in texts.items()}, [])

    def damage(self, text):
        os.makedirs(self.folder, exist_ok=True)
        write(self.manifest, text)

    def test_a_damaged_one_is_named_with_the_remedy(self):
        good = {"ini": "my.ini", "functions": [], "files": {}}
        odd = ["", "{", "null", "[]", '"ini"', "7", "[" * 5000, "\0", "{}"]
        odd += [json.dumps({**good, name: value}) for name in good for value in (None, 5, [7], {"plumb.hal": 5}, {"plumb.hal": [5]})]
        for text in odd:
            self.damage(text)
            with self.assertRaises(Impossible, msg=text) as caught:
                self.output()
            self.assertIn("%s, in which plumb wire notes its files, is damaged. Restore it" % self.manifest,
                          " ".join(str(caught.exception).split()))

    def test_the_command_reports_a_damaged_one(self):
        ini = os.path.join(self.home, "my.ini")
        write(ini, "[KINS]\nKINEMATICS = trivkins\n[TRAJ]\nCOORDINATES = XYZ\n")
        self.damage("[]")
        status, _, flat = plumb_wire("squareness", "--ini", ini)
        self.assertEqual(status, 1)
        self.assertRegex(flat, "^plumb wire: nothing was written. .*is damaged")

    def test_a_write_that_breaks_off_at_any_step_is_taken_up_again(self):
        rename, old, new = os.rename, {"plumb": "old\n", "stages": "same\n"}, {"plumb": "new\n", "stages": "same\n", "more": "new\n"}
        for before in ({}, old):
            for step in range(5):
                self.setUp()
                if before:
                    self.write(**before)
                full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                effects = [rename] * step + [full]
                with mock.patch("os.rename", side_effect=lambda *at, done=effects, **where: self.step(done, *at, **where)):
                    with self.assertRaises(writing.PartlyWritten if step else OSError):
                        self.write(**new)
                files = {name + ".hal": text for name, text in new.items()}
                self.output().forbid_strangers(files)
                self.assertFalse([name for name in os.listdir(self.home) if name.endswith(".new")])
                self.write(**new)
                self.assertEqual(sorted(os.listdir(self.folder)), [".written.json", "more.hal", "plumb.hal", "stages.hal"])
                write(os.path.join(self.folder, "plumb.hal"), "a user's\n")
                with self.assertRaisesRegex(Impossible, "Somebody changed plumb.hal"):
                    self.output().forbid_strangers(files)

    @staticmethod
    def step(done, *at, **where):
        effect = done.pop(0)
        if isinstance(effect, OSError):
            raise effect
        effect(*at, **where)

    def test_a_file_of_a_killed_start_is_no_stranger_and_goes(self):
        os.mkdir(self.folder)
        write(os.path.join(self.folder, ".0123456789abcdef.new"), "half")
        self.write(plumb="new\n")
        self.assertEqual(sorted(os.listdir(self.folder)), [".written.json", "plumb.hal"])
        write(os.path.join(self.folder, ".mine.new"), "mine")
        self.write(plumb="newer\n")
        self.assertIn(".mine.new", os.listdir(self.folder))

    def test_a_read_only_folder_is_named_before_a_start(self):
        ini = os.path.join(self.home, "my.ini")
        write(ini, "[KINS]\nKINEMATICS = trivkins\n[TRAJ]\nCOORDINATES = XYZ\n")
        users = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
        script = 'mount --bind "$1" "$1" && mount -o remount,bind,ro "$1" && exec "$2" wire squareness --ini "$1/my.ini"'
        words = ["unshare", *users, "--mount", "sh", "-c", script, "sh", self.home, os.path.join(BUILD, "bin", "plumb")]
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        if "unshare" in done.stderr:
            self.skipTest(done.stderr)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("nothing was written. You cannot write into %s." % self.home, " ".join(done.stderr.split()))


class Names(unittest.TestCase):
    """Names that LinuxCNC cannot have are refused before a start."""

    def refusal(self, *names, output="plumb", more=""):
        ini = os.path.join(own_folder(self), *names)
        os.makedirs(os.path.dirname(ini), exist_ok=True)
        write(ini, "[KINS]\nKINEMATICS = trivkins\n[TRAJ]\nCOORDINATES = XYZ\n" + more)
        before = snapshot(os.path.dirname(ini))
        status, _, flat = plumb_wire("squareness", "--ini", ini, "--output", os.path.join(os.path.dirname(ini), output))
        self.assertEqual((status, snapshot(os.path.dirname(ini))), (1, before))
        return flat

    def test_a_path_with_a_blank(self):
        for name, words in (("my\tmill", "a tab"), ("my\nmill", "a line break")):
            words = "has %s, and LinuxCNC cannot read an INI file there" % words
            self.assertRegex(self.refusal(name, "configs", "my.ini"), words)
            self.assertRegex(self.refusal(name.replace("mill", "mill.ini")), words)
        words = r"has a blank, and LinuxCNC does not find the INI file of line \d+, '#INCLUDE my.inc', there"
        self.assertRegex(self.refusal("my mill", "my.ini", more="#INCLUDE my.inc\n"), words)

    def test_a_file_that_begins_with_a_byte_order_mark(self):
        ini = os.path.join(own_folder(self), "my.ini")
        write(ini, "\ufeff[EMC]\nVERSION = 1.1\n")
        status, _, flat = plumb_wire("squareness", "--ini", ini)
        self.assertEqual(status, 1)
        self.assertIn("my.ini begins with a byte order mark", flat)
        subprocess.run(re.search("sed .*", flat)[0], shell=True, check=True)
        self.assertEqual(read(ini), "[EMC]\nVERSION = 1.1\n")

    def test_a_file_of_linuxcnc_2_7(self):
        self.assertRegex(self.refusal("my.ini"), r"my.ini is an INI file of LinuxCNC 2.7 or before.*: update_ini \S+/my.ini$")

    def test_a_path_that_is_not_utf_8(self):
        self.assertRegex(self.refusal("caf\udce9", "my.ini"), "The path .* has a byte that is not UTF-8")

    def test_line_ends_of_dos(self):
        ini = os.path.join(own_folder(self), "my.ini")
        write(ini, "[KINS]\r\nKINEMATICS = trivkins\r\n[TRAJ]\r\nCOORDINATES = XYZ\r\n#INCLUDE my.inc\r\n")
        status, _, flat = plumb_wire("squareness", "--ini", ini)
        self.assertEqual(status, 1)
        self.assertIn("has the line ends of DOS, and LinuxCNC does not find the file of its line 5, '#INCLUDE my.inc'", flat)
        self.assertIn(r"sed -i 's/\r$//' %s" % ini, flat)

    def test_a_name_of_the_output_that_hal_would_read_otherwise(self):
        for name, words in (("my plumb", "a blank"), ("a:b", "the character ':'"), ("$(id)", r"the character '\$'"), ("[x]", "'\\['")):
            self.assertRegex(self.refusal("my.ini", output=name), "--output .* has .*%s in its name" % words)


class Fuzz(unittest.TestCase):
    """Damaged INI and HAL files are read, or refused in a sentence. PLUMB_FUZZ is the number of files."""

    PIECES = (b"=", b"[", b"]", b"#", b";", b"\n", b"\r\n", b"\0", b"\xff", b"\xe4", b"\xef\xbb\xbf", b" ", b"\t", b"1e999", b"-", b"nan", b"~")
    PIECES += (b"#INCLUDE ", b"$(HOME)", b"..", b"/", b"loadrt ", b"names=", b'"', b"'", b"{", b"[EMC]VERSION", b"9" * 40, "\u0130".encode())
    MACHINE = os.path.join(ROOT, "tests", "specimens", "machines", "mesa_7i76e")

    def damaged(self, name):
        with open(os.path.join(self.MACHINE, name), "rb") as file:
            text = bytearray(file.read())
        draw = self.random
        for _ in range(draw.choice((1, 1, 2, 4, 8))):
            place, lines = draw.randrange(len(text)), text.split(b"\n")
            line = draw.randrange(len(lines))
            kind = draw.randrange(4)
            if kind == 0:
                text[place : place + draw.choice((1, 3, 20, 200))] = b""
            elif kind == 1:
                text[place:place] = draw.choice(self.PIECES)
            else:
                key = lines[line].split(b"=")[0] + b"=" + draw.choice(self.PIECES)
                lines.insert(draw.randrange(len(lines)), lines[line] if kind == 2 else key)
                text = bytearray(b"\n".join(lines))
        return bytes(text)

    def test_no_exception_but_a_refusal(self):
        home, self.random = own_folder(self), random.Random(5)
        loader = importlib.machinery.SourceFileLoader("plumb_wire", os.path.join(BUILD, "bin", "plumb-wire"))
        wire = importlib.util.module_from_spec(importlib.util.spec_from_loader("plumb_wire", loader))
        loader.exec_module(wire)
        known = wire.all_functions(wire.FUNCTIONS)
        path, hal = (os.path.join(home, name) for name in ("mesa.ini", "mesa.hal"))
        arguments = types.SimpleNamespace(ini=path, output=None, joints="", stand_in=[], apply=False, remove=False)
        ends = {True: 0, False: 0}
        for number in range(int(os.environ.get("PLUMB_FUZZ", "80"))):
            for name in (path, hal):
                with open(name, "wb") as file:
                    file.write(self.damaged(os.path.basename(name)))
            try:
                its = wire.Wire([known["squareness"], known["chopping"]], arguments, known)
                ini = its.fresh_ini()
                its.check_axes(wire.joints_by_coordinates(ini), ini)
                its.check_codes(ini)
                trials.begin_with_first_sequence(ini)
                for joint in list(trials.joints(ini))[:9]:
                    for key in ("MAX_VELOCITY", "MAX_ACCELERATION", "MIN_LIMIT", "MAX_LIMIT"):
                        ini.number("JOINT_%d" % joint, key, 1)
                files = [*hal_text.halfiles(ini, home), hal]
                hal_text.where("net", files)
                text = "".join(line for _place, line in hal_text.lines_with("net", files))
                hal_text.nets_of(text)
                hal_text.parse(text)
                ends[True] += 1
            except (Impossible, OSError) as error:
                self.assertTrue(str(error).endswith((".", path)) or isinstance(error, OSError) or "sed" in str(error), str(error))
                ends[False] += 1
            except Exception as error:
                raise AssertionError("file %d: %r" % (number, error)) from error
        self.assertTrue(all(ends.values()), ends)

    def test_a_file_of_ten_megabytes_in_one_line(self):
        path = os.path.join(own_folder(self), "my.ini")
        write(path, "[EMC]\nVERSION = 1.1\nA = %s\n" % ("x" * 10_000_000))
        status, _, flat = plumb_wire("squareness", "--ini", path)
        self.assertEqual((status, flat), (1, "plumb wire: nothing was written. %s is longer than 1048576 bytes." % path))

    def test_a_byte_of_latin_1_is_named(self):
        path = os.path.join(own_folder(self), "my.ini")
        with open(path, "wb") as file:
            file.write(b"[EMC]\nVERSION = 1.1\n[DISPLAY]\nDISPLAY = fr\xe4se\n")
        with self.assertRaisesRegex(Impossible, "my.ini:4: DISPLAY is not UTF-8 text: save the file as UTF-8."):
            IniFile(path).get("DISPLAY", "DISPLAY")


class Values(unittest.TestCase):
    def test_a_number_that_is_none_is_named_with_its_line(self):
        path = os.path.join(own_folder(self), "my.ini")
        for text in ("625 # 25 % above", "-200 ; a remark", "ten", "1_000", "inf", "nan", "1,5"):
            write(path, "[JOINT_0]\nMAX = 5\nMIN = %s\n" % text)
            ini = IniFile(path)
            self.assertEqual((ini.number("JOINT_0", "MAX"), ini.number("JOINT_0", "HOME", 7)), (5, 7))
            with self.assertRaises(Impossible) as caught:
                ini.number("JOINT_0", "MIN")
            words = " ".join(str(caught.exception).split())
            self.assertIn("my.ini:3: MIN = %s is no number." % text, words)
            self.assertEqual("takes no remark behind a value" in words, "remark" in text or "above" in text)

    def test_an_include_that_is_no_file_or_too_long_is_named_with_its_line(self):
        home = own_folder(self)
        with open(os.path.join(home, "long.inc"), "wb") as file:
            file.truncate(2 << 20)
        for name, words in (("/dev/zero", "is no file"), ("long.inc", "is longer than 1048576 bytes")):
            write(os.path.join(home, "my.ini"), "[HAL]\n#INCLUDE %s\n" % name)
            with self.assertRaises(Impossible) as caught:
                IniFile(os.path.join(home, "my.ini"))
            self.assertRegex(" ".join(str(caught.exception).split()), "my.ini:2 includes .*%s, which %s" % (name, words))

    def test_linuxcnc_is_given_no_include_for_its_2_10_refuses_that_of_a_file_to_come(self):
        home = own_folder(self)
        write(os.path.join(home, "some.inc"), "MACHINE = mine\n#INCLUDE nested.inc\n")
        write(os.path.join(home, "my.ini"), "[EMC]\n#INCLUDE some.inc\n[PLUMB]\n#INCLUDE plumb/plumb.inc\nACCESS = view\n")
        ini = IniFile(os.path.join(home, "my.ini"))
        given = []

        def of_2_10(path):
            given.append(read(path))
            return linuxcnc.ini(path)

        with mock.patch("ini_file.linuxcnc", mock.Mock(ini=of_2_10, error=linuxcnc.error)):
            self.assertEqual((ini.get("EMC", "MACHINE"), ini.get("PLUMB", "ACCESS")), ("mine", "view"))
        self.assertEqual(len(given), 4)
        self.assertNotIn("#INCLUDE", "".join(given))
        with mock.patch.object(linuxcnc, "version", "2.10.0~pre1"), self.assertRaisesRegex(Impossible, "some.inc:2 includes a file"):
            IniFile(os.path.join(home, "my.ini"))

    def test_lines_of_a_file_of_dos_and_without_a_last_line_end(self):
        home = own_folder(self)
        with open(os.path.join(home, "my.ini"), "wb") as file:
            file.write(b"[HAL]\r\nHALFILE = a.hal\r\n[TRAJ]\r\nMAX = 3")
        ini = IniFile(os.path.join(home, "my.ini"))
        ini.add("HAL", "HALFILE", "b.hal")
        self.assertEqual(ini.text(ini.path), "[HAL]\r\nHALFILE = a.hal\r\nHALFILE = b.hal\r\n[TRAJ]\r\nMAX = 3")
        ini.add("TRAJ", "MIN", "1")
        self.assertEqual(ini.text(ini.path).split("\r\n")[3:], ["[TRAJ]", "MAX = 3", "MIN = 1"])
        ini.add("NEW", "A", "1")
        self.assertEqual(ini.text(ini.path).split("\r\n")[5:], ["MIN = 1", "", "[NEW]", "A = 1", ""])

    def test_a_halfile_comes_before_the_first_without_a_value(self):
        """LinuxCNC reads no further."""
        home = own_folder(self)
        for name in ("first.hal", "last.hal"):
            write(os.path.join(home, name), "# mine\n")
        write(os.path.join(home, "my.ini"), "[HAL]\nHALFILE = first.hal\nHALFILE =\nHALFILE = last.hal\n[TRAJ]\n")
        ini = IniFile(os.path.join(home, "my.ini"))
        self.assertEqual(list(hal_text.halfiles(ini, home)), [os.path.join(home, "first.hal")])
        ini.add("HAL", "HALFILE", "plumb/plumb.hal")
        self.assertEqual(ini.texts[ini.path][1:4], ["HALFILE = first.hal", "HALFILE = plumb/plumb.hal", "HALFILE ="])


MOTION = """for module in tpmod homemod "trivkins coordinates=XYZ"; do halcmd loadrt $module; done
halcmd loadrt motmod servo_period_nsec=1000000 num_joints=3
halcmd loadrt sum2 names=a,b,c,d,e,f,g,u,v,w
for name in a %s motion-command-handler motion-controller b; do halcmd addf $name servo-thread || exit; done
haltcl order.tcl || exit
halcmd addf g servo-thread
halcmd -s show thread
"""
OWN = ["c", "d", "motion-controller", "e", "f", "b", "g"]


class Order(unittest.TestCase):
    """order.tcl, which adds functions to the thread of motion-controller."""

    def setUp(self):
        self.home, self.hallib = own_folder(self), own_folder(self)
        self.environment = {name: value for name, value in os.environ.items() if name != "HALLIB_DIR"}
        self.write_order(mock.Mock(before=["c", "d"], after=["e"], last=["f"]))
        self.shared = read(os.path.join(BUILD, "share", "plumb", "functions", "plumb_order.tcl"))
        write(os.path.join(self.home, "plumb_order.tcl"), self.shared)

    def write_order(self, *parts):
        files = object.__new__(HalFiles)
        files.all_parts, files.functions = list(parts), []
        write(os.path.join(self.home, "order.tcl"), files.order())

    def run_in_host(self, *command):
        command = [os.path.join(BUILD, "bin", "plumb"), "run", "--", *command]
        done = subprocess.run(command, cwd=self.home, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    def thread(self, more=""):
        write(os.path.join(self.home, "machine.sh"), MOTION % more)
        status, output, error = self.run_in_host("bash", "machine.sh")
        self.assertEqual(status, 0, error)
        return output.split("servo-thread")[-1].split()[2:]

    def test_functions_that_a_user_adds_in_front_later_change_nothing_around_motion_controller(self):
        self.assertEqual(self.thread(), ["a", "motion-command-handler", *OWN])
        self.assertEqual(self.thread("u v w"), ["a", "u", "v", "w", "motion-command-handler", *OWN])

    def test_a_thread_without_motion_controller_is_named(self):
        self.write_order()
        status, _, error = self.run_in_host("haltcl", "order.tcl")
        self.assertNotEqual(status, 0)
        self.assertIn("no thread has motion-controller: the HALFILE that adds it must come before this one", error)

    def test_the_commands_of_an_installed_package_come_before_those_of_the_folder(self):
        write(os.path.join(self.home, "plumb_order.tcl"), "error {of the folder}\n")
        write(os.path.join(self.hallib, "plumb_order.tcl"), self.shared)
        self.environment["HALLIB_DIR"] = self.hallib
        self.assertEqual(self.thread(), ["a", "motion-command-handler", *OWN])

    def test_a_linuxcnc_run_in_place_whose_hallib_is_its_own_takes_the_commands_of_the_folder(self):
        self.environment["HALLIB_DIR"] = self.hallib
        self.assertEqual(self.thread(), ["a", "motion-command-handler", *OWN])


class Remedies(unittest.TestCase):
    """What to do where LinuxCNC does not start without Plumb."""

    def test_a_complaint_of_linuxcnc_gets_file_line_and_remedy(self):
        home = own_folder(self)
        path = os.path.join(home, "my.ini")
        write(path, "[HAL]\nHALFILE = my.hal\nHALFILE = gone.hal\n")
        write(os.path.join(home, "my.hal"), "loadusr -Wn nobody ./reader.py\n")
        waiting = "  Waiting for component 'nobody' to become ready.\n  While waiting for 'nobody', component 'reader' loaded.\n"
        python = '  File "/mpg.py", line 60\n    print \'bad event\'\n    ^^^^\nSyntaxError: Missing parentheses in call to \'print\'. Did you'
        for words, expected in (
            ("  CANNOT FIND FILE FOR:gone.hal\n", "%s:3 names gone.hal, and it is not there: put the file into %s, or remove the line." % (path, home)),
            (waiting, "my.hal:1 waits for the component nobody, and the component reader came: write loadusr -Wn reader there."),
            (waiting.split("\n")[0], "my.hal:1 waits for the component nobody, which did not come: start its program by hand to see why."),
            (
                "my_kins: dlopen: /modules/my_kins.so: cannot open shared object file: No such file",
                "The module my_kins is not installed here. If it is yours, install it: sudo halcompile --install my_kins.comp",
            ),
            (python, "/mpg.py:60 is written for Python 2: convert it by 2to3."),
            ("./my.hal:7: Pin 'a.b' was already linked to signal 'c'", "./my.hal:7 nets a.b, which is in your signal c: use this signal there."),
            ("something else", None),
        ):
            self.assertEqual(remedy(words, IniFile(path)), expected)


class Later(unittest.TestCase):
    """Files of the user that use pins and signals of ours."""

    def test_lines_with_pins_and_signals_of_ours_go_and_a_signal_that_a_stage_took_over_stays(self):
        home = own_folder(self)
        os.mkdir(os.path.join(home, "plumb"))
        ours = "loadrt squareness names=square\nloadrt joint_offset names=x-stage interlock=no\nloadusr -Wn link linuxcnc_link --x y\nunlinkp joint.0.motor-pos-cmd\n"
        ours += "net x-correction square.x-correction => x-stage.offset-0\nnet x-cmd x-stage.drive-command\nnet\n"
        write(os.path.join(home, "plumb", "stages.hal"), ours)
        with open(os.path.join(home, "plumb", "mine_settings.hal"), "wb") as file:
            file.write(b"# Ma\xdf\nsetp square.x 1\n")
        theirs = {
            "main.hal": "net x-cmd joint.0.motor-pos-cmd => drive.in\n",
            "other.hal": "# square.x-error\nnet x-cmd => scope.in\nnet my-x-correction mysquare.out\n",
            "mine.hal": "net seen square.x-error \\\n => scope.a\nnet x-correction => scope.b\nnet link-up link.connected\nsetp scope.c 1\n",
            "mine.tcl": "net seen square.x-error scope.a\n",
        }
        for name, text in theirs.items():
            write(os.path.join(home, name), text)
        found = later_files.LaterFiles(os.path.join(home, "plumb"))
        paths = [os.path.join(home, name) for name in theirs]
        self.assertEqual(found.first(paths, home), os.path.join(home, "mine.hal"))
        pattern = found.pattern(hal_text.nets_of("".join(theirs.values())))
        left = {name: found.without(name, text, pattern) for name, text in theirs.items()}
        expected = {**theirs, "mine.hal": "\n\n\n\nsetp scope.c 1\n", "mine.tcl": ""}
        self.assertEqual(left, expected)
        self.assertIsNone(later_files.LaterFiles(os.path.join(home, "nowhere")).first(paths, home))


class Pins(unittest.TestCase):
    """The pins that stand in for a driver."""

    def setUp(self):
        self.rows, self.loaded = "", []  # what modules show that load here, and their loadrt lines

    def test_a_file_gives_types_and_directions(self):
        text = "# of my drive\nmydrive.0.torque s32 OUT\n 12  u32  IN  0  mydrive.0.control <== z-control\n"
        learnt = stand_ins.given_pins({"mydrive": ("pins.txt", text)})
        ours = self.stand_ins("loadrt mydrive\nnet torque mydrive.0.torque\nnet z-control => mydrive.0.control\n", learnt)
        self.assertIn("mydrive", ours.drivers)
        self.assertEqual((ours._kind("mydrive.0.torque"), ours._kind("mydrive.0.control")), (["s32", "OUT"], ["u32", "IN"]))
        with self.assertRaisesRegex(Impossible, "pins.txt:1 has 'mydrive.0.torque int OUT'. Write the pin, its type"):
            stand_ins.given_pins({"mydrive": ("pins.txt", "mydrive.0.torque int OUT\n")})

    def stand_ins(self, hal, learnt=None):
        home = own_folder(self)
        write(os.path.join(home, "my.ini"), "[HAL]\nHALFILE = my.hal\n")
        write(os.path.join(home, "my.hal"), "loadrt hm2_eth\nloadrt lcec\n" + hal)
        self.written = {}
        ours = mock.Mock(read=set(), plumb="/nowhere/plumb")
        ours.path = lambda name: "/run/" + name
        ours.list_models = lambda models: self.written.update({"models.json": models})
        ours.is_absent = lambda module, ini: False
        ours.write = lambda name, text, *_: self.written.setdefault(name, text)
        ours.pins_of_modules = lambda lines: self.loaded.append(lines) or self.rows
        return stand_ins.StandIns(ours, IniFile(os.path.join(home, "my.ini")), [os.path.join(home, "my.hal")], learnt)

    def true(self):
        return {row[0] for model in self.written["models.json"]["modules"].values() for row in model["pins"] if row[3]}

    def test_a_pin_is_known_by_its_whole_name(self):
        found = self.stand_ins("")
        for pin, expected in (
            ("hm2_7i76e.0.gpio.030.invert_output", ["bit", "IN"]),
            ("hm2_7i76e.0.gpio.030.in_not", ["bit", "OUT"]),
            ("hm2_7i76e.0.pwmgen.00.output-type", ["s32", "IN"]),
            ("spindle.0.orient-angle", ["float", "OUT"]),
            ("cia402.0.statusword", ["u32", "IN"]),
        ):
            self.assertEqual(found._known(pin), expected, pin)

    def test_modules_that_load_without_hardware_give_their_pins_once(self):
        self.rows = "    5  s32   OUT          0  lcec.0.cia-controlword\n 5 bit IN FALSE lcec.0.mode <== mine\n"
        hal = "loadrt cia402 count=1\nnet mine motion.digital-out-00 => lcec.0.mode lcec.0.other\n"
        learnt = {}
        for _ in range(2):
            found = self.stand_ins(hal, learnt)
            self.assertEqual(found._kind("lcec.0.cia-controlword"), ["s32", "OUT"])
            self.assertEqual(found._kind("lcec.0.other"), ["bit", "IN"])
        self.assertEqual(self.loaded, [["loadrt tpmod", "loadrt homemod", "loadrt lcec", "loadrt cia402 count=1"]])

    def test_a_module_that_is_not_here_is_stood_in_for_and_one_with_a_wrong_option_is_not(self):
        hal = "loadrt acme_io names=left\naddf left servo-thread\nnet speed acme-io.0.speed left.speed\nloadrt pid names=x\n"
        found = self.stand_ins(hal)
        self.assertFalse(found.learn("pid: rtapi_app_main: Invalid argument (-22)"))
        self.assertFalse(found.learn("other: dlopen: /usr/lib/other.so: cannot open shared object file: No such file"))
        missing = "acme_io: dlopen: /usr/lib/linuxcnc/modules/acme_io.so: cannot open shared object file: No such file or directory"
        self.assertTrue(found.learn(missing))
        found = self.stand_ins(hal, found.learnt)
        self.assertIn("acme_io", found.drivers)
        self.assertEqual(found.described["acme_io"], ["acme-io.0.speed", "left.speed"])
        self.assertFalse(found.learn(missing), "once")

    def test_signals_give_the_direction_of_a_pin_that_no_list_has_and_a_function_has_its_own_pins(self):
        hal = "addf lcec.read-all servo-thread\nnet time lcec.read-all.time\nnet fb joint.0.motor-pos-fb <= hm2_7i92.0.stbl.1.2.pos_fb\n"
        found = self.stand_ins(hal + "net own <= hm2_7i92.0.other.0.value\nsetp hm2_7i92.0.other.0.width 3\nnet index joint.0.index-enable <=> hm2_7i92.0.stbl.1.2.index\n")
        self.assertEqual(found._kind("hm2_7i92.0.stbl.1.2.pos_fb"), ["float", "OUT"])
        self.assertEqual(found._kind("hm2_7i92.0.other.0.value"), ["float", "OUT"])
        self.assertEqual(found._kind("hm2_7i92.0.other.0.width"), ["float", "IN"])
        self.assertEqual(found._kind("hm2_7i92.0.stbl.1.2.index"), ["bit", "IO"])
        self.assertNotIn("lcec.read-all.time", [pin for pins in found.described.values() for pin in pins])

    def test_a_pin_is_known_behind_its_alias(self):
        hal = "alias pin hm2_7i92.0.new.0.its switch.x\nnet home-x <= switch.x\nnet home-x => joint.0.home-sw-in\n"
        found = self.stand_ins(hal)
        self.assertEqual(found.nets["home-x"][0], ["hm2_7i92.0.new.0.its", "joint.0.home-sw-in"])
        self.assertEqual(found._kind("hm2_7i92.0.new.0.its"), ["bit", "OUT"])
        self.assertTrue(found.learn("Signal 'home-x' of type 'bit' cannot add pin 'switch.x' of type 's32'"))

    def test_real_modules_are_read_and_those_that_look_for_hardware_leave_nothing(self):
        home = own_folder(self)
        write(os.path.join(home, "my.ini"), "[HAL]\n")
        there = trial.Trial(IniFile(os.path.join(home, "my.ini")), os.path.join(own_folder(self), "try"), os.path.join(BUILD, "bin", "plumb"))
        there.read.add(BUILD)
        rows = there.pins_of_modules(['loadrt hal_parport cfg="0x378"', "loadrt sim_grinder names=wheel", "loadrt nowhere"])
        self.assertIn(["float", "IN", "wheel.position-cmd"], [row.split()[1:3] + row.split()[4:5] for row in rows.splitlines()])
        self.assertNotIn("parport.", rows)

    def test_a_step_generator_that_is_too_slow_for_its_joint_is_named(self):
        def machine(scale):
            texts = dict.fromkeys(("comp", "pin"), "")
            texts["pin"] = "5 float OUT 0 joint.2.motor-pos-cmd ==> z\n"
            texts["sig"] = "float 0 z <== joint.2.motor-pos-cmd ==> stepgen.1.position-cmd\n"
            texts["param"] = "".join("5 u32 RW %s stepgen.1.%s\n" % pair for pair in ((5000, "steplen"), (1, "stepspace"), (scale, "position-scale")))
            texts["thread"] = "250000 YES base-thread ( 0, 0 ) stepgen.make-pulses\n"
            return mock.Mock(complete=State(texts), joints={"Z": [2]}, number=lambda joint, name: 2)

        (sentence,) = too_slow(machine(-8000))
        self.assertIn("Joint 2 may move at 2/s, by MAX_VELOCITY of [JOINT_2], and stepgen.1 makes steps for 0.25/s at most", sentence)
        self.assertEqual(list(too_slow(machine(1000))), [])

    def test_a_pin_takes_the_type_of_the_signal_that_linuxcnc_names(self):
        for wanted in ("s32", "u32", "bit"):
            learnt = {}
            found = self.stand_ins("net torque lcec.0.2.torque mine.0.in\n", learnt)
            words = "Signal 'torque' of type 'float' cannot add pin 'mine.0.in' of type '%s'" % wanted
            self.assertTrue(found.learn(words))
            self.assertEqual(learnt["lcec.0.2.torque"], wanted)
            self.assertFalse(found.learn(words))  # it helps once

    def test_a_manual_page_tells_what_the_files_do_not(self):
        hal = "loadrt opto_ac5\nloadrt mesa_7i65\nloadusr -Wn vfd gs2_vfd -n vfd\nnet load vfd.load-percentage\n"
        hal += "net revision vfd.firmware-revision\nnet led => opto_ac5.0.port1.in-01\n"
        hal += "net turns hm2_7i76e.0.encoder.00.rawcounts\nsetp hm2_7i76e.0.packet-error-limit 0\n"
        hal += "net level hm2_7i76e.0.analogin3\nnet mine vfd.nonesuch\n"
        ours = self.stand_ins(hal)
        for pin, expected in (
            ("vfd.load-percentage", ["float", "OUT"]),
            ("vfd.firmware-revision", ["s32", "OUT"]),
            ("opto_ac5.0.port1.in-01", ["bit", "OUT"]),
            ("hm2_7i76e.0.packet-error-limit", ["s32", "IN"]),
            ("hm2_7i76e.0.analogin3", ["float", "OUT"]),  # not on the page
            ("vfd.nonesuch", ["float", "IN"]),
        ):
            self.assertEqual(ours._kind(pin), expected, pin)

    def test_the_ways_in_which_pages_write_a_pin(self):
        text = [
            ".TP", "(float, in) card.\\fI<Number>\\fR.timer\\-us", ".IP <name>.at\\-speed\\ (bit,\\ out)", ".B card.\\fIN\\fB.level\\fR s32 rw \\fR",
            "\\fBcard.[\\fINUMBER\\fB\\fR].in\\-[\\fIPIN\\fB\\fR] OUT bit", "card.N.in\\-NN\\-invert bit in", ".IP <name>.SetF", "(float, out)",
            "card.<p>.reset (U32)", ".SS Counter", "Counters have names like card.<N>.counter.<Instance>.", "(s32 out) count and count-not",
            "(bit, in) a, b, and c (default 0): the three", ".SS Other", "(bit in) lost", "A sentence about (bit, in) things.",
        ]  # fmt: skip
        page = driver_pages.Page("\n".join(text))
        for pin, expected in (
            ("card.0.timer-us", ["float", "IN"]),
            ("any.name.at-speed", ["bit", "OUT"]),
            ("card.1.level", ["s32", "IN"]),
            ("card.0.in-03", ["bit", "OUT"]),
            ("card.0.in-03-invert", ["bit", "IN"]),
            ("hv.SetF", ["float", "OUT"]),
            ("card.0.reset", ["u32", None]),
            ("card.0.counter.01.count-not", ["s32", "OUT"]),
            ("card.0.counter.01.b", ["bit", "IN"]),
            ("card.0.counter.01.c", ["bit", "IN"]),
            ("card.0.counter.01.lost", None),
            ("card.0", None),
        ):
            self.assertEqual(page.kind(pin), expected, pin)
        self.assertEqual(driver_pages.page_of("no-page-has-this-name").pins, [])

    def test_an_input_and_its_inverse_contradict_each_other(self):
        limits = "hm2_7i76e.0.7i76.0.0.input-0"
        hal = "".join("net s%d %s%s\n" % (number, limits, name) for number, name in enumerate(("1", "1-not", "2", "2-not")))
        self.stand_ins(hal)
        self.assertEqual(self.true(), {limits + "1-not", limits + "2-not"})
        self.stand_ins(hal, {"false": [limits + "1-not"], "true": [limits + "2"]})
        self.assertEqual(self.true(), {limits + "1", limits + "2"})


class Tables(unittest.TestCase):
    """Error tables of the user's squareness."""

    def test_a_table_without_a_seal_is_named_with_the_command_and_not_written(self):
        home = own_folder(self)
        table = "X,EXX\n0,0\n10,0.001\n# end, 2 rows\n"
        for name in ("one.csv", "two words.csv", "three.csv", "four.csv", "five.csv", "commented.csv"):
            write(os.path.join(home, name), table)
        write(os.path.join(home, "sealed.csv"), table.replace("end,", "end, seal 540aff5d,").replace("\n", "\r\n") + "\r\n")
        os.mkfifo(os.path.join(home, "pipe.csv"))
        ini, hal = os.path.join(home, "my.ini"), os.path.join(home, "my.hal")
        write(ini, "[HAL]\nHALCMD = loadrt squareness names=c table=%s/five.csv\n[SQUARENESS]\nTABLE = %s/four.csv\n" % (home, home))
        write(hal, "# loadrt squareness names=a table=%s/commented.csv\nloadrt squareness names=a,b chain=w.b-X-Y-Z-t \\\n"
                   "  table=%s/one.csv:$(CONFIG_DIR)/three.csv:%s/sealed.csv:%s/pipe.csv:%s/none.csv\n"
                   "loadrt squareness table=[SQUARENESS]TABLE\nloadrt other table=%s/commented.csv\n" % ((home,) * 6))
        before = snapshot(home)
        sentences = error_tables.unsealed(IniFile(ini), [hal], home)
        self.assertEqual(snapshot(home), before)
        named = [sentence.split(" has no seal")[0].split("/")[-1] for sentence in sentences]
        self.assertEqual(named, ["five.csv", "one.csv", "three.csv", "four.csv"])
        self.assertIn("run: plumb squareness --table %s/one.csv --seal" % home, sentences[1])
        self.assertTrue(error_tables.lacks_seal(os.path.join(home, "two words.csv")))
        write(ini, "[SQUARENESS]\nTABLE = none\n")
        self.assertEqual(list(error_tables.loaded(read(hal).replace("\\\n", " "), IniFile(ini), home))[-1].split("/")[-1], "none.csv")

    def machine(self, joints, columns):
        """A machine with a table of Y, and these lines of its joints; limits of a stage as in configs/portal."""
        home = own_folder(self)
        write(os.path.join(home, "y.csv"), "Y,%s\n0,%s\n10,%s\n# end, 2 rows\n" % (columns, *[",".join("0" for _ in columns.split(","))] * 2))
        write(os.path.join(home, "my.hal"), "loadrt squareness names=a table=$(CONFIG_DIR)/y.csv\n")
        write(os.path.join(home, "my.ini"), "[TRAJ]\nLINEAR_UNITS = mm\n" + joints)
        ini = IniFile(os.path.join(home, "my.ini"))
        reserves = {0: 500, 1: 400, "VELOCITY": 50}

        class Its:
            files, unit, inch = [os.path.join(home, "my.hal")], 1, False

            def reserve(self, joint, name):
                return reserves["VELOCITY" if name == "VELOCITY" else joint]

        its = Its()
        its.ini, its.joints = ini, {"X": [0], "Y": [1]}
        return its, home

    def test_a_table_of_an_axis_that_linuxcnc_compensates_is_refused(self):
        for line, refused in (("BACKLASH = 0.01", 1), ("BACKLASH = 0.0", 0), ("COMP_FILE = y.comp", 1), ("BACKLASH = -0", 0), ("COMP_FILE_TYPE = 1", 0)):
            for columns, scale in (("EYY", True), ("EYY+,EYY-", True), ("EXY", False), ("EXY+,EXY-", False)):
                machine, home = self.machine("[JOINT_1]\n%s\n" % line, columns)
                found = list(error_tables.compensated(machine, home))
                self.assertEqual(len(found), refused if scale else 0, (line, columns))
                for sentence in found:
                    self.assertIn("LinuxCNC compensates joint 1 by %s of [JOINT_1], and the error table %s/y.csv has %s" % (line, home, columns.replace(",", " and ")), sentence)
                self.assertEqual(len(list(error_tables.own_compensation(machine, home))), refused if not scale else 0)
        machine, home = self.machine("[JOINT_0]\nCOMP_FILE = x y.comp\nCOMP_FILE_TYPE = 1\n", "EYY")
        self.assertEqual(list(error_tables.compensated(machine, home)), [])
        note = list(error_tables.own_compensation(machine, home))[0]
        self.assertIn("plumb volume import --from linuxcnc 'x y.comp' --axis X --type 1 --output x.csv", note)

    def test_a_stage_that_is_slower_than_a_turn_is_named_with_the_settings(self):
        machine, home = self.machine("", "EYY+,EYY-")
        note = list(error_tables.slow_turns(machine, home))
        self.assertEqual(len(note), 1)
        self.assertIn("reversal-acceleration to at most 100 and reversal-rate to at most 0.9", note[0])
        self.assertEqual(list(error_tables.slow_turns(*self.machine("", "EYY"))), [])

    def test_the_limits_of_a_drive_have_two_spellings(self):
        for name in ("STEPGEN_MAXACCEL", "STEPGEN_MAX_ACC", "OTHER"):
            its, _home = self.machine("[JOINT_0]\nMAX_ACCELERATION = 500\n%s = 700\n" % name, "EYY")
            machine = Machine.__new__(Machine)
            machine.ini = its.ini
            self.assertEqual(machine.reserve(0, "ACCELERATION"), 125 if name == "OTHER" else 200)

    def test_a_rotary_axis_without_a_joint_is_named(self):
        for value, named in (("YA", ["A"]), ("AC", ["A", "C"]), ("Y", []), ("none", []), ("", [])):  # Y has a joint
            machine, _home = self.machine("[SQUARENESS]\nROTARY = %s\n" % value if value else "", "EYY")
            found = list(rotary_axes.without_joint(machine))
            self.assertEqual([note.split(",")[0] for note in found], ["[SQUARENESS]ROTARY names " + letter for letter in named])
        self.assertIn("--joints X=0,Y=1,Z=2,A=3; or net joint.N.pos-cmd to square.a-position", list(rotary_axes.without_joint(self.machine("[SQUARENESS]\nROTARY = A\n", "EYY")[0]))[0])


class Copies(unittest.TestCase):
    def setUp(self):
        self.root = own_folder(self)
        self.source, self.copy = os.path.join(self.root, "source"), os.path.join(self.root, "copy")
        os.mkdir(self.source)

    def test_a_script_of_ours_runs_no_other_command_in_a_folder_of_any_name(self):
        for name in ODD_NAMES:
            folder = os.path.join(self.root, name)
            os.mkdir(folder)
            write(os.path.join(folder, "own.py"), "import sys\nprint(sys.argv[1:])\n")
            write(os.path.join(folder, "script"), trial.script(os.path.join(folder, "own.py"), name))
            os.chmod(os.path.join(folder, "script"), 0o755)
            found = subprocess.run([os.path.join(folder, "script"), "two words"], cwd=folder, capture_output=True, text=True, check=True)
            self.assertEqual(found.stdout, "%s\n" % [name, "two words"])
            self.assertEqual(sorted(os.listdir(folder)), ["own.py", "script"])

    def test_links_to_files_hard_links_and_rights(self):
        outside = os.path.join(self.root, "outside")
        os.makedirs(os.path.join(self.source, "deep"))
        write(outside, "mine\n")
        for name in ("link", "deep/link"):
            os.symlink(outside, os.path.join(self.source, name))
        os.link(outside, os.path.join(self.source, "hard"))
        os.symlink("nowhere", os.path.join(self.source, "broken"))
        os.mkfifo(os.path.join(self.source, "pipe"))
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(os.path.join(self.source, "socket"))
        before = snapshot(self.root)
        copies.copy_folder(self.source, self.copy)
        for name in ("link", "deep/link", "hard"):
            write(os.path.join(self.copy, name), "ruined\n")
        self.assertEqual(sorted(os.listdir(self.copy)), ["deep", "hard", "link"])
        copies.copy_links(self.source, self.copy + "-links")
        self.assertEqual(sorted(os.listdir(self.copy + "-links")), ["deep", "link"])
        after = {name: found for name, found in snapshot(self.root).items() if not name.startswith("copy")}
        self.assertEqual({**after, ".": None}, {**before, ".": None})


    def test_a_folder_for_temporary_files_in_the_folder_is_left_out(self):
        write(os.path.join(self.source, "file"), "mine\n")
        copy = os.path.join(self.source, "tmp", "trial", "copy")
        os.makedirs(os.path.dirname(copy))
        copies.copy_folder(self.source, copy)
        self.assertEqual(os.listdir(copy), ["file"])


class Ends(unittest.TestCase):
    """The end of a trial."""

    def test_a_program_that_halcmd_supposes_never_to_come_is_given_its_own_time(self):
        words = trial.WRONG_NAME.decode()
        with mock.patch.object(trial, "NAME_PATIENCE", 0.5):
            status, output = trial.finished(["sh", "-c", 'echo "%s"; exec sleep 100' % words], os.environ, 90)
        self.assertEqual((status, output.split("\n")), (-15, [words, "", "LinuxCNC did not end within 0 s"]))
        self.assertEqual(trial.finished(["sh", "-c", "echo here; exit 3"], os.environ, 90), (3, "here\n"))

    def test_a_program_has_no_terminal_and_its_group_is_its_own(self):
        master, slave = os.openpty()
        self.addCleanup(os.close, master)
        self.addCleanup(os.close, slave)
        script = "import sys, trial\nsys.exit(trial.finished(['sh', '-c', 'echo x > /dev/tty; kill -TERM 0; sleep 100'], None, 90)[0] + 15)"

        def take_terminal():
            os.setsid()
            fcntl.ioctl(slave, termios.TIOCSCTTY, 0)

        done = subprocess.run([sys.executable, "-c", script], env={**os.environ, "PYTHONPATH": ":".join(sys.path)}, stdin=slave, preexec_fn=take_terminal)
        self.assertEqual(done.returncode, 0)  # it was not ended with the program
        self.assertEqual(select.select([master], [], [], 0)[0], [])

    def test_the_last_words_are_those_before_linuxcnc_reports_its_end(self):
        said = ["./m.hal:%d: no" % line for line in range(1, 61)] + ["waits" + 500 * ".", "Shutting down and cleaning up LinuxCNC...", "log:"]
        self.assertEqual(trial.last_words("\n".join(said)).split("\n"), ["  ./m.hal:%d: no" % line for line in range(22, 61)] + ["  waits..."])


class Sandbox(unittest.TestCase):
    """A program in the namespaces of a trial, without LinuxCNC."""

    def setUp(self):
        self.root = own_folder(self)
        for name in ("home", "copy", "own", "outside", "user/deep"):
            os.makedirs(os.path.join(self.root, name))
        for name in ("home/file", "copy/file", "outside/file", "own/cover", "outside/covered", "user/file", "user/deep/file"):
            write(os.path.join(self.root, name), name + "\n")

    def ours(self):
        """The folders that a trial writes."""
        return [os.path.join(self.root, name) for name in ("copy", "own", "shown", "work")]

    def run_inside(self, lines):
        """The words that a script prints in the place of the copy."""
        path = os.path.join(self.root, "copy", "script")
        write(path, "\n".join(lines) + "\n")
        self.before = snapshot(self.root, self.ours())
        plan = {
            "home": os.path.join(self.root, "home"),
            "copy": os.path.join(self.root, "copy"),
            "own": os.path.join(self.root, "own"),
            "covers": [(os.path.join(self.root, "own", "cover"), os.path.join(self.root, "outside", "covered"))],
            "keep": [BUILD],
        }
        program = [os.path.join(BUILD, "bin", "plumb"), "run", "--"]
        others = {name: "here" for name in ("DISPLAY", "DBUS_SESSION_BUS_ADDRESS", "XDG_RUNTIME_DIR")}
        with mock.patch.dict(os.environ, {**others, "HOME": os.path.join(self.root, "user")}):
            command, environment = trial.in_sandbox(plan, program, ["sh", "./script"])
        done = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, check=False)
        self.assertTrue(os.path.exists(os.path.join(self.root, "own", "ready")), done.stdout)
        return done.stdout

    def outside_as_before(self):
        self.assertEqual(snapshot(self.root, self.ours()), self.before)

    def test_all_but_the_copy_and_memory_is_read_only(self):
        # Opened for writing, and left as they are: where the sandbox fails, no setting of the computer changes.
        writable = ["file", "new", "$HOME/file", "$HOME/new", "/tmp/new", "/var/tmp/new", "/dev/shm/new", "/run/new"]
        refused = ["../outside/file", "../outside/new", "$HOME/deep/file", "/etc/plumb-test", "/usr/plumb-test", "/plumb-test",
                   "/proc/sys/kernel/core_pattern", "/sys/kernel/rcu_expedited"]
        words = self.run_inside(
            ["cat file ../outside/covered $HOME/file $HOME/deep/file"]
            + ["(: >> %s) 2>/dev/null && echo wrote %s" % (path, path.replace("$", "_")) for path in writable + refused]
            + ["(%s) >/dev/null 2>&1 && echo ran %s" % (words, words.split()[0]) for words in (
                "rm ../outside/file", "chmod 777 ../outside/file", "touch -d yesterday ../outside/file", "ln ../outside/file hard",
                "mount -o remount,bind,rw /", "umount /run", "mv ../outside/file ../outside/moved", "mknod device b 1 1")]
        )
        self.assertEqual(
            words.splitlines(),
            ["copy/file", "own/cover", "user/file", "user/deep/file", *("wrote " + path.replace("$", "_") for path in writable)],
        )
        self.outside_as_before()

    def test_no_device_socket_or_network_of_the_computer_is_in_sight(self):
        place = self.enterContext(TemporaryFolder("/tmp"))
        address = os.path.join(place, "socket")
        with socket.socket(socket.AF_UNIX) as near, socket.socket(socket.AF_INET) as far:
            near.bind(address)
            near.listen()
            far.bind(("127.0.0.1", 0))
            far.listen()
            self.addCleanup(os.unlink, address)
            program = "import socket\nfor family, address in ((1, %r), (2, %r)):\n try:\n  socket.socket(family).connect(address)\n" \
                "  print('connected', address)\n except OSError:\n  pass\n"
            words = self.run_inside([
                "%s -c \"%s\"" % (sys.executable, program % (address, far.getsockname())),
                "ls /run; ls -1 /tmp | grep -v plumb-host; find /dev/ -type b",
                "ls -d /dev/tty[A-Z]* /dev/mem /dev/hidraw* /dev/i2c* 2>/dev/null",
                "echo \"$DISPLAY$DBUS_SESSION_BUS_ADDRESS$XDG_RUNTIME_DIR\""])
        shown = {path.split("/")[2] for path in (self.root, BUILD) if path.startswith("/tmp/")}
        self.assertEqual(words.split(), ["plumb-wire", *sorted(shown)])


if __name__ == "__main__":
    unittest.main()

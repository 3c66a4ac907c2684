# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb-retain, the real program, beside components in the virtual-time host; retain_stock_test.py has it on LinuxCNC.

    python3 tests/support/run.py tests/components/io/plumb_retain_test.py --kills 5000

kills it as often. PLUMB_BUILD names the build folder.
"""

import fcntl
import glob
import math
import os
import random
import re
import signal
import stat
import subprocess
import sys
import time
import unittest
import zlib
from unittest import mock

import plumb
from tree import BUILD, own_folder

RETAIN = os.path.join(BUILD, "bin", "plumb-retain")
PATIENCE = 30  # s of real time, for an event that takes a moment
EVERY = 0.05  # s between two looks
FRESH = 1.5  # it.in of a specimen

FOREIGN, DAMAGED, VERSION, INACCESSIBLE, UNFIT, REFUSED, PROGRAM, COMPUTER, OLDER, UNNAMED, NAMELESS = range(1, 12)

kills = 20


def processes():
    """Numbers of the retains that run, by the path of their TOML file.

    A child of one has its command line until it becomes halcmd.
    """
    found = {}
    for line in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            with open(line, "rb") as file:
                words = file.read().decode(errors="replace").split("\0")
        except OSError:
            continue
        if os.path.basename(words[0]) == "plumb-retain" and "--file" in words:
            found[int(line.split("/")[2])] = words[words.index("--file") + 1]
    return {file: process for process, file in found.items() if parent(process) not in found}


def parent(process):
    try:
        with open("/proc/%d/stat" % process) as file:
            return int(file.read().rpartition(")")[2].split()[1])
    except OSError:
        return None


def kill(process):
    """Returns when it is dead: after the signal it may still finish its last act."""
    os.kill(process, signal.SIGKILL)
    while alive(process):
        time.sleep(0.0005)


def alive(process):
    """One of its threads may yet be in a system call when the first is dead."""
    try:
        for task in glob.glob("/proc/%d/task/*/stat" % process):
            with open(task) as file:
                if file.read().rpartition(")")[2].split()[0] not in "ZX":
                    return True
    except OSError:
        return alive(process)
    return False


def await_lock(store):
    """Until a killed plumb-retain has no lock on its store any more: a busy computer frees it a moment after the death."""
    with open(store + ".lock", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)


def checksummed(rest, version=1):
    return "# retain %d, CRC-32 of the rest: %08x\n%s" % (version, zlib.crc32(rest.encode()), rest)


def contents(store):
    """The pins of a store, as text by name, and all records as text; asserts that it is whole."""
    with open(store) as file:
        text = file.read()
    head, rest = text.split("\n", 1)
    assert text == checksummed(rest), text
    pins = dict(re.findall(r'^"(\S+)" = (\S+)$', rest.split("[records]")[0], re.MULTILINE))
    return pins, re.findall(r"^  \{ (.*) \},$", rest, re.MULTILINE)


class Machine:
    """A host with two specimens, it and other, on a servo thread, and plumb-retain in a folder."""

    def __init__(self, folder, start=True, load="loadrt specimen names=it,other"):
        self.folder = folder
        self.host = plumb.Host(modules=[os.path.join(BUILD, "specimens")])
        self.host.command("loadrt threads name1=servo-thread period1=1000000")
        self.host.command(load)
        for name in load.split("=")[1].split(","):
            self.host.command("addf %s.update servo-thread" % name)
        if start:
            self.host.command("start")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.host.close()

    def retain(self, toml, name="plumb-retain", wait=True, environment="", before=""):
        """Loads plumb-retain with a TOML file of this text, NAME.toml."""
        path = os.path.join(self.folder, name + ".toml")
        with open(path, "w") as file:
            file.write(toml)
        self.errors = os.path.join(self.folder, name + ".errors")
        shell = before + 'trap "" XFSZ; exec env %s "$0" "$@" 2>"%s"' % (environment, self.errors)
        line = "loadusr %s /bin/sh -c '%s' %s %s --file %s --period 0.01"
        try:
            self.host.command(line % ("-Wn " + name if wait else "", shell, RETAIN, name, path))
        except plumb.Refused as refusal:
            refusal.add_note("output of plumb-retain: " + self.said())
            raise

    def said(self):
        with open(self.errors) as file:
            return file.read()

    def get(self, name):
        return self.host.get(name)

    def until(self, condition, what):
        """Lets virtual time pass until condition() is true."""
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise AssertionError("%s did not come; output of plumb-retain: %s" % (what, self.said()))
            self.host.run(0.01)
            time.sleep(0.001)

    def await_pin(self, pin, value=True):
        self.until(lambda: self.get(pin) == value, "%s = %s" % (pin, value))

    def go(self, seconds):
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "the end")

    def await_saved(self, name, value):
        """Until the store of `plumb-retain` has this text for a pin."""
        store = os.path.join(self.folder, "plumb-retain.retained")
        self.until(lambda: os.path.exists(store) and contents(store)[0].get(name) == value, "%s = %s" % (name, value))

    def give(self, *records, to="it"):
        for tool, length in records:
            self.host.set(to + ".restore-tool", tool)
            self.host.set(to + ".restore-length", length)
            self.host.set(to + ".restore", True)
            self.host.run(0.002)
            self.host.set(to + ".restore", False)
            self.host.run(0.002)

    def records(self, of="it"):
        found = []
        for row in range(self.get(of + ".rows")):
            self.host.set(of + ".row", row)
            self.host.run(0.002)
            found.append((self.get(of + ".row-tool"), self.get(of + ".row-length")))
        return found

    def unload(self, name="plumb-retain"):
        """As `halcmd unloadusr` does; waits until it has ended."""
        self.host.command("unloadusr " + name)
        toml = os.path.join(self.folder, name + ".toml")
        self.until(lambda: toml not in processes(), "the end of plumb-retain")


SETTINGS = """\
machine = "bench"
pins = ["it.in", "it.order", "it.call-system"]
records = ["it"]
every = %g
""" % EVERY


EMPTY = 'machine = "bench"\n\n[pins]\n"it.in" = 1.0\n\n[records]\n'


class Keeping(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)
        self.store = os.path.join(self.folder, "plumb-retain.retained")

    def machine(self, **options):
        machine = Machine(self.folder, **options)
        self.addCleanup(machine.host.close)
        return machine

    def write_store(self, text):
        with open(self.store, "w") as file:
            file.write(text)

    def read_store(self):
        with open(self.store) as file:
            return file.read()

    def test_pins_and_records_outlive_a_restart(self):
        records = [(3, 0.1 + 0.2), (-2147483648, 5e-324), (2147483647, 1.7976931348623157e308)]
        with self.machine() as machine:
            machine.retain(SETTINGS)
            machine.await_pin("plumb-retain.restored")
            machine.host.set("it.in", 0.1)
            machine.host.set("it.order", -7)
            machine.give(*records)
            machine.await_saved("it.order", "-7")
            machine.until(lambda: len(contents(self.store)[1]) == 3, "the records")
        with self.machine() as machine:
            machine.retain(SETTINGS)
            machine.await_pin("plumb-retain.restored")
            self.assertEqual(machine.get("it.in"), 0.1)
            self.assertEqual(machine.get("it.order"), -7)
            machine.unload()
            self.assertEqual(machine.records(), records)
            self.assertEqual(machine.said(), "")

    def test_every_value_of_every_type_comes_back_exactly(self):
        floats = [0.1, -0.0, 1e-300, 5e-324, 1e22, 123456789.0, 2.5e15, math.inf, -math.inf, math.nan]
        names = ["a%d" % i for i in range(len(floats))]
        load = "loadrt lowpass names=" + ",".join(names)
        toml = 'machine = "m"\npins = ["u.0.in", "s.in", "b.in", %s]\nevery = 0.05\n'
        toml %= ", ".join('"%s.in"' % name for name in names)
        values = {"u.0.in": 4294967295, "s.in": -2147483648, "b.in": True}
        values.update(("%s.in" % name, value) for name, value in zip(names, floats))
        for first in (True, False):
            with plumb.Host() as host:
                machine = Machine.__new__(Machine)
                machine.host, machine.folder = host, self.folder
                host.command(load)
                host.command("loadrt conv_u32_s32 names=u.0")
                host.command("loadrt conv_s32_u32 names=s")
                host.command("loadrt not names=b")
                if first:
                    for name, value in values.items():
                        host.set(name, value)
                machine.retain(toml)
                machine.await_pin("plumb-retain.restored")
                machine.until(lambda: os.path.exists(self.store), "the store")
                for name, value in values.items():
                    self.assertEqual(repr(host.get(name)), repr(value), name)

    def test_waits_for_realtime_and_saves_nothing_before(self):
        self.write_store(checksummed('machine = "bench"\n\n[pins]\n\n[records]\n"it" = [\n  { length = 1.5, tool = 3 },\n]\n'))
        kept = self.read_store()
        machine = self.machine(start=False)
        machine.retain(SETTINGS)
        machine.await_pin("plumb-retain.waiting")
        machine.go(0.5)
        self.assertFalse(machine.get("plumb-retain.restored"))
        self.assertFalse(machine.get("plumb-retain.fault"))
        self.assertEqual(self.read_store(), kept)
        machine.host.command("start")
        machine.await_pin("plumb-retain.restored")
        self.assertFalse(machine.get("plumb-retain.waiting"))
        machine.await_saved("it.in", "1.5")
        self.assertEqual(contents(self.store)[1], ["length = 1.5, tool = 3"])

    def test_what_the_component_has_is_replaced(self):
        machine = self.machine()
        machine.give((1, 1), (2, 2))
        self.write_store(checksummed('machine = "bench"\n\n[pins]\n\n[records]\n"it" = [\n  { length = 1.5, tool = 3 },\n]\n'))
        machine.retain(SETTINGS)
        machine.await_pin("plumb-retain.restored")
        machine.unload()
        self.assertEqual(machine.records(), [(3, 1.5)])

    def refused(self, machine, code, words, name="plumb-retain"):
        """plumb-retain has refused the content of the store: it reports why, saves nothing, and is not ready for work."""
        machine.await_pin(name + ".fault-code", code)
        machine.go(0.1)
        self.assertTrue(machine.get(name + ".fault"))
        self.assertFalse(machine.get(name + ".restored"))
        self.assertEqual(machine.get(name + ".saves"), 0)
        self.assertRegex(machine.said(), words)

    def test_a_bad_store_is_refused_and_left_as_it_is(self):
        with self.machine() as machine:
            machine.retain(SETTINGS)
            machine.await_pin("plumb-retain.restored")
            machine.give((3, 30.5))
            machine.until(lambda: os.path.exists(self.store) and contents(self.store)[1], "the record")
        good = self.read_store()
        rest = good.split("\n", 1)[1]
        changed = good.replace("30.5", "30.6")
        bad = [
            (FOREIGN, "no file of plumb-retain: it begins with 'G0 X10'", "G0 X10\nM2\n"),
            (FOREIGN, "machine 'other', not of 'bench'", checksummed(rest.replace("bench", "other"))),
            (VERSION, "is of version 0; this plumb-retain reads version 1", checksummed(rest, 0)),
            (VERSION, "is of version 2; this plumb-retain reads version 1", checksummed(rest, 2)),
            (DAMAGED, "truncated or was changed: .*[0-9a-f]{8}", changed),
            (DAMAGED, "truncated or was changed", good + "\n"),
            (DAMAGED, "not a file of plumb-retain", checksummed('machine = "bench"\n')),
            (DAMAGED, "not a file of plumb-retain", checksummed('machine = "bench"\npins = 1\n[records]\n')),
            (DAMAGED, "not a file of plumb-retain", checksummed('machine = "bench"\n[pins]\na="b"\n[records]\n')),
            (DAMAGED, ": Error while parsing", checksummed("machine = \n")),
        ]
        bad += [(DAMAGED, "truncated", good[:length]) for length in range(0, len(good), 17)]
        machine = self.machine()
        for number, (code, words, text) in enumerate(bad):
            name = "r%d" % number
            store = os.path.join(self.folder, name + ".retained")
            with open(store, "w") as file:
                file.write(text)
            with self.subTest(text):
                machine.retain(SETTINGS, name)
                self.refused(machine, code, re.escape(store) + ".*" + words, name)
                with open(store) as file:
                    self.assertEqual(file.read(), text)
        self.assertEqual(machine.records(), [])

    def test_a_store_that_cannot_be_is_reported(self):
        machine = self.machine()
        os.mkdir(os.path.join(self.folder, "folder"))
        os.mkfifo(os.path.join(self.folder, "pipe"))
        os.mkfifo(os.path.join(self.folder, "locked-by-pipe.lock"))
        os.symlink("target", os.path.join(self.folder, "locked-by-link.lock"))
        with open(os.path.join(self.folder, "first"), "w") as file:
            file.write(checksummed(EMPTY))
        os.link(os.path.join(self.folder, "first"), os.path.join(self.folder, "second"))
        for name, store, words in (
            ("a", self.folder + "/nowhere/mill.retained", "nowhere.*No such file or directory"),
            ("b", self.folder + "/folder", "folder: Is a directory"),
            ("c", self.folder + "/pipe", "pipe is no regular file"),
            ("d", self.folder + "/second", "second has another name, a hard link"),
            ("e", self.folder + "/locked-by-link", "locked-by-link.lock is a link"),
            ("f", self.folder + "/locked-by-pipe", "locked-by-pipe.lock is no regular file"),
        ):
            machine.retain(SETTINGS + 'store = "%s"\n' % store, name)
            self.refused(machine, INACCESSIBLE, words, name)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "target")))

    def test_a_pipe_for_its_settings_or_its_program_does_not_hang(self):
        machine = self.machine()
        os.mkfifo(os.path.join(self.folder, "pipe.toml"))
        with self.assertRaisesRegex(plumb.Refused, "pipe.toml is no regular file"):
            machine.host.command("loadusr -Wn it2 %s it2 --file %s/pipe.toml" % (RETAIN, self.folder))
        machine.retain('machine = "m"\nprogram = ["%s/pipe.toml"]\n' % self.folder)
        machine.await_pin("plumb-retain.fault-code", PROGRAM)
        self.assertRegex(machine.said(), "pipe.toml is no regular file")

    def await_change(self, machine, value):
        machine.host.set("it.in", value)
        machine.await_saved("it.in", "%.1f" % value)

    def test_the_store_keeps_its_rights(self):
        for mode in (0o600, 0o664, 0o444 | stat.S_IWUSR | stat.S_IXGRP):
            with self.subTest(oct(mode)), self.machine() as machine:
                self.write_store(checksummed(EMPTY))
                os.chmod(self.store, mode)
                machine.retain(SETTINGS)
                machine.await_pin("plumb-retain.restored")
                self.await_change(machine, 5)
                self.assertEqual(stat.S_IMODE(os.stat(self.store).st_mode), mode)
                os.unlink(self.store)  # which its owner may do; the next one is like it
                self.await_change(machine, 6)
                self.assertEqual(stat.S_IMODE(os.stat(self.store).st_mode), mode)
                machine.unload()

    @unittest.skipIf(os.geteuid() != 0, "only root may give a file away")
    def test_the_store_keeps_its_owner(self):
        machine = self.machine()
        self.write_store(checksummed(EMPTY))
        os.chmod(self.store, 0o600)
        os.chown(self.store, 4321, 4322)
        machine.retain(SETTINGS)
        machine.await_pin("plumb-retain.restored")
        self.await_change(machine, 5)
        state = os.stat(self.store)
        self.assertEqual((state.st_uid, state.st_gid, stat.S_IMODE(state.st_mode)), (4321, 4322, 0o600))

    def test_a_link_where_it_writes_again_is_not_followed(self):
        machine = self.machine()
        secret = os.path.join(self.folder, "secret")
        with open(secret, "w") as file:
            file.write("secret")
        for link in (os.symlink, os.link):
            link(secret, self.store + ".new")
            machine.retain(SETTINGS)
            machine.await_pin("plumb-retain.restored")
            self.await_change(machine, 5)
            machine.unload()
            with open(secret) as file:
                self.assertEqual(file.read(), "secret")
            os.unlink(self.store)

    @unittest.skipIf(os.geteuid() != 0, "only root is more than one user")
    def test_a_link_of_another_user_in_a_folder_for_all_is_refused(self):
        machine = self.machine()
        shared = os.path.join(self.folder, "shared")
        os.mkdir(shared)
        os.chmod(shared, 0o1777)
        os.symlink(self.folder + "/target", shared + "/theirs")
        os.chown(shared + "/theirs", 4321, 4321, follow_symlinks=False)
        machine.retain(SETTINGS + 'store = "%s/theirs"\n' % shared, "theirs")
        self.refused(machine, INACCESSIBLE, "theirs is a link of user 4321 in a folder that all can write", "theirs")
        os.symlink(self.folder + "/own-target", shared + "/own")
        machine.retain(SETTINGS + 'store = "%s/own"\n' % shared, "own")
        machine.await_pin("own.saves", 1)
        self.assertEqual(sorted(os.listdir(shared)), ["own", "theirs"])
        self.assertTrue(os.path.exists(self.folder + "/own-target"))

    def unplugged(self):
        """A machine whose plumb-retain cannot write a changed value, for the folder of its store, also returned, is away."""
        machine = self.machine()
        folder = os.path.join(self.folder, "usb")
        os.mkdir(folder)
        machine.retain(SETTINGS + 'store = "%s/mill.retained"\n' % folder)
        machine.await_pin("plumb-retain.saves", 1)
        os.rename(folder, folder + ".away")
        machine.host.set("it.in", 3)
        machine.await_pin("plumb-retain.fault-code", INACCESSIBLE)
        return machine, folder

    def test_a_store_that_can_no_more_be_written_is_reported_and_tried_again(self):
        machine, folder = self.unplugged()
        self.assertTrue(machine.get("plumb-retain.restored"))
        self.assertRegex(machine.said(), "usb/mill.retained.new: No such file")
        os.rename(folder + ".away", folder)
        machine.await_pin("plumb-retain.fault", False)
        self.assertEqual(contents(folder + "/mill.retained")[0]["it.in"], "3.0")

    def test_a_full_disk_leaves_the_store_as_it_was(self):
        machine = self.machine()
        machine.retain(SETTINGS)
        machine.await_pin("plumb-retain.saves", 1)
        kept = self.read_store()
        process = processes()[os.path.join(self.folder, "plumb-retain.toml")]
        subprocess.run(["prlimit", "--pid", str(process), "--fsize=100"], check=True)
        machine.host.set("it.in", 3)
        machine.await_pin("plumb-retain.fault-code", INACCESSIBLE)
        self.assertEqual(self.read_store(), kept)
        self.assertFalse(os.path.exists(self.store + ".new"))
        self.assertRegex(machine.said(), "retained.new: File too large")

    def test_what_is_named_has_to_be_there_and_writable(self):
        machine = self.machine()
        machine.host.command("net linked other.sum => it.in")
        machine.host.command("loadrt lowpass names=filter")
        store = checksummed('machine = "m"\n\n[pins]\n"it.order" = 1.5\n"other.order" = 3000000000\n\n[records]\n')
        for number, (lines, words) in enumerate(
            (
                ('pins = ["it.nothing"]', "r0.toml: there is no pin it.nothing"),
                ('pins = ["it.sum"]', "r1.toml: it.sum is an output"),
                ('pins = ["it.in"]', "r2.toml: it.in is linked"),
                ('pins = ["it.order"]', "r3.toml: it.order, s32, cannot be 1.5"),
                ('pins = ["other.order"]', "r4.toml: other.order, s32, cannot be 3000000000"),
                ('records = ["nobody"]', "r5.toml: there are no records: there is no pin nobody.row-..."),
                ('records = ["filter"]', "r6.toml: there are no records: there is no pin filter.row-..."),
            )
        ):
            name = "r%d" % number
            with open(os.path.join(self.folder, name + ".retained"), "w") as file:
                file.write(store)
            with self.subTest(lines):
                machine.retain('machine = "m"\n' + lines, name)
                self.refused(machine, UNFIT, re.escape(words), name)

    def test_it_goes_on_when_what_is_named_comes(self):
        self.write_store(checksummed('machine = "bench"\n\n[pins]\n"later.in" = 2.5\n\n[records]\n'))
        machine = self.machine()
        machine.retain('machine = "bench"\npins = ["later.in"]\n')
        machine.await_pin("plumb-retain.fault-code", UNFIT)
        machine.host.command("loadrt lowpass names=later")
        machine.await_pin("plumb-retain.restored")
        self.assertFalse(machine.get("plumb-retain.fault"))
        self.assertEqual(machine.get("later.in"), 2.5)

    def test_an_instance_takes_over_the_values_kept_under_its_former_name(self):
        with self.machine() as machine:
            machine.retain(SETTINGS)
            machine.await_pin("plumb-retain.restored")
            machine.host.set("it.in", 0.25)
            machine.give((3, 1.5))
            machine.await_saved("it.in", "0.25")
            machine.until(lambda: contents(self.store)[1], "the record")
        renamed = SETTINGS.replace("it", "new") + 'formerly = { new = "it" }\n'
        with self.machine(load="loadrt specimen names=new") as machine:
            machine.retain(renamed)
            machine.await_pin("plumb-retain.restored")
            self.assertEqual(machine.get("new.in"), 0.25)
            machine.unload()
            self.assertEqual(machine.records("new"), [(3, 1.5)])
            self.assertEqual(machine.said(), "")
        self.assertNotIn('"it', self.read_store())
        with self.machine(load="loadrt specimen names=new") as machine:  # formerly has no effect any more
            machine.retain(renamed)
            machine.await_pin("plumb-retain.restored")
            self.assertEqual(machine.get("new.in"), 0.25)
            machine.unload()
            self.assertEqual(machine.records("new"), [(3, 1.5)])

    def test_values_under_the_name_of_today_come_before_those_of_a_former_name(self):
        self.write_store(
            checksummed(
                'machine = "bench"\n\n[pins]\n"it.in" = 2.0\n"old.in" = 1.0\n"old.order" = 7\n\n[records]\n'
                '"it" = [\n  { length = 2.5, tool = 2 },\n]\n"old" = [\n  { length = 1.5, tool = 1 },\n]\n'
            )
        )
        machine = self.machine()
        machine.retain(SETTINGS + 'formerly = { it = "old" }\n')
        machine.await_pin("plumb-retain.restored")
        self.assertEqual((machine.get("it.in"), machine.get("it.order")), (2.0, 7))
        machine.unload()
        self.assertEqual(machine.records(), [(2, 2.5)])
        self.assertIn("holds old.in, which", machine.said())
        self.assertIn("holds records of old, which", machine.said())

    def test_records_with_other_fields_are_refused(self):
        machine = self.machine()
        for number, (record, words) in enumerate(
            (
                ("length = 1.5", "records of it are kept without tool"),
                ("length = 1.5, tool = 3, colour = 4", "it has no field colour, which is kept"),
                ("length = 1.5, tool = 0.5", "it.restore-tool, s32, cannot be 0.5"),
            )
        ):
            name = "r%d" % number
            text = checksummed('machine = "bench"\n\n[pins]\n\n[records]\n"it" = [\n  { %s },\n]\n' % record)
            with open(os.path.join(self.folder, name + ".retained"), "w") as file:
                file.write(text)
            machine.retain(SETTINGS, name)
            self.refused(machine, UNFIT, words, name)
        self.assertEqual(machine.records(), [])

    def test_a_quantity_that_an_older_store_lacks_is_0_and_the_component_decides(self):
        machine = self.machine()
        text = 'machine = "bench"\n\n[pins]\n\n[records]\n"it" = [\n  { length = 1.5, tool = 3 },\n  { tool = 4 },\n]\n'
        self.write_store(checksummed(text))
        machine.retain(SETTINGS)
        self.refused(machine, REFUSED, r"it refuses the record \{ tool = 4 \}")  # a length of 0, not the last one
        self.assertEqual(machine.records(), [])

    def test_where_one_record_is_refused_all_is_as_before(self):
        machine = self.machine()
        machine.give((1, 1))
        record = "  { length = %s, tool = 3 },\n"
        text = 'machine = "bench"\n\n[pins]\n"it.in" = 9.0\n"it.order" = 9\n\n[records]\n"it" = [\n%s]\n"other" = [\n%s]\n'
        self.write_store(checksummed(text % (record % 1.5, record % 2.5 + record % -0.25)))
        kept = self.read_store()
        machine.retain(SETTINGS.replace('["it"]', '["it", "other"]'))
        self.refused(machine, REFUSED, r"retain.toml: other refuses the record \{ length = -0.25, tool = 3 \}")
        self.assertEqual((machine.get("it.in"), machine.get("it.order")), (1.5, 0))
        self.assertEqual((machine.get("it.rows"), machine.get("other.rows")), (0, 0))
        self.assertEqual(self.read_store(), kept)

    def test_where_a_component_falls_silent_in_the_middle_nothing_stays_in_force(self):
        machine = self.machine()
        machine.give((1, 1), to="other")
        text = 'machine = "bench"\n\n[pins]\n"it.in" = 9.0\n\n[records]\n"it" = [\n%s]\n"other" = [\n%s]\n'
        self.write_store(checksummed(text % (2 * ("  { length = 1.5, tool = 3 },\n",))))
        machine.retain(SETTINGS.replace('["it"]', '["it", "other"]'))
        while machine.get("it.rows") == 0:
            machine.host.run(0.001)
        machine.host.command("delf other.update servo-thread")
        machine.await_pin("it.rows", 0)
        machine.await_pin("plumb-retain.waiting")
        self.assertEqual(machine.get("it.in"), 1.5)
        machine.unload()
        self.assertEqual(machine.get("other.rows"), 1)
        machine.host.command("addf other.update servo-thread")
        machine.await_pin("other.rows", 0)
        machine.retain(SETTINGS.replace('["it"]', '["it", "other"]'))
        machine.await_pin("plumb-retain.restored")
        self.assertEqual((machine.records("it"), machine.records("other")), ([(3, 1.5)], [(3, 1.5)]))
        self.assertEqual(machine.get("it.in"), 9)

    def test_the_last_change_is_saved_when_it_is_asked_to_end(self):
        machine = self.machine()
        machine.retain(SETTINGS.replace("0.05", "3600"))
        machine.await_pin("plumb-retain.saves", 1)
        machine.host.set("it.in", 42)
        machine.unload()
        self.assertEqual(contents(self.store)[0]["it.in"], "42.0")

    def test_a_closed_terminal_ends_it_as_a_request_does(self):
        machine = self.machine()
        # The tests may themselves have been started under nohup.
        for name, ignored, heeded in (("kept", "", "--default-signal=HUP"), ("nohup", 'trap "" HUP; ', "")):
            toml = SETTINGS.replace("every = %g" % EVERY, "every = 1000")
            machine.retain(toml, name, before=ignored, environment=heeded)
            machine.await_pin(name + ".saves", 1)
            machine.host.set("it.in", 7)
            process = processes()[os.path.join(self.folder, name + ".toml")]
            os.kill(process, signal.SIGHUP)
            if ignored:
                machine.go(0.3)
                self.assertTrue(alive(process), "nohup has no effect")
                continue
            machine.until(lambda: not alive(process), "the end of " + name)
            self.assertEqual(contents(os.path.join(self.folder, name + ".retained"))[0]["it.in"], "7.0")
            with self.assertRaises(plumb.Refused, msg="it has left its pins in HAL"):
                machine.get(name + ".saves")

    def test_when_the_threads_stand_records_are_kept_as_seen_last(self):
        machine = self.machine()
        machine.retain(SETTINGS)
        machine.await_pin("plumb-retain.restored")
        machine.give((3, 1.5), (4, 2.5))
        machine.until(lambda: len(contents(self.store)[1]) == 2, "the records")
        machine.host.command("stop")
        machine.host.set("it.in", 43)
        began = time.monotonic()
        machine.unload()
        self.assertLess(time.monotonic() - began, 2)
        pins, records = contents(self.store)
        self.assertEqual(pins["it.in"], "43.0")
        self.assertEqual(len(records), 2)

    def test_a_component_that_is_loaded_again_gets_its_records_again(self):
        for moment in (0, 0.5):  # before and after plumb-retain looks
            with self.subTest(moment), self.machine() as machine:
                machine.retain(SETTINGS)
                machine.await_pin("plumb-retain.restored")
                machine.give((3, 1.5), (4, 2.5))
                machine.until(lambda: len(contents(self.store)[1]) == 2, "the records")
                machine.host.command("unloadrt specimen")
                machine.go(moment) if moment else None
                machine.host.command("loadrt specimen names=it,other")
                machine.host.command("addf it.update servo-thread")
                machine.until(lambda: machine.get("it.rows") == 2, "the records")
                machine.await_pin("plumb-retain.restored")
                self.assertEqual(len(contents(self.store)[1]), 2)

    def test_another_may_walk_and_forget(self):
        machine = self.machine()
        machine.retain(SETTINGS)
        machine.await_pin("plumb-retain.restored")
        for records in ([], [(3, 1.5), (4, 2.5)]):
            machine.give(*records)
            machine.until(lambda: len(contents(self.store)[1]) == len(records), "the records")
            machine.host.set("it.forget", True)
            end = time.monotonic() + 1
            while time.monotonic() < end:  # another program holds its row
                machine.host.set("it.row", 0)
                machine.host.run(0.003)
                self.assertTrue(machine.get("plumb-retain.restored"))
            machine.host.set("it.forget", False)
            self.assertEqual(machine.get("it.rows"), 0)
            machine.until(lambda: not contents(self.store)[1], "the end of the records")
        self.assertEqual(machine.said(), "")

    def test_what_was_seen_is_written_when_its_component_goes(self):
        for end in (True, False):
            with self.subTest(end), self.machine() as machine:
                machine.retain(SETTINGS.replace("0.05", "3600"))
                machine.await_pin("plumb-retain.saves", 1)
                machine.host.set("it.in", 42 + end)
                machine.give((3, 1.5))
                machine.go(2.5)
                machine.host.command("unloadrt specimen")
                machine.await_pin("plumb-retain.fault-code", UNFIT)
                if end:
                    machine.unload()
                else:
                    machine.await_pin("plumb-retain.saves", 2)
                pins, records = contents(self.store)
                self.assertEqual((float(pins["it.in"]), len(records)), (42 + end, 1))
                os.unlink(self.store)

    def test_what_cannot_be_written_is_tried_again_at_every_look(self):
        machine = self.machine(start=False)
        folder = os.path.join(self.folder, "usb")
        os.mkdir(folder)
        machine.retain(SETTINGS.replace("0.05", "3600") + 'store = "%s/mill.retained"\n' % folder)
        machine.await_pin("plumb-retain.waiting")
        os.rename(folder, folder + ".away")
        machine.host.command("start")
        machine.await_pin("plumb-retain.fault-code", INACCESSIBLE)
        os.rename(folder + ".away", folder)
        machine.await_pin("plumb-retain.saves", 1)
        self.assertFalse(machine.get("plumb-retain.fault"))

    def test_what_is_as_it_was_stored_needs_no_disk(self):
        machine, folder = self.unplugged()
        machine.host.set("it.in", 1.5)
        machine.await_pin("plumb-retain.fault", False)

    def test_records_that_change_while_they_are_read_are_read_again(self):
        draw = random.Random(1)
        machine = self.machine()
        machine.retain(SETTINGS.replace("0.05", "0.01"))
        machine.give((1, 1), (2, 2), (3, 3))
        machine.await_pin("plumb-retain.saves", 1)
        both = set()
        for number in range(60):
            machine.host.set("it.renumber", 1000 * (number % 2))
            machine.go(0.06 + 0.02 * draw.random())
            records = contents(self.store)[1]
            tools = {int(re.search(r"tool = (\d+)", record)[1]) // 1000 for record in records}
            self.assertEqual(len(tools), 1, records)
            both |= tools
        self.assertEqual(both, {0, 1})

    def test_one_store_is_for_one_retain_at_a_time(self):
        machine = self.machine()
        machine.retain(SETTINGS)
        machine.retain(SETTINGS.replace('["it"]', '["other"]'), "second")
        machine.await_pin("second.restored")
        with self.assertRaises(plumb.Refused):
            machine.retain(SETTINGS + 'store = "%s"\n' % self.store, "third")
        self.assertRegex(machine.said(), "third.toml: %s is kept by another plumb-retain" % re.escape(self.store))
        machine.unload()
        machine.retain(SETTINGS + 'store = "%s"\n' % self.store, "fourth")
        machine.await_pin("fourth.restored")

    def test_former_name_still_works_and_shows_the_new_line(self):
        machine = self.machine()
        with open(os.path.join(self.folder, "it.toml"), "w") as file:
            file.write(SETTINGS)
        machine.errors = os.path.join(self.folder, "errors")
        shell = 'exec "$0" "$@" 2>%s' % machine.errors
        former = os.path.join(BUILD, "bin", "retain")
        machine.host.command("loadusr -Wn retain /bin/sh -c '%s' %s --file %s/it.toml" % (shell, former, self.folder))
        machine.await_pin("retain.restored")
        self.assertIn("plumb-retain: It was started as retain, its former name", machine.said())
        self.assertIn("write: loadusr -Wn retain plumb-retain retain\n", machine.said())

    def test_a_file_that_is_not_there_begins_with_the_name_of_the_machine(self):
        machine = self.machine()
        path = os.path.join(self.folder, "panel.toml")
        line = "loadusr -Wn %s " + RETAIN + " %s --file " + path + ' --machine "%s" --period 0.01'
        machine.host.command(line % ("panel", "panel", "Plumb mill"))
        machine.await_pin("panel.restored")
        with open(path) as file:
            text = file.read()
        self.assertIn('machine = "Plumb mill"\npins = []\n', text)
        machine.host.command("unloadusr panel")
        machine.until(lambda: path not in processes(), "the end of plumb-retain")
        machine.host.command(line % ("again", "again", "another"))  # it is not written again
        machine.await_pin("again.restored")
        with open(path) as file:
            self.assertEqual(file.read(), text)

    def test_wrong_settings_are_reported_with_file_and_line(self):
        machine = self.machine()
        for number, (lines, words) in enumerate(
            (
                ('pins = ["it.in"]', ":1: there is no machine"),
                ('machine = "a"\n\nmashine = "b"', ":3: unknown key 'mashine'"),
                ('machine = ""', ":1: machine is empty"),
                ("machine = 3", ":1: machine is no text"),
                ('machine = "a"\nmachine = "b"', ":2: "),
                ('machine = "a\n', ":1: "),
                ('machine = "a"\npins = "it.in"', ":2: pins is no list"),
                ('machine = "a"\npins = [\n  "it.in",\n  3]', ":4: pins: an element is no name of a pin"),
                ('machine = "a"\npins = [\n  "it.in",\n  "it in"]', ":4: pins: 'it in' is no name of a pin"),
                ('machine = "a"\npins = ["it.in",\n"it.in"]', ":3: pins: 'it.in' is there twice"),
                ('machine = "a"\nstore = "mill.retained"', ":2: store: 'mill.retained' is no absolute path"),
                ('machine = "a"\nprogram = ["part.ngc"]', ":2: program: 'part.ngc' is no absolute path"),
                ('machine = "a"\nformerly = "it"', ':2: formerly is no table: write { "name" = "former name" }'),
                ('machine = "a"\nformerly = { it = "old" }', ":2: formerly: nothing of 'it' is kept"),
                ('machine = "a"\nrecords = ["it"]\nformerly = { it = 3 }', ":3: formerly: the former name of 'it' is no name"),
                ('machine = "a"\nrecords = ["it", "b"]\nformerly = { it = "b" }', ":3: formerly: 'b' is still kept"),
                ('machine = "a"\npins = ["a.x", "b.x"]\nformerly = { a = "c", b = "c" }', ":3: formerly: 'c' is there twice"),
                ('machine = "a"\nevery = "5"', ":2: every is no time"),
                ('machine = "a"\nevery = nan', ":2: every is no time"),
                ('machine = "a"\nevery = 0', ":2: every is no time"),
            )
        ):
            name = "r%d" % number
            with self.subTest(lines):
                with self.assertRaises(plumb.Refused):
                    machine.retain(lines, name)
                self.assertIn("%s.toml%s" % (name, words), machine.said())
        for option, words in (("", "--file"), ("--file mill.toml", "/mill.toml: No such file"), ("--file /nowhere.toml", "/nowhere.toml")):
            with self.assertRaisesRegex(plumb.Refused, words):
                machine.host.command("loadusr -Wn it2 %s it2 %s" % (RETAIN, option))

    def test_the_program_is_known_by_the_checksum_of_its_files(self):
        machine = self.machine()
        main, part = os.path.join(self.folder, "main.ngc"), os.path.join(self.folder, "part.ngc")
        settings = 'machine = "m"\nprogram = ["%s", "%s"]\n' % (main, part)

        def write(path, text):
            with open(path, "w") as file:
                file.write(text)

        def identity(text):
            return zlib.crc32(text.encode()) - (1 << 32) * (zlib.crc32(text.encode()) >> 31)

        write(main, "o100 call\nM2\n")
        write(part, "o100 sub\n")
        machine.retain(settings)
        self.assertEqual(machine.get("plumb-retain.program-id"), identity("o100 call\nM2\no100 sub\n"))
        write(part, "o100 sub\nG0 X0\n")
        machine.await_pin("plumb-retain.program-id", identity("o100 call\nM2\no100 sub\nG0 X0\n"))
        before = os.stat(part)
        write(part, "o100 sub\nG0 X9\n")
        os.utime(part, ns=(before.st_atime_ns, before.st_mtime_ns))
        machine.await_pin("plumb-retain.program-id", identity("o100 call\nM2\no100 sub\nG0 X9\n"))
        os.unlink(part)
        machine.await_pin("plumb-retain.fault-code", PROGRAM)
        self.assertEqual(machine.get("plumb-retain.program-id"), 0)
        self.assertTrue(machine.get("plumb-retain.restored"))
        self.assertRegex(machine.said(), "part.ngc: No such file")
        write(part, "o100 sub\n")
        machine.await_pin("plumb-retain.program-id", identity("o100 call\nM2\no100 sub\n"))
        self.assertFalse(machine.get("plumb-retain.fault"))

    def test_the_date_is_the_local_one(self):
        machine = self.machine()
        before = int(time.strftime("%Y%m%d"))
        machine.retain('machine = "m"\n')
        self.assertIn(machine.get("plumb-retain.date"), (before, int(time.strftime("%Y%m%d"))))

    def test_stock_watchdog_sees_that_it_has_died(self):
        machine = self.machine()
        machine.retain('machine = "m"\n')
        for line in (
            "loadrt watchdog num_inputs=1",
            "net alive plumb-retain.heartbeat => watchdog.input-0",
            "setp watchdog.timeout-0 5",
            "addf watchdog.set-timeouts servo-thread",
            "addf watchdog.process servo-thread",
            "setp watchdog.enable-in 1",
        ):
            machine.host.command(line)
        machine.go(0.1)
        end = machine.host.time + 20
        while machine.host.time < end:
            machine.go(0.01)
            self.assertTrue(machine.get("watchdog.ok-out"))
        process = processes()[os.path.join(self.folder, "plumb-retain.toml")]
        kill(process)
        machine.await_pin("watchdog.ok-out", False)


class Bound(unittest.TestCase):
    """A store that is bound to its computer: plumb-retain asks where it is another's, an old copy, or without a name."""

    SETTINGS = 'machine = "bench"\npins = ["it.in"]\nbound = true\nevery = %g\n' % EVERY

    def setUp(self):
        self.folder, self.state = own_folder(self), own_folder(self)
        self.store = os.path.join(self.folder, "plumb-retain.retained")
        self.id = self.write("machine-id", "0123456789abcdef0123456789abcdef\n")

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            file.write(text)
        return path

    def text(self):
        with open(self.store) as file:
            return file.read()

    def other_computer(self):
        self.write("machine-id", "fedcba9876543210fedcba9876543210\n")

    def counter(self):
        (path,) = glob.glob(os.path.join(self.state, "plumb", "retain", "*[0-9a-f]"))
        return path

    def start(self, work):
        """A LinuxCNC with plumb-retain, from its start to its end."""
        with Machine(self.folder) as machine:
            machine.retain(self.SETTINGS, environment="XDG_STATE_HOME=%s PLUMB_MACHINE_ID=%s" % (self.state, self.id))
            machine.until(lambda: machine.get("plumb-retain.restored") or machine.get("plumb-retain.fault"), "the end of the start")
            found = work(machine)
            machine.unload()
        return found

    def keep(self, value):
        def work(machine):
            self.assertTrue(machine.get("plumb-retain.restored"), machine.said())
            machine.host.set("it.in", value)
            machine.await_saved("it.in", repr(value))

        self.start(work)

    def found(self):
        """The fault and the value after a start."""
        return self.start(lambda machine: (machine.get("plumb-retain.fault-code"), machine.get("it.in")))

    def asked(self, answer="", value=None):
        """The fault, and the value before and after an answer. Without an answer nothing is restored and nothing saved."""
        def work(machine):
            before = self.text()
            if value is not None:
                machine.host.set("it.in", value)
            machine.go(3 * EVERY)
            self.assertEqual((machine.get("plumb-retain.restored"), self.text()), (False, before))
            found = [machine.get("plumb-retain.fault-code"), machine.get("it.in")]
            if answer:
                machine.host.set("plumb-retain." + answer, True)
                machine.await_pin("plumb-retain.restored")
                machine.until(lambda: self.text() != before, "a write")
                found.append(machine.get("it.in"))
            return found

        return self.start(work)

    def test_a_restart_asks_nothing(self):
        for value in (7.5, 2.5, 3.5):
            self.keep(value)
            self.assertEqual(self.found(), (0, value))

    def test_a_store_on_another_computer_waits_for_an_answer(self):
        self.keep(7.5)
        self.other_computer()  # to which the home was copied, too
        self.assertEqual(self.asked(), [COMPUTER, FRESH])
        self.assertEqual(self.asked("accept"), [COMPUTER, FRESH, 7.5])
        self.assertEqual(self.found(), (0, 7.5))

    def test_the_other_answer_keeps_the_present_values(self):
        self.keep(7.5)
        self.other_computer()
        self.assertEqual(self.asked("renew", 4.5), [COMPUTER, 4.5, 4.5])
        self.assertEqual(self.found(), (0, 4.5))

    def test_the_copy_of_yesterday_waits_for_an_answer(self):
        self.keep(7.5)
        copy = self.text()
        self.keep(2.5)
        self.write("plumb-retain.retained", copy)
        self.assertEqual(self.asked(), [OLDER, FRESH])
        self.assertEqual(self.asked("accept"), [OLDER, FRESH, 7.5])
        self.assertEqual(self.found(), (0, 7.5))

    def test_a_store_that_this_user_never_wrote_waits_for_an_answer(self):
        self.keep(7.5)
        self.state = own_folder(self)
        self.assertEqual(self.asked(), [OLDER, FRESH])

    def test_the_first_write_of_another_user_is_no_crash(self):
        self.start(lambda machine: machine.await_saved("it.in", repr(FRESH)))
        self.assertIn("count = 1 ", self.text())
        self.state = own_folder(self)
        self.assertEqual(self.found()[0], OLDER)

    def test_without_a_machine_id_each_start_asks(self):
        self.write("machine-id", "")
        self.keep(7.5)
        for _ in range(2):
            self.assertEqual(self.asked("accept"), [NAMELESS, FRESH, 7.5])

    def test_a_store_from_before_it_was_bound_waits_for_an_answer(self):
        self.write("plumb-retain.retained", checksummed('machine = "bench"\n\n[pins]\n"it.in" = 7.5\n\n[records]\n'))
        self.assertEqual(self.asked("accept"), [UNNAMED, FRESH, 7.5])
        self.assertEqual(self.found(), (0, 7.5))

    def test_a_crash_between_the_store_and_its_counter_asks_nothing(self):
        self.keep(7.5)
        with open(self.counter()) as file:
            count = int(file.read())
        self.assertIn("count = %d " % count, self.text())
        for before, fault in ((1, 0), (2, OLDER)):
            with open(self.counter(), "w") as file:
                file.write("%d\n" % (count - before))
            self.assertEqual(self.found()[0], fault)

    def test_the_store_is_at_most_one_write_ahead_of_its_counter(self):
        self.keep(7.5)

        def work(machine):
            counter = self.counter()
            os.rename(counter, counter + ".away")
            os.mkdir(counter)
            machine.host.set("it.in", 2.5)
            machine.await_pin("plumb-retain.fault-code", INACCESSIBLE)
            machine.await_saved("it.in", "2.5")
            before = self.text()
            machine.host.set("it.in", 3.5)
            machine.go(3)
            self.assertEqual(self.text(), before)
            os.rmdir(counter)
            os.rename(counter + ".away", counter)
            machine.await_saved("it.in", "3.5")
            machine.await_pin("plumb-retain.fault", False)

        self.start(work)
        self.assertEqual(self.found(), (0, 3.5))


class Kill(unittest.TestCase):
    """kill -9 at any moment."""

    INSTANCES = 5  # more of them mostly wait for HAL's lock

    def test_loses_at_most_the_last_change(self):
        draw = random.Random(1)
        folder = own_folder(self)
        names = ["it%d" % i for i in range(self.INSTANCES)]
        left = {name: (0, 0) for name in names}  # the last values in the store, and numbers of records
        value = 0
        for _ in range(math.ceil(kills / self.INSTANCES)):
            with Machine(folder, load="loadrt specimen names=" + ",".join(names)) as machine:
                for name in names:
                    pins = ", ".join('"%s.%s"' % (name, pin) for pin in ("in", "order", "call-system", "renumber"))
                    toml = 'machine = "%s"\npins = [%s]\nrecords = ["%s"]\nevery = 0.02\n' % (name, pins, name)
                    machine.retain(toml, "r" + name, wait=False)
                for name in names:
                    machine.until(lambda: self.is_restored(machine, name), "r%s.restored" % name)
                    if left[name] != (0, 0):
                        self.assertEqual((machine.get(name + ".in"), machine.get(name + ".rows")), left[name])
                running = processes()
                alive_yet = {name: running["%s/r%s.toml" % (folder, name)] for name in names}
                before_round = {name: left[name][0] for name in names}
                safe = dict(before_round)
                written = {name: [] for name in names}  # values, and how many saves there had been before
                while alive_yet:
                    value += 1
                    changed = draw.sample(sorted(alive_yet), min(4, len(alive_yet)))
                    for name in changed:
                        machine.host.set(name + ".in", value)
                    # From now on, the second save begins when the value is there.
                    saves = machine.host.get(["r%s.saves" % name for name in changed])
                    for name, now in zip(changed, saves):
                        safe[name] = max([safe[name]] + [old for old, before in written[name] if now >= before + 2])
                        written[name].append((value, now))
                    name = draw.choice(changed)
                    machine.host.set(name + ".forget", machine.get(name + ".rows") == 3)
                    machine.give((value, value), to=name)
                    time.sleep(0.02 * draw.random())
                    name = draw.choice(changed)
                    if safe[name] == before_round[name]:
                        continue  # nothing of this round has to be there yet
                    kill(alive_yet.pop(name))
                    await_lock("%s/r%s.retained" % (folder, name))
                    pins, records = contents("%s/r%s.retained" % (folder, name))
                    left[name] = (float(pins[name + ".in"]), len(records))
                    self.assertGreaterEqual(left[name][0], safe[name])

    def is_restored(self, machine, name):
        try:
            return machine.get("r%s.restored" % name)
        except plumb.Refused:
            return False


    @unittest.skipIf(os.environ.get("PLUMB_SANITIZE"), "a sanitizer wants to be the first that is preloaded")
    def test_at_each_step_of_its_writing_leaves_the_old_store_or_the_new_one(self):
        self.assertEqual(self.steps_of_a_write(), 11)  # one more than there are

    @unittest.skipIf(os.environ.get("PLUMB_SANITIZE"), "a sanitizer wants to be the first that is preloaded")
    def test_at_each_step_of_writing_a_bound_store_and_its_counter_asks_nothing(self):
        folder = own_folder(self)
        machine_id = os.path.join(folder, "machine-id")
        with open(machine_id, "w") as file:
            file.write("0123456789abcdef0123456789abcdef\n")
        with mock.patch.dict(os.environ, {"XDG_STATE_HOME": folder, "PLUMB_MACHINE_ID": machine_id}):  # for the host's programs
            self.assertGreater(self.steps_of_a_write("bound = true\n"), 18)

    def steps_of_a_write(self, more=""):
        folder = own_folder(self)
        store = os.path.join(folder, "r.retained")
        kept = None
        ends = set()
        toml = SETTINGS + more + 'store = "%s"\n' % store
        with Machine(folder) as machine:
            machine.give((1, 1))
            if more:  # the first write has no counter yet
                machine.host.set("it.in", 0)
                machine.retain(toml, "r0")
                machine.until(lambda: machine.get("r0.saves") == 1, "the first write")
                machine.unload("r0")
                kept = 0
            for steps in range(1, 100):
                name = "r%d" % steps
                machine.host.set("it.in", 0)
                loaded = os.path.join(folder, name + ".loaded")  # before that halcmd has not seen that it is ready
                preload = "LD_PRELOAD=%s/specimens/kill_at.so KILL_AT=%d KILL_AFTER=%s" % (BUILD, steps, loaded)
                machine.retain(toml, name, environment=preload)
                process = processes()[os.path.join(folder, name + ".toml")]
                open(loaded, "x").close()
                saved = lambda: machine.get(name + ".saves") == 1
                if kept is not None:  # a counter that lacks the last write is written at once
                    machine.until(lambda: machine.get(name + ".restored") or (more and not alive(process)), name + ".restored")
                    self.assertEqual(machine.get("it.in"), kept)
                    machine.host.set("it.in", steps)
                machine.until(lambda: not alive(process) or saved(), "the end of " + name)
                if alive(process):
                    kill(process)
                    break
                await_lock(store)
                found = float(contents(store)[0]["it.in"]) if os.path.exists(store) else None
                self.assertIn(found, (kept, steps) if kept is not None else (None, 0))
                ends.add(found == kept)
                kept = found
        self.assertEqual(ends, {True, False})
        return steps


if __name__ == "__main__":
    if "--kills" in sys.argv:
        at = sys.argv.index("--kills")
        kills = int(sys.argv[at + 1])
        del sys.argv[at : at + 2]
    unittest.main()

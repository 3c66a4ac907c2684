#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The standing halcmd gives each command the status and the output that a separate halcmd gives."""

import os
import re
import signal
import time
import unittest

import plumb

# What HAL holds is the same for both hosts; a command that fails leaves nothing behind.
COMMANDS = """
    net command and.out => not.in
    net command <= and.out
    net other and.out
    net third no.such.pin
    newsig free float
    newsig free float
    newsig wrong colour
    sets free 2.5
    sets free nonsense
    sets no-such-signal 1
    sets command 1
    gets free
    gets no-such-signal
    stype free
    stype command
    setp filter.gain -0.25
    setp filter.gain 1e400
    setp filter.gain
    setp filter.gain 1 2
    setp filter.gain nan
    setp and.out 1
    setp no.such.pin 1
    getp filter.gain
    getp no.such.pin
    ptype filter.gain
    ptype no.such.pin
    linksp free filter.in
    linksp free filter.gain
    linkps filter.out filtered
    linkpp filter.load and.in0
    unlinkp filter.in
    unlinkp no.such.pin
    alias pin filter.gain tuned
    alias pin no.such.pin tuned
    getp tuned
    unalias pin tuned
    delsig free
    delsig free
    addf filter t
    addf filter t
    addf nothing t
    delf filter t
    delf filter t
    addf filter t 1
    start
    stop
    lock tune
    setp filter.gain 1
    unlock all
    status lock
    show pin
    show pin filter not.in
    show sig command
    show param
    show funct
    show thread
    show nonsense
    list pin
    list sig f*
    list nonsense
    list
    frobnicate
    filter.gain = 0.5
    getp filter.gain
    getp filter.gain#comment
    setp filter.gain $HOME
    print hello
    quit
    help getp
    loadrt no_such_module
    loadrt xor2 nonsense=1
    loadrt xor2 names=extra
    getp extra.in0
""".strip().splitlines()


class StandingHalcmd(unittest.TestCase):
    def setUp(self):
        self.host = self.new_host()

    def new_host(self):
        host = plumb.Host()
        self.addCleanup(host.close)
        for line in ("threads name1=t period1=1000000", "lowpass names=filter", "and2 names=and", "not names=not"):
            host.command("loadrt " + line)
        return host

    def halcmds_now(self):
        """The processes of halcmd that the host has started, as this computer counts."""
        with open("/proc/%d/task/%d/children" % (self.host.process, self.host.process), encoding="utf-8") as file:
            return [int(word) for word in file.read().split() if self.name(int(word)) == "halcmd"]

    def standing(self):
        self.host.command("getp filter.gain")
        return self.halcmds_now()

    def await_none(self):
        end = time.monotonic() + 20
        while self.halcmds_now() and time.monotonic() < end:
            time.sleep(0.01)
        self.assertEqual(self.halcmds_now(), [])

    @staticmethod
    def name(process):
        try:
            with open("/proc/%d/comm" % process, encoding="utf-8") as file:
                return file.read().strip()
        except OSError:
            return ""

    @staticmethod
    def comparable(output):
        """Running times of threads and addresses of code and memory differ from run to run."""
        return re.sub(r"\( *\d+, +\d+ \)|\b[0-9a-f]{12}\b", "-", output)

    def test_every_command_has_the_status_and_the_output_that_its_own_halcmd_has(self):
        other = self.new_host()
        for line in COMMANDS:
            words = line.split()
            alone = other.halcmd("-q", *words)  # an option makes it one of its own
            together = self.host.halcmd(*words)
            with self.subTest(line.strip()):
                self.assertEqual(together.status, alone.status)
                self.assertEqual(self.comparable(together.output), self.comparable(alone.output))

    def test_one_process_takes_many_commands_until_one_fails(self):
        processes = set()
        for _ in range(50):
            processes.update(self.standing())
        self.assertLess(len(processes), 25)  # a pause of the computer can end it
        before = self.standing()
        self.assertEqual(self.host.halcmd("getp", "nothing").status, 1)
        self.assertNotEqual(self.standing(), before)

    def test_nobody_sees_it_beside_another(self):
        for words in (("show", "comp"), ("-s", "show", "comp")):
            self.standing()
            shown = self.host.halcmd(*words).output
            self.assertEqual(len(re.findall(r"halcmd\d+", shown)), 1, shown)

    def test_it_ends_soon_after_the_last_command(self):
        self.standing()
        self.await_none()

    def test_after_its_death_commands_go_on(self):
        for number in (signal.SIGTERM, signal.SIGKILL):
            for process in self.standing():
                os.kill(process, number)
            self.await_none()
            self.host.command("setp filter.gain 0.5")
            self.assertEqual(self.host.get("filter.gain"), 0.5)

    def test_many_lines_of_output_arrive_whole_and_in_order(self):
        self.host.command("loadrt mux_generic config=" + ",".join(["ff16"] * 60))
        pins = self.host.halcmd("list", "pin").output.split()
        self.assertGreater(sum(map(len, pins)), 20000)
        for _ in range(3):
            shown = self.host.halcmd("show", "pin").output
            names = [line.split()[4] for line in shown.splitlines()[2:] if line]
            self.assertEqual(names, pins)

    def test_memory_of_hal_is_new_once_all_modules_are_gone(self):
        self.host.command("newsig left float")
        self.host.command("unloadrt all")
        self.host.command("loadrt and2 names=and")
        self.assertNotEqual(self.host.halcmd("gets", "left").status, 0)
        self.assertEqual(self.host.halcmd("getp", "and.in0").status, 0)


if __name__ == "__main__":
    unittest.main()

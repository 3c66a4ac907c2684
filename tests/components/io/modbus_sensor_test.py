# SPDX-License-Identifier: GPL-2.0-or-later
"""modbus_sensor, the real program, beside real peers: servers by pymodbus, over TCP and through socat, and mbpoll."""

import contextlib
import glob
import os
import re
import socket
import subprocess
import time
import unittest

import plumb
from tree import BUILD, ROOT, own_folder

SENSOR = os.path.join(BUILD, "bin", "modbus_sensor")
SERVER = os.path.join(ROOT, "tests", "programs", "modbus_server.py")
PATIENCE = 30  # s

DISCONNECTED, REFUSED, COMMAND, DISABLED = 2, 5, 9, 10  # codes of a channel

CHANNELS = """
timeout = 0.5
retry = 0.5
retry-max = 0.5

[[link.channel]]
name = "cold"
table = "holding"
register = 0
type = "s16"
unit = "degC"

[[link.channel]]
name = "clock"
table = "holding"
register = 1
type = "u32"
scale = 0.001
unit = "s"

[[link.channel]]
name = "float"
table = "holding"
register = 3
type = "f32"
words = "low-first"
unit = "1"

[[link.channel]]
name = "field"
table = "holding"
register = 5
first-bit = 8
bits = 3
unit = "1"

[[link.channel]]
name = "coil"
table = "coil"
bit = 3

[[link.channel]]
name = "door"
table = "discrete"
bit = 5

[[link.channel]]
name = "room"
table = "input"
register = 2
scale = 0.1
unit = "degC"

[[link.channel]]
name = "far"
device = 7
table = "holding"
register = 0
type = "s16"
unit = "degC"
"""

MORE = """
[[link.channel]]
name = "missing"
table = "holding"
register = 500
unit = "1"

[[link.output]]
name = "fan"
register = 6
scale = 0.1
unit = "%"
min = 0
max = 100

[[link.output]]
name = "lamp"
table = "coil"
bit = 1
"""

VALUES = {"cold": -15, "float": 3.5, "field": 3, "coil": True, "door": True, "room": 23.5, "far": -40}


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Sensor(unittest.TestCase):
    def setUp(self):
        self.folder = own_folder(self)

    def start(self, words, ready):
        """A program that the test ends; ready() is true once it does its work."""
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL)
        self.addCleanup(self.end, process)
        self.until(ready, words[0])
        return process

    @staticmethod
    def end(process):
        process.kill()
        process.wait()

    @staticmethod
    def until(condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(what + " did not come")
            time.sleep(0.01)

    def tcp_server(self, port):
        def answers():
            with contextlib.suppress(OSError):
                socket.create_connection(("127.0.0.1", port), 1).close()
                return True

        return self.start(["/usr/bin/python3", SERVER, "tcp", str(port)], answers)

    def file(self, text):
        path = os.path.join(self.folder, "sensors.toml")
        with open(path, "w") as file:
            file.write(text)
        return path

    def load(self, text):
        """A host with the sensor; returns when it is ready, which it is before it connects."""
        self.host = plumb.Host()
        self.addCleanup(self.host.close)
        self.host.command("loadusr -W %s --file %s" % (SENSOR, self.file(text)))

    def get(self, pin):
        return self.host.get("modbus-sensor." + pin)

    def await_pin(self, pin, value=True):
        self.until(lambda: self.get(pin) == value, "%s = %s" % (pin, value))

    def await_values(self):
        for name, value in VALUES.items():
            self.await_pin(name + ".valid")
            self.assertEqual(self.get(name + ".value"), value, name)
            self.assertEqual(self.get(name + ".fault-code"), 0, name)

    def unload(self):
        began = time.monotonic()
        self.host.command("unloadusr modbus_sensor")
        self.until(lambda: not self.host.programs(), "the end")
        self.assertLess(time.monotonic() - began, 1.5)  # 1 s, on a busy computer

    def test_over_tcp_it_reads_writes_and_recovers(self):
        port = free_port()
        self.load('[[link]]\nname = "plc"\ntcp = "localhost:%d"\n' % port + CHANNELS + MORE)
        self.await_pin("cold.fault-code", DISCONNECTED)  # nobody listens yet
        self.assertFalse(self.get("cold.valid"))
        server = self.tcp_server(port)
        self.await_values()
        self.assertTrue(self.get("plc.connected"))
        self.await_pin("missing.fault-code", REFUSED)
        self.assertFalse(self.get("missing.valid"))
        self.assertEqual(self.get("fan.fault-code"), DISABLED)

        # Values follow the device, and none is older than it claims.
        for _ in range(20):
            clock, age = self.host.get(["modbus-sensor.clock.value", "modbus-sensor.clock.age"])
            self.assertLess(time.monotonic() - clock, age + 1)
            time.sleep(0.01)

        # An output is written while it is enabled, and never beyond its bounds.
        self.host.set("modbus-sensor.fan.command", 42.5)
        self.host.set("modbus-sensor.lamp.command", True)
        self.host.set("modbus-sensor.fan.enable", True)
        self.host.set("modbus-sensor.lamp.enable", True)
        self.await_pin("fan.valid")
        self.await_pin("lamp.valid")
        self.assertEqual(self.get("fan.value"), 42.5)
        poll = ["mbpoll", "-m", "tcp", "-p", str(port), "-a", "1", "-0", "-1", "-q"]
        self.assertRegex(subprocess.check_output([*poll, "-r", "6", "-t", "4", "127.0.0.1"], text=True), r"\[6\]:\s+425\b")
        self.assertRegex(subprocess.check_output([*poll, "-r", "1", "-t", "0", "127.0.0.1"], text=True), r"\[1\]:\s+1\b")
        self.host.set("modbus-sensor.fan.command", 101)
        self.await_pin("fan.fault-code", COMMAND)
        self.assertFalse(self.get("fan.valid"))
        self.assertRegex(subprocess.check_output([*poll, "-r", "6", "-t", "4", "127.0.0.1"], text=True), r"\[6\]:\s+425\b")

        # The server dies and comes back, and nothing is loaded again.
        self.end(server)
        for name in ("cold", "coil", "far"):
            self.await_pin(name + ".valid", False)
        self.assertEqual(self.get("cold.value"), -15)
        self.assertFalse(self.get("plc.connected"))
        beat = self.get("plc.heartbeat")
        self.until(lambda: self.get("plc.heartbeat") != beat, "the heartbeat")
        self.tcp_server(port)
        self.await_values()
        self.unload()

    def line(self):
        ends = [os.path.join(self.folder, end) for end in "ab"]
        socat = self.start(
            ["socat", *("pty,raw,echo=0,link=" + end for end in ends)], lambda: all(os.path.exists(end) for end in ends)
        )
        server = self.start(["/usr/bin/python3", SERVER, "rtu", ends[1]], lambda: True)
        return socat, server

    def test_over_a_serial_line_it_reads_and_survives_its_unplugging(self):
        device = os.path.join(self.folder, "a")
        self.load('[[link]]\nname = "bus"\nrtu = "%s"\nparity = "none"\n' % device + CHANNELS)
        self.await_pin("cold.fault-code", DISCONNECTED)
        socat, server = self.line()
        self.await_values()
        self.end(socat)  # the adapter is unplugged
        self.end(server)
        self.await_pin("cold.valid", False)
        self.await_pin("bus.connected", False)
        self.line()
        self.await_values()
        self.unload()

    def test_it_ends_in_time_while_a_device_keeps_silent(self):
        listener = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(listener.close)
        text = '[[link]]\nname = "plc"\ntcp = "127.0.0.1:%d"\ntimeout = 10\n' % listener.getsockname()[1]
        self.load(text + CHANNELS.split("\n\n", 1)[1])
        connection, _ = listener.accept()
        self.addCleanup(connection.close)
        self.assertTrue(connection.recv(12))
        self.unload()

    def test_list_prints_the_values_without_hal(self):
        port = free_port()
        file = self.file('[[link]]\nname = "plc"\ntcp = "127.0.0.1:%d"\n' % port + CHANNELS)
        gone = subprocess.run([SENSOR, "--list", file], capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(gone.returncode, 1)
        self.assertRegex(gone.stdout, r"plc +cold +- +degC +no +\S+ s +The link is not connected")
        self.assertIn("plc: 127.0.0.1:%d: Connection refused" % port, gone.stderr)
        self.tcp_server(port)
        done = subprocess.run([SENSOR, "--list", file], capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertRegex(done.stdout, r"plc +cold +-15 +degC +yes +\S+ s +-\n")
        self.assertRegex(done.stdout, r"plc +coil +1 +bit +yes")

    def test_check_shows_the_requests_or_the_error(self):
        file = self.file('[[link]]\nname = "plc"\ntcp = "plc.local"\n' + CHANNELS + MORE)
        done = subprocess.run([SENSOR, "--check", file], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"plc, plc.local:502:\n")
        self.assertRegex(done.stdout, r"1 +3 +0 +6 +0.1 s +cold clock float field\n")
        self.assertRegex(done.stdout, r"1 +6 +6 +1 +0.1 s +fan \(written\)\n")
        wrong = subprocess.run([SENSOR, "--check", self.file("[[link]]\nnam = 1\n")], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 1)
        self.assertIn(file + ":1: name is missing", wrong.stderr)

    def test_every_shipped_file_and_that_of_the_page_is_right(self):
        files = glob.glob(os.path.join(ROOT, "configs", "*", "**", "*modbus.toml"), recursive=True)
        page = subprocess.run([SENSOR, "--man"], capture_output=True, text=True, check=True).stdout.replace("\\-", "-")
        example = re.search(r"^ +\[\[link\]\].*?(?=^\.EE)", page, re.M | re.S)[0]
        for file in [*files, self.file(example)]:
            done = subprocess.run([SENSOR, "--check", file], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()

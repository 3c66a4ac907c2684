# SPDX-License-Identifier: GPL-2.0-or-later
"""can_sensor, the real program, on a bus; its values are compared with those of canmatrix.

Where this kernel has no SocketCAN, the tests run under another one: tests/support/can_vm.
"""

import glob
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import unittest
import unittest.mock

import plumb
from tree import BUILD, ROOT, own_folder

SENSOR = os.path.join(BUILD, "bin", "can_sensor")
CONVERTER = os.path.join(BUILD, "bin", "can_sensor_dbc")
DBC = os.path.join(ROOT, "tests", "programs", "machine.dbc")
BUS = "PLUMB_TEST_HAS_A_BUS"
PATIENCE = 20  # s

DISCONNECTED, DAMAGED, REFUSED, OLD = 2, 4, 5, 6  # codes of a channel
MISSING, DOWN, BUS_OFF, ERRORS = 2, 3, 4, 5  # codes of a link

EXTENDED, ERROR = socket.CAN_EFF_FLAG, socket.CAN_ERR_FLAG
ERR_BUSOFF, ERR_CRTL, ERR_RESTARTED = 0x40, 0x04, 0x100


def ip(*words):
    subprocess.run(["ip", *words], check=True)


class Files(unittest.TestCase):
    """These need no bus."""

    def setUp(self):
        self.folder = own_folder(self)

    def check(self, text):
        path = os.path.join(self.folder, "bus.toml")
        with open(path, "w") as file:
            file.write(text)
        return subprocess.run([SENSOR, "--check", path], capture_output=True, text=True)

    def convert(self, *words):
        return subprocess.run([CONVERTER, DBC, *words], capture_output=True, text=True)

    def test_every_shipped_file_and_that_of_the_page_is_right(self):
        page = subprocess.run([SENSOR, "--man"], capture_output=True, text=True, check=True).stdout.replace("\\-", "-")
        texts = [re.search(r"^ +\[\[link\]\].*?(?=^\.EE)", page, re.M | re.S)[0]]
        for path in glob.glob(os.path.join(ROOT, "configs", "*", "**", "*can.toml"), recursive=True):
            with open(path) as file:
                texts.append(file.read())
        for text in texts:
            done = self.check(text)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_dbc_file_becomes_a_file_of_can_sensor(self):
        done = self.convert("SpindleTorque=load", "Temperatures.ZoneOne", "Odd", "Skew", "Flow", "--interface", "can1", "--link", "x")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        checked = self.check(done.stdout)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("x, can1, listens only:", checked.stdout)
        self.assertRegex(checked.stdout, r"load +0x181 +16\+16 +intel +%\n")
        self.assertRegex(checked.stdout, r"odd +0x18FECA15 extended +13\+11 +motorola +bar\n")
        self.assertIn("max-age = 0.03\n", done.stdout)

    def test_files_of_other_editors(self):
        """Code page 1252, ranges beyond whole numbers, J1939 without a sender, ranges of a multiplexer, a line that is none."""
        head = 'VERSION ""\nBS_:\nBU_: X\n'
        temperature = 'BO_ 256 D: 8 X\n SG_ T : 0|8@1+ (1,-40) [-40|215] "%s" X\n'
        current = 'BO_ 256 D: 8 X\n SG_ T : 0|%d@1%s (1,0) [%s] "A" X\n%s'
        j1939 = 'BO_ 2364540158 D: 8 X\n SG_ T : 24|16@1+ (0.125,0) [0|8031] "rpm" X\nBA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","J1939PG";\n'
        multiplexed = 'BO_ 256 D: 8 X\n SG_ M M : 0|8@1+ (1,0) [0|0] "" X\n SG_ T m1 : 8|8@1+ (1,0) [0|0] "" X\nSG_MUL_VAL_ 256 T M %s;\n'
        for text, expected in (
            (temperature % "\N{DEGREE SIGN}C", 'unit = "degC"'),
            (temperature % "degC" + 'CM_ SG_ 256 T "K\N{LATIN SMALL LETTER U WITH DIAERESIS}hlung";\n', 'unit = "degC"'),
            (current % (32, "-", "-3.4E+038|3.4E+038", "SIG_VALTYPE_ 256 T : 1;\n"), "min = -3.4e+38\nmax = 3.4e+38\n"),
            (current % (64, "+", "0|1.84467440737096E+019", ""), "min = 0\nmax = 1.84467440737096e+19\n"),
            (current % (64, "-", "-9.22337203685478E+018|9.2E+018", ""), "min = -9.22337203685478e+18\nmax = 9.2e+18\n"),
            (j1939 + 'BA_DEF_DEF_ "VFrameFormat" "J1939PG";\n', "\npgn = 61444\nstart-bit"),
            (j1939 + 'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";\nBA_ "VFrameFormat" BO_ 2364540158 1;\n', "\npgn = 61444\nstart-bit"),
            (j1939.replace("540158", "539904") + 'BA_DEF_DEF_ "VFrameFormat" "J1939PG";\n', "\nid = 0x0CF00400\nextended = true\n"),
            (multiplexed % "1-1", "value = 1 }"),
            (multiplexed % "0-3", "value = 0, to = 3 }"),
        ):
            path = os.path.join(self.folder, "its.dbc")
            with open(path, "w", encoding="cp1252") as file:
                file.write(head + text)
            done = subprocess.run([CONVERTER, path, "T"], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), text)
            self.assertIn(expected, done.stdout)
            checked = self.check(done.stdout)
            self.assertEqual(checked.returncode, 0, checked.stderr)
        with open(path, "w") as file:
            file.write(head + multiplexed % "0-3, 5-7")
        done = subprocess.run([CONVERTER, path, "T"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("D.T has 2 ranges of its multiplexer, and can_sensor reads one", done.stderr)
        with open(path, "w") as file:
            file.write(head + temperature % "degC" + "EV_ nothing;\n")
        done = subprocess.run([CONVERTER, path, "T"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, "can_sensor_dbc: %s:6 is not read\n" % path))

    def test_the_converter_names_what_is_wrong(self):
        self.assertIn("there is no signal Spindle;", self.convert("Spindle").stderr)
        self.assertIn("write SIGNAL=name", self.convert("SpindleTorque=Load").stderr)
        self.assertIn("is there twice", self.convert("Odd=a", "Skew=a").stderr)
        wrong = subprocess.run([CONVERTER, __file__, "X"], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 1)
        self.assertRegex(wrong.stderr, r"^can_sensor_dbc: .*no DBC file.*\n$")
        self.assertIn("Torque.SpindleTorque %\n", self.convert("--list").stdout)
        with open("/dev/full", "w") as full:
            for words in (["--list"], ["Odd"]):
                done = subprocess.run([CONVERTER, DBC, *words], stdout=full, stderr=subprocess.PIPE, text=True)
                self.assertEqual((done.returncode, done.stderr), (1, "can_sensor_dbc: standard output: No space left on device\n"))


class Bus(unittest.TestCase):
    """On vcan0."""

    def setUp(self):
        self.folder = own_folder(self)
        self.socket = self.listener()

    def listener(self):
        opened = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.addCleanup(opened.close)
        opened.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
        opened.bind(("vcan0",))
        return opened

    def send(self, identity, data, flexible=False):
        self.socket.send(struct.pack("=IB3x%ds" % (64 if flexible else 8), identity, len(data), data))

    def file(self, text, head='interface = "vcan0"'):
        path = os.path.join(self.folder, "bus.toml")
        with open(path, "w") as file:
            file.write(text if text.startswith("[[link]]") else '[[link]]\nname = "bus"\n%s\n%s' % (head, text))
        return path

    def load(self, *arguments):
        self.host = plumb.Host(namespaces=False)
        self.addCleanup(self.host.close)
        self.host.command("loadusr -W %s --file %s" % (SENSOR, self.file(*arguments)))

    def get(self, pin):
        return self.host.get("can-sensor." + pin)

    def await_pin(self, pin, value=True, between=lambda: None):
        end = time.monotonic() + PATIENCE
        while self.get(pin) != value:
            self.assertLess(time.monotonic(), end, "%s = %s did not come" % (pin, value))
            between()
            time.sleep(0.005)

    SPEED = '[[link.channel]]\nname = "speed"\nid = 0x201\nstart-bit = 0\nunit = "rpm"\nmax-age = 0.3\n'

    def test_values_are_those_of_canmatrix(self):
        import logging

        logging.disable(logging.CRITICAL)
        import canmatrix.formats

        with open(DBC, "rb") as file:
            matrix = canmatrix.formats.load_flat(file, "dbc")
        signals = {"SpindleTorque": "spindle-torque", "ZoneOne": "zone-one", "ZoneTwo": "zone-two", "Odd": "odd", "Skew": "skew", "Flow": "flow", "Last": "last"}
        words = subprocess.run([CONVERTER, DBC, *signals, "--interface", "vcan0"], capture_output=True, text=True, check=True)
        self.load(re.sub("(?m)^(min|max) = .*\n", "", words.stdout))
        draw = random.Random(5)
        seen = dict.fromkeys(signals, 0)
        for _ in range(40):
            frame = draw.choice(matrix.frames)
            data = bytes(draw.randrange(256) for _ in range(8))
            if frame.name == "Temperatures":
                data = bytes([draw.randrange(4)]) + data[1:]
            elif frame.name == "Float":
                data = struct.pack("<f", draw.uniform(-1e6, 1e6)) + data[4:]
            values = {name: float(value.phys_value) for name, value in frame.decode(data).items() if name in signals}
            count = self.get("bus.frame-count")
            self.send(frame.arbitration_id.id | (EXTENDED if frame.arbitration_id.extended else 0), data)
            self.await_pin("bus.frame-count", count + 1)
            for name, value in values.items():
                seen[name] += 1
                self.assertAlmostEqual(self.get(signals[name] + ".value"), value, delta=1e-6 * max(1, abs(value)), msg=name)
        self.assertTrue(all(seen.values()), seen)

    def test_a_value_is_valid_while_right_frames_come(self):
        self.load(self.SPEED)
        self.await_pin("bus.connected")
        self.assertFalse(self.get("speed.valid"))
        self.await_pin("speed.valid", between=lambda: self.send(0x201, b"\x10\x27"))
        self.assertEqual(self.get("speed.value"), 10000)
        # Frames that are not the signal's: of other lengths of id, remote, too short.
        for identity, data in ((0x201 | EXTENDED, b"\1\0"), (0x201 | socket.CAN_RTR_FLAG, b"\1\0"), (0x202, b"\1\0")):
            self.send(identity, data)
        self.await_pin("speed.fault-code", DAMAGED, between=lambda: self.send(0x201, b"\1"))
        self.assertEqual(self.get("speed.value"), 10000)
        self.await_pin("speed.valid", False)
        self.await_pin("speed.valid", between=lambda: self.send(0x201, b"\1\0\0\0"))
        self.assertEqual(self.get("speed.value"), 1)
        self.await_pin("speed.fault-code", OLD)
        self.assertFalse(self.get("speed.valid"))

    def test_a_frame_that_waited_for_the_program_is_old(self):
        self.load(self.SPEED)
        self.await_pin("speed.valid", between=lambda: self.send(0x201, b"\1\0"))
        process = int(subprocess.check_output(["pgrep", "-f", "can_sensor --file " + self.folder]))
        os.kill(process, signal.SIGSTOP)
        self.send(0x201, b"\2\0")
        time.sleep(0.5)
        os.kill(process, signal.SIGCONT)
        self.await_pin("speed.value", 2)
        self.assertGreater(self.get("speed.age"), 0.4)
        self.assertFalse(self.get("speed.valid"))

    def test_a_flexible_frame_has_64_bytes(self):
        self.load('[[link.channel]]\nname = "last"\nid = 0x301\nstart-bit = 496\nlength = 16\nunit = "1"\n')
        self.await_pin("last.valid", between=lambda: self.send(0x301, bytes(62) + b"\x34\x12", flexible=True))
        self.assertEqual(self.get("last.value"), 0x1234)

    def test_errors_on_the_bus_are_shown(self):
        self.load(self.SPEED)
        self.await_pin("bus.connected")
        self.await_pin("bus.fault-code", ERRORS, between=lambda: self.send(ERROR | ERR_CRTL, bytes(8)))
        self.await_pin("bus.fault-code", 0)
        self.send(ERROR | ERR_BUSOFF, bytes(8))
        self.await_pin("bus.fault-code", BUS_OFF)
        self.assertFalse(self.get("bus.connected"))
        self.assertEqual(self.get("speed.fault-code"), DISCONNECTED)
        self.send(ERROR | ERR_RESTARTED, bytes(8))
        self.await_pin("bus.connected")
        self.send(ERROR | ERR_BUSOFF, bytes(8))
        self.await_pin("bus.connected", False)
        self.await_pin("bus.connected", between=lambda: self.send(0x201, b"\1\0"))

    def test_the_interface_may_be_missing_go_down_and_be_removed(self):
        ip("link", "del", "vcan0")
        self.addCleanup(lambda: subprocess.run("ip link add vcan0 type vcan; ip link set vcan0 mtu 72 up", shell=True, stderr=subprocess.DEVNULL))
        self.load(self.SPEED)
        self.await_pin("bus.fault-code", MISSING)
        for stage in ("new", "down", "removed"):
            if stage == "down":
                ip("link", "set", "vcan0", "down")
                self.await_pin("bus.fault-code", DOWN)
            elif stage == "removed":
                ip("link", "del", "vcan0")
                self.await_pin("bus.fault-code", MISSING)
            if stage != "new":
                self.assertFalse(self.get("bus.connected"))
                self.await_pin("speed.valid", False)
                self.assertEqual(self.get("speed.value"), 7)
            if stage != "down":
                ip("link", "add", "vcan0", "type", "vcan")
                ip("link", "set", "vcan0", "mtu", "72")
            ip("link", "set", "vcan0", "up")
            self.socket = self.listener()
            self.await_pin("speed.valid", between=lambda: self.send(0x201, b"\7\0"))
            self.await_pin("bus.fault-code", 0)

    def test_it_only_listens_unless_it_may_transmit(self):
        self.load(self.SPEED)
        self.await_pin("speed.valid", between=lambda: self.send(0x201, b"\7\0"))
        self.socket.setblocking(False)
        self.assertRaises(BlockingIOError, self.socket.recv, 72)

    def test_it_starts_nodes_and_asks_for_objects(self):
        """Node 5 sends its torque once it is operational, and has the object 0x2010, but not 0x2011."""
        over, started, asked = threading.Event(), [], []

        def node():
            bus = self.listener()
            bus.settimeout(0.02)

            def send(identity, data):
                bus.send(struct.pack("=IB3x8s", identity, len(data), data))

            while not over.is_set():
                if not started:
                    send(0x705, b"\x7f")
                else:
                    send(0x185, struct.pack("<h", -250))
                try:
                    identity, size, data = struct.unpack("=IB3x8s", bus.recv(72)[:16])
                except TimeoutError:
                    continue
                if identity == 0 and data[:2] == b"\1\5":
                    started.append(True)
                elif identity == 0x605 and size == 8:
                    asked.append(data[1:4])
                    if data[1:3] == b"\x10\x20":
                        send(0x585, b"\x4b" + data[1:4] + struct.pack("<hh", -40, 0))
                    else:
                        send(0x585, b"\x80" + data[1:4] + b"\0\0\2\6")

        thread = threading.Thread(target=node)
        self.load(
            '[[link.channel]]\nname = "torque"\nid = 0x185\nstart-bit = 0\ntype = "signed"\nscale = 0.1\nunit = "%"\n'
            '[[link.channel]]\nname = "heat"\nsdo = { node = 5, index = 0x2010 }\nevery = 0.1\ntype = "signed"\nunit = "degC"\n'
            '[[link.channel]]\nname = "none"\nsdo = { node = 5, index = 0x2011, subindex = 1 }\nevery = 0.1\nunit = "degC"\n',
            'interface = "vcan0"\ntransmit = true\nnmt-start = [5]\ntimeout = 0.1\nretry = 0.1',
        )
        self.await_pin("heat.fault-code", 3)  # no node yet
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)
        self.await_pin("torque.valid")
        self.assertEqual(self.get("torque.value"), -25)
        self.await_pin("heat.valid")
        self.assertEqual(self.get("heat.value"), -40)
        self.await_pin("none.fault-code", REFUSED)
        over.set()
        self.await_pin("heat.valid", False)

    def test_it_works_and_ends_on_a_full_bus(self):
        over = threading.Event()

        def flood():
            bus = self.listener()
            count = 0
            while not over.is_set():
                for _ in range(9):  # 9,000 a second are a full bus at 1 Mbit/s
                    count += 1
                    try:
                        bus.send(struct.pack("=IB3x8s", 0x201 if count % 10 == 0 else 0x100 + count % 0x100, 8, bytes(8)))
                    except OSError:
                        pass
                time.sleep(0.001)

        thread = threading.Thread(target=flood)
        self.load(self.SPEED.replace("0.3", "10"))  # s, in which a busy computer may do nothing
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)
        self.await_pin("speed.valid")
        for _ in range(50):
            self.assertTrue(self.get("speed.valid"))
            time.sleep(0.01)
        began = time.monotonic()
        self.host.command("unloadusr can_sensor")
        while self.host.programs():
            self.assertLess(time.monotonic() - began, 2)  # 1 s, on a busy computer
            time.sleep(0.01)

    def test_the_mill_loses_its_sensors_and_gets_them_back(self):
        """configs/mill/sensors.hal, with a load that comes over CAN and temperatures that come over Modbus."""
        mill = os.path.join(ROOT, "configs", "mill")
        for name in ("sensors_can.toml", "sensors_modbus.toml"):
            with open(os.path.join(mill, name)) as file, open(os.path.join(self.folder, name), "w") as copy:
                copy.write(file.read().replace('"can0"', '"vcan0"'))  # the bus of the tests
        over = threading.Event()
        sending = threading.Event()
        sending.set()

        def drive():
            while not over.wait(0.01):
                if sending.is_set():
                    self.send(0x481, struct.pack("<Hh", 0x27, 423))

        thread = threading.Thread(target=drive)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)
        server = os.path.join(ROOT, "tests", "programs", "modbus_server.py")
        thermometer = subprocess.Popen(["/usr/bin/python3", server, "tcp", "1502"])
        self.addCleanup(thermometer.wait)
        self.addCleanup(thermometer.kill)

        def until(pin, value):
            end = time.monotonic() + PATIENCE
            while self.host.get(pin) != value:
                self.assertLess(time.monotonic(), end, "%s = %s did not come" % (pin, value))
                self.host.run(0.01)
                time.sleep(0.005)

        path = ":".join([os.path.join(BUILD, "bin"), os.environ["PATH"]])
        environment = {"CONFIG_DIR": self.folder, "PATH": path}
        patched = unittest.mock.patch.dict(os.environ, environment)
        patched.start()
        self.addCleanup(patched.stop)
        self.host = plumb.Host(namespaces=False)
        self.addCleanup(self.host.close)
        for line in ("loadrt threads name1=servo-thread period1=1000000", "loadrt sum2 names=load-reading", "net spindle-load load-reading.out", "loadrt thermal_displacement names=growth interlock=no",
                     "loadrt interlock names=interlock", "addf interlock.update servo-thread"):
            self.host.command(line)
        self.host.load(os.path.join(mill, "sensors.hal"))
        self.host.command("start")
        until("growth.load-valid", True)
        until("shop-valid", True)
        self.assertAlmostEqual(self.host.get("spindle-load"), 42.3)
        until("can-sensor.spindle-load.fault", False)
        sending.clear()
        until("growth.load-valid", False)
        until("can-sensor.spindle-load.fault", True)
        self.assertAlmostEqual(self.host.get("spindle-load"), 42.3)
        self.assertFalse(self.host.get("interlock.service-lost-2"))
        sending.set()
        # A program that dies leaves valid as it was; interlock sees it.
        program = int(subprocess.check_output(["pgrep", "-f", "^can_sensor --file " + self.folder]))
        until("load-valid", True)
        os.kill(program, signal.SIGSTOP)
        while not self.host.get("load-fresh"):  # the value became too old meanwhile
            os.kill(program, signal.SIGCONT)
            until("load-valid", True)
            os.kill(program, signal.SIGSTOP)
        os.kill(program, signal.SIGKILL)
        until("load-valid", False)
        self.assertTrue(self.host.get("load-fresh"))
        self.assertTrue(self.host.get("interlock.service-lost-2"))

    def test_list_prints_the_values_and_candump_agrees(self):
        over = threading.Event()

        def sender():
            while not over.wait(0.02):
                self.send(0x201, b"\x10\x27")

        thread = threading.Thread(target=sender)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)
        dumped = subprocess.run(["candump", "-n", "1", "-T", "5000", "vcan0"], capture_output=True, text=True)
        self.assertRegex(dumped.stdout, r"201 +\[2\] +10 27")
        done = subprocess.run([SENSOR, "--list", self.file(self.SPEED)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertRegex(done.stdout, r"bus +speed +10000 +rpm +yes ")
        over.set()
        thread.join()
        silent = subprocess.run([SENSOR, "--list", self.file(self.SPEED)], capture_output=True, text=True)
        self.assertEqual(silent.returncode, 1)
        self.assertRegex(silent.stdout, r"bus +speed +- +rpm +no .*No value has come yet")

    def test_no_stale_value_is_valid_whatever_is_on_the_bus(self):
        done = subprocess.run([os.path.join(BUILD, "specimens", "can_link_faults"), "2000", "1"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        print(done.stdout, end="")


class Everything(unittest.TestCase):
    def test_on_a_bus(self):
        folder = own_folder(self)
        words = ["/usr/bin/python3", os.path.join(ROOT, "tests", "support", "run.py"), os.path.abspath(__file__), *sys.argv[1:]]
        done = subprocess.run(
            [os.path.join(ROOT, "tests", "support", "can_vm"), "500", folder, *words],
            env={**os.environ, BUS: "1", "PLUMB_BUILD": BUILD},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.assertEqual(done.returncode, 0, done.stdout)
        print(done.stdout, end="")


def load_tests(loader, _, __):
    """On the bus the tests that need it, else those that do not, and one that runs the former elsewhere."""
    suite = unittest.TestSuite()
    for case in [Bus] if os.environ.get(BUS) else [Files, Everything]:
        suite.addTests(loader.loadTestsFromTestCase(case))
    return suite


if __name__ == "__main__":
    unittest.main()

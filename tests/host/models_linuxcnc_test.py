# SPDX-License-Identifier: GPL-2.0-or-later
"""Models of drivers: a complete LinuxCNC homes, moves and changes tools on them. PLUMB_BUILD names the build folder."""

import json
import os
import re
import subprocess
import sys
import unittest

import plumb
from tree import BUILD, own_folder

sys.path.insert(1, os.path.join(BUILD, "share", "plumb", "models"))
import model_files  # noqa: E402

PLUMB = os.path.join(BUILD, "bin", "plumb")
INI = """[EMC]
VERSION = 1.1
MACHINE = mixed
[DISPLAY]
DISPLAY = ./display.py
[RS274NGC]
PARAMETER_FILE = mixed.var
[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 30
SERVO_PERIOD = 1000000
[TASK]
TASK = milltask
CYCLE_TIME = 0.010
[HAL]
HALFILE = mixed.hal
[TRAJ]
COORDINATES = XYZ
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
DEFAULT_LINEAR_VELOCITY = 20
MAX_LINEAR_VELOCITY = 60
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.100
TOOL_TABLE = mixed.tbl
[KINS]
KINEMATICS = trivkins coordinates=XYZ
JOINTS = 3
"""
JOINT = """[AXIS_%(letter)s]
MIN_LIMIT = %(low)g
MAX_LIMIT = %(high)g
MAX_VELOCITY = 60
MAX_ACCELERATION = 500
[JOINT_%(joint)d]
TYPE = LINEAR
MIN_LIMIT = %(low)g
MAX_LIMIT = %(high)g
MAX_VELOCITY = 60
MAX_ACCELERATION = 500
STEPGEN_MAXACCEL = 625
FERROR = 0.5
MIN_FERROR = 0.2
HOME = %(home)g
HOME_OFFSET = %(offset)g
HOME_SEARCH_VEL = %(search)g
HOME_LATCH_VEL = %(latch)g
HOME_USE_INDEX = %(index)s
HOME_IGNORE_LIMITS = %(shared)s
HOME_SEQUENCE = %(sequence)d
"""
JOINTS = (
    {"letter": "X", "joint": 0, "low": -1, "high": 300, "home": 10, "offset": 0, "search": -15, "latch": -3, "index": "NO", "shared": "YES", "sequence": 1},
    {"letter": "Y", "joint": 1, "low": -2, "high": 200, "home": 20, "offset": 205, "search": 15, "latch": 2, "index": "YES", "shared": "NO", "sequence": 1},
    {"letter": "Z", "joint": 2, "low": -150, "high": 3, "home": 0, "offset": 2, "search": 10, "latch": 2, "index": "YES", "shared": "NO", "sequence": 0},
)
# A step generator, a servo behind a pid with an index, and a drive on EtherCAT. X has one switch for home and limit.
HAL = """loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
loadrt hostmot2
loadrt hm2_eth board_ip="10.10.10.10" config="num_encoders=2 num_pwmgens=1 num_stepgens=1"
loadrt lcec
loadrt cia402 count=1
loadrt pid names=pid-y
loadrt not names=z-home-not
loadusr -W hal_manualtoolchange

addf hm2_7i76e.0.read servo-thread
addf lcec.read-all servo-thread
addf cia402.0.read-all servo-thread
addf z-home-not servo-thread
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf pid-y.do-pid-calcs servo-thread
addf cia402.0.write-all servo-thread
addf lcec.write-all servo-thread
addf hm2_7i76e.0.write servo-thread

net x-cmd joint.0.motor-pos-cmd => hm2_7i76e.0.stepgen.00.position-cmd
net x-fb hm2_7i76e.0.stepgen.00.position-fb => joint.0.motor-pos-fb
net x-on joint.0.amp-enable-out => hm2_7i76e.0.stepgen.00.enable
setp hm2_7i76e.0.stepgen.00.maxvel 70
setp hm2_7i76e.0.stepgen.00.maxaccel [JOINT_0]STEPGEN_MAXACCEL
setp hm2_7i76e.0.stepgen.00.position-scale 400
net x-switch hm2_7i76e.0.gpio.003.in_not => joint.0.home-sw-in joint.0.neg-lim-sw-in
net x-other-side hm2_7i76e.0.gpio.003.in

net y-cmd joint.1.motor-pos-cmd => pid-y.command
net y-fb hm2_7i76e.0.encoder.00.position => pid-y.feedback joint.1.motor-pos-fb
net y-out pid-y.output => hm2_7i76e.0.pwmgen.00.value
net y-on joint.1.amp-enable-out => hm2_7i76e.0.pwmgen.00.enable
setp pid-y.Pgain 200
setp pid-y.enable 1
setp pid-y.bias 0.05
setp hm2_7i76e.0.pwmgen.00.scale 70
setp hm2_7i76e.0.encoder.00.scale 1000
net y-raw hm2_7i76e.0.encoder.00.rawcounts
net y-index hm2_7i76e.0.encoder.00.index-enable <=> joint.1.index-enable
net y-home hm2_7i76e.0.gpio.004.in => joint.1.home-sw-in

net z-cmd joint.2.motor-pos-cmd => cia402.0.pos-cmd
net z-fb cia402.0.pos-fb => joint.2.motor-pos-fb
net z-on joint.2.amp-enable-out => cia402.0.enable
net z-operates cia402.0.stat-op-enabled
net z-index joint.2.index-enable <=> cia402.0.home
setp cia402.0.pos-scale 10000
net z-control cia402.0.controlword => lcec.0.0.cia-controlword
net z-status lcec.0.0.cia-statusword => cia402.0.statusword
net z-target cia402.0.drv-target-position => lcec.0.0.target-position
net z-actual lcec.0.0.actual-position => cia402.0.drv-actual-position
net z-home-raw hm2_7i76e.0.gpio.005.in => z-home-not.in
net z-home z-home-not.out => joint.2.home-sw-in

net spindle-turns hm2_7i76e.0.encoder.01.position => spindle.0.revs
net spindle-speed hm2_7i76e.0.encoder.01.velocity => spindle.0.speed-in
net spindle-ready hm2_7i76e.0.7i76.0.0.input-00 => spindle.0.at-speed

net estop hm2_7i76e.0.gpio.001.in => iocontrol.0.emc-enable-in
net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net change iocontrol.0.tool-change => hal_manualtoolchange.change
net changed hal_manualtoolchange.changed => iocontrol.0.tool-changed
net number iocontrol.0.tool-prep-number => hal_manualtoolchange.number
"""
DISPLAY = """#!/usr/bin/python3
import json, os, sys, time
import linuxcnc
import plumb

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
host = plumb.Host(attach=os.environ["RTAPI_FIFO_PATH"])
found = {"messages": [], "lines": []}

def wait(holds):
    end = time.monotonic() + 600  # of the faster clock
    while time.monotonic() < end:
        status.poll()
        message = errors.poll()
        if message:
            found["messages"].append(message[1])
            return False
        if holds():
            return True
        time.sleep(0.02)
    return False

def finish():
    with open("found.json", "w") as file:
        json.dump(found, file)
    sys.exit(0)

found["before"] = host.get("y-fb")
if "motor-fb" in NAMES:
    host.expect("abs(fb_rate) <= 30001", fb="motor-fb")  # 3 a millisecond, seen in a period of the base thread
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete()
command.state(linuxcnc.STATE_ON)
command.wait_complete()
if not wait(lambda: status.task_state == linuxcnc.STATE_ON):
    found["messages"].append("the machine is not on")
    finish()
command.teleop_enable(0)
command.wait_complete()
command.home(-1)
found["homed"] = wait(lambda: all(status.homed[:3]))
time.sleep(0.5)  # a drive behind a pid comes to rest
status.poll()
found["home"] = [status.joint[joint]["input"] for joint in range(3)]
if not found["homed"]:
    finish()
command.mode(linuxcnc.MODE_MDI)
command.wait_complete()
for line in LINES:
    begin = host.time
    command.mdi(line)
    command.wait_complete(600)
    status.poll()
    found.setdefault("times", []).append(host.time - begin)
    found["lines"].append([line, [round(value, 4) for value in status.actual_position[:3]], status.tool_in_spindle])
    if "motor-fb" in NAMES:
        found.setdefault("motor", []).append(host.get(["motor-rpm", "motor-fb"]))
    found.setdefault("speeds", []).append(host.get("spindle.0.speed-in"))
found["violations"] = str(host.violations())
found["values"] = dict(zip(NAMES, host.get(NAMES)))
finish()
"""
# As StepConf writes it: X has one input for home and limits, Y and Z share one. A VFD, a component and a program of the user's.
PARPORT = """loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT base_period_nsec=100000 servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
loadrt hal_parport cfg="0x378 out"
loadrt stepgen step_type=0,0,0
loadrt near
loadrt gear
loadusr -Wn vfd hy_vfd -n vfd -d /dev/ttyUSB0 -p none -r 9600
loadusr -W ./lamp_tower.py

addf parport.0.read base-thread
addf stepgen.make-pulses base-thread
addf parport.0.write base-thread
addf stepgen.capture-position servo-thread
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf gear.0 servo-thread
addf near.0 servo-thread
addf stepgen.update-freq servo-thread

net x-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd
net x-fb stepgen.0.position-fb => joint.0.motor-pos-fb
net x-on joint.0.amp-enable-out => stepgen.0.enable
net x-step stepgen.0.step => parport.0.pin-03-out
net y-cmd joint.1.motor-pos-cmd => stepgen.1.position-cmd
net y-fb stepgen.1.position-fb => joint.1.motor-pos-fb
net y-on joint.1.amp-enable-out => stepgen.1.enable
net z-cmd joint.2.motor-pos-cmd => stepgen.2.position-cmd
net z-fb stepgen.2.position-fb => joint.2.motor-pos-fb
net z-on joint.2.amp-enable-out => stepgen.2.enable
%s
net both-home-x parport.0.pin-10-in-not => joint.0.home-sw-in joint.0.neg-lim-sw-in joint.0.pos-lim-sw-in
net x-other-side parport.0.pin-10-in
net all-home parport.0.pin-12-in => joint.1.home-sw-in joint.2.home-sw-in

net spindle-rpm spindle.0.speed-out-abs => gear.0.in
net motor-rpm gear.0.out => vfd.speed-command near.0.in1
net spindle-on spindle.0.on => vfd.spindle-on
net motor-fb vfd.spindle-speed-fb => near.0.in2
setp near.0.scale 1.02
net near-speed near.0.out
net spindle-ready vfd.spindle-at-speed => spindle.0.at-speed
net lamp iocontrol.0.user-enable-out => tower.lamp.lit
net estop parport.0.pin-15-in-not => iocontrol.0.emc-enable-in
net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net change iocontrol.0.tool-change => iocontrol.0.tool-changed
""" % "".join("setp stepgen.%d.position-scale 50\nsetp stepgen.%d.maxaccel 700\nsetp stepgen.%d.maxvel 70\n" % (n, n, n) for n in range(3))
GEAR = """component gear;
pin in float in;
pin out float out;
function _;
license "GPL";
;;
FUNCTION(_) { out = in * 3; }
"""
LAMPS = """#!/usr/bin/python
import serial
print "no Python 3"
"""
LINES = ["G21 G90 G0 X120 Y30 Z-40", "M3 S600", "G1 F1200 X130 Z-45", "M5", "T1 M6", "G0 X5 Y5 Z0"]
NAMES = ["z-operates", "x-switch", "x-other-side", "cia402.0.controlword", "lcec.0.0.cia-statusword", "z-actual", "z-fb", "y-fb", "y-raw"]


class Machine(unittest.TestCase):
    """A complete LinuxCNC on models."""

    INI = INI

    def setUp(self):
        self.folder = own_folder(self)
        self.write("mixed.ini", self.INI + "".join(JOINT % {**joint, **self.JOINT} for joint in JOINTS))
        self.write("mixed.tbl", "T1 P1 Z-10 D6\n")
        values = "LINES = %r\nNAMES = %r\n" % (LINES, self.NAMES)
        self.write("display.py", DISPLAY.replace("command, status", values + "command, status", 1))

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)
        if text.startswith("#!"):
            os.chmod(os.path.join(self.folder, name), 0o755)

    def run_linuxcnc(self):
        words = [PLUMB, "run", "--models", "--speed", "10", "--", "linuxcnc", "-r", "mixed.ini"]
        environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        environment["XDG_CACHE_HOME"] = os.path.join(self.folder, "cache")
        ran = subprocess.run(words, cwd=self.folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300, check=False)
        try:
            with open(os.path.join(self.folder, "found.json"), encoding="utf-8") as file:
                return json.load(file), ran.stderr
        except FileNotFoundError:
            self.fail(ran.stdout + ran.stderr)

    def check_moves(self, found, errors, delta):
        self.assertEqual(found["messages"], [], errors)
        self.assertTrue(found["homed"])
        for joint, place in enumerate(found["home"]):
            self.assertAlmostEqual(place, JOINTS[joint]["home"], delta=delta)
        for line, position, _ in found["lines"]:
            wanted = {word[0]: float(word[1:]) for word in line.split() if word[0] in "XYZ"}
            for letter, value in wanted.items():
                self.assertAlmostEqual(position["XYZ".index(letter)], value, delta=delta, msg=line)
        self.assertEqual([tool for *_, tool in found["lines"]], [0, 0, 0, 0, 1, 1])
        # The feed waits for the spindle: 600/min by 1000/min in a second, less what M3 took; then 11 mm with 20 mm/s.
        self.assertGreater(sum(found["times"][1:3]), 1.05)


class StepConf(Machine):
    """A parallel port, software step generators, a VFD, a component and a program in Python 2."""

    JOINT = {"index": "NO"}
    NAMES = ["near-speed", "motor-fb", "motor-rpm", "tower.lamp.lit", "both-home-x", "x-other-side"]

    def test_it_homes_on_shared_inputs_moves_and_waits_for_the_vfd(self):
        self.write("mixed.hal", PARPORT)
        self.write("gear.comp", GEAR)
        self.write("lamp_tower.py", LAMPS)
        found, errors = self.run_linuxcnc()
        self.check_moves(found, errors, 0.03)  # a step is 0.02 mm
        values = found["values"]
        self.assertEqual(values["tower.lamp.lit"], True)
        self.assertNotEqual(values["both-home-x"], values["x-other-side"])
        self.assertEqual((values["motor-rpm"], values["motor-fb"]), (0, 0))
        self.assertEqual(found["motor"][2], [1800, 1800])  # of the command that the program sees
        self.assertEqual(found["violations"], "[]")  # 3 times 1000/min in a second
        self.assertIn("gear.comp is compiled for this run", errors)
        self.assertIn("note: ./lamp_tower.py: the program is no valid Python 3; its pins rest", errors)


class Mixed(Machine):
    """A step generator, a servo behind a pid with an index, and a drive on EtherCAT."""

    JOINT = {}
    NAMES = NAMES

    def test_a_pid_with_the_wrong_sign_runs_away(self):
        self.write("mixed.hal", HAL.replace("Pgain 200", "Pgain -200"))
        found, errors = self.run_linuxcnc()
        self.assertEqual(found["messages"][:1], ["joint 1 following error"], errors)

    def test_it_homes_moves_reaches_its_speed_and_changes_the_tool(self):
        self.write("mixed.hal", HAL)
        found, errors = self.run_linuxcnc()
        self.check_moves(found, errors, 0.001)
        self.assertEqual(found["before"], 0)  # a drive that is not enabled rests
        self.assertAlmostEqual(found["speeds"][2], 10, delta=0.3)  # turns a second
        values = found["values"]
        self.assertAlmostEqual(values["y-fb"], 5 - JOINTS[1]["offset"], delta=0.001)
        index = values["y-raw"] / 1000 - values["y-fb"]  # where the count began again
        self.assertAlmostEqual(index, round(index), delta=0.03)
        self.assertGreater(index, 0.9)
        self.assertAlmostEqual(values["z-fb"], 0 - JOINTS[2]["offset"], delta=0.001)
        self.assertGreater(values["z-actual"] / 10000 - values["z-fb"], 1)  # the drive has homed where it stood
        self.assertTrue(values["z-operates"])
        self.assertNotEqual(values["x-switch"], values["x-other-side"])
        self.assertEqual((values["cia402.0.controlword"], values["lcec.0.0.cia-statusword"] & 0x6F), (0x0F, 0x27))
        self.assertIn("model: ", errors)
        for what in ("the bus", "the watchdog of the card"):
            self.assertEqual(errors.count(what), 1, errors)


class Steps(unittest.TestCase):
    """A step generator in plumb bench, and model files."""

    def setUp(self):
        self.folder = own_folder(self)

    def bench(self, hal, *words):
        with open(os.path.join(self.folder, "it.hal"), "w", encoding="utf-8") as file:
            file.write(hal)
        environment = {**os.environ, "XDG_CACHE_HOME": os.path.join(self.folder, "cache")}
        words = [PLUMB, "bench", "it.hal", "--models", *words]
        return subprocess.run(words, cwd=self.folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=100, check=False)

    HEAD = """loadrt %(module)s
loadrt threads name1=servo-thread period1=1000000
addf %(head)s.read servo-thread
setp %(head)s.stepgen.00.enable 1
setp %(head)s.stepgen.00.maxvel 20
setp %(head)s.stepgen.00.maxaccel 100
net at %(head)s.stepgen.00.position-fb
net speed %(head)s.stepgen.00.velocity-fb
net goal => %(head)s.stepgen.00.position-cmd
sets goal 30
"""

    def test_a_step_generator_keeps_to_its_limits_and_stops_at_its_goal(self):
        hal = self.HEAD % {"module": "hm2_eth", "head": "hm2_7i92.0"}
        limits = ["abs({speed}) <= 20.000001", "abs({speed}_rate) <= 100.001", "{at} <= 30.000001"]
        words = [word for limit in limits for word in ("--expect", limit)]
        ran = self.bench(hal, "--for", "2.5s", *words, "--record", "at,speed", "--every", "10ms", "--output", "o.csv")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        with open(os.path.join(self.folder, "o.csv"), encoding="utf-8") as file:
            rows = [list(map(float, line.split(","))) for line in file.readlines()[1:]]
        self.assertAlmostEqual(max(row[2] for row in rows), 20, places=6)
        self.assertAlmostEqual(rows[-1][1], 30, places=6)
        # 30 at 20/s with 100/s2: 1.7 s.
        arrived = next(row[0] for row in rows if row[1] > 29.999)
        self.assertAlmostEqual(arrived, 1.7, delta=0.02)

    def test_the_file_of_an_ethercat_bus_gives_types_and_the_drive(self):
        objects = (("out", "6040", "u32", "order"), ("out", "607A", "s32", "goal"), ("in", "6041", "u32", "state"), ("in", "6064", "s32", "place"), ("in", "2001", "s32", "load"))
        entries = {way: "".join('<pdoEntry idx="%s" subIdx="00" bitLen="32" halPin="%s" halType="%s"/>' % (idx, name, kind) for its, idx, kind, name in objects if its == way) for way in ("in", "out")}
        managers = "".join('<syncManager idx="2" dir="%s"><pdo idx="1600">%s</pdo></syncManager>' % way for way in entries.items())
        with open(os.path.join(self.folder, "bus.xml"), "w", encoding="utf-8") as file:
            file.write('<masters><master idx="0" name="m"><slave idx="3" type="generic" name="x">%s</slave></master></masters>' % managers)
        hal = "loadusr -W lcec_conf bus.xml\nloadrt lcec\nloadrt threads name1=servo-thread period1=1000000\naddf lcec.read-all servo-thread\n"
        hal += "newsig order u32\nnet order => lcec.m.x.order\nsets order 6\nnet state lcec.m.x.state\nnet goal => lcec.m.x.goal\n"
        hal += "net place lcec.m.x.place\nnet load lcec.m.x.load\nsets goal -70000\n"
        ran = self.bench(hal, "--for", "10ms", "--record", "state,goal,load", "--every", "5ms", "--output", "o.csv")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        with open(os.path.join(self.folder, "o.csv"), encoding="utf-8") as file:
            self.assertEqual(list(map(float, file.readlines()[-1].split(",")[1:])), [0x221, -70000, 0])
        ran = self.bench(hal.replace("sets order 6", "sets order 15"), "--for", "10ms", "--expect", "{state} == 576 || {state} == 0")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)  # not without a shutdown first
        self.assertNotEqual(self.bench(hal + "loadrt xor2\naddf xor2.0 servo-thread\nnet load xor2.0.in0\n", "--for", "1ms").returncode, 0)

    def test_each_slave_of_a_bus_is_a_drive_of_its_own(self):
        hal = "loadrt lcec\nloadrt threads name1=servo-thread period1=1000000\naddf lcec.read-all servo-thread\n"
        for slave, order in (("x", 6), ("y", 0)):
            hal += "newsig {0}-order u32\nnet {0}-order => lcec.0.{0}.cia-controlword\nsets {0}-order {1}\n".format(slave, order)
            hal += "net {0}-state lcec.0.{0}.cia-statusword\n".format(slave)
        ran = self.bench(hal, "--for", "10ms", "--record", "x-state,y-state", "--every", "5ms", "--output", "o.csv")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        with open(os.path.join(self.folder, "o.csv"), encoding="utf-8") as file:
            self.assertEqual(list(map(float, file.readlines()[-1].split(",")[1:])), [0x221, 0x240])

    def test_a_port_is_read_in_a_thread_without_floating_point_and_its_inputs_contradict_each_other(self):
        hal = "loadrt hal_parport cfg=378\nloadrt threads name1=base-thread fp1=0 period1=50000\naddf parport.0.read base-thread\n"
        hal += "net probe parport.0.pin-10-in\nnet no-probe parport.0.pin-10-in-not\n"
        ran = self.bench(hal, "--for", "10ms", "--expect", "{probe} == 0 && {no-probe} == 1")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)

    def test_a_file_beside_the_hal_file_adds_a_driver_under_another_name(self):
        hal = self.HEAD % {"module": "acme_card", "head": "motion-board"}
        ran = self.bench(hal, "--for", "2.5s", "--expect", "{at} == 0")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn("acme_card has 6 pins; the model leaves out all that the module does, because it is not installed here", ran.stderr)
        lines = ["modules = 'acme_card'", "heads = 'motion-board'", "misses = 'its lamps'", "pins = '''"]
        lines += [r"motion-board\.stepgen\.\d+\.(position-fb|velocity-fb)  float out", r"motion-board\.stepgen\.\d+\.enable bit in"]
        lines += [r"motion-board\..* float in", "'''", "[[parts]]", r"of = 'motion-board\.stepgen\.\d+'", "kind = 'stepgen'"]
        lines += ["pins = { command = 'position-cmd', maxvel = 'maxvel', maxaccel = 'maxaccel', enable = 'enable', position = 'position-fb' }"]
        with open(os.path.join(self.folder, "acme.model"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        ran = self.bench(hal, "--for", "2.5s", "--expect", "{at} >= 0 && {at} < 30.001", "--record", "at", "--every", "100ms", "--output", "o.csv")
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn("acme_card has 6 pins; the model leaves out its lamps", ran.stderr)
        with open(os.path.join(self.folder, "o.csv"), encoding="utf-8") as file:
            self.assertAlmostEqual(float(file.readlines()[-1].split(",")[1]), 30, places=6)

    def test_a_wrong_model_file_is_named_with_its_word(self):
        for text, words in (
            ("modulse = 'x'", "it.model: 'modulse' is no word of a model file"),
            ("modules = '('", "'(' is no regular expression"),
            ("pins = '''\nx.y flaot in\n'''", "'x.y flaot in' is no pin"),
            ("[[parts]]\nof = 'x'\nkind = 'robot'", "'robot' is no kind of a part"),
        ):
            with self.subTest(text):
                with open(os.path.join(self.folder, "it.model"), "w", encoding="utf-8") as file:
                    file.write(text)
                ran = self.bench("loadrt threads name1=t period1=1000000\n", "--for", "1ms")
                self.assertEqual(ran.returncode, 1)
                self.assertIn(words, ran.stderr)


class Names(unittest.TestCase):
    def test_the_pins_of_a_card_are_those_of_linuxcncs_own_test_driver(self):
        folder = own_folder(self)
        path = os.path.join(folder, "it.hal")
        with open(path, "w", encoding="utf-8") as file:
            file.write("loadrt hostmot2\nloadrt hm2_test test_pattern=12\nshow pin\nshow param\n")
        with plumb.Host() as host:
            shown = host.halcmd("-f", path).output
        rows = re.findall(r"^ +\d+ +(bit|float|s32|u32) +(IN|OUT|I/O|RO|RW) +\S+ +(hm2_test\.0\.gpio\.\S+)", shown, re.M)
        self.assertGreater(len(rows), 100, shown)
        files = model_files.model_files()
        for kind, direction, name in rows:
            wanted = {"RW": "IN", "RO": "OUT", "I/O": "IO"}.get(direction, direction)
            self.assertEqual(model_files.known(files, name), [kind, wanted], name)


if __name__ == "__main__":
    unittest.main()

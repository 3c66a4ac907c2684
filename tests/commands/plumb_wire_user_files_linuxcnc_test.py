#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb wire on a machine with many things that users' files have: Mesa and EtherCAT, inverted inputs, a load, a late file."""

import os
import re
import unittest

import wire_samples
from wire_sample import AXIS_MM, Sample, read, write

HAL = """loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
loadrt hostmot2
loadrt hm2_eth board_ip="10.10.10.10" config="num_encoders=1 num_stepgens=2 sserial_port_0=00xxxx"
loadusr -W lcec_conf ethercat.xml
loadrt lcec
loadrt cia402 count=1
loadrt hal_parport cfg=0x378
loadrt not count=1
loadrt conv_s32_float count=1

# Functions of the user in front and behind
loadrt ddt names=watch,late
addf watch servo-thread
addf lcec.read-all servo-thread
addf cia402.0.read-all servo-thread
addf parport.read-all servo-thread
addf parport.0.reset servo-thread
addf hm2_7i76e.0.read servo-thread
addf not.0 servo-thread
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf conv-s32-float.0 servo-thread
addf cia402.0.write-all servo-thread
addf lcec.write-all servo-thread
addf hm2_7i76e.0.write servo-thread

setp hm2_7i76e.0.gpio.030.is_output true
setp hm2_7i76e.0.gpio.030.invert_output true
setp hm2_7i76e.0.stepgen.00.step_type 0
net x-cmd joint.0.motor-pos-cmd => hm2_7i76e.0.stepgen.00.position-cmd
net x-fb hm2_7i76e.0.stepgen.00.position-fb => joint.0.motor-pos-fb
net y-cmd joint.1.motor-pos-cmd => hm2_7i76e.0.stepgen.01.position-cmd
net y-fb hm2_7i76e.0.stepgen.01.position-fb => joint.1.motor-pos-fb
# Normally closed limits: the inverse of an input, an input behind not
net x-limit joint.0.neg-lim-sw-in <= hm2_7i76e.0.7i76.0.0.input-04-not
net y-switch hm2_7i76e.0.7i76.0.0.input-05 => not.0.in
net y-limit not.0.out => joint.1.pos-lim-sw-in
net stop-ok hm2_7i76e.0.7i76.0.0.input-06 => iocontrol.0.emc-enable-in
net spindle-load hm2_7i76e.0.7i76.0.0.analogin0
net lamp spindle.0.brake => parport.0.pin-02-out

setp cia402.0.csp-mode 1
setp cia402.0.pos-scale 10000
net z-cmd joint.2.motor-pos-cmd => cia402.0.pos-cmd
net z-fb cia402.0.pos-fb => joint.2.motor-pos-fb
net z-on joint.2.amp-enable-out => cia402.0.enable
net z-status lcec.0.2.cia-statusword => cia402.0.statusword
net z-control cia402.0.controlword => lcec.0.2.cia-controlword
net z-mode cia402.0.opmode => lcec.0.2.opmode
net z-shown lcec.0.2.opmode-display => cia402.0.opmode-display
net z-actual lcec.0.2.actual-position => cia402.0.drv-actual-position
net z-target cia402.0.drv-target-position => lcec.0.2.target-position
net torque lcec.0.2.actual-torque conv-s32-float.0.in
net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed
"""
POSTGUI = "loadusr -W longer\nloadusr sleep 400\n"
PROGRAM = """#!/usr/bin/python3
import time
import hal
component = hal.component("longer")
component.ready()
while True:
    time.sleep(1)
"""


class UserFiles(Sample):
    def test_a_machine_with_many_of_them_is_wired(self):
        home = os.path.dirname(self.ini(AXIS_MM))
        write(os.path.join(home, "mine.hal"), HAL)
        write(os.path.join(home, "late.hal"), POSTGUI)
        os.makedirs(os.path.join(home, "bin"), exist_ok=True)
        write(os.path.join(home, "bin", "longer"), PROGRAM)
        os.chmod(os.path.join(home, "bin", "longer"), 0o755)
        ini = re.sub(r"^HALFILE = .*\n", "", read(self.ini(AXIS_MM)), flags=re.M)
        halfiles = "[HAL]\nHALFILE = mine.hal\nHALFILE =\nPOSTGUI_HALFILE = late.hal\n"
        write(self.ini(AXIS_MM), re.sub(r"^\[HAL\]\n", halfiles, ini, flags=re.M))
        status, output, flat = self.wire(AXIS_MM, "squareness", "thermal_displacement")
        self.assertEqual(status, 0, output)
        self.assertTrue(all(holds for holds, _ in wire_samples.statements(output)), output)
        self.assertTrue(any("is measured as" in text for text in self.seen(output, "thermal_displacement")), output)
        self.assertRegex(flat, "Pins stand in for them here: hostmot2, hm2_eth, lcec, cia402, hal_parport")


if __name__ == "__main__":
    unittest.main()

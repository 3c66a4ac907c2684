# SPDX-License-Identifier: GPL-2.0-or-later
"""plumb volume: from readings to tables that squareness takes, with their uncertainty, and files of other controls."""

import json
import math
import os
import random
import subprocess
import unittest

import plumb
from plumb_folder import TemporaryFolder
from tree import BUILD

PLUMB_VOLUME = os.path.join(BUILD, "bin", "plumb-volume")


def volume(*arguments, cwd=None):
    done = subprocess.run([PLUMB_VOLUME, *arguments], capture_output=True, text=True, check=False, cwd=cwd)
    return done.returncode, done.stdout, done.stderr


class Volume(unittest.TestCase):
    def setUp(self):
        folder = TemporaryFolder()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)
        return name

    def read(self, name):
        with open(os.path.join(self.folder, name), encoding="ascii") as file:
            return file.read()

    def run_volume(self, *arguments):
        status, output, errors = volume(*arguments, cwd=self.folder)
        self.assertEqual((status, errors), (0, ""), arguments)
        return output

    def refused(self, *arguments):
        status, output, errors = volume(*arguments, cwd=self.folder)
        self.assertEqual((status, output), (1, ""), arguments)
        return errors.strip()

    def readings(self, noise=0.0):
        drawn = random.Random(4)
        rows = ["position,up1,up2,up3,down1,down2,down3"]
        for place, lost in ((100, 0.008), (300, 0.010), (500, 0.012)):
            rows.append(",".join(["%g" % place] + ["%.5f" % (sign * lost / 2 + drawn.gauss(0, noise)) for sign in (-1, -1, -1, 1, 1, 1)]))
        return self.write("readings.csv", "\n".join(rows) + "\n")

    def test_readings_become_direction_columns_that_squareness_corrects(self):
        output = self.run_volume("reversal", self.readings(), "--axis", "X", "--output", "x.csv", "--reading-u", "0.1um")
        self.assertIn("Lost motion of X: 10.00 um +- 0.09 um (k = 2), from 8.00 um to 12.00 um along the travel", output)
        self.assertIn("Not seen: the scale of the axis,", output)
        with plumb.Host(options={"squareness.table": os.path.join(self.folder, "x.csv"), "squareness.chain": "w-X-Y.b-Z-C-t"}) as host:
            for line in ("loadrt threads name1=t period1=1000000", "loadrt squareness names=square interlock=no", "addf square.update t", "start"):
                host.command(line)
            for name, value in (("max-speed", 1e5), ("enable", True), ("all-homed", True)):
                host.set("square." + name, value)
            for place, direction, lost in ((300, 1, 0.010), (100, -1, 0.008), (500, 1, 0.012)):
                host.set("square.x-position", place - direction)
                host.run(0.2)
                host.set("square.x-position", place)
                host.run(0.3)
                self.assertAlmostEqual(host.get("square.x-correction"), direction * lost / 2, 6)

    def test_one_reading_each_needs_an_uncertainty_and_the_hysteresis_stays(self):
        self.write("once.csv", "position,up1,down1\n5,0,0.01\n")
        self.assertIn("once.csv: each position was read once in each direction", self.refused("reversal", "once.csv", "--axis", "X"))
        self.assertIn("the readings do not scatter at all", self.refused("reversal", self.readings(), "--axis", "Y"))
        found = json.loads(self.run_volume("reversal", self.readings(), "--axis", "Y", "--json", "--own-u", "0.5um", "--reading-u", "0.01um"))
        self.assertAlmostEqual(found["U"], 0.001, 5)
        self.assertAlmostEqual(found["lost_motion"], 0.010)

    def test_a_table_that_is_there_takes_the_lost_motion_in(self):
        self.write("y.csv", "# u: EYY 0.0003\nY,EXY,EYY\n0,0.001,0.002\n300,0.003,0.004\n600,0,0\n# end, 3 rows\n")
        self.run_volume("reversal", self.readings(), "--axis", "Y", "--output", "new.csv", "--into", "y.csv", "--reading-u", "0.1um")
        lines = self.read("new.csv").splitlines()
        self.assertEqual(lines[2:5], ["# by: readings from both sides", "# u: EYY 0.0003", "Y,EYY+,EYY-,EXY"])
        self.assertTrue(lines[0].startswith("# u: EYY+ "), lines[0])
        self.assertEqual(lines[6], "300,-0.001,0.009,0.003")
        self.assertIn("y.csv: holds a table of another axis", self.refused("reversal", self.readings(), "--axis", "X", "--output", "z.csv", "--into", "y.csv", "--reading-u", "1um").splitlines()[-1])

    def test_readings_that_a_stranger_writes_are_refused_with_the_reason(self):
        head = "position,up1,up2,down1,down2\n"
        for text, reason in (
            ("position;up1;up2;down1;down2\n100;0,0001;0.0002;0,01;0,0101\n", "line 2: '0,0001' has a comma and '0.0002' a point: which one is the decimal mark?"),
            (head + "100,0,0001,0,0002,0,01,0,0101\n", "line 2: 9 values, but line 1 has 5 heads; is the comma a decimal mark? Then separate by semicolons"),
            ("position,up1,up1,down1,down2\n100,0,0.0001,0.01,0.0101\n", "line 1: column 'up1' is there twice"),
            ("Place,Up1\n100,0\n", "line 1: there is no column position; there are 'Place', 'Up1'"),
            ("position,up1 (s),down1\n100,0,1\n", "line 1: column 'up1 (s)' is neither a length nor an angle"),
            ("# mill 7\nposition,up1,left1\n100,0,1\n", "line 2: column 'left1' is none of position, up1"),
            (head + "100,0,0.0001,0.3,0.3001\n", "position 100 mm: the directions differ by 0.3 mm, more than 0.2 mm"),
            (head + "0,0,0.0001,0.01,0.0101\n0.1,0,0.0001,0.07,0.0701\n", "position 0.1 mm: from -0.005 to -0.035 mm within 0.1 mm is too steep"),
        ):
            self.write("odd.csv", text)
            self.assertIn("odd.csv: " + reason, self.refused("reversal", "odd.csv", "--axis", "X", "--output", "x.csv"))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "x.csv")))
        self.readings()
        for option, value, reason in (
            ("--reading-u", "-1um", "--reading-u: '-1um' is not 0 or more and below 1 mm"),
            ("--own-u", "3inch", "plumb volume: --own-u: '3inch' has an unknown unit"),
            ("--date", "2026-02-29", "--date: '2026-02-29' is no date"),
        ):
            self.assertIn(reason, self.refused("reversal", "readings.csv", "--axis", "X", option, value))
        self.run_volume("reversal", "readings.csv", "--axis", "X", "--date", "2024-02-29", "--reading-u", "1um")

    def test_semicolons_decimal_commas_and_micrometres_are_read_and_stated(self):
        self.write("plain.csv", "position,up1,up2,down1,down2\n100,0,0.0001,0.01,0.0101\n300,0.0001,0,0.0102,0.0101\n")
        self.write("other.csv", "Position (mm);Up1 (µm);Up2 (µm);Down1 (µm);Down2 (µm)\n100;0;0,1;10;10,1\n300;0,1;0;10,2;10,1\n")
        options = ("--axis", "X", "--json", "--reading-u", "0.1um")
        status, output, errors = volume("reversal", "other.csv", *options, cwd=self.folder)
        self.assertEqual(status, 0)
        found, plain = json.loads(output), json.loads(self.run_volume("reversal", "plain.csv", *options))
        self.assertAlmostEqual(found["lost_motion"], 0.01, 3)
        for name in ("lost_motion", "U"):
            self.assertAlmostEqual(found[name], plain[name], 12)
        self.assertIn("other.csv: taken as: separated by semicolons, decimal comma, position in mm, up1 in ", errors)

    def test_up_and_down_that_are_swapped_are_refused(self):
        """A table from them would double the error."""
        self.write("lead.csv", "position,up1,up2,down1,down2\n0,0.01,0.0101,0,0.0001\n100,0.02,0.0201,0,0.0001\n")
        reason = self.refused("reversal", "lead.csv", "--axis", "X", "--output", "x.csv")
        self.assertIn("lead.csv: position 0 mm: the lost motion is -10.00 um, so the table would lead. Are the columns up and down swapped, or does the indicator count down as X moves to its + end?", reason)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "x.csv")))
        output = self.run_volume("reversal", "lead.csv", "--axis", "X", "--leads", "--output", "x.csv")
        self.assertIn("from -20.00 um to -10.00 um along the travel", output)
        self.assertNotIn("On a circle", output)
        # Within its uncertainty the sign is open.
        self.write("small.csv", "position,up1,up2,down1,down2\n0,0.0001,0,0,0.0001\n100,0,0.0002,0,0.0001\n")
        self.run_volume("reversal", "small.csv", "--axis", "X")

    def test_reversal_along_a_short_stage_is_no_slope(self):
        """The play of 35 um is taken up within the first half millimetre of 8 mm; the mean changes by 3 um within one."""
        rows = ((0, 0, 0), (0.5, 0, 0.035), (1.5, 0.003, 0.038), (4, 0.001, 0.036), (7.5, 0, 0.035), (8, 0.035, 0.035))
        self.write("stage.csv", "position,up1,up2,down1,down2\n" + "".join("%g,%g,%g,%g,%g\n" % (x, up, up + 2e-4, down, down + 2e-4) for x, up, down in rows))
        for options in ((), ("--scale", "--scale-u", "1um/m")):
            self.assertIn("from 0.00 um to 35.00 um along the travel", self.run_volume("reversal", "stage.csv", "--axis", "X", "--output", "x.csv", *options))
        with plumb.Host() as host:
            for line in ("loadrt threads name1=t period1=1000000", "loadrt squareness names=square interlock=no chain=w-X.b-Y-Z-t table=" + os.path.join(self.folder, "x.csv"), "addf square.update t", "start"):
                host.command(line)
            for name, value in (("max-speed", 1e5), ("enable", True), ("all-homed", True), ("x-position", 7)):
                host.set("square." + name, value)
            host.run(0.2)
            host.set("square.x-position", 4)
            host.run(0.3)
            self.assertAlmostEqual(host.get("square.x-correction"), -0.0361, 4)
            self.assertFalse(host.get("square.fault"))

    def test_places_in_the_columns_of_readings_are_refused(self):
        self.write("places.csv", "position,up1,up2,down1,down2\n0,0,0.0001,0.01,0.0101\n100,100.003,100.0031,100.012,100.0121\n")
        self.assertIn("places.csv: line 3: column up1: '100.003' is the place that the axis reached; a reading is the place less the position, here 0.003", self.refused("reversal", "places.csv", "--axis", "X"))

    def test_a_drift_while_reading_is_named_and_is_in_the_uncertainty(self):
        def readings(drift):
            drawn = random.Random(7)
            rows = ["position," + ",".join("%s%d" % its for its in [(way, run) for way in ("up", "down") for run in range(5)])]
            for place in (0, 200, 400, 600, 800):
                rows.append("%d," % place + ",".join("%.6f" % (sign * 0.005 + drift * (run + half) + drawn.gauss(0, 0.0002)) for sign, half in ((-1, 0), (1, 0.5)) for run in range(5)))
            return self.write("drift.csv", "\n".join(rows) + "\n")

        still = json.loads(self.run_volume("reversal", readings(0), "--axis", "X", "--json"))
        moved = json.loads(self.run_volume("reversal", readings(0.002), "--axis", "X", "--json"))
        self.assertEqual(still["drift"], 0)
        self.assertAlmostEqual(moved["drift"], 0.002, 4)
        self.assertGreater(moved["U"], 2 * 0.002 / math.sqrt(3))  # the lost motion is off by 1 um
        self.assertLess(abs(moved["lost_motion"] - 0.010), moved["U"])
        self.assertIn("The readings drift by 2.0", " ".join(self.run_volume("reversal", "drift.csv", "--axis", "X").split()))

    def test_a_scale_needs_the_uncertainty_of_its_laser(self):
        options = ("reversal", self.readings(0.0002), "--axis", "X", "--scale", "--output", "x.csv")
        self.assertIn("The scale has no uncertainty", self.run_volume(*options))
        self.assertEqual(self.errors("--table", "x.csv")["EXX"][:2], ("unknown", None))
        self.run_volume(*options, "--scale-u", "0.8um/m")
        self.assertIn("# u-common: EXX 8e-07 per X\n", self.read("x.csv"))

    def test_a_tool_that_points_into_the_spindle_is_refused(self):
        self.assertIn("--tool: 'T3=0,0,200' points to +Z, into the spindle: a tool that is 200 mm long has -200", self.refused(*self.COLUMN[:5], "--tool", "T3=0,0,200"))

    def test_an_axis_that_linuxcnc_compensates_is_refused(self):
        self.write("my.ini", "[TRAJ]\nCOORDINATES = X Y Z\n[JOINT_0]\nBACKLASH = 0.01\n")
        self.assertIn("my.ini: line 4: 'BACKLASH = 0.01': LinuxCNC compensates X already", self.refused("reversal", self.readings(), "--axis", "X", "--ini", "my.ini"))
        self.run_volume("reversal", self.readings(), "--axis", "Y", "--ini", "my.ini", "--reading-u", "0.1um")

    def test_motor_encoder_against_a_scale_at_the_load(self):
        rows, load, at = ["motor,load"], 0, 0
        drawn = random.Random(5)
        for _ in range(60):
            to = drawn.uniform(0, 400)
            for step in range(100):
                motor = at + (to - at) * step / 100
                load = min(max(load, motor - 0.006), motor + 0.006)
                rows.append("%.5f,%.5f" % (motor, load))
            at = to
        self.write("log.csv", "\n".join(rows) + "\n")
        found = json.loads(self.run_volume("reversal", "log.csv", "--axis", "X", "--recording", "--json", "--reading-u", "0.1um"))
        self.assertEqual(len(found["rows"]), 7)
        for row in found["rows"]:
            self.assertAlmostEqual(row["lost_motion"], 0.012, 4)

    def ballbar(self, direction, opening=0.0, lost=0.0, name=None, head=""):
        rows = ["# plane: XY", "# radius: 100", "# feed: 3000", "# direction: " + direction, "# object: part" + head, "angle,radius"]
        turn = 1 if direction == "CCW" else -1
        for n in range(720):
            t = math.radians(n / 2)
            x, y = 100 * math.cos(t), 100 * math.sin(t)
            x -= opening * y + math.copysign(lost / 2, -turn * math.sin(t))
            rows.append("%g,%.6f" % (n / 2, math.hypot(x, y)))
        return self.write(name or direction + ".csv", "\n".join(rows) + "\n")

    def test_a_ballbar_gives_the_corner_and_the_lost_motion_with_their_signs(self):
        found = json.loads(self.run_volume("circle", self.ballbar("CCW", 50e-6, 0.01), self.ballbar("CW", 50e-6, 0.01), "--json"))
        self.assertAlmostEqual(found["opening"]["value"], 50e-6, 7)
        self.assertAlmostEqual(found["lost_motion_X"]["value"], 0.01, 4)
        self.assertAlmostEqual(found["lost_motion_Y"]["value"], 0, 4)
        self.assertAlmostEqual(found["G_b"], 0.01 + 0.005, 2)
        text = self.run_volume("circle", "CCW.csv")
        self.assertIn("opening of the corner, with lag", text)
        self.assertIn("Not seen: equal scales of both axes", text)
        # The same corner by the same part's diagonals.
        corner = subprocess.run([os.path.join(BUILD, "bin", "plumb-squareness"), "--json", "--chain", "w-X.b-Y-Z-C-t", "--diagonals",
                                 "plane=XY,object=part,rising=%.6fmm,falling=%.6fmm,u=1um" % (100 * math.sqrt(2) * (1 - 25e-6), 100 * math.sqrt(2) * (1 + 25e-6))],
                                capture_output=True, text=True, check=True)
        angle = [its for its in json.loads(corner.stdout)["settings"] if its["pin"] == "ec0y"][0]
        self.assertAlmostEqual(float(angle["value"]), 50e-6, 7)

    def test_the_opening_of_a_ballbar_is_entered_into_plumb_squareness(self):
        output = self.run_volume("circle", self.ballbar("CCW", 50e-6, 0.01), self.ballbar("CW", 50e-6, 0.01))
        words = [line for line in output.splitlines() if "--opening" in line][0].replace("CHAIN", "w-X.b-Y-Z-C-t").split()
        corner = subprocess.run([os.path.join(BUILD, "bin", "plumb-squareness"), *words[2:], "--json"], capture_output=True, text=True, check=True)
        angle = [its for its in json.loads(corner.stdout)["settings"] if its["pin"] == "ec0y"][0]
        self.assertAlmostEqual(float(angle["value"]), 50e-6, 7)
        self.assertIn("The angles of the clockwise path rise. They are read as places on the circle", " ".join(output.split()))
        alone = self.run_volume("circle", "CCW.csv")
        self.assertNotIn("--opening", alone)
        self.assertNotIn("The angles of", alone)
        body = self.run_volume("diagonals", "--box", "1000,1000,1000", "--deviations", "-10um,10um,10um,-10um", "--u", "1um")
        self.assertIn("--opening plane=XY,object=part,angle=17.32urad,u=0.866urad", body)

    def test_the_mean_radius_of_both_directions_is_stated(self):
        for direction in ("CCW", "CW"):
            text = self.read(self.ballbar(direction, lost=0.01))
            more = 0.004 if direction == "CCW" else 0.002
            self.write(direction + ".csv", "\n".join(line if line[0] in "#a" else "%s,%.6f" % (line.split(",")[0], float(line.split(",")[1]) + more) for line in text.splitlines()) + "\n")
        found = json.loads(self.run_volume("circle", "CCW.csv", "CW.csv", "--json"))
        self.assertAlmostEqual(found["D"] * 1000, 3, delta=0.02)
        self.assertIn("D, mean radius less nominal       3.00 um", self.run_volume("circle", "CCW.csv", "CW.csv"))
        self.assertNotIn("D", json.loads(self.run_volume("circle", "CCW.csv", "--json")))

    def test_wrong_ballbar_files_are_refused_with_line_and_value(self):
        self.assertIn("ring.csv: line 5: object: 'part of a ring' is not part; for a ring or ball", self.refused("circle", self.ballbar("CCW", name="ring.csv", head=" of a ring")))
        self.write("turn.csv", self.read(self.ballbar("CCW")).replace("CCW", "left"))
        self.assertIn("turn.csv: line 4: direction: 'left' is not CW or CCW", self.refused("circle", "turn.csv"))
        self.write("comma.csv", self.read("CCW.csv").replace("0.5,100.000000", "0.5,100,000"))
        self.assertIn("comma.csv: line 8: 3 values, but line 6 has 2 heads", self.refused("circle", "comma.csv"))
        self.write("half.csv", "\n".join(self.read("CCW.csv").splitlines()[:400]) + "\n")
        self.assertIn("half.csv: the counter-clockwise path covers 197 deg, and needs 330 deg", self.refused("circle", "half.csv"))
        self.assertIn("CCW.csv: both paths go in the same direction", self.refused("circle", "CCW.csv", "CCW.csv"))
        head, _end, points = self.read("CCW.csv").partition("angle,radius\n")
        points = [line.split(",") for line in points.split()]
        for name, changed, reason in (
            ("radians.csv", ["%.6f,%s" % (math.radians(float(a)), r) for a, r in points], "line 6: the angles go from 0 to 6.274459 only; are they in deg?"),
            ("deviation.csv", ["%s,%.6f" % (a, float(r) - 100) for a, r in points], "mm at 0 deg, 1 mm or more from the nominal 100"),
        ):
            self.write(name, head + "angle,radius\n" + "\n".join(changed) + "\n")
            self.assertIn(reason, self.refused("circle", name))
        self.write("feed.csv", self.read("CCW.csv").replace("feed: 3000", "feed: 0"))
        self.assertIn("feed.csv: line 3: feed: 0 is not above 0", self.refused("circle", "feed.csv"))
        self.write("radius.csv", self.read("CCW.csv").replace("radius: 100", "radius: 100 mm"))
        self.assertIn("radius.csv: line 2: radius: '100 mm' is no number", self.refused("circle", "radius.csv"))
        self.write("bare.csv", "angle,radius\n0,100\n")
        self.assertIn("bare.csv: the head does not state plane: write # plane: ...", self.refused("circle", "bare.csv"))

    def test_body_diagonals(self):
        output = self.run_volume("diagonals", "--box", "1000,1000,1000", "--deviations", "-10um,10um,10um,-10um", "--u", "1um")
        self.assertRegex(output, r"X to Y +17\.32 \+- 1\.73 urad")
        self.assertIn("Equal diagonals do not prove a good volume", " ".join(output.split()))

    def test_a_straightedge_that_is_turned_over(self):
        rows = ["position,before,turned"] + ["%d,%.6f,%.6f" % (x, 1e-7 * x * x + 0.002 * math.sin(x), -1e-7 * x * x + 0.002 * math.sin(x)) for x in range(0, 601, 50)]
        self.write("edge.csv", "\n".join(rows) + "\n")
        output = self.run_volume("straightedge", "edge.csv", "--error", "EYX", "--u", "0.5um", "--output", "x.csv")
        self.assertIn("Straightness EYX: 9.00 um, U of each value 0.71 um", output)
        self.assertRegex(self.read("x.csv"), r"\A# date: 20\d\d-\d\d-\d\d\n# u: EYX 0\.000353553391\n# by: straightedge\nX,EYX\n0,0\.0055\n")
        self.assertIn("'EXX' is no straightness", self.refused("straightedge", "edge.csv", "--error", "EXX", "--u", "1um"))
        for u in ("0um", "-1um", "5mm"):
            self.assertIn("--u: '%s' is not above 0 and below 1 mm" % u, self.refused("straightedge", "edge.csv", "--error", "EYX", "--u", u))
        self.assertIn("--date: 'x' is no date", self.refused("straightedge", "edge.csv", "--error", "EYX", "--u", "1um", "--date", "x"))
        self.write("um.csv", "position,before,turned\n0,9,0\n50,0,0\n100,0,0\n")
        self.assertIn("um.csv: position 50 mm: from 0.75 to -1.5 mm within 50 mm is too steep", self.refused("straightedge", "um.csv", "--error", "EYX", "--u", "1um"))

    def test_a_bore_and_a_boss_need_the_pre_travel(self):
        output = self.run_volume("block", "--bore", "30", "--measured", "27.018", "--ball", "3", "--pre-travel", "4um", "--pre-travel-u", "1um", "--u", "0.5um")
        self.assertIn("Lost motion: 10.00 um +- 4.24 um (k = 2)", output)
        self.assertIn("+- unknown: the pre-travel has no uncertainty", self.run_volume("block", "--boss", "30", "--measured", "32.982", "--ball", "3", "--pre-travel", "4um", "--u", "1um"))
        self.assertIn("--pre-travel: '-4um' is not 0 or more", self.refused("block", "--bore", "30", "--measured", "27.018", "--ball", "3", "--pre-travel", "-4um"))
        short = ("block", "--bore", "30", "--measured", "26.99", "--ball", "3", "--pre-travel", "4um", "--pre-travel-u", "1um", "--u", "1um")
        self.assertIn("The lost motion is negative: check the sizes", self.run_volume(*short))
        self.assertIn("give either --bore or --boss", self.refused("block", "--measured", "3", "--ball", "3", "--pre-travel", "4um"))

    def test_a_comp_file_becomes_a_table_and_comes_back(self):
        self.write("x.comp", "0 0 0.01\n100 -0.002 0.008\n200 -0.004 0.006\n")
        output = self.run_volume("import", "--from", "linuxcnc", "x.comp", "--axis", "X", "--type", "1", "--output", "x.csv")
        self.assertIn("At 200 mm, reached in + direction, X stands 4.00 um beyond its nominal place, towards its + end.", " ".join(output.split()))
        self.assertRegex(self.read("x.csv"), r"\A# imported from linuxcnc\n# date: 20\d\d-\d\d-\d\d\nX,EXX\+,EXX-\n0,0,-0\.01\n100,0\.002,-0\.008\n")
        self.run_volume("export", "--to", "linuxcnc", "x.csv", "--axis", "X", "--type", "1", "--output", "back.comp")
        self.assertEqual([[float(word) for word in line.split()] for line in self.read("back.comp").splitlines()], [[0, 0, 0.01], [100, -0.002, 0.008], [200, -0.004, 0.006]])
        self.run_volume("export", "--to", "rtl", "x.csv", "--axis", "X", "--output", "x.rtl")
        self.run_volume("import", "--from", "rtl", "x.rtl", "--axis", "X", "--output", "again.csv")
        self.assertEqual(self.read("again.csv").splitlines()[2:6], self.read("x.csv").splitlines()[2:6])
        zeroed = self.run_volume("import", "--from", "linuxcnc", "x.comp", "--axis", "X", "--output", "zero.csv", "--zero", "0", "--negate")
        self.assertIn("Written: zero.csv", zeroed)
        self.assertEqual(self.read("zero.csv").splitlines()[3], "0,-0.005,0.005")

    def test_wrong_files_write_nothing(self):
        self.write("bad.comp", "0 0 0\n100 0\n")
        self.assertIn("bad.comp: line 2: 2 values, not nominal, forward and reverse", self.refused("import", "--from", "linuxcnc", "bad.comp", "--axis", "X", "--output", "x.csv"))
        self.assertEqual(os.listdir(self.folder), ["bad.comp"])
        self.write("steep.comp", "0 0 0\n1 0.5 0.5\n")
        self.assertIn("is too steep", self.refused("import", "--from", "linuxcnc", "steep.comp", "--axis", "X"))
        self.assertIn("--axis: 'A' is none of X Y Z U V W", self.refused("import", "--from", "linuxcnc", "bad.comp", "--axis", "A"))
        self.write("um.comp", "0 0 10\n100 -2 8\n")
        self.assertIn("um.comp: position 0 mm: the directions differ by 10 mm, more than 0.2 mm", self.refused("import", "--from", "linuxcnc", "um.comp", "--axis", "X"))
        self.write("x.comp", "0 0 0.01\n100 -0.002 0.008\n")
        for place in ("nan", "101"):
            self.assertIn("the zero at %s mm is not within the positions of the table, 0 to 100 mm" % place, self.refused("import", "--from", "linuxcnc", "x.comp", "--axis", "X", "--zero", place))
        for option, value, reason in (("--unit", "um", "--unit: 'um' is none of mm and inch"), ("--error", "EBX", "--error: a COMP_FILE has the scale")):
            self.assertIn(reason, self.refused("import", "--from", "linuxcnc", "x.comp", "--axis", "X", option, value))
        self.assertEqual(volume("import", "--from", "mach4", "bad.comp", "--axis", "X", cwd=self.folder)[0], 2)
        self.assertIn("there is no option --axes", volume("import", "--from", "rtl", "bad.comp", "--axes", "X", cwd=self.folder)[2])

    def test_readings_of_another_kind_need_their_error_and_unit(self):
        text = "HEADER::\nType: Angular yaw\nTARGET DATA::\nTarget-count: 2\nTargets :\n0.0 100.0\nFlags: 0\nUSER-TEXT::\nRUNS::\nRun-count: 2\nDEVIATIONS::\nRun Target Data:\n1 1 0.0\n1 2 2.0\n2 2 3.0\n2 1 1.0\nENVIRONMENT::\nEOF::\n"
        self.write("yaw.rtl", text)
        given = ("import", "--from", "rtl", "yaw.rtl", "--axis", "X", "--output", "x.csv")
        self.assertIn("yaw.rtl: line 2: 'Type: Angular yaw' is no linear measurement: its unit is not um. Give --error and --unit", self.refused(*given))
        output = " ".join(self.run_volume(*given, "--error", "ECX", "--unit", "arcsec").split())
        self.assertIn("At 100 mm, reached in + direction, X turns by 9.70 urad about Z, positive by the right hand.", output)
        self.assertIn("X,ECX+,ECX-\n0,0,4.8481368", self.read("x.csv"))
        for options, reason in (
            (("--error", "ECX"), "--error: give the unit of ECX by --unit, urad, mrad or arcsec"),
            (("--error", "EYX", "--unit", "urad"), "--error: give the unit of EYX by --unit, um"),
            (("--error", "ECY", "--unit", "urad"), "--error: 'ECY' is no error of X, as EXX"),
            (("--unit", "arcsec"), "--unit: 'arcsec' is no unit of the scale EXX: give --error, as EBX"),
            (("--unit", "inch"), "--unit: 'inch' is none of um, urad, mrad and arcsec"),
            (("--type", "0"), "--type is for a COMP_FILE of LinuxCNC"),
        ):
            self.assertIn(reason, self.refused(*given, *options))
        self.write("side.rtl", text.replace("Angular yaw", "Straightness"))
        self.run_volume("import", "--from", "rtl", "side.rtl", "--axis", "X", "--output", "x.csv", "--error", "EYX", "--unit", "um")
        self.assertIn("X,EYX+,EYX-\n0,0,0.001\n100,0.002,0.003\n", self.read("x.csv"))
        for unit in ("mrad",):
            self.run_volume(*given, "--error", "ECX", "--unit", unit)
            self.assertIn("X,ECX+,ECX-\n0,0,0.001\n100,0.002,0.003\n", self.read("x.csv"))
        self.write("mm.rtl", text.replace("Angular yaw", "linear").replace("2.0", "0.002").replace("3.0", "0.003").replace("2 1 1.0", "2 1 0.001"))
        self.assertIn("mm.rtl: the largest reading is 0.003 um; are the readings in um, not mm?", self.refused("import", "--from", "rtl", "mm.rtl", "--axis", "X"))

    def rtl(self, targets, flags, *runs):
        """Runs of (target, reading in um)."""
        lines = "".join("%d %d %g\n" % (run, target, value) for run, its in enumerate(runs, 1) for target, value in its)
        return self.write("z.rtl", "HEADER::\nTARGET DATA::\nTarget-count: %d\nTargets :\n%s\nFlags: %s\nUSER-TEXT::\nRUNS::\nRun-count: %d\nDEVIATIONS::\nRun Target Data:\n%sENVIRONMENT::\nEOF::\n"
                          % (len(targets), " ".join(map(str, targets)), flags, len(runs), lines))

    def test_targets_of_an_rtl_may_fall(self):
        """The Z of a mill: a run along falling targets is a motion to the - end."""
        self.rtl((0, -40, -90), "0 0 2 0", [(1, 0.2), (2, 1.2), (3, 2.4)], [(3, 5.4), (2, 4.2), (1, 3.2)])
        self.run_volume("import", "--from", "rtl", "z.rtl", "--axis", "Z", "--output", "z.csv")
        self.assertIn("Z,EZZ+,EZZ-\n-90,0.0054,0.0024\n-40,0.0042,0.0012\n0,0.0032,0.0002\n", self.read("z.csv"))
        self.rtl((0, -40, -30), "0 0 2 0", [(1, 0)])
        self.assertIn("z.rtl: line 5: -30 is not beyond -40: targets rise or fall", self.refused("import", "--from", "rtl", "z.rtl", "--axis", "Z"))

    def test_runs_of_an_rtl_that_all_go_the_same_way_show_no_lost_motion(self):
        up = [[(1, 0.1), (2, 1.1), (3, 2.1)], [(1, 0.3), (2, 1.3), (3, 2.3)], [(1, 0.2), (2, 1.2), (3, 2.2)]]
        back = [(3, 0), (2, 0), (1, 0)]
        expected = ("X,EXX\n0,0.0002\n400,0.0012\n800,0.0022\n", "EXX alone")
        for runs in (up, [up[0], back, up[1], back, up[2], back]):
            self.rtl((0, 400, 800), "0 1 2 0", *runs)
            taken = ("import", "--from", "rtl", "z.rtl", "--axis", "X", "--output", "x.csv")
            output = self.run_volume(*taken)
            self.assertIn("All runs go the same way: the lost motion is unknown.", output)
            self.assertIn("The scale has no uncertainty, so it counts as unknown.", output)
            self.assertIn("without u", self.errors("--table", "x.csv")["EXX"][2])
            self.assertNotIn("The scale has no", self.run_volume(*taken, "--scale-u", "0.8um/m"))
            self.assertIn("# u-common: EXX 8e-07 per X\n", self.read("x.csv"))
            self.assertIn(expected[0], self.read("x.csv"))
            self.assertNotIn("EXX+", self.read("x.csv"))
            u = float(self.read("x.csv").partition("# u: EXX ")[2].split()[0])
            self.assertGreater(u, 0.0001 / math.sqrt(3))  # of the mean of three, widened for few readings
            found = self.errors("--table", "x.csv")
            self.assertEqual((found["EXX"][0], found["lost motion X"][0]), ("measured", "unknown"))
        self.assertIn("--scale-u is for the scale in an .rtl", self.refused(*taken, "--error", "ECX", "--unit", "urad", "--scale-u", "0.8um/m"))
        self.rtl((0, 400, 800), "0 1 2 0", up[0], [(3, 5), (2, 4), (1, 3)])
        self.assertIn("z.rtl: line 17: Flags state that all runs go the same way, but run 2 comes back with readings", self.refused("import", "--from", "rtl", "z.rtl", "--axis", "X"))

    ISG = "// laser, 2024\nX EYX EXX // mm\n0 0.001 0\n100 0.002 0.004\n200 0 0.006\n#\nY EYY\n0 0\n50 0.001\n"
    COM = "BEGIN X.COM MM\nNR AXISPOS BACKLASH X\n0 -100 0.005 -0.005\n1 0 0.004 -0.004\n[END]\n"
    CEC = "".join("$AN_CEC_%s[%d]=%s\n" % (key, t, value) for t, way in ((0, 1), (1, -1)) for key, value in (("INPUT_AXIS", "(AX1)"), ("OUTPUT_AXIS", "(AX1)"), ("STEP", 50), ("MIN", -50), ("MAX", 50), ("DIRECTION", way), ("IS_MODULO", 0))) \
        + "".join("$AN_CEC[%d,%d]=%g ; note\n" % (t, n, 0.001 * n - sign * 0.003) for t, sign in ((0, 1), (1, -1)) for n in range(3)) + "M17\n"

    def test_tables_of_other_controls_are_read(self):
        for kind, text, rows, error in (
            ("isg", self.ISG, "X,EXX\n0,0\n100,0.004\n200,0.006\n", None), ("isg", self.ISG, "X,EYX\n0,0.001\n100,0.002\n200,0\n", "EYX"),
            ("heidenhain", self.COM, "X,EXX+,EXX-\n-100,-0.005,0.005\n0,-0.004,0.004\n", None), ("cec", self.CEC, "X,EXX+,EXX-\n-50,-0.003,0.003\n0,-0.002,0.004\n50,-0.001,0.005\n", None),
        ):
            self.write("table", text)
            output = self.run_volume("import", "--from", kind, "table", "--axis", "X", "--output", "x.csv", *(("--error", error) if error else ()))
            self.assertIn(rows, self.read("x.csv"), kind)
            self.assertIn("Sign: E", output)
            self.write("table", text.replace("\n", "\r\n"))
            self.run_volume("import", "--from", kind, "table", "--axis", "X", "--output", "dos.csv", *(("--error", error) if error else ()))
            self.assertEqual(self.read("dos.csv"), self.read("x.csv"))

    def test_tables_come_back_from_other_controls(self):
        self.write("x.csv", "X,EXX+,EXX-,EAX\n0,0.001,0.003,1e-6\n50,0.002,0.005,0\n100,0,0.001,0\n# end, 3 rows\n")
        for kind in ("heidenhain", "cec"):
            status, _output, errors = volume("export", "--to", kind, "x.csv", "--axis", "X", "--output", "other", cwd=self.folder)
            self.assertEqual(status, 0, errors)
            self.assertIn("Not in the file, which holds EXX: EAX", errors)
            self.run_volume("import", "--from", kind, "other", "--axis", "X", "--output", "again.csv")
            self.assertIn("X,EXX+,EXX-\n0,0.001,0.003\n50,0.002,0.005\n100,0,0.001\n", self.read("again.csv"))
        self.assertIn("the difference by direction;", volume("export", "--to", "isg", "x.csv", "--axis", "X", "--output", "other", cwd=self.folder)[2])
        self.run_volume("import", "--from", "isg", "other", "--axis", "X", "--output", "again.csv")
        self.assertIn("X,EXX\n0,0.002\n50,0.0035\n100,0.0005\n", self.read("again.csv"))
        volume("export", "--to", "isg", "x.csv", "--axis", "X", "--error", "EAX", "--output", "other", cwd=self.folder)
        self.run_volume("import", "--from", "isg", "other", "--axis", "X", "--error", "EAX", "--output", "again.csv")
        self.assertIn("X,EAX\n0,1e-06\n50,0\n100,0\n", self.read("again.csv"))
        self.write("uneven.csv", "X,EXX\n0,0\n30,0.003\n100,0\n# end, 3 rows\n")
        self.assertIn("the uneven places, for 15 even steps;", volume("export", "--to", "cec", "uneven.csv", "--axis", "X", "--output", "other", cwd=self.folder)[2])

    def test_wrong_tables_of_other_controls_are_refused_with_line_and_value(self):
        for kind, text, reason in (
            ("isg", self.ISG.replace("0.004", "0,004"), "line 4: '0,004' is no number; the decimal mark is a point"), ("isg", self.ISG.replace("200 0 0.006", "200 0"), "line 5: 2 values, but 3 names stand above"),
            ("isg", self.ISG.replace("X EYX", "Z X EYX").replace("\n0 ", "\n0 0 "), "line 2: EXX depends on Z, too: plumb volume takes tables of one axis"), ("isg", "0 1 2\n", "line 1: numbers without a line of names before them"),
            ("isg", self.ISG.replace("EXX", "EZX"), "there is no column EXX"), ("isg", self.ISG.replace("100 0.002", "0 0.002"), "line 4: 0 is not beyond 0"),
            ("isg", self.ISG.replace("0.006", "6"), "position 200 mm: from 0.004 to 6 mm within 100 mm is too steep"),
            ("heidenhain", self.COM.replace(" MM", " INCH"), "line 1: 'BEGIN X.COM INCH' is not in MM"), ("heidenhain", self.COM.replace("AXISPOS", "POS"), "line 2: there is no column AXISPOS"),
            ("heidenhain", self.COM.replace("BACKLASH X", "BACKLASH Z"), "line 2: there is no column X, which has EXX"), ("heidenhain", self.COM.replace("1 0 0.004", "1 0"), "line 4: 3 values, but the table has 4 columns"),
            ("heidenhain", self.COM + "2 5 0 0\n", "line 6: a line behind [END]"),
            ("cec", self.CEC.replace("$AN_CEC[1,2]=0.005 ; note\n", ""), "there is no $AN_CEC[1,2]"), ("cec", self.CEC.replace("STEP[0]=50", "STEP[0]=30"), "line 5: from -50 to 50 mm there are no whole steps of 30 mm"),
            ("cec", self.CEC.replace("DIRECTION[0]=1", "DIRECTION[0]=2"), "line 6: a direction of 2 is none of 0, 1 and -1"), ("cec", self.CEC.replace("IS_MODULO[1]=0", "IS_MODULO[1]=1"), "line 14: '$AN_CEC_IS_MODULO[1]=1': only tables of a travel"),
            ("cec", self.CEC.replace("AX1", "AX2"), "there is no table from X to X, which has EXX"), ("cec", self.CEC.replace("$AN_CEC[0,1]", "$AN_CEC[0,7]"), "N 7 is beyond the last step, 2"),
            ("cec", self.CEC.replace("$AN_CEC[0,1]", "$AN_CEC[0,0]"), "'$AN_CEC[0,0]' is there twice"), ("cec", self.CEC.replace("=-0.003", "=-0,003"), "is no number; the decimal mark is a point"),
        ):
            self.write("table", text)
            self.assertIn("table: " + (reason if reason.startswith(("line", "there", "position")) else ""), self.refused("import", "--from", kind, "table", "--axis", "X"), kind)
            self.assertIn(reason, self.refused("import", "--from", kind, "table", "--axis", "X"))
        for kind in ("heidenhain", "cec"):
            self.assertIn("--error: 'EAX' is an angle, and this file has lengths alone", self.refused("import", "--from", kind, "table", "--axis", "X", "--error", "EAX"))
        self.assertIn("--unit: 'um' is none of mm: the file has mm and rad", self.refused("import", "--from", "isg", "table", "--axis", "X", "--unit", "um"))

    COLUMN = ("uncertainty", "--chain", "w-X.b-Y-Z-t", "--box", "X=0:800,Y=0:600,Z=-500:0", "--tool", "T3=0,0,-200")

    def test_the_whole_is_stated_in_one_line(self):
        self.write("x.csv", "# u: EXX 0.0005\n# u-common: EXX 2e-6 per X\nX,EXX\n0,0\n400,0.003\n800,0\n# end, 3 rows\n")
        arguments = (*self.COLUMN, "--tilt", "EC0Y=-80urad,u=4urad", "--table", "x.csv", "--repeatability", "X=0.3um")
        output = " ".join(self.run_volume(*arguments).split())
        self.assertRegex(output, r"After correction: at least \+- \d\.\d um \(k = 2\) over [\d.]+ m, worst at X 800 Y 600 Z (-500|-250|0) with T3\. Largest share: EC0Y, \d\d %\.")
        self.assertIn("Not corrected, and not in U: the orientation of the tool", output)
        found = json.loads(self.run_volume(*arguments, "--json"))
        self.assertEqual(len(found["places"]), 27)
        self.assertAlmostEqual(sum(share["part"] for share in found["shares"]), 1)
        # X 800, Y 600: 4 urad of 600 mm, rows of 0.5 um at both ends, 2 um/m of 800 mm, twice the repeatability.
        expected = 2 * math.sqrt(0.0024**2 + 2 * 0.0005**2 + 0.0016**2 + 2 * 0.0003**2)
        self.assertAlmostEqual(found["U"], expected, delta=0.05 * expected)
        self.assertEqual(json.loads(self.run_volume(*arguments, "--json"))["U"], found["U"])

    def errors(self, *arguments):
        """The list of errors by name: (state, u in mm or rad, source)."""
        return {its["name"]: (its["state"], its["u"], its["by"]) for its in json.loads(self.run_volume(*self.COLUMN, *arguments, "--json"))["errors"]}

    def test_an_error_that_was_never_measured_is_unknown_and_no_zero(self):
        output = " ".join(self.run_volume(*self.COLUMN, "--tilt", "EC0Y=-80urad").split())
        self.assertIn("After correction: U is unknown, for no error has an uncertainty. 30 of 30 errors are unknown, the first of them XY. To measure XY: square and indicator", output)
        self.assertIn("XY unknown EC0Y, without u; measure by: square and indicator", output)
        self.write("x.csv", "X,EXX+,EXX-\n0,0,0\n800,0,0.001\n# end, 2 rows\n")
        tilt = ("--tilt", "EC0Y=1urad,u=1urad,date=2026-11-20,by=square")
        output = " ".join(self.run_volume(*self.COLUMN, *tilt, "--table", "x.csv").split())
        self.assertIn("After correction: at least +- 1.2 um (k = 2)", output)
        self.assertIn("29 of 30 errors are unknown, the first of them XZ. To measure XZ:", output)
        self.assertNotRegex(output, r"\b0\.0+ um|\+- 0\b")
        found = self.errors(*tilt, "--table", "x.csv")
        self.assertEqual(found["XY"], ("measured", 1e-6, "EC0Y (square, 2026-11-20)"))
        self.assertEqual(found["EXX"], ("unknown", None, "x.csv, no date, without u"))
        self.assertEqual(found["lost motion X"], ("unknown", None, "x.csv, no date, without u"))
        self.assertEqual(sum(its[0] == "unknown" for its in found.values()), 29)
        self.assertIsNone(json.loads(self.run_volume(*self.COLUMN, "--table", "x.csv", "--json"))["U"])
        # A u of 0 is none.
        self.write("x.csv", "# u: EXX 0\nX,EXX\n0,0\n800,0\n# end, 2 rows\n")
        self.assertEqual(self.errors("--table", "x.csv")["EXX"][0], "unknown")
        self.assertEqual(self.errors("--tilt", "EC0Y=1urad,u=0urad")["XY"][0], "unknown")

    def test_a_corner_is_measured_by_any_tilt_that_opens_it(self):
        """On w-Y.b-X-Z-t the square of Z may have turned X, too; the covariance of one square counts."""
        gantry = ("uncertainty", "--chain", "w.b-X-Y-Z-t", *self.COLUMN[3:], "--json")
        one = json.loads(self.run_volume(*gantry, "--tilt", "EC0Y=9urad,u=0urad", "--tilt", "EC0X=5urad,u=0urad", "--common", "square,EC0Y=1,EC0X=1,u=3urad"))["errors"][0]
        self.assertEqual((one["name"], one["state"]), ("XY", "measured"))
        self.assertAlmostEqual(one["u"], 3e-6, 12)  # EC0X turns Y with it: the corner opens by EC0Y alone
        # W carries Z, and is neither X nor Z.
        rail = json.loads(self.run_volume("uncertainty", "--chain", "w-X.b-Y-W-Z-t", "--box", "X=0:800,Y=0:600,Z=-500:0,W=300", *self.COLUMN[5:], "--tilt", "EB0W=3urad,u=1urad", "--json"))
        self.assertEqual([(its["name"], its["state"]) for its in rail["errors"]][1], ("XZ", "unknown"))

    SHEET = "error,u,source\nEYX,3um,maker's sheet, page 4\nsecond axis,2um,level at both ends of Z\nbending,5urad/K,maker's sheet\n"

    def test_a_class_and_a_sheet_fill_the_list_with_their_source(self):
        self.write("sheet.csv", self.SHEET)
        options = ("--assume", "sheet.csv", "--assume", "iso-10791", "--temperature", "23degC")
        found = self.errors(*options)
        self.assertEqual({its[0] for its in found.values()}, {"assumed", "measured"})
        self.assertEqual(found["EYX"], ("assumed", 0.003, "maker's sheet, page 4"))
        self.assertEqual(found["XZ"], ("assumed", 2e-5, "ISO 10791, 20 um over 500 mm"))
        self.assertEqual(found["EZX"][2], "ISO 10791, 15 um, travel to 800 mm")
        self.assertAlmostEqual(found["bending"][1], 5e-6 * math.hypot(3, 0.3))
        self.assertEqual(found["growth"][0], "measured")
        output = " ".join(self.run_volume(*self.COLUMN, *options).split())
        self.assertRegex(output, r"After correction: \+- \d\d um \(k = 2\) over")
        self.assertNotIn("unknown", output)
        self.assertEqual(self.errors("--assume", "iso-10791")["second axis"][0], "unknown")  # ISO has none
        self.assertEqual(self.errors("--assume", "sheet.csv")["bending"], ("unknown", None, "the temperature is not known"))
        # A measured line stays.
        self.assertEqual(self.errors("--tilt", "EC0Y=1urad,u=1urad", "--assume", "iso-10791")["XY"][:2], ("measured", 1e-6))
        self.assertEqual(self.errors("--assume", "iso-10791", "--assume", "sheet.csv")["EYX"][2], "ISO 10791, 15 um, travel to 800 mm")  # the first one
        self.write("corner.csv", "error,u,source\nXY,9urad,maker's sheet\n")
        self.assertEqual(self.errors("--tilt", "EC0Y=1urad,u=1urad", "--assume", "corner.csv")["XY"][:2], ("measured", 1e-6))

    def test_an_assumed_line_counts_as_a_measured_one_would(self):
        """Each line alone, against the closed form at X 800 Y 600 Z 0 of a distance from X 0 Y 0 Z -500."""
        r2 = math.sqrt(2)
        for line, u, expected in (("XY", "4urad", 4e-6 * 600), ("YZ", "4urad", 4e-6 * 500), ("EXX", "1um", r2 * 1e-3), ("EYX", "1um", r2 * 1e-3), ("lost motion X", "2um", r2 * 1e-3),
                                  ("repeatability Y", "1um", r2 * 1e-3), ("second axis", "1um", r2 * 1e-3), ("EXZ", "2um", r2 * 2e-3), ("growth", "10um/m", 10e-6 * 800)):
            self.write("one.csv", "error,u,source\n%s,%s,test\n" % (line, u))
            found = self.sure_of("--assume", "one.csv")
            place = next(its for its in found["places"] if its["at"] == [800, 600, 0])
            self.assertAlmostEqual(max(place["U_axis"]) / (2 * expected), 1, delta=0.06, msg=line)
            self.assertTrue(found["at_least"])

    def test_wrong_sheets_are_refused_with_line_and_value(self):
        head = "error,u,source\n"
        for text, reason in (("EYX,3um,sheet\n", "line 1: 'EYX,3um,sheet' is not the head error,u,source"), (head + "EYX,3um\n", "line 2: 'EYX,3um' has no source"),
                             (head + "EYX,3um,\n", "line 2: 'EYX,3um,' has no source: without one the error stays unknown"), (head + "EYQ,3um,sheet\n", "line 2: 'EYQ' is no error of this chain"),
                             (head + "EYX,3urad,sheet\n", "line 2: EYX: '3urad' has an unknown unit"), (head + "XY,0urad,sheet\n", "line 2: XY: '0urad' is no u above 0"), ("", "there is no line error,u,source in it")):
            self.write("sheet.csv", text)
            self.assertIn("sheet.csv: " + reason, self.refused(*self.COLUMN, "--assume", "sheet.csv"))
        self.assertIn("no/such.csv", self.refused(*self.COLUMN, "--assume", "no/such.csv"))

    def test_the_repeatability_that_reversal_measured_is_in_U(self):
        self.run_volume("reversal", self.readings(0.001), "--axis", "X", "--output", "x.csv")
        measured = json.loads(self.run_volume("reversal", "readings.csv", "--axis", "X", "--json"))["repeatability"]
        found = self.errors("--table", "x.csv")
        self.assertAlmostEqual(found["repeatability X"][1], measured, 9)
        self.assertIn("# by: readings from both sides\n", self.read("x.csv"))
        self.assertEqual(found["lost motion X"], ("unknown", None, "x.csv ends at 100 and 500 mm"))
        shares = {its["of"]: its["part"] for its in self.sure_of("--table", "x.csv")["shares"]}
        self.assertGreater(shares["repeatability"], 0.3)

    def sure_of(self, *arguments):
        return json.loads(self.run_volume(*self.COLUMN, "--json", *arguments))

    def dated(self, head):
        return self.write("x.csv", "# u: EXX 0.0005\n" + head + "X,EXX\n0,0\n800,0\n# end, 2 rows\n")

    def test_a_measurement_ages(self):
        fresh = self.sure_of("--table", self.dated("# date: 2026-01-01\n# drift: EXX 2e-6 per X\n"), "--today", "2026-01-01")
        self.assertEqual(fresh["notes"], [])
        self.assertAlmostEqual(fresh["U"], 2 * math.sqrt(2) * 0.0005, delta=1e-4)
        half = self.sure_of("--table", "x.csv", "--today", "2026-07-02")  # 182 days
        expected = 2 * math.hypot(math.sqrt(2) * 0.0005, 800 * 2e-6 * 182 / 365.25)
        self.assertAlmostEqual(half["U"], expected, delta=0.05 * expected)
        self.assertEqual(half["notes"], [])
        old = self.sure_of("--table", "x.csv", "--today", "2028-01-01")
        self.assertEqual([(its["kind"], its["of"], its["first"], its["second"]) for its in old["notes"]], [("old", "X", 730, 365)])
        self.assertIn("x.csv is 730 days old, and valid for 365: measure again.", " ".join(self.run_volume(*self.COLUMN, "--table", "x.csv", "--today", "2028-01-01").split()))
        unset = self.sure_of("--table", "x.csv", "--today", "1970-01-01")  # the clock is not set: a year is added
        self.assertEqual([its["kind"] for its in unset["notes"]], ["age-unknown"])
        self.assertAlmostEqual(unset["U"], 2 * math.hypot(math.sqrt(2) * 0.0005, 800 * 2e-6 * 365 / 365.25), delta=2e-4)
        worn = self.sure_of("--table", self.dated("# date: 2026-01-01\n# valid-for: 30 d\n"), "--today", "2026-03-01")
        self.assertEqual([(its["state"], its["by"]) for its in worn["errors"] if its["name"] == "drift X"], [("unknown", "an old table without # drift")])
        self.assertIn("x.csv: line 2: valid-for has no form as 365 d", self.refused(*self.COLUMN, "--table", self.dated("# valid-for: a year\n")))
        tilt = self.sure_of("--tilt", "EC0Y=1urad,u=1urad,drift=4urad,date=2024-01-01", "--today", "2026-01-01")
        self.assertAlmostEqual(tilt["U"], 2 * 0.0006 * math.hypot(1, 4 * 731 / 365.25), delta=2e-4)
        self.assertEqual(tilt["notes"][0]["first"], 731)
        line = next(its for its in tilt["errors"] if its["name"] == "drift EC0Y")
        self.assertEqual((line["unit"], line["by"]), ("rad", "--tilt, 731 days"))
        self.assertAlmostEqual(line["u"], 4e-6 * 731 / 365.25)
        listed = self.run_volume(*self.COLUMN, "--tilt", "EC0Y=1urad,u=1urad,drift=2urad,date=2025-12-22", "--today", "2026-01-01")
        self.assertRegex(listed, r"drift EC0Y +0\.0548 urad measured: --tilt, 10 days")

    def test_tables_have_the_date_of_their_measurement(self):
        self.write("x.comp", "0 0 0.01\n800 0 0.01\n")
        os.utime(os.path.join(self.folder, "x.comp"), (1768000000, 1768000000))  # 2026-01-09
        output = " ".join(self.run_volume("import", "--from", "linuxcnc", "x.comp", "--axis", "X", "--output", "x.csv").split())
        self.assertIn("# date: 2026-01-0", self.read("x.csv"))
        self.assertIn("Date: 2026-01-0", output)
        self.assertIn("of the last change of the file. If the axis was measured earlier, give --date.", output)
        output = self.run_volume("import", "--from", "linuxcnc", "x.comp", "--axis", "X", "--output", "x.csv", "--date", "2025-06-30")
        self.assertIn("# date: 2025-06-30\n", self.read("x.csv"))
        self.assertNotIn("Date:", output)
        self.assertEqual([its["kind"] for its in self.sure_of("--table", "x.csv", "--today", "2028-01-01")["notes"]], ["old"])
        self.assertIn("--date: 'June' is no date", self.refused("import", "--from", "linuxcnc", "x.comp", "--axis", "X", "--date", "June"))
        self.run_volume("reversal", self.readings(), "--axis", "X", "--output", "r.csv", "--date", "2025-07-01", "--reading-u", "0.1um")
        self.assertIn("# date: 2025-07-01\n", self.read("r.csv"))
        self.run_volume("reversal", "readings.csv", "--axis", "X", "--into", "x.csv", "--output", "both.csv", "--reading-u", "0.1um")
        self.assertIn("# date: 2025-06-30\n", self.read("both.csv"))  # as old as its older part

    def test_an_unknown_direction_adds_half_of_the_lost_motion(self):
        self.write("x.csv", "# u: EXX 0, EXX+ 0.0001\nX,EXX+,EXX-\n0,-0.004,0.004\n800,-0.005,0.005\n# end, 2 rows\n")
        found = self.sure_of("--table", "x.csv")
        self.assertAlmostEqual(found["unknown_direction"], 0.005, 6)
        self.assertLess(found["rest"], 1e-6)
        places = {tuple(its["at"]): its["unknown_direction"] for its in found["places"]}
        self.assertAlmostEqual(places[0, 0, 0], 0.004, 6)
        output = " ".join(self.run_volume(*self.COLUMN, "--table", "x.csv").split())
        self.assertRegex(output, r"While a direction of motion is not known: at least \+- 5\.\d um, with up to 5\.0 um of lost motion\.")
        self.write("y.csv", "# u: EYY 0.0001\nY,EYY\n0,0\n600,0\n# end, 2 rows\n")
        self.assertNotIn("direction of motion is not known", self.run_volume(*self.COLUMN, "--table", "y.csv"))

    def test_a_table_that_ends_within_the_work_space_is_named(self):
        self.write("x.csv", "# u: EXX 0.0005\nX,EXX\n100,0\n800,0\n# end, 2 rows\n")
        self.assertEqual([(its["kind"], its["of"], its["first"], its["second"]) for its in self.sure_of("--table", "x.csv")["notes"]], [("table-ends", "X", 100, 800)])
        output = " ".join(self.run_volume(*self.COLUMN, "--table", "x.csv").split())
        self.assertIn("The table of X in x.csv ends at 100 and 800 mm, within the work space", output)
        self.assertEqual(self.errors("--table", "x.csv")["EXX"], ("unknown", None, "x.csv ends at 100 and 800 mm"))
        self.assertIn("2000 machines drawn, seed 1.", output)
        self.write("x.csv", "# u: EXX 0.0005\nX,EXX\n0,0\n800,0\n# end, 2 rows\n")
        self.assertEqual(self.sure_of("--table", "x.csv")["notes"], [])

    def test_a_fast_circle_is_foretold(self):
        output = " ".join(self.run_volume("turn", "--lost-motion", "10um", "--feed", "3000", "--radius", "50", "--allowed", "2um").split())
        self.assertIn("F3000 on R50 keeps 4.69 um of the lost motion of 10.00 um", output)
        self.assertIn("G: 10.00 um without correction, 4.69 um with it.", output)
        self.assertNotIn("comes late", output)
        self.assertRegex(output, r"R25 F\d+ R50 F\d+ R100 F\d+")
        self.assertIn("The turn comes late", self.run_volume("turn", "--lost-motion", "10um", "--feed", "5000", "--radius", "25"))
        self.assertEqual(volume("turn", "--lost-motion", "10um", "--feed", "3000", cwd=self.folder)[0], 2)
        for option, value, reason in (("--lost-motion", "1mm", "not above 0 and up to 200 um"), ("--lost-motion", "0um", "not above 0"),
                                      ("--allowed", "-2um", "not above 0"), ("--distance", "1mm", "not above 0 and up to 100 um")):
            given = {"--lost-motion": "10um", option: value}
            self.assertIn("%s: '%s' is %s" % (option, value, reason), self.refused("turn", *[word for pair in given.items() for word in pair]))
        self.assertIn("R10    none: reversal-distance alone keeps more", self.run_volume("turn", "--lost-motion", "10um", "--allowed", "0.1um"))

    def test_rotary_axes_stand_at_0_and_are_named(self):
        self.write("c.csv", "C,EXC\n0,0\n360,0\nX,EXX\n0,0\n800,0\n# end, 4 rows\n")
        tilt = ("--tilt", "EC0Y=1urad,u=1urad", "--table", "c.csv")
        trunnion = json.loads(self.run_volume("uncertainty", "--chain", "w-C-A-X.b-Y-Z-t", *self.COLUMN[3:], "--json", *tilt))
        self.assertEqual([(its["kind"], its["of"]) for its in trunnion["notes"]], [("rotary", "A, C")])
        self.assertEqual(list(trunnion["tables"]), ["X"])
        self.assertEqual(trunnion["places"], self.sure_of(*tilt)["places"])
        self.assertEqual([its["of"] for its in self.sure_of(*tilt)["notes"]], ["C"])
        self.assertEqual(json.loads(self.run_volume("uncertainty", "--chain", "w-X.b-Y-Z-C-t", *self.COLUMN[3:], "--json", *tilt[:2]))["notes"], [])
        self.assertIn("c.csv: line 1: plumb volume takes no table of a rotary axis here", self.refused("export", "--to", "rtl", "c.csv", "--axis", "X"))

    def test_a_clamped_rail_has_its_place(self):
        self.write("w.csv", "# u: ECW 1e-6\nW,ECW\n0,0\n300,5e-5\n# end, 2 rows\n")

        def diagonal(*place):
            box = ",".join(("X=0:800,Y=0:600,Z=-500:0", *place))
            return json.loads(self.run_volume("uncertainty", "--chain", "w-X.b-W-Y-Z-t", "--box", box, "--table", "w.csv", "--json"))["diagonals"][0]["without"]
        self.assertAlmostEqual(diagonal(), 0, 9)
        self.assertAlmostEqual(diagonal("W=300"), -5e-5 * 800 * 600 / math.sqrt(800**2 + 600**2 + 500**2), 5)  # Y turns, X does not
        self.assertIn("--box: 'W=x' has no form as W=300", self.refused("uncertainty", "--chain", "w-X.b-W-Y-Z-t", "--box", "X=0:8,Y=0:6,Z=0:5,W=x", "--table", "w.csv"))
        self.assertIn("names an axis that the chain does not have", self.refused("uncertainty", "--chain", "w-X.b-Y-Z-t", "--box", "X=0:8,Y=0:6,Z=0:5,W=3"))

    def test_a_table_of_another_temperature_is_less_sure(self):
        """Without a threshold. A screw grows by 0 to 11.5 um/m for each K, and a thermometer is off by 0.3 K."""
        self.dated("# temperature: 20 degC\n")
        at = {place: next(i for i, its in enumerate(self.sure_of("--table", "x.csv")["places"]) if its["at"] == list(place)) for place in ((800, 0, -500),)}
        for now in (20, 20.5, 24.9, 25.2, 26, 14):
            found = self.sure_of("--table", "x.csv", "--temperature", "%gdegC" % now)
            expected = 2 * math.hypot(math.sqrt(2) * 0.0005, 800 * 11.5e-6 / math.sqrt(3) * math.hypot(now - 20, 0.3))
            self.assertAlmostEqual(found["places"][at[800, 0, -500]]["U_axis"][0] / expected, 1, delta=0.06)
            self.assertEqual(next(its["state"] for its in found["errors"] if its["name"] == "growth"), "measured")
        self.dated("")
        self.assertEqual(self.errors("--table", "x.csv", "--temperature", "26degC")["growth"][0], "unknown")
        self.assertIn("has no form as 24degC", self.refused(*self.COLUMN, "--table", "x.csv", "--temperature", "hot"))

    def test_a_tilt_displaces_nothing_at_its_pivot(self):
        corner = ("--tilt", "EC0Y=-80urad,u=4urad", "--reference", "X=0,Y=0,Z=0", "--max-correction", "0.01")
        rest = {tuple(its["at"]): its["rest"] for its in self.sure_of(*corner, "--pivot", "Y=300")["places"]}
        self.assertAlmostEqual(rest[0, 0, 0], 0)
        self.assertAlmostEqual(rest[0, 300, 0] * 1000, 14, delta=0.1)  # 24 um at Y 0, of which 10 um are corrected
        self.assertAlmostEqual(rest[0, 600, 0] * 1000, 28, delta=0.1)
        self.assertIn("--pivot: 'W=1' names an axis", self.refused(*self.COLUMN, "--pivot", "W=1"))

    def test_diagonals_before_and_after_and_their_steps(self):
        self.write("steps.csv", "distance,deviation\n500,0.0\n1000,0.0001\n")
        arguments = ("--tilt", "EC0Y=-80urad,u=4urad", "--steps", "PPP=steps.csv")
        found = self.sure_of(*arguments)["diagonals"]
        self.assertEqual([its["name"] for its in found], ["PPP", "NPP", "PNP", "NNP"])
        length = math.sqrt(800**2 + 600**2 + 500**2)
        for its, sign in zip(found, (1, -1, -1, 1)):  # EC0Y < 0: Y leans to +X
            self.assertAlmostEqual(its["length"], length)
            self.assertAlmostEqual(its["without"], sign * 80e-6 * 800 * 600 / length, 5)
            self.assertAlmostEqual(its["rest"], 0, 6)
            self.assertAlmostEqual(its["U"], 2 * 4e-6 * 800 * 600 / length, delta=2e-4)
        steps = found[0]["steps"]
        self.assertAlmostEqual(steps[0]["without"], 80e-6 * 800 * 600 / length * 500 / length, 5)
        output = " ".join(self.run_volume(*self.COLUMN, *arguments).split())
        self.assertIn("The steps fit the machine without correction at 0 and with correction at 2 of 2 places, within U.", output)
        self.assertIn("steps check a table, and never fill one", output)
        self.assertIn("beyond the diagonal of the box", self.refused(*self.COLUMN, "--steps", "PPP=" + self.write("far.csv", "distance,deviation\n5000,0\n")))
        self.assertIn("line 3: column distance: 400 does not rise", self.refused(*self.COLUMN, "--steps", "PPP=" + self.write("back.csv", "distance,deviation\n500,0\n400,0\n")))
        self.assertIn("'QQQ=back.csv' has no form as PPP=steps.csv", self.refused(*self.COLUMN, "--steps", "QQQ=back.csv"))

    def test_a_screen_gets_tables_and_paths(self):
        self.write("x.csv", "# u: EXX 0.0005, EXX+ 0.0002\nX,EXX+,EXX-,EAX\n0,-0.001,0.003,1e-6\n800,0,0,0\n# end, 2 rows\n")
        found = self.sure_of("--table", "x.csv")["tables"]["X"]
        self.assertEqual(found["EXX"], {"unit": "mm", "directed": True, "u": 0.0005, "rows": [[0, -0.001, 0.003], [800, 0, 0]]})
        self.assertEqual((found["EAX"]["unit"], found["EAX"]["u"], found["EAX"]["rows"][0]), ("rad", None, [0, 1e-6, 1e-6]))
        path = json.loads(self.run_volume("circle", self.ballbar("CCW", lost=0.01), "--json"))["paths"][0]
        self.assertEqual((path["clockwise"], len(path["points"])), (False, 720))
        self.assertAlmostEqual(max(deviation for _angle, deviation in path["points"]), 0.005, 3)

    def test_wrong_questions_are_refused(self):
        for option, value, reason in (
            ("--tilt", "EC0W=1urad,u=1urad", "--tilt: 'EC0W' names an axis that the chain does not have"),
            ("--tilt", "EC0Y=1", "--tilt: '1'"),
            ("--common", "square,EC0Y=1", "--common: 'square,EC0Y=1' has no form"),
            ("--repeatability", "X=20mm", "is not from 0 to 10 mm"),
            ("--reference", "X=nan", "--reference: 'X=nan' has no form"),
            ("--tilt", "EC0Y=-80urad,EA0Z=3urad,u=4urad", "has two angles: give each its own --tilt"),
            ("--tilt", "EC0Y=-80urad,u=-4urad", "--tilt: '-4urad' is not from 0 to 0.1 rad"),
            ("--tilt", "EC0Y=10deg,u=4urad", "--tilt: 'EC0Y=10deg,u=4urad' is no angle below 0.1 rad"),
            ("--common", "square,EC0Y=1,u=-3urad", "--common: '-3urad' is not from 0 to 0.1 rad"),
            ("--today", "2026-99-99", "--today: '2026-99-99' is no date"),
            ("--temperature", "24", "--temperature: '24' has no form as 24degC"),
        ):
            self.assertIn(reason, self.refused(*self.COLUMN, option, value))
        self.assertIn("gives EC0Y a second time", self.refused(*self.COLUMN, "--tilt", "EC0Y=1urad,u=1urad", "--tilt", "EC0Y=2urad,u=1urad"))
        self.assertIn("gives X a second time", self.refused("uncertainty", "--chain", "w-X.b-Y-Z-t", "--box", "X=0:9,X=0:8,Y=0:6,Z=0:5"))
        self.write("x.csv", "# date: 20.11.2026\n# u: EXX 0.0005\n# drift: EXX 2e-6\nX,EXX\n0,0\n800,0\n# end, 2 rows\n")
        self.assertIn("has the date '20.11.2026', which is none as 2026-11-20: its age is unknown", " ".join(self.run_volume(*self.COLUMN, "--table", "x.csv").split()))
        bare = " ".join(self.run_volume(*self.COLUMN).split())
        self.assertIn("U is unknown, for no error has an uncertainty.", bare)
        self.assertNotIn("-0.00", bare)
        self.assertIn("--box: 'X=0:0' has no form", self.refused("uncertainty", "--chain", "w-X.b-Y-Z-t", "--box", "X=0:0,Y=0:1,Z=0:1"))


if __name__ == "__main__":
    unittest.main()

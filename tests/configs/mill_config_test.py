#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""configs/mill: thermal displacement in a complete LinuxCNC in virtual time."""

import os
import re
import subprocess
import unittest

import numpy as np

import linuxcnc_runs
import plumb_contacts
from linuxcnc_runs import BUILD, ROOT, STILL, changes, copy_configuration, own_folder, read_recording, um
from long import long
from starts import starts

README = os.path.join(ROOT, "configs", "mill", "README.md")

GROWTH = 10 * um  # that grow.ngc adds
TOLERANCE = 6 * um  # of the cuts: 2 um that are not applied, the seats of the tools, and the uncertainty of the load
OPERATIONS = [10, 10, 10, 20, 20, 30]
RAPID, FEED = 1, 2
ZERO = 3  # of M68 E6: a new zero, or the tool was measured


def run(folder, machine, *command, **more):
    """Exit status and output of a command in the folder of a configuration."""

    def begin():
        return subprocess.Popen(
            command,
            cwd=machine,
            env=linuxcnc_runs.environment(folder, PYTHONPATH=os.path.join(BUILD, "python"), **more),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    return linuxcnc_runs.run_to_the_end(machine, begin)


class Shift(unittest.TestCase):
    """One start of LinuxCNC, in which programs/mill_scenario.py works through all scenes."""

    @classmethod
    def setUpClass(cls):
        folder = own_folder(cls)
        cls.folder, cls.machine = folder, copy_configuration("mill", folder)
        ini = linuxcnc_runs.own_ini(os.path.join(cls.machine, "mill.ini"), HAL=linuxcnc_runs.at_the_end("HALFILE = record.hal"))
        its, cls.output = linuxcnc_runs.work(folder, ini, "mill_scenario.py")
        cls.facts, cls.errors, cls.messages = its["facts"], its["errors"], its["messages"]
        cls.scenes = linuxcnc_runs.read_scenes(cls.machine, its["scenes"])

    def cuts(self, scene):
        """Errors of the cuts in a scene."""
        rows = changes(self.scenes[scene]["mill.truth-cuts"])
        operations = self.scenes[scene]["mill.truth-cut-operation"][rows]
        self.assertEqual(list(operations), OPERATIONS)
        return self.scenes[scene]["mill.truth-cut-error"][rows]

    def test_scenes_are_those_of_the_scenario(self):
        self.assertEqual(
            sorted(self.scenes),
            ["aborted", "aborted_before_learning", "after_learning_again", "before_probing", "checked_blanks", "checked_spindle", "compensated", "grown"]
            + ["learnt", "learnt_again", "probed", "refused", "tool_touched_off", "touched_off", "uncompensated"],
        )

    def test_parts_are_true_on_the_cold_machine(self):
        self.assertLess(abs(self.cuts("learnt")).max(), 3 * um)

    def test_without_compensation_growth_goes_into_the_work(self):
        np.testing.assert_allclose(self.cuts("uncompensated"), -GROWTH, atol=3 * um)

    def test_with_compensation_only_the_first_two_cuts_show_growth_that_jumps(self):
        """grow.ngc lets it jump; one contact moves the offset towards it, and the next one decides."""
        for scene in ("compensated", "grown"):
            with self.subTest(scene):
                errors = self.cuts(scene)
                self.assertLess(errors[0], -GROWTH / 2)
                self.assertGreater(errors[1], errors[0] + um)
                self.assertLess(abs(errors[2:]).max(), TOLERANCE)

    def test_offset_moves_only_out_of_contact_and_slowly(self):
        for name, scene in self.scenes.items():
            with self.subTest(name):
                moves = np.diff(scene["axis.z.eoffset"])
                lifted = np.diff(scene["joint.2.motor-pos-cmd"]) > um  # it bears on the bottom no more
                in_work = (scene["mill.engagement"][1:] > 0) & ~lifted
                if name != "probed":  # where the probe touches
                    self.assertLess(abs(moves[in_work]).max(initial=0), STILL)
                self.assertLess(abs(moves).max(initial=0), 5 * um)

    def test_cycle_bits_frame_the_contacts(self):
        for name in ("learnt", "uncompensated", "compensated", "grown"):
            with self.subTest(name):
                scene = self.scenes[name]
                running, complete = scene["motion.digital-out-00"], scene["motion.digital-out-01"]
                begin, end = changes(running)
                self.assertTrue(begin < end and not running[0])
                cutting = np.flatnonzero(scene["mill.engagement"] > 0)
                self.assertTrue(begin < cutting[0] and cutting[-1] < end)
                self.assertTrue(complete[end])
                self.assertFalse(complete[begin : cutting[-1]].any())
                learn = scene["motion.digital-out-02"]
                self.assertEqual(learn[begin : end + 1].all(), name == "learnt")
                self.assertFalse(learn[-1])

    def test_operations_are_numbered_as_the_tools_feed(self):
        scene = self.scenes["compensated"]
        operation = scene["motion.analog-out-00"]
        self.assertEqual([operation[row] for row in changes(operation)][::2], OPERATIONS)
        feeding = scene["motion.motion-type"] == FEED
        self.assertTrue((operation[feeding] != 0).all())
        tools = scene["iocontrol.0.tool-number"][feeding]
        self.assertTrue((tools == operation[feeding] / 10).all())

    def test_contacts_are_those_of_the_feeding_end_mills(self):
        scene = self.scenes["compensated"]
        contacts = changes(scene["growth.contacts"])
        self.assertEqual(len(contacts), 5)  # and not the drill's
        self.assertTrue((scene["motion.motion-type"][contacts] == FEED).all())
        self.assertEqual(np.ptp(scene["growth.contacts-accepted"]), 5)

    def test_program_reads_the_offset_in_force(self):
        for scene in self.scenes.values():
            np.testing.assert_allclose(scene["motion.analog-in-00"][3:], scene["axis.z.eoffset"][2:-1], atol=0.1 * um)
        names = ["learnt", "uncompensated", "compensated", "grown", "before_probing"]
        shown = [float(re.search("force (.*) mm", text)[1]) for text in self.messages if "force 0" in text][: len(names)]
        for name, offset in zip(names, shown):
            self.assertAlmostEqual(offset, self.scenes[name]["axis.z.eoffset"][-1], delta=0.1 * um)
        self.assertEqual(len(shown), len(names))

    def test_abort_takes_the_bits_back_and_moves_nothing(self):
        scene = self.scenes["aborted"]
        self.assertTrue(scene["motion.digital-out-00"].any())
        for bit in range(5):
            self.assertFalse(scene["motion.digital-out-%02d" % bit][-1], bit)
        self.assertEqual(scene["motion.analog-out-00"][-1], 0)
        begin = changes(scene["motion.digital-out-00"])[0]
        self.assertFalse(scene["motion.digital-out-01"][begin:].any())
        self.assertLess(np.ptp(scene["joint.2.motor-pos-cmd"][-500:]), STILL)
        request = self.scenes["aborted_before_learning"]["motion.digital-out-02"]
        self.assertEqual([request[0], request[-1]], [1, 0])

    def test_part_is_refused_until_the_work_is_known(self):
        self.assertIn("where is the work? Run setup.ngc first", self.facts["without setup"])

    def test_probing_with_an_offset_in_force_is_refused(self):
        scene = self.scenes["refused"]
        self.assertGreater(scene["axis.z.eoffset"][0], GROWTH)
        self.assertLess(np.ptp(scene["joint.2.motor-pos-cmd"]), 10 * um)
        self.assertLess(np.ptp(scene["axis.z.eoffset"]), STILL)
        self.assertIn("refusal", self.facts)
        self.assertTrue(any("Probing is aborted" in error for error in self.errors), self.errors)

    def test_probing_takes_the_offset_back_and_finds_the_work_where_the_offset_will_be_right(self):
        self.assertAlmostEqual(self.facts["work"], -250, delta=2 * um)
        self.assertAlmostEqual(self.scenes["probed"]["axis.z.eoffset"][-1], 0, delta=0.1 * um)
        growth = self.scenes["probed"]["mill.truth-growth"][-1]
        self.assertGreater(growth, 1.5 * GROWTH)
        right = -250 + growth - self.facts["wanted"]
        self.assertAlmostEqual(self.facts["probed"], right, delta=3 * um)  # the seat of the probe

    def test_touch_off_comes_out_alike_with_the_offset_in_force_and_without(self):
        for how in ("with", "without"):
            self.assertAlmostEqual(
                self.facts["touched off %s the offset" % how], self.facts["probed"], delta=0.2 * um, msg=how
            )

    def test_by_time_every_contact_is_accepted_and_the_offset_follows_the_growth(self):
        for way, (accepted, contacts, offset, growth, code) in self.facts["by time"].items():
            with self.subTest(way):
                self.assertEqual((accepted, contacts, code), (10, 10, 0))
                self.assertAlmostEqual(growth, 2 * GROWTH, delta=0.01 * um)
                self.assertAlmostEqual(offset, growth, delta=TOLERANCE)

    def test_a_probed_table_and_another_depth_are_no_growth_and_shifts_are_asked_about(self):
        seen = self.facts["origins"]
        growth = seen["higher table, probed"]["growth-estimate"]
        for name, its in seen.items():
            with self.subTest(name):
                self.assertAlmostEqual(its["growth-estimate"], growth, delta=6 * um, msg=str(its))  # two estimates of few contacts
        for name in ("higher table, probed", "higher blanks, answered", "another depth, answered", "touched off", "tool touched off"):
            its = seen[name]
            self.assertEqual((its["doubt"], its["shift-size"], its["origin-change"], its["accepted"], its["messages"]), (0, 0, 0, 5, []), name)
        for name in ("higher blanks", "longer tool"):  # against the growth, which is as uncertain as above
            self.assertAlmostEqual(seen[name]["shift-size"], 30 * um, delta=6 * um, msg=name)
        self.assertAlmostEqual(seen["another depth"]["origin-change"], -8 * um, delta=0.01 * um)
        statuses = plumb_contacts.plumb.declarations("thermal_displacement")["statuses"]
        for name, status, size in (("higher blanks", "53", 30), ("longer tool", "56", 30), ("another depth", "54", -8)):
            (text,) = seen[name]["messages"]
            unanswered, number = r"If nobody answers, parts go on\.", r"(\u2212?\d+\.\d) µm\."
            of_tool = r"Tool 2 has cut deeper for \d+ (?:s|min): "
            said = of_tool + number + " " + unanswered if name == "longer tool" else unanswered + " Size: " + number
            shown = re.fullmatch(re.escape("Growth of Z: " + statuses[status]["sentence"]) + " " + said + ".*growth_answer.*", text)
            self.assertTrue(shown, text)
            self.assertAlmostEqual(float(shown[1].replace("\u2212", "-")), size, delta=6)

    def test_a_probed_tool_setter_answers_whether_contacts_have_moved_by_growth(self):
        codes = {name: its["check-code"] for name, its in self.facts["checked"].items()}
        first, is_growth, is_no_growth = 2, 4, 5
        self.assertEqual(codes, {"at first": first, "checked_blanks": is_no_growth, "checked_spindle": is_growth})
        self.assertEqual(self.facts["due"], [1, 0])
        sentences = plumb_contacts.plumb.declarations("thermal_displacement")["codes"]["check-code"]
        for name, its in self.facts["checked"].items():
            with self.subTest(name):
                self.assertEqual(its["messages"], ["Growth of Z: " + sentences[its["check-code"]]])
                self.assertEqual((its["shift-size"], its["check-due"]), (0, 0))
                if name == "at first":
                    self.assertAlmostEqual(its["surface"], -125, delta=5 * um)  # the seat of the probe, and the column
                    continue
                self.assertAlmostEqual(its["shift"], 30 * um, delta=8 * um)
                self.assertLess(abs(self.cuts(name)).max(), GROWTH)
        growth = [self.facts["checked"][name]["growth-estimate"] for name in ("checked_blanks", "checked_spindle")]
        self.assertAlmostEqual(growth[1] - growth[0], 30 * um, delta=4 * um)

    def test_at_doubt_the_next_part_waits_until_one_is_acknowledged(self):
        self.assertEqual(self.facts["waits"], [[1, 0], [0, 5]])

    def test_probing_and_touching_off_give_their_reason_before_the_change(self):
        for name, pin in (("probed", "work-offset"), ("touched_off", "work-offset"), ("tool_touched_off", "tool-length")):
            with self.subTest(name):
                scene = self.scenes[name]
                given = np.flatnonzero(scene["growth.answer"] == ZERO)
                changed = changes(scene["growth." + pin])
                self.assertGreater(len(changed), 0)
                self.assertLessEqual(given[0], changed[-1])
                self.assertLess(changed[-1] - given[-1], 1 / linuxcnc_runs.PERIOD)  # for which a reason holds
                self.assertEqual(scene["growth.answer"][-1], 0)

    def test_a_warm_machine_learns_with_its_offset_and_reports_how_well(self):
        self.assertEqual(self.facts["learnt again"], [1, 0])
        for name in ("learnt_again", "after_learning_again"):
            scene = self.scenes[name]
            cuts = scene["motion.digital-out-00"] == 1
            error = scene["axis.z.eoffset"][cuts] - scene["mill.truth-growth"][cuts]
            self.assertLess(abs(error).max(), TOLERANCE, name)
        reports = [text for text in self.messages if text.startswith("Growth of Z: Learned from this part")]
        self.assertGreater(len(reports), 1)
        for text in reports:
            sigma = re.fullmatch(r"Growth of Z: Learned from this part\. The reference is uncertain by (\d\.\d) µm; 5 contacts of all programs are kept\.", text)
            self.assertTrue(sigma, text)
            self.assertTrue(0 < float(sigma[1]) < 3, text)

    def test_one_line_a_shift_says_how_it_went(self):
        (line,) = self.facts["summary"]
        self.assertRegex(line, r"^Growth of Z: Last shift: \d+ parts, offset up to \u2212?\d+\.\d µm, expected error \d+\.\d µm, doubt in \d+ % of the parts\.$")

    def report(self, recording, *options):
        """Exit status, output and the table of contacts of the report on a recording."""
        status, output = run(self.folder, self.machine, "plumb", "contacts", recording, *options)
        contacts = []
        for line in output.partition("\nContacts, in mm\n")[2].partition("\n\n")[0].splitlines()[1:]:
            words = line.split()
            compared = len(words) > 7 and re.fullmatch(r"[+-]\d+\.\d+", words[6])
            contacts.append(
                {
                    "key": tuple(map(int, words[2:5])),
                    "cycle": int(words[1]),
                    "coordinate": float(words[5]),
                    "growth": float(words[6]) if compared else None,
                    "verdict": " ".join(words[8 if compared else 6 :]),
                }
            )
        return status, output, contacts

    def test_report_agrees_with_the_machine(self):
        _, output, contacts = self.report("load.txt", "--chart", "chart.png")
        for cycle, name in ((3, "compensated"), (4, "grown")):
            with self.subTest(name):
                scene = self.scenes[name]
                rows = changes(scene["growth.contacts"])
                reported = [c for c in contacts if c["cycle"] == cycle]
                self.assertEqual(
                    [c["key"] for c in reported], [(10, 1, 1), (10, 1, 2), (10, 1, 3), (20, 2, 1), (20, 2, 2)]
                )
                self.assertEqual({c["verdict"] for c in reported}, {"accepted"})
                for pin, value in (("contact-coordinate", "coordinate"), ("displacement", "growth")):
                    said = scene["growth." + pin][rows]
                    np.testing.assert_allclose([c[value] for c in reported], said, atol=0.2 * um, err_msg=pin)
        self.assertGreater(os.path.getsize(os.path.join(self.machine, "chart.png")), 10000)
        self.assertIn("Not complete: cycle 5,", output)

    @long
    def test_report_from_a_machine_without_compensation_shows_the_offset_that_it_would_have_applied(self):
        scene = self.scenes["uncompensated"]
        with open(os.path.join(self.machine, "load.txt")) as file:
            lines = file.readlines()
        numbers = [line.split() for line in lines]
        ends = [i for i in range(1, len(numbers)) if numbers[i - 1][10] == "1" and numbers[i][10] == "0"]
        with open(os.path.join(self.machine, "first.txt"), "w") as file:
            for line in lines[: ends[1] + 20]:
                words = line.split()
                words[12] = "0"  # so no part is chosen for learning
                file.write(" ".join(words) + "\n")
        self.assertLess(np.ptp(scene["axis.z.eoffset"]), STILL)
        status, output, contacts = self.report("first.txt")
        self.assertEqual(status, 1, output)
        self.assertEqual([c["verdict"] for c in contacts], 5 * ["learned"] + 5 * ["accepted"])
        growth = [c["growth"] for c in contacts if c["growth"] is not None]
        np.testing.assert_allclose(growth, GROWTH, atol=TOLERANCE)
        self.assertIn("taken as learned by this report", output)
        self.assertIn("No cycle asked to be learned from", output)
        self.assertNotIn("Nothing hinders compensation", output)
        with open(os.path.join(self.machine, "first.txt")) as file:
            asked = [line.split() for line in file]
        for words in asked[: ends[0] + 1]:
            words[12] = "1"
        self.write("asked.txt", asked)
        status, output, contacts = self.report("asked.txt", "--set", "dry-run=1")
        self.assertEqual(status, 0, output)
        self.assertIn("Nothing hinders compensation", output)
        cycle = output.partition("with dry-run 0, in mm")[2].splitlines()[3].split()
        self.assertAlmostEqual(float(cycle[5]), GROWTH, delta=TOLERANCE)

        # It does not recommend worse settings, and recommends better ones.
        accepted = r"now +%d .*\n  these +%d "
        status, output, _ = self.report("asked.txt", "--set", "threshold=100")
        self.assertRegex(output, accepted % (0, 5))
        self.assertIn("Take the other settings over", output)
        asked = [words[:1] + ["%g" % (float(words[1]) / 100)] + words[2:] for words in asked]
        self.write("fraction.txt", asked)
        status, output, _ = self.report("fraction.txt")
        self.assertEqual(status, 1, output)
        self.assertIn("is the load in percent of the rating?", output)
        self.assertNotIn("setp growth", output)

    def write(self, name, rows):
        with open(os.path.join(self.machine, name), "w") as file:
            file.writelines(" ".join(words) + "\n" for words in rows)

    def test_report_does_not_recommend_what_does_worse(self):
        class Outcome(plumb_contacts.Replay):
            def __init__(self, accepted, sigma):
                self.outcome = accepted, sigma

            def accepted(self):
                return self.outcome[0]

            def sigma(self):
                return self.outcome[1]

        for this, other, better in (
            ((10, 7), (4, 14), True),
            ((4, 7), (10, 14), False),
            ((10, 14), (4, 7), False),
            ((10, 7), (10, 7.02), False),
            ((10, 7), (10, 8), True),
            ((10, 7), (0, np.inf), True),
            ((0, np.inf), (0, np.inf), False),
        ):
            with self.subTest(this=this, other=other):
                self.assertEqual(Outcome(*this).better_than(Outcome(*other)), better)

    def test_report_names_signals_that_are_missing(self):
        with open(os.path.join(self.machine, "load.txt")) as file:
            rows = [line.split() for line in file.readlines()[:60000]]
        for column, name, source in (
            (1, "spindle-load", "the load of the drive"),
            (2, "z-joint-fb", "joint.2.motor-pos-fb"),
            (3, "z-velocity", "joint.2.vel-cmd"),
            (4, "spindle-speed-cmd", "spindle.0.speed-out"),
            (5, "feed-override", "halui.feed-override.value"),
            (8, "motion-type", "motion.motion-type"),
            (9, "tool-number", "iocontrol.0.tool-number"),
        ):
            with self.subTest(name):
                self.write("missing.txt", [words[:column] + ["0"] + words[column + 1 :] for words in rows])
                status, output, _ = self.report("missing.txt")
                self.assertEqual(status, 2, output)
                self.assertEqual(re.findall("net ([^ ]*) to (.*)", output), [(name, source)])
                self.assertNotIn("setp", output)

    def test_report_names_what_a_recording_lacks(self):
        with open(os.path.join(self.machine, "load.txt")) as file:
            lines = file.readlines()[:20000]
        for name, changed, words in (
            ("overrun", lines[:10] + ["overrun\n"] + lines[10:], "a larger depth"),
            ("missing", lines[:10] + lines[11:], "samples are missing after sample 9"),
            ("columns", [line.partition(" ")[2].partition(" ")[2] for line in lines], "11 columns"),
            ("cycles", lines[:1000], "M64 P0"),
        ):
            with self.subTest(name):
                file = os.path.join(self.machine, name + ".txt")
                with open(file, "w") as recording:
                    recording.writelines(changed)
                status, output, _ = self.report(file)
                self.assertEqual(status, 2, output)
                self.assertIn(words, output)
                self.assertNotIn("Traceback", output)


class Readme(unittest.TestCase):
    """The commands of the page print the output on the page, but for figures that differ from run to run."""

    @classmethod
    def setUpClass(cls):
        with open(README) as page:
            cls.page = page.read()
        cls.folder = own_folder(cls)
        cls.machine = copy_configuration("mill", cls.folder)

    def shown(self, before):
        """The indented lines behind these words."""
        return re.search(re.escape(before) + r"\n\n((?:    .*\n|\n)+)", self.page)[1]

    def command(self, pattern):
        return re.search(r"^    (%s.*?)(?: +#.*)?$" % pattern, self.page, re.M)[1]

    def follow(self, command):
        command = re.sub(r"--speed \d+", "--speed %g" % linuxcnc_runs.speed, command).replace("linuxcnc mill", "linuxcnc -r mill")
        return run(self.folder, self.machine, "sh", "-c", command)

    @staticmethod
    def skeletons(text):
        """Lines without their figures, and without words that vary with them."""
        lines = (re.sub(r"[+-]?\d+(\.\d+)?", "0", " ".join(line.split())) for line in text.splitlines())
        lines = (re.sub(r" #.*", "", line) for line in lines if line)
        return [line for line in lines if not line.startswith(("- Keep the settings", "- Take the other"))]

    @unittest.skipIf(os.environ.get("PLUMB_SANITIZE"), "runs the same code as the other tests, for longer")
    def test_commissioning_is_as_on_the_page(self):
        machining = self.command(r"plumb run .* part.ngc grow.ngc part.ngc grow.ngc part.ngc grow.ngc part.ngc")
        first = self.command("plumb run --speed 10 -- linuxcnc mill.ini setup.ngc learn.ngc")
        self.assertTrue(machining.startswith(first), "the example is the beginning of the recording")
        self.assertEqual(self.follow(self.command("echo"))[0], 0)
        status, output = self.follow(machining)
        self.assertEqual(status, 0, output)
        printed = [line for line in output.splitlines() if re.match(" the work| operation|.* is done", line)]
        shown = [line[4:] for line in self.shown("would find at its floor:").splitlines() if line]
        self.assertEqual(self.skeletons("\n".join(printed[: len(shown)])), self.skeletons("\n".join(shown)))
        cold = shown.index("grow.ngc is done")  # on the cold machine even the figures are the same
        self.assertEqual(printed[:cold], shown[:cold])

        status, output = self.follow(self.command(r"plumb contacts load.txt"))
        self.assertEqual(status, 0, output)
        said, shown = self.skeletons(output), self.skeletons(self.shown("prints, for the recording of step 2"))
        self.assertEqual([line for line in shown if line not in said + ["..."]], [])
        self.assertEqual([line for line in said if line not in shown], [])
        self.assertIn("Nothing hinders compensation", output)

        status, output = self.follow(self.command(r"plumb contacts load.txt --set"))
        self.assertEqual(status, 0, output)
        self.assertTrue(os.path.exists(os.path.join(self.machine, "report.png")))
        status, output = self.follow(self.command("plumb bench"))
        self.assertEqual(status, 0, output)
        offsets = read_recording(os.path.join(self.machine, "offset.csv"))
        self.assertGreater(offsets["growth.z-offset"].max(), GROWTH)

    def test_load_comes_by_what_it_shows(self):
        """As far as it goes without the interface cards."""
        import plumb

        blocks = re.findall(r"```hal\n(.*?)```", self.page, re.S)
        self.assertEqual(len(blocks), 3)
        with open(os.path.join(self.machine, "load.toml"), "w") as file:
            file.write(next(block for block in re.findall(r"```ini\n(.*?)```", self.page, re.S) if "[[link]]" in block))
        for block in blocks:
            with plumb.Host() as host:
                host.command("loadrt threads name1=servo-thread period1=1000000")
                for line in block.splitlines():
                    if re.search("YOUR-CARD|lcec", line):
                        line = re.sub("(YOUR-CARD|lcec)[^ ]*", "", line)
                    if line.startswith("loadusr"):
                        line = line.replace("load.toml", os.path.join(self.machine, "load.toml"))
                        line = line.replace("modbus_sensor", os.path.join(BUILD, "bin", "modbus_sensor"))
                    if line:
                        host.command(line)
                host.command("start")
                host.run(0.01)
                self.assertEqual(host.get("spindle-load"), 0)


tearDownModule = starts("mill/mill.ini")


if __name__ == "__main__":
    unittest.main()

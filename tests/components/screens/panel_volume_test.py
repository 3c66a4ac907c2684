# SPDX-License-Identifier: GPL-2.0-or-later
"""The questions of the page Tables and uncertainty to plumb volume, and the answers that it shows; without a screen."""

import configparser
import json
import os
import subprocess
import sys
import unittest

import panel_texts
from tree import BUILD, ROOT

sys.path.insert(0, os.path.join(ROOT, "components", "screens"))
from panel import chopping_orders, squareness_state, texts, volume_state  # noqa: E402
from plumb_folder import TemporaryFolder  # noqa: E402


class Ini:
    def __init__(self, text):
        self._ini = configparser.ConfigParser(interpolation=None)
        self._ini.optionxform = str
        self._ini.read_string(text)

    def get(self, section, name, otherwise=""):
        return self._ini.get(section, name, fallback=otherwise)


class Instance:
    """As panel.machine.Instance."""

    def __init__(self, values):
        self.pins, self._values = dict.fromkeys(values), values

    def value(self, _values, short, otherwise=None):
        return self._values.get(short, otherwise)


LIMITS = "".join("[AXIS_%s]\nMIN_LIMIT = %s\nMAX_LIMIT = %s\n" % its for its in (("X", -1, 9), ("Y", 0, 8), ("Z", -7, 0)))


class Asked(unittest.TestCase):
    def setUp(self):
        folder = TemporaryFolder()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_work_space_is_in_mm_and_a_missing_limit_is_named(self):
        self.assertEqual(volume_state.box(Ini("[TRAJ]\nLINEAR_UNITS = mm\n" + LIMITS)), "X=-1.0:9.0,Y=0.0:8.0,Z=-7.0:0.0")
        self.assertEqual(volume_state.box(Ini("[TRAJ]\nLINEAR_UNITS = inch\n" + LIMITS)), "X=%r:%r,Y=0.0:%r,Z=%r:0.0" % (-25.4, 9 * 25.4, 8 * 25.4, -7 * 25.4))
        with self.assertRaisesRegex(volume_state.Lacks, r"\[AXIS_Z\]MIN_LIMIT and MAX_LIMIT"):
            volume_state.box(Ini("[TRAJ]\nLINEAR_UNITS = mm\n" + LIMITS.replace("AXIS_Z", "AXIS_A")))

    def test_tables_are_those_of_the_ini_file(self):
        self.assertEqual(volume_state.tables(Ini("[SQUARENESS]\nTABLE = /a/x.csv:/a/y.csv\n")), ["/a/x.csv", "/a/y.csv"])
        self.assertEqual(volume_state.tables(Ini("[SQUARENESS]\nTABLE = none\n")), [])

    def test_tool_points_from_the_gauge_point_to_its_tip(self):
        self.assertEqual(volume_state.tool(Instance({"z-tool-offset": 150.0, "x-tool-offset": -2.0}), {})[1].partition("=")[2], "2.0,0.0,-150.0")

    def test_pivots_other_than_0_are_named(self):
        self.assertEqual(volume_state.pivots(Instance({"x-pivot": 0.0, "y-pivot": 300.0, "c-x-pivot": 0.0}), {}), ["--pivot", "Y=300.0"])

    def test_an_angle_is_sure_only_as_it_was_measured(self):
        document = {"input": {"measurements": [{"by": "square"}]}, "deviations": [{"EC0Y": 4e-6, "EC0X": -2e-6}], "settled": [{"name": "EC0Y", "angle": -8e-5}, {"name": "EC0X", "angle": 1e-5}]}
        volume_state.keep_uncertainty(self.folder, document)
        kept = volume_state.kept_uncertainty(self.folder)
        self.assertEqual(kept["angles"]["EC0Y"]["angle"], -8e-5)
        given = volume_state.of_angles(self.folder, Instance({"ec0y": -8e-5, "ec0x": 3e-5, "eb0z": 0.0}), {})
        tilts = [word for option, word in zip(given, given[1:]) if option == "--tilt"]
        self.assertRegex(tilts[0], r"^EC0Y=-8e-05rad,u=0rad,date=\d{4}-\d\d-\d\d,by=square$|^EC0X=3e-05rad$")
        self.assertEqual(sorted(word.partition("=")[0] for word in tilts), ["EC0X", "EC0Y"])
        self.assertIn("EC0X=3e-05rad", tilts)  # edited by hand: without u
        self.assertIn("measurement 1,EC0Y=1.0,u=4e-06rad", given)
        volume_state.keep_uncertainty(self.folder, {"deviations": [{"EC0X": 1e-6}], "settled": [{"name": "EC0X", "angle": 3e-5}]})
        self.assertEqual(volume_state.kept_uncertainty(self.folder)["causes"], [{"EC0Y": 4e-6}, {"EC0X": 1e-6}])
        for cut in ("{", "{}", '{"angles": 3, "causes": []}', "[]", '{"angles": {"EC0Y": {"angle": -8e-5}}, "causes": []}', '{"angles": {"EC0Y": 1}, "causes": []}', '{"angles": {}, "causes": [3]}'):
            with open(os.path.join(self.folder, volume_state.FILE), "w") as file:
                file.write(cut)
            self.assertEqual(volume_state.kept_uncertainty(self.folder), {"angles": {}, "causes": []})

    def test_temperature_is_that_of_a_valid_sensor(self):
        growth = Instance({"temperature-0": 31.0, "temperature-valid-0": False, "temperature-1": 24.5, "temperature-valid-1": True})
        self.assertEqual(volume_state.temperature([growth], {}), ["--temperature", "24.5degC"])
        self.assertEqual(volume_state.temperature([Instance({"temperature-0": 31.0, "temperature-valid-0": False})], {}), [])
        self.assertEqual(volume_state.temperature([], {}), [])

    def test_newest_path_of_a_ballbar_counts(self):
        def path(name, direction, correction, time):
            with open(os.path.join(self.folder, name), "w") as file:
                file.write("# direction: %s\n# correction: %s\nangle,radius\n" % (direction, correction))
            os.utime(os.path.join(self.folder, name), (time, time))
            return os.path.join(self.folder, name)

        path("old.csv", "CCW", "off", 1e9)
        new, other, after = path("a_new.csv", "CCW", "off", 2e9), path("cw.csv", "CW", "off", 1e9), path("z.csv", "CW", "on", 1e9)
        path("strange.csv", "both", "on", 3e9)
        self.assertEqual(volume_state.circles(self.folder), {"off": [new, other], "on": [after]})


class Shown(unittest.TestCase):
    def test_corners_are_both_ends_of_each_axis_with_the_first_tool(self):
        places = [{"at": [x, y, z], "tool": tool, "U": 0.001} for tool in ("T1", "T2") for x in (0, 400, 800) for y in (0, 300, 600) for z in (-500, -250, 0)]
        found = volume_state.corners(places)
        self.assertEqual(len(found), 8)
        self.assertEqual({tuple(its["at"]) for its in found}, {(x, y, z) for x in (0, 800) for y in (0, 600) for z in (-500, 0)})
        self.assertEqual({its["tool"] for its in found}, {"T1"})

    def test_causes_and_notes_are_said_in_words(self):
        self.assertEqual(volume_state.cause_in_words("EXX, all rows together"), "EXX, all rows together")
        self.assertEqual(volume_state.cause_in_words("drift EC0Y"), "drift of EC0Y")
        self.assertEqual(volume_state.cause_in_words("repeatability"), "repeatability")
        note = {"kind": "old", "of": "X", "first": 500, "second": 365}
        self.assertEqual(volume_state.note_in_words(note), "The measurement of X is 500 days old, and valid for 365: measure again.")

    def test_causes_and_notes_are_said_in_german(self):
        texts.choose(os.path.join(BUILD, "share", "locale"), "de")
        self.addCleanup(texts.choose, os.path.join(BUILD, "share", "locale"), "en")
        self.assertEqual(volume_state.cause_in_words("lost motion X"), "Umkehrspiel X")
        for kind in volume_state.NOTES:
            note = {"kind": kind, "of": "EXX", "first": 20, "second": 26}
            self.assertNotEqual(volume_state.note_in_words(note), volume_state.NOTES[kind].format(**note), kind)
        hows = panel_texts.of_error_list()
        self.assertEqual(len(hows), 10)
        for how in hows:
            self.assertNotEqual(texts._(how), how)
        section = dict(zip(("section-0-kind", "section-0-from", "section-0-to", "section-0-ratio"), (chopping_orders.BOTH, -20.0, -5.0, 0.5)))
        self.assertIn("in beiden Richtungen", chopping_orders.section_in_words(Instance(section), {}, 0))


    def test_the_list_of_errors_names_how_each_unknown_one_is_measured(self):
        """The kinds are those of plumb volume."""
        chain = ("--chain", "w-X.b-Y-Z-t", "--box", "X=0:800,Y=0:600,Z=-500:0")
        done = subprocess.run([os.path.join(BUILD, "bin", "plumb-volume"), "uncertainty", "--json", *chain, "--tilt", "EC0Y=1urad,u=2urad,by=square"], capture_output=True, text=True, check=True)
        errors = json.loads(done.stdout)["errors"]
        rows = volume_state.errors_in_words(errors)
        self.assertEqual(rows[0], ("corner XY", "2 \u00b5rad", "measured: EC0Y (square)"))
        self.assertEqual(rows[1][:2], ("corner XZ YZ", "unknown"))
        self.assertEqual(volume_state.errors_in_words([{**errors[1], "by": "EB0X, without u"}])[0][2], "EB0X, without u; measure: square and indicator, or diagonals of a part: plumb squareness or the page Measure and set up")
        self.assertIn(("lost motion X Y Z", "unknown", "measure: indicator, from both sides: plumb volume reversal"), rows)
        drift = {"kind": "drift", "state": "measured", "by": "x.csv", "how": ""}
        rows = volume_state.errors_in_words([{**drift, "name": "drift EXX", "u": 0.002, "unit": "mm"}, {**drift, "name": "drift EC0Y", "u": 4e-6, "unit": "rad"}])
        self.assertEqual([its[1] for its in rows], ["2 \u00b5m", "4 \u00b5rad"])
        self.assertLessEqual({its["how"] for its in errors}, set(panel_texts.of_error_list()))


class Rotary(unittest.TestCase):
    def test_errors_of_rotary_axes_that_are_set_are_shown_and_no_question(self):
        instance = Instance({"ec0y": 1e-5, "ey0a": 0.02, "ea0c": 3e-5, "ec0a": 0.0, "a-x-pivot": 5.0})
        self.assertEqual(squareness_state.rotary_errors(instance, {}), {"ey0a": 0.02, "ea0c": 3e-5})
        self.assertEqual(squareness_state.angles(instance, {}), {"ec0y": 1e-5})


class Answered(unittest.TestCase):
    def test_the_reason_of_a_refusal_is_its_first_line(self):
        question = volume_state.Question("/bin/sh", ["-c", "echo first >&2; echo second >&2; exit 1"])
        while not question.done():
            pass
        with self.assertRaisesRegex(volume_state.Lacks, "^first$"):
            question.answer()
        question = volume_state.Question("/bin/echo", [json.dumps({"U": 1})])
        while not question.done():
            pass
        self.assertEqual(question.answer(), {"U": 1})
        with self.assertRaises(volume_state.Lacks):
            volume_state.Question("/no/such/program", [])


if __name__ == "__main__":
    unittest.main()

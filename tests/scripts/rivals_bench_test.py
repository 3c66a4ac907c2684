# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/bench rivals: the rivals as they were, the contacts of a recording, the table, and what happens on the drawn days."""

import os
import random
import unittest

import numpy as np

import growth
from plumb_folder import TemporaryFolder
from support import contact_days, contacts, replay
from support.attacks import TEACH
from support.mill_machine import start_mill
from support.rivals import Both, Hold, Simple3, answers


# What each answers a second later, computed once: the offset of Hold; offset, sigma and told of Simple3 and of Both.
ALL_MOVE_AND_GO_BACK = (  # after a chip
    ("speed 0 0",),
    ("speed 3 5000",),
    ("contact 310 1001 1 2 1.5 1", 1.5, (0, 3.91719, 0), (0, 3.91719, 0)),
    ("contact 318 1002 1 2 2.4 1", 2.4, (0, 3.72649, 0), (0, 3.72649, 0)),
    ("contact 340 4001 4 2 0.4 1.5", 0.4, (0, 3.36853, 0), (0, 3.36853, 0)),
    ("contact 610 1001 1 3 4.1 1", 4.1, (1.19621, 4.17558, 0), (1.19621, 4.17558, 0)),
    ("contact 640 4001 4 3 3.3 1.5", 3.3, (1.70059, 3.6771, 0), (1.70059, 3.6771, 0)),
    ("speed 900 0",),
    ("contact 910 1001 1 4 35 1", 35, (0.42154, 6.12066, 0), (0.42154, 6.12066, 0)),
    ("contact 940 4001 4 4 4.4 1.5", 35, (2.56099, 3.92101, 0), (2.56099, 3.92101, 0)),
    ("contact 1210 1001 1 5 5.2 1", 5.2, (3.2866, 3.43022, 0), (3.2866, 3.43022, 0)),
    ("contact 1240 4001 4 5 4.9 1.5", 4.9, (4.10752, 2.97821, 0), (4.10752, 2.97821, 0)),
    ("speed 1300 4000",),
    ("contact 1510 1001 1 6 31 1", 31, (1.44183, 5.3328, 0), (1.44183, 5.3328, 0)),
    ("contact 1540 4001 4 6 30.5 1.5", 30.5, (1.17336, 5.64889, 6), (13.12116, 13.39411, 6)),
    ("contact 1810 1001 1 7 31.6 1", 31.6, (4.36596, 3.21141, 6), (14.14771, 13.09734, 6)),
    ("contact 1840 4001 4 7 30.9 1.5", 30.9, (5, 2.80872, 6), (14.06693, 13.05792, 6)),
    ("contact 2110 1001 1 8 5.5 1", 5.5, (2.34352, 4.96852, 6), (14.12161, 13.31316, 6)),
    ("contact 2140 4001 4 8 5.9 1.5", 5.9, (5, 3.195, 0), (5, 3.195, 0)),
    ("contact 2410 1001 1 9 5.9 1", 5.9, (5, 2.96502, 0), (5, 2.96502, 0)),
)
ONE_TOOL_MOVES = (
    ("speed 0 0",),
    ("contact 310 1001 1 2 0.5 1", 0.5, (0, 3.01365, 0), (0, 3.01365, 0)),
    ("contact 340 4001 4 2 0.4 1", 0.4, (0, 2.84597, 0), (0, 2.84597, 0)),
    ("contact 610 1001 1 3 0.9 1", 0.9, (0, 3.15647, 0), (0, 3.15647, 0)),
    ("contact 640 4001 4 3 30.8 1", 0.9, (0, 3.21585, 0), (0, 3.21585, 0)),
    ("contact 910 1001 1 4 1.4 1", 1.4, (0, 3.31623, 0), (0, 3.31623, 0)),
    ("contact 940 4001 4 4 31.9 1", 1.4, (0, 3.37103, 4), (0, 3.37103, 4)),
    ("contact 1210 1001 1 5 1.2 1", 1.2, (0, 3.26698, 4), (0, 3.26698, 4)),
    ("contact 1240 4001 4 5 31.2 1", 1.2, (0, 2.92998, 4), (0, 2.92998, 4)),
)

# Computed once, of 30 drawn_day(): the sums of the offsets and of the sigmas in um, and how often 4 and 6 were told.
DRAWN_DAYS = {Hold: (29513.4210, 14400.0000, 0, 0), Simple3: (19404.5097, 21782.1663, 5103, 738), Both: (15358.1252, 31786.6953, 5103, 738)}


def drawn_day(seed):
    """80 parts with two tools on a machine that wanders, jumps, has chips, tools of another length, and a night."""
    draw, lines, level, longer = random.Random(seed), ["speed 0 0"], 0.0, {1: 0.0, 4: 0.0}
    for cycle in range(2, 82):
        time = 300 * cycle + (40000 if cycle > 50 else 0)
        lines.append(f"speed {time - 200} {draw.choice((0, 3000, 8000))}")
        level += draw.gauss(0, 1.5)
        if draw.random() < 0.06:
            level += draw.choice((-1, 1)) * draw.uniform(8, 40)
        for key, tool, after in ((1001, 1, 10), (1002, 1, 18), (4001, 4, 40)):
            if draw.random() < 0.02:
                longer[tool] += draw.choice((-1, 1)) * draw.uniform(10, 40)
            sigma = draw.uniform(0.5, 3)
            chip = 30 * (draw.random() < 0.02)
            shown = level + longer[tool] + chip + draw.gauss(0, sigma)
            lines += [f"contact {time + after} {key} {tool} {cycle} {shown:.3f} {sigma:.3f}", f"cut {time + after + 5} 0 0 0 0"]
    return lines


class Rivals(unittest.TestCase):
    def test_they_answer_as_they_always_did(self):
        for day in (ALL_MOVE_AND_GO_BACK, ONE_TOOL_MOVES):
            lines, held = [], [its for its in day if len(its) > 1]
            for line, *expected in day:
                lines.append(line)
                if expected:
                    lines.append(f"cut {int(line.split()[1]) + 1} 0 0 0 0")
            np.testing.assert_allclose(answers(lines, Hold())["offset"], [its[1] for its in held], atol=1e-5)
            for rival, column in ((Simple3(), 2), (Both(), 3)):
                found = [tuple(its) for its in answers(lines, rival)]
                np.testing.assert_allclose(found, [its[column] for its in held], atol=1e-5, err_msg=type(rival).__name__)

    def test_each_of_their_constants_is_what_it_was(self):
        for rival, expected in DRAWN_DAYS.items():
            its = np.concatenate([answers(drawn_day(seed), rival()) for seed in range(30)])
            found = its["offset"].sum(), its["sigma"].sum(), np.sum(its["told"] == 4), np.sum(its["told"] == 6)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3, err_msg=rival.__name__)

    def test_one_that_knows_nothing_changes_nothing(self):
        for rival in (Hold(), Simple3(), Both()):
            self.assertEqual(rival.out(10)[0], 0)


def recording():
    """A reference cut and two later ones; a contact of the learning cycle, an accepted, a rejected and one that was not compared."""
    column = {name: np.zeros(12) for name in contacts.COLUMNS}
    column["time"] = np.arange(12.0)
    column["program.learn"][:3] = 1
    column["program.cycle-running"] = np.array([0, 1, 1, 0, 1, 1, 1, 1, 1, 1, 1, 0])
    column["program.cycle"] = np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2])
    column["program.truth-occurrence"][:] = 1
    column["program.truth-occurrence"][7:] = 2
    column["program.z-velocity-cmd"][:] = -1.5
    column["growth.spindle-speed-cmd"] = np.array([0, 5000, 5015, 5021, 0, 0, 0, 0, 0, 10, 10, 10])
    column["growth.contacts"] = np.array([0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4])
    column["growth.contact-operation"][:] = 10
    column["growth.contact-tool"][:] = 7
    column["growth.displacement"] = np.array([0, 1, 1, 1, 4, 4, 4, 40, 40, 40, 40, 40]) / 1000
    column["growth.displacement-sigma"][:] = 5 / 1000
    column["growth.offset-sigma"] = np.arange(12) / 1000
    column["growth.doubt"][7] = 1
    column["mill.truth-contacts"] = np.array([0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4])
    column["mill.truth-cuts"] = np.array([0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3])
    column["mill.truth-cut-operation"][:] = 10
    column["mill.truth-cut-error"] = np.array([0, 0, 1, 1, 1, 1, -5, -5, -5, -5, 9, 9]) / 1000
    column["mill.applied-offset"] = np.array([0, 0, 0, 0, 0, 2, 2, 2, 2, 3, 3, 3]) / 1000
    return column


class Recorded(unittest.TestCase):
    def lines(self, kind, column=None):
        column = column or recording()
        return [line for line in contacts.events(column, contacts.find_cuts(column), {1001: 3.0}) if line.startswith(kind)]

    def test_contacts_count_that_could_be_compared_accepted_or_not(self):
        self.assertEqual(self.lines("contact"), ["contact 4.0 1001 7 2 4.000 4.000 -1500.0 3.000", "contact 7.0 1002 7 2 40.000 5.000 -1500.0 0.000"])

    def test_a_cut_needs_the_offset_in_force_less_its_error_and_is_asked_before_it_begins(self):
        self.assertEqual(self.lines("cut"), ["cut 3.0 8.000 2.000 3.000 0", "cut 7.0 -5.000 3.000 7.000 1"])

    def test_a_first_part_after_a_start_tells_nothing(self):
        column = recording()
        column["growth.status-code"][:] = contacts.UNKNOWN
        self.assertEqual([line[-1] for line in self.lines("cut", column)], ["0", "0"])

    def test_speeds_are_told_that_differ_by_more_than_20_rpm_or_stop(self):
        self.assertEqual(self.lines("speed"), ["speed 0.0 0", "speed 1.0 5000", "speed 3.0 5021", "speed 4.0 0", "speed 9.0 10"])

    def test_events_come_in_the_order_of_time(self):
        self.assertEqual(self.lines("part"), ["part 1.0 1", "part 3.0 0", "part 4.0 1", "part 11.0 0"])
        times = [float(line.split()[1]) for line in self.lines("")]
        self.assertEqual(times, sorted(times))

    def test_files_of_a_class_lie_in_its_folder(self):
        with TemporaryFolder() as folder:
            contacts.write(folder, "load dead at 0, twice", 7, ["part 1.0 1"])
            with open(os.path.join(folder, "load-dead-at-0-twice", "7.txt"), encoding="ascii") as file:
                self.assertEqual(file.read(), "part 1.0 1\n")
        contacts.write(None, "nothing", 1, [])


GOOD = ["contact 1 1001 1 1 10 1 -1500 1", "cut 2 10 7 2 0", "cut 3 10 4 2 1", "contact 4 1001 1 2 12 1 -1500 1", "cut 5 -2 4 2 0"]


class Table(unittest.TestCase):
    def rows(self, found, **arguments):
        lines = replay.table("class", [replay.replayed(lines, **arguments) for lines in found])
        return {line.split()[0]: line for line in lines[3:]}

    def test_it_shows_errors_against_nothing_and_counts_cuts_and_machines(self):
        rows = self.rows([GOOD, GOOD])
        self.assertRegex(rows["none"], r"none +8\.25 +0\.0% +0 +0 \(<= 77\.6%\) +0\.0 ")  # sqrt((100 + 100 + 4) / 3)
        self.assertRegex(rows["Hold"], r"Hold +8\.08 +2\.0% +2 +2 \(<= 100\.0%\) +12\.0 +66\.7% +2\.0 ")  # 0, 0 and 14 wrong
        self.assertRegex(rows["thermal_displacement"], r" 5\.20 +37\.0% +0 +0 \(<= 77\.6%\) +4\.0 +33\.3% +2\.0 +33\.3% ")
        self.assertIn("+2.89 (+2.89 +2.89)", rows["Hold"])

    def test_a_difference_has_the_interval_of_a_draw_of_machines(self):
        bad = [line.replace("7 2 0", "90 2 0") for line in GOOD]
        machines = [replay.replayed(lines) for lines in (GOOD, GOOD, bad)]
        mean, low, high = replay.difference(machines, "thermal_displacement", "none")
        self.assertAlmostEqual(mean, np.sqrt((9 + 9 + 6400 + 3 * (36 + 36)) / 9) - np.sqrt(204 / 3))
        self.assertAlmostEqual(low, np.sqrt(27) - np.sqrt(68))  # none of the draw is the bad one
        self.assertGreater(high, mean)

    def test_a_sigma_counts_when_the_growth_is_known(self):
        machines = [[replay.replayed(lines)] for lines in (["cut 0 10 0 0 0", *GOOD], GOOD)]
        for way in ("Simple3", replay.COMPONENT):
            self.assertEqual(*(replay.within(machine, way) for machine in machines), way)

    def test_a_program_is_a_rival(self):
        def program(text):
            path = os.path.join(folder, "growth_replay")
            with open(path, "w", encoding="ascii") as file:
                file.write("#!/bin/sh\n" + text + "\n")
            os.chmod(path, 0o755)
            return path

        with TemporaryFolder() as folder:
            rows = self.rows([GOOD], program=program("awk '/^cut/ {print $3, 1, 0}'"))
            self.assertRegex(rows["filter"], r"filter +0\.00 +100\.0% ")
            with self.assertRaisesRegex(RuntimeError, "growth_replay: 1 lines for 3 cuts"):
                self.rows([GOOD], program=program("echo 1 2 0"))
            with self.assertRaisesRegex(RuntimeError, "growth_replay: no reference"):
                self.rows([GOOD], program=program("echo no reference >&2; exit 1"))

    def test_each_file_can_have_a_row_of_its_own(self):
        with TemporaryFolder() as folder:
            contacts.write(folder, "good days", 7, GOOD)
            contacts.write(folder, "good days", 8, ["part 1 1"])
            lines = replay.of_files([os.path.join(folder, "good-days", name) for name in ("7.txt", "8.txt")], each=True)
        self.assertEqual(len(lines), 2, "a machine that learned nothing removes nothing")
        self.assertRegex(lines[1], r"^good-days/7\.txt +3 +8\.2 +2\.0% \(1\) .* 37\.0% \(0\)$")

    def test_machines_that_learned_nothing_are_counted(self):
        self.assertEqual(replay.of_machines("class", [["part 1 1"]]), ["class: 1 machines learned nothing"])
        self.assertIn("class: 1 machines, 3 cuts", replay.of_machines("class", [["part 1 1"], GOOD]))


class Days(unittest.TestCase):
    def grown(self, change, seed):
        day = contact_days.Day("a day", seed, contact_days.DURATION, None)
        growth_of_day, speed = np.zeros(contact_days.DURATION + 1), np.full(contact_days.DURATION + 1, 3000.0)
        change(day, growth_of_day, speed)
        return growth_of_day, speed

    def test_a_seed_draws_the_phase_unless_it_is_given(self):
        phases = {contact_days.Day("a day", seed, 1, None).phase for seed in range(100)}
        self.assertEqual(phases, set(range(0, 280, 40)))
        self.assertEqual(contact_days.Day("a day", 1, 1, None, 17).phase, 17)

    def test_a_door_takes_18_um_in_a_minute_and_gives_them_back(self):
        both = 0
        for seed in range(20):
            its, _ = self.grown(contact_days.open_door, seed)
            self.assertAlmostEqual(its.min(), -18, delta=0.5)
            self.assertLess(abs(its[-1]), 1e-9)
            self.assertGreater(np.abs(its[60:] - its[:-60]).max(), 17)
            both += np.any((its[:-62] == 0) & (its[31:-31] < -17) & (its[62:] == 0))
        self.assertIn(both, range(5, 20), "some are open for a moment only")

    def test_a_stop_from_full_speed_takes_16_um_in_5_minutes_and_the_machine_comes_back_slowly(self):
        its, speed = self.grown(contact_days.stop, 3)
        lowest = np.argmin(its)
        self.assertAlmostEqual(its[lowest], -16, delta=0.1)
        self.assertEqual(speed[lowest], 0)
        self.assertEqual(speed[lowest - 310], 18000)
        self.assertTrue(-15 < its[lowest + 600] < -8)

    def test_a_step_returns_after_40_minutes(self):
        for seed in range(20):
            its, _ = self.grown(contact_days.step, seed)
            self.assertEqual(np.count_nonzero(its), 2400)
            self.assertTrue(12 <= abs(its).max() <= 25)


class Simulated(unittest.TestCase):
    def contacts_of(self, lines):
        return np.array([tuple(map(float, line.split()[1:])) for line in lines if line.startswith("contact")])

    def test_a_contact_shows_the_growth_whatever_offset_is_in_force(self):
        import plumb

        found, largest_offset = [], 0
        for dry_run in (False, True):
            with TemporaryFolder() as folder, plumb.Host() as host:
                start_mill(host, 0)
                for pin, value in growth.IDEAL.items():
                    host.set(pin, value)
                host.set("growth.dry-run", dry_run)
                path = os.path.join(folder, "recording.csv")
                host.record(path, contacts.COLUMNS, 0.1)
                host.run(2400)
                its = contacts.judge(host, path)
            found.append(self.contacts_of(its.lines)[:, 4])
            largest_offset = max(largest_offset, abs(its.cuts["offset"]).max())
        self.assertGreater(largest_offset, 20)
        self.assertLess(abs(np.mean(found[0] - found[1])), 0.05)  # um
        self.assertLess(abs(found[0] - found[1]).max(), 0.5)

    def test_another_latency_shifts_contacts_in_proportion_to_their_feed(self):
        its = self.contacts_of(contact_days.simulate("latency-5", 501, 0, True, lambda done: True))
        self.assertLess(np.median(its[:, 5]), 1, "the load of the typical machine is clean")
        moved = {}
        for key in np.unique(its[:, 1]):
            of_key = its[its[:, 1] == key]
            before, after = (of_key[(of_key[:, 0] > TEACH + begin) & (of_key[:, 0] < TEACH + begin + 900)] for begin in (-900, 0))
            moved[int(key)] = (np.mean(after[:, 4]) - np.mean(before[:, 4]), after[0, 6])
        near, slow = moved.pop(4001)
        far, fast = np.mean(list(moved.values()), axis=0)
        self.assertAlmostEqual(slow / fast, 0.6, delta=0.01)
        self.assertGreater(abs(far), 10)
        self.assertAlmostEqual(near / far, 0.6, delta=0.1)

    def test_in_a_night_the_contacts_step_and_the_cuts_only_if_it_is_growth(self):
        for truth, expected in (("stock", 0), ("growth", -25)):
            lines = contact_days.simulate(f"night-{truth}-25", 3, 0, True, lambda done: done < 6000)
            shown = self.contacts_of(lines)
            shown = shown[shown[:, 1] == 1001]
            stepped = np.argmin(np.diff(shown[:, 4]))
            self.assertAlmostEqual(shown[stepped + 1, 4] - shown[stepped, 4], -25, delta=5, msg=truth)
            cuts = np.array([tuple(map(float, line.split()[1:3])) for line in lines if line.startswith("cut")])
            before, after = (cuts[abs(cuts[:, 0] - time) < 100, 1] for time in shown[stepped : stepped + 2, 0])
            self.assertAlmostEqual(np.median(after) - np.median(before), expected, delta=3, msg=truth)

    def test_a_component_without_the_speed_sees_one_that_never_changes(self):
        lines = contact_days.simulate("nospeed", 3, 0, True, lambda done: done < 1200)
        self.assertEqual(len([line for line in lines if line.startswith("speed")]), 1)
        self.assertGreater(len(self.contacts_of(lines)), 2)


if __name__ == "__main__":
    unittest.main()

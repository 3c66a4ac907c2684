#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What scripts/campaign commission finds in the pins of each period: made recordings with one fault each."""

import unittest

import commissioning_attacks as attacks
import numpy as np

SHOP = attacks.MACHINE_OF["squareness"]
ROWS, BEGIN, END = 4000, 500, 1500  # of the recording, and of a press: the last beat comes half a second before its end
BACK = END + attacks.LAG


def recording(stage=0, function=-1, size=0.01):
    """A press at real time, whose client dies: the output rises, and returns at the ramp."""
    made = {name: np.zeros(ROWS) for name in ["scene", *SHOP.columns]}
    made["motion.motion-enabled"][:] = 1
    for kind, rows in (("function", SHOP.functions), ("stage", SHOP.stages)):
        for number in range(len(rows)):
            made["interlock.%s-identity-%d" % (kind, number)][:] = 7
    for short, value in (("stage", stage), ("function", function), ("offset", size)):
        pin = made["interlock.trial-" + short]
        pin[:] = -1 if short != "offset" else 0
        pin[BEGIN:] = value
    beats = np.arange(BEGIN, END - 500 + 1, 100)
    made["interlock.trial-beat"][:] = np.searchsorted(beats, np.arange(ROWS), "right") % 2
    rate = attacks.RAMP * attacks.PERIOD
    rises = np.clip((np.arange(ROWS) - BEGIN) * rate, 0, size)
    made["output"] = np.where(np.arange(ROWS) < BACK, rises, np.clip(size - (np.arange(ROWS) - BACK) * rate, 0, size))
    return made


def found(made, function="squareness", number=0, output=None):
    if number is not None:
        made[SHOP.stages[number] + ".drive-command"] = made.pop("output") if output is None else output
    return [sentence for _row, sentence in attacks.judge(made, function, 1)[0]]


class Judging(unittest.TestCase):
    def test_a_press_that_returns_at_its_ramp_is_no_finding(self):
        made = recording()
        presses = attacks.judge({**made, "x-stage.drive-command": made["output"]}, "squareness", 1)[1]
        self.assertEqual([(press.begin, press.end, press.stages) for press in presses], [(BEGIN, END, (0,))])
        self.assertEqual(found(made), [])

    def test_a_return_that_begins_late_or_takes_long_is_found(self):
        made = recording()
        self.assertIn("x-stage is 0.0100 from 0", " ".join(found(made, output=np.roll(made["output"], 400))))
        slow = np.where(np.arange(ROWS) < BACK, made["output"], 0.01 * np.exp(-(np.arange(ROWS) - BACK) / 500))
        self.assertIn("from 0", " ".join(found(recording(), output=slow)))

    def test_another_stage_that_moves_beside_a_press_is_found(self):
        made = recording()
        made["axis.z.eoffset"][1000:] = 0.03
        self.assertIn("z-axis-stage moved by 0.0300 beside a press of x-stage", found(made))

    def test_a_stage_that_goes_farther_than_it_is_asked_is_found(self):
        made = recording()
        self.assertIn("x-stage went to 0.0500 in a press of 0.0100", found(made, output=5 * made["output"]))

    def test_a_beat_that_comes_again_begins_no_press_and_a_motion_by_it_is_found(self):
        made = recording()
        made["interlock.trial-beat"][2500:] = np.arange(ROWS - 2500) // 100 % 2
        self.assertEqual(len(attacks.judge({**made, "x-stage.drive-command": made["output"]}, "squareness", 1)[1]), 1)
        again = made["output"].copy()
        again[2600:] = 0.01
        self.assertIn("x-stage, which has not passed, moved by 0.0100 without a press", found(made, output=again))

    def test_a_beat_of_the_press_before_begins_no_press(self):
        made = recording()
        late = BEGIN + 200  # 0.6 s after the last beat of the press before
        beats = np.r_[BEGIN - 400, np.arange(late, END - 500 + 1, 100)]
        made["interlock.trial-beat"][:] = np.searchsorted(beats, np.arange(ROWS), "right") % 2
        presses = attacks.judge({**made, "x-stage.drive-command": made["output"]}, "squareness", 1)[1]
        self.assertEqual([(press.begin, press.end) for press in presses], [(late, END)])

    def test_a_function_that_is_enabled_without_a_press_is_found(self):
        made = recording(stage=-1, function=1)
        made["interlock.function-enable-1"][BEGIN:END] = 1
        self.assertEqual(found(dict(made)), [])
        made["interlock.function-enable-1"][BEGIN : END + 100] = 1
        self.assertEqual(found(made), ["squareness is enabled without a press"])

    def test_a_stroke_that_goes_on_after_the_press_is_found(self):
        made = recording(stage=-1, function=2, size=0.5)
        made["interlock.stage-passed-2"][:] = 7
        stands = np.minimum(made["output"], made["output"][END])
        stands[END:] = stands[END]
        self.assertEqual(found(dict(made), "chopping", 2, stands), [])
        self.assertIn("the stroke went on by", " ".join(found(made, "chopping", 2, made["output"])))

    def test_an_offset_that_moves_with_the_machine_off_is_found(self):
        made = recording()
        made["interlock.stage-passed-0"][:] = 7
        made["motion.motion-enabled"][END - 300 :] = 0
        self.assertIn("x-stage moved by 0.0100 with the machine off", " ".join(found(made)))


if __name__ == "__main__":
    unittest.main()

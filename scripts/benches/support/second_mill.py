# SPDX-License-Identifier: GPL-2.0-or-later
"""A mill of another structure than sim_mill: its growth has two states, and its load a resonance, a clip and a sample time that jitters.

The front bearing warms within minutes and pulls the tip back; the housing warms within hours and pushes it out; the shop's air swings.
"""

import random

import numpy as np

from support.mill_machine import replay_growth

PART, CUTTING, PART_SPEED = 300, 60, 5000  # s, s, rpm: a part, and the speed while it is cut
JITTER = 10  # s between two sample times


def speeds(seed, duration):
    """rpm of the sides of the part, a value for each second."""
    draw = random.Random(f"second mill {seed}")
    found = []
    while len(found) <= duration:
        found += [0 if found and draw.random() < 0.12 else draw.uniform(2000, 8000)] * int(draw.uniform(1800, 5400))
    return np.array(found[: int(duration) + 1])


def growth(seed, size, speed):
    """mm, a value for each second, of a machine whose growth is `size` mm at its largest."""
    draw = random.Random(f"second growth {seed}")
    slow, quick = draw.uniform(3600, 10800), draw.uniform(120, 600)
    exponent, dip = draw.uniform(1.5, 1.9), draw.uniform(0.1, 0.3)
    air, turn, phase = size * draw.uniform(0.02, 0.08), draw.uniform(900, 1500), draw.uniform(0, 2 * np.pi)
    cutting = np.arange(len(speed)) % PART < CUTTING
    heat = size * (np.where(cutting, PART_SPEED, speed) / 8000) ** exponent
    out, back, found = 0.0, 0.0, np.empty(len(speed))
    for second, now in enumerate(heat):
        out += (1.4 * now - out) / slow
        back += (-dip * now - back) / quick
        found[second] = out + back + air * np.sin(2 * np.pi * second / turn + phase)
    found -= found[0]
    return found * (size / np.abs(found).max())


def prepare(host, seed, size, duration, folder):
    """Puts this growth and load in the place of sim_mill's and sim_drive_load's. Returns events: (time, function of the host)."""
    draw = random.Random(f"second load {seed}")
    speed = speeds(seed, duration)
    replay_growth(host, folder, range(len(speed)), growth(seed, size, speed), speed)
    for line in ("loadrt biquad names=resonance", "loadrt limit1 names=clip", "unlinkp growth.load", "net load => resonance.in",
                 "net ringing resonance.out => clip.in", "net clipped clip.out => growth.load"):  # fmt: skip
        host.command(line)
    host.set("resonance.f0", draw.uniform(15, 40))
    host.set("resonance.type", 1)  # a low pass
    host.set("resonance.Q", draw.uniform(0.8, 1.9))
    host.set("resonance.enable", True)
    host.set("clip.min", 0)
    host.set("clip.max", draw.uniform(25, 60))
    for line in ("addf resonance servo-thread", "addf clip servo-thread", "delf growth.update servo-thread", "addf growth.update servo-thread"):
        host.command(line)

    def sample(time):
        interval = draw.uniform(0.002, 0.012)
        return time, lambda host: host.set("drive.sample-time", interval)

    return [sample(time) for time in range(JITTER, int(duration), JITTER)]

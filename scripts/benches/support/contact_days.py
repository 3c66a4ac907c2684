# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawn days of the mill of configs/mill/bench.hal on which estimators of growth are compared.

A seed draws the machine, what happens on its day, and the phase of the parts: how long after the start of the day the first part
begins, from which the others follow every five minutes.
"""

import os
import random

import numpy as np

from support import contacts, second_mill
from support.attacks import SHIFTS, STOCK, TEACH, force
from support.mill_machine import begin_at, every_end_mill_is_a_gauge, learn_until_good, replay_growth, run_events, start_mill, unlink

RATE = 500  # Hz, of the servo thread
EVERY = 0.1  # s between two rows of a recording
PHASES = range(0, 280, 40)  # s
GROWTHS = (5, 10, 20, 48)  # um, of the machines on which something happens
DURATION = 10800  # s, of a day with fast growth
NIGHT = 8 * 3600  # s without an answer


class Day:
    """What a seed draws."""

    def __init__(self, name, seed, duration, folder, phase=None):
        self.seed, self.duration, self.folder = seed, duration, folder
        self.draw = random.Random(f"{name} {seed}")
        drawn = self.draw.choice(PHASES)
        self.phase = drawn if phase is None else phase

    def growth(self, size):
        """Growth in um and speed of a machine of second_mill's structure, a value for each second."""
        speed = second_mill.speeds(self.seed, self.duration)
        return 1000 * second_mill.growth(self.seed, size / 1000, speed), speed

    def replay(self, host, growth, speed):
        replay_growth(host, self.folder, range(len(speed)), growth / 1000, speed)


# --- what happens: prepare(host, day) returns events, pairs of a time and a function of the host ---


def first_plant(size):
    def prepare(host, day):
        host.set("mill.spindle-growth", size / 1000)
        return ()

    return prepare


def second_plant(size):
    return lambda host, day: second_mill.prepare(host, day.seed, size / 1000, day.duration, day.folder)


def shift(attack, size):
    def prepare(host, day):
        host.set("mill.spindle-growth", size / 1000)
        attack.prepare(host)
        return [(TEACH + day.phase + after, change) for after, change in attack.events]

    return prepare


def ramp(time, begin, lasts):
    return np.clip((time - begin) / lasts, 0, 1)


def open_door(day, growth, speed):
    """Twice down by 18 um in a minute and up again later, or both within a minute."""
    time = np.arange(len(growth))
    for begin in (day.draw.uniform(1800, 3600), day.draw.uniform(6000, 8000)):
        stays = day.draw.choice((0, day.draw.uniform(300, 2400)))
        lasts = 60 if stays else 30
        growth -= 18 * (ramp(time, begin, lasts) - ramp(time, begin + lasts + stays, lasts))


def stop(day, growth, speed):
    """From full speed: down by 16 um in five minutes, and slowly up again."""
    time = np.arange(len(growth))
    begin, slow = day.draw.uniform(3000, 4500), day.draw.uniform(1800, 5400)
    speed[int(begin) - 1500 : int(begin)] = 18000
    speed[int(begin) : int(begin) + 2400] = 0
    growth -= 16 * ramp(time, begin, 300) * np.exp(-np.maximum(time - begin - 300, 0) / slow)


def step(day, growth, speed):
    """Up or down, and back after 40 min."""
    time = np.arange(len(growth))
    begin, height = day.draw.uniform(2400, 4800), day.draw.uniform(12, 25) * day.draw.choice((-1, 1))
    growth += height * ((time >= begin) & (time < begin + 2400))


FAST = {"door": open_door, "stop": stop, "step": step}


def fast(change, size):
    """True growth that comes fast."""

    def prepare(host, day):
        growth, speed = day.growth(size)
        change(day, growth, speed)
        day.replay(host, growth, speed)
        return ()

    return prepare


def no_speed(host, day):
    """The component does not see the speed of the spindle."""
    day.replay(host, *day.growth(day.draw.uniform(40, 70)))
    unlink(host, "growth.spindle-speed-cmd", day.draw.choice((0, 5000)))
    return ()


def by_feed(size):
    """The load gets another latency, which shifts each contact in proportion to its feed. Operation 40 has 60 % of the feed."""

    def prepare(host, day):
        day.replay(host, *day.growth(size))
        every_end_mill_is_a_gauge(host)
        for line in FEEDS:
            host.command(line)
        feed = day.draw.uniform(1.3, 2)
        host.set("slowly.in0", 35)
        host.set("feed.in0", feed)
        host.set("feed.in1", 0.6 * feed)
        host.set("growth.load-latency", 0.03)
        other = 0.03 + day.draw.choice((-1, 1)) * day.draw.uniform(0.008, 0.025)
        return [(TEACH + day.phase, lambda host: host.set("growth.load-latency", other))]

    return prepare


FEEDS = (
    "loadrt conv_s32_float names=operation-number", "loadrt comp names=slowly", "loadrt mux2 names=feed",
    "net operation => operation-number.in", "net operation-number operation-number.out => slowly.in1",
    "net slowly slowly.out => feed.sel", "net contact-feed feed.out => program.contact-feed",
    "addf operation-number servo-thread", "addf slowly servo-thread", "addf feed servo-thread",
)  # fmt: skip


def night(height, is_growth):
    """A step of all contacts, of which nobody is asked: growth, or stock of another height."""

    def prepare(host, day):
        growth, speed = day.growth(day.draw.uniform(10, 40))
        begin = day.draw.uniform(2700, 4500)
        if is_growth:
            growth += height * (np.arange(len(growth)) >= begin)
        day.replay(host, growth, speed)
        return () if is_growth else [(begin, lambda host: force(host, STOCK, height=height / 1000))]

    return prepare


def all_days():
    """Name -> (duration, prepare)."""
    found = {}
    for size in (5, 12, 50):
        found[f"plant1-{size}"] = 5400, first_plant(size)
        found[f"plant2-{size}"] = 5400, second_plant(size)
    for size in GROWTHS:
        for number, attack in enumerate(SHIFTS, 1):
            found[f"shift{number}-{size}"] = 7200, shift(attack, size)
        for name, change in FAST.items():
            found[f"{name}-{size}"] = DURATION, fast(change, size)
        found[f"latency-{size}"] = DURATION, by_feed(size)
    found["nospeed"] = 6 * 3600, no_speed
    for height in (25, -25):
        for truth in ("stock", "growth"):
            found[f"night-{truth}{height:+d}"] = NIGHT + 5400, night(height, truth == "growth")
    return found


DAYS = all_days()


# --- run ---


def simulate(name, seed, phase, typical, progress):
    """The contact lines of a day; phase in s, None: drawn. The plants have none: their heat follows their parts.

    `typical`: program, mill and drive are those of the typical machine, whose load is clean. What happens is drawn all the same.
    """
    import plumb
    from plumb_folder import TemporaryFolder

    duration, prepare = DAYS[name]
    with TemporaryFolder() as folder, plumb.Host(options={"threads.period1": round(1e9 / RATE)}) as host:
        path = os.path.join(folder, "recording.csv")
        day = Day(name, seed, duration, folder, 0 if name.startswith("plant") else phase)
        start_mill(host, 0 if typical else seed)
        learn_until_good(host)
        events = [begin_at(host, day.phase), *prepare(host, day)]
        host.record(path, contacts.COLUMNS, EVERY)
        run_events(host, events, duration, progress)
        return contacts.judge(host, path).lines

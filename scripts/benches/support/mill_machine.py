# SPDX-License-Identifier: GPL-2.0-or-later
"""The mill of configs/mill/bench.hal in the virtual-time host."""

import os
import re

from support.recordings import write_rows
from support.simulations import ROOT

CONFIG = os.path.join(ROOT, "configs", "mill", "bench.hal")


def start_mill(host, seed):
    """Loads the configuration as machine `seed`; 0 is the typical one."""
    host.load(CONFIG)
    host.command("start")
    for part in ("program", "mill", "drive"):
        host.set(part + ".seed", seed)


def every_end_mill_is_a_gauge(host):
    host.set("growth.exclude-operation-1", 0)


def same_inputs(host, instance, other, without=()):
    """Nets the inputs of a second instance to the signals of the first one."""
    for line in host.halcmd("-s", "show", "pin", instance + ".*").output.splitlines():
        netted = re.search(r" %s\.(\S+) <== (\S+)" % instance, line)
        if netted and netted[1] not in without:
            host.command("net %s %s.%s" % (netted[2], other, netted[1]))


def run_events(host, events, duration, progress):
    """Runs until `duration`, or until progress() returns False. events: pairs of a time and a function of the host, which happens then."""
    done = 0
    for due, change in [*sorted(events, key=lambda event: event[0]), (duration, None)]:
        due = min(due, duration)
        if due > done:
            host.run(due - done, lambda its, done=done: progress(done + its))
            done = due
        if not progress(done) or done == duration:
            return
        change(host)


def unlink(host, pin, value):
    """A sensor that is gone: the pin keeps a value."""
    host.command(f"unlinkp {pin}")
    host.set(pin, value)


def begin_at(host, phase):
    """The event by which the first part begins `phase` s after the start."""
    host.set("program.run", False)
    return phase, lambda host: host.set("program.run", True)


def learn_until_good(host):
    """As an operator who reads the message that nothing was learned."""
    host.command("net learn-again growth.learning-failed => program.relearn")


def replay_growth(host, folder, times, growth, speeds):
    """Growth in mm in the place of the mill's own, and the speed in rpm at which the sides are milled."""
    path = os.path.join(folder, "growth.csv")
    write_rows(path, ["time", "mill.growth-replay", "program.sides-speed"], zip(times, growth, speeds))
    host.set("mill.use-replay", True)
    host.replay(path)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Many operators at once, each before a centre_height and a sim_lathe of his own, in one host.

An operator is a generator: it yields what it sets before a period, and the pins whose values it gets behind it. Pins are those of `centre`
and `lathe`, without the number of the instance.
"""

import functools
import itertools

AT_ONCE = 12
PERIOD = 0.001  # s
CONFIG = (
    "loadrt threads name1=servo-thread period1=1000000",
    "loadrt sim_lathe names=" + ",".join("lathe%d" % n for n in range(AT_ONCE)),
    "loadrt centre_height names=%s interlock=no" % ",".join("centre%d" % n for n in range(AT_ONCE)),
    *("addf %s%d.update servo-thread" % (name, n) for name in ("lathe", "centre") for n in range(AT_ONCE)),
    "start",
)
# So that no operator finds what another one has left.
SETTINGS = {"gauge-sigma": 0.002, "land-step": 0.2, "land-diameter": 0, "clearance-angle": 0, "x-is-radius": True, "largest-burr": 0, "max-move": 0.5, "max-x-correction": 0.5,
            "max-sigma": 0.02, "tolerance": 0.01, "pass-depth": 0, "enable": True, "air-cut-check": False, "stock-diameter": 0, "program-sign": 0, "second-diameter": 0, "x-zero-0": 0}


@functools.cache
def hall():
    """The host of this process, and the values that were set."""
    import plumb

    host = plumb.Host()
    for line in CONFIG:
        host.command(line)
    return host, {}


def numbered(n, name):
    return name.replace(".", "%d." % n, 1)


def settings(values):
    """What an operator sets first."""
    return {"centre." + name: value for name, value in (SETTINGS | values).items()}


def results(operators, progress):
    """What each of the operators returns, in their order; those that have ended if progress(their number) is False."""
    host, last = hall()
    waiting, at_work, ended = enumerate(operators), {}, {}
    answers = {}
    while True:
        for n in range(AT_ONCE):
            while n in at_work or (following := next(waiting, None)) is not None:
                if n not in at_work:
                    at_work[n] = [*following, {}, ()]
                its = at_work[n]
                try:
                    its[2:] = its[1].send(answers.pop(n, None))
                    break
                except StopIteration as end:
                    ended[its[0]] = end.value
                    del at_work[n]
        if not at_work or not progress(len(ended)):
            return [ended[number] for number in sorted(ended)]
        values = {numbered(n, name): value for n, its in at_work.items() for name, value in its[2].items()}
        host.set({name: value for name, value in values.items() if last.get(name) != value})
        last.update(values)
        host.run(PERIOD)
        wanted = [numbered(n, name) for n, its in at_work.items() for name in its[3]]
        found = iter(host.get(wanted) if wanted else ())
        answers = {n: list(itertools.islice(found, len(its[3]))) for n, its in at_work.items()}


# --- acts of an operator ---


def get(*pins):
    return (yield {}, ["centre." + pin for pin in pins])


def begin(values):
    """`values` of pins of centre_height."""
    yield {"centre." + pin: value for pin, value in values.items()} | {"centre.start": True}, ()
    yield {"centre.start": False}, ()


def end_of_cut(x, y):
    yield {"centre.x-position-0": x, "centre.y-position-0": y, "centre.cut-done": True, "centre.entered": False}, ()


def enter(diameter, second=0):
    yield {"centre.entered-diameter": diameter, "centre.second-diameter": second, "centre.cut-done": False, "centre.entered": True}, ()

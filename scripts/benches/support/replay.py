# SPDX-License-Identifier: GPL-2.0-or-later
"""Rivals over the files of support/contacts.py, and the table that compares them with thermal_displacement."""

import dataclasses
import os
import subprocess

import numpy as np

from support.figures import most_likely, rms
from support.rivals import ANSWER, SIMPLE, Both, answers
from support.simulations import BUILD

FILTER = os.path.join(BUILD, "bench", "growth_replay")  # the filter as it is now: a file to its stdin, "OFFSET SIGMA TOLD" of each cut from it
COMPONENT = "thermal_displacement"
RIVALS = {**SIMPLE, "Both": Both}
WORSE = 5  # um
BAD = 0.01  # part of the cuts of a machine
SAMPLES = 2000  # of a bootstrap


def of_program(lines, program):
    text = "".join(line + "\n" for line in lines)
    done = subprocess.run([program], input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{program}: {done.stderr.strip() or f'it ended with {done.returncode}'}")
    return np.array([tuple(map(float, line.split())) for line in done.stdout.splitlines()], ANSWER)


@dataclasses.dataclass
class Machine:
    needed: np.ndarray  # um, the offset that would have made each cut right
    answers: dict  # name -> rows of ANSWER


def replayed(lines, program=None):
    """A Machine, of nothing, the rivals, the program if there is one, and the component."""
    cuts = np.array([tuple(map(float, line.split()[2:])) for line in lines if line.startswith("cut ")], [("needed", float), *ANSWER])
    found = {"none": np.zeros(len(cuts), ANSWER)}
    found.update((name, answers(lines, rival())) for name, rival in RIVALS.items())
    if program:
        found["filter"] = of_program(lines, program)
        if len(found["filter"]) != len(cuts):
            raise RuntimeError(f"{program}: {len(found['filter'])} lines for {len(cuts)} cuts")
    found[COMPONENT] = cuts[[name for name, _ in ANSWER]]
    return Machine(cuts["needed"], found)


def read(path):
    with open(path, encoding="ascii") as file:
        return file.read().splitlines()


# --- the table ---


def errors(machine, way):
    return machine.answers[way]["offset"] - machine.needed


def worse(machine, way):
    """um by which each cut is worse than without compensation."""
    return abs(errors(machine, way)) - abs(machine.needed)


def difference(machines, way, other):
    """um by which the pooled rms of `way` is larger, with its 95 % interval over machines."""
    squares = np.array([[np.sum(errors(machine, its) ** 2) for its in (way, other)] for machine in machines])
    counts = np.array([len(machine.needed) for machine in machines])
    weights = np.random.default_rng(1).multinomial(len(machines), np.full(len(machines), 1 / len(machines)), SAMPLES)

    def of(weight):
        first, second = np.sqrt(weight @ squares / (weight @ counts)[..., None]).T
        return first - second

    return of(np.ones(len(machines))), *np.percentile(of(weights), (2.5, 97.5))


def within(machines, way):
    """Part of the cuts with a known growth whose error is within two sigma, and the median sigma."""
    sigma = np.concatenate([machine.answers[way]["sigma"] for machine in machines])
    known = (sigma > 0) & (sigma < 99)
    if not known.any():
        return np.nan, np.nan
    error = np.concatenate([errors(machine, way) for machine in machines])
    return np.mean(abs(error[known]) <= 2 * sigma[known]), np.median(sigma[known])


def table(name, machines):
    """Its lines, of Machines with cuts."""
    against = [*SIMPLE, COMPONENT]
    cuts, width = sum(len(machine.needed) for machine in machines), len(COMPONENT) + 1
    lines = [
        f"{name}: {len(machines)} machines, {cuts} cuts",
        f"{'':{width + 70}}{'rms less that of ... (95 % of the machines)':>66}",
        f"{'um':{width}}{'rms':>7}{'removed':>9}{f'> {WORSE} worse':>10}{'machines > 1 %':>16}{'largest':>9}{'2 sigma':>8}{'sigma':>6}{'told':>7}"
        + "".join(f"{other:>23}" for other in against),
    ]
    without = rms(np.concatenate([machine.needed for machine in machines]))
    for way in machines[0].answers:
        error = rms(np.concatenate([errors(machine, way) for machine in machines]))
        bad = [np.count_nonzero(worse(machine, way) > WORSE) for machine in machines]
        many = sum(count > BAD * len(machine.needed) for count, machine in zip(bad, machines))
        inside, sigma = within(machines, way)
        told = np.mean(np.concatenate([machine.answers[way]["told"] for machine in machines]) > 0)
        cells = f"{error:7.2f}{1 - error / without:9.1%}{sum(bad):10d}{f'{many} (<= {most_likely(many, len(machines)):.1%})':>16}"
        cells += f"{max(worse(machine, way).max() for machine in machines):9.1f}"
        cells += f"{inside:8.1%}{sigma:6.1f}" if np.isfinite(inside) else f"{'-':>8}{'-':>6}"
        cells += f"{told:7.1%}"
        for other in against:
            text = "-" if way == other else "{:+.2f} ({:+.2f} {:+.2f})".format(*difference(machines, way, other))
            cells += f"{text:>23}"
        lines.append(f"{way:{width}}{cells}")
    return lines


def removed(machine, way):
    """Part of the rms error that this way removes."""
    return 1 - rms(errors(machine, way)) / rms(machine.needed)


def each_machine(machines):
    """The lines of a table with a row for each of the Machines, by name: the part that each way removes, and the cuts more than WORSE um worse."""
    width = max(map(len, machines)) + 2
    ways = [way for way in next(iter(machines.values())).answers if way != "none"]
    lines = [f"{f'removed (> {WORSE} um worse)':{width}}{'cuts':>7}{'none, um':>10}" + "".join(f"{way:>22}" for way in ways)]
    for name, machine in machines.items():
        cells = "".join(f"{f'{removed(machine, way):.1%} ({np.count_nonzero(worse(machine, way) > WORSE)})':>22}" for way in ways)
        lines.append(f"{name:{width}}{len(machine.needed):7d}{rms(machine.needed):10.1f}{cells}")
    return lines


def the_program():
    return FILTER if os.access(FILTER, os.X_OK) else None


def of_machines(name, found):
    """The lines of the table of a class; found: the contact lines of each machine."""
    machines = [machine for machine in (replayed(lines, the_program()) for lines in found) if len(machine.needed)]
    silent = [f"{name}: {len(found) - len(machines)} machines learned nothing"] if len(machines) < len(found) else []
    return silent + (table(name, machines) if machines else [])


def of_files(paths, each=False):
    """The lines of the tables of contact files: those of one folder are a class. `each`: one table with a row for each file."""
    names = {path: os.path.abspath(path).split(os.sep)[-2:] for path in paths}
    if each:
        machines = {"/".join(names[path]): replayed(read(path), the_program()) for path in paths}
        return each_machine({name: machine for name, machine in machines.items() if len(machine.needed)})
    classes = {}
    for path in paths:
        classes.setdefault(names[path][0], []).append(read(path))
    return [line for name, found in classes.items() for line in (*of_machines(name, found), "")]

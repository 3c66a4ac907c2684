# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs the commands of configs/growth/README.md on drawn machines in complete LinuxCNCs, and counts the good tries.

The commands stand as in the README: the test of the machine, its report, the settings of axis_growth, a second test with them, its
report, and the plans. The number of the machine is a line at the end of accelerated.hal; a command that needs a screen is left out.
A try is good if each command succeeds, each axis is corrected or a sentence says why not, the second verdict is pass, and no
sentence contradicts a figure of its report.
"""

import glob
import json
import os
import re
import subprocess

from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.simulations import BUILD, ROOT, simulate_all

TARGETS = "product"
README = os.path.join(ROOT, "configs", "growth", "README.md")
WITH_SCREEN = "linuxcnc axis.ini"
GOOD_GAIN = (0.9, 1.15)
# LinuxCNC's programs and Plumb's programs print these lines if a run ends early.
SAID = re.compile(r"(plumb \w+|Growth test|Interlock|LinuxCNC|\S+\.ngc|.* aborted|.* (does|did) not answer|Queue is|Probe)\b.*(?<!instead of \d\d)$")


def main():
    parser = new_parser("growth_readme", __doc__)
    parser.add_argument("--seeds", type=whole(1, 10000), default=20, metavar="N", help="machines (default: 20)")
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first of them")
    parser.add_argument("--set", action="append", default=[], metavar="PIN=VALUE", help="one more line of accelerated.hal; may be repeated")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        lines = ["setp %s %s" % tuple(text.split("=", 1)) for text in options.set]
        tasks = [(seed, lines) for seed in range(options.seed, options.seed + options.seeds)]
        found = simulate_all(simulate, tasks, len(tasks), place_of(options))
        print("\n".join(figures(dict(zip((seed for seed, _ in tasks), found)))))


def commands():
    """The commands of the README's code blocks, in their order; the command that ends in the folder of the machine comes first."""
    with open(README, encoding="utf-8") as file:
        lines = re.findall(r"(?m)^    (\S.*)$", file.read())
    return [line for line in lines if line != WITH_SCREEN]


def simulate(seed, lines, progress):
    """The outcome of one try."""
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder:
        outcome = run(folder, ["setp artifact.seed %d" % seed, *lines])
        machine = os.path.join(folder, "growth")
        tests = [results(machine, place) for place in ("first", "logs")]
    progress(1)
    return {"seed": seed, **outcome, "tests": tests}


def run(folder, lines):
    """Runs all commands in one shell; the command that failed, with its last lines, or "", and the output of each."""
    first, *rest = commands()
    script = ["set -e", first, "cat >>accelerated.hal <<'end'", *lines, "end"]
    for index, command in enumerate(rest):
        script += ["echo %d >running" % index, "{ %s ; } >output-%d 2>&1" % (command, index) if ">" not in command else command + " 2>output-%d" % index]
    environment = {**os.environ, "HOME": folder, "PATH": os.path.join(BUILD, "bin") + ":" + os.environ["PATH"]}
    done = subprocess.run(["bash", "-c", "\n".join(script)], cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    machine = os.path.join(folder, "growth")
    outputs = []
    for index in range(len(rest)):
        path = os.path.join(machine, "output-%d" % index)
        if os.path.exists(path):
            with open(path, encoding="utf-8", errors="replace") as file:
                outputs.append(file.read())
    failed = ""
    if done.returncode != 0:
        command = rest[len(outputs) - 1] if outputs else first
        said = (outputs[-1] if outputs else done.stderr).splitlines()
        failed = "%s: %s" % (command, " / ".join([line for line in said if SAID.match(line)][-4:] or said[-1:]))
    return {"failed": failed, "outputs": outputs}


def results(machine, place):
    """The first test of results.json beside the log in a folder; None if there is none."""
    for path in glob.glob(os.path.join(machine, place, "growth-*-report", "results.json")):
        with open(path, encoding="utf-8") as file:
            return json.load(file)["tests"][0]
    return None


def contradictions(test):
    """The sentences of a report that its own figures contradict."""
    found, sentence = [], test["compensation"]["sentence"]
    gains = {letter: axis["gain"] for letter, axis in test["axes"].items()}
    if sentence.startswith("The compensation removes the drift"):
        for letter, gain in gains.items():
            out = gain["determined"] and not GOOD_GAIN[0] - 2 * gain["uncertainty"] <= gain["value"] <= GOOD_GAIN[1] + 2 * gain["uncertainty"]
            if out and "But %s," % letter not in sentence:
                found.append("%s: gain %.2f, and the report says: %s" % (letter, gain["value"], sentence))
    if "does nothing" in sentence and any(abs(value) > 5e-3 for series in test["series"] if series["compensated"] for point in series["points"] for value in point["compensation_mm"]):
        found.append("the compensation moved an axis by more than 5 um, and the report says: " + sentence)
    for letter, axis in (test["identified"] or {"axes": {}})["axes"].items():
        rests = [axis["predicted_rest_mm"], axis["none_rest_mm"], axis["line_rest_mm"]]
        if axis["used"] and rests[0] > min(rests[1:]) or not axis["used"] and rests[2] < rests[1]:
            found.append("%s: %s, but of later parts %.1f um remain, %.1f without a law, %.1f by the best temperature"
                         % (letter, "corrected" if axis["used"] else "not corrected", *(1e3 * rest for rest in rests)))
    return found


def judged(outcome):
    """The faults of a try, a sentence for each fault."""
    first, second = outcome["tests"]
    wrong = [outcome["failed"]] if outcome["failed"] else []
    for name, test in (("first", first), ("second", second)):
        if test is None:
            wrong.append("there is no report of the %s test" % name)
        else:
            wrong += ["%s test: %s" % (name, text) for text in contradictions(test)]
    if first is not None and first["identified"] is None:
        wrong.append("no law: " + first["not_identified"])
    if second is not None and second["verdict"] != "pass":
        wrong.append("the second verdict is %s: %s" % (second["verdict"], " ".join(second["reasons"])))
    return wrong


def row(outcome):
    first, second = outcome["tests"]

    def drifts(test):
        if test is None:
            return "%24s%24s%16s" % ("-", "-", "-")
        states = ["/".join("%.1f" % (1e3 * axis[state]["largest_mm"]) if axis[state] else "-" for axis in test["axes"].values()) for state in ("off", "on")]
        return "%24s%24s%16s" % (*states, test["verdict"])

    law = (first or {}).get("identified")
    used = "".join(letter for letter, axis in law["axes"].items() if axis["used"]) if law else "-"
    return "%7d%s%11s%s" % (outcome["seed"], drifts(first), used or "none", drifts(second))


def figures(found):
    lines = ["%-7s%64s%11s%64s" % ("machine", "first test: off, on, X/Y/Z um, verdict", "corrected", "second test: off, on, X/Y/Z um, verdict")]
    lines += [row(outcome) for outcome in found.values()]
    wrong = {seed: judged(outcome) for seed, outcome in found.items()}
    laws = [test["identified"] for test, _ in (outcome["tests"] for outcome in found.values()) if test and test["identified"]]
    axes = [axis for law in laws for axis in law["axes"].values()]
    lines += ["", "good: %d of %d tries; corrected: %d of %d axes" % (sum(not its for its in wrong.values()), len(found), sum(axis["used"] for axis in axes), len(axes))]
    lines += ["machine %d: %s" % (seed, text) for seed, its in wrong.items() for text in its]
    return lines

# SPDX-License-Identifier: GPL-2.0-or-later
"""Common parts of all campaigns: seeds, time, findings, and a record by which the next run goes on.

A campaign is a module beside this one that calls run() with a function attack(seed). The same seed attacks in the same
way. The record lies in build/campaigns/NAME.json.
"""

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections import namedtuple

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUILD = os.environ.get("PLUMB_BUILD", os.path.join(ROOT, "build"))
sys.path.append(os.path.join(ROOT, "hal", "client"))  # plumb_folder, before anything is built

# tries: how many attacks a seed stands for; findings: a list of sentences, empty if all is well.
Outcome = namedtuple("Outcome", "tries findings")


def run(name, summary, attack, setup=("product",), add_options=lambda parser: None, prepare=lambda options: None):
    """Runs attack(seed) -> Outcome until the time or the count is over, and ends the program.

    setup: the target that scripts/setup builds first.  add_options(parser) may add options; prepare(options) is called
    once before the first attack. The exit status is 1 where anything was found in this run.
    """
    parser = argparse.ArgumentParser(prog=f"scripts/campaign {name}", description=summary)
    limits = parser.add_mutually_exclusive_group()
    limits.add_argument("--for", type=seconds_of, dest="duration", metavar="TIME", help="such as 90s, 10min or 2h (default: 10min)")
    limits.add_argument("--count", type=_whole, metavar="N", help="this many seeds")
    parser.add_argument("--seed", type=_whole, metavar="N",
                        help="repeat this seed alone, or begin with it where --for or --count is given; the record stays as it is")
    parser.add_argument("--fresh", action="store_true", help="forget the record and begin with seed 1")
    add_options(parser)
    options = parser.parse_args()
    try:
        if "PLUMB_BUILD" not in os.environ:
            subprocess.run([os.path.join(ROOT, "scripts", "setup"), *setup], check=True)
        prepare(options)
        alone = options.seed and not options.duration and not options.count
        sys.exit(_repeat(attack, options.seed) if alone else _campaign(name, attack, options))
    except KeyboardInterrupt:
        sys.exit(130)
    except (OSError, RuntimeError, subprocess.CalledProcessError) as error:
        sys.exit(f"scripts/campaign {name}: {error}")


def of_tests(names, variable):
    """The attack of tests in C++, which draw by the seed in a variable of the environment and print how many cases they tried."""

    def attack(seed):
        found = subprocess.run([os.path.join(BUILD, "tests", "tests"), "--gtest_filter=" + names], capture_output=True, text=True, check=False,
                               env={**os.environ, variable: str(seed)})
        tries = sum(map(int, re.findall(r"^cases: (\d+)$", found.stdout, re.M)))
        findings = [text.strip() for text in re.findall(r"^(\S+: Failure\n.*?)(?=^\[ |^\S+: Failure)", found.stdout, re.M | re.S)]
        if not tries or (found.returncode and not findings):
            findings.append(f"the tests ended with status {found.returncode}: " + (found.stdout + found.stderr)[-2000:])
        return Outcome(tries, findings)

    return attack


def seconds_of(text):
    """ "90" and "90s" -> 90, "10min" -> 600, "2h" -> 7200."""
    match = re.fullmatch(r"(\d{1,6}(?:\.\d+)?)(s|min|h)?", text)
    if not match or float(match[1]) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a time such as 90s, 10min or 2h")
    return float(match[1]) * {None: 1, "s": 1, "min": 60, "h": 3600}[match[2]]


def _whole(text):
    if not re.fullmatch(r"[1-9]\d{0,9}", text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 on")
    return int(text)


def _repeat(attack, seed):
    outcome = attack(seed)
    for finding in outcome.findings:
        print(f"seed {seed}: {finding}")
    print(f"seed {seed}: {outcome.tries} tries, {len(outcome.findings)} findings")
    return 1 if outcome.findings else 0


def _campaign(name, attack, options):
    path = None if options.seed else os.path.join(BUILD, "campaigns", name + ".json")
    record = Record(path, options.fresh)
    if options.seed:
        record.next_seed = options.seed
    began, first, found = time.monotonic(), record.next_seed, 0
    stopping = []
    signal.signal(signal.SIGTERM, lambda *_: stopping.append(True))
    duration = options.duration or (None if options.count else 600)
    while not stopping:
        spent = time.monotonic() - began
        done = record.next_seed - first
        if (options.count and done >= options.count) or (duration and spent >= duration):
            break
        seed, before = record.next_seed, time.monotonic()
        try:
            outcome = attack(seed)
        except KeyboardInterrupt:
            print(f"Interrupted in seed {seed}; the next run begins with it.", file=sys.stderr)
            break
        record.add(outcome, time.monotonic() - before)
        found += len(outcome.findings)
        for finding in outcome.findings:
            print(f"seed {seed}: {finding}", flush=True)
    last = record.next_seed - 1
    print(f"This run: seeds {first} to {last}, {found} findings." if last >= first else "This run: no seed.")
    begin = first if options.seed else 1
    print(f"In all: seeds {begin} to {last}, {record.tries} tries in {record.seconds / 3600:.2f} h, {len(record.findings)} findings.")
    return 1 if found else 0


class Record:
    """All tries so far, in a file that is replaced as a whole; without a path, the tries of this run."""

    def __init__(self, path, fresh=False):
        self.path, self.next_seed, self.tries, self.seconds, self.findings = path, 1, 0, 0.0, []
        if fresh or path is None or not os.path.exists(path):
            return
        try:
            with open(path, encoding="utf-8") as file:
                stored = json.load(file)
            self.next_seed, self.tries = int(stored["next_seed"]), int(stored["tries"])
            self.seconds, self.findings = float(stored["seconds"]), list(stored["findings"])
        except (ValueError, KeyError, TypeError) as error:
            raise RuntimeError(f"{path} is not a record of a campaign ({error}); --fresh begins a new one") from error

    def add(self, outcome, seconds):
        self.findings += [{"seed": self.next_seed, "text": text} for text in outcome.findings]
        self.next_seed += 1
        self.tries += outcome.tries
        self.seconds += seconds
        if self.path is None:
            return
        os.makedirs(os.path.dirname(self.path), exist_ok=True)
        with open(self.path + ".new", "w", encoding="utf-8") as file:
            json.dump({"next_seed": self.next_seed, "tries": self.tries, "seconds": self.seconds, "findings": self.findings}, file, indent=1)
        os.replace(self.path + ".new", self.path)

# SPDX-License-Identifier: GPL-2.0-or-later
"""LinuxCNC's own regression tests with the virtual-time host, beside the same with LinuxCNC's own realtime side.

The tests come from the source package of the installed LinuxCNC, unmodified. A folder is a test if it has a
test.hal, which halrun runs, or a test.sh, which bash runs. It passes when that succeeds, and then its checkresult does, or
else its output is the file `expected`.
"""

import argparse
import asyncio
import contextlib
import dataclasses
import difflib
import filecmp
import os
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import time

import stock_linuxcnc

BUILD = os.environ.get("PLUMB_BUILD", os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "build"))

WORK = os.path.join(BUILD, "linuxcnc-tests")

WHOLE = (  # tests that start a complete LinuxCNC, and need no network, no window and no compiler
    "startup-state",
    "linuxcncrsh",
    "abort/g64",
    "mdi-queue/simple-queue-buster",
    "single-step",
    "tlo",
    "t0/nonrandom",
    "interp/subroutine-return",
    "motion/jogwheel-joint",
    "toolchanger/m61",
    "lathe",
    "halui/mdi",
)
NOT_HALRUN_ALONE = ("linuxcnc", "halcompile", "python")  # a test.sh with one of these words needs more than halrun

LIMIT = {"halrun": 60, "whole": 300}  # s, of this machine's time
MOST_OVERRUNS = 10  # a sampler that overran proves nothing about the test, which is run again


class Trouble(Exception):
    """A reason for which no test can run."""


# --- where the tests come from ---


def output_of(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise Trouble(f"{' '.join(command)}\n{done.stderr.strip()}")
    return done.stdout


def fetched():
    """The folder of LinuxCNC's tests; from Debian's source package, when it is not here yet."""
    version = output_of("dpkg-query", "-W", "-f", "${source:Version}", "linuxcnc-uspace")
    folder = os.path.join(WORK, version)
    if not os.path.isdir(folder):
        print(f"Fetching the source package of linuxcnc {version}", file=sys.stderr)
        download = os.path.join(WORK, "download")
        shutil.rmtree(download, ignore_errors=True)
        fetch_source_package(version, download)
        unpack_tests(download)
        os.rename(os.path.join(download, "tests"), folder)
        shutil.rmtree(download)
    return folder


def fetch_source_package(version, folder):
    """With lists of its own, so that the package sources of the machine stay as they are."""
    sources = set()
    for line in output_of("apt-cache", "madison", "linuxcnc-uspace").splitlines():
        _, _, (uri, suite, *_) = (part.split() for part in line.split("|"))
        sources.add(f"deb-src {uri} {suite.replace('/', ' ')}\n")
    if not sources:
        raise Trouble("No package source of this machine has linuxcnc-uspace; Debian 12 and 13 have it.")
    for name in ("lists/partial", "cache/archives/partial"):
        os.makedirs(os.path.join(folder, name))
    with open(os.path.join(folder, "sources.list"), "w", encoding="ascii") as file:
        file.writelines(sorted(sources))
    apt = ["apt-get", "-q"]
    for option, value in {
        "Dir::Etc::SourceList": os.path.join(folder, "sources.list"),
        "Dir::Etc::SourceParts": "/dev/null",
        "Dir::State::Lists": os.path.join(folder, "lists"),
        "Dir::Cache": os.path.join(folder, "cache"),
        "APT::Sandbox::User": "root",  # else root's folder is not apt's own user's to write
    }.items():
        apt += ["-o", f"{option}={value}"]
    for command in (["update"], ["source", "--download-only", f"linuxcnc={version}"]):
        if subprocess.run(apt + command, cwd=folder, stdout=sys.stderr).returncode:
            raise Trouble(f"apt-get {command[0]} failed; it needs the network.")


def unpack_tests(folder):
    names = os.listdir(folder)
    original = next(name for name in names if ".orig.tar." in name)
    changes = next((name for name in names if ".debian.tar." in name), None)
    if changes:
        with tarfile.open(os.path.join(folder, changes)) as archive:
            for member in archive:
                text = archive.extractfile(member).read() if member.isfile() else b""
                if "/patches/" in member.name and re.search(rb"^[-+]{3} \S+?/tests/", text, re.MULTILINE):
                    raise Trouble(f"{member.name} changes the tests; the original ones are not in the package.")
    with tarfile.open(os.path.join(folder, original)) as archive:
        for member in archive:
            path = member.name.split("/", 1)
            if len(path) == 2 and path[1].startswith("tests/"):
                member.name = path[1]
                archive.extract(member, folder)


def need_spaces(folder):
    command = stock_linuxcnc.closed_in(["true"], folder)
    done = subprocess.run(command, cwd=folder, env=stock_linuxcnc.ENVIRONMENT, capture_output=True, text=True)
    if done.returncode:
        raise Trouble(f"This kernel gives no namespaces to run stock LinuxCNC in: {done.stderr.strip()}")


# --- which tests there are ---


@dataclasses.dataclass(frozen=True)
class Test:
    name: str  # of its folder
    script: str  # test.hal or test.sh
    group: str
    skipped: bool = False


def is_skipped(folder):
    """Whether LinuxCNC skips the test: it has a file `skip` that is no program, or that fails when it is run."""
    skip = os.path.join(folder, "skip")
    if not os.path.exists(skip):
        return False
    return not os.access(skip, os.X_OK) or subprocess.run([skip], cwd=folder).returncode != 0


def needs_halrun_only(path):
    if path.endswith(".hal"):
        return True
    with open(path, encoding="utf-8") as file:
        text = file.read()
    return "halrun" in text and not any(word in text for word in NOT_HALRUN_ALONE)


def halrun_tests(source):
    tests = []
    for folder, _, files in os.walk(source):
        for script in {"test.hal", "test.sh"}.intersection(files):
            if needs_halrun_only(os.path.join(folder, script)):
                tests.append(Test(os.path.relpath(folder, source), script, "halrun", is_skipped(folder)))
    return sorted(tests, key=lambda test: test.name)


def whole_tests():
    return [Test(name, "test.sh", "whole") for name in WHOLE]


# --- run them ---


@dataclasses.dataclass(frozen=True)
class Side:
    """The realtime side of a test."""

    name: str
    speed: str = ""  # of the host; "" is LinuxCNC's own realtime side

    def command(self, program, box):
        if not self.speed:
            return stock_linuxcnc.closed_in(program, box)
        speed = ["--free"] if self.speed == "free" else ["--speed", self.speed]
        return ["setpriv", "--pdeathsig", "TERM", os.path.join(BUILD, "bin", "plumb"), "run", *speed, "--", *program]

    @property
    def end_signal(self):
        return signal.SIGTERM if self.speed else signal.SIGKILL


STOCK = Side("stock")


def host(speed):
    return Side("host free" if speed == "free" else f"host {speed}x", speed)


@dataclasses.dataclass
class Outcome:
    """The result of a test that was run once, or until it passed."""

    failure: str = ""  # the reason, with the folder to look at
    seconds: float = 0.0
    tries_before: list = dataclasses.field(default_factory=list)  # their failures


async def end(process, end_signal):
    if process.returncode is not None:
        return
    for number in (end_signal, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(process.wait(), 5)
            return


async def run_script(test, side, box):
    """Runs the test that is in the box.

    Returns its exit status, or None when it did not end in time. Its output is in the files result and stderr.
    """
    folder = os.path.join(box, test.name)
    program = ["halrun", "-f", test.script] if test.script == "test.hal" else ["bash", "-x", test.script]
    environment = dict(stock_linuxcnc.ENVIRONMENT)
    environment["PATH"] = folder + ":" + environment["PATH"]
    environment["TEST_DIR"] = folder
    if side.speed:
        environment["HOME"] = os.path.join(box, "home")
        os.mkdir(environment["HOME"])
    with open(os.path.join(folder, "result"), "wb") as out, open(os.path.join(folder, "stderr"), "wb") as err:
        process = await asyncio.create_subprocess_exec(
            *side.command(program, box),
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            start_new_session=True,  # Ctrl-C is for this script, which ends its children
        )
        try:
            return await asyncio.wait_for(asyncio.shield(process.wait()), LIMIT[test.group])
        except asyncio.TimeoutError:
            return None
        finally:
            await end(process, side.end_signal)


def differences(folder):
    texts = []
    for name in ("expected", "result"):
        with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
            texts.append(file.read().splitlines())
    lines = list(difflib.unified_diff(*texts, "expected", "result", lineterm=""))
    return "\n".join(lines[:40] + [f"({len(lines) - 40} more lines)"] * (len(lines) > 40))


def judge(status, folder):
    """The failure; "" without one."""
    if status is None:
        return "did not end in time"
    if status:
        return f"ended with status {status}"
    result = os.path.join(folder, "result")
    check = os.path.join(folder, "checkresult")
    if os.path.exists(check):
        done = subprocess.run(
            [check, result],
            cwd=folder,
            env=stock_linuxcnc.ENVIRONMENT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        return f"its checkresult ended with status {done.returncode}\n{done.stdout}" if done.returncode else ""
    if not os.path.exists(os.path.join(folder, "expected")):
        return "has neither checkresult nor expected"
    if filecmp.cmp(result, os.path.join(folder, "expected"), shallow=False):
        return ""
    return "printed something else than expected\n" + differences(folder)


def overran(folder):
    with open(os.path.join(folder, "result"), "rb") as file:
        return b"overrun" in file.read().splitlines()


class Runner:
    """Runs tests, each on a private copy, so many at a time."""

    def __init__(self, source, runs, jobs):
        self._source = source
        self._runs = runs
        self._free = asyncio.Semaphore(jobs)
        self._serial = 0
        shutil.rmtree(runs, ignore_errors=True)

    async def run(self, test, side):
        """Runs the test until it passes: once more after a failure, and up to ten times after overruns."""
        if test.skipped:
            return None
        async with self._free:
            outcome = Outcome()
            failures = 0
            for attempt in range(MOST_OVERRUNS):
                if attempt:
                    outcome.tries_before.append(outcome.failure)
                outcome.failure, overrun = await self._attempt(test, side, outcome)
                failures += bool(outcome.failure) and not overrun
                if not (outcome.failure and failures < 2 or overrun):
                    break
            return outcome

    async def _attempt(self, test, side, outcome):
        self._serial += 1
        box = os.path.join(self._runs, side.name.replace(" ", "-"), f"{test.name.replace('/', '_')}.{self._serial}")
        top = test.name.split("/")[0]  # tests of a family share files
        shutil.copytree(os.path.join(self._source, top), os.path.join(box, top), symlinks=True)
        folder = os.path.join(box, test.name)
        began = time.monotonic()
        try:
            status = await run_script(test, side, box)
        except asyncio.CancelledError:
            shutil.rmtree(box)
            raise
        outcome.seconds += time.monotonic() - began
        overrun = test.script == "test.hal" and overran(folder)
        failure = "its sampler overran" if overrun else judge(status, folder)
        if failure:
            return f"{failure}\nin {folder}", overrun
        shutil.rmtree(box)
        return "", False


# --- report ---


def cell(outcomes):
    if outcomes[0] is None:
        return "skipped"
    passed = sum(not outcome.failure for outcome in outcomes)
    verdict = "pass" if passed == len(outcomes) else "FAIL"
    if len(outcomes) > 1:
        verdict += f" {passed}/{len(outcomes)}"
    retries = sum(len(outcome.tries_before) for outcome in outcomes)
    seconds = sum(outcome.seconds for outcome in outcomes) / len(outcomes)
    return f"{verdict} {seconds:6.1f} s" + (f" +{retries}" if retries else "")


def total(outcomes):
    ran = [outcome for outcome in outcomes if outcome]
    retries = sum(len(outcome.tries_before) for outcome in ran)
    text = f"{sum(not outcome.failure for outcome in ran)}/{len(ran)} {sum(outcome.seconds for outcome in ran):6.1f} s"
    return text + (f" +{retries}" if retries else "")


class Table:
    def __init__(self, names, sides):
        self._first = max(len(name) for name in [*names, "passed"])
        self.row("", [side.name for side in sides])

    def row(self, name, cells):
        columns = [f"{name:{self._first}}", *(f"{text:20}" for text in cells)]
        print("  ".join(columns).rstrip(), flush=True)


async def run_tests(tests, sides, runner, repetitions):
    """Prints the table. Returns {side: {test: outcomes}}."""
    jobs = {}
    for test in tests:
        for side in sides:
            for number in range(repetitions):
                jobs[test, side, number] = asyncio.create_task(runner.run(test, side))
    try:
        table = Table([test.name for test in tests], sides)
        outcomes = {side: {} for side in sides}
        for test in tests:
            for side in sides:
                outcomes[side][test] = [await jobs[test, side, number] for number in range(repetitions)]
            table.row(test.name, [cell(outcomes[side][test]) for side in sides])
        table.row("passed", [total(sum(outcomes[side].values(), [])) for side in sides])
        return outcomes
    finally:
        for job in jobs.values():
            job.cancel()
        await asyncio.gather(*jobs.values(), return_exceptions=True)


def fails(outcomes):
    return any(outcome and outcome.failure for outcome in outcomes)


def print_failures(outcomes):
    for side, tests in outcomes.items():
        for test, tried in tests.items():
            for outcome in filter(None, tried):
                for number, failure in enumerate([*outcome.tries_before, outcome.failure], 1):
                    if failure:
                        print(f"\n{test.name}, {side.name}, try {number}: {failure}")


def host_is_worse(outcomes):
    """Whether a test fails with the host and does not with LinuxCNC's own realtime side."""
    stock = outcomes.get(STOCK, {})
    return any(
        fails(tried) and not fails(stock.get(test, []))
        for side, tests in outcomes.items()
        if side is not STOCK
        for test, tried in tests.items()
    )


def speed(text):
    if text != "free" and not re.fullmatch(r"\d+(\.\d+)?", text):
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number nor `free`")
    return text


def positive(text):
    if not re.fullmatch(r"[1-9]\d*", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return int(text)


def arguments():
    parser = argparse.ArgumentParser(
        prog="scripts/linuxcnc-tests",
        description="LinuxCNC's own regression tests, with its own realtime side (stock) and with the virtual-time host.",
        epilog="A table shows the seconds that each took, and after + how often it was run again: once more after a "
        "failure, and after an overrun of a sampler, as LinuxCNC does. The exit status is 1 when the host fails a test "
        "that stock passes.",
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--halrun", action="store_true", help="only the tests that need no more than halrun")
    which.add_argument("--whole", action="store_true", help="only the tests of a complete LinuxCNC")
    sides = parser.add_mutually_exclusive_group()
    sides.add_argument("--stock-only", action="store_true", help="without the host")
    sides.add_argument("--host-only", action="store_true", help="without stock")
    parser.add_argument(
        "--speed",
        type=speed,
        action="append",
        metavar="K",
        help="of the host, times real time, or `free`; several may be given. "
        "Else it is 1 and 20 with halrun, and 10 for a complete LinuxCNC",
    )
    parser.add_argument("-R", metavar="REGEX", default="", help="only the tests whose names have a match")
    parser.add_argument("--repeat", type=positive, default=1, metavar="N", help="run each N times")
    parser.add_argument("--jobs", type=positive, default=2, metavar="N", help="tests at a time, 2 by default")
    return parser.parse_args()


def chosen_groups(options, source):
    """(title, tests, speeds) of each group."""
    groups = []
    if not options.whole:
        tests = halrun_tests(source)
        kinds = [test.script for test in tests]
        skipped = ", ".join(test.name for test in tests if test.skipped)
        title = f"With halrun alone: {kinds.count('test.hal')} test.hal and {kinds.count('test.sh')} test.sh"
        title += f"; LinuxCNC itself skips {skipped}" * bool(skipped)
        groups.append((title, tests, ["1", "20"]))
    if not options.halrun:
        groups.append((f"A complete LinuxCNC: {len(WHOLE)} tests", whole_tests(), ["10"]))
    for title, tests, speeds in groups:
        tests = [test for test in tests if re.search(options.R, test.name)]
        if tests:
            yield title, tests, options.speed or speeds


async def main():
    options = arguments()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, asyncio.current_task().cancel)
    source = fetched()
    if not options.host_only:
        need_spaces(source)
    runner = Runner(source, os.path.join(WORK, "runs"), options.jobs)
    groups = list(chosen_groups(options, source))
    if not groups:
        raise Trouble(f"No test has a name with {options.R}.")
    worse = False
    for title, tests, speeds in groups:
        sides = ([] if options.host_only else [STOCK]) + ([] if options.stock_only else [host(k) for k in speeds])
        print(title)
        began = time.monotonic()
        outcomes = await run_tests(tests, sides, runner, options.repeat)
        print(f"in {time.monotonic() - began:.0f} s, {options.jobs} at a time")
        print_failures(outcomes)
        print()
        worse = worse or host_is_worse(outcomes)
    return int(worse)


if __name__ == "__main__":
    try:
        sys.exit(asyncio.run(main()))
    except Trouble as trouble:
        sys.exit(f"scripts/linuxcnc-tests: {trouble}")
    except (KeyboardInterrupt, asyncio.CancelledError):
        sys.exit(128 + signal.SIGINT)

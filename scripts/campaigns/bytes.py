# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/campaign bytes: libFuzzer writes the bytes that Plumb's readers read.

Each file of tests/readers is a reader, with a small corpus in tests/corpus. A seed is one reader for some seconds,
one after the other. New bytes that lead further are kept in build/campaigns/bytes/corpus, where the next seed of that
reader finds them; the bytes of a finding are kept in build/campaigns/bytes/findings.
"""

import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import campaign  # noqa: E402  (beside this file)

SOURCES = os.path.join(campaign.ROOT, "tests", "readers")
CORPORA = os.path.join(campaign.ROOT, "tests", "corpus")
WORK = os.path.join(campaign.BUILD, "campaigns", "bytes")
FUZZED = os.path.join(campaign.BUILD, "bytes")  # the build by clang
PROGRAM = os.path.join(FUZZED, "tests", "readers", "readers")
LIMITS = ("-timeout=100", "-rss_limit_mb=1500", "-malloc_limit_mb=256")  # s for one input, on a busy computer, and MB
LONGEST = 1 << 14  # bytes of an input

READERS = sorted({os.path.splitext(name)[0] for name in os.listdir(SOURCES) if name.endswith(".cpp")} - {"reader", "corpus"})

options = None


def main():
    campaign.run("bytes", "Lets libFuzzer attack the readers of Plumb (tests/readers), one a seed.", attack,
                 setup=("--with", "clang libclang-rt-dev llvm", "readers"), add_options=add_options, prepare=prepare)


def add_options(parser):
    parser.add_argument("--reader", choices=READERS, metavar="NAME", help=f"attack this one alone: {', '.join(READERS)}")
    parser.add_argument("--seconds", type=campaign.seconds_of, default=20.0, metavar="TIME", help="for each seed (default: 20s)")


def prepare(given):
    global options
    options = given
    if not os.path.exists(os.path.join(FUZZED, "build.ninja")):
        subprocess.run(["cmake", "-S", campaign.ROOT, "-B", FUZZED, "-G", "Ninja", "-DCMAKE_CXX_COMPILER=clang++",
                        "-DPLUMB_SANITIZE=fuzzer-no-link,address,undefined", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -g1"], check=True)
    subprocess.run(["cmake", "--build", FUZZED, "--parallel", str(os.cpu_count()), "--target", "readers"], check=True)


def attack(seed):
    """One reader, with the present corpora; a finding names the file that repeats it."""
    reader = options.reader or READERS[(seed - 1) % len(READERS)]
    corpus, findings = (os.path.join(WORK, kind, reader) for kind in ("corpus", "findings"))
    for folder in (corpus, findings):
        os.makedirs(folder, exist_ok=True)
    command = [PROGRAM, f"-seed={seed}", f"-max_total_time={max(1, round(options.seconds))}",
               f"-max_len={LONGEST}", f"-artifact_prefix={findings}{os.sep}", "-print_final_stats=1", "-detect_leaks=1",
               *LIMITS, corpus, os.path.join(CORPORA, reader)]
    run = subprocess.run(command, env={**os.environ, "PLUMB_READER": reader}, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                         stderr=subprocess.PIPE, encoding="utf-8", errors="replace", check=False)
    return campaign.Outcome(tries_in(run.stderr), [] if run.returncode == 0 else [finding(reader, run)])


def tries_in(text):
    counts = re.findall(r"(?:number_of_executed_units: |^#)(\d+)", text, re.MULTILINE)
    return int(counts[-1]) if counts else 0


def finding(reader, run):
    """The sentence that was demanded, or the sanitizer's, and the command that repeats it."""
    causes = re.findall(r"^demanded: (.*)|^.*runtime error: (.*)|^SUMMARY: (.*)", run.stderr, re.MULTILINE)
    cause = next((words for cause in causes for words in cause if words), f"exit status {run.returncode}")
    kept = re.search(r"Test unit written to (\S+)", run.stderr)
    if not kept:
        log = os.path.join(WORK, "findings", f"{reader}.log")
        with open(log, "w", encoding="utf-8") as file:
            file.write(run.stderr)
        return f"{reader}: {cause}; see {log}"
    return f"{reader}: {cause}; repeat it by PLUMB_READER={reader} {PROGRAM} {kept[1]}"


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""Switches off each mechanism by which chopping learns, and shows how the figures of drawn axes change.

A mechanism is a text in a header and the text without it. A copy of the header is compiled into a module of its own, and the
shipped component stays as it is.
"""

import os
import re
import shlex
import subprocess
import sys

from support import drives, integral, proven
from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.simulations import BUILD, ROOT, simulate_all

TARGETS = "simulation_grinder sim_elastic_axis chopping"
PACKAGES = ""
MATH = "components/math/oscillation/"
LEARNING, CLIMB, LAW = (MATH + name + ".hpp" for name in ("dead_point_learning", "climb", "turn_law"))
WATCH = "components/compensation/chopping/dead_point_watch.hpp"
MECHANISMS = {
    "as shipped": (),
    "first cycle farther inside": (LEARNING, "10 * settings_.inset", "settings_.inset"),
    "memory of a passed dead point": (LEARNING, "per_acceleration_ = std::max(per_acceleration_, excess_[upper] / acceleration);", ""),
    "overshoot bounds the climb": (LEARNING, "double growth = slope > 0 ?", "double growth = false ?"),
    "brakes by what was shown": (CLIMB, "its < enough * expected", "false"),
    "surprise of a turn": (LAW, "surprise_ = apart > its.doubt - surprise_ ? apart : 0;", "surprise_ = 0 * apart;"),
    "an odd axis": (LAW, "odd_ |= surprise_ > unit;", ""),
    "slope by the length": (LAW, "turn.shape == wanted.shape ? longer - 1 : 0", "0 * longer"),
    "wide slope beside a section": (LAW, "const bool odd = odd_ || !covers(wanted) || wanted.shape != 0;", "const bool odd = odd_;"),
    "no turn between two kinds": (LEARNING, "if (number != number_) return;", "(void)number;"),
    "own turns beside a section": (LAW, "if (known && each.turn.shape != wanted.shape) continue;", "(void)known;"),
    "remembered turns end": (LAW, "if (surprise_ > unit) drop_remembered();", ""),
    "half of an error is no doubt": (LEARNING, "0.5 * std::abs(now.beyond + used)", "1e9"),
    "less after a start": (LAW, "(each.turn.starts ? starting : least)", "least"),
    "doubt beside a section": (LEARNING, "doubt = std::max(doubt, uneven_doubt(upper, its.beyond));", ""),
    "quicker than all others": (LAW, "bool quick = false;", "bool quick = true;"),
    "doubt of unlike turns": (LAW, "strange = 0.1", "strange = 0"),
    "inside after a restart": (LEARNING, "again = 0.975", "again = 1"),
    "a turn inside waits a cycle": (LEARNING, "if (!waits(upper)) correct", "correct"),
    "lag of the last strokes": (WATCH, "Event event = lag(now, present);", "Event event = (lag(now, present), Event::none);"),
}


def changed(path, text, rest):
    """A header with `rest` in the place of `text`."""
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        code = file.read()
    if code.count(text) != 1:
        sys.exit(f"{path} does not have this text once: {text}")
    return code.replace(text, rest)


def search_first(folder):
    """Hosts take modules from here."""
    import plumb

    plumb.Host.__init__.__defaults__ = (None, (folder,), *plumb.Host.__init__.__defaults__[2:])


def without(mechanism, folder):
    """The folder of a module without it."""
    source = os.path.join(ROOT, "components/compensation/chopping/chopping.cpp")
    if mechanism:
        copy = os.path.join(folder, mechanism[0])
        os.makedirs(os.path.dirname(copy), exist_ok=True)
        with open(copy, "w", encoding="utf-8") as file:
            file.write(changed(*mechanism))
    done = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", "modules/chopping.so"], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    compiled, linked = next(line for line in lines if line.endswith(source)), lines[-1].split("&&")[1]
    built, module = (os.path.join(folder, name) for name in ("chopping.o", "chopping.so"))
    words = shlex.split(compiled)
    own = re.search(r"\S+chopping\.cpp\.o", linked)[0]
    words[words.index("-o") + 1], words[words.index("-MF") + 1] = built, built + ".d"
    words.insert(words.index("-DRTAPI"), "-I" + folder)
    subprocess.run(words, cwd=BUILD, check=True)
    subprocess.run(linked.replace(own, built).replace("modules/chopping.so", module), shell=True, cwd=BUILD, check=True)
    return folder


def figures(seeds, folder, options):
    """The cells of a row."""
    search_first(folder)
    place, plants = place_of(options), drives.PLANTS

    def run(simulate, axes):
        return simulate_all(simulate, axes, 150 * len(axes), place)

    strong, weak = (run(drives.simulate, [(plant, seed, its) for plant in plants for seed in seeds]) for its in (False, True))
    loops = run(integral.simulate, [(seed, True) for seed in seeds])
    others = [each for each in run(proven.simulate, [(plant, seed) for plant in plants for seed in seeds]) if each]
    cycles = sorted(its.cycles for its in strong if its.cycles is not None) or [0]
    soon = [sum(each[kind].soon for each in others) / max(len(others), 1) for kind in proven.KINDS]
    cells = [
        f"{sum(its.learned for its in strong):4}/{len(strong)}{max(its.beyond for its in strong):8.1f}{cycles[int(0.95 * len(cycles))]:7.1f}{sum(its.late for its in strong):6}",
        f"{sum(its.learned or its.fault != 0 for its in weak):6}/{len(weak)}{max(its.beyond for its in weak):8.1f}",
        f"{sum(its.seconds is not None for its in loops):6}/{len(loops)}{max(its.first for its in loops):9.1f}{max(its.later for its in loops):8.1f}{sum(its.silent > 0 for its in loops):4}",
        "  " + "".join(f"{100 * part:5.0f}" for part in soon) + f"{max(each[kind].beyond for each in others for kind in proven.KINDS):8.1f}",
    ]
    return "".join(cells)


HEADER = [
    f"{'':32}{'strong drives':26}{'weak':17}{'with an integral':30}other strokes: right in 3 cycles, %",
    f"{'without':32}{'learned':8}{'beyond':>7}{'p95':>7}{'late':>5}{'told':>9}{'beyond':>8}{'learned':>11}{'first':>8}{'later':>8}{'un':>4}  {'feed':>5}{'reg.':>5}{'sec.':>5}{'rest':>5}{'beyond':>8}",
]


def main():
    from plumb_folder import TemporaryFolder

    parser = new_parser("ablation", __doc__)
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first axis (default: 1)")
    parser.add_argument("--seeds", type=whole(2, 100000), default=20, metavar="N", help="N drawn axes of each kind (default: 20)")
    parser.add_argument("--without", nargs="+", choices=MECHANISMS, default=list(MECHANISMS), metavar="MECHANISM", help="only these: " + ", ".join(MECHANISMS))
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        print("\n".join(HEADER), flush=True)
        for name in options.without:
            with TemporaryFolder() as folder:
                print(f"{name:32}" + figures(range(options.seed, options.seed + options.seeds), without(MECHANISMS[name], folder), options), flush=True)

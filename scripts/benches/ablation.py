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
RIGHT, PASSED = 1.05, 5  # um
MECHANISMS = {
    "as shipped": (),
    "restart: by the force of before": (LEARNING, "std::max({now, before * unshown, least})", "std::max({now, 0 * before, least})"),
    "restart: the force of before, shown": (LEARNING, "climb_.expect(std::min(force_[0], force_[1]) / (seen_part * settings_.demand));", ""),
    "restart: remembered turns": (LEARNING, "known && !doubted_) recall(*known);", "known && false) recall(*known);"),
    "restart: without measured cycles": (LEARNING, "if (!recalls_ || !climb_.proves()", "if (recalls_ || !recalls_"),
    "restart: the first cycle of before": (LEARNING, "laws_[i].add(first, slow_[i], settings_.most_beyond);", ""),
    "law before lengths are steady": (LEARNING, "(within && !changes)", "within"),
    "remembered turns end": (LAW, "if (other) drop_remembered();", ""),
    "first cycle farther inside": (LEARNING, "10 * settings_.inset", "settings_.inset"),
    "begin inside by the overshoot": (LEARNING, " - 1.3 * a * overshoot()", " - 0 * a"),
    "memory of a passed dead point": (LEARNING, "per_acceleration_ = std::max(per_acceleration_, excess_[upper] / acceleration);", ""),
    "overshoot bounds the climb": (LEARNING, "double growth = slope > 0 ?", "double growth = false ?"),
    "overshoot by its slope": (LEARNING, "slope = std::max(slope, (excess_[i] - last_excess_[i]) / (now - last_turning_));", ";"),
    "last good speed": (LEARNING, "if (++trips_ >= 2)", "if (++trips_ >= 200)"),
    "climb: brakes by less": (CLIMB, "level_ = std::min(level_ * std::min(cautious_ ? careful : fastest, growth), ceiling_);", "level_ = brakes_ = std::min(level_ * std::min(cautious_ ? careful : fastest, growth), ceiling_);"),
    "climb: judges what was shown": (CLIMB, "its < enough * expected", "false"),
    "climb: expects less of a fast one": (CLIMB, "return 1 / (1 + (1 / reference_ - 1) * level_ / reference_level_);", "return reference_;"),
    "climb: first rise near full speed": (CLIMB, "? least_shown : 0", "? 0 * least_shown : 0"),
    "climb: careful after less": (CLIMB, "cautious_ ? careful : fastest", "fastest"),
    "falls behind while rising": (WATCH, "lag_.begin();\n        if (!rises) return Event::lags;", "if (rises) return Event::none;\n        lag_.begin();\n        if (!rises) return Event::lags;"),
    "lag of the last strokes": (WATCH, "Event event = lag(now, present);", "Event event = (lag(now, present), Event::none);"),
    "lag: only of a right stroke": (WATCH, "learning_.was_learned() && present.without_override, now.speed", "false, now.speed"),
    "lag: friction": (WATCH, "Eigen::Vector3d row{velocity, acceleration, sign};", "Eigen::Vector3d row{velocity, acceleration, 1e-9 * sign};"),
    "lag: band of older strokes": (WATCH, "std::max(its.band, 0.7 * band_ * faster * faster)", "its.band + 0 * faster"),
    "lag: first strokes": (WATCH, "lag_.strokes() < 6 ? 0.2 : 0.05", "0.05"),
    "lag: largest at another speed": (WATCH, "like || rises ? 0 :", "like || rises || true ? 0 :"),
    "law: constant": (LAW, "3 * unit + 0.3 * largest,", "1e-6 * unit,"),
    "law: square of the frequency": (LAW, "0.5 * largest, largest,", "1e-6 * unit, largest,"),
    "law: leaving": (LAW, "0.5 * largest, largest,", "0.5 * largest, 1e-6 * unit,"),
    "law: slope by the length": (LAW, "turn.shape == wanted.shape ? longer - 1 : 0", "0 * longer"),
    "law: slope of an even one": (LAW, "least * unit + usual_power * std::abs(its_beyond);", "1e-6 * unit + 0 * usual_power;"),
    "law: slope of a lag": (LAW, "(its_beyond > 0 ? odd_slope : odd_lag_slope)", "(its_beyond > 0 ? odd_slope : odd_slope + 0 * odd_lag_slope)"),
    "law: wide slope beside a section": (LAW, "const bool odd = odd_ || !covers(wanted) || wanted.shape != 0;", "const bool odd = odd_;"),
    "law: surprise": (LAW, "surprise_ = apart > its.doubt - surprise_ ? apart : 0;", "surprise_ = 0 * apart;"),
    "law: odd": (LAW, "odd_ |= other;", ""),
    "law: unlike turns of an odd axis": (LAW, "(odd_ ? 10 : 1) * relative", "relative"),
    "law: sigma of unlike turns": (LAW, "relative = 0.03", "relative = 0"),
    "law: doubt of unlike turns": (LAW, "strange = 0.1", "strange = 0"),
    "law: less after a start": (LAW, "(each.turn.starts ? starting : least)", "(each.turn.starts ? least + 0 * starting : least)"),
    "law: own turns beside a section": (LAW, "if (known && each.turn.shape != wanted.shape) continue;", "(void)known;"),
    "law: quicker than all others": (LAW, "bool quick = false;", "bool quick = true;"),
    "law: 8 turns": (LAW, "most = 24", "most = 8"),
    "no turn between two kinds": (LEARNING, "if (number != number_) return;", "(void)number;"),
    "no last turn of a pause": (LEARNING, "if (laws_[upper].empty() || !pauses) laws_", "(void)pauses; laws_"),
    "half of an error is no doubt": (LEARNING, "std::max(0.5 * std::abs(now.beyond + used), law.surprise())", "1e9"),
    "all of an error": (LEARNING, "std::min(now.doubt, std::max(0.5 * std::abs(now.beyond + used), law.surprise()))", "0.0"),
    "gain once it is right": (LEARNING, "((was_learned_ || (within && !changes)) && error <= settings_.most_beyond)", "(false && within && !changes)"),
    "doubt beside a section": (LEARNING, "doubt = std::max(doubt, uneven_doubt(upper, its.beyond));", ""),
    "doubt: growth by the way": (LEARNING, "std::max({settings_.inset + over / 2, grown, -0.6 * beyond})", "std::max({settings_.inset + over / 2, 0 * grown, -0.6 * beyond})"),
    "doubt: a lag": (LEARNING, "std::max({settings_.inset + over / 2, grown, -0.6 * beyond})", "std::max({settings_.inset + over / 2, grown, 0.0})"),
    "inward at another length": (LEARNING, "its -= std::max(1.5 * slopes_[upper] * (now - lengths_[upper]), 0.0);", "(void)now;"),
    "no correction at another length": (LEARNING, "lengths.before > 0 && differs(lengths);", "false;"),
    "a turn inside waits a cycle": (LEARNING, "if (!waits(upper)) correct", "waits(upper); correct"),
    "inward above the full speed": (LEARNING, "faster > 1 ? its * faster * faster : its", "faster > 0 ? its : 0"),
    "back with the acceleration": (LEARNING, "return acceleration < reference_[upper] ? its * acceleration / reference_[upper] : its;", "(void)acceleration; return its;"),
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


def simulate(kind, *task):
    return {"drives": drives.simulate, "integral": integral.simulate, "proven": proven.simulate}[kind](*task)


def figures(seeds, folder, options):
    """The cells of a row."""
    search_first(folder)
    plants = drives.PLANTS
    axes = [("integral", seed, True) for seed in seeds]
    axes += [("proven", plant, seed) for plant in plants for seed in seeds]
    axes += [("drives", plant, seed, weak) for weak in (False, True) for plant in plants for seed in seeds]
    found = simulate_all(simulate, axes, 150 * len(axes), place_of(options))
    loops, others, strong, weak = (
        [each for axis, each in zip(axes, found) if each and axis[0] == kind and axis[3:] in its]
        for kind, its in (("integral", [()]), ("proven", [()]), ("drives", [(False,)]), ("drives", [(True,)]))
    )
    cycles = sorted(its.cycles if its.cycles is not None else 100 for its in strong)
    seconds = sorted(its.seconds if its.seconds is not None else integral.PATIENCE for its in loops)
    new = [each[kind] for each in others for kind in proven.KINDS]
    soon = [100 * sum(each[kind].soon for each in others) / max(len(others), 1) for kind in proven.KINDS]
    mean = sum(its.cycles if its.cycles is not None else proven.STROKES for its in new) / max(len(new), 1)
    untold = sum(its.beyond > PASSED and not its.fault for its in [*strong, *weak, *new]) + sum(its.silent > 0 for its in loops)
    settled = [its for its in strong if its.learned] + [its for its in new if not its.fault]
    cells = [
        f"{sum(its.error <= RIGHT for its in settled):5}/{len(strong) + len(new)}{untold:7}",
        f"{max(its.beyond for its in strong):8.1f}{max(its.beyond for its in weak):8.1f}{max(its.later for its in loops):8.1f}{max(its.beyond for its in new):8.1f}",
        f"{sum(its.learned for its in strong):7}/{len(strong)}{cycles[int(0.95 * len(cycles))]:6.1f}{sum(its.late for its in strong):5}",
        f"{sum(its.learned for its in weak):5}{sum(its.silent for its in weak):4}{seconds[len(seconds) // 2]:7.0f}{seconds[-1]:5.0f}",
        "  " + "".join(f"{part:5.0f}" for part in soon) + f"{mean:6.2f}{sum(its.fault != 0 for its in new):5}",
    ]
    return "".join(cells)


HEADER = [
    f"{'':36}{'within':>9}{'> 5 um':>7}{'farthest beyond, um':^32}{'strong drives':^21}{'weak':>9}{'integral':>12}  other strokes: right in 3 cycles, %",
    f"{'without':36}{'1.05 um':>9}{'untold':>7}{'strong':>8}{'weak':>8}{'integr.':>8}{'other':>8}{'learned':>10}{'p95':>6}{'late':>5}{'learn':>5}{'un':>4}{'s':>7}{'most':>5}  {'feed':>5}{'reg.':>5}{'sec.':>5}{'rest':>5}{'mean':>6}{'told':>5}",
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
                print(f"{name:36}" + figures(range(options.seed, options.seed + options.seeds), without(MECHANISMS[name], folder), options), flush=True)

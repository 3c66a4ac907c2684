# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds the height of a lathe tool from its trial cuts, on a thousand drawn lathes and by every method.

configs/lathe/bench.hal runs in the virtual-time host. On each lathe the tool stands at another height, the work bends, the
tool wears and carries a built-up edge, X grows and the spindle lifts. The residual is the difference between the height that
centre_height reports and the effective height, the one under the cut.
"""

import os
import sys

import numpy as np

from support import charts
from support.command import add_output, add_place, errors_reported, make_writable, new_parser, place_of, whole, written_line
from support.figures import rms
from support import lathe_strangers
from support.lathe_machine import AT_A_TIME, METHODS, UM, WORKS, Case, procedure, simulate
from support.recordings import write_rows
from support.second_lathe import SLIPS, SecondCase, simulate_second
from support.simulations import simulate_all

TARGETS = "simulation_lathe"
PACKAGES = "python3-matplotlib"
EDGE = 0.005  # mm
OUTSIDE = 0.05  # of the procedures that said on-centre
ALLOWED = 0.001  # of moves that leave more than there was


def table_cases():
    """Every method on both bars and at three clearances, with built-up edge and, for lands, without; and by micrometer."""
    cases = []
    for diameter in WORKS:
        for method in METHODS:
            of_clearance = (0,) if method == "two cuts" else (0, 7, 11)
            for clearance in of_clearance:
                cases.append(Case(diameter, method, clearance, EDGE))
                if "lands" in method:
                    cases.append(Case(diameter, method, clearance, 0))
        if diameter == 10:
            cases += [Case(diameter, method, 0, EDGE, True) for method in METHODS]
        cases += [Case(diameter, method, 0, EDGE, near=True) for method in METHODS]
    return cases


# --- print ---


def name_of(case):
    words = [case.method]
    if case.clearance:
        words.append(f"{case.clearance} deg")
    if case.micrometer:
        words.append("micrometer")
    if not case.edge:
        words.append("no built-up edge")
    return ", ".join(words)


def worse(outcome):
    """How many moves left more than there was."""
    moved = outcome.moved
    return int(np.sum(np.abs(outcome.residual[moved]) > np.abs(outcome.truth[moved])))


def moves_of(results):
    """How many tools were moved, and how many of these moves left more than there was."""
    outcomes = [outcome for _, outcome in results]
    return sum(int(outcome.moved.sum()) for outcome in outcomes), sum(worse(outcome) for outcome in outcomes)


def in_sigmas(case, outcome):
    """The errors of all heights in reported sigmas, also of those by which Y does not move. Two cuts measure the square."""
    if case.method == "two cuts":
        errors = (outcome.height**2 - outcome.truth**2) / outcome.within**2
    else:
        errors = outcome.residual / outcome.sigma
    return errors[np.isfinite(outcome.height)]


def head(diameter):
    return f"{f'Residual of the height at D {diameter} mm, um':48}{'rms':>8}{'p95':>8}{'sigma':>8}{'ratio':>8}{'refused':>9}{'worse':>7}"


def row(case, outcome):
    """Of the moves: residual, reported sigma. Of all heights: their errors by sigma. The share refused; moves that made it worse."""
    moved = outcome.moved
    refused = np.mean(~moved & (outcome.detail > 0))  # the others are on centre
    if not moved.any():
        return f"    {name_of(case):44}{'':32}{refused:>9.1%}"
    residual, sigma = outcome.residual[moved], outcome.sigma[moved]
    ratio = rms(in_sigmas(case, outcome))
    return f"    {name_of(case):44}{rms(residual):8.2f}{np.percentile(np.abs(residual), 95):8.2f}{rms(sigma):8.2f}{ratio:8.2f}{refused:>9.1%}{worse(outcome):>7}"


def said_on_centre(results):
    """How many procedures said on-centre, and how many of these tools are outside the tolerance: of their effective heights."""
    said = sum(int(outcome.centred.sum()) for _, outcome in results)
    outside = sum(
        int(np.sum(np.abs(outcome.truth[outcome.centred]) > UM * WORKS[case.diameter].tolerance)) for case, outcome in results
    )
    return said, outside


def centre_row(case, outcome):
    """Of the tools close to the tolerance: how many are within, how many of all are said to be, and how many of those are not."""
    said, outside = said_on_centre([(case, outcome)])
    within = int(np.sum(np.abs(outcome.truth) <= UM * WORKS[case.diameter].tolerance))
    return f"    {name_of(case):44}{within:8}{said:8}{outside:9}"


# --- the second lathe ---

METHODS_THAT_ASK = ("one pair of lands", "lands ABBA", "lands ABBA x 3", "eight cuts")  # the others are never on centre here
NEAR = 30  # times as many lathes, so that 400 of a row are on centre


def second_cases():
    cases = [SecondCase(diameter, method, burrs) for diameter in WORKS for method in METHODS for burrs in (False, True)]
    near = [SecondCase(diameter, method, burrs, near=True) for diameter in WORKS for method in METHODS_THAT_ASK for burrs in (False, True)]
    slips = [SecondCase(10, method, slip=slip) for slip in SLIPS for method in ("lands ABBA", "lands ABBA x 3")]
    return cases, near, slips


def second_name(case):
    return f"{case.method}{', burrs' if case.burrs else ''}"


def errors_of(case, outcome):
    """Y's errors in sigmas, of all heights that there are."""
    its = outcome.values
    known = (its["value-valid"] > 0) & outcome.met
    height, truth = its["height"][known], outcome.truth[known]
    if case.method == "two cuts":
        return (height**2 - truth**2) / its["within"][known] ** 2
    return (height - truth) / its["sigma"][known]


def within_two(errors):
    return float(np.mean(np.abs(errors) <= 2)) if len(errors) else 1.0


def second_worse(outcome):
    its = outcome.values
    return int(np.sum((its["move-allowed"] > 0) & (np.abs(its["height"] - outcome.truth) > np.abs(outcome.truth))))


def second_row(case, outcome):
    its = outcome.values
    moved = its["move-allowed"] > 0
    residual = (its["height"] - outcome.truth)[moved]
    figures = f"{rms(residual):8.2f}{np.percentile(np.abs(residual), 95):8.2f}{rms(its['sigma'][moved]):8.2f}" if moved.any() else f"{'':24}"
    return f"    {second_name(case):44}{figures}{within_two(errors_of(case, outcome)):8.1%}{int(moved.sum()):8}{second_worse(outcome):7}"


def on_centre_of(case, outcome):
    """How many were said to be on centre, and how many of them are outside in Y, outside in X, and met no stock."""
    said, tolerance = outcome.values["on-centre"] > 0, UM * WORKS[case.diameter].tolerance
    outside = [int(np.sum(said & (np.abs(truth) > tolerance))) for truth in (outcome.truth, outcome.truth_x)]
    return int(said.sum()), *outside, int(np.sum(said & ~outcome.met))


def slip_row(case, outcome):
    its = outcome.values
    fault, moved, centred = (its[name] > 0 for name in ("fault", "move-allowed", "on-centre"))
    stored = moved | (its["x-allowed"] > 0)
    bad = moved & (np.abs(its["height"] - outcome.truth) > np.abs(outcome.truth))
    numbers = (fault.sum(), np.sum(~fault & ~stored & ~centred), np.sum(stored & ~bad), bad.sum(), centred.sum())
    return f"    {SLIPS[case.slip] + ', ' + case.method:72}" + "".join(f"{int(number):9}" for number in numbers)


def second(seed, count, place):
    """Prints the tables of the second lathe; whether all limits hold."""
    cases, near, slips = second_cases()
    tasks = [(case, range(seed, seed + count)) for case in cases + slips]
    tasks += [(case, range(seed, seed + NEAR * count)) for case in near]
    outcomes = simulate_all(simulate_second, tasks, sum(len(seeds) for _, seeds in tasks) * 0.002, place)
    results = list(zip(cases + slips + near, outcomes))
    wrong = []
    print(f"\nThe second lathe, {count} drawn, burrs on 8 % of the cuts. Within: errors of at most two sigmas, of all heights.\n")
    for diameter in WORKS:
        print(f"{f'Residual of the height at D {diameter} mm, um':48}{'rms':>8}{'p95':>8}{'sigma':>8}{'within':>8}{'moves':>8}{'worse':>7}")
        for case, outcome in results[: len(cases)]:
            if case.diameter == diameter:
                print(second_row(case, outcome))
                if count >= 400 and not 0.9 <= within_two(errors_of(case, outcome)) <= 0.99:
                    wrong.append(f"within two sigmas: {second_name(case)}, D {diameter}")
        print()
    burred = [outcome for case, outcome in results[: len(cases)] if case.burrs]
    moves, bad = sum(int((outcome.values["move-allowed"] > 0).sum()) for outcome in burred), sum(second_worse(outcome) for outcome in burred)
    print(f"{bad} of {moves} moves with burrs left more than there was.")
    if bad > ALLOWED * moves:
        wrong.append("moves with burrs that left more than there was")
    print(f"\n{'Tools close to the tolerance, said to be on centre':52}{'said':>8}{'Y out':>8}{'X out':>8}{'no cut':>8}")
    for case, outcome in results:
        said, y_out, x_out, air = on_centre_of(case, outcome)
        if case.near:
            print(f"    D {case.diameter:<3}{second_name(case):43}{said:8}{y_out:8}{x_out:8}{air:8}")
        if air or (case.near and said >= 20 and max(y_out, x_out) > OUTSIDE * said):
            wrong.append(f"on centre: {second_name(case)}, D {case.diameter} {case.slip}")
    print(f"\n{'Slips, D 10 mm':76}{'refused':>9}{'again':>9}{'right':>9}{'worse':>9}{'centre':>9}")
    print("\n".join(slip_row(*each) for each in results[len(cases) : len(cases) + len(slips)]))
    print("\n".join(f"Missed: {each}" for each in wrong))
    return not wrong


# --- strangers ---

CLAIMS = lathe_strangers.upper(1, 473)  # of wrong claims of a row, upper 95 %


def strangers(seed, count, place):
    """Prints the table of the slips; whether both limits hold."""
    cases = lathe_strangers.cases()
    results = simulate_all(lathe_strangers.simulate_strangers, [(case, range(seed, seed + count)) for case in cases], len(cases) * count, place)
    rows = [lathe_strangers.total(counts) for counts in results]
    print(f"Strangers with one slip each, {count} lathes a row, from {seed} on. Moves: stores that stand. Worse: Y is further off than before.")
    print("Taken back: stores that no land showed. Claims: on centre; wrong: Y or X outside the tolerance; limit: upper 95 % of their share.\n")
    print(f"{'Plant, slip, D 10 mm, micrometer':68}{'moves':>8}{'worse':>8}{'X worse':>8}{'back':>8}{'claims':>8}{'wrong':>8}{'limit':>8}")
    bad = []
    for case, row in zip(cases, rows):
        limit = lathe_strangers.upper(row["wrong"], row["claims"])
        numbers = "".join(f"{row[name]:8}" for name in ("moves", "worse", "worse x", "back", "claims", "wrong"))
        print(f"    {case.plant}  {lathe_strangers.SLIPS[case.slip]:61}{numbers}{limit:8.1%}")
        if row["wrong"] and limit > CLAIMS:
            bad.append(f"claims: plant {case.plant}, {case.slip}")
    pool = lathe_strangers.total(rows)
    print(f"\n{pool['worse']} of {pool['moves']} moves ({pool['worse'] / max(pool['moves'], 1):.2%}) left more than there was; {pool['wrong']} of {pool['claims']} claims are wrong.")
    if pool["worse"] > ALLOWED * pool["moves"]:
        bad.append("moves that left more than there was")
    print("\n".join(f"Missed: {each}" for each in bad))
    return not bad


# --- write ---


def write_lathes(path, results):
    header = ["diameter_mm", "method", "clearance_deg", "built_up_edge_um", "micrometer"]
    header += ["effective_height_um", "height_um", "sigma_um", "moved", "fault", "detail"]
    write_rows(path, header, (each for case, outcome in results for each in lathe_rows(case, outcome)))


def lathe_rows(case, outcome):
    its = [case.diameter, case.method, case.clearance, round(1000 * case.edge), int(case.micrometer)]
    for values in zip(outcome.truth, outcome.height, outcome.sigma, outcome.moved, outcome.fault, outcome.detail):
        yield its + [f"{value:.4f}" for value in values[:3]] + [int(value) for value in values[3:]]


def draw(paths, steps, case, seed):
    """One procedure: where the tool stood, the diameters, and the estimate after each cut."""
    pyplot = charts.prepared_pyplot()
    figure, (where, diameters, estimate) = pyplot.subplots(3, 1, figsize=(9, 8), sharex=True, layout="constrained")
    charts.write_title(figure, f"{name_of(case)} on lathe {seed}: cuts, diameters, and the height of the tool")
    number = np.arange(1, len(steps.diameter) + 1)
    where.step(number, steps.y, where="mid", color=charts.GREY)
    where.plot(number, steps.y, "o", color=charts.BLUE)
    where.set_ylabel("Y of the land (mm)")
    for above, colour, name in ((True, charts.ORANGE, "upper lands"), (False, charts.BLUE, "lower lands")):
        its = (steps.y > np.mean(steps.y)) == above
        diameters.plot(number[its], steps.diameter[its], "o", color=colour, label=name)
    diameters.set_ylabel("diameter (mm)")
    diameters.legend(frameon=False)
    known = np.isfinite(steps.height)
    estimate.axhline(steps.truth, color=charts.GREY, linewidth=1, label="effective height")
    estimate.errorbar(number[known], steps.height[known], 2 * steps.sigma[known], fmt="o", color=charts.GREEN, capsize=3, label="height ± 2 sigma")
    estimate.set_ylabel("height (µm)")
    estimate.set_xlabel("cut")
    estimate.legend(frameon=False)
    for axes in (where, diameters, estimate):
        axes.grid(color=charts.GRID, linewidth=0.6)
    charts.save(figure, paths)


# --- the command ---


def bench(seed, count, output, place):
    cases = table_cases()
    seeds = range(seed, seed + count)
    outcomes = simulate_all(simulate, [(case, seeds) for case in cases], len(cases) * count * AT_A_TIME, place)
    results = list(zip(cases, outcomes))
    print(f"{count} lathes, {seeds[0]} to {seeds[-1]}. Ratio: error / reported sigma, of all heights. Worse: moves that left more than there was.\n")
    for diameter in WORKS:
        print(head(diameter))
        print("\n".join(row(*each) for each in results if each[0].diameter == diameter and not each[0].near) + "\n")
    near = [each for each in results if each[0].near]
    moves, bad = moves_of(results)
    print(f"{bad} of {moves} moves ({bad / max(moves, 1):.3%}) left more than there was.")
    print("Of these, tools close to the tolerance: {1} of {0}. A height of three sigmas may be one and a half.".format(*moves_of(near)))
    for diameter in WORKS:
        print(f"\n{f'Tools within {2 * UM * WORKS[diameter].tolerance:g} um of the centre, D {diameter} mm':48}{'within':>8}{'said':>8}{'outside':>9}")
        print("\n".join(centre_row(*each) for each in near if each[0].diameter == diameter))
    said, outside = said_on_centre(results)
    print(f"\n{outside} of {said} tools that were said to be on centre are outside the tolerance ({outside / max(said, 1):.1%}).")
    case = Case(10, "lands ABBA x 3", 0, EDGE)
    paths = [os.path.join(output, name) for name in ("procedure.png", "procedure.svg", "lathes.csv")]
    draw(paths[:2], procedure(case, seed), case, seed)
    write_lathes(paths[2], results)
    print(written_line(paths))
    good = second(seed, count, place)
    return good and bad <= ALLOWED * moves and outside <= OUTSIDE * said


def main():
    parser = new_parser("lathe", __doc__)
    parser.add_argument("--seed", type=whole(1, 2**30), default=1, metavar="N", help="draw from lathe N on (default: 1)")
    parser.add_argument("--seeds", type=whole(1, 100000), default=1000, metavar="N", help="N drawn lathes a row (default: 1000)")
    parser.add_argument("--strangers", action="store_true", help="strangers with one slip each, instead of the methods")
    add_place(parser)
    add_output(parser, "lathe")
    options = parser.parse_args()
    if options.strangers:
        with errors_reported():
            good = strangers(options.seed, options.seeds, place_of(options))
        sys.exit(0 if good else 1)
    with errors_reported():
        make_writable(options.output)
        good = bench(options.seed, options.seeds, options.output, place_of(options))
    sys.exit(0 if good else 1)

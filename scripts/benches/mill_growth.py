# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs growth tests on the mill with thermal_displacement: on, off and with faults, as the report names them.

The machine of configs/mill/bench.hal mills, and sim_artifact has its growth. The growth test probes without and with the offset
that thermal_displacement has in force then: a switch between it and the drive takes it out for the passes without. A factor
behind thermal_displacement makes it absent, of wrong sign, too weak or too strong; a load that is lost after ten minutes freezes it.
"""

import os

from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.growth_tests import log_text, read_records, results_of
from support.mill_machine import start_mill
from support.simulations import ROOT, simulate_all

TARGETS = "simulation_mill simulation_growth plumb-growth"
PERIOD = 0.004  # s, of the thread
OPTIONS = {"threads.period1": round(PERIOD * 1e9)}
LONGEST = 8 * 3600  # s
FACTORS = {"on": 1, "off": 0, "wrong sign": -1, "0.8": 0.8, "1.3": 1.3, "load lost": 1}
SETTINGS = {
    "artifact.bores": 1,
    "artifact.both-orientations": False,
    "artifact.work-time": 900,
    "artifact.use-replay": True,
    "growth-test.minimum-time": 7200,
    "growth-test.maximum-time": 14400,
    "growth-test.max-scatter": 0.012,
    "growth-test.position-uncertainty": 0.0012,
}


def add_growth_test(host, seed, factor):
    """The nets of configs/growth/bench.hal, but for Z, whose growth and compensation are those of the mill."""
    for line in ("loadrt sim_artifact names=artifact", "loadrt thermal_growth_test names=growth-test interlock=no sensors=4", "loadrt scale names=spoilt", "loadrt mux2 names=switched"):
        host.command(line)
    with open(os.path.join(ROOT, "configs", "growth", "bench.hal"), encoding="utf-8") as file:
        for line in file:
            if line.startswith("net ") and not line.startswith(("net x-offset ", "net y-offset ", "net z-offset ", "net spindle-speed ")):
                host.command(line.replace("net ", "net artifact-", 1).split("#")[0])
    host.command("net true-growth mill.truth-growth artifact.replay-z")
    host.command("net applied-offset spoilt.in")
    host.command("net spoilt-offset spoilt.out switched.in1")
    host.command("net artifact-request switched.sel")
    host.command("net contained-offset switched.out growth-test.z-offset")
    host.command("net spindle-speed-cmd growth-test.spindle-speed")
    for function in ("spoilt", "switched", "artifact.update", "growth-test.update"):
        host.command("addf %s servo-thread" % function)
    host.set("artifact.seed", seed)
    for name, value in SETTINGS.items():
        host.set(name, value)
    host.set("spoilt.gain", factor)


def simulate(seed, name, progress):
    """The number and the sentence of the compensation in the report, its gain in Z, and the largest deviations in Z in um."""
    import plumb
    from plumb_folder import TemporaryFolder

    with TemporaryFolder() as folder, plumb.Host(options=OPTIONS) as host:
        start_mill(host, seed)
        add_growth_test(host, seed, FACTORS[name])
        host.set("artifact.play", True)
        while not host.get("artifact.finished") and host.time < LONGEST:
            host.run(600)
            if name == "load lost":
                host.set("growth.load-valid", False)
        log = os.path.join(folder, "growth.csv")
        with open(log, "w", encoding="ascii") as file:
            file.write(log_text(seed, read_records(host, folder, PERIOD), ("spindle", "bed", "air")))
        results = results_of(log)
    progress(1)
    axis = results["axes"]["Z"]
    return results["compensation"], axis["gain"]["value"], [1e3 * axis[state]["largest_mm"] for state in ("off", "on")]


def figures(found):
    lines = ["%-22s%8s%8s%14s   report" % ("thermal_displacement", "machine", "gain", "off, on, um")]
    for (seed, name), (compensation, gain, (off, on)) in found.items():
        shown = "     -" if gain is None else "%6.2f" % gain
        lines.append("%-22s%8d  %s%7.1f%7.1f   %s" % (name, seed, shown, off, on, compensation["sentence"]))
    return lines


def main():
    parser = new_parser("mill_growth", __doc__)
    parser.add_argument("--seeds", type=whole(1, 10000), default=5, metavar="N", help="machines (default: 5)")
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        tasks = [(seed, name) for name in FACTORS for seed in range(1, options.seeds + 1)]
        found = simulate_all(simulate, tasks, len(tasks), place_of(options))
    print("\n".join(figures(dict(zip(tasks, found)))))

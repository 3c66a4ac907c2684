# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares thermal_displacement with simple rivals on the contacts that it found itself.

A rival of its estimator is replayed over the contacts, which are recorded once: on drawn days of support/contact_days.py, or by
`--contacts DIR` of this bench, of trust and of growth. The files of one folder are a class of machines and get a table. If
build/bench/growth_replay can be run, it is a rival as well: it reads a file from stdin, and writes "OFFSET SIGMA TOLD" for each cut.
"""

from support import contact_days, contacts
from support.command import add_place, errors_reported, new_parser, place_of, whole
from support.replay import of_files, of_machines
from support.simulations import simulate_all

TARGETS = "simulation_mill growth_replay"


def main():
    parser = new_parser("rivals", __doc__)
    parser.add_argument("files", nargs="*", metavar="FILE", help="recorded contacts; without one, days are drawn")
    parser.add_argument("--each", action="store_true", help="a row for each FILE, in the place of a table for each folder")
    parser.add_argument("--days", nargs="+", choices=contact_days.DAYS, default=list(contact_days.DAYS), metavar="NAME", help="only these: " + ", ".join(contact_days.DAYS))
    parser.add_argument("--seeds", type=whole(1, 100000), default=20, metavar="N", help="drawn machines for each day (default: 20)")
    parser.add_argument("--seed", type=whole(1, 2**31 - 1), default=1, metavar="N", help="the first of them")
    parser.add_argument("--phase", type=whole(0, 299), metavar="S", help="from the start of a day to its first part (default: drawn)")
    parser.add_argument("--typical", action="store_true", help="what happens is drawn, but it happens on the typical machine")
    contacts.add_option(parser)
    add_place(parser)
    options = parser.parse_args()
    with errors_reported():
        if options.files:
            print("\n".join(of_files(options.files, options.each)))
            return
        seeds = range(options.seed, options.seed + options.seeds)
        tasks = [(name, seed, options.phase, options.typical) for name in options.days for seed in seeds]
        found = simulate_all(contact_days.simulate, tasks, sum(contact_days.DAYS[name][0] for name, *_ in tasks), place_of(options))
        of_class = ("typical-" if options.typical else "") + "{}"
        for (name, seed, *_), lines in zip(tasks, found):
            contacts.write(options.contacts, of_class.format(name), seed, lines)
        for i, name in enumerate(options.days):
            print("\n".join(of_machines(of_class.format(name), found[i * len(seeds) : (i + 1) * len(seeds)])) + "\n")

# SPDX-License-Identifier: GPL-2.0-or-later
"""The mill of configs/mill/bench.hal in the virtual-time host."""

import os
import re

from support.simulations import ROOT

CONFIG = os.path.join(ROOT, "configs", "mill", "bench.hal")


def start_mill(host, seed):
    """Loads the configuration as machine `seed`; 0 is the typical one."""
    host.load(CONFIG)
    host.command("start")
    for part in ("program", "mill", "drive"):
        host.set(part + ".seed", seed)


def every_end_mill_is_a_gauge(host):
    host.set("growth.exclude-operation-1", 0)


def same_inputs(host, instance, other, without=()):
    """Nets the inputs of a second instance to the signals of the first one."""
    for line in host.halcmd("-s", "show", "pin", instance + ".*").output.splitlines():
        netted = re.search(r" %s\.(\S+) <== (\S+)" % instance, line)
        if netted and netted[1] not in without:
            host.command("net %s %s.%s" % (netted[2], other, netted[1]))

# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures plumb panel: time to start, processor time at rest, with a chart and hidden, and memory.

The panel is in a window of a virtual X server, as in a tab of AXIS, before the mill of configs/mill/bench.hal, whose threads run
in real time in the virtual-time host. The figures are those of this computer, which nothing else should load.
"""

import contextlib
import os
import subprocess
import sys
import tempfile
import time

from support.command import errors_reported, new_parser, whole
from support.simulations import BUILD

sys.path.insert(0, os.path.join(BUILD, "python"))
import plumb  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TICK = os.sysconf("SC_CLK_TCK")
PATIENCE = 60  # s until the panel is there
SIZE = (1000, 740)  # px, of the tab
PAGES = (("at rest", "Overview", True), ("with a chart", "thermal_displacement", True), ("hidden", "thermal_displacement", False))


def main():
    parser = new_parser("panel", __doc__)
    parser.add_argument("--seconds", type=whole(1, 3600), default=30, metavar="N", help="seconds of each measurement (default: 30)")
    options = parser.parse_args()
    with errors_reported(), virtual_screen() as screen, tempfile.TemporaryDirectory() as folder:
        print("\n".join(figures(folder, screen, options.seconds)))


@contextlib.contextmanager
def virtual_screen():
    """The display of an Xvfb."""
    numbers, answer = os.pipe()
    process = subprocess.Popen(["Xvfb", "-displayfd", str(answer), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
                               pass_fds=[answer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(answer)
    try:
        with os.fdopen(numbers) as line:
            yield ":" + line.readline().strip()
    finally:
        process.terminate()
        process.wait()


def figures(folder, screen, seconds):
    lines = []
    for what, page, shown in PAGES:
        with plumb.Host() as host:
            host.command("source " + os.path.join(ROOT, "configs", "mill", "bench.hal"))
            panel = Panel(host, folder, screen, page)
            if what == "at rest":
                lines += ["start            %5.2f s until the window is drawn, %.2f s of it processor time" % (panel.start, panel.processor())]
            if not shown:
                panel.hide()
            run(host, 5)  # what a page does once
            before = panel.processor()
            took = run(host, seconds)
            lines.append("%-14s %7.2f %% of a processor" % (what, 100 * (panel.processor() - before) / took))
            if what == "with a chart":
                lines.append("memory         %7.0f MB" % panel.memory())
    return lines


def run(host, seconds):
    """In real time. Returns the seconds that it took."""
    began = time.monotonic()
    while time.monotonic() - began < seconds:
        host.run(0.1)
        time.sleep(max(0.0, 0.1 - (time.monotonic() - began) % 0.1))
    return time.monotonic() - began


class Panel:
    """The program in a window of a screen; start is the time in s until it is drawn there."""

    def __init__(self, host, folder, screen, page):
        from Xlib import X, display

        self._display = display.Display(screen)
        root = self._display.screen().root
        self._tab = root.create_window(0, 0, *SIZE, 0, self._display.screen().root_depth)
        self._tab.map()
        self._display.sync()
        ini = os.path.join(folder, "machine.ini")
        with open(ini, "w", encoding="utf-8") as file:
            file.write("[EMC]\nMACHINE = bench\n")
        began = time.monotonic()
        host.halcmd("loadusr", "env", "DISPLAY=" + screen, "NO_AT_BRIDGE=1", os.path.join(BUILD, "bin", "plumb-panel"), "-x", str(self._tab.id),
                    "--ini", ini, "--page", page, "--user", screen)
        while not any(child.get_attributes().map_state == X.IsViewable for child in self._tab.query_tree().children):
            if time.monotonic() - began > PATIENCE:
                raise RuntimeError("the panel does not appear")
            time.sleep(0.01)
        self.start = time.monotonic() - began
        self._process = process_with("plumb-panel", screen)

    def hide(self):
        self._tab.unmap()
        self._display.sync()

    def processor(self):
        """Seconds of processor time so far."""
        with open("/proc/%d/stat" % self._process, encoding="utf-8") as file:
            words = file.read().rpartition(")")[2].split()
        return (int(words[11]) + int(words[12])) / TICK

    def memory(self):
        with open("/proc/%d/status" % self._process, encoding="utf-8") as file:
            return int(next(line for line in file if line.startswith("VmRSS")).split()[1]) / 1024


def process_with(name, last):
    """The number of the process of a program whose last word is this one."""
    for number in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError), open("/proc/%s/cmdline" % number, encoding="utf-8") as file:
            words = file.read().split("\0")
            if len(words) > 2 and words[-2] == last and any(os.path.basename(word) == name for word in words[:3]) and words[0] != "env":
                return int(number)
    raise RuntimeError("there is no process " + name)

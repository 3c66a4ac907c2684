# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures how soon plumb panel is on the screen, and how much of a processor it takes.

The panel shows the machine of configs/mill/bench.hal, whose clock keeps pace with the computer's. It stands in a
window of another program, as in a tab of AXIS. Hidden means that this window is, as behind another tab. The start is the fastest of five.
"""

import ctypes
import os
import sys
import time

from support.command import errors_reported, new_parser, whole
from support.simulations import BUILD, ROOT  # which finds the modules of scripts
from screen import Finger, virtual

TARGETS = "product"
PACKAGES = "xvfb"
CONFIG = os.path.join(ROOT, "configs", "mill", "bench.hal")
STARTS = 5
PAGES = ("Overview", "Growth of Z", "All components", "Changes")
PATIENCE = 30  # s
TICK = 0.05  # s, of the machine between two pauses
SETTLING = 3  # s after the start
LIMITS = {"start": 1.0, "at rest": 2, "with a chart": 5, "hidden": 1, "memory": 100}
UNITS = {"start": "s", "memory": "MB"}  # of the others: % of a processor


class Around:
    """The window of another program, in which the panel stands."""

    def __init__(self, name):
        from Xlib import display

        self.display = display.Display(name)
        its = self.display.screen()
        self.window = its.root.create_window(0, 0, 1000, 740, 0, its.root_depth)
        self.show()

    def show(self):
        self.window.map()
        self.display.sync()

    def hide(self):
        self.window.unmap()
        self.display.sync()

    def is_filled(self):
        """Whether the panel is on the screen."""
        from Xlib import X, error

        try:
            return any(child.get_attributes().map_state == X.IsViewable for child in self.window.query_tree().children)
        except (error.BadWindow, error.BadDrawable):
            return False  # it has just gone


class Panel:
    """A panel on a host that keeps pace with the clock."""

    number = 0

    def __init__(self, host, around, display, *options):
        Panel.number += 1
        self.host, self.around = host, around
        user = f"bench-{os.getpid()}-{Panel.number}"
        words = ["env", f"DISPLAY={display}", "NO_AT_BRIDGE=1", os.path.join(BUILD, "bin", "plumb-panel")]
        words += ["-x", str(around.window.id), "--language", "en", "--user", user, *options]
        begin = time.monotonic()
        host.halcmd("loadusr", *words)
        while not around.is_filled():
            if time.monotonic() > begin + PATIENCE:
                raise RuntimeError("the panel does not come")
            time.sleep(0.01)
        self.start_time = time.monotonic() - begin
        self.pid = next(pid for pid in filter(str.isdigit, os.listdir("/proc")) if user in words_of(pid))

    def pace(self, seconds):
        """The machine runs in real time."""
        ends = now = time.monotonic()
        while now < ends + seconds:
            self.host.run(TICK)
            time.sleep(max(0, now + TICK - time.monotonic()))
            now = time.monotonic()

    def share(self, seconds):
        """Percent of a processor that it takes."""
        self.pace(SETTLING)
        before, begin = processor_time(self.pid), time.monotonic()
        self.pace(seconds)
        return 100 * (processor_time(self.pid) - before) / (time.monotonic() - begin)

    def close(self):
        os.kill(int(self.pid), 15)
        latest = time.monotonic() + PATIENCE
        while words_of(self.pid) or self.around.is_filled():
            if time.monotonic() > latest:
                raise RuntimeError("the panel does not end")
            self.pace(TICK)


def words_of(pid):
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            return file.read().decode(errors="replace").split("\0")[:-1]
    except OSError:
        return []


def processor_time(pid):
    """Seconds, by a clock that is finer than /proc: a panel at rest takes less than 10 ms in 2 s."""
    clock = ctypes.c_int()
    error = ctypes.CDLL(None).clock_getcpuclockid(int(pid), ctypes.byref(clock))
    if error:
        raise OSError(error, os.strerror(error))
    return time.clock_gettime(clock.value)


def memory(pid):
    """MB."""
    with open(f"/proc/{pid}/status") as file:
        return int(next(line for line in file if line.startswith("VmRSS")).split()[1]) / 1024


def bench(seconds):
    import plumb

    with virtual() as display, plumb.Host() as host:
        host.load(CONFIG)
        host.command("start")
        host.run(60)
        around = Around(display)
        starts = []
        for _ in range(STARTS):
            panel = Panel(host, around, display)
            starts.append(panel.start_time)
            panel.close()
        found = {"start": min(starts)}
        panel = Panel(host, around, display, "--page", "All components")
        found["at rest"] = panel.share(seconds)
        around.hide()
        found["hidden"] = panel.share(seconds)
        around.show()
        panel.close()
        panel = Panel(host, around, display, "--page", "Growth of Z")
        found["with a chart"] = panel.share(seconds)
        found["memory"] = memory(panel.pid)
        panel.close()
    for name, limit in LIMITS.items():
        unit = UNITS.get(name, "% of a processor")
        print(f"{name:14}{found[name]:7.2f} {unit:18} at most {limit:g}")
    return all(found[name] <= limit for name, limit in LIMITS.items())


def changes_of_page(count, seconds):
    """A finger goes through the pages that often in so many seconds, while the machine runs at ten times the clock. Prints growth and processor
    time of each tenth of it."""
    import plumb
    from plumb_folder import TemporaryFolder

    with virtual() as display, plumb.Host() as host, TemporaryFolder() as folder:
        host.load(CONFIG)
        host.command("start")
        host.run(60)
        around = Around(display)
        widgets = os.path.join(folder, "widgets.json")
        panel = Panel(host, around, display, "--widgets", widgets, "--period", "100")
        last = [time.monotonic()]

        def between():
            now = time.monotonic()
            host.run(min(2.0, 10 * (now - last[0])))
            last[0] = now
            time.sleep(0.02)

        finger = Finger(display, widgets, between)
        for name in 2 * PAGES:
            finger.press(name)
        began, first, used, clock = time.monotonic(), memory(panel.pid), processor_time(panel.pid), host.time
        for turn in range(count):
            finger.press(PAGES[turn % len(PAGES)])
            while time.monotonic() < began + (turn + 1) * seconds / count:
                between()
            if (turn + 1) % max(1, count // 10) == 0:
                took, now = time.monotonic() - began, memory(panel.pid)
                print(f"{turn + 1:6} changes of page in {took:.0f} s, {(host.time - clock) / took:.1f} times the clock: {first:.1f} MB -> {now:.1f} MB, "
                      f"{1000 * (now - first) / (turn + 1):.1f} kB a change, processor {100 * (processor_time(panel.pid) - used) / took:.1f} %", flush=True)
        panel.close()


def main():
    parser = new_parser("panel", __doc__)
    parser.add_argument("--for", dest="seconds", type=whole(1, 3600), default=20, metavar="SECONDS", help="measure each page for so long (default: 20)")
    parser.add_argument("--changes", type=whole(1, 100000), metavar="COUNT",
                        help="change the page that often instead, over SECONDS or longer, with the machine at ten times the clock")
    options = parser.parse_args()
    if options.changes:
        with errors_reported():
            changes_of_page(options.changes, options.seconds)
        return
    with errors_reported():
        good = bench(options.seconds)
    sys.exit(0 if good else 1)

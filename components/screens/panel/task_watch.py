# SPDX-License-Identifier: GPL-2.0-or-later
"""Prints LinuxCNC's status as one JSON object a line, when it changes and once a second, until nobody reads.

It is a process of its own: a program that was stopped with the lock of LinuxCNC's status keeps it waiting, and the
panel must stop strokes nevertheless.
"""

import json
import os
import sys
import time

PERIOD = 0.1  # s
BEAT = 10  # periods


def task_lives():
    """Whether LinuxCNC's task is there and not stopped."""
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/stat" % name, encoding="ascii", errors="replace") as file:
                program, _, rest = file.read().partition("(")[2].rpartition(")")
        except OSError:
            continue
        if program == "milltask" and rest.split()[0] not in "TtZX":
            return True
    return False


def state(linuxcnc, status):
    status.poll()
    program = "idle"
    if status.interp_state != linuxcnc.INTERP_IDLE:
        program = "paused" if status.interp_state == linuxcnc.INTERP_PAUSED or status.task_paused else "running"
    return {"task.program": program, "task.on": status.task_state == linuxcnc.STATE_ON, "task.alive": True}


def main():
    import linuxcnc

    status, last, lives = None, None, False
    for period in range(1 << 62):
        if period % BEAT == 0:
            lives = task_lives()
        try:
            status = status or linuxcnc.stat()
            now = state(linuxcnc, status)
        except linuxcnc.error:
            status, now = None, {}
        now["task.alive"] = lives and status is not None
        if now != last or period % BEAT == 0:
            print(json.dumps(now), flush=True)
            last = now
        if os.getppid() == 1:
            return
        time.sleep(PERIOD)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError):
        os._exit(0)
    except ImportError:
        sys.exit(1)

# SPDX-License-Identifier: GPL-2.0-or-later
"""LinuxCNC's task, for MDI lines."""

import time

from panel.texts import _

PATIENCE = 30  # s for a line; taking an offset back takes a few


def mdi(line, stays=False):
    """Runs one line in MDI, and goes back to the mode before, unless it stays: another mode aborts. Raises RuntimeError with the reason."""
    import linuxcnc

    try:
        command, status = linuxcnc.command(), linuxcnc.stat()
        status.poll()
    except linuxcnc.error as error:
        raise RuntimeError(_("LinuxCNC does not answer: {why}").format(why=error)) from None
    if status.task_state != linuxcnc.STATE_ON:
        raise RuntimeError(_("The machine is off."))
    if status.interp_state != linuxcnc.INTERP_IDLE:
        raise RuntimeError(_("A program runs."))
    mode = status.task_mode
    command.mode(linuxcnc.MODE_MDI)
    command.wait_complete(PATIENCE)
    command.mdi(line)
    result = command.wait_complete(PATIENCE)
    ends = time.monotonic() + PATIENCE
    status.poll()
    while status.interp_state != linuxcnc.INTERP_IDLE and time.monotonic() < ends:
        time.sleep(0.02)
        status.poll()
    if mode != linuxcnc.MODE_MDI and not stays:
        command.mode(mode)
        command.wait_complete(PATIENCE)
    if result == linuxcnc.RCS_ERROR:
        raise RuntimeError(_("LinuxCNC refuses {line}.").format(line=line))


def abort():
    """Aborts the program. Raises RuntimeError with the reason."""
    import linuxcnc

    try:
        linuxcnc.command().abort()
    except linuxcnc.error as error:
        raise RuntimeError(_("LinuxCNC does not answer: {why}").format(why=error)) from None


def start(program):
    """Opens a program and starts it. Raises RuntimeError with the reason."""
    import linuxcnc

    try:
        command, status = linuxcnc.command(), linuxcnc.stat()
        status.poll()
    except linuxcnc.error as error:
        raise RuntimeError(_("LinuxCNC does not answer: {why}").format(why=error)) from None
    if status.interp_state != linuxcnc.INTERP_IDLE:
        raise RuntimeError(_("A program runs."))
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete(PATIENCE)
    command.program_open(program)
    command.wait_complete(PATIENCE)
    command.auto(linuxcnc.AUTO_RUN, 0)

# SPDX-License-Identifier: GPL-2.0-or-later
"""Nothing that a test starts outlives it, also when the test or its keeper is killed.

Two processes stand around the test, and each of them adopts all orphans below it. One ends the rest when the test has
ended, when SIGTERM comes, or when the other is killed.
"""

import ctypes
import os
import signal
import time

MARK = "PLUMB_TEST_IS_KEPT"  # in the environment of a test that has its keepers already
PATIENCE = 5  # s, in which a program may end in order
ADAMANT = 10  # s more, in which a killed one may die
LOOK = 0.02  # s between two looks at those that are asked to end

_SET_PDEATHSIG, _SET_CHILD_SUBREAPER = 1, 36  # of prctl()
_KERNEL = 128  # si_code of a signal that a terminal sends to all


def keep():
    """Returns in a child process, which is to do the test; this process ends inside, with the exit status of the test."""
    if os.environ.get(MARK):
        return
    os.environ[MARK] = "yes"
    ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN  # as under nohup
    ends = {signal.SIGTERM, signal.SIGINT} | (set() if ignored else {signal.SIGHUP})
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ends | {signal.SIGCHLD})
    for _ in range(2):
        parent = os.getpid()
        _control(_SET_CHILD_SUBREAPER, 1)
        child = os.fork()
        if child:
            _keep(child, ends)
        _control(_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:  # it died before that
            os.kill(os.getpid(), signal.SIGTERM)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _control(*words):
    if ctypes.CDLL(None, use_errno=True).prctl(*(ctypes.c_ulong(word) for word in words)) != 0:
        raise OSError(ctypes.get_errno(), "prctl")


def _keep(child, ends):
    status, asked = None, 0
    while status is None and not asked:
        came = signal.sigwaitinfo(ends | {signal.SIGCHLD})
        # Ctrl-C has reached the test, too, which cleans up.
        if came.si_signo != signal.SIGCHLD and not (came.si_signo == signal.SIGINT and came.si_code == _KERNEL):
            asked = came.si_signo
        status = _reap(child)
    _end_all()
    os._exit(128 + asked if asked else status)


def _reap(child=None):
    """Takes in the dead. The exit status of the child, if it is one of them."""
    status = None
    while True:
        try:
            process, waited = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return status
        if process == 0:
            return status
        if process == child:
            code = os.waitstatus_to_exitcode(waited)
            status = code if code >= 0 else 128 - code


def _end_all():
    """Asks each child to end, and each orphan that falls to this process then; kills all that remain."""
    began, asked = time.monotonic(), set()
    while True:
        _reap()
        children = _children(os.getpid())
        late = time.monotonic() - began
        if not children or late > PATIENCE + ADAMANT:  # one of another user may be beyond reach
            return
        for process in children:
            if late > PATIENCE:
                _kill_below(process)
            elif process not in asked:
                _send(process, signal.SIGTERM)
                asked.add(process)
        time.sleep(LOOK)


def _kill_below(process):
    for child in _children(process):
        _kill_below(child)
    _send(process, signal.SIGKILL)


def _send(process, number):
    try:
        os.kill(process, number)
    except (ProcessLookupError, PermissionError):
        pass


def _children(process):
    found = []
    try:
        for task in os.listdir("/proc/%d/task" % process):
            with open("/proc/%d/task/%s/children" % (process, task)) as file:
                found += map(int, file.read().split())
    except OSError:
        pass  # it has ended
    return found

# SPDX-License-Identifier: GPL-2.0-or-later
"""Works a LinuxCNC as an operator does: for a DISPLAY script without a screen, or beside a screen.

    #!/usr/bin/python3
    from plumb_linuxcnc import Machine

    with Machine() as machine:
        machine.turn_on()
        machine.home()
        with machine.recording("move.csv", ["joint.0.pos-cmd", "joint.0.f-error"]):
            machine.mdi("G0 X10")
        machine.run("part.ngc")

An error message of LinuxCNC is raised as OperatorError by the call that meets it. Times are
in seconds of this program's clock: machine time under `plumb run`, which also makes recordings. A
Machine is for one thread at a time, and takes the messages from other screens that run beside it.
"""

import contextlib
import os
import time

import linuxcnc

__all__ = ["Machine", "OperatorError", "Overdue"]

_POLLING = 0.005  # seconds between two looks at the status
_MORE_MESSAGES = 0.3  # seconds in which they follow the first one
_ANSWER = 30  # seconds for LinuxCNC to answer without motion
_STALL = 0.1  # seconds; a longer time between two looks is one in which a busy computer let this program wait
_STOPPED = "motion stopped by enable input"  # motion's report of an emergency stop whose chain it sees, too


class OperatorError(RuntimeError):
    """An error message of LinuxCNC to the operator."""


class Overdue(RuntimeError):
    """A condition has not come in time."""


class Machine:
    """The LinuxCNC that runs here, waited for until it can be worked.

    status     linuxcnc.stat of the last poll()
    command    linuxcnc.command, for all that has no method here
    errors     the error messages of LinuxCNC so far, a list of texts
    messages   its other messages, and motion's report of each emergency_stop()
    """

    def __init__(self, timeout=60):
        self.errors = []
        self.messages = []
        self._raised = 0  # of the errors
        self._in_emergency_stop = False  # by this program
        self._host = None
        self.command = linuxcnc.command()
        self.status = linuxcnc.stat()
        self._channel = linuxcnc.error_channel()
        # All of the status is zero until task has written it for the first time.
        states = (linuxcnc.STATE_ESTOP, linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_OFF, linuxcnc.STATE_ON)
        ready = False
        while not ready:
            with contextlib.suppress(OperatorError):  # as of a sensor that is not there; it stays in errors
                self.wait_for(lambda status: status.joints > 0 and status.task_state in states, "LinuxCNC", timeout)
                ready = True

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._host is not None:
            self._host.close()

    @property
    def host(self):
        """The plumb.Host that this LinuxCNC runs in; it records, expects, gets and sets pins."""
        if self._host is None:
            import plumb

            path = os.environ.get("RTAPI_FIFO_PATH")
            if path is None:
                raise plumb.HostDied("this LinuxCNC does not run in a virtual-time host: start it by `plumb run`")
            self._host = plumb.Host(attach=path)
        return self._host

    @contextlib.contextmanager
    def recording(self, file, names, every=0.001):
        """Has the host write these pins into a CSV file, a row each `every` seconds, while the block runs."""
        identity = self.host.record(file, names, every)
        try:
            yield
        finally:
            self.host.stop_recording(identity)

    def poll(self):
        """Takes in the status and the messages of LinuxCNC; returns the status."""
        with contextlib.suppress(linuxcnc.error):  # while there is no status yet
            self.status.poll()
        while True:
            message = None
            with contextlib.suppress(linuxcnc.error):  # as above
                message = self._channel.poll()
            if not message:
                return self.status
            kind, text = message
            text = text.strip()
            is_error = kind in (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR) and not (self._in_emergency_stop and text == _STOPPED)
            (self.errors if is_error else self.messages).append(text)

    def wait_for(self, condition, what, timeout=60):
        """Waits until condition(status) is true. Raises OperatorError where an error comes first, or Overdue."""
        waited = 0
        while not condition(self.poll()) and len(self.errors) == self._raised:
            if waited > timeout:
                raise Overdue("%s did not come within %g s" % (what, timeout))
            waited += self._sleep()
        if len(self.errors) > self._raised:
            self._raise_errors()

    def wait(self, seconds):
        """Lets this much of the machine's time pass: of servo cycles, once a recording has been made."""
        if self._host is None:
            time.sleep(seconds)
            return
        end = self._host.time + seconds
        while self._host.time < end:
            time.sleep(_POLLING)

    def turn_on(self):
        """Resets the emergency stop, and turns the machine on."""
        self._state(linuxcnc.STATE_ESTOP_RESET, lambda status: status.task_state != linuxcnc.STATE_ESTOP)
        self._in_emergency_stop = False
        self._state(linuxcnc.STATE_ON, lambda status: status.task_state == linuxcnc.STATE_ON)

    def turn_off(self):
        """Turns the machine off."""
        self._state(linuxcnc.STATE_OFF, lambda status: status.task_state != linuxcnc.STATE_ON)

    def emergency_stop(self):
        """Stops as the red button does."""
        self._in_emergency_stop = True
        self._state(linuxcnc.STATE_ESTOP, lambda status: status.task_state == linuxcnc.STATE_ESTOP)

    def home(self, timeout=300):
        """Homes all joints, homed ones again: by HOME_SEQUENCE, then those without one, one by one."""
        self.mode(linuxcnc.MODE_MANUAL)
        self.joint_mode()
        if any(self.status.homed):
            self.command.unhome(-1)
            self.wait_for(lambda status: not any(status.homed), "unhoming", _ANSWER)
        ini = linuxcnc.ini(self.status.ini_filename)
        joints = range(self.status.joints)
        in_sequence = [joint for joint in joints if ini.find("JOINT_%d" % joint, "HOME_SEQUENCE") is not None]
        if in_sequence:
            self.command.home(-1)
            self._await_home(in_sequence, timeout)
        for joint in joints:
            if joint not in in_sequence:
                self.command.home(joint)
                self._await_home([joint], timeout)

    def mode(self, mode):
        """Changes to linuxcnc.MODE_MANUAL, MODE_MDI or MODE_AUTO."""
        if self.poll().task_mode != mode:
            self.command.mode(mode)
            self.wait_for(lambda status: self._is_done() and status.task_mode == mode, "the mode", _ANSWER)

    def joint_mode(self):
        """Lets jogs move single joints, in manual mode."""
        self.command.teleop_enable(0)
        self.wait_for(lambda status: status.motion_mode == linuxcnc.TRAJ_MODE_FREE, "joint mode", _ANSWER)

    def axis_mode(self):
        """Lets jogs move axes, in manual mode, once all is homed."""
        self.command.teleop_enable(1)
        self.wait_for(lambda status: status.motion_mode == linuxcnc.TRAJ_MODE_TELEOP, "axis mode", _ANSWER)

    def mdi(self, block, timeout=600, wait=True):
        """Carries out a block of G-code; to its end, unless wait is False."""
        self.mode(linuxcnc.MODE_MDI)
        self.command.mdi(block)
        self._await_receipt()
        if wait:
            self.wait_until_idle(timeout)

    def run(self, program, timeout=86400):
        """Runs a G-code file to its end."""
        self.start(program)
        self.wait_until_idle(timeout)

    def start(self, program):
        """Starts a G-code file, and returns."""
        self.mode(linuxcnc.MODE_AUTO)
        self.command.program_open(os.path.abspath(program))
        self.wait_for(lambda status: self._is_done(), "the program's file", _ANSWER)
        if hasattr(self.status, "taskbeat"):
            time.sleep(0.1)  # LinuxCNC 2.10 names the program until it begins: linuxcnc_link has to see it
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self._await_receipt()

    def was_aborted(self):
        """Whether the last program was aborted: LinuxCNC then shows no block of it. Version 2.10 is not judged."""
        return not hasattr(self.status, "taskbeat") and self.poll().command == ""

    def pause(self):
        """Holds the program, and waits until the axes stand."""
        self.command.auto(linuxcnc.AUTO_PAUSE)
        self.wait_for(lambda status: status.paused, "the pause", _ANSWER)
        self.wait_until_still()

    def resume(self):
        """Lets a held program go on."""
        self.command.auto(linuxcnc.AUTO_RESUME)
        self.wait_for(lambda status: not status.paused, "the end of the pause", _ANSWER)

    def abort(self, timeout=60):
        """Aborts all motion, and waits until the axes stand. Errors that come meanwhile are not raised."""
        self.command.abort()
        while True:
            try:
                return self.wait_until_idle(timeout)
            except OperatorError:
                pass  # The caller aborts because of an error.

    def wait_until_idle(self, timeout=600):
        """Waits until program or block are carried out, and nothing moves."""
        self.wait_for(lambda status: self._is_idle(), "the end of the motion", timeout)

    def wait_until_still(self, timeout=60):
        """Waits until no joint is commanded to move."""
        self.wait_for(
            lambda status: all(joint["velocity"] == 0 for joint in status.joint[: status.joints]),
            "standstill",
            timeout,
        )

    def _await_home(self, joints, timeout):
        what = "the home of joint " + ", ".join(map(str, joints))
        self.wait_for(lambda status: all(status.homed[joint] for joint in joints), what, timeout)

    def _state(self, state, is_reached):
        self.command.state(state)
        self.wait_for(lambda status: self._is_done() and is_reached(status), "the change of state", _ANSWER)

    def _await_receipt(self):
        self.wait_for(lambda status: status.echo_serial_number >= self.command.serial, "the receipt", _ANSWER)

    def _is_done(self):
        # The status may still belong to the command before.
        return self.status.echo_serial_number >= self.command.serial and self.status.state != linuxcnc.RCS_EXEC

    def _is_idle(self):
        return (
            self._is_done()
            and self.status.interp_state == linuxcnc.INTERP_IDLE
            and self.status.exec_state == linuxcnc.EXEC_DONE
            and self.status.queue == 0
            and self.status.inpos
        )

    def _sleep(self):
        """Sleeps until the next look; returns how much of it counts for a time-out."""
        began = time.monotonic()
        time.sleep(_POLLING)
        return min(time.monotonic() - began, _STALL)

    def _raise_errors(self):
        # LinuxCNC sends several messages for one cause.
        waited = 0
        while waited < _MORE_MESSAGES:
            waited += self._sleep()
            self.poll()
        news = self.errors[self._raised :]
        self._raised = len(self.errors)
        raise OperatorError("; ".join(news))

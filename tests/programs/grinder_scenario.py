#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The DISPLAY of grinder_linuxcnc_test: strokes of Z beside a contour, stopped in every way that there is."""

import contextlib
import os
import signal
import subprocess
import sys

import linuxcnc
from plumb_linuxcnc import OperatorError, Overdue
from scenario import Scenario, run

STROKE, LOWER = "M3 S1000 G81.1 Z5 Q-30 R5 P3600", -25


class Shift(Scenario):
    columns = [
        "scene",
        "joint.0.pos-cmd",
        "joint.2.pos-cmd",
        "joint.2.f-error",
        "motion.current-vel",
        "motion.program-line",
        "motion.motion-enabled",
        "motion.homing-inhibit",
        "joint.2.homed",
        "chop.active",
        "chop.command",
        "chop.offset",
        "chop.stroke-count",
        "z-stage.applied-offset",
        "z-stage.drive-command",
        "grinder.truth-position",
        "interlock.feed-service-lost",
        "interlock.feed-inhibit",
        "chop.at-end",
        "chop.stroking",
        "chop.speed-factor",
        "chop.upper",
        "chop.run",
        "chop.emergency-hold",
        "chop.end-position",
        "chop.measured-position",
        "interlock.function-enable-0",
    ]

    def work(self):
        self.play(
            self.turn_on,
            self.contour,
            self.pause,
            self.abort,
            self.after_abort,
            self.waiting,
            self.jogging,
            self.defeated,
            self.program_ends,
            self.next_program,
            self.outlasting,
            self.begun_in_mdi,
            self.taken_over,
            self.shifts,
            self.shifted_in_mdi,
            self.holds,
            self.emergency_stop,
            self.on_again,
            self.start_again,
            self.off_and_on,
            self.back_at_r,
            self.retracted,
            self.changed_settings,
            self.enable_lost,
            self.enable_back,
            self.to_point_r,
            self.to_point_r_with_a_lead,
            self.refusals,
            self.with_a_tool,
            self.in_inches,
            self.by_words,
            self.at_the_lower_dead_point,
            self.without_words,
            self.learn,
            self.learned_again,
            self.proven,
            self.unhomed,
            self.lost_homed,
            self.impatient,
            self.task_stops,
            self.task_returns,
            self.io_stops,
            self.io_returns,
            self.link_dies,
            self.both_die,
        )

    def end(self):
        """Nothing is left that could turn the machine off."""

    def turn_on(self):
        self.host.set("chop.learn", 0)
        # An emergency stop ends the spindle first. On a busy computer LinuxCNC turns motion off after more than 0.2 s.
        self.host.set("chop.at-speed-time", 5)
        self.machine.turn_on()
        self.machine.home()
        self.await_pin("chop.enabled", 1)  # plumb-retain has restored its values

    def contour(self):
        self.machine.run("contour.ngc")

    def strokes(self, count):
        """Waits for so many more strokes."""
        last = self.host.get("chop.stroke-count") + count
        self.await_condition(lambda: self.host.get("chop.stroke-count") >= last, "%d strokes" % count)

    def await_strokes(self):
        """Two strokes of a start that may be yet to come."""
        get = self.host.get
        self.await_condition(lambda: get("chop.active") == 1 and get("chop.stroke-count") >= 2, "the strokes")

    def start(self, stroke=STROKE):
        """In MDI: the end of a program must have been seen before."""
        self.await_pin("linuxcnc-alive.part-program-running", 0)
        self.machine.mdi(stroke)
        self.await_strokes()

    def pause(self):
        self.machine.start("contour.ngc")
        self.await_strokes()
        self.machine.pause()
        self.strokes(2)
        self.machine.resume()

    def abort(self):
        self.machine.abort()
        self.await_pin("chop.at-end", 1)

    def after_abort(self):
        """No stroke comes back with the next block."""
        self.machine.mdi("G0 X0 Y0 Z10")

    def abort_in_the_work(self, stroke=STROKE):
        self.start(stroke)
        self.await_depth()
        self.machine.abort()

    def waiting(self):
        """MDI after an abort: outputs at once, moves when the wheel is at R. It returns slowly, for a busy computer to see it."""
        self.abort_in_the_work(STROKE.replace("P3600", "P900"))
        self.machine.mdi("M64 P30")
        self.facts["output"] = [self.host.get("motion.digital-out-30"), self.host.get("chop.active")]
        self.machine.mdi("M65 P30")
        self.machine.mdi("G0 X30")
        self.facts["told"] = "\n".join(self.machine.messages)

    def jogging(self):
        """The way out is X. The wheel returns slowly, for a busy computer to jog meanwhile."""
        self.abort_in_the_work(STROKE.replace("P3600", "P900"))
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.axis_mode()
        self.jog(0, 5, speed=20)
        self.await_pin("chop.at-end", 1)
        self.machine.mdi("G0 X0")

    def defeated(self):
        """No hold of LinuxCNC acts: interlock aborts the move."""
        self.facts["defeated"] = {}
        for code, back in (("M49", "M48"), ("M51 P0", "M51 P1")):
            self.await_pin("interlock.hold-defeated", 0)
            self.machine.mdi(code)
            self.machine.mdi("M53 P0")
            self.abort_in_the_work()
            with contextlib.suppress(OperatorError):
                self.machine.mdi("G1 X40 F600")
                self.machine.wait_for(lambda _: False, "the message")
            self.facts["defeated"][code] = self.host.get("joint.0.pos-cmd")
            self.await_pin("chop.at-end", 1)
            self.machine.mdi(back)
            self.machine.mdi("M53 P1")
            self.machine.mdi("G0 X0")

    def program(self, *lines):
        with open("strokes.ngc", "w") as file:
            file.write("\n".join(("G90", *lines, "M2", "")))
        self.machine.start("strokes.ngc")

    def program_ends(self):
        """Without its G80.1."""
        self.program(STROKE, "G1 X20 F1200")
        self.machine.wait_until_idle()
        self.await_pin("chop.stroking", 0)

    def next_program(self):
        """Its first move waits for R, and its strokes begin."""
        self.program("G1 X0 F1200", STROKE, "G1 X20", "G80.1")
        self.machine.wait_until_idle()
        self.facts["next_program"] = [self.host.get("chop.at-end"), self.host.get("chop.fault-code")]

    def outlasting(self):
        """M64 P18 lets strokes outlast their program, and those of MDI the begin of a program. M2 stops the spindle."""
        self.host.set("chop.without-wheel", 1)
        for own in (["M64 P18", STROKE], []):
            if not own:
                self.machine.mdi("M64 P18")
                self.start()
            self.program(*own, "G1 X0 F1200", "G1 X20")
            self.machine.wait_until_idle()
            self.strokes(2)
            self.facts["outlasting" if own else "of_mdi"] = self.host.get("chop.stroking")
            self.machine.mdi("M65 P18")
            self.machine.mdi("G80.1")
            self.machine.mdi("G0 X20")
        self.host.set("chop.without-wheel", 0)

    def begun_in_mdi(self):
        """Strokes end with the begin of a program, whose first move waits for R."""
        self.start()
        self.await_depth()
        self.program("G1 X0 F1200", "G1 X20")
        self.machine.wait_until_idle()

    def taken_over(self):
        """A program whose first line is G81.1: its strokes begin when those of MDI have ended."""
        self.start()
        self.machine.wait(2)
        self.program("G81.1 Z4 Q-30", "G1 X0 F1200", "G1 X20", "G80.1")
        self.machine.wait_until_idle()

    def shifts(self):
        """Each comes with the next move of its program. The last shift of a row counts, and one without a move is void."""
        two = ("G81.1 Z8 Q-30", "G81.1 Z4 Q-30")
        self.program("F1200", STROKE, "G1 X21", *two, "G1 X90", "G81.1 Z9 Q-28", "G80.1", STROKE, "G1 X20", "G80.1")
        self.machine.wait_until_idle()

    def shifted_in_mdi(self):
        """At once: in MDI no move follows. In a program M482 waits for the region that is to come."""
        self.start()
        self.machine.mdi("G81.1 Z4 Q-30 P4800")
        self.await_condition(lambda: self.host.get("chop.command") < LOWER - 0.9, "the lower region")
        self.strokes(2)
        self.facts["faster_cycle"] = self.host.get("chop.planned-cycle-time")
        self.machine.mdi("G80.1")
        self.program(STROKE, "G81.1 Z3 Q-30", "M482", "G4 P10", "G80.1")  # two cycles on a busy computer, too
        self.machine.wait_until_idle()
        self.facts["awaited_region"] = self.host.get("chop.upper")

    def holds(self):
        """At the next dead point, at R by the setting, and at once only for an emergency."""
        get, change = self.host.get, self.host.set
        self.start()
        self.facts["holds"] = []
        for kind, order in ((1, "feed-hold"), (0, "feed-hold"), (1, "emergency-hold")):
            change("chop.hold-kind", kind)
            self.await_condition(lambda: get("chop.velocity") < -50, "a downward stroke")
            change("chop." + order, 1)
            self.await_pin("chop.held", 1)
            self.machine.wait(0.3)
            self.facts["holds"].append([get("chop.command"), get("chop.active")])
            change("chop." + order, 0)
            self.strokes(2)
        self.machine.mdi("G80.1")

    def await_depth(self):
        """In the work: 20 mm below R and more."""
        self.await_condition(lambda: self.host.get("chop.offset") < -20, "a wheel in the work")

    def emergency_stop(self):
        self.start()
        self.await_depth()
        self.machine.emergency_stop()

    def note_place(self, name):
        """Where LinuxCNC shows Z, where it is, and where a relative move in MDI takes it."""
        self.machine.wait(0.2)
        status = self.machine.poll()
        shown, measured, truth = status.position[2], status.actual_position[2], self.host.get("grinder.truth-position")
        self.machine.command.mdi("G91 G0 Z1")  # in MDI still, as the operator left it
        self.await_condition(lambda: abs(self.host.get("joint.2.pos-cmd") - truth - 1) < 0.01, "a relative move")
        self.machine.wait_until_idle()
        self.facts[name] = [shown, measured, truth, self.host.get("joint.2.pos-cmd"), self.host.get("chop.offset")]
        self.machine.mdi("G90")

    def on_again(self):
        self.facts["stands"] = [self.host.get("z-stage.fault-code"), self.host.get("chop.fault-code")]
        self.machine.turn_on()
        self.machine.wait(0.5)

    def start_again(self):
        self.note_place("emergency_stop")
        self.start()
        self.strokes(2)

    def off_and_on(self):
        self.await_depth()
        self.machine.turn_off()
        self.machine.wait(0.3)
        self.machine.turn_on()
        self.machine.wait(0.5)

    def proven(self):
        """contour.ngc as shipped, with learning: at full speed in both regions."""
        self.machine.run("contour.ngc")

    def unhomed(self):
        """The joint loses its homed state where machine off has ended the stroke, and is homed again: there, so that all places
        are other ones from here on."""
        self.start()
        self.await_depth()
        self.machine.turn_off()
        self.machine.wait(0.3)
        self.machine.turn_on()
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.joint_mode()
        self.machine.command.unhome(2)
        self.await_pin("joint.2.homed", 0)
        self.machine.wait(0.5)
        self.machine.home()
        self.facts["homed_again"] = self.host.get("joint.2.homed")
        self.machine.mdi("G0 Z10")

    def lost_homed(self):
        """Unhomed amid a stroke, by mistake: the wheel brakes and stands. Machine off makes its place true."""
        self.start()
        self.await_depth()
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.joint_mode()
        self.machine.command.unhome(2)
        self.await_pin("joint.2.homed", 0)
        for _ in ("of chopping", "of the stage"):
            with contextlib.suppress(OperatorError, Overdue):
                self.machine.wait_for(lambda _: False, "a message", 5)
        self.machine.turn_off()
        self.machine.wait(0.3)
        self.machine.turn_on()
        self.machine.home()
        self.machine.mdi("G0 Z10")

    def back_at_r(self):
        self.note_place("off")
        before = self.host.time
        self.facts["g801_after_off"] = [self.host.get("chop.stands-off"), self.refuse("G80.1"), self.host.time - before]
        self.facts["m482_at_rest"] = self.refuse("M482")
        self.start()
        self.facts["m482_without_learn"] = [self.host.get("chop.learn"), self.refuse("M482"), self.host.get("chop.stands-off")]
        self.machine.mdi("G80.1")
        self.facts["at_r"] = [self.host.get("chop.offset"), self.host.get("z-stage.applied-offset")]

    def retracted(self):
        """The wheel is moved in MDI and by hand after an emergency stop in the work; then contour.ngc runs from its start."""
        self.start()
        self.await_depth()
        self.machine.emergency_stop()
        self.machine.turn_on()
        self.machine.mdi("G0 Z-20")
        self.machine.wait(0.5)  # for the lag of the drive
        self.facts["mdi_after_stop"] = self.host.get("grinder.truth-position")
        self.machine.mode(linuxcnc.MODE_MANUAL)
        self.machine.axis_mode()
        self.jog(2, 40, speed=20)
        self.machine.run("contour.ngc")

    def despite_messages(self, act):
        """What an operator does who reads on; a second cause may have a message of its own."""
        for _ in range(5):
            with contextlib.suppress(OperatorError):
                return act()

    def changed_settings(self):
        """Each while the wheel is in the work, and back: taken with the next stroke, or refused with a message. At rest in the
        work a smaller max-offset is refused."""
        get, change = self.host.get, self.host.set
        self.start()
        for name, value in {"max-acceleration": 10, "jerk-time": 0.05, "lead": 0.01, "max-rate": 30, "max-offset": 5}.items():
            before = get("chop." + name)
            self.await_depth()
            change("chop." + name, value)
            self.despite_messages(lambda: self.machine.wait(0.7))
            change("chop." + name, before)
            self.despite_messages(lambda: self.strokes(2))
        self.despite_messages(lambda: self.machine.mdi("G80.1 P1"))
        self.machine.wait_until_idle()
        place, before = get("chop.command"), get("chop.max-offset")
        change("chop.max-offset", 5)
        self.despite_messages(lambda: self.machine.wait(0.5))
        self.facts["smaller_bound"] = [get("chop.command") - place, get("chop.fault-code")]
        change("chop.max-offset", before)
        self.despite_messages(lambda: self.machine.mdi("G80.1"))
        self.await_pin("chop.at-end", 1)

    def enable_lost(self):
        """Where the program would have stopped in the work."""
        self.host.set("chop.stop-kind", 2)
        self.start()
        self.host.set("interlock.function-switch-0", 0)
        self.await_pin("chop.at-end", 1)

    def enable_back(self):
        self.host.set("interlock.function-switch-0", 1)
        self.await_pin("chop.enabled", 1)
        self.machine.wait(0.5)
        self.facts["enable_back"] = [self.host.get("chop.enabled"), self.host.get("chop.run")]
        self.machine.mdi("G80.1")

    def to_point_r(self):
        self.start()
        self.host.set("chop.go-to-end", 1)
        self.await_pin("chop.at-end", 1)
        self.host.set("chop.go-to-end", 0)
        self.host.set("chop.stop-kind", 0)
        self.machine.mdi("G80.1")

    def to_point_r_with_a_lead(self):
        """A lead and a jerk-time that need 6000 mm/s2 are refused, also for the way to R."""
        self.start()
        self.machine.mdi("G80.1 P1")
        before = self.host.get("chop.jerk-time")
        self.host.set("chop.jerk-time", 0.004)
        self.host.set("chop.lead", 0.01)
        self.host.set("chop.go-to-end", 1)
        self.despite_messages(lambda: self.await_pin("chop.at-end", 1))
        self.facts["lead_refused"] = self.host.get("chop.fault-code")
        for name, value in (("go-to-end", 0), ("lead", 0), ("jerk-time", before)):
            self.host.set("chop." + name, value)
        self.despite_messages(lambda: self.machine.mdi("G80.1"))

    def refuse(self, *blocks):
        """All that the operator reads until the last block has ended; those before it are carried out."""
        texts = []
        for block in blocks[:-1]:
            self.machine.mdi(block)
        carry_out, words = self.machine.mdi, blocks[-1:]
        while carry_out:
            try:
                carry_out(*words)
                carry_out = None
            except OperatorError as error:
                texts.append(str(error))
                carry_out, words = self.machine.wait_until_idle, ()
        return "; ".join(texts)

    def refusals(self):
        """Each as the operator reads it."""
        fast, far, deep = "G81.1 Z5 Q-30 R5 P60000", "G81.1 Z-200 Q-110 R5 P600", "G81.1 Z-250 Q-20 R200 P600"
        flat, no_q, negative = "G81.1 Z5 Q0 R5 P600", "G81.1 Z5 R5 P600", "G81.1 Z5 Q-30 P-5"
        blocks = {"fast": fast, "far": far, "deep": deep, "flat": flat, "no_q": no_q, "negative": negative}
        stroke = "G81.1 Z5 Q-30 R25 P3600 "  # R is 20 mm above the present Z
        blocks.update({word: stroke + word for word in ("F20", "X40.5", "L1", "I-1", "J3601", "K1.5", "D2", "E-0.1")})
        blocks.update({word: "M481 I0 J-10 P0.5 " + word for word in ("Q3",)})
        blocks.update({word: word for word in ("M481 I5 J5 P1", "M481 I0 J1 P0", "G80.1 P3", "G80.1 K0.5")})
        blocks["overlap"] = "M481 I0 J-10 P0.5", "M481 I-5 J-15 P0.5", stroke
        self.facts["refused"] = {name: self.refuse(*[block] if isinstance(block, str) else block) for name, block in blocks.items()}
        self.await_pin("chop.program-sections", 0)  # the abort takes its time
        self.facts["words_left"] = self.host.get("chop.program-sections")

    def with_a_tool(self):
        """The words are of the work, whatever its origin and the tool."""
        self.machine.mdi("G10 L2 P1 Z-3")
        self.machine.mdi("T2 M6 G43")
        self.machine.mdi("M3 S1000 G81.1 Z-60 Q-30 R5 P3600")
        self.await_strokes()
        self.strokes(2)
        self.facts["with_a_tool"] = [self.host.get("chop.upper"), self.host.get("chop.lower")]
        self.facts["joint"] = self.host.get("joint.2.pos-cmd")
        self.machine.mdi("G80.1")
        self.machine.mdi("G49")
        self.machine.mdi("G10 L2 P1 Z0")
        self.machine.mdi("G0 Z10")

    def in_inches(self):
        self.machine.mdi("G20")
        self.machine.mdi("M3 S1000 G81.1 Z0.2 Q-1 R0.1 P100")
        self.await_strokes()
        self.facts["in_inches"] = [self.host.get("chop." + name) for name in ("upper", "lower", "feed")]
        self.machine.mdi("G80.1")
        self.machine.mdi("G21")

    def by_words(self):
        """A section, dwell, exact stop, an override that does not act, and in G91 a Z that is a position still."""
        self.host.set("chop.override", 0.5)
        self.machine.mdi("M480")
        self.machine.mdi("M481 I-25 J-15 P0.5")
        self.machine.mdi("M3 S1000 G91 G81.1 Z5 Q-30 R5 P3600 I0.2 J0.1 E0.05 D0")
        self.await_strokes()
        self.strokes(4)
        self.facts["sections"] = self.host.get("chop.program-sections")
        self.machine.mdi("G81.1 Z5 Q-30 J0")  # while it strokes: J alone changes
        self.machine.mdi("X1 F600")
        self.strokes(3)
        self.machine.mdi("G90")

    def at_the_lower_dead_point(self):
        self.machine.mdi("G80.1 P1 K2")
        get = self.host.get
        self.facts["at_lower"] = [get("chop.command"), get("chop.active"), get("chop.program-sections")]
        self.machine.wait(0.2)
        self.machine.mdi("G80.1")
        self.facts["from_lower_to_r"] = [get("chop.offset"), get("chop.at-end")]

    def without_words(self):
        """The words have ended with their strokes: the settings hold, and the override of the panel."""
        self.machine.mdi("M3 S1000 G81.1 Z5 Q-30 R5")
        self.await_strokes()
        self.strokes(2)
        self.facts["cycle_without_words"] = self.host.get("chop.planned-cycle-time")
        self.machine.mdi("G80.1")
        self.host.set("chop.override", 1)

    def learn(self):
        self.host.set("chop.learn", 1)
        self.machine.mdi("M3 S1000 G81.1 Z5 Q-30 R5 P3600")
        self.facts["impatient"] = self.refuse("M482 P2")
        self.await_pin("chop.at-end", 1)
        self.machine.mdi("M3 S1000 G81.1 Z5 Q-30 R5 P3600")
        self.machine.mdi("M482")
        self.facts["waited"] = self.host.get("chop.learned")
        self.strokes(2)
        names = ("upper", "lower")
        self.facts["dead_points"] = [self.host.get("grinder.truth-" + name) for name in names]
        self.facts["codes"] = [self.host.get("chop.fault-code"), self.host.get("z-stage.limited")]
        self.await_condition(lambda: self.host.get("chop.velocity") < -50, "a downward stroke")
        self.machine.mdi("G80.1")

    def learned_again(self):
        """The end of the last strokes at R has spoilt nothing."""
        self.machine.mdi("M3 S1000 G81.1 Z5 Q-30 R5 P3600")
        self.await_strokes()
        self.strokes(4)
        self.facts["learned_again"] = [self.host.get("chop." + name) for name in ("speed-factor", "fault-code")]
        self.machine.mdi("G80.1")

    def impatient(self):
        """The time-outs of configs/common/alive.hal; tests have longer ones (linuxcnc_runs.py). While it learns, the strokes end
        inside of their region."""
        self.host.set("chop.learn", 0)
        for service in (4, 5):
            self.host.set("interlock.service-timeout-%d" % service, 2.5)

    def stroke_and_feed(self):
        """X is on its way for longer than it takes to see a loss."""
        self.start()
        self.machine.mdi("G1 X%d F60" % (100 if self.host.get("joint.0.pos-cmd") < 0 else -100), wait=False)
        self.machine.wait(0.5)

    def await_end_of_stroke(self):
        self.await_pin("interlock.feed-service-lost", 1)
        self.await_pin("chop.at-end", 1)
        self.machine.wait(0.3)

    def go_on(self):
        """The feed stays held, and no stroke comes back, until the operator renews the function."""
        os.kill(self.reached[0], signal.SIGCONT)
        for service in (4, 5):
            self.await_pin("interlock.service-ok-%d" % service, 1)
        self.machine.wait(0.5)
        self.facts[self.scenes[-1]] = [self.host.get("interlock.feed-inhibit"), self.host.get("interlock.function-enable-0")]
        x = self.host.get("joint.0.pos-cmd")
        self.await_message("a service was lost, and answers again")
        self.machine.wait(0.5)
        self.facts[self.scenes[-1]] += [self.host.get("joint.0.pos-cmd") - x, self.host.get("motion.motion-type")]
        self.machine.abort()
        self.host.set("interlock.function-switch-0", 0)
        self.machine.wait(0.1)
        self.host.set("interlock.function-switch-0", 1)
        self.await_pin("interlock.function-enable-0", 1)
        self.await_pin("interlock.feed-inhibit", 0)

    def task_stops(self):
        self.stroke_and_feed()
        self.reached = self.signal(signal.SIGSTOP, "task_stopped", "inihal")
        self.await_end_of_stroke()

    def task_returns(self):
        self.go_on()

    def io_stops(self):
        self.stroke_and_feed()
        self.reached = self.signal(signal.SIGSTOP, "io_stopped", "iocontrol")
        self.await_end_of_stroke()

    def io_returns(self):
        """LinuxCNC's task can take a move for done that has not begun, and shows no program then: the move is held still."""
        subprocess.run(["halcmd", "unlinkp", "interlock.program-running"], check=True)
        self.host.set("interlock.program-running", 0)
        self.go_on()
        subprocess.run(["halcmd", "net", "program-running", "interlock.program-running"], check=True)

    def link_dies(self):
        self.host.set("interlock.service-timeout-1", 2)
        self.stroke_and_feed()
        self.reached = self.signal(signal.SIGKILL, "link_dead", "linuxcnc-link")
        self.await_pin("interlock.service-lost-1", 1)
        self.strokes(2)

    def both_die(self):
        """Within 5 s of the computer's clock: plumb run ends without a task. So the dead are missed early."""
        self.reached = self.signal(signal.SIGKILL, "both_dead", "inihal", "iocontrol")
        for service in (4, 5):
            self.host.set("interlock.service-timeout-%d" % service, 0.5)
        self.await_end_of_stroke()
        self.facts["lost"] = [self.host.get("interlock.service-lost-%d" % service) for service in (1, 4, 5)]


if __name__ == "__main__":
    sys.exit(run(Shift, recording="shift.csv"))

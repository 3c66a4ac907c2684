# SPDX-License-Identifier: GPL-2.0-or-later
"""thermal_displacement: the load, a touch of a block by hand feed, and a step of +0.020 mm by verify-step."""

from commissioning.judging import Verdict, good, judge, judge_press
from commissioning.steps import Field, OnTrial, Step, where_to_put_it
from panel.texts import _, number

MOVES_NOTHING = False
STEP = 0.020  # mm
OPERATION = 999  # a number that no program uses


def steps(session):
    return [Load(session), Place(session), Touch(session), VerifyStep(session)]


def unused(rig, instance):
    """Inputs that nobody needs to write: the measured position of a stroking axis lacks the motor offset."""
    return ["z-motor-offset"] if rig.machine.writer(instance.full("z-position")).endswith(".measured-position") else []


class Load(Step):
    minutes = 3

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Load of the spindle")
        self.look = _("The spindle has stood so far, and its load was near 0. Start it now at your usual speed, in air. Enter the load that the drive itself shows.")
        self.back = _("Stop the spindle.")
        self.picture = ("load", "")
        self.fields = (Field("shown", _("Load shown by the drive"), "%"),)

    def begin(self):
        self.at_rest = float(self.rig.get(self.function.instance, "load"))

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        if not rig.get(instance, "load-valid"):
            return Verdict("net", _("The load is not valid: its sensor reports nothing."), _("Check the sensor, and its net."))
        if not rig.get(instance, "spindle-speed-cmd"):
            return Verdict("state", _("The spindle stands."), _("Start it. If it turns, net its speed to {pin}.").format(pin=instance.full("spindle-speed-cmd")))
        readings = []
        for _turn in range(25):
            readings.append(float(rig.get(instance, "load")))
            rig.sleep(0.02)
        load = sum(readings) / len(readings)
        verdict = judge(values["shown"], load, max(1.0, 0.25 * abs(values["shown"])), _("Load"), 0.005 * abs(values["shown"]), "load")
        follows = abs(load - self.at_rest) > 0.2 * abs(values["shown"])
        if verdict.fault in ("", "size", "nothing") and not follows and abs(values["shown"]) > 3:
            return Verdict("nothing", _("The load does not follow the spindle: {rest} at rest, {load} now.").format(
                rest=number(self.at_rest, 3), load=number(load, 3)), _("Net the load of the spindle, not another signal."))
        if verdict.passed:
            self.session.has_tried(instance.full("load"))
        return verdict


class Place(Step):
    def __init__(self, session):
        super().__init__(session)
        self.title = _("Place of Z")
        self.look = _("Move Z to a height that is not 0, far from the work. Enter the machine position of Z (G53) as the screen of LinuxCNC shows it.")
        self.back = _("Nothing is applied: the function is off.")
        self.fields = (Field("shown", _("Machine position of Z")),)

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        place = float(rig.get(instance, "z-position")) - float(rig.get(instance, "z-motor-offset"))
        if abs(values["shown"]) < 2 * self.unit:
            return Verdict("state", _("Z is too near to its zero for this."), _("Move Z, and repeat the step."))
        return judge(values["shown"], place, 0.1 * self.unit, instance.full("z-position"))


class Touch(OnTrial):
    """Nobody needs to press: the function measures only, and moves nothing."""

    holds, watches, measures = False, True, True
    minutes = 4

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Touch of a block")
        self.look = _("Clamp a block of soft material. With the spindle turning, lower the tool onto it by hand feed or slowly in MDI, until it just cuts, and "
                      "retract. The function counts this contact, and moves nothing.")
        self.back = _("Retract Z. Nothing is applied: the function measures only.")
        self.picture = ("touch", "Z")

    def begin(self):
        self.refused = self.session.lend(self.function.instance, "dry-run", 1) or self.begin_press()
        for line in ("M68 E0 Q%d" % OPERATION, "M64 P0"):
            self.rig.mdi(line)
        self.before = int(self.rig.get(self.function.instance, "contacts"))

    def finish(self, values):
        rig, instance = self.rig, self.function.instance
        count = int(rig.get(instance, "contacts")) - self.before
        self.end_press()
        rig.mdi("M65 P0")
        refused = self.refused
        if refused is None and count < 1:
            refused = self.acting() or Verdict("nothing", _("No contact was seen."), _(
                "Check threshold and release against the rise of the load, {pin}.").format(pin=instance.full("load")))
        if refused is not None:
            self.begin()
            return refused
        rig.mdi("M68 E0 Q0")
        self.session.give_back()
        return good(_("Contacts: {count}, the last one at {place}.").format(count=count, place=number(float(rig.get(instance, "contact-coordinate")))))


class VerifyStep(OnTrial):
    """The function itself moves Z, through its stage, and takes it back."""

    minutes = 4

    def __init__(self, session):
        super().__init__(session)
        self.title = _("Z rises by {size} mm").format(size="+%.3f" % STEP) + session.in_inches(STEP)
        self.look = " ".join((_("The spindle stands."), where_to_put_it("Z"), _("Set it to 0. Press and hold: Z rises by verify-step."),
                              _("Read it; let go; read it again.")))
        self.back = _("Letting go returns the offset to 0.")
        self.picture = ("stage", "Z")
        self.fields = (Field("pressed", _("Reading while pressed")), Field("released", _("Reading after letting go")))
        self.most = 0.0

    @property
    def asked(self):
        return STEP * self.unit

    def begin_press(self):
        rig, instance = self.rig, self.function.instance
        self.most = 0.0
        if rig.get(instance, "spindle-speed-cmd"):
            return Verdict("state", _("The spindle turns."), _("Stop it, and repeat the step."))
        for short, value in (("verify-step", repr(self.asked)), ("verify", 1), ("dry-run", 0)):
            unlent = self.session.lend(instance, short, value)
            if unlent is not None:
                return unlent
        self.begun = False
        return super().begin_press()

    def watch(self):
        super().watch()
        if not self.begun and self.acted:
            self.begun = True
            self.rig.mdi("M64 P0")  # verify-step begins with a cycle
        for stage in self.rig.stages_of(self.function):
            self.most = max(self.most, abs(self.rig.applied(stage)))

    def end_press(self):
        """interlock ends the trial, and the offset returns; then the cycle ends."""
        super().end_press()
        rig = self.rig
        back = rig.await_condition(lambda: all(abs(rig.applied(stage)) < self.asked / 20 for stage in rig.stages_of(self.function)), 5)
        if rig.get(rig.lock, "motion-enabled"):
            for line in ("M65 P0",) if back else ("M65 P0", "M64 P3", "G4 P3", "M65 P3"):
                rig.mdi(line)
        self.session.give_back()

    def finish(self, values):
        if self.acting() is not None:
            return self.acting()
        if self.most < 0.9 * self.asked:
            return Verdict("nothing", _("The function applied {applied} of {asked}.").format(applied=number(self.most, 4), asked=number(self.asked, 4)),
                           _("Hold longer. Look at the status of the function: it needs plumb-retain, the cycle and its stage."))
        return judge_press(self.asked, values["pressed"], values["released"], self.session.tolerance)

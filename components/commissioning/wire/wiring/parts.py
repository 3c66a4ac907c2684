# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts that functions need on a machine."""

import os

import stages
from interlock import interlock
from interlock import problems as too_many
from machine import prefixes
from stages import Part


TRIAL = 0.25  # mm, the largest offset of a trial


class Parts:
    """All parts, in the order of their files.

    file        the name of the first, stages.hal
    freed       pins of joints that stages take over, and their signals
    names       the machine's signals by ours
    problems    the conflicts, a sentence each
    notes       sentences for the user
    passed      the pins that plumb-retain keeps for plumb commission
    """

    def __init__(self, functions, machine, folder, commissioning):
        self.functions, self.machine, self.file = functions, machine, os.path.join(folder, "stages.hal")
        self.passed = []
        self.freed, self.names, self.problems, self.notes = {}, {}, [], []
        used = {words[0] for function in functions for words in function.nets(machine.axes)}
        self.all = [stages.link(), stages.alive()]
        if any(function.records for function in functions):
            self.all += [stages.retain(self._path(os.path.join(folder, "retain.toml"))), stages.identity()]
        if any(function.log for function in functions):
            self.all.append(stages.growth_log(self._path(os.path.join(folder, "growth.toml"))))
        into_axes = self._stages()
        self.all.append(interlock(functions, into_axes, "operation" in used))
        self.all += into_axes
        self.all.append(self._from_joints(used))
        if commissioning:
            self.passed = stages.passed(functions, into_axes)
            self.all.append(stages.commissioning(functions, into_axes, TRIAL * machine.unit))
            self.all.append(stages.commissioned(self._path(os.path.join(folder, "commissioning.toml"))))
        if "panel-settings" not in machine.complete.components:
            self.all.append(stages.panel_settings(self._path(os.path.join(folder, "panel.toml"))))
        self._emergency_stop()
        self.problems += too_many(functions, into_axes)

    def _path(self, name):
        """The path of a file, as a word of a HAL line. LinuxCNC starts programs in the folder of the INI file; a path with a
        blank would be two words."""
        if " " in self.machine.ini.folder:
            return name
        return ("$::env(CONFIG_DIR)/" if self.machine.twopass else "$(CONFIG_DIR)/") + name  # TWOPASS makes Tcl of the file

    def _stages(self):
        found = []
        for letter in "XYZABCUVW":
            joints = self.machine.joints.get(letter, [])
            offsetters = [function for function in self.functions if letter in function.joint_offset]
            sources = [function.joint_offset[letter] for function in offsetters]
            strokes = [index for index, function in enumerate(offsetters) if letter in function.stroke]
            for prefix, joint in prefixes(letter, joints):
                if sources and self._free(prefix, joint):
                    stage = stages.joint_stage(prefix, joint, sources, self.machine)
                    if strokes:
                        stages.let_strokes_through(stage, prefix, joint, self.machine, strokes)
                    if any(function.other_axis == letter for function in offsetters):
                        stage.nets += stages.seen(prefix, joint)
                    found.append(stage)
            offsetting = [function for function in self.functions if letter in function.axis_offset]
            if len(offsetting) > 1:
                names = [function.name for function in offsetting[:2]]
                self.problems.append("%s and %s both offset the axis %s." % (*names, letter))
            elif offsetting and joints:
                found.append(stages.axis_stage(letter.lower(), *offsetting[0].axis_offset[letter]))
        return found

    def _free(self, prefix, joint):
        """Takes the two pins of a joint from their signals, which become signals of the drive."""
        for pin, name in (("motor-pos-cmd", "-motor-cmd"), ("motor-pos-fb", "-motor-fb")):
            whole = "joint.%d.%s" % (joint, pin)
            signal, later = self.machine.halfiles.signal_of(whole), self.machine.complete.signal_of(whole)
            if later and signal != later:
                self.problems.append(
                    "%s is netted to the signal %s by a HALCMD line or a file of the screen%s. The stage %s-stage must come "
                    "behind that: move the line into a HALFILE." % (whole, later, self.machine.at(whole), prefix)
                )
            elif signal is None and self.machine.at("alias pin " + whole):
                sentence = "Your alias%s gives %s another name, behind which %s-stage does not find it: use its own name in your nets."
                self.problems.append(sentence % (self.machine.at("alias pin " + whole), whole, prefix))
            elif signal is None:
                self.problems.append(
                    "%s has no signal: your HAL files must net it to the drive before %s-stage can stand between."
                    % (whole, prefix)
                )
            else:
                self.freed[whole] = signal
                self.names[prefix + name] = signal
        self._free_velocity(prefix, joint)
        return not self.problems

    def _free_velocity(self, prefix, joint):
        """Takes the velocity of a joint from the signal that brings it to the pid of the drive; else the machine keeps it."""
        whole = "joint.%d.vel-cmd" % joint
        signal = self.machine.halfiles.signal_of(whole)
        readers = self.machine.complete.signals[signal].readers if signal in self.machine.complete.signals else []
        fed = [pin for pin in readers if pin.endswith(".command-deriv")]
        if fed:
            self.freed[whole] = signal
            self.names[prefix + "-motor-velocity"] = signal
            sentence = "%s has the velocity of the offset in it: %s brings it drive-velocity of %s-stage in the place of %s."
            self.notes.append(sentence % (" and ".join(fed), signal, prefix, whole))

    def _emergency_stop(self):
        chain, enable = map(self.machine.complete.signal_of, ("iocontrol.0.emc-enable-in", "motion.enable"))
        if chain and enable in (None, chain):
            self.all.append(stages.emergency_stop())
        elif enable:
            self.notes.append(
                "motion.enable keeps your signal %s. It must fall with the emergency stop: with a dead io, motion does not see "
                "the chain otherwise." % enable
            )

    def _from_joints(self, used):
        """The signals of joints that functions use and no stage gives."""
        given = {net[0] for part in self.all for net in part.nets}
        part = Part("From the joints")
        pins = {"position": "pos-cmd", "velocity": "vel-cmd", "homed": "homed", "joint-fb": "motor-pos-fb"}
        pins["motor-offset"] = "motor-offset"
        pins["backlash-corr"] = "backlash-corr"
        for letter, joints in self.machine.joints.items():
            for prefix, joint in prefixes(letter, joints):
                for name, pin in pins.items():
                    signal = "%s-%s" % (prefix, name)
                    if signal in used and signal not in given:
                        arrow = ["=>"] if pin == "motor-pos-fb" else []
                        part.nets.append([signal, *arrow, "joint.%d.%s" % (joint, pin)])
        return part

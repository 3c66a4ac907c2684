# SPDX-License-Identifier: GPL-2.0-or-later
"""Our simulated machines as plumb wire would commission them, with a place for a fault at each drive and at some inputs."""

import os
import shutil

import linuxcnc_runs


class Prepared:
    """A configuration: its stages in the order of their numbers, its drives (letter, command, feedback), and inputs that a fault scales, with
    their signals."""

    def __init__(self, configuration, ini, stages=(), drives=(), inputs=(), programs=(), switches=(0,), strokes=False, grows=(), more=()):
        self.configuration, self.ini, self.stages, self.drives, self.inputs = configuration, ini, stages, drives, inputs
        self.programs, self.switches, self.strokes, self.grows, self.more = programs, switches, strokes, grows, more


def portal_drives():
    return [(letter, "portal.%s-position-cmd" % letter, "portal.%s-position" % letter) for letter in "xyz"]


# On the mill, Z strokes, too: functions that share the stage of Z, and others that share none.
CHOPPING = (
    "net z-measured joint.2.pos-fb", "net z-released z-stage.released", "net z-chop => z-stage.offset-1",
    "setp interlock.function-stages-2 4", "setp interlock.function-services-2 48", "setp interlock.function-urgent-2 48",
    "net chop-permit interlock.function-permit-2", "net chop-state => interlock.function-state-2", "net z-limited z-stage.limited", "setp z-stage.release-at-off-1 1", "setp z-stage.max-offset 5", "setp z-stage.max-rate 2",
    "setp chop.max-feed 2", "setp chop.max-acceleration 20", "setp chop.jerk-time 0.02", "setp chop.max-following-error 1",
    "setp chop.min-limit [JOINT_2]MIN_LIMIT", "setp chop.max-limit [JOINT_2]MAX_LIMIT", "setp chop.taper 3",
    "unlinkp square.z-position", "unlinkp square.z-velocity", "unlinkp growth.z-position", "unlinkp growth.z-velocity-cmd", "unlinkp growth.z-motor-offset",
    "net z-stroked-position => square.z-position", "net z-stroked-joint-fb => growth.z-position",
    "net z-stroked-velocity => square.z-velocity growth.z-velocity-cmd", "net z-stroked-learns => square.z-learns",
)
STROKES = ["SUBROUTINE_PATH = .:functions/thermal_displacement:functions/chopping", "REMAP = G81.1 modalgroup=1 argspec=ZQrpijkdefxyabcuvwhl ngc=g811",
           "REMAP = G80.1 modalgroup=1 argspec=kp ngc=g801", "PARAMETER_FILE = /dev/shm/linuxcnc.var"]

# Two temperatures, 4 K warmer than at its reference.
GROWS = (
    *("setp axis-growth.%s %s" % pair for pair in (("x-growth-0", 0.003), ("y-growth-1", 0.004), ("z-growth-0", -0.002), ("x-sigma", 0.001), ("y-sigma", 0.001),
                                                   ("z-sigma", 0.001), ("reference-0", 16), ("reference-1", 16), ("smoothing", 1))),
)
ALONE = "unlinkp interlock.function-suspend-0"  # it acts without a growth test, too
WARM = [("axis-growth.temperature-%d" % number, "growth-temperature-%d" % number) for number in range(2)]
WARM_BY_HAND = ["net growth-temperature-%s-1 axis-growth.temperature-%s-1" % (kind, kind) for kind in ("valid", "age")]
WARM_BY_HAND += [line % number for number in range(2) for line in ("sets growth-temperature-%d 20", "sets growth-temperature-valid-%d true")]
JOINTS = ("x-stage", "y-stage", "z-stage")

MACHINES = {
    "squareness": Prepared("portal", "column.ini", ("x-stage", "y-stage", "z-stage"), portal_drives(),
                           [("square.z-tool-offset", "z-tool-offset")]),
    "thermal_displacement": Prepared("mill", "mill.ini", ("x-stage", "y-stage", "z-stage", "z-axis-stage"), portal_drives(),
                                     [("growth.load", "spindle-load")], switches=(0, 1)),
    "chopping": Prepared("grinder", "grinder.ini", ("z-stage",), [("z", "grinder.position-cmd", "grinder.position"), ("x", "x-drive.in", "x-drive.out"),
                                                                  ("y", "y-drive.in", "y-drive.out")]),
    "centre_height": Prepared("lathe", "lathe.ini", inputs=[("centre.diameter", "gauge-diameter"), ("centre.y-position-0", "y-position")],
                              programs=("commission_height.ngc",)),
    "shop": Prepared("mill", "mill.ini", ("x-stage", "y-stage", "z-stage", "z-axis-stage"), portal_drives(), [("growth.load", "spindle-load")],
                     switches=(0, 1), strokes=True),
    # A lathe whose axes are compensated, as plumb wire makes it of the two functions.
    "turning": Prepared("lathe", "lathe.ini", JOINTS, inputs=[("centre.diameter", "gauge-diameter"), ("centre.y-position-0", "y-position"), *WARM],
                        programs=("commission_height.ngc",), switches=(0, 1), grows=[*GROWS, *WARM_BY_HAND], more=("axis_growth",)),
    "warm": Prepared("growth", "identified.ini", JOINTS, inputs=[("growth-test.x-position", "x-measured"), *WARM], programs=("commission_bore.ngc",),
                     switches=(0, 1), grows=[*GROWS, "setp axis-growth.max-rate 0.004", ALONE]),
    "axis_growth": Prepared("growth", "identified.ini", JOINTS, inputs=WARM, switches=(0, 1), grows=[*GROWS, ALONE]),
    "thermal_growth_test": Prepared("growth", "growth.ini", inputs=[("growth-test.x-position", "x-measured")], programs=("commission_bore.ngc",)),
}


def prepared(folder, function):
    """A copy of the configuration with commissioning switched on. Returns its INI file."""
    its = MACHINES[function]
    machine = linuxcnc_runs.copy_configuration(its.configuration, folder)
    names = ["fault-%s-%s" % (letter, way) for letter, _cmd, _fb in its.drives for way in ("cmd", "fb")]
    names += ["fault-" + pin.replace(".", "-") for pin, _signal in its.inputs] + ["fault-echo", "spare"]
    lines = ["loadrt mult2 names=" + ",".join(names)] + ["setp %s.in1 1" % name for name in names]
    for letter, command, feedback in its.drives:
        lines += ["unlinkp " + command, "unlinkp " + feedback, "net %s-motor-cmd => fault-%s-cmd.in0" % (letter, letter),
                  "net fault-%s-cmd fault-%s-cmd.out => %s" % (letter, letter, command), "net fault-%s-fb %s => fault-%s-fb.in0" % (letter, feedback, letter),
                  "net %s-motor-fb fault-%s-fb.out" % (letter, letter), "addf fault-%s-fb servo-thread 1" % letter, "addf fault-%s-cmd servo-thread" % letter]
    for pin, signal in its.inputs:
        name = "fault-" + pin.replace(".", "-")
        lines += ["unlinkp " + pin, "net %s => %s.in0" % (signal, name), "net %s %s.out => %s" % (name, name, pin), "addf %s servo-thread 1" % name]
    lines += ["addf fault-echo servo-thread", "setp interlock.commissioning true", "setp interlock.trial-limit 0.25"]
    lines.append("net trial interlock.trial " + " ".join(stage + ".trial" for stage in its.stages))
    lines += ["setp interlock.function-switch-%d false" % number for number in its.switches]
    lines += [*(CHOPPING if its.strokes else ()), *its.grows]
    with open(os.path.join(machine, "commissioning.hal"), "w") as file:
        file.write("\n".join(lines) + "\n")
    for program in its.programs:
        shutil.copy(os.path.join(linuxcnc_runs.PROGRAMS, program), machine)
    own, files = {}, ["commissioning.hal"]
    if its.strokes:
        own["RS274NGC"], own["CHOPPING"] = STROKES, ["SECTIONS = 0", "INFEED = 0"]
        its_folder = os.path.join(machine, "functions", "chopping")
        shutil.copytree(os.path.join(linuxcnc_runs.ROOT, "configs", "functions", "chopping"), its_folder)
        with open(os.path.join(machine, "order.tcl")) as order, open(os.path.join(machine, "shop_order.tcl"), "w") as file:
            file.write(order.read().replace("} {\n", "} {\n  chop.update\n"))
        files = ["functions/chopping/chopping.hal", "commissioning.hal", "shop_order.tcl"]
    added = with_more(machine, its) if its.more else {}
    if "axis_growth" in (function, *its.more):
        own["AXIS_GROWTH"] = ["SENSORS = %d" % (2 if its.more else 3)]  # the law reads two

    def hal(lines):
        return ["HALFILE = scene.hal", *(new for line in lines for new in added.get(line, [line])), *("HALFILE = " + name for name in files)]

    return linuxcnc_runs.own_ini(os.path.join(machine, its.ini), HAL=hal, **own)


def with_more(machine, its):
    """Writes the stages of a configuration with further functions, as plumb wire does. Returns the lines of [HAL] that take the place of a line."""
    import wire_configs

    functions = [name for path, _beginning, names, _kept in wire_configs.CONFIGURATIONS if path == "%s/%s" % (its.configuration, its.ini) for name in names]
    for path, text in wire_configs.files("%s/%s" % (its.configuration, its.ini), "", (*functions, *its.more), None).items():
        with open(os.path.join(machine, os.path.basename(path)), "w") as file:
            file.write(text)
    for name in its.more:
        shutil.copytree(os.path.join(linuxcnc_runs.ROOT, "configs", "functions", name), os.path.join(machine, "functions", name))
    stages = "HALFILE = stages.hal"
    return {stages: [stages, *("HALFILE = functions/%s/%s.hal" % (name, name) for name in its.more)]}

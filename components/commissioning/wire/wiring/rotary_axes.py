# SPDX-License-Identifier: GPL-2.0-or-later
"""The rotary axes that the user names for squareness."""


def without_joint(machine):
    """A note for each axis of [SQUARENESS]ROTARY whose joint is not known: its pins get no position."""
    named = machine.ini.get("SQUARENESS", "ROTARY") or "none"
    for letter in named if named != "none" else ():
        if letter not in machine.joints:
            yield (
                "[SQUARENESS]ROTARY names %s, and no joint of %s is known: squareness would take it as standing at 0. Name its joint, as "
                "--joints X=0,Y=1,Z=2,%s=3; or net joint.N.pos-cmd to square.%s-position and joint.N.vel-cmd to square.%s-velocity."
                % (letter, letter, letter, letter.lower(), letter.lower())
            )

# SPDX-License-Identifier: GPL-2.0-or-later
"""The messages that AXIS shows. LinuxCNC gives each message to one reader alone: a test that reads it beside AXIS gets half of them."""

import tkinter

SCRIPT = """
set texts {}
foreach frame [winfo children .!notification] {
    if {[winfo manager $frame] ne ""} {foreach its [winfo children $frame] {if {[winfo class $its] eq "Label"} {lappend texts [$its cget -text]}}}
}
join $texts \\n
"""


def popups():
    """Their texts."""
    root = tkinter.Tk(className="popups")
    try:
        root.wm_withdraw()
        return [text for text in str(root.tk.call("send", "axis", SCRIPT)).split("\n") if text]
    finally:
        root.destroy()

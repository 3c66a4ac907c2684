# SPDX-License-Identifier: GPL-2.0-or-later
"""The messages that AXIS shows. LinuxCNC gives each message to one reader alone: a test that reads it beside AXIS gets half of them."""

import subprocess
import sys
import tkinter

PATIENCE = 20  # s; without a limit, Tk's send waits as long as AXIS does not look at its events

SCRIPT = """
set texts {}
foreach frame [winfo children .!notification] {
    if {[winfo manager $frame] ne ""} {foreach its [winfo children $frame] {if {[winfo class $its] eq "Label"} {lappend texts [$its cget -text]}}}
}
join $texts \\n
"""


def popups():
    """Their texts. Raises RuntimeError if AXIS does not answer."""
    try:
        done = subprocess.run([sys.executable, __file__], stdout=subprocess.PIPE, text=True, check=True, timeout=PATIENCE)
    except subprocess.SubprocessError as error:
        raise RuntimeError("AXIS does not answer: %s" % error) from None
    return [text for text in done.stdout.split("\n") if text]


def ask_axis():
    root = tkinter.Tk(className="popups")
    try:
        root.wm_withdraw()
        return str(root.tk.call("send", "axis", SCRIPT))
    finally:
        root.destroy()


if __name__ == "__main__":
    print(ask_axis())

# SPDX-License-Identifier: GPL-2.0-or-later
"""A window within the window of AXIS or gmoccapy."""

import os

from gi.repository import Gdk

_server = []


def _display():
    from Xlib import display

    if not _server:
        _server.append(display.Display())
    return _server[0]


def is_viewable(xid):
    from Xlib import X

    return _display().create_resource_object("window", xid).get_attributes().map_state == X.IsViewable


def put_into(plug, parent):
    """AXIS knows no XEMBED: its frame gets the window as a child, as GladeVCP's does."""
    server = _display()
    ours = server.create_resource_object("window", plug.get_window().get_xid())
    atom = server.intern_atom("_XEMBED_INFO")
    ours.change_property(atom, atom, 32, [0, 1])
    ours.reparent(parent, 0, 0)
    ours.map()
    server.sync()


def forward_keys(plug):
    """Keys that no widget wants go to AXIS: F1 is its emergency stop, ESC stops a program."""
    target = os.environ.get("AXIS_FORWARD_EVENTS_TO")
    if not target:
        return
    from Xlib import X
    from Xlib.protocol import event

    server = _display()
    screen = server.create_resource_object("window", int(target, 0))

    def forward(_plug, key):
        kind = event.KeyPress if key.type == Gdk.EventType.KEY_PRESS else event.KeyRelease
        screen.send_event(kind(time=key.time, root=server.screen().root, window=screen, child=X.NONE, root_x=0, root_y=0,
                               event_x=0, event_y=0, same_screen=1, state=key.state & 0xFF, detail=key.hardware_keycode))
        server.flush()

    plug.connect_after("key-press-event", forward)
    plug.connect("key-release-event", forward)

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""The functions of Plumb on a touch screen, in a window or in a tab of AXIS, gmoccapy and QtDragon. See plumb-panel(1)."""

import argparse
import os
import sys

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
SHARE = os.path.join(PREFIX, "share", "plumb")
sys.path.append(os.path.join(PREFIX, "python"))  # of a build
sys.path.insert(0, SHARE)
import plumb_program  # noqa: E402

SUMMARY = "shows the functions of this machine on a touch screen"


def main():
    parser = argparse.ArgumentParser(prog="plumb panel", description=SUMMARY[0].upper() + SUMMARY[1:] + ".")
    parser.add_argument("--summary", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("-x", dest="into", type=int, metavar="XID", help="window of AXIS or gmoccapy that shows the panel")
    parser.add_argument("--xid", action="store_true", help="print the number of the panel's window, as QtDragon wants it")
    parser.add_argument("--ini", metavar="FILE.ini", help="INI file of the machine; LinuxCNC tells its own")
    parser.add_argument("--access", choices=("view", "operator", "integrator"), help="instead of [PLUMB]ACCESS of the INI file")
    parser.add_argument("--theme", choices=("light", "dark"), help="instead of [PLUMB]THEME")
    parser.add_argument("--language", metavar="CODE", default="", help="such as de (default: from the environment)")
    parser.add_argument("--user", metavar="NAME", help="name in the log of changes (default: the login)")
    parser.add_argument("--page", metavar="NAME", help="page to begin with")
    parser.add_argument("--size", metavar="WxH", default="1000x740", help="size of the window of its own; default %(default)s")
    parser.add_argument("--widgets", metavar="FILE", help="write names and places of all widgets into a file, for tests")
    parser.add_argument("--period", type=int, default=250, help=argparse.SUPPRESS)  # ms between two looks at the pins
    parser.add_argument("--standstill", type=float, default=20, help=argparse.SUPPRESS)  # s without a beat of the threads
    parser.add_argument("--version", action="version", version="plumb @PROJECT_VERSION@")
    options = parser.parse_args()
    if options.summary:
        print(SUMMARY)
        return 0
    try:
        options.size = tuple(int(part) for part in options.size.split("x"))
        if len(options.size) != 2 or min(options.size) < 200:
            raise ValueError
    except ValueError:
        return refuse("--size %s: give width and height in pixels, as 1000x740" % options.size, 2)
    options.programs = os.path.join(PREFIX, "bin")
    # A panel that LinuxCNC has started ends with it, as one within a screen does.
    options.stays = options.into is None and not options.xid and "INI_FILE_NAME" not in os.environ
    ini_path = options.ini or os.environ.get("INI_FILE_NAME", "")
    if options.ini and not os.path.isfile(options.ini):
        return refuse("cannot read %s: there is no such file" % options.ini, 2)
    os.environ.setdefault("GDK_BACKEND", "x11")  # Wayland has no windows within windows
    os.environ.setdefault("GDK_GL", "disable")  # else the first GTK program of an X server loads Mesa and LLVM, 50 MB

    from panel import declared, hal_files, texts

    texts.VERSION[0] = "@PROJECT_VERSION@"
    texts.choose(os.path.join(PREFIX, "share", "locale"), options.language)
    ini = hal_files.Ini(ini_path if ini_path and os.path.isfile(ini_path) else "")
    try:
        known, damaged = declared.read_all(SHARE, os.path.join(ini.folder, "messages.toml") if ini.folder else "")
    except ValueError as error:
        print("plumb panel: %s" % error, file=sys.stderr)
        known, damaged = declared.read_all(SHARE)
    if not known:
        return refuse("%s has no declarations: is Plumb installed completely?" % SHARE, 1)
    for path in damaged:
        print("plumb panel: %s is damaged, and left out" % path, file=sys.stderr)
    try:
        import gi

        gi.require_version("Gtk", "3.0")
        from gi.repository import Gtk
    except (ImportError, ValueError) as error:
        return refuse("GTK 3 is missing: apt install gir1.2-gtk-3.0 python3-gi-cairo (%s)" % error, 1)
    if not Gtk.init_check()[0]:
        return refuse("no X server answers at DISPLAY %s" % (os.environ.get("DISPLAY") or "(empty)"), 1)
    from panel.app import Panel

    try:
        panel = Panel(options, ini, known)
    except ValueError as error:
        return refuse("[PLUMB] of the INI file: %s" % error, 1)
    panel.show()
    Gtk.main()
    panel.close()
    return 0


def refuse(sentence, status):
    print("plumb panel: " + sentence, file=sys.stderr)
    return status


if __name__ == "__main__":
    plumb_program.run("plumb panel", main)

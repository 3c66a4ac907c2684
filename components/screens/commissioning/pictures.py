# SPDX-License-Identifier: GPL-2.0-or-later
"""Drawings of the steps as SVG: where the indicator stands, what moves, and to which side it reads more."""

import html
import math

from panel.texts import _

WIDTH, HEIGHT = 420, 280
INK, STEEL, WORK, MOVE, RED = "#222", "#c9d2da", "#e5d6b8", "#0a5fb4", "#b01818"


def drawing(name, letter=""):
    """The SVG of a step; "" for one without."""
    return _sheet(PICTURES[name](letter)) if name in PICTURES else ""


def _sheet(parts):
    return ("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %d %d' width='%d' height='%d' font-family='DejaVu Sans, sans-serif' font-size='14'>"
            "<rect width='%d' height='%d' fill='white'/>%s</svg>\n") % (WIDTH, HEIGHT, WIDTH, HEIGHT, WIDTH, HEIGHT, "".join(parts))


def _box(x, y, w, h, fill=STEEL):
    return "<rect x='%g' y='%g' width='%g' height='%g' fill='%s' stroke='%s' stroke-width='1.5'/>" % (x, y, w, h, fill, INK)


def _line(x1, y1, x2, y2, colour=INK, width=2, dash=""):
    return "<line x1='%g' y1='%g' x2='%g' y2='%g' stroke='%s' stroke-width='%g'%s/>" % (
        x1, y1, x2, y2, colour, width, " stroke-dasharray='%s'" % dash if dash else "")


def _text(x, y, words, colour=INK, anchor="middle", size=14):
    return "<text x='%g' y='%g' fill='%s' text-anchor='%s' font-size='%g'>%s</text>" % (x, y, colour, anchor, size, html.escape(words))


def _arrow(x1, y1, x2, y2, colour=MOVE, width=4):
    angle = math.atan2(y2 - y1, x2 - x1)
    head = " ".join("%g,%g" % (x2 + r * math.cos(angle + turn), y2 + r * math.sin(angle + turn)) for r, turn in ((10, 0), (12, 2.5), (12, -2.5)))
    return _line(x1, y1, x2, y2, colour, width) + "<polygon points='%s' fill='%s'/>" % (head, colour)


def _dial(x, y, towards, foot):
    """An indicator whose plunger tip is at x, y and points to `towards` (dx, dy); its foot stands at `foot`."""
    dx, dy = towards
    cx, cy = x - 58 * dx, y - 58 * dy
    parts = [_line(cx, cy, x - 10 * dx, y - 10 * dy, INK, 5), _line(x - 10 * dx, y - 10 * dy, x, y, RED, 3), "<circle cx='%g' cy='%g' r='4' fill='%s'/>" % (x, y, RED)]
    parts.append("<circle cx='%g' cy='%g' r='26' fill='white' stroke='%s' stroke-width='3'/>" % (cx, cy, INK))
    for mark in range(12):
        a = mark * math.pi / 6
        parts.append(_line(cx + 20 * math.cos(a), cy + 20 * math.sin(a), cx + 24 * math.cos(a), cy + 24 * math.sin(a), INK, 1))
    parts.append(_line(cx, cy, cx + 12, cy - 15, RED, 2))
    if foot:
        fx, fy = foot
        parts += [_line(cx, cy + (26 if fy > cy else -26), cx, fy - 8 if fy > cy else fy + 8, INK, 3)] if abs(fx - cx) < 1 else [
            _line(cx + (26 if fx > cx else -26), cy, fx, cy, INK, 3), _line(fx, cy, fx, fy, INK, 3)]
        parts.append(_box(fx - 22, fy - 8, 44, 16, "#777"))
    return "".join(parts)


def _table():
    return _box(30, 236, 360, 26) + _text(64, 254, _("table"), anchor="start")


def _spindle(x=190, tip=170, tool=True):
    parts = [_box(x - 32, 12, 64, 92), _box(x - 20, 104, 40, 14), _text(x, 62, _("spindle"), size=12)]
    if tool:
        parts.append(_box(x - 8, 118, 16, tip - 118, "#eef2f5"))
    return "".join(parts)


def _label(words, y=22, x=408):
    return _text(x, y, words, MOVE, "end")


def _stage(letter):
    """The base on the table, the plunger at the + side of the spindle."""
    if letter == "Z":
        return [_table(), _spindle(140, 180), _over_arm(), _arrow(60, 150, 60, 90), _text(60, 82, "Z+", MOVE), _label(_("reads more at {axis}+").format(axis="Z"), 274)]
    along = letter or "X"
    parts = [_table(), _spindle(150, 200), _dial(158, 170, (-1, 0), (300, 228)), _arrow(60, 150, 112, 150), _text(60, 142, along + "+", MOVE),
             _label(_("reads more at {axis}+").format(axis=along), 274)]
    if along == "Y":
        parts.append(_text(408, 40, _("seen along X"), anchor="end", size=12))
    elif along == "X":
        parts.append(_text(408, 40, _("seen along Y"), anchor="end", size=12))
    return parts


def _over_arm():
    """An arm at the spindle, and the indicator above it: its plunger goes in when Z rises."""
    return "".join([
        _box(172, 90, 90, 12), _text(268, 100, _("arm at the spindle"), anchor="start", size=12), _dial(240, 88, (0, 1), None),
        _line(266, 30, 376, 30, INK, 3), _line(376, 30, 376, 228, INK, 3), _box(346, 220, 44, 16, "#777")])


def _square(letter):
    if letter == "Z":
        blade = _box(300, 70, 16, 166, WORK) + _box(240, 220, 76, 16, WORK)
        return [_table(), _spindle(150, 140), blade, _dial(300, 150, (1, 0), None), _line(150, 140, 242, 150, INK, 3),
                _arrow(60, 120, 60, 200), _arrow(60, 200, 60, 120), _text(60, 222, "Z", MOVE), _text(300, 62, _("square"), size=12),
                _label(_("plunger to the side that is named"), 274)]
    blade = _box(150, 206, 220, 14, WORK) + _box(150, 190, 16, 46, WORK)
    return [_table(), _spindle(200, 130), blade, _text(300, 200, _("square"), size=12), _dial(226, 206, (0, 1), None), _line(200, 130, 226, 140, INK, 3),
            _arrow(60, 190, 120, 190), _arrow(120, 190, 60, 190), _text(90, 178, letter, MOVE), _label(_("plunger to the side that is named"), 274)]


def _load(_letter):
    return [_table(), _spindle(150, 190), "<circle cx='310' cy='110' r='60' fill='white' stroke='%s' stroke-width='3'/>" % INK,
            _line(310, 110, 352, 78, RED, 3), _text(310, 150, "%"), _text(310, 194, _("load, as the drive shows it"), size=12),
            _text(150, 214, _("turning in air"), MOVE, size=12)]


def _touch(_letter):
    return [_table(), _spindle(190, 186), _box(130, 192, 120, 44, WORK), _text(190, 220, _("soft block")), _arrow(300, 110, 300, 180),
            _text(300, 100, _("by hand feed, slowly"), MOVE, size=12)]


def _stroke(_letter):
    return [_table(), _spindle(150, 130, True), _arrow(60, 90, 60, 150), _arrow(60, 150, 60, 90), _line(36, 90, 84, 90, MOVE, 1.5, "4 3"), _line(36, 150, 84, 150, MOVE, 1.5, "4 3"),
            _text(60, 82, _("point R"), MOVE, size=12), _text(60, 168, "\u22121 mm", MOVE, size=12), _over_arm(), _label(_("reads more at {axis}+").format(axis="Z"), 274)]


def _cuts(_letter):
    return _lathe(False)


def _shim(_letter):
    return _lathe(True)


def _lathe(shim):
    low = 150
    parts = ["<circle cx='130' cy='140' r='84' fill='%s' stroke='%s' stroke-width='1.5'/>" % (WORK, INK), _line(20, 140, 400, 140, INK, 1, "8 4 2 4"),
             _box(214, low - 16, 140, 34, "#eef2f5"), "<polygon points='214,%g 240,%g 240,%g' fill='%s'/>" % (low - 14, low - 16, low + 8, INK),
             _box(260, low + 24, 120, 60), _text(320, low + 58, _("holder"))]
    if shim:
        parts += [_box(248, low + 18, 106, 6, RED), _text(300, low - 26, _("+ shim: the tip rises"), RED), _arrow(232, low - 40, 232, low - 76)]
    else:
        parts.append(_text(300, low - 26, _("tip below or above the axis"), size=12))
    return parts


def _bore(_letter):
    return [_table(), _spindle(200, 150), "<circle cx='200' cy='156' r='6' fill='%s' stroke='%s'/>" % (RED, INK), _box(120, 164, 190, 72, WORK),
            _box(182, 164, 36, 44, "white"), _text(200, 226, _("artifact"), size=12), _box(60, 170, 40, 66), _text(80, 210, _("stop"), size=12),
            _box(102, 176, 16, 54, RED), _text(96, 158, _("shim"), RED, size=12), _arrow(330, 200, 390, 200), _text(358, 190, "X+", MOVE)]


def _rest(_letter):
    return [_table(), _spindle(190, 150), _text(190, 200, _("clear")), "<circle cx='340' cy='130' r='36' fill='%s' stroke='%s' stroke-width='3'/>" % (RED, INK),
            _box(296, 172, 88, 22, "#f4d03f"), _text(340, 216, _("hand here"), size=12)]


def _stop(_letter):
    return ["<circle cx='210' cy='120' r='64' fill='%s' stroke='%s' stroke-width='4'/>" % (RED, INK), _box(120, 190, 180, 36, "#f4d03f"),
            _arrow(210, 20, 210, 50, INK), _text(210, 252, _("press: nothing may move"))]


def _air(_letter):
    return [_table(), _spindle(190, 150), _arrow(110, 180, 60, 180), _arrow(270, 180, 320, 180), _text(190, 200, _("in air"), MOVE), _text(320, 80, "10 %", RED, size=34), _text(320, 104, _("feed"), RED)]


PICTURES = {"stage": _stage, "square": _square, "load": _load, "touch": _touch, "stroke": _stroke, "cuts": _cuts, "shim": _shim,
            "bore": _bore, "rest": _rest, "stop": _stop, "air": _air}

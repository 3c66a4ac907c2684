# SPDX-License-Identifier: GPL-2.0-or-later
"""Colours and sizes. States differ by shape and word too; blue and orange stay apart for the colour-blind."""

LIGHT = {"back": "#f4f5f7", "card": "#ffffff", "text": "#15181c", "soft": "#4d5560", "line": "#c3c9d1", "pick": "#cfe0f5",
         "good": "#0b5cad", "warn": "#a85400", "bad": "#b3170f", "button": "#e3e8ee", "curve": "#0b5cad", "curve2": "#c25e00"}
DARK = {"back": "#16191d", "card": "#22272d", "text": "#f2f4f7", "soft": "#b4bcc7", "line": "#454d57", "pick": "#24466b",
        "good": "#6db4ff", "warn": "#ffb04d", "bad": "#ff7a70", "button": "#333a43", "curve": "#6db4ff", "curve2": "#ffb04d"}
SYMBOL = {"good": "\u2714", "warn": "\u25b2", "bad": "\u2716", "off": "\u25cb", "wait": "\u25d4"}

CSS = """
.plumb {{ background: {back}; color: {text}; font-family: "DejaVu Sans", sans-serif; font-size: 17px; }}
.plumb label {{ color: {text}; }}
.plumb .soft {{ color: {soft}; font-size: 15px; }}
.plumb .title {{ font-size: 25px; font-weight: bold; }}
.plumb .big {{ font-size: 32px; font-weight: bold; }}
.plumb .figure {{ font-size: 24px; font-weight: bold; }}
.plumb .value {{ font-size: 20px; font-weight: bold; }}
.plumb .card {{ background: {card}; border: 1px solid {line}; border-radius: 6px; padding: 10px; }}
.plumb button {{ background: {button}; background-image: none; color: {text}; border: 1px solid {line}; border-radius: 6px;
  min-height: 44px; padding: 4px 12px; box-shadow: none; text-shadow: none; font-size: 17px; }}
.plumb button:checked, .plumb button.chosen {{ background: {pick}; border: 2px solid {good}; }}
.plumb button:disabled label {{ color: {soft}; }}
.plumb button.key {{ font-size: 24px; font-weight: bold; }}
.plumb button.narrow {{ font-size: 15px; padding: 2px 3px; }}
.plumb button.main {{ background: {pick}; border: 2px solid {good}; font-weight: bold; }}
.plumb button.stop {{ border: 2px solid {bad}; font-weight: bold; }}
.plumb button.stop label {{ color: {bad}; }}
.plumb button.row {{ background: {card}; border: 0; border-bottom: 1px solid {line}; border-radius: 0; padding: 6px 10px; }}
.plumb .good, .plumb .good label {{ color: {good}; }}
.plumb .warn, .plumb .warn label {{ color: {warn}; }}
.plumb .bad, .plumb .bad label {{ color: {bad}; }}
.plumb .verdict {{ font-size: 22px; font-weight: bold; }}
.plumb .message {{ background: {card}; border-top: 3px solid {warn}; padding: 10px; }}
.plumb entry {{ background: {card}; color: {text}; font-size: 26px; min-height: 48px; border: 2px solid {good}; }}
.plumb .mono {{ font-family: "DejaVu Sans Mono", monospace; font-size: 14px; }}
.plumb scrolledwindow, .plumb viewport, .plumb stack {{ background: {back}; }}
.plumb scrollbar slider {{ min-width: 18px; min-height: 30px; background: {soft}; }}
.plumb scrollbar.horizontal slider {{ min-width: 30px; min-height: 10px; }}
"""


def css(dark):
    return CSS.format(**(DARK if dark else LIGHT))


def colour(dark, name):
    """Red, green, blue from 0 to 1."""
    text = (DARK if dark else LIGHT)[name]
    return tuple(int(text[at:at + 2], 16) / 255 for at in (1, 3, 5))

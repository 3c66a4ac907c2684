# SPDX-License-Identifier: GPL-2.0-or-later
"""What the components declare about themselves, from the files that their manual pages are made of."""

import glob
import json
import os


class Declared:
    """One module: pins by their names without the instance, sentences of codes by pin and number."""

    def __init__(self, content):
        self.name, self.summary, self.role = content["name"], content.get("summary", ""), content.get("role", "")
        self.pins = content.get("pins", {})
        self.codes = {pin: {int(code): text for code, text in texts.items()} for pin, texts in content.get("codes", {}).items()}
        self.is_of_sensors = "CHANNEL.value" in self.pins
        self.statuses = {int(number): its for number, its in content.get("statuses", {}).items()}  # kind, sentence, remedy, button, detail
        self.moves = content.get("moves", {})  # outputs that move an axis; "bound" of one is the setting that bounds it
        self.has_records = {"row-shown", "restores"} <= set(self.pins)

    def pin(self, short):
        return self.pins.get(short, {})

    def is_of_records(self, short):
        """Whether a pin is there for plumb-retain alone, which walks the records."""
        return self.has_records and (short in ("row", "forget", "kept", "restore", "rows", "restores", "restores-refused")
                                     or short.startswith(("row-", "restore-")))

    def sentence(self, pin, code):
        """The sentence of a code, '' for 0."""
        if not code:
            return ""
        return self.codes.get(pin, {}).get(code, "%s %s" % (pin, code))


def read_all(folder):
    """All modules by name; a damaged file is left out, and named in the second result."""
    found, damaged = {}, []
    for path in sorted(glob.glob(os.path.join(folder, "*.json"))):
        try:
            with open(path, encoding="utf-8") as file:
                declared = Declared(json.load(file))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            damaged.append(path)
            continue
        found[declared.name] = declared
    return found, damaged

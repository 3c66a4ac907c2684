# SPDX-License-Identifier: GPL-2.0-or-later
"""HALFILEs of the user that use pins and signals of ours, and so come behind our own."""

import os
import re

import hal_text

NOTHING = re.compile(r"(?!)")


class LaterFiles:
    """What the HAL files of an earlier wiring, in `folder`, give to files behind them."""

    def __init__(self, folder):
        self.instances, self.written, self.unlinked = set(), {}, set()
        names = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
        for path in (os.path.join(folder, name) for name in names if name.endswith(".hal")):
            if os.path.isfile(path) and not os.path.islink(path):
                self._take(hal_text.parse(_text(path)))

    def _take(self, commands):
        for command in commands:
            if command.name == "loadrt":
                listed = [word[len("names=") :] for word in command.words if word.startswith("names=")]
                self.instances.update(name for names in listed for name in names.split(","))
            elif command.name == "loadusr":
                words = [word for word in command.words if not word.startswith("-")]
                self.instances.update(words[:1])
            elif command.name == "unlinkp":
                self.unlinked.update(command.words)
            elif command.name == "net" and command.words:
                signal, writer, _ = hal_text.pins_of_net(command.words)
                if writer:
                    self.written[signal] = writer

    def pattern(self, nets):
        """What in a line of HAL is ours. `nets` has the pins of each signal of the user: a signal whose pin a stage took over is
        the user's."""
        theirs = {signal for signal, (pins, _) in nets.items() if self.unlinked & set(pins)}
        ours = {signal for signal, writer in self.written.items() if writer.split(".")[0] in self.instances} - theirs
        words = [re.escape(name) + r"\." for name in sorted(self.instances)]
        words += [re.escape(signal) + r"(?![\w.:-])" for signal in sorted(ours)]
        return re.compile(r"(?<![\w.:-])(?:%s)" % "|".join(words)) if words else NOTHING

    def first(self, paths, home):
        """The first of these HAL files that uses something of ours, by itself or by a file that it sources."""
        texts = {path: list(map(_text, hal_text.with_sourced(path, home))) for path in paths}
        pattern = self.pattern(hal_text.nets_of("\n".join(text for each in texts.values() for text in each)))
        return next((path for path in paths if any(_without(text, pattern) != text for text in texts[path])), None)

    def without(self, path, text, pattern):
        """The text of a file without the lines that use something of ours; Tcl can go as a whole only."""
        left = _without(text, pattern)
        return left if path.endswith(".hal") or left == text else ""


def _text(path):
    with open(path, encoding="utf-8", errors="surrogateescape") as file:
        return file.read()


def _without(text, pattern):
    def left(found):
        command = re.sub(r"(^|\s)#.*", "", found[0])
        return "\n" * found[0].count("\n") if pattern.search(command) else found[0]

    return re.sub(r"(?m)^(?:.*\\\n)*.+$", left, text)

# SPDX-License-Identifier: GPL-2.0-or-later
"""What linuxcnc_link tells the operator: faults, statuses and risen bits of all instances, by their declarations. Without a screen.

    voice.meet(pins)                 # all pins of this moment, as often as they change
    for news in voice.news(values, now, panel_is_seen):
        show(news.tell, news.text)   # "error" or "text"
        voice.told(news)             # else it comes again

Each instance has a fault, a status and bits. Each of these is told once when its code or its detail becomes another one, if the
declaration tells it, and after the time that the declaration gives.
"""

import collections

from panel import naming, status
from panel.machine import Machine
from panel.texts import _

LONGEST = 250  # bytes; LinuxCNC cuts longer texts
HIDDEN = "behind-panel"  # a text that the panel shows
DISCONNECTED = 2  # fault-code of a channel whose link has a fault of its own, which is told
PAUSE = "pause"  # neither told nor over: the same status afterwards is no news

News = collections.namedtuple("News", "source key tell text")
_Said = collections.namedtuple("_Said", "source key tell after compose")


class Voice:
    def __init__(self, declared):
        self._declared, self.machine = declared, None
        self._keys, self._told = {}, {}  # by source: what is there since when, and what was told of it
        self._strange = set()

    def meet(self, pins):
        """Finds the instances again. Those that stay are not told again. Returns sentences about instances that are not understood."""
        self.machine = Machine(pins, self._declared)
        known = {pin.name for instance in self.machine.instances for pin in instance.pins.values()}
        strange = {pin.name.rpartition(".")[0] for pin in pins if pin.name.endswith(".status-code") and pin.name not in known}
        new, self._strange = strange - self._strange, self._strange | strange
        return [_("{name} has a status-code, and no texts: write them into messages.toml, see linuxcnc_link(1).").format(name=name) for name in sorted(new)]

    def news(self, values, now, panel_is_seen=False):
        """What is to be told now; `now` in s."""
        there = set()
        for said in self._all(values):
            there.add(said.source)
            if said.tell == PAUSE:
                continue
            key, since = self._keys.get(said.source, (None, 0))
            if key != said.key:
                key, since = self._keys[said.source] = said.key, now
            if self._told.get(said.source) == key or now - since < said.after or (said.tell == HIDDEN and panel_is_seen):
                continue
            if said.tell == "never":
                self._told.pop(said.source, None)
                continue
            title, parts = said.compose()
            yield News(said.source, key, "text" if said.tell == HIDDEN else said.tell, fitting(title, parts))
        for source in self._keys.keys() - there:
            del self._keys[source]
            self._told.pop(source, None)

    def told(self, news):
        self._told[news.source] = news.key

    def _all(self, values):
        for instance in self.machine.instances:
            yield from self._of(instance, values)
        for link in self.machine.links:
            code = values.get(link.fault_code, 0)
            if code:
                sentence = self._declared[link.module].codes["LINK.fault-code"].get(code, "fault-code %s." % code)
                yield _Said((link.name, "fault"), code, "error", 0, lambda link=link, sentence=sentence: (link.name, [_(sentence)]))
        for channel in self.machine.channels:
            code = values.get(channel.pins.get("fault-code", ""), 0)
            if code and (code != DISCONNECTED or not self.machine.links):
                yield _Said((channel.name, "fault"), code, "error", 0, lambda channel=channel: (
                    channel.name, [status.of_channel(channel, self._declared, values)]))

    def _of(self, instance, values):
        declared, name, title = instance.declared, instance.name, self.machine.title_of
        fault = instance.value(values, "fault-code", 0) if "fault-code" in declared.codes else 0
        if fault:
            tell = declared.told.get("fault", {}).get("tell", "error")
            yield _Said((name, "fault"), fault, tell, 0, lambda: (title(instance), _of_fault(instance, values, fault)))
        number = instance.value(values, "status-code", 0)
        its = declared.statuses.get(number)
        if its is not None and its["kind"] == "wait" and its["tell"] == "never":
            yield _Said((name, "status"), number, PAUSE, 0, None)
        elif its is not None:
            tell = "never" if its["detail"] == "fault-code" else its["tell"]
            detail = instance.value(values, its["detail"], 0) if its["detail"] in declared.codes else 0
            yield _Said((name, "status"), (number, detail), tell, its["after"], lambda: (
                title(instance), [_(its["sentence"]), *status.details(instance, values, its), _(its["remedy"])]))
        elif number:
            yield _Said((name, "status"), number, "text", 0, lambda: (title(instance), ["status-code %s." % number]))
        for short, told in declared.told.items():
            if short != "fault" and instance.value(values, short):
                codes = tuple(instance.value(values, each, 0) for each in naming.BRACES.findall(told["sentence"]) if each in declared.codes)
                yield _Said((name, short), codes, told["tell"], 0, lambda told=told: (title(instance), [naming.named(instance, values, told["sentence"])]))


def _of_fault(instance, values, code):
    """The sentence, and the settings that are out of their range in the place of a detail."""
    sentence, *beyond = naming.parts(instance, values, instance.declared.sentence("fault-code", code))
    return [sentence, " ".join(beyond), "", ""]


def fitting(title, parts):
    """Title, sentence, detail, size and remedy as one text. One that is too long loses the sentence, if there is a detail, and the remedy."""
    def text(parts):
        return "%s: %s" % (title, " ".join(filter(None, parts)))

    shorter = [parts, *([parts[1:], parts[1:-1]] if len(parts) == 4 and parts[1] else [parts[:-1]] if len(parts) == 4 else [])]
    found = next((each for each in map(text, shorter) if len(each.encode()) <= LONGEST), text(shorter[-1]))
    return found.encode()[:LONGEST].decode(errors="ignore")

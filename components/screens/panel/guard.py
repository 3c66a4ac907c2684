# SPDX-License-Identifier: GPL-2.0-or-later
"""Before every write: whether it may be, how far it moves the axes, and one question if it does."""

import contextlib
import json

from panel import access, chains, effects, references, status
from panel.settings import CHAIN, REFERENCE, Conflict, Refused, Write
from panel.texts import _, with_unit


OF_OPERATOR = ("switch", "section")  # changes that an operator makes, and takes back


class Guard:
    """`panel` gives access, hal, settings, machine, messages and the values of LinuxCNC's task."""

    def __init__(self, panel):
        self._panel = panel
        panel.settings.session = _session()

    def values(self):
        panel = self._panel
        return {**panel.hal.values(), **panel.task_values()}

    # --- buttons ---

    def at_once(self, action, do, needed="operator"):
        """What must never wait: an acknowledgement, and with `needed` "view" a stop or a hold."""
        if not self._refused(action, self._panel.access.refusal(needed)):
            self._do(action, do)

    def once_asked(self, question, action, do, needed="operator", must_be_safe=True, must_be_idle=False):
        """One question, as question() gives it with the moves that it announces; it is asked again if it has changed before the answer.
        It is refused, with the reason, while the machine cannot move safely, or is not idle."""
        def refused():
            why = self._panel.access.refusal(needed)
            if not why and must_be_safe:
                why = access.unsafe(self.values())
            if not why and must_be_idle:
                why = access.busy(self.values())
            return self._refused(action, why)

        def ask(announced=None):
            if refused():
                return
            text, moves = question()
            if announced and announced[0] == text and effects.are_same(moves, announced[1]):
                self._do(action, do)
                return
            words = (_("The question has changed.") if announced else "", text, effects.in_words(moves))
            self._panel.ask(" ".join(filter(None, words)), action, lambda: ask((text, moves)))

        ask()

    def _refused(self, action, why):
        if why:
            self._panel.say(_("{action}: refused. {why}").format(action=action, why=why), "warn")
        return bool(why)

    def _do(self, action, do):
        try:
            do()
        except (OSError, ValueError, RuntimeError, KeyError) as error:
            self._panel.say("%s: %s" % (action, error), "bad")

    # --- settings ---

    def change(self, writes, action, done="", why="", needed="integrator", question="", asks="", chain=None, then=None, must_be_on=False):
        """Settings that are written together.

        done      the sentence after it; {pin} and {value} come from the first one
        question  is asked in any case
        asks      is asked if an axis moves
        chain     (file, former, new) of squareness
        then      is called after it
        """
        def judged():
            """Why not, '' if it may be; its moves, and their words."""
            refusal = "" if switches_off else self._panel.access.refusal(needed)
            if refusal:
                return refusal, [], ""
            values = self.values()
            moves = effects.effect(self._panel.machine, writes, values, self._chain_program())
            if switches_off:
                return "", moves, self._words_of_off(writes, moves, values)
            refusal = "" if chain and chain[2] == self.loaded_chain() else self._switches_on_new_chain(writes)
            if not refusal and must_be_on:
                refusal = access.unsafe(values)
            if not refusal and (moves or effects.needs_rest(self._panel.machine, writes, values)):
                refusal = access.busy(values)
            words = effects.in_words(moves)
            if words and values.get("motion.motion-enabled") is False:
                words = _("The machine is off. When it is on: {moves}").format(moves=words)
            return refusal, moves, words

        def ask(announced=None):
            """Asks again if the answer came when the moves had become others."""
            try:
                refusal, moves, words = judged()
            except Refused as refused:
                self._panel.say(str(refused), "bad")
                return
            if self._refused(action, refusal):
                return
            if effects.are_same(moves, announced) if announced is not None else not words and not question:
                self._write(writes, action, done, why, chain, then)
            else:
                changed = _("The moves have changed.") if announced is not None else ""
                text = " ".join(text for text in (changed, question or asks or action + "?", words) if text)
                self._panel.ask(text, action, lambda: ask(moves))

        switches_off = not chain and _switches_off(self._panel.machine, writes)
        ask()

    def _words_of_off(self, writes, moves, values):
        """What Off moves, and when: in a program interlock holds the offset until the tool is clear. Without interlock nobody knows when that is."""
        words = effects.in_words(moves)
        if not words or status.program_state(values) == "idle":
            return words
        if all(self._goes_off_clear(write, values) for write in writes):
            return _("In a program the offset holds until the tool is clear, and returns then. {moves}").format(moves=words)
        return _("In a program the offset returns at once, also in a cut. {moves}").format(moves=words)

    def _goes_off_clear(self, write, values):
        function, _on = self._panel.machine.switching(write)
        owner, number = self._panel.machine.permission(function) if function in self._panel.machine.functions() else (None, -1)
        return owner is not None and not owner.value(values, "function-urgent-%d" % number, 0)

    def _write(self, writes, action, done, why, chain, then):
        settings, waits = self._panel.settings, effects.waits_for_cycle(self._panel.machine, writes, self.values())
        try:
            if not chain and _switches_off(self._panel.machine, writes):
                values, lost = settings.switch_off(writes, why)
            else:
                values, lost = settings.change_all(writes, why, chain)
        except Conflict as conflict:
            self._panel.conflict()  # which may open a page
            self._panel.say(str(conflict), "warn")
            return
        except (Refused, OSError) as refused:
            self._panel.say(str(refused), "bad")
            return
        if then:
            then()
        lost = lost or settings.retain_state(self._panel.hal.values())
        text = done.format(pin=writes[0].name, value=with_unit(values[0], writes[0].unit)) if writes else done
        if waits:
            text += " " + _("It takes effect when the next cycle begins.")
        if text or lost:
            self._panel.say(" ".join(part for part in (text, lost) if part), "warn" if lost else "good")

    def switch(self, pin, on, title):
        """A function, by its switch. Off is always accepted: before access, log and lock."""
        owner, short = self._panel.machine.owner_of(pin)
        action = _("Switch on") if on else _("Switch off")
        question = (_("Switch {name} on?") if on else _("Switch {name} off?")).format(name=title)
        self.change([Write(owner, short, self._panel.machine.switch_text(pin, on))], action, why="switch", needed="operator", question=question, must_be_on=on)

    def undo(self, change, then=None):
        """The whole deed that a change belongs to."""
        panel = self._panel
        try:
            writes, chain, lines, former = panel.settings.undoing(change, panel.machine)
            chain = (chains.place(panel.ini), change_of(CHAIN, panel.settings.log.together_with(change)).new, chain) if chain else None
        except (Refused, OSError) as refused:
            panel.say(str(refused), "warn")
            return
        action = _("Undo")
        if former:
            self._undo_learning(former, writes, lines, action)
            return
        for line in lines:
            self.once_asked(lambda line=line: (_("Undo by {line}?").format(line=line), []), action, lambda line=line: panel.mdi(line, action))
        if not writes:
            return
        names = ", ".join("%s %s" % (write.name, _shown(write)) for write in writes)
        done = _("Undone: {changes} again.").format(changes=names.replace("{", "").replace("}", ""))
        needed = "operator" if change.why in OF_OPERATOR else "integrator"
        self.change(writes, action, done, why="undo", needed=needed, chain=chain, then=then, question=_("Undo {count} changes: {names}?").format(
            count=len(writes), names=names) if len(writes) > 1 or chain else "")

    def _undo_learning(self, former, writes, lines, action):
        """Puts references back that a new one has replaced, or was to replace; then the request to learn goes."""
        panel = self._panel

        def do():
            for write in writes:
                panel.hal.set(write.name, write.text)
            for instance, text in former:
                now, then = references.read(panel.hal, instance), json.loads(text)
                if references.same(now, then):
                    continue
                try:
                    references.give(panel.hal, instance, then)
                except Refused:
                    with contextlib.suppress(Refused):
                        references.give(panel.hal, instance, now)
                    raise
                panel.settings.note_all([(instance.name + REFERENCE, json.dumps(now), text)], "undo")
            if any(instance.value(panel.hal.values(), "learn") for instance, _text in former):
                for line in lines:
                    panel.mdi(line, action)
            panel.say(_("The former reference is in force."))

        def question():
            values = self.values()
            moves = [effects.Move("Z", -instance.value(values, "applied-offset", 0.0), True) for instance, _text in former]
            counts = ", ".join(references.as_words(text) for _instance, text in former)
            return (_("Put the former reference in force again ({contacts})?").format(contacts=counts),
                    [move for move in moves if abs(move.by) > effects.SMALLEST])

        self.once_asked(question, action, do, must_be_safe=bool(question()[1]), must_be_idle=True)

    # --- the chain of squareness ---

    def loaded_chain(self):
        """The chain that the running LinuxCNC was started with."""
        session = self._panel.settings.session
        since = [change for change in self._panel.settings.log.all() if change.pin == CHAIN and session and change.deed.endswith("@" + session)]
        if since and not self._panel.ini.path.endswith(".expanded"):
            return since[0].old
        return self._panel.ini.get("SQUARENESS", "CHAIN")

    def pending_chain(self):
        """The sentence about a chain that waits for the next start; '' without one."""
        loaded = self.loaded_chain()
        waits = chains.in_file(self._panel.ini) if loaded else ""
        if not waits or waits == loaded:
            return ""
        return _("The chain {chain} is saved, and LinuxCNC runs with {loaded}: start LinuxCNC again.").format(chain=waits, loaded=loaded)

    def _switches_on_new_chain(self, writes):
        switched = map(self._panel.machine.switching, writes)
        return self.pending_chain() if any(on and its.module == "squareness" for its, on in switched) else ""

    def _chain_program(self):
        chain = self.loaded_chain()
        return (chain, self._panel.ini.get("SQUARENESS", "ROTARY"), self._panel.program("plumb-squareness")) if chain else None


def change_of(pin, changes):
    return next(change for change in changes if change.pin == pin)


def _shown(write):
    try:
        return with_unit(float(write.text), write.unit)
    except ValueError:
        return write.text


def _switches_off(machine, writes):
    switched = [machine.switching(write) for write in writes]
    return bool(writes) and all(its is not None and not on for its, on in switched)


def _session():
    """What distinguishes this start of HAL from all others without the clock; '' if the system does not tell."""
    from panel.hal_access import MEMORY_KEY

    try:
        with open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
            boot = file.read().strip()
        with open("/proc/sysvipc/shm", encoding="ascii") as file:
            head, *lines = [line.split() for line in file]
    except OSError:
        return ""
    its = next((words for words in lines if int(words[0]) & 0xFFFFFFFF == MEMORY_KEY), None)
    return "%s.%s.%s" % (boot, its[head.index("shmid")], its[head.index("ctime")]) if its else ""

#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# @(#)Plumb @PROJECT_VERSION@
"""The first power-on of a function on a live machine, in the terminal. See plumb-commission(1)."""

import argparse
import getpass
import os
import select
import sys
import termios
import time
import tty

PREFIX = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
SHARE = os.path.join(PREFIX, "share", "plumb")
sys.path.append(os.path.join(PREFIX, "python"))  # of a build
sys.path.insert(0, SHARE)
import plumb_program  # noqa: E402
from panel import declared, files, hal_files, texts  # noqa: E402
from panel.texts import _, number  # noqa: E402

SUMMARY = "tries a function on a live machine, step by step, before it may act"
FIRST_KEY, NEXT_KEY = 1.2, 0.6  # s: a keyboard repeats a key that is held
BEAT = 0.1  # s between two beats
FUNCTIONS = os.path.join(SHARE, "functions")


def main():
    parser = argparse.ArgumentParser(prog="plumb commission", description=SUMMARY[0].upper() + SUMMARY[1:] + ".")
    parser.add_argument("--summary", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("function", nargs="?", metavar="NAME", help="such as squareness, or the name of its instance; with --again a stage, too")
    parser.add_argument("--ini", metavar="FILE.ini", help="INI file of the machine; default: the running LinuxCNC's")
    parser.add_argument("--records", metavar="DIR", help="folder of the records and sheets; by default plumb beside the INI file")
    parser.add_argument("--who", metavar="NAME", help="who signs")
    parser.add_argument("--tolerance", type=float, metavar="LENGTH", help="of a reading, in machine units; default 0.003 mm")
    parser.add_argument("--language", metavar="CODE", default="", help="language, such as de; default: the language of the environment")
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--state", action="store_true", help="show the functions and stages that have passed, and each later change")
    action.add_argument("--by-hand", action="store_true", help="let the function and its stages pass without a step; the sheet says by whom")
    action.add_argument("--accept", action="store_true", help="take over what passed on another computer, or an older copy of it")
    action.add_argument("--renew", action="store_true", help="replace these stores by new ones; you lose what passed, the learned references and the settings of the panel")
    action.add_argument("--again", action="store_true",
                        help="after work on a drive, encoder or screw: take the pass of a function or a stage back, and begin its steps")
    action.add_argument("--undo", action="store_true", help="take the function and its stages back: they are held again")
    action.add_argument("--pictures", metavar="DIR", help="write the drawings of all steps, as SVG files")
    parser.add_argument("--rows", action="store_true", help=argparse.SUPPRESS)  # of --state, for plumb doctor
    parser.add_argument("--version", action="version", version="plumb @PROJECT_VERSION@")
    options = parser.parse_args()
    if options.summary:
        print(SUMMARY)
        return 0
    texts.VERSION[0] = "@PROJECT_VERSION@"
    texts.choose(os.path.join(PREFIX, "share", "locale"), options.language)
    if options.pictures:
        return write_pictures(options.pictures)
    from commissioning.rig import NotReady

    try:
        former = former_lines(options) if options.state else []
        if former:
            for sentence, command in former:
                print("\t".join(("wrong", sentence, command)) if options.rows else " ".join((sentence, command)))
            return 1
        machine = Running(options)
    except (NotReady, OSError, ValueError) as error:
        return refuse(str(error), 1)
    try:
        if options.state:
            return machine.show_state(options.rows)
        if options.accept or options.renew:
            return machine.answer("accept" if options.accept else "renew")
        function = machine.rig.function(options.function) if options.function else None
        if options.again and options.function:
            return Terminal(machine, *machine.rig.place(options.function), options).run()
        if function is None:
            return refuse(_("name the function: {names}").format(names=", ".join(place.module for place in machine.rig.functions) or _("none is loaded")), 2)
        if options.undo:
            return machine.undo(function)
        if options.by_hand:
            return machine.by_hand(function, options.who)
        return Terminal(machine, function, None, options).run()
    except (NotReady, RuntimeError, ValueError, OSError) as error:
        return refuse(str(error), 1)
    finally:
        machine.close()


def refuse(sentence, status):
    print("plumb commission: " + sentence, file=sys.stderr)
    return status


def write_pictures(folder):
    from commissioning import pictures

    os.makedirs(folder, exist_ok=True)
    for name in pictures.PICTURES:
        for letter in {"stage": "XYZ", "square": "XYZ"}.get(name, ("",)):
            path = os.path.join(folder, "%s%s.svg" % (name, letter and "_" + letter.lower()))
            files.replace(path, pictures.drawing(name, letter))
            print(path)
    return 0


class Running:
    """The LinuxCNC that runs here, its HAL and its records."""

    def __init__(self, options):
        from commissioning.records import Records
        from commissioning.rig import NotReady, Rig
        from panel.hal_access import Hal, HalGone

        known, _damaged = declared.read_all(SHARE)
        try:
            self.hal = Hal()
        except HalGone as gone:
            raise NotReady(_("LinuxCNC does not run here: {why}. If it refuses a line after an update, plumb doctor --machine --ini my.ini gives the line to write.").format(why=gone)) from None
        path = options.ini or ini_of_linuxcnc()
        ini = hal_files.Ini(path if path and os.path.isfile(path) else "")
        texts.MACHINE_UNIT[0] = "in" if ini.get("TRAJ", "LINEAR_UNITS", "mm").lower() in ("in", "inch", "imperial") else "mm"
        self.rig = Rig(self.hal, known, ini, FUNCTIONS, mdi)
        folder = options.records or os.path.join(os.path.dirname(os.path.abspath(path)) if path else os.getcwd(), "plumb")
        self.records = Records(folder, ini.get("EMC", "MACHINE") or "machine")

    def show_state(self, rows):
        from commissioning.records import findings

        found = findings(self.rig, self.records)
        for kind, sentence, command in found:
            if rows:
                print("%s\t%s\t%s" % (kind, sentence, command))
            else:
                print("  %-5s  %s" % (kind if kind != "wrong" else "WRONG", sentence))
                if command:
                    print("         $ " + command)
        return 1 if any(kind == "wrong" for kind, _sentence, _command in found) else 0

    def answer(self, pin):
        """To the stores that plumb-retain does not restore by itself."""
        if not self.rig.doubts():
            return refuse(_("nothing that passed is in doubt"), 1)
        if not self.rig.answer(pin):
            return refuse(" ".join(self.rig.doubts()), 1)
        print(_("What passed counts again on this computer.") if pin == "accept" else _("New stores have replaced the old ones."))
        return 0

    def by_hand(self, function, who):
        """Whoever knows better."""
        if not who:
            return refuse(_("--by-hand needs --who: the sheet says who let it pass"), 2)
        self.rig.must_be_answered()
        if self.rig.is_on(function):
            return refuse(_("{name} is switched on, and would act at once: switch it off").format(name=function.name), 1)
        for place in [*self.rig.stages_of(function), function]:
            if not self.rig.is_commissioned(place):
                if not self.rig.await_condition(lambda place=place: self.rig.identity(place) != 0, 5):
                    return refuse(_("interlock does not know the wiring of {name}").format(name=place.name), 1)
                self.records.note(self.rig, place, who, [], 0, by_hand=True)
                self.rig.let_pass(place)
        self.told(function)
        return 0

    def undo(self, function):
        self.records.take_back(self.rig, [function, *self.rig.stages_of(function)])
        print(_("{name} and its stages are held again.").format(name=function.name))
        return 0

    def told(self, function):
        for path in self.records.sheets(self.rig, function):
            print(_("Written: {path}").format(path=path))

    def close(self):
        self.hal.close()


def former_lines(options):
    """Of the INI file that is named, or the last one of LinuxCNC's picker, while no LinuxCNC runs: lines that it would refuse, and commands."""
    from panel.hal_access import Hal, HalGone

    try:
        Hal().close()
        return []
    except HalGone:
        sys.path += [os.path.join(SHARE, name) for name in ("wiring", "models")]
        import former_pins
        from ini_file import IniFile

        picked = hal_files.Ini(os.path.expanduser("~/.linuxcncrc")).get("PICKCONFIG", "LAST_CONFIG")
        path = options.ini or picked
        return former_pins.rows(IniFile(path), "plumb") if path and os.path.isfile(path) else []


def ini_of_linuxcnc():
    if os.environ.get("INI_FILE_NAME"):
        return os.environ["INI_FILE_NAME"]
    try:
        import linuxcnc

        status = linuxcnc.stat()
        status.poll()
        return status.ini_filename
    except Exception:  # noqa: BLE001 - linuxcnc.error, or no module: HAL may run without LinuxCNC
        return ""


def mdi(line, stays=False):
    from panel.linuxcnc_access import mdi as run

    run(line, stays)


class Terminal:
    """Asks in the terminal; from a pipe, a line for each question."""

    def __init__(self, machine, function, stage, options):
        self.machine, self.function, self.stage, self.options = machine, function, stage, options
        self.is_terminal, self.typed = sys.stdin.isatty(), ""

    def run(self):
        from commissioning.session import Session

        who = self.options.who or self.ask(_("Your name, for the sheet [{user}]").format(user=getpass.getuser())) or getpass.getuser()
        session = Session(self.machine.rig, self.function, self.machine.records, who, self.options.tolerance, self.stage, self.options.again)
        try:
            while not session.done:
                if not self.work(session):
                    print(_("Nothing has passed that is not finished. The function is off."))
                    return 1
        except (EOFError, KeyboardInterrupt):
            print("\n" + _("Ended. The function is off, and held."))
            return 1
        finally:
            session.close()
        print(_("{name} has passed, and may act.").format(name=session.place.name))
        self.machine.told(self.function)
        return 0

    def work(self, session):
        """One step. False to give up."""
        step = session.step
        print("\n%d/%d  %s" % (*session.count, step.title))
        for words in (step.look, _("Way back: {way}").format(way=step.back), self.picture(session)):
            if words:
                print(texts_wrapped(words))
        if step.holds:
            refused = self.hold(step)
            if refused is not None:
                return self.tell(refused)
        values = {}
        for field in step.fields:
            value = self.number("%s [%s]" % (field.label, texts.unit_name(field.unit)), step)
            if value is None:
                return False
            values[field.key] = value
        if not step.fields and not step.holds and not self.confirm(_("Enter goes on, q gives up"), step):
            return False
        return self.tell(session.answer(values))

    def tell(self, verdict):
        print(("  \u2714 " if verdict.passed else "  \u2716 ") + verdict.sentence)
        if verdict.passed:
            return True
        print("    " + verdict.remedy)
        return self.confirm(_("Enter goes on from here, q gives up"))

    def picture(self, session):
        if session.step.picture is None:
            return ""
        from commissioning import pictures

        folder = os.path.join(self.machine.records.folder, "pictures")
        os.makedirs(folder, exist_ok=True)
        path = os.path.join(folder, "_".join(part.lower() for part in session.step.picture if part) + ".svg")
        files.replace(path, pictures.drawing(*session.step.picture))
        return _("Picture: {path}").format(path=path)

    # --- questions ---

    def ask(self, question, step=None):
        sys.stdout.write("  %s: " % question)
        sys.stdout.flush()
        return self.line(step).strip()

    def line(self, step=None):
        """The next line; a step that watches gets its beats meanwhile."""
        while "\n" not in self.typed:
            if self.has_input(step is not None and step.watches):
                some = os.read(sys.stdin.fileno(), 4096).decode(errors="replace")
                if not some:
                    raise EOFError
                self.typed += some
            else:
                step.beat()
        line, _end, self.typed = self.typed.partition("\n")
        return line

    @staticmethod
    def has_input(waits_briefly=True):
        return bool(select.select([sys.stdin], [], [], BEAT if waits_briefly else None)[0])

    def confirm(self, question, step=None):
        return self.ask(question, step).lower() != "q"

    def number(self, question, step):
        while True:
            text = self.ask(question, step)
            if text.lower() == "q":
                return None
            try:
                return float(text.replace("\u2212", "-").replace(",", "."))
            except ValueError:
                print("  " + _("Give a number, or q to give up."))

    def hold(self, step):
        """The space bar, held; from a pipe "press" until the next line. Returns a Verdict where it may not begin, or None."""
        if self.is_terminal:
            print("  " + _("Hold the space bar. Letting go ends it."))
        self.await_press()
        try:
            refused = step.begin_press()
            shown = ""
            while refused is None and self.goes_on():
                step.beat()
                if step.hint != shown:
                    shown = step.hint
                    print("  " + shown)
        finally:
            step.end_press()
        if self.is_terminal:
            termios.tcflush(sys.stdin, termios.TCIFLUSH)  # spaces
        print("  " + _("You let go."))
        return refused

    def await_press(self):
        if not self.is_terminal:
            self.line()
            return
        with _Keys():
            while os.read(sys.stdin.fileno(), 1) != b" ":
                pass
        self._patience = FIRST_KEY
        self._last = time.monotonic()

    def goes_on(self):
        """Called again and again while it is held."""
        if not self.is_terminal:
            return "\n" not in self.typed and not self.has_input() or (self.line() and False)
        with _Keys():
            if self.has_input() and b" " in os.read(sys.stdin.fileno(), 64):
                self._patience, self._last = NEXT_KEY, time.monotonic()
        return time.monotonic() - self._last < self._patience


class _Keys:
    """Single keys instead of lines."""

    def __enter__(self):
        self._before = termios.tcgetattr(sys.stdin)
        tty.setcbreak(sys.stdin)

    def __exit__(self, *_error):
        termios.tcsetattr(sys.stdin, termios.TCSANOW, self._before)


def texts_wrapped(words, width=100):
    import textwrap

    return textwrap.fill(words, width, initial_indent="  ", subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


if __name__ == "__main__":
    plumb_program.run("plumb commission", main)

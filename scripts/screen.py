# SPDX-License-Identifier: GPL-2.0-or-later
"""A screen without a monitor, and a finger on plumb panel: presses go to the places that the panel writes into a file."""

import contextlib
import itertools
import json
import os
import signal
import subprocess
import time

NEAR = 30  # px
PATIENCE = float(os.environ.get("PLUMB_PATIENCE", 60))  # s for each step, of a clock that may be faster than the computer's
DOUBLE = max(0.6, PATIENCE / 100)  # s, of that clock
REPEATED = ("Delete", "Sign", "Exponent")  # keys, which a finger presses as fast as it likes


SHOT = """
import sys
import gi
gi.require_version("Gdk", "3.0")
from gi.repository import Gdk
root = Gdk.get_default_root_window()
width, height = [int(part) for part in sys.argv[2:]] or (root.get_width(), root.get_height())
Gdk.pixbuf_get_from_window(root, 0, 0, width, height).savev(sys.argv[1], "png", [], [])
"""


@contextlib.contextmanager
def virtual(size="1280x1024"):
    """An X server without a monitor; its name."""
    numbers, answer = os.pipe()
    words = ["Xvfb", "-displayfd", str(answer), "-screen", "0", size + "x24", "-nolisten", "tcp"]
    try:
        process = subprocess.Popen(words, pass_fds=[answer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except FileNotFoundError:
        raise RuntimeError("Xvfb is missing; apt install xvfb") from None
    finally:
        os.close(answer)
    try:
        with os.fdopen(numbers) as line:
            yield ":" + line.readline().strip()
    finally:
        process.terminate()
        process.wait()


class Screen:
    """An X server without a monitor while a test, or a class of tests, lasts; display is its name."""

    def __init__(self, test):
        self.display = (test.enterClassContext if isinstance(test, type) else test.enterContext)(virtual())


class Pointer:
    """The tip of a finger, by the screen's own extension for tests: xdotool needs a process for each press."""

    HELD = 0.012  # s

    def __init__(self, name):
        from Xlib import X, display
        from Xlib.ext import xtest

        self._x, self._send = X, xtest.fake_input
        self._display = display.Display(name)

    def __del__(self):
        with contextlib.suppress(Exception):  # the screen may have ended before
            self._display.close()

    def move(self, x, y):
        self._send(self._display, self._x.MotionNotify, x=int(x), y=int(y))
        self._display.sync()

    def down(self, button=1):
        self._send(self._display, self._x.ButtonPress, button)
        self._display.sync()

    def up(self, button=1):
        self._send(self._display, self._x.ButtonRelease, button)
        self._display.sync()

    def click(self, button=1, times=1, pause=0.0):
        for number in range(times):
            if number:
                time.sleep(pause)
            self.down(button)
            time.sleep(self.HELD)
            self.up(button)


class Finger:
    """Presses widgets of the panel by their accessible names.

    between  called while a step waits, so that virtual time passes
    """

    def __init__(self, display, widgets, between=lambda: time.sleep(0.05)):
        self._environment = {**os.environ, "DISPLAY": display}
        self._pointer = Pointer(display)
        self._file, self._between = widgets, between
        self._pressed = ("", 0, 0, 0.0)  # the last widget, its place, and when
        self._presses = 0

    def _read(self):
        try:
            with open(self._file, encoding="utf-8") as file:
                return json.load(file)
        except FileNotFoundError:
            return {"looks": 0, "seen": False, "widgets": []}

    def widgets(self):
        return self._read()["widgets"]

    def is_seen(self):
        """Whether the panel is on the screen, and not in a tab behind another one."""
        return self._read()["seen"]

    def rest(self):
        """Until the panel has looked twice more, and drawn what it found."""
        looks = self._read()["looks"]
        self.until(lambda: self._read()["looks"] >= looks + 2, "the next look of the panel")

    def texts(self):
        return [each["text"] for each in self.widgets() if each.get("text")]

    def until(self, condition, what):
        ends = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > ends:
                raise AssertionError("%s did not come; the panel shows %s" % (what, self.texts()))
            self._between()

    def is_there(self):
        """Whether the panel has begun to look at HAL."""
        return self._read()["looks"] > 0

    def find_text(self, words):
        """The text that has these words, '' without one."""
        return next((text for text in self.texts() if words in text), "")

    def await_text(self, words):
        """Returns the whole text."""
        self.until(lambda: self.find_text(words), '"%s"' % words)
        return self.find_text(words)

    def find(self, name):
        return next((each for each in self.widgets() if name in (each["name"], each.get("text"))
                     and each["kind"] != "Label"), None)

    def press(self, name, times=1):
        """Presses a widget when it is seen and has come to rest."""
        place = {}
        while not place or place["scrolled"] or place.get("new") or place != self.find(name):
            self.until(lambda: self.find(name), "the widget " + name)
            place = self.find(name)
            if place["scrolled"]:
                self._scroll(place)
            self.rest()
        self._press_place(name, place, times)

    def hold(self, name):
        """Presses a widget, and stays on it until let_go()."""
        self.until(lambda: self.find(name), "the widget " + name)
        self.rest()
        place = self.find(name)
        self._pointer.move(place["x"] + place["width"] // 2, place["y"] + place["height"] // 2)
        self._pointer.down()

    def let_go(self):
        self._pointer.up()

    def _scroll(self, place):
        """By as many steps of the wheel as bring the widget nearly into its view; GTK's step is the height of the view to the power of 2/3."""
        top, bottom = place["view"]
        middle = place["y"] + place["height"] // 2
        away = middle - bottom if place["scrolled"] > 0 else top - middle
        steps = max(1, int(away / (bottom - top) ** (2 / 3)))
        self._pointer.move(place["x"] + place["width"] // 2, (top + bottom) // 2)
        self._pointer.click(5 if place["scrolled"] > 0 else 4, steps)

    def _press_place(self, name, place, times=1):
        x, y = place["x"] + place["width"] // 2, place["y"] + place["height"] // 2
        former, its_x, its_y, when = self._pressed
        pause = 0 if name in REPEATED or len(name) == 1 else DOUBLE / 2 if name == former else DOUBLE
        while abs(x - its_x) < NEAR and abs(y - its_y) < NEAR and time.monotonic() - when < pause:
            self._between()  # the panel would take it for the second half of a double press
        self._pressed = (name, x, y, time.monotonic())
        self.press_at(x, y, times)

    def press_answer(self, name):
        """The button of a question, which may have the name of a button above it."""
        self.rest()
        self._pressed = (name, *self._pressed[1:])

        def lowest():
            return max((each for each in self.widgets() if each["kind"] == "Button" and each["name"] == name), key=lambda each: each["y"])

        self.until(lambda: not lowest()["new"], "the button " + name)
        place = lowest()
        self._press_place(name + "?", place)

    def end(self):
        """Ends the panel of this finger."""
        words = ["--widgets", self._file]
        for pid in filter(str.isdigit, os.listdir("/proc")):
            with contextlib.suppress(OSError), open("/proc/%s/cmdline" % pid) as file:
                given = file.read().split("\0")
                if any(given[place:place + 2] == words for place in range(len(given))):
                    os.kill(int(pid), signal.SIGTERM)
                    self.until(lambda pid=pid: not os.path.exists("/proc/" + pid), "the end of the panel")

    def press_twice(self, name):
        """As a finger that trembles does."""
        self.press(name, times=2)

    def open(self, page, mark):
        """Presses the button of a page until a widget of the page is there: a window that was just covered may lose a press."""

        def opened():
            place = self.find(page)
            if not self.find(mark) and place:
                self.rest()
                if place["scrolled"]:
                    self.press(page)
                elif place == self.find(page):  # else an earlier press has led on meanwhile
                    self.press_at(place["x"] + place["width"] // 2, place["y"] + place["height"] // 2)
                self.rest()
            return self.find(mark)

        self.until(opened, "the page " + page)

    def fill(self, title, size="1280x1000"):
        """Fills the screen with the window of that title. Returns whether it is there."""
        words = ["xdotool", "search", "--onlyvisible", "--name", title, "windowmove", "0", "0", "windowsize", *size.split("x")]
        return subprocess.run(words, env=self._environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              timeout=PATIENCE, check=False).returncode == 0

    def find_tab(self, title, places):
        """Presses places in the window of that title, one of them on the tab, until the panel is seen: a busy screen loses presses."""
        self.until(self.is_there, "the panel")
        self.until(lambda: self.fill(title), "the window " + title)
        self.rest()
        places = itertools.cycle(places)

        def press_next():
            self.press_at(*next(places))
            self.rest()
            return self.is_seen()

        self.until(press_next, "the panel in a tab of " + title)

    def press_at(self, x, y, times=1):
        """Several times, 0.05 s apart."""
        self._presses += times
        self._pointer.move(x, y)
        self._pointer.click(times=times, pause=0.05 - Pointer.HELD)

    @contextlib.contextmanager
    def story(self, name):
        """Counts presses and time of the block, into the file $PLUMB_STORIES, if there is one. A finger has no keyboard."""
        began, before = time.monotonic(), self._presses
        yield
        if os.environ.get("PLUMB_STORIES"):
            with open(os.environ["PLUMB_STORIES"], "a", encoding="utf-8") as file:
                file.write("%s\t%d\t%.0f\n" % (name, self._presses - before, time.monotonic() - began))

    def press_places(self, *places):
        """The middles of widgets that may not be there any more, one after the other as fast as the screen takes them."""
        for place in places:
            self._pointer.move(place["x"] + place["width"] // 2, place["y"] + place["height"] // 2)
            self._pointer.click()
            time.sleep(0.03)

    def _do(self, *words):
        subprocess.run(["xdotool", *map(str, words)], env=self._environment, check=True, timeout=PATIENCE)

    def jog(self, *keys):
        """By keys of the screen below the pointer, the last one held for a moment."""
        self._do("mousemove", 200, 600)
        for key in keys[:-1]:
            self._do("key", key)
        self._do("keydown", keys[-1], "sleep", "0.3", "keyup", keys[-1])

    def type(self, text):
        """By the keys on the screen. They stand still after the first one, at which the page may have changed."""
        for number, key in enumerate(text):
            name = {"-": "Sign"}.get(key, key)
            place = self.find(name)
            if number > 1 and place and not place["scrolled"] and not place["new"]:
                self._press_place(name, place)
            else:
                self.press(name)

    def shot(self, path, size=()):
        """A picture of the screen, or of its upper left, by GTK, which the panel needs anyway."""
        subprocess.run(["/usr/bin/python3", "-c", SHOT, path, *map(str, size)], env={**self._environment, "GDK_BACKEND": "x11"}, check=True, timeout=PATIENCE)

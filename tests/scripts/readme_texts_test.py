# SPDX-License-Identifier: GPL-2.0-or-later
"""A README that quotes a text of a screen, "in quotation marks", quotes one that exists; so it names the pages of plumb panel, and pins in its tables."""

import glob
import os
import re
import subprocess
import unittest

import pages
import panel_texts
import unwritten
from support import simulations  # for the way to plumb.py
from tree import BUILD, ROOT

# Texts in quotation marks that neither the panel nor a message shows: the file that has them, or the reason.
OTHERS = {
    "Queue is not empty after probing": "a message of LinuxCNC",
    "Probe tripped during non-probe move": "a message of LinuxCNC",
    "Still missing": "components/commissioning/wire/plumb_wire.py",
    "Worth it": "components/commissioning/contacts/plumb_contacts.py",
    "on centre within": "components/compensation/centre_height/centre_height.cpp",
    "Farthest beyond": "components/compensation/chopping/README.md",
    "CNC machine thermal growth characterization": "the title of a paper",
}


HEADING = re.compile(r'^ +heading = "([^"]+)"', re.M)
TITLE = re.compile(r'def title\(self\):\n +return _\("([^"]+)"\)')


def titles(pattern, files="*.py"):
    """The titles of pages of the panel that files give in this way."""
    found = []
    for path in glob.glob(os.path.join(ROOT, "components", "screens", "panel", files)):
        with open(path, encoding="utf-8") as file:
            found += pattern.findall(file.read())
    return found


def page_titles():
    return titles(HEADING) + titles(TITLE) + unwritten.titles_of_functions(BUILD)


def is_shown(text, shown):
    """Whether it is one of the shown texts, or the beginning of one; {placeholders} of a shown text stand for anything."""
    for whole in shown:
        pieces = [re.escape(piece) for piece in re.split(r"\{\w*\}", whole)]
        if re.fullmatch(".+".join(pieces), text) or re.match(re.escape(text) + r"(?!\w)", whole):
            return True
    return False


class Texts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shown = [*panel_texts.of_sources(), *panel_texts.of_declarations(BUILD)]

    def test_every_text_that_a_page_quotes_is_shown(self):
        quoted = [found for page in pages.readmes() for found in pages.quoted(page)]
        self.assertGreater(len(quoted), 15)
        for found in quoted:
            with self.subTest("%s:%d" % found[:2]):
                self.assertTrue(found.text in OTHERS or is_shown(found.text, self.shown), "%s, line %d: no screen shows \"%s\"" % found)

    def test_texts_of_others_are_quoted_and_there(self):
        quoted = {found.text for page in pages.readmes() for found in pages.quoted(page)}
        for text, place in OTHERS.items():
            self.assertIn(text, quoted)
            if "/" in place:
                self.assertIn(text.lower(), pages.read(place).lower())

    def test_every_page_that_a_page_names_exists(self):
        named = [found for page in pages.readmes() for found in pages.named_pages(page)]
        self.assertGreater(len(named), 5)
        for found in named:
            with self.subTest("%s:%d" % found[:2]):
                begins = any(re.match(re.escape(title) + r"(?!\w)", found.text) for title in page_titles())
                self.assertTrue(begins, "%s, line %d: the panel has no page %s" % found)

    def test_the_list_of_pages_is_that_of_the_panel(self):
        listed = unwritten.listed_pages()
        steps = [title for title in page_titles() if title[0].isdigit()]
        self.assertEqual([title for title in listed if title not in page_titles()], [])
        self.assertGreaterEqual(len(set(listed) & set(unwritten.titles_of_functions(BUILD))), 5)
        # The build lists the page of a function that is not in the table. Its other pages are forms to enter values.
        of_functions = titles(HEADING, "*_page.py") + titles(TITLE, "*_page.py") + unwritten.titles_of_functions(BUILD)
        self.assertEqual(sorted(set(page_titles()) - set(steps) - set(listed) - set(of_functions)), [])

    def test_beginnings_and_placeholders_are_recognised(self):
        shown = ["Refused: {why}", "Valid, of {count} contacts.", "Learn"]
        for text in ("Refused", "Refused: no load", "Valid, of 5 contacts.", "Learn"):
            self.assertTrue(is_shown(text, shown), text)
        for text in ("Ref", "Valid, of 5", "Learn again", "Limited"):
            self.assertFalse(is_shown(text, shown), text)


class Claims(unittest.TestCase):
    """The table of each function: claim by claim of its source, which pin, setting or program does it, and which command shows it."""

    FUNCTIONS = unwritten.with_claims(BUILD)

    def tables(self):
        for function in self.FUNCTIONS:
            rows, commands = pages.claims(unwritten.readme_of(function))
            yield function, rows, commands

    def test_each_function_has_a_whole_table(self):
        self.assertGreaterEqual(len(self.FUNCTIONS), 5)
        for function, rows, commands in self.tables():
            with self.subTest(function):
                self.assertGreaterEqual(len(rows), 7)
                self.assertGreaterEqual(len(commands), 7)
                self.assertEqual({cells for cells, _ in rows}, {5})
                for _, row in rows:
                    self.assertTrue(row.code and row.files and row.difference, "%s, line %d" % (row.page, row.line))

    def test_each_row_has_its_commands_and_each_command_a_row(self):
        for function, rows, commands in self.tables():
            with self.subTest(function):
                self.assertEqual(sorted(commands), list(range(1, len(commands) + 1)))
                self.assertEqual([number for number, lines in commands.items() if len(lines) > 1], [])
                self.assertEqual({number for _, row in rows for number in row.numbers}, set(commands))
                self.assertEqual([row.text for _, row in rows if not row.numbers], [])

    def test_pins_settings_and_files_of_a_row_exist(self):
        import plumb

        for function, rows, _ in self.tables():
            declared = plumb.declarations(function)
            own = {*declared["pins"], *declared["options"]}
            for _, row in rows:
                with self.subTest("%s:%d" % (row.page, row.line)):
                    for file in row.files:
                        self.assertTrue(os.path.isfile(os.path.join(ROOT, file)), file)
                    linked = "\n".join(pages.read(file) for file in row.files)
                    for words in row.code:
                        self.assertTrue(words in own or is_program(words) or contains(linked, words),
                                        "%s, line %d: %s is neither a pin of %s nor in a linked file" % (row.page, row.line, words, function))

    def test_words_and_programs_are_recognised(self):
        self.assertTrue(contains("net a motion.tooloffset.z => b", "motion.tooloffset.z"))
        self.assertFalse(contains("o<m4551> sub", "M455"))
        self.assertTrue(is_program("plumb growth identify"))
        self.assertFalse(is_program("plumb growth guess"))
        self.assertFalse(is_program("feed"))


def contains(text, words):
    """Whether a file has these words, whole, in capitals or not."""
    return re.search(r"(?<![\w-])" + re.escape(words) + r"(?![\w-])", text, re.I) is not None


def is_program(words):
    """A program of Plumb, or plumb with its commands."""
    name, *commands = words.split()
    known = os.path.isfile(os.path.join(BUILD, "bin", name))
    for place, command in enumerate(commands):
        known = known and "\n  %s " % command in helped(name, *commands[:place])
    return known


def helped(name, *commands):
    return subprocess.run([os.path.join(BUILD, "bin", name), *commands, "--help"], capture_output=True, text=True).stdout


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""All texts that plumb panel and linuxcnc_link show: the texts in its sources, comments "for gettext" too, and in the declarations.

    python3 scripts/panel_texts.py BUILD

prints those that the PO file lacks, as entries to be filled in. The panel shows such a text in English.
"""

import ast
import glob
import json
import os
import re
import sys

CALL = re.compile(r'\b_\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)\)')
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PO = os.path.join(ROOT, "components", "screens", "locale", "de.po")


def of_sources():
    found = {}
    screens = os.path.join(ROOT, "components", "screens")
    core = os.path.join(screens, "commissioning")
    program = os.path.join(ROOT, "components", "commissioning", "commission")
    folders = (os.path.join(screens, "panel"), core, os.path.join(core, "functions"), program)
    for path in sorted(path for folder in folders for path in glob.glob(os.path.join(folder, "*.py"))):
        with open(path, encoding="utf-8") as file:
            for match in CALL.finditer(file.read()):
                found[ast.literal_eval("(%s)" % match[1])] = os.path.basename(path)
    return {**found, **of_error_list()}


def of_error_list():
    """How each kind of error is measured, as plumb volume says it."""
    with open(os.path.join(ROOT, "components", "commissioning", "error_list.hpp"), encoding="utf-8") as file:
        hows = re.search(r"hows\[\] = \{(.*?)\};", file.read(), re.S)[1]
    return dict.fromkeys(re.findall(r'"([^"]*)"', hows), "error_list.hpp")


def of_declarations(build):
    """Titles, summaries, codes, messages and sentences of all components but plants."""
    found = {}
    for path in sorted(glob.glob(os.path.join(build, "share", "plumb", "*.json"))):
        name = os.path.basename(path)
        with open(path, encoding="utf-8") as file:
            declared = json.load(file)
        if declared.get("role") == "plant":
            continue
        texts = [text for codes in declared.get("codes", {}).values() for text in codes.values()] + [declared["summary"]]
        texts += [declared["title"]] if "title" in declared else []
        texts += [told["sentence"] for told in declared.get("told", {}).values() if not told["sentence"].startswith("{")]
        texts += [its["remedy"] for its in declared.get("statuses", {}).values() if its["remedy"]]
        pins = {short: pin for short, pin in declared["pins"].items() if not short.startswith(("row", "restore"))}
        texts += [pin["sentence"] for pin in pins.values()]
        found.update({text: name for text in texts})
    return found


def of_role(build, role):
    """The modules and programs of a role, by their declarations. A link is a former name."""
    found = []
    for path in sorted(glob.glob(os.path.join(build, "share", "plumb", "*.json"))):
        if os.path.islink(path):
            continue
        with open(path, encoding="utf-8") as file:
            if json.load(file).get("role") == role:
                found.append(os.path.basename(path)[:-len(".json")])
    return found


def translated(path=PO):
    """Texts of a PO file by what they translate."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    entries = re.findall(r'^msgid ((?:"(?:[^"\\]|\\.)*"\s*)+)\nmsgstr ((?:"(?:[^"\\]|\\.)*"\s*)+)', text, re.M)
    return {ast.literal_eval("(%s)" % first): ast.literal_eval("(%s)" % second) for first, second in entries}


def without_words(texts, path=PO):
    """Those of the texts, with their places, that a PO file does not translate."""
    there = translated(path) if os.path.exists(path) else {}
    return {text: place for text, place in texts.items() if not there.get(text)}


if __name__ == "__main__":
    for text, place in without_words({**of_sources(), **of_declarations(sys.argv[1])}).items():
        print("#: %s\nmsgid %s\nmsgstr \"\"\n" % (place, json.dumps(text, ensure_ascii=False)))

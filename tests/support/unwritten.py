# SPDX-License-Identifier: GPL-2.0-or-later
"""Texts for people that a new function still lacks. Its .cpp, its .page, its page of the panel and its test do without them.

    python3 tests/support/unwritten.py BUILD

prints a warning for each kind, with a list.
"""

import glob
import json
import os
import re
import sys

import pages
from tree import ROOT

sys.path.insert(1, os.path.join(ROOT, "scripts"))
import panel_texts  # noqa: E402

PANEL = "components/screens/README.md"


def readme_of(function):
    """The README.md beside a compensation."""
    return "components/compensation/%s/README.md" % function.removesuffix("_test")


def with_claims(build):
    """The compensations whose README.md has the table of claims. A README.md may have those of two."""
    names = panel_texts.of_role(build, "compensation")
    return [name for name in names if os.path.exists(os.path.join(ROOT, readme_of(name))) and pages.claims(readme_of(name))[0]]


def not_named(build):
    """The compensations and stages that README.md does not name."""
    page = pages.read("README.md")
    return [name for role in ("compensation", "stage") for name in panel_texts.of_role(build, role) if "`%s`" % name not in page]


def titles_of_functions(build):
    """The titles of the pages that functions have in the panel."""
    declared = [json.loads(pages.read(path)) for path in sorted(glob.glob(os.path.join(build, "share", "plumb", "*.json")))]
    return [each["title"] for each in declared if each.get("role") == "compensation" and "title" in each]


def listed_pages():
    """The titles in the table of the README.md of the panel."""
    rows = re.search(r"^\| Page \|.*\n.*\n((?:\|.*\n)+)", pages.read(PANEL), re.M)[1]
    return re.findall(r"^\| ([^|]+?) \|", rows, re.M)


def warn(about, lines):
    if lines:
        print("warning: %s:" % about)
        for line in lines:
            print("    " + line)


def main(build):
    german = panel_texts.without_words({**panel_texts.of_sources(), **panel_texts.of_declarations(build)})
    warn("%d texts have no German words in components/screens/locale/de.po" % len(german), ["%s: %s" % (place, text) for text, place in german.items()])
    if german:
        print("python3 scripts/panel_texts.py %s prints them as entries to be filled in." % build)
    warn("README.md names no", not_named(build))
    compensations = panel_texts.of_role(build, "compensation")
    warn("There is no", [readme_of(name) for name in compensations if not os.path.exists(os.path.join(ROOT, readme_of(name)))])
    warn(PANEL + " lists no page", [title for title in titles_of_functions(build) if title not in listed_pages()])


if __name__ == "__main__":
    main(sys.argv[1])

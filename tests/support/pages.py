# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands and quoted texts of the README pages."""

import collections
import glob
import os
import re
import shutil

from tree import BUILD, ROOT

DATA = ("hal", "ini", "ngc", "python")  # languages of fenced blocks without commands
PROGRAMS = os.pathsep.join([os.path.join(BUILD, "bin"), os.environ["PATH"]])

Found = collections.namedtuple("Found", "page line text")

# A row of the table of claims: its first cell, its words in code, the files it links to, why it differs, and the numbers of
# its commands.
Claim = collections.namedtuple("Claim", "page line text code files difference numbers")
CLAIMS = "## The source, claim by claim"


def readmes():
    """README.md, CONTRIBUTING.md, and every page of a folder."""
    found = ["README.md", "CONTRIBUTING.md"]
    for top in ("components", "configs", "hal", "scripts", "tests"):
        found += sorted(glob.glob(top + "/**/*.md", root_dir=ROOT, recursive=True))
    return found


def read(page):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        return file.read()


def blocks(text):
    """Code blocks: the language of the fence or '', the number of the first line, and the lines."""
    fence, block, after_blank = None, None, True
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("```"):
            fence = None if fence is not None else line[3:].strip()
            block = None
        elif fence is not None or (line.startswith("    ") and (block or after_blank)):
            if block is None:
                block = (fence or "", number, [])
                yield block
            block[2].append(line if fence is not None else line[4:])
        else:
            block = None
        after_blank = not line.strip()


def commands(page, text=None):
    """The commands of a page, without their comments. A block holds commands if its first word is a program, or a line has an option."""
    found = []
    for language, number, lines in list(blocks(read(page) if text is None else text)):
        if language not in DATA and (language or _is_command(lines[0]) or any(" --" in line for line in lines)):
            for place, line in enumerate(lines):
                line = re.sub(r"(^|\s+)#( .*)?$", "", line).strip()
                if line:
                    found.append(Found(page, number + place, line))
    return found


def claims(page):
    """The rows of the table of claims of a page, and its commands by their numbers."""
    text = read(page)
    if "\n" + CLAIMS + "\n" not in text:
        return [], {}
    before, section = text.split("\n" + CLAIMS + "\n", 1)
    section = re.split(r"^## ", section, maxsplit=1, flags=re.M)[0]
    first = before.count("\n") + 3
    rows = []
    for place, line in enumerate(section.splitlines()):
        if line.startswith("|"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            files = [os.path.normpath(os.path.join(os.path.dirname(page), link)) for link in re.findall(r"\]\(([^)#]+)", line)]
            numbers = [int(number) for number in re.findall(r"\d+", cells[-1])]
            rows.append((len(cells), Claim(page, first + place, cells[0], re.findall(r"`([^`]+)`", line), files, cells[-2], numbers)))
    numbered = {}
    for line in section.splitlines():
        found = re.match(r"    (\S.*?) +# (\d+)$", line)
        if found:
            numbered.setdefault(int(found[2]), []).append(found[1])
    return rows[2:], numbered


def _is_command(line):
    word = (line.split() or [""])[0]
    if re.match(r"\w+(=|\(\)$)", word) or word in ("export", "cd", "sudo", "plumb", "linuxcnc", "halcmd", "halrun"):
        return True
    return shutil.which(word, path=PROGRAMS) is not None or (
        "/" in word and (os.path.isfile(os.path.join(ROOT, word)) or word.startswith(("build/", "scripts/", "./"))))


def prose(page):
    """The page without its code blocks, the code in its lines, and the licences that it cites; line numbers stay."""
    text = read(page)
    lines = ["" if line.startswith(("```", ">")) else line for line in text.splitlines()]
    for _, number, code in list(blocks(text)):
        for place in range(len(code)):
            lines[number - 1 + place] = ""
    return re.sub(r"`[^`]*`", lambda code: re.sub(r"[^\n]", "x", code[0]), "\n".join(lines))


def quoted(page, text=None):
    """The texts in quotation marks, each in one line."""
    text = prose(page) if text is None else text
    return [Found(page, text.count("\n", 0, match.start()) + 1, " ".join(match[1].split()))
            for match in re.finditer(r'"([^"]+)"', text)]


def named_pages(page, text=None):
    """The words behind `the page`, where a page of a screen is named."""
    text = prose(page) if text is None else text
    return [Found(page, text.count("\n", 0, match.start()) + 1, " ".join(match[1].split()))
            for match in re.finditer(r"\bpages?\s+([A-Z][^.,;|]*)", text)]

# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs the bench that the first argument names. Each module beside this one is a bench, with its options."""

import ast
import glob
import importlib.util
import os
import re
import sys

FOLDER = os.path.dirname(os.path.abspath(__file__))
COMMAND = os.environ.get("PLUMB_BENCH", "scripts/bench")  # what the user wrote


def benches():
    """Name -> the first line of its docstring."""
    found = {}
    for path in sorted(glob.glob(os.path.join(FOLDER, "[a-z]*.py"))):
        with open(path, encoding="utf-8") as file:
            found[os.path.basename(path)[:-3]] = ast.get_docstring(ast.parse(file.read())).splitlines()[0]
    return found


def usage():
    lines = [f"Usage: {COMMAND} NAME [OPTION ...]", ""]
    width = max(len(name) for name in benches()) + 2
    lines += [f"    {name:{width}}{words}" for name, words in benches().items()]
    return "\n".join(lines + ["", f"`{COMMAND} NAME --help` prints the options of a bench.", ""])


def require(bench):
    """Ends with a command if the packages of a bench are missing. scripts/bench has installed them before."""
    with open(os.path.join(FOLDER, bench + ".py"), encoding="utf-8") as file:
        packages = re.findall(r'^PACKAGES = "(.*)"$', file.read(), re.M)
    for package in " ".join(packages).split():
        if package.startswith("python3-") and importlib.util.find_spec(package[len("python3-"):]) is None:
            sys.exit(f"{COMMAND}: {bench} needs {package}: sudo apt install {package}")


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] not in benches():
        sys.stderr.write(usage())
        sys.exit(2)
    if "--help" not in sys.argv:
        require(sys.argv[1])
    importlib.import_module(sys.argv.pop(1)).main()

# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the functions: a FunctionPage in a file *_page.py serves its module, and PlainPage all others."""

import importlib
import pkgutil

import panel
from panel.function_page import FunctionPage, PlainPage


def _own_pages():
    """The pages by the module that each is about."""
    for each in pkgutil.iter_modules(panel.__path__):
        if each.name.endswith("_page"):
            importlib.import_module("panel." + each.name)
    return {page.function: page for page in FunctionPage.__subclasses__() if page.function}


PAGES = _own_pages()


def function_pages(panel, former):
    """A page for each function that this machine has, in the order of the navigation; `former` are pages that stay, by type and
    instance."""
    found = []
    for instance in panel.machine.functions():
        page = PAGES.get(instance.module, PlainPage)
        found.append(former.get((page, instance.name)) or page(panel, instance))
    return sorted(found, key=lambda page: page.place)

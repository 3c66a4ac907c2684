# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the functions, in the order of the navigation."""

from panel.centre_height_page import CentreHeightPage
from panel.chopping_page import ChoppingPage
from panel.growth_page import GrowthPage
from panel.growth_test_page import GrowthTestPage
from panel.squareness_page import SquarenessPage

PAGES = {
    "thermal_displacement": GrowthPage,
    "squareness": SquarenessPage,
    "centre_height": CentreHeightPage,
    "chopping": ChoppingPage,
    "thermal_growth_test": GrowthTestPage,
}


def function_pages(panel, former):
    """A page for each instance of a function that this machine has; `former` are pages that stay, by type and instance."""
    found = []
    for instance in panel.machine.instances:
        page = PAGES.get(instance.module)
        if page is not None:
            found.append(former.get((page, instance.name)) or page(panel, instance))
    return found

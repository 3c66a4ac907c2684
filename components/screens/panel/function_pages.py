# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages of the functions, in the order of the navigation."""

from panel.centre_height_page import CentreHeightPage
from panel.growth_page import GrowthPage
from panel.simple_pages import ChoppingPage, GrowthTestPage
from panel.squareness_page import SquarenessPage

PAGES = {
    "thermal_displacement": GrowthPage,
    "squareness": SquarenessPage,
    "centre_height": CentreHeightPage,
    "chopping": ChoppingPage,
    "thermal_growth_test": GrowthTestPage,
}


def function_pages(panel):
    """A page for each instance of a function that this machine has."""
    return [PAGES[instance.module](panel, instance) for instance in panel.machine.instances if instance.module in PAGES]

# SPDX-License-Identifier: GPL-2.0-or-later
"""centre_height, chopping and thermal_growth_test."""

from panel.function_page import FunctionPage


class CentreHeightPage(FunctionPage):
    heading = "Centre height"  # for gettext: _("Centre height")


class ChoppingPage(FunctionPage):
    heading = "Chopping"  # for gettext: _("Chopping")


class GrowthTestPage(FunctionPage):
    heading = "Growth test"  # for gettext: _("Growth test")

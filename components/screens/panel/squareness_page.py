# SPDX-License-Identifier: GPL-2.0-or-later
"""squareness: what is corrected now, and the way from a leaning machine to a square one."""

from panel.function_page import FunctionPage


class SquarenessPage(FunctionPage):
    heading = "Squareness"  # for gettext: _("Squareness")

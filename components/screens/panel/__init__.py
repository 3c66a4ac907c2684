# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts of plumb-panel. Those that import gi draw; the others do without a screen."""

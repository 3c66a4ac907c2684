# SPDX-License-Identifier: GPL-2.0-or-later
"""The first power-on of a function: steps, readings and their faults. No module here draws."""

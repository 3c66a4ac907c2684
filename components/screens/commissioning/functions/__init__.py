# SPDX-License-Identifier: GPL-2.0-or-later
"""The steps of each function, by its module: MOVES_NOTHING, and steps(session)."""

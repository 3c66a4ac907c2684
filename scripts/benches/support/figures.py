# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures over many values, and how tables print them."""

import numpy as np

PERCENTILES = {"p10": 10, "p50": 50, "p90": 90, "worst": 100}


def rms(values):
    return np.sqrt(np.mean(np.square(values))) if len(values) else np.nan


def largest(values):
    return np.max(np.abs(values)) if len(values) else np.nan


def percentile_lines(title, rows, width, cell, name_width):
    """The lines of a table of PERCENTILES; rows: pairs of a name and its values, of one machine each."""
    lines = [f"{title:{name_width}}" + "".join(f"{head:>{width}}" for head in PERCENTILES)]
    for name, values in rows:
        found = np.percentile(values, list(PERCENTILES.values()))
        lines.append(f"{name:{name_width}}" + "".join(f"{cell(value):>{width}}" for value in found))
    return lines


def micrometres(um):
    return "< 1e-6" if um < 1e-6 else f"{um:.1g}" if um < 0.05 else f"{um:.1f}"

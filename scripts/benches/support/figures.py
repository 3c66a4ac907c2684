# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures over many values, and how tables print them."""

import math

import numpy as np

PERCENTILES = {"p10": 10, "p50": 50, "p90": 90, "worst": 100}


def rms(values):
    return np.sqrt(np.mean(np.square(values))) if len(values) else np.nan


def largest(values):
    return np.max(np.abs(values)) if len(values) else np.nan


def most_likely(found, of):
    """Upper 95 % limit of the part of which `found` of so many are a sample (C. J. Clopper and E. S. Pearson, Biometrika 26, 1934)."""
    if found == of:
        return 1.0
    low, high = found / of, 1.0
    for _ in range(60):
        part = (low + high) / 2
        terms = [math.lgamma(of + 1) - math.lgamma(k + 1) - math.lgamma(of - k + 1) + k * math.log(part) + (of - k) * math.log1p(-part) for k in range(found + 1)]
        low, high = (part, high) if sum(math.exp(term) for term in terms) > 0.05 else (low, part)
    return high


def percentile_lines(title, rows, width, cell, name_width):
    """The lines of a table of PERCENTILES; rows: pairs of a name and its values, of one machine each."""
    lines = [f"{title:{name_width}}" + "".join(f"{head:>{width}}" for head in PERCENTILES)]
    for name, values in rows:
        found = np.percentile(values, list(PERCENTILES.values()))
        lines.append(f"{name:{name_width}}" + "".join(f"{cell(value):>{width}}" for value in found))
    return lines


def micrometres(um):
    return "< 1e-6" if um < 1e-6 else f"{um:.1g}" if um < 0.05 else f"{um:.1f}"

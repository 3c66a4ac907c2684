# SPDX-License-Identifier: GPL-2.0-or-later
"""The look of all charts, which the same figures always draw byte for byte."""

# Colours that the colour-blind can distinguish, from Okabe and Ito.
ORANGE, BLUE, GREEN, PURPLE, GREY = "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#555555"
LIGHT_GREY = "#777777"
GRID = "#dddddd"


def prepared_pyplot():
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"svg.hashsalt": "plumb", "font.size": 10, "axes.spines.top": False, "axes.spines.right": False})
    return pyplot


def write_title(figure, title):
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")


def save(figure, paths):
    """In the format that the end of each path names."""
    from matplotlib import pyplot

    for path in paths:
        figure.savefig(path, dpi=120, metadata={"Date": None} if path.endswith(".svg") else None)
    pyplot.close(figure)

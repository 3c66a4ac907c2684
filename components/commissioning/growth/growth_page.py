#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""growth_page.py FOLDER: makes report.html of the results.json that plumb-growth wrote there, and results.csv and the charts of the first test as PNG."""

import csv
import io
import json
import logging
import os
import re
import sys

import jinja2

try:
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # a HOME that cannot be written is no news
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import figure
except ImportError:
    matplotlib = None

# Colours that the colour-blind can distinguish, from Okabe and Ito.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8a6d00", "#555555")
STYLE = {"svg.fonttype": "none", "svg.hashsalt": "plumb", "text.parse_math": False, "font.family": "sans-serif", "font.size": 9, "axes.grid": True, "grid.color": "#dddddd",
         "axes.spines.top": False, "axes.spines.right": False}
FEW = 60  # values, of a line that shows them as dots
GAP = float("nan")


def number(value, digits=1):
    return "\u2013" if value is None else "%.*f" % (digits, value)


def um(value, digits=1):
    return number(None if value is None else 1e3 * value, digits)


def hours(value, digits=2):
    return number(value / 3600, digits)


class Chart:
    """Lines over hours; a line is a name, values of x and y, and options of its drawing."""

    def __init__(self, file, title, unit, lines, tolerance=0):
        self.file, self._title = file, title
        with matplotlib.rc_context(STYLE):
            self._figure = figure.Figure(figsize=(9, 3.9), layout="constrained")
            axes = self._figure.subplots()
            axes.set_title(title, loc="left", fontweight="bold")
            axes.set_xlabel("time in h")
            axes.set_ylabel(unit)
            if tolerance:
                axes.axhspan(-tolerance, tolerance, color="#009e73", alpha=0.13, lw=0, label="tolerance \u00b1%.1f %s" % (tolerance, unit))
            axes.axhline(0, color="#555555", lw=0.8) if unit != "\u00b0C" else None
            for index, (name, x, y, options) in enumerate(lines):
                options = {"color": COLOURS[options.get("colour", index) % len(COLOURS)], "ls": "--" if options.get("dashed") else "-"}
                axes.plot(x, y, lw=1.6, marker="o" if len(x) <= FEW else None, ms=3.5, label=name, gid="line-%d" % index, **options)
            axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False, fontsize=8)

    @property
    def svg(self):
        text = io.StringIO()
        with matplotlib.rc_context(STYLE):
            self._figure.savefig(text, format="svg", metadata={"Date": None}, transparent=True)
        svg = text.getvalue()[text.getvalue().index("<svg"):]
        return svg.replace("<svg ", '<svg class="chart" role="img" aria-label="%s" ' % jinja2.utils.markupsafe.escape(self._title), 1)

    def write_png(self, folder):
        picture = io.BytesIO()
        with matplotlib.rc_context(STYLE):
            self._figure.savefig(picture, format="png", dpi=120)
        replace(os.path.join(folder, self.file + ".png"), picture.getvalue())


def replace(path, content):
    """The whole file or none, in the place of an older one."""
    try:
        with open(path + ".new", "wb") as file:
            file.write(content)
        os.replace(path + ".new", path)
    except OSError as error:
        if os.path.exists(path + ".new"):
            os.unlink(path + ".new")
        sys.exit("plumb growth: %s: %s" % (path, error.strerror))


def line_of(series, axis, name, **options):
    """One axis of a series, with a gap at each break."""
    x, y, part = [], [], 0
    for point in series["points"]:
        if point["part"] != part:
            x.append(point["time_s"] / 3600)
            y.append(None)
        part = point["part"]
        x.append(point["time_s"] / 3600)
        y.append(point["deviation_mm"][axis])
    x += [point["time_s"] / 3600 for point in series["cool_down"]]
    y += [point["deviation_mm"][axis] for point in series["cool_down"]]
    return name, x, [GAP if value is None else 1e3 * value for value in y], options


def worst(test, compensated):
    """The series in this state with the largest deviation in space."""
    def size(series):
        return max((sum(v * v for v in point["deviation_mm"]) for point in series["points"] if None not in point["deviation_mm"]), default=0)
    return max((series for series in test["series"] if series["compensated"] == compensated), key=size, default=None)


def probed(test, letter):
    return any(test["axes"][letter][state] for state in ("off", "on"))


def temperatures(test):
    lines = []
    for sensor in test["temperatures_degc"]:
        x, y, breaks = [], [], list(test["breaks_s"])
        for time, value in zip(sensor["time_s"], sensor["value"]):
            if breaks and time >= breaks[0]:
                breaks.pop(0)
                x.append(time / 3600)
                y.append(GAP)
            x.append(time / 3600)
            y.append(value)
        lines.append((sensor["name"], x, y, {}))
    return [Chart("temperatures", "Temperatures", "\u00b0C", lines)] if lines else []


def charts_of(test):
    charts = temperatures(test)
    its = worst(test, not test["has_off"])
    axes = [(index, letter, 1e3 * test["axes"][letter]["tolerance_mm"]) for index, letter in enumerate("XYZ") if probed(test, letter)]
    for index, letter, tolerance in axes if its else ():
        same = [series for series in test["series"] if (series["bore"], series["turned"]) == (its["bore"], its["turned"])]
        lines = [line_of(series, index, "compensation " + ("on" if series["compensated"] else "off"), colour=0 if series["compensated"] else 1)
                 for series in sorted(same, key=lambda series: series["compensated"])]
        charts.append(Chart(letter.lower() + "-off-and-on", "%s of %s, the worst" % (letter, its["name"]), "\u00b5m", lines, tolerance))
    for index, letter, tolerance in axes if len(test["series"]) > 1 else ():
        lines = [line_of(series, index, series["name"], colour=series["bore"] - 1, dashed=series["turned"])
                 for series in test["series"] if series["compensated"] != test["has_off"]]
        charts.append(Chart(letter.lower() + "-bores", "%s of all bores, %s compensation" % (letter, "without" if test["has_off"] else "with"), "\u00b5m", lines, tolerance))
    return charts


def compared(tests):
    charts = []
    for index, letter in enumerate("XYZ"):
        if not any(probed(test, letter) for test in tests):
            continue
        found = [(test, worst(test, not test["has_off"])) for test in tests]
        lines = [line_of(series, index, re.sub(r"^(.{16})[^,]*", r"\1", test["title"])) for test, series in found if series]
        charts.append(Chart("compared-" + letter.lower(), letter + " of the worst bore of each test, without compensation where there is that", "\u00b5m", lines))
    return charts


def charts_of_gauges(gauges):
    charts = []
    for file, title, unit, given in (("displacements", "Displacements", "\u00b5m", "um"), ("tilts", "Tilts", "\u00b5m/m", "um/m")):
        lines = [(name, [time / 3600 for time in its["time_s"]], its["value"], {}) for name, its in sorted(gauges["quantities"].items()) if its["unit"] == given]
        charts += [Chart(file, title, unit, lines)] if lines else []
    return charts


def prepare(test):
    """Adds the fields of the template to the results of a test."""
    test["both"] = test["has_off"] and test["has_on"]
    test["curves"] = [("%s, %s" % (letter, state), axis[state]["curve"]) for state in ("off", "on") for letter, axis in test["axes"].items() if axis[state] and axis[state]["curve"]]
    test["charts"] = charts_of(test) if matplotlib else []


def csv_of(test):
    """Every deviation and compensation, a line each."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow("bore turned compensated pass time_s dx_mm dy_mm dz_mm cx_mm cy_mm cz_mm diameter_mm scatter_mm".split())
    for series in test["series"]:
        where = [series["bore"], int(series["turned"]), int(series["compensated"])]
        for point in series["points"] + series["cool_down"]:
            rows.writerow([*where, point["pass"], point["time_s"], *point["deviation_mm"], *point["compensation_mm"], point["diameter_mm"], point["scatter_mm"]])
    return text.getvalue().encode()


def nearest(cells):
    return min(cells, key=lambda other: GAP if cells[other] is None else cells[other])


def main(folder):
    with open(os.path.join(folder, "results.json"), encoding="utf-8") as file:
        results = json.load(file)
    tests, gauges = results.get("tests", []), results.get("gauges")
    for test in tests:
        prepare(test)
    charts = [] if not matplotlib else charts_of_gauges(gauges) if gauges else compared(tests) if len(tests) > 1 else []
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(os.path.abspath(__file__))), autoescape=True, undefined=jinja2.ChainableUndefined)
    environment.filters.update(number=number, um=um, hours=hours, extract=lambda key, its: its[key])
    title = "Thermal growth of " + (gauges["file"] if gauges else tests[0]["machine"])
    page = environment.get_template("growth_page.html").render(title=title, tests=tests, gauges=gauges, charts=charts, nearest=nearest, version=results["version_of_plumb"])
    replace(os.path.join(folder, "report.html"), page.encode())
    if tests:
        replace(os.path.join(folder, "results.csv"), csv_of(tests[0]))
    for chart in tests[0]["charts"] if tests else ():
        chart.write_png(folder)
    if not matplotlib:
        print("No charts: install python3-matplotlib.")


if __name__ == "__main__":
    main(sys.argv[1])

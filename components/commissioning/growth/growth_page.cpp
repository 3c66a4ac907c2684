// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <sstream>

#include "components/commissioning/growth/growth_report.hpp"
#include "components/commissioning/growth/growth_words.hpp"
#include "components/io/files/csv.hpp"

namespace plumb::commissioning {
namespace {

constexpr const char* style = R"(<style>
:root{--bg:#fff;--fg:#1a1a1a;--soft:#555;--line:#ddd;--card:#f6f6f6;--good:#00694d;--bad:#b03a00;--open:#6b5900}
@media (prefers-color-scheme:dark){:root{--bg:#16181b;--fg:#eee;--soft:#aaa;--line:#3a3d42;--card:#212428;--good:#4fd0a5;--bad:#ff9a5c;--open:#e6cf5c}}
body{background:var(--bg);color:var(--fg);font:16px/1.5 system-ui,sans-serif;max-width:1000px;margin:0 auto;padding:1rem}
h1{font-size:1.6rem;margin:.2rem 0}h2{font-size:1.2rem;margin-top:2rem;border-bottom:1px solid var(--line)}
table{border-collapse:collapse;width:100%;font-size:.92rem}th,td{padding:.3rem .5rem;text-align:right;border-bottom:1px solid var(--line)}
th:first-child,td:first-child{text-align:left}.wide{overflow-x:auto}.soft{color:var(--soft)}
.verdict{background:var(--card);border-left:8px solid var(--open);padding:.6rem 1rem;margin:1rem 0;font-size:1.05rem}
.verdict.pass{border-color:var(--good)}.verdict.fail{border-color:var(--bad)}.verdict b{text-transform:uppercase}
.pass b{color:var(--good)}.fail b{color:var(--bad)}
svg.chart{width:100%;height:auto;margin:.6rem 0;font-family:system-ui,sans-serif}
.g{stroke:var(--line)}.a{stroke:var(--soft)}.t{fill:var(--fg)}.b{fill:#009e73;fill-opacity:.16}
.l0{stroke:#0072b2;fill:#0072b2}.l1{stroke:#d55e00;fill:#d55e00}.l2{stroke:#009e73;fill:#009e73}.l3{stroke:#cc79a7;fill:#cc79a7}
.l4{stroke:#56b4e9;fill:#56b4e9}.l5{stroke:#e69f00;fill:#e69f00}.l6{stroke:#8a6d00;fill:#8a6d00}.l7{stroke:#777;fill:#777}
@media (prefers-color-scheme:dark){.l0{stroke:#4da6e0;fill:#4da6e0}.l1{stroke:#ff8a45;fill:#ff8a45}}
figure{margin:0}figure:focus-visible,summary:focus-visible,a:focus-visible{outline:3px solid #0072b2;outline-offset:2px}
pre{overflow-x:auto;background:var(--card);padding:.6rem;font-size:.85rem}details{margin:.5rem 0}summary{cursor:pointer}
@media print{body{max-width:none;font-size:11pt}figure,table{break-inside:avoid}details{display:none}}
</style>)";

void write_axes(std::ostringstream& out, const GrowthAnalysis& test) {
    out << "<div class=\"wide\"><table><caption class=\"soft\">Largest deviation of a bore from the cold "
           "pass, in \u00b5m; U is its uncertainty, 95 of 100</caption><thead><tr><th "
           "scope=\"col\">Axis</th><th scope=\"col\">1 h</th><th "
           "scope=\"col\">4 h</th>"
           "<th scope=\"col\">end</th><th scope=\"col\">largest</th><th scope=\"col\">range</th><th "
           "scope=\"col\">rate per "
           "h</th><th scope=\"col\">U</th><th scope=\"col\">tolerance</th><th "
           "scope=\"col\">verdict</th></tr></thead><tbody>\n";
    for (const bool compensated : {false, true}) {
        if (!(compensated ? test.has_on : test.has_off)) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const GrowthOfAxis& its = (compensated ? test.on : test.off)[axis];
            if (!its.probed) continue;
            const bool judged = compensated || !test.has_on;
            out << "<tr><th scope=\"row\">" << letters[axis] << (compensated ? ", on" : ", off")
                << "</th><td>" << um(its.at_1_hour) << "</td><td>" << um(its.at_4_hours) << "</td><td>"
                << um(its.at_end) << "</td><td>" << um(its.largest) << "</td><td>" << um(its.range)
                << "</td><td>" << um(its.rate) << "</td><td>" << um(test.budgets[axis].expanded())
                << "</td><td>\u00b1" << um(test.log->tolerance[axis]) << "</td><td>"
                << (judged ? word(test.verdicts[axis]) : "") << "</td></tr>\n";
        }
    }
    out << "</tbody></table></div>\n";
}

void write_cross_gains(std::ostringstream& out, const CrossGains& cross) {
    if (std::count(cross.drifts.begin(), cross.drifts.end(), true) < 2) return;
    out << "<table><caption class=\"soft\">Which axis does the compensation follow? Offset of the row minus "
           "drift of the "
           "column, \u00b5m rms, and the cross gain with its 2 u</caption><thead><tr><th "
           "scope=\"col\">Compensation</th>";
    for (const char letter : {'X', 'Y', 'Z'}) out << "<th scope=\"col\">drift of " << letter << "</th>";
    out << "</tr></thead><tbody>\n";
    for (int row = 0; row < 3; ++row) {
        out << "<tr><th scope=\"row\">" << letters[row] << "</th>";
        Eigen::Index nearest = 0;
        cross.difference.row(row).minCoeff(&nearest);
        for (int column = 0; column < 3; ++column) {
            const char* const tag = column == nearest ? "b" : "span";
            out << "<td><" << tag << '>' << um(cross.difference(row, column)) << "</" << tag << '>';
            if (cross.determined[static_cast<std::size_t>(column)])
                out << " <span class=\"soft\">" << number(cross.gain(row, column), 2) << " \u00b1 "
                    << number(2 * cross.uncertainty(row, column), 2) << "</span>";
            out << "</td>";
        }
        out << "</tr>\n";
    }
    out << "</tbody></table><p class=\"soft\">A good compensation has its smallest differences, in bold, on "
           "the "
           "diagonal, and gains of 1 there and 0 elsewhere. Where the axes drift alike, their gains cannot "
           "be told "
           "apart and are left out.</p>\n";
}

std::string why_no_gain(const GrowthAnalysis& test, std::size_t axis) {
    if (!test.off[axis].probed) return "was not probed";
    if (test.passes < 2) return "not determined: there is one pass";
    return "not determined: the drift, " + um(test.off[axis].largest) +
           " \u00b5m, has to be above 4 u of a pass = " + um(4 * test.of_one_pass(axis)) + " \u00b5m";
}

void write_compensation(std::ostringstream& out, const GrowthAnalysis& test) {
    out << "<h2>Compensation</h2><p>" << escaped_xml(compensation_sentence(test)) << "</p>\n";
    if (!test.has_on || !test.has_off) return;
    out << "<table><thead><tr><th scope=\"col\">Axis</th><th scope=\"col\">gain</th><th scope=\"col\">2 "
           "u</th>"
           "<th scope=\"col\">effectiveness</th></tr></thead><tbody>\n";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const CompensationGain& gain = test.gain[axis];
        out << "<tr><th scope=\"row\">" << letters[axis] << "</th>";
        if (gain.determined)
            out << "<td>" << number(gain.gain, 2) << "</td><td>" << number(2 * gain.uncertainty, 2)
                << "</td><td>" << number(100 * gain.effectiveness, 0) << " %</td></tr>\n";
        else
            out << "<td colspan=\"3\">" << why_no_gain(test, axis) << "</td></tr>\n";
    }
    out << "</tbody></table><p class=\"soft\">Gain: 0 not applied, 1 perfect, \u22121 wrong sign, above 1 "
           "too much. It names the fault of the compensation; the verdict above follows the drift that is "
           "left, "
           "its U and the tolerance.</p>\n";
    write_cross_gains(out, test.finding.cross);
}

void write_identified(std::ostringstream& out, const GrowthAnalysis& test) {
    if (!test.identified && test.not_identified.empty()) return;
    out << "<h2>Settings of axis_growth</h2>";
    if (!test.identified) {
        out << "<p>None: " << escaped_xml(test.not_identified) << ".</p>\n";
        return;
    }
    out << "<p>The test was cut into parts, and each law predicted the later ones from those before. A law "
           "is used where "
           "it leaves less than no law and than a line over one temperature.</p><table><thead><tr><th "
           "scope=\"col\">Axis</th><th scope=\"col\">drift, \u00b5m rms</th><th scope=\"col\">of later parts "
           "no law "
           "leaves</th><th scope=\"col\">one temperature</th><th "
           "scope=\"col\">the law</th><th scope=\"col\">used</th></tr></thead><tbody>\n";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const GrowthIdentified::Axis& its = test.identified->axes[axis];
        out << "<tr><th scope=\"row\">" << letters[axis] << "</th>";
        if (its.probed)
            out << "<td>" << um(its.drift) << "</td><td>" << um(its.none_rest) << "</td><td>"
                << um(its.line_rest) << "</td><td>" << um(its.predicted_rest) << "</td><td>"
                << (its.used ? "yes" : "no") << "</td></tr>\n";
        else
            out << "<td colspan=\"5\">was not probed</td></tr>\n";
    }
    out << "</tbody></table><details><summary>The lines for axis_growth_settings.hal, also in "
           "axis_growth_settings.hal beside "
           "this page</summary><pre>"
        << escaped_xml(growth_settings(test.log->file, test.log->begun, *test.identified))
        << "</pre></details>\n";
}

void write_prediction(std::ostringstream& out, const GrowthAnalysis& test) {
    const auto fitted = [](const GrowthOfAxis& axis) { return axis.curve.has_value(); };
    out << "<h2>Prediction</h2>";
    if (std::none_of(test.off.begin(), test.off.end(), fitted) &&
        std::none_of(test.on.begin(), test.on.end(), fitted)) {
        out << "<p>None: a prediction needs two passes" << (test.parts > 1 ? " since the last break" : "")
            << ".</p>\n";
        return;
    }
    if (test.duty_changed) {
        out << "<p>Not determined: the spindle speed of the work changed in the test. A steady state belongs "
               "to one "
               "duty.</p>\n";
        return;
    }
    out << "<p>Advice, never the verdict. A machine has several time constants, which may act against each "
           "other: the curve may bend twice and turn. The interval takes all time constants from "
           "one minute to three times the length of the test, at most eight hours.</p>"
           "<table><thead><tr><th scope=\"col\">Axis</th><th scope=\"col\">steady state</th><th "
           "scope=\"col\">95 of 100 between</th><th scope=\"col\">rate at the end, per h</th></tr></thead>"
           "<tbody>\n";
    for (const bool compensated : {false, true})
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const GrowthOfAxis& its = (compensated ? test.on : test.off)[axis];
            if (!its.probed || !its.curve) continue;
            const GrowthCurve& curve = *its.curve;
            out << "<tr><th scope=\"row\">" << letters[axis] << (compensated ? ", on" : ", off")
                << "</th><td>" << (curve.determined ? um(curve.steady) + " \u00b5m" : "not determined")
                << "</td><td>" << um(curve.low()) << " and " << um(curve.high()) << " \u00b5m</td><td>"
                << um(curve.rate * seconds_per_hour) << " \u00b1 "
                << um(2 * curve.rate_sigma * seconds_per_hour) << " \u00b5m</td></tr>\n";
        }
    out << "</tbody></table><p class=\"soft\">Not determined: the interval is wider than the drift that was "
           "measured. Test for longer.</p>\n";
}

void write_places(std::ostringstream& out, const GrowthAnalysis& test) {
    if (test.rigid && test.rigid->rank <= 3) {
        out << "<h2>Rigid part in the last pass</h2><p>None: one bore cannot show rotations and "
               "scales.</p>\n";
    } else if (test.rigid) {
        out << "<h2>Rigid part in the last pass</h2><p>dx = tx + sx x + ry z \u2212 rz y; dy = ty + sy y "
               "\u2212 rx z + rz "
               "x; dz = tz + sz z + rx y \u2212 ry x. Rank "
            << test.rigid->rank
            << " of 9.</p><div class=\"wide\"><table><thead><tr><th scope=\"col\">Parameter</th>";
        for (const char* name : RigidPart::names) out << "<th scope=\"col\">" << name << "</th>";
        out << "</tr></thead><tbody><tr><th scope=\"row\">\u00b5m, \u00b5m/m</th>";
        for (Eigen::Index i = 0; i < 9; ++i) {
            const double scale = i < 3 ? 1e3 : 1e6;
            out << "<td>";
            if (test.rigid->determined[static_cast<std::size_t>(i)])
                out << number(test.rigid->value[i] * scale) << " \u00b1 "
                    << number(2 * test.rigid->per_unit[i] * test.uncertainty * scale);
            else
                out << "not determined";
            out << "</td>";
        }
        out << "</tr></tbody></table></div><p>The rest that is not rigid: " << um(test.rigid->rms)
            << " \u00b5m rms.</p>\n";
    }
    if (test.turned.empty()) return;
    out << "<h2>Two orientations in the last pass</h2><p>In X and Z the half-sum is the table's centre "
           "against the spindle, "
           "and the half-difference the bore against the table's centre.</p><table><thead><tr><th "
           "scope=\"col\">Bore</th><th scope=\"col\">half-sum X, Y, Z</th><th scope=\"col\">half-difference "
           "X, Y, Z</th><th "
           "scope=\"col\">tilt about X</th></tr></thead><tbody>\n";
    for (const GrowthAnalysis::Turned& turned : test.turned) {
        out << "<tr><th scope=\"row\">" << turned.bore << "</th>";
        for (const Eigen::Vector3d& half : {turned.table.half_sum, turned.table.half_difference})
            out << "<td>" << um(half.x()) << ", " << um(half.y()) << ", " << um(half.z()) << " \u00b5m</td>";
        out << "<td>" << (turned.tilt ? number(*turned.tilt * 1e6) + " \u00b5rad" : "\u2013")
            << "</td></tr>\n";
    }
    out << "</tbody></table>\n";
}

void write_budget(std::ostringstream& out, const GrowthAnalysis& test) {
    out << "<table><caption class=\"soft\">Uncertainty of a deviation, \u00b5m. All but the last two are "
           "standard uncertainties</caption><thead><tr><th scope=\"col\">Axis</th><th "
           "scope=\"col\">touch</th>"
           "<th scope=\"col\">seat</th><th scope=\"col\">drift in the pass</th><th scope=\"col\">reference "
           "pass</th><th scope=\"col\">artifact</th><th scope=\"col\">probe</th><th scope=\"col\">u</th><th "
           "scope=\"col\">k</th><th "
           "scope=\"col\">U</th></tr></thead><tbody>\n";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!test.off[axis].probed && !test.on[axis].probed) continue;
        const GrowthBudget& its = test.budgets[axis];
        out << "<tr><th scope=\"row\">" << letters[axis] << "</th>";
        for (const double part :
             {its.touch, its.seat, its.drift, its.pass(), its.artifact, its.probe, its.standard()})
            out << "<td>" << number(part * 1e3, 2) << "</td>";
        out << "<td>" << number(coverage_factor(its.freedom)) << "</td><td>" << um(its.expanded())
            << "</td></tr>\n";
    }
    out << "</tbody></table>\n";
}

std::string artifact_sentence(const GrowthAnalysis& test) {
    const ArtifactExpansion& its = test.expansion;
    if (!its.applied)
        return "Artifact: its own expansion is in the deviations and not in U, as " +
               escaped_xml(its.why_not) +
               ". 120 mm of steel grow by 2.8 \u00b5m in 2 K: write the table [artifact] into the file of "
               "growth_log.";
    const GrowthLog::Artifact& artifact = *test.log->artifact;
    return "Artifact: its own expansion has been taken out, " + number(artifact.expansion) + " \u00b1 " +
           number(artifact.uncertainty) + " \u00b5m/m for 1 K, from " + number(its.coldest) + " to " +
           number(its.warmest) + " K by its sensor: " + um(its.largest.x()) + ", " + um(its.largest.y()) +
           " and " + um(its.largest.z()) + " \u00b5m at most in X, Y and Z.";
}

void write_method(std::ostringstream& out, const GrowthAnalysis& test) {
    out << "<h2>Method and uncertainty</h2>\n";
    write_budget(out, test);
    out << "<ul><li>Deviation = position without compensation now, minus that in the first pass, of the same "
           "bore, "
           "orientation and state.</li><li>Touch: the touches of a bore against each other, from visit to "
           "visit. "
           "About their circle they scatter by "
        << um(test.touch_scatter)
        << " \u00b5m, with the lobes of the probe, which do not change.</li><li>Seat: the scatter of the "
           "passes about "
           "a smooth curve, less the touches. A few passes show little of it: 1 \u00b5m is expected "
           "beforehand, and k "
           "grows.</li><li>Drift in the pass: it is removed by the bore that is probed twice. An eighth of "
           "it may "
           "remain.</li><li>Reference pass: it has touch, seat and drift once more.</li><li>"
        << artifact_sentence(test)
        << "</li><li>Probe: see its section above.</li><li>Fail: a deviation less U "
           "is above the tolerance, at any time. Pass: each deviation plus U is within it, and the test has "
           "reached "
           "its end. All else is not determined.</li><li>Where the compensation does nothing, a sensor that "
           "is not "
           "logged may be frozen: the two cannot be distinguished.</li></ul>\n";
}

void write_table(std::ostringstream& out, const GrowthAnalysis& test) {
    out << "<details><summary>All deviations as a table</summary><div class=\"wide\"><table><thead><tr><th "
           "scope=\"col\">Bore</th><th scope=\"col\">state</th><th scope=\"col\">pass</th><th "
           "scope=\"col\">h</th><th "
           "scope=\"col\">X</th><th scope=\"col\">Y</th><th scope=\"col\">Z</th></tr></thead><tbody>\n";
    for (const GrowthSeries& series : test.series)
        for (const GrowthPoint& point : series.all())
            out << "<tr><td>" << escaped_xml(series.name()) << "</td><td>"
                << (series.compensated ? "on" : "off") << "</td><td>" << point.pass << "</td><td>"
                << number(point.time / seconds_per_hour, 2) << "</td><td>" << um(point.deviation.x())
                << "</td><td>" << um(point.deviation.y()) << "</td><td>" << um(point.deviation.z())
                << "</td></tr>\n";
    out << "</tbody></table></div></details>\n";
}

void write_test(std::ostringstream& out, const GrowthAnalysis& test) {
    const GrowthLog& log = *test.log;
    const std::string kind = test.verdict == GrowthVerdict::pass   ? "pass"
                             : test.verdict == GrowthVerdict::fail ? "fail"
                                                                   : "open";
    out << "<p class=\"soft\">" << escaped_xml(clause(log)) << "<br>Machine " << escaped_xml(log.machine)
        << ", begun " << escaped_xml(log.begun) << ", " << number(test.duration / seconds_per_hour) << " h, "
        << test.passes << " passes. Compensation: " << escaped_xml(log.compensation) << ". "
        << growth_test::said_of_log(test.stop).sentence << "</p>\n"
        << "<div class=\"verdict " << kind << "\" role=\"status\"><b>" << word(test.verdict) << "</b><ul>";
    for (const std::string& reason : test.reasons) out << "<li>" << escaped_xml(reason) << "</li>";
    if (test.has_off && test.has_on) out << "<li>" << escaped_xml(compensation_sentence(test)) << "</li>";
    out << "</ul></div>\n";
    write_axes(out, test);
    write_compensation(out, test);
    out << "<h2>Charts</h2>\n";
    for (const GrowthChart& chart : growth_charts(test))
        out << "<figure tabindex=\"0\">" << chart.svg(false) << "</figure>\n";
    write_identified(out, test);
    write_prediction(out, test);
    write_places(out, test);
    out << practice_page(test);
    write_method(out, test);
    if (!test.notes.empty()) {
        out << "<h2>Notes</h2><ul>";
        for (const std::string& note : test.notes) out << "<li>" << escaped_xml(note) << "</li>";
        out << "</ul>\n";
    }
    write_table(out, test);
}

std::string short_title(const GrowthLog& log) {
    GrowthLog its;
    its.begun = log.begun.substr(0, 16);
    its.number = log.number;
    return its.title();
}

void write_comparison(std::ostringstream& out, const std::vector<GrowthAnalysis>& tests) {
    out << "<h2>Comparison</h2><div class=\"wide\"><table><thead><tr><th scope=\"col\">Test</th><th "
           "scope=\"col\">verdict</th>";
    for (const char* state : {"off", "on"})
        for (int axis = 0; axis < 3; ++axis)
            out << "<th scope=\"col\">" << letters[axis] << ' ' << state << "</th>";
    out << "</tr></thead><tbody>\n";
    for (std::size_t i = 0; i < tests.size(); ++i) {
        const GrowthAnalysis& test = tests[i];
        out << "<tr><td><a href=\"#test" << i + 1 << "\">" << escaped_xml(test.log->title())
            << "</a></td><td>" << word(test.verdict) << "</td>";
        for (const bool compensated : {false, true})
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const GrowthOfAxis& its = (compensated ? test.on : test.off)[axis];
                out << "<td>" << (its.probed ? um(its.largest) : "\u2013") << "</td>";
            }
        out << "</tr>\n";
    }
    out << "</tbody></table></div><p class=\"soft\">Largest deviation of a bore, in \u00b5m.</p>\n";
    for (int axis = 0; axis < 3; ++axis) {
        const auto probed = [axis](const GrowthAnalysis& test) {
            const auto i = static_cast<std::size_t>(axis);
            return test.off[i].probed || test.on[i].probed;
        };
        if (std::none_of(tests.begin(), tests.end(), probed)) continue;
        GrowthChart chart{"compared-" + std::string(1, "xyz"[axis]),
                          std::string(1, letters[axis]) +
                              " of the worst bore of each test, without compensation where "
                              "there is that",
                          "\u00b5m",
                          {},
                          0};
        int colour = 0;
        for (const GrowthAnalysis& test : tests) {
            const GrowthSeries* worst = test.worst(!test.has_off);
            if (worst) chart.lines.push_back(line_of(*worst, axis, short_title(*test.log), colour++, false));
        }
        out << "<figure tabindex=\"0\">" << chart.svg(false) << "</figure>\n";
    }
}

}  // namespace

std::string page_begin(const std::string& title) {
    return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
           "content=\"width=device-width,initial-scale=1\"><link rel=\"icon\" href=\"data:,\"><title>" +
           title + "</title>" + style + "</head><body>\n<h1>" + title + "</h1>\n";
}

std::string page_end() {
    return "<p class=\"soft\">plumb growth " PLUMB_VERSION "</p></body></html>\n";
}

std::string growth_page(const std::vector<GrowthAnalysis>& tests) {
    std::ostringstream out;
    const std::string machine = escaped_xml(tests.front().log->machine);
    out << page_begin("Thermal growth of " + machine);
    if (tests.size() > 1) write_comparison(out, tests);
    for (std::size_t i = 0; i < tests.size(); ++i) {
        out << "<section id=\"test" << i + 1 << "\">";
        if (tests.size() > 1) out << "<h1>Test of " << escaped_xml(tests[i].log->title()) << "</h1>";
        write_test(out, tests[i]);
        out << "</section>\n";
    }
    out << page_end();
    return out.str();
}

}  // namespace plumb::commissioning

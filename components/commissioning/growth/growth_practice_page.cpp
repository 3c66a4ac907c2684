// SPDX-License-Identifier: GPL-2.0-or-later
#include <sstream>

#include "components/commissioning/growth/growth_practice.hpp"
#include "components/commissioning/growth/growth_words.hpp"
#include "components/io/files/csv.hpp"

namespace plumb::commissioning {
namespace {

void write_environment(std::ostringstream& out, const GrowthAnalysis& test, const GrowthPractice& practice) {
    if (test.log->warming != "none") return;
    out << "<h2>Environment</h2><p>The machine stood. The environmental temperature variation error (ETVE) "
           "is the "
           "range of a "
           "deviation over the test.</p><table><thead><tr><th scope=\"col\">Range over "
        << number(test.duration / seconds_per_hour) << " h</th><th scope=\"col\"></th></tr></thead><tbody>\n";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const GrowthOfAxis& its = (test.has_off ? test.off : test.on)[axis];
        if (its.probed)
            out << "<tr><th scope=\"row\">ETVE " << letters[axis] << "</th><td>" << um(its.range)
                << " \u00b5m, U = " << um(test.budgets[axis].expanded()) << " \u00b5m</td></tr>\n";
    }
    for (const auto& [name, range] : practice.ranges)
        out << "<tr><th scope=\"row\">" << escaped_xml(name) << "</th><td>" << number(range)
            << " K</td></tr>\n";
    out << "</tbody></table>\n";
}

void write_cool_down(std::ostringstream& out, const GrowthAnalysis& test, const GrowthPractice& practice) {
    if (test.log->warming == "none") return;
    out << "<h2>Cool-down</h2>";
    if (practice.cooled_for == 0) {
        out << "<p>Not recorded: set _growth_cool_down in the settings of the test.</p>\n";
        return;
    }
    out << "<p>The machine rested for " << number(practice.cooled_for / seconds_per_hour)
        << " h after the last warm pass. Mean of all bores, " << (test.has_off ? "without" : "with")
        << " compensation, in \u00b5m.</p><table><thead><tr><th scope=\"col\">Axis</th><th "
           "scope=\"col\">warm</th><th "
           "scope=\"col\">at the end</th><th scope=\"col\">largest rate per h</th><th scope=\"col\">returned "
           "to the cold place</th></tr></thead><tbody>\n";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& its = practice.cool_down[axis];
        if (!its) continue;
        out << "<tr><th scope=\"row\">" << letters[axis] << "</th><td>" << um(its->warm) << "</td><td>"
            << um(its->left) << "</td><td>" << um(its->rate) << "</td><td>"
            << (std::abs(its->left) <= test.budgets[axis].expanded() ? "yes, within U" : "not yet")
            << "</td></tr>\n";
    }
    out << "</tbody></table>\n";
}

void write_ends(std::ostringstream& out, const GrowthAnalysis& test, const GrowthPractice& practice) {
    out << "<h2>Both ends of the travel</h2>";
    bool any = false;
    for (const auto& its : practice.ends) any |= its.has_value();
    if (!any) {
        out << "<p>Not determined: no two bores are 20 mm apart along an axis, with their places in the "
               "log.</p>\n";
        return;
    }
    out << "<table><thead><tr><th scope=\"col\">Axis</th><th scope=\"col\">low end</th><th "
           "scope=\"col\">high end</th><th "
           "scope=\"col\">distance</th><th scope=\"col\">expansion, \u00b5m/m</th></tr></thead><tbody>\n";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& its = practice.ends[axis];
        if (!its) continue;
        out << "<tr><th scope=\"row\">" << letters[axis] << "</th><td>bore " << its->low << ": "
            << um(its->at_low) << " \u00b5m</td><td>bore " << its->high << ": " << um(its->at_high)
            << " \u00b5m</td><td>" << number(its->distance, 0) << " mm</td><td>" << number(its->strain * 1e6)
            << " \u00b1 " << number(2 * its->strain_sigma * 1e6) << "</td></tr>\n";
    }
    out << "</tbody></table><p class=\"soft\">In the last warm pass. "
        << (test.expansion.applied
                ? "The expansion of the artifact has been taken out."
                : "The expansion of the artifact is contained in it: 11.5 \u00b5m/m for 1 K of steel.")
        << " ISO 230-3 asks for the ends of the whole travel: put the artifact, or one at each end, "
           "there.</p>\n";
}

void write_probe(std::ostringstream& out, const GrowthAnalysis& test) {
    if (test.probe.passes.empty()) return;
    out << "<h2>Probe</h2><p>The diameters of the bores changed by " << um(test.probe.largest())
        << " \u00b5m at most since the first pass, 2 u = " << um(2 * test.probe.sigma) << " \u00b5m. "
        << (!test.expansion.applied
                ? "The expansion of the artifact is contained in it: 0.35 \u00b5m for 30 mm of steel and 1 K."
            : test.probe.seen() ? "The probe itself changed: half of it, evenly distributed, is in the "
                                  "uncertainty of Z. Let the probe warm up "
                                  "in the spindle before a pass, or requalify it, and test again."
                                : "No change of the probe can be seen.")
        << "</p><details><summary>By pass</summary><table><thead><tr><th scope=\"col\">Pass</th><th "
           "scope=\"col\">h</th><th scope=\"col\">change of the diameters, "
           "\u00b5m</th></tr></thead><tbody>\n";
    for (const ProbeDrift::Pass& pass : test.probe.passes)
        out << "<tr><td>" << pass.number << "</td><td>" << number(pass.time / seconds_per_hour, 2)
            << "</td><td>" << number(pass.change * 1e3, 2) << "</td></tr>\n";
    out << "</tbody></table></details>\n";
}

}  // namespace

std::string practice_page(const GrowthAnalysis& test) {
    std::ostringstream out;
    write_environment(out, test, test.practice);
    write_cool_down(out, test, test.practice);
    write_ends(out, test, test.practice);
    write_probe(out, test);
    return out.str();
}

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "components/commissioning/growth/growth_report.hpp"
#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {
namespace {

std::string micrometres(double mm) {
    return um(mm) + " \u00b5m";
}

// The drift that the rule of the test calls stable, and the drift that the rule cannot see.
void say_stable(GrowthAnalysis& analysis, const std::array<GrowthOfAxis, 3>& axes) {
    double room = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (axes[axis].probed) room = std::max(room, analysis.budgets[axis].expanded());
    if (std::isfinite(analysis.last_hour))
        analysis.reasons.push_back("Stable means here: in the last hour no deviation changed by more than " +
                                   micrometres(analysis.last_hour) + ", U = " + micrometres(room) +
                                   ". A drift below " + micrometres(analysis.last_hour + room) +
                                   " per hour cannot be seen; it may go on, and it may turn.");
    else
        analysis.reasons.push_back(
            "Stable means here: the temperatures stand. The displacements do not cover the last hour, so a "
            "drift "
            "may go on, and it may turn.");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& curve = axes[axis].curve;
        if (!curve || !axes[axis].probed || !(std::abs(curve->rate) > 2 * curve->rate_sigma)) continue;
        const bool back = curve->rate * axes[axis].at_end < 0;
        analysis.reasons.push_back(std::string(1, "XYZ"[axis]) + " still drifted by " +
                                   micrometres(curve->rate * 3600) + " per hour at the end" +
                                   (back ? ", back towards its cold place." : "."));
    }
}

}  // namespace

void decide(GrowthAnalysis& analysis) {
    const bool compensated = analysis.has_on;
    const auto& axes = compensated ? analysis.on : analysis.off;
    const std::string state = compensated ? "with compensation" : "without compensation";
    bool all = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string letter(1, "XYZ"[axis]);
        if (!axes[axis].probed) continue;
        const double most = axes[axis].largest, room = analysis.budgets[axis].expanded(),
                     tolerance = analysis.log->tolerance[axis];
        GrowthVerdict& verdict = analysis.verdicts[axis];
        if (const auto& slip = analysis.slips[axis]) {
            analysis.reasons.push_back(
                "All bores moved by " + micrometres(slip->size) + " in " + letter + " at once before pass " +
                std::to_string(slip->pass) +
                ", which no growth does: the artifact has slipped, or the probe has changed.");
        } else if (most - room > tolerance) {
            verdict = GrowthVerdict::fail;
            analysis.reasons.push_back(letter + " drifts " + micrometres(most) + " " + state +
                                       ", U = " + micrometres(room) + "; the tolerance is " +
                                       micrometres(tolerance) + ".");
            analysis.verdict = GrowthVerdict::fail;
        } else if (most + room > tolerance) {
            analysis.reasons.push_back(letter + " drifts " + micrometres(most) + " " + state +
                                       ", within U = " + micrometres(room) + " of the tolerance of " +
                                       micrometres(tolerance) + ".");
        } else if (analysis.stop == growth_test::Stop::stable) {
            verdict = GrowthVerdict::pass;
        }
        all = all && verdict == GrowthVerdict::pass;
    }
    const hal::Said said = growth_test::said_of_log(analysis.stop);
    const std::string status = said.sentence;
    if (analysis.stop == growth_test::Stop::none)
        analysis.reasons.push_back(status + " Only a fail can be stated now. " + said.remedy);
    if (analysis.stop == growth_test::Stop::stable) say_stable(analysis, axes);
    if (analysis.stop == growth_test::Stop::maximum_time) analysis.reasons.push_back(status);
    const bool any =
        std::any_of(axes.begin(), axes.end(), [](const GrowthOfAxis& axis) { return axis.probed; });
    if (!any) analysis.reasons.push_back("No bore was probed twice.");
    if (any && all && analysis.verdict != GrowthVerdict::fail) analysis.verdict = GrowthVerdict::pass;
    if (analysis.verdict == GrowthVerdict::pass)
        analysis.reasons.push_back("All axes stay within their tolerances " + state + ".");
}

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {
namespace {

// The seat of a probe in its spindle. A few passes show it within a factor of two at best: they correct it.
constexpr double usual_seat = 0.001;  // mm
// A stopped spindle cools along an exponential. A line through a pass that is as long as its time constant
// leaves at most an eighth of the drift in this pass, evenly distributed.
const double bend_of_drift = 1 / (8 * std::sqrt(3.0));
constexpr double least_touch = 0.0002;  // mm

// The largest number of bores and orientations of a state.
double bores(const GrowthAnalysis& analysis) {
    double count[2]{};
    for (const GrowthSeries& series : analysis.series) ++count[series.compensated ? 1 : 0];
    return std::max({count[0], count[1], 1.0});
}

// How a mean over bores scatters about a smooth curve from pass to pass: by the longest part of the test.
GrowthCurve scatter(const GrowthAnalysis& analysis, int axis) {
    GrowthCurve best;
    best.noise = usual_seat;
    for (const bool compensated : {false, true}) {
        const GrowthMeans means = means_of(analysis, compensated);
        for (int part = 0; part < analysis.parts; ++part)
            if (const auto curve = curve_of(means, axis, part); curve && curve->freedom > best.freedom)
                best = *curve;
    }
    return best;
}

double lever(const std::vector<GrowthVisit>& visits, int axis) {
    double largest = 0;
    for (const GrowthVisit& visit : visits)
        largest = std::max(largest, axis == 0   ? visit.x_per_touch
                                    : axis == 1 ? visit.y_per_touch
                                                : visit.z_per_touch);
    return largest;
}

// `touch`: the standard uncertainty of a touch, mm. The expansion of the artifact has been taken out of the
// diameters if it is known.
ProbeDrift probe_drift(const std::vector<GrowthVisit>& visits, double touch) {
    struct Sum {
        double change = 0, time = 0, count = 0;
    };
    std::map<GrowthVisit::Key, std::pair<double, double>>
        first;  // sum of the diameters in the first pass, and their number
    for (const GrowthVisit& visit : visits)
        if (visit.checked && visit.pass == visits.front().pass)
            first[visit.key()].first += visit.diameter, ++first[visit.key()].second;
    std::map<int, Sum> later;
    for (const GrowthVisit& visit : visits) {
        const auto reference = first.find(visit.key());
        if (!visit.checked || visit.pass == visits.front().pass || reference == first.end()) continue;
        Sum& its = later[visit.pass];
        its.change += visit.diameter - reference->second.first / reference->second.second;
        its.time += visit.time;
        ++its.count;
    }
    ProbeDrift found;
    for (const auto& [pass, its] : later) {
        found.passes.push_back({pass, its.time / its.count, its.change / its.count});
        // A circle of four touches has a diameter as certain as one touch; the first pass has it once more.
        found.sigma = std::max(found.sigma, touch * std::sqrt(2 / its.count));
    }
    return found;
}

}  // namespace

double ProbeDrift::largest() const {
    double found = 0;
    for (const Pass& pass : passes)
        if (std::abs(pass.change) > std::abs(found)) found = pass.change;
    return found;
}

std::optional<GrowthCurve> curve_of(const GrowthMeans& means, int axis, int part) {
    GrowthSamples samples;
    for (std::size_t i = 0; i < means.pass.size(); ++i)
        if (means.part[i] == part) samples.emplace_back(means.time[i], means.deviation[i][axis]);
    return curve_of(samples, usual_seat);
}

void make_budgets(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits) {
    const TouchRepeats repeats = touch_repeats(visits);
    const double touch = std::max(repeats.freedom > 0 ? repeats.sigma : analysis.touch_scatter, least_touch);
    const DriftInPass drift = drift_in_passes(visits);
    analysis.probe = probe_drift(visits, touch);
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        GrowthBudget& its = analysis.budgets[i];
        if (!analysis.off[i].probed && !analysis.on[i].probed) continue;
        its.touch = touch * lever(visits, axis);
        // A bore that was visited twice gives the rate within a pass.
        its.drift = std::hypot(drift.largest[axis] * bend_of_drift, its.touch / std::sqrt(2.0));
        const GrowthCurve pass = scatter(analysis, axis);
        const double of_mean = its.touch / std::sqrt(bores(analysis));
        its.seat = std::sqrt(std::max(pass.noise * pass.noise - of_mean * of_mean, 0.0));
        // Welch and Satterthwaite.
        const double touches = std::pow(its.touch, 4) / std::max(repeats.freedom, 1.0),
                     seats = std::pow(its.seat, 4) / std::max(pass.freedom, 1.0);
        its.artifact = analysis.expansion.uncertainty[axis];
        // The centre of a bore does not depend on the travel of the probe until it trips; the face does.
        if (axis == 2 && analysis.expansion.applied && analysis.probe.seen())
            its.probe = std::abs(analysis.probe.largest()) / 2 / std::sqrt(3.0);
        its.freedom = std::pow(its.standard(), 4) / (4 * (touches + seats));
        analysis.of_mean[i] = std::sqrt(2.0) * std::sqrt(its.seat * its.seat + of_mean * of_mean);
        analysis.uncertainty = std::max(analysis.uncertainty, its.standard());
    }
    if (!drift.known)
        analysis.notes.push_back(
            "No bore was probed again within a pass: the drift within a pass was not removed, and is not in "
            "the "
            "uncertainty.");
}

}  // namespace plumb::commissioning

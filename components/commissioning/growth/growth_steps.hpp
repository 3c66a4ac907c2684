// SPDX-License-Identifier: GPL-2.0-or-later
// The steps of analysed(), in their order.
#pragma once

#include "components/commissioning/growth/growth_analysis.hpp"
#include "components/commissioning/growth/growth_visits.hpp"

#include <optional>
#include <vector>

namespace plumb::commissioning {

// The deviations of each bore from the first pass.
void make_series(const std::vector<GrowthVisit>& visits, GrowthAnalysis& analysis);

// Drifts, rates and predictions of each axis.
void measure_axes(GrowthAnalysis& analysis);

// The uncertainty of a deviation, from repeated touches, seats and passes.
void make_budgets(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits);

// Gain and fault of the compensation, where both states were probed.
void judge_compensation(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits);

// The two orientations in the last pass.
void compare_orientations(GrowthAnalysis& analysis);

// Steps of all bores between two passes that are no growth.
void find_slips(GrowthAnalysis& analysis);

// The cool-down, the ends of the travel and the environment.
GrowthPractice growth_practice(const GrowthAnalysis& analysis);

// The verdict, with its reasons.
void decide(GrowthAnalysis& analysis);

// The means over bores and orientations of each pass that has them all; the passes and their times.
// `cooling`: of the last warm pass and the cool-down.
struct GrowthMeans {
    std::vector<int> pass, part;
    std::vector<double> time;
    std::vector<Eigen::Vector3d> deviation, compensation;
};
GrowthMeans means_of(const GrowthAnalysis& analysis, bool compensated, bool cooling = false);

// The curve of one axis in one part of the test; nothing with fewer than two passes.
std::optional<GrowthCurve> curve_of(const GrowthMeans& means, int axis, int part);

}  // namespace plumb::commissioning

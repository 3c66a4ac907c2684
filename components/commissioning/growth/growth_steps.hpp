// SPDX-License-Identifier: GPL-2.0-or-later
// The steps of analysed(), in their order.
#pragma once

#include "components/commissioning/growth/growth_analysis.hpp"
#include "components/commissioning/growth/growth_visits.hpp"

#include <vector>

namespace plumb::commissioning {

// The deviations of each bore from the first pass.
void make_series(const std::vector<GrowthVisit>& visits, GrowthAnalysis& analysis);

// Drifts, rates and predictions of each axis, and the uncertainty of a deviation.
void measure_axes(GrowthAnalysis& analysis);

// Gain and fault of the compensation, where both states were probed.
void judge_compensation(GrowthAnalysis& analysis, const std::vector<GrowthVisit>& visits);

// The rigid part, and the two orientations.
void split_places(GrowthAnalysis& analysis);

// The verdict, with its reasons.
void decide(GrowthAnalysis& analysis);

// The means over bores and orientations of each pass that has them all; the passes and their times.
struct GrowthMeans {
    std::vector<int> pass;
    std::vector<double> time;
    std::vector<Eigen::Vector3d> deviation, compensation;
};
GrowthMeans means_of(const GrowthAnalysis& analysis, bool compensated);

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"

#include <Eigen/Core>

#include <limits>
#include <tuple>
#include <vector>

namespace plumb::commissioning {

// A visit of a bore that counts; lengths in mm.
struct GrowthVisit {
    static constexpr double none = std::numeric_limits<double>::quiet_NaN();
    using Key = std::tuple<int, bool, bool>;  // bore, turned, compensated

    int pass = 0, bore = 0;
    bool turned = false, compensated = false, cooled = false;
    double time = 0;                          // s, the mean of its touches
    Eigen::Vector3d place{none, none, none};  // without compensation; not a number where it was not probed
    Eigen::Vector3d compensation{0, 0, 0};
    double diameter = 0, scatter = 0;
    bool checked = false;  // more touches than a circle needs: `scatter` means something

    Key key() const { return {bore, turned, compensated}; }
};

std::vector<GrowthVisit> growth_visits(const GrowthLog& log);

// All visits of a pass at its middle, one of each bore, orientation and state. The drift within the pass is
// that of all bores that were visited more than once at an orientation, in any state: off and on may be taken
// bore by bore, or in mirrored passes.
std::vector<GrowthVisit> visits_at_one_time(const std::vector<GrowthVisit>& visits);

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"

#include <Eigen/Core>

#include <limits>
#include <map>
#include <tuple>
#include <vector>

namespace plumb::commissioning {

// A visit of a bore that counts; lengths in mm.
struct GrowthVisit {
    static constexpr double none = std::numeric_limits<double>::quiet_NaN();
    using Key = std::tuple<int, bool, bool>;  // bore, turned, compensated

    int pass = 0, bore = 0;
    int part = 0;  // of the test: a break in which the machine cools begins another one
    bool turned = false, compensated = false, cooled = false;
    bool cooling_down = false;                // the test has stopped, and the machine rests
    double time = 0;                          // s, the mean of its touches
    Eigen::Vector3d place{none, none, none};  // without compensation; not a number where it was not probed
    Eigen::Vector3d compensation{0, 0, 0};
    double diameter = 0, scatter = 0;
    bool checked = false;  // more touches than a circle needs: `scatter` means something
    // By the directions of the touches: how far each is off the circle or the face of all, in their order.
    std::map<int, std::vector<double>> rests;
    double x_per_touch = 0, y_per_touch = 0, z_per_touch = 0;  // uncertainty of place by that of a touch

    Key key() const { return {bore, turned, compensated}; }
};

// A break that is longer, or of unknown length, lets the machine cool.
constexpr double longest_break = 600;  // s

std::vector<GrowthVisit> growth_visits(const GrowthLog& log);

// The standard uncertainty of one touch, by its repeats: how the touches of a bore change against each other
// from visit to visit. The lobes of the probe stay and do not count.
struct TouchRepeats {
    double sigma = 0;    // mm
    double freedom = 0;  // 0: no touch was repeated
};
TouchRepeats touch_repeats(const std::vector<GrowthVisit>& visits);

// Of each axis: the largest drift within a pass that was removed from it, mm, and whether a bore was visited
// again so that it could be.
struct DriftInPass {
    Eigen::Vector3d largest{0, 0, 0};
    bool known = true;
};
DriftInPass drift_in_passes(const std::vector<GrowthVisit>& visits);

// All visits of a pass at its middle, one of each bore, orientation and state. The drift within the pass is
// that of all bores that were visited more than once at an orientation, in any state: off and on may be taken
// bore by bore, or in mirrored passes.
std::vector<GrowthVisit> visits_at_one_time(const std::vector<GrowthVisit>& visits);

}  // namespace plumb::commissioning

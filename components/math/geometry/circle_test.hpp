// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <vector>

namespace plumb {

// A circular path after ISO 230-4: radii at angles, from the first axis of the plane to the second one.
struct CircularPath {
    bool clockwise = false;
    std::vector<double> angles, radii;  // rad, mm
};

struct CircleSetup {
    double radius = 0;  // mm, nominal
    double speed = 0;   // mm/s, along the path
};

struct Estimate {
    double value = 0, uncertainty = 0;  // standard
};

// The errors of both axes, a first and b second of the plane, that the path shows.
struct CircleResult {
    Estimate opening;                       // rad, of the corner; with one direction the lag is in it
    Estimate scale_difference;              // 1, scale of a less scale of b
    Estimate lost_motion_a, lost_motion_b;  // mm
    Estimate across_a;                      // mm, half of the shift of a along b by direction: E(b)(a)+
    Estimate lag;                           // s, of a less b; only with both directions
    double centre_a = 0, centre_b = 0;      // mm
    double radius_deviation = 0;            // mm, mean radius less nominal: the bar, and equal scales
    double d = 0;                           // mm, D: mean radius of both paths less nominal
    bool both_directions = false;
    double noise = 0;                                   // mm, rms of the residuals
    double g_clockwise = 0, g_counter = 0, g_both = 0;  // mm, G and G(b)
    double f_most = 0, f_least = 0;                     // mm, F of both directions
};

// One path, or one in each direction. Throws std::invalid_argument with the reason.
CircleResult circle_result(const CircleSetup& setup, const std::vector<CircularPath>& paths);

}  // namespace plumb

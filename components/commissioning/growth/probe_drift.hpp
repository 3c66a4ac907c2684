// SPDX-License-Identifier: GPL-2.0-or-later
// Whether the probe itself changed in the test: by the diameter of each bore, which a machine that grows does
// not change.
#pragma once

#include "components/commissioning/growth/growth_visits.hpp"

#include <cmath>
#include <vector>

namespace plumb::commissioning {

struct ProbeDrift {
    struct Pass {
        int number = 0;
        double time = 0;    // s
        double change = 0;  // mm, of the diameters since the first pass; the mean over the bores
    };
    std::vector<Pass> passes;  // from the second one on; empty if no circle was probed twice
    double sigma = 0;          // mm, standard, of the least certain change

    double largest() const;
    bool seen() const { return std::abs(largest()) > 3 * sigma; }
};

// `touch`: the standard uncertainty of a touch, mm. The expansion of the artifact has been taken out of the
// diameters if it is known.
ProbeDrift probe_drift(const std::vector<GrowthVisit>& visits, double touch);

}  // namespace plumb::commissioning

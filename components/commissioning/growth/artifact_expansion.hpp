// SPDX-License-Identifier: GPL-2.0-or-later
// The expansion of the artifact by its own temperature, which displaces its bores as growth of the machine
// does.
#pragma once

#include "components/commissioning/growth/growth_visits.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace plumb::commissioning {

struct ArtifactExpansion {
    bool applied = false;
    double coldest = 0, warmest = 0;   // K, of the artifact since its first touch
    Eigen::Vector3d largest{0, 0, 0};  // mm, taken out of a place along each axis
    Eigen::Vector3d uncertainty{0, 0,
                                0};  // mm, standard uncertainty of the expansion that the report subtracts
    double per_length = 0;           // the same of a strain
    std::string why_not = "the log names none";  // if it is not applied
};

// Takes the expansion out of the places of the visits, from the fixed point of the artifact on. Their
// diameters lose it, too.
ArtifactExpansion take_out_expansion(const GrowthLog& log, std::vector<GrowthVisit>& visits);

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/probe_drift.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace plumb::commissioning {

double ProbeDrift::largest() const {
    double found = 0;
    for (const Pass& pass : passes)
        if (std::abs(pass.change) > std::abs(found)) found = pass.change;
    return found;
}

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

}  // namespace plumb::commissioning

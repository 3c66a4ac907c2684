// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/artifact_expansion.hpp"

#include <algorithm>
#include <cmath>

#include "components/commissioning/growth/growth_course.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Vector3d;

// Of the difference of two readings of one sensor, with the gradients in the artifact.
constexpr double temperature_sigma = 0.2;  // K

Vector3d vector_of(const std::array<double, 3>& values) {
    return {values[0], values[1], values[2]};
}

// A point of the artifact, from the centre of the table, at an orientation.
Vector3d turned(const Vector3d& point, bool is_turned, bool trunnion) {
    if (!is_turned) return point;
    return trunnion ? Vector3d(point.x(), -point.y(), -point.z())
                    : Vector3d(-point.x(), point.y(), -point.z());
}

// The centre of the table in the positions of the axes, by the bores whose places the log has; not a number
// along an axis that shows none.
Vector3d centre_of(const GrowthLog& log, const std::vector<GrowthVisit>& visits) {
    Vector3d sum = Vector3d::Zero(), count = Vector3d::Zero();
    for (const GrowthVisit& visit : visits) {
        const auto named = log.bores.find(visit.bore);
        if (visit.turned || named == log.bores.end()) continue;
        const Vector3d from = visit.place - vector_of(named->second.place);
        for (int axis = 0; axis < 3; ++axis)
            if (std::isfinite(from[axis])) sum[axis] += from[axis], ++count[axis];
    }
    return sum.cwiseQuotient(count);
}

}  // namespace

ArtifactExpansion take_out_expansion(const GrowthLog& log, std::vector<GrowthVisit>& visits) {
    ArtifactExpansion its;
    if (!log.artifact) return its;
    GrowthSamples temperatures;
    for (const GrowthRecord& r : log.records)
        if (r.kind == GrowthRecord::temperature && r.item == log.artifact->sensor && r.at[1] != 0)
            temperatures.emplace_back(r.time, r.at[0]);
    const Vector3d centre = centre_of(log, visits), fixed = vector_of(log.artifact->fixed);
    if (temperatures.empty())
        its.why_not = "its sensor reported no valid temperature";
    else if (visits.empty())
        its.why_not = "no bore was probed";
    else if (!centre.array().isFinite().any())
        its.why_not = "the log names no place of a bore at 0\u00b0";
    else
        its.applied = true;
    if (!its.applied) return its;
    const double expansion = log.artifact->expansion * 1e-6, unsure = log.artifact->uncertainty * 1e-6;
    const double cold = value_at(temperatures, visits.front().time);
    for (GrowthVisit& visit : visits) {
        const double rise = value_at(temperatures, visit.time) - cold;
        its.coldest = std::min(its.coldest, rise);
        its.warmest = std::max(its.warmest, rise);
        // The place that was touched: the face at the second orientation is another one.
        const Vector3d from = visit.place - centre - turned(fixed, visit.turned, log.trunnion);
        for (int axis = 0; axis < 3; ++axis) {
            if (!std::isfinite(from[axis])) continue;
            const double expanded = expansion * rise * from[axis];
            visit.place[axis] -= expanded;
            its.largest[axis] = std::max(its.largest[axis], std::abs(expanded));
            its.uncertainty[axis] =
                std::max(its.uncertainty[axis],
                         std::abs(from[axis]) * std::hypot(unsure * rise, expansion * temperature_sigma));
        }
        its.per_length = std::max(its.per_length, std::hypot(unsure * rise, expansion * temperature_sigma));
        visit.diameter *= 1 - expansion * rise;
    }
    return its;
}

}  // namespace plumb::commissioning

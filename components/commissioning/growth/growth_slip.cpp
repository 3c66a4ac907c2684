// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>

#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {
namespace {

constexpr double suspect = 0.003;  // mm, scatter of the passes about a curve that a slip may explain
constexpr double explained = 0.4;  // of this scatter, that is left without the slip
constexpr std::size_t fewest = 6;  // passes

GrowthMeans part_of(const GrowthMeans& all, int part) {
    GrowthMeans its;
    for (std::size_t i = 0; i < all.pass.size(); ++i) {
        if (all.part[i] != part) continue;
        its.pass.push_back(all.pass[i]);
        its.part.push_back(part);
        its.time.push_back(all.time[i]);
        its.deviation.push_back(all.deviation[i]);
        its.compensation.push_back(all.compensation[i]);
    }
    return its;
}

std::optional<GrowthSlip> slip_in(const GrowthMeans& means, int axis, int part) {
    if (means.pass.size() < fewest) return std::nullopt;
    const auto plain = curve_of(means, axis, part);
    if (!plain || plain->noise < suspect) return std::nullopt;
    double least = explained * plain->noise;
    std::optional<GrowthSlip> found;
    // A slip before the second pass looks like quick growth, and one before the last pass like a bad seat.
    for (std::size_t k = 2; k + 1 < means.pass.size(); ++k) {
        const auto step = [&](std::size_t i) {
            return means.deviation[i][axis] - means.deviation[i - 1][axis];
        };
        const double size = step(k) - (step(k - 1) + step(k + 1)) / 2;
        GrowthMeans without = means;
        for (std::size_t i = k; i < without.pass.size(); ++i) without.deviation[i][axis] -= size;
        const auto curve = curve_of(without, axis, part);
        if (!curve || curve->noise >= least || std::abs(size) < 4 * curve->noise) continue;
        least = curve->noise;
        found = {means.pass[k], size};
    }
    return found;
}

}  // namespace

void find_slips(GrowthAnalysis& analysis) {
    const GrowthMeans means = means_of(analysis, !analysis.has_off);
    for (int axis = 0; axis < 3; ++axis)
        for (int part = 0; part < analysis.parts; ++part)
            if (const auto slip = slip_in(part_of(means, part), axis, part))
                analysis.slips[static_cast<std::size_t>(axis)] = slip;
}

}  // namespace plumb::commissioning

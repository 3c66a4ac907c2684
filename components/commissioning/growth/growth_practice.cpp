// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>

#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {
namespace {

constexpr double least_distance = 20;  // mm, of two bores that show the ends of a travel

void follow_cool_down(const GrowthAnalysis& analysis, GrowthPractice& practice) {
    const GrowthMeans course = means_of(analysis, !analysis.has_off, true);
    if (course.time.size() < 2) return;
    practice.cooled_for = course.time.back() - course.time.front();
    for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(course.deviation.front()[axis])) continue;
        GrowthPractice::CoolDown its{course.deviation.front()[axis], course.deviation.back()[axis], 0};
        for (std::size_t i = 1; i < course.time.size(); ++i) {
            const double rate = (course.deviation[i][axis] - course.deviation[i - 1][axis]) /
                                std::max(course.time[i] - course.time[i - 1], 1.0) * 3600;
            if (std::abs(rate) > std::abs(its.rate)) its.rate = rate;
        }
        practice.cool_down[static_cast<std::size_t>(axis)] = its;
    }
}

void compare_ends(const GrowthAnalysis& analysis, GrowthPractice& practice) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        const GrowthSeries *low = nullptr, *high = nullptr;
        const auto place = [&](const GrowthSeries& series) {
            return analysis.log->bores.at(series.bore).place[axis];
        };
        for (const GrowthSeries& series : analysis.series) {
            if (series.compensated != !analysis.has_off || series.turned || series.points.size() < 2 ||
                analysis.log->bores.count(series.bore) == 0 ||
                !std::isfinite(series.points.back().deviation[i]))
                continue;
            if (!low || place(series) < place(*low)) low = &series;
            if (!high || place(series) > place(*high)) high = &series;
        }
        if (!low || place(*high) - place(*low) < least_distance) continue;
        GrowthPractice::Ends its;
        its.low = low->bore;
        its.high = high->bore;
        its.distance = place(*high) - place(*low);
        its.at_low = low->points.back().deviation[i];
        its.at_high = high->points.back().deviation[i];
        its.strain = (its.at_high - its.at_low) / its.distance;
        // The seat of a pass is the same at both bores.
        const GrowthBudget& budget = analysis.budgets[axis];
        its.strain_sigma =
            std::hypot(2 * std::hypot(budget.touch, budget.drift),
                       analysis.expansion.applied ? analysis.expansion.per_length * its.distance : 0.0) /
            its.distance;
        practice.ends[axis] = its;
    }
}

}  // namespace

GrowthPractice growth_practice(const GrowthAnalysis& analysis) {
    GrowthPractice practice;
    follow_cool_down(analysis, practice);
    compare_ends(analysis, practice);
    for (const auto& [sensor, samples] : analysis.temperatures) {
        const auto [low, high] = range_of(samples);
        practice.ranges.emplace_back(analysis.sensor_name(sensor), high - low);
    }
    return practice;
}

}  // namespace plumb::commissioning

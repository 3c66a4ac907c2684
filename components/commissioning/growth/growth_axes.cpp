// SPDX-License-Identifier: GPL-2.0-or-later
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "components/commissioning/growth/growth_steps.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Vector3d;
constexpr double none = GrowthVisit::none;
constexpr double hour = 3600;

double at(const GrowthSeries& series, int axis, double time) {
    const auto& points = series.points;
    if (points.empty() || time > points.back().time + 60) return none;
    for (std::size_t i = 1; i < points.size(); ++i) {
        if (points[i].time < time && i + 1 < points.size()) continue;
        if (points[i].part != points[i - 1].part) return none;
        const double share = std::clamp(
            (time - points[i - 1].time) / std::max(points[i].time - points[i - 1].time, 1.0), 0.0, 1.0);
        return (1 - share) * points[i - 1].deviation[axis] + share * points[i].deviation[axis];
    }
    return points.front().deviation[axis];
}

double larger(double a, double b) {
    return !std::isfinite(a) || std::abs(b) > std::abs(a) ? b : a;
}

// How far a bore has moved in the last hour, and in the pass before it; not a number if it began later.
double last_hour(const GrowthSeries& series, int axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    const GrowthPoint& last = series.points.back();
    for (auto point = series.points.rbegin(); point != series.points.rend(); ++point) {
        if (point->part != last.part || !std::isfinite(point->deviation[axis])) return none;
        low = std::min(low, point->deviation[axis]);
        high = std::max(high, point->deviation[axis]);
        if (last.time - point->time >= hour) return high - low;
    }
    return none;
}

// Of the state that decides when the machine is warm.
void measure_last_hour(GrowthAnalysis& analysis) {
    analysis.last_hour = none;
    for (const GrowthSeries& series : analysis.series)
        for (int axis = 0; axis < 3 && series.compensated == !analysis.has_off; ++axis)
            if (const double moved = last_hour(series, axis); std::isfinite(moved))
                analysis.last_hour = larger(analysis.last_hour, moved);
}

}  // namespace

void make_series(const std::vector<GrowthVisit>& visits, GrowthAnalysis& analysis) {
    std::map<GrowthVisit::Key, std::vector<const GrowthVisit*>> keyed;
    for (const GrowthVisit& visit : visits) keyed[visit.key()].push_back(&visit);
    std::set<int> without;
    for (const auto& [key, all] : keyed) {
        GrowthSeries series;
        std::tie(series.bore, series.turned, series.compensated) = key;
        const auto named = analysis.log->bores.find(series.bore);
        series.sphere = named != analysis.log->bores.end() && named->second.sphere;
        if (all.front()->pass > 1) {
            without.insert(series.bore);
            continue;
        }
        for (const GrowthVisit* visit : all)
            (visit->cooling_down ? series.cool_down : series.points)
                .push_back({visit->pass, visit->part, visit->time, visit->place - all.front()->place,
                            visit->compensation, visit->diameter, visit->scatter});
        (series.compensated ? analysis.has_on : analysis.has_off) = true;
        analysis.series.push_back(std::move(series));
    }
    for (const int bore : without)
        analysis.notes.push_back(
            "Bore " + std::to_string(bore) +
            " was not probed in the first pass in each state: it has no reference there.");
}

GrowthMeans means_of(const GrowthAnalysis& analysis, bool compensated, bool cooling) {
    std::map<std::pair<int, int>, std::tuple<Vector3d, Vector3d, double, int>> sums;  // by pass and part
    int series = 0;
    for (const GrowthSeries& each : analysis.series) {
        if (each.compensated != compensated) continue;
        ++series;
        std::vector<GrowthPoint> points = cooling ? each.cool_down : each.points;
        if (cooling) points.push_back(each.points.back());
        for (const GrowthPoint& point : points) {
            auto& [d, c, time, count] =
                sums.try_emplace({point.pass, point.part}, Vector3d::Zero(), Vector3d::Zero(), 0.0, 0)
                    .first->second;
            d += point.deviation;
            c += point.compensation;
            time = point.time;
            ++count;
        }
    }
    GrowthMeans means;
    for (const auto& [key, sum] : sums) {
        const auto& [d, c, time, count] = sum;
        if (count < series) continue;  // a pass that was interrupted
        means.pass.push_back(key.first);
        means.part.push_back(key.second);
        means.time.push_back(time);
        means.deviation.push_back(d / count);
        means.compensation.push_back(c / count);
    }
    return means;
}

void measure_axes(GrowthAnalysis& analysis) {
    for (const bool compensated : {false, true}) {
        const GrowthMeans means = means_of(analysis, compensated);
        for (int axis = 0; axis < 3; ++axis) {
            GrowthOfAxis& its = (compensated ? analysis.on : analysis.off)[static_cast<std::size_t>(axis)];
            its.at_1_hour = its.at_4_hours = its.at_end = none;
            for (const GrowthSeries& series : analysis.series) {
                if (series.compensated != compensated) continue;
                double low = 0, high = 0;
                for (std::size_t i = 0; i < series.points.size(); ++i) {
                    const double d = series.points[i].deviation[axis];
                    if (!std::isfinite(d)) continue;
                    its.probed = true;
                    its.largest = std::max(its.largest, std::abs(d));
                    low = std::min(low, d);
                    high = std::max(high, d);
                    if (i == 0 || series.points[i].part != series.points[i - 1].part) continue;
                    const double step = (d - series.points[i - 1].deviation[axis]) /
                                        std::max(series.points[i].time - series.points[i - 1].time, 1.0) *
                                        hour;
                    if (std::abs(step) > std::abs(its.rate)) its.rate = step;
                }
                its.range = std::max(its.range, high - low);
                const double first = series.points.front().time;
                its.at_1_hour = larger(its.at_1_hour, at(series, axis, first + hour));
                its.at_4_hours = larger(its.at_4_hours, at(series, axis, first + 4 * hour));
                its.at_end = larger(its.at_end, series.points.back().deviation[axis]);
            }
            if (!its.probed) continue;
            its.curve = curve_of(means, axis, analysis.parts - 1);
        }
    }
    measure_last_hour(analysis);
}

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_law_search.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Usual sizes of the coefficients: a metre of steel grows by 11.5 um/K, a metre of aluminium by 23. A common
// change moves the tip and the work alike, and leaves a small difference.
constexpr double usual_growth = 0.010, usual_common = 0.003;  // mm/K
constexpr double usual_slope = 12e-6;                         // 1/K
constexpr double usual_by_speed = 0.05;                       // mm
// No machine has more.
constexpr double most_growth = 0.020, most_slope = 30e-6, most_by_speed = 0.15;

constexpr double least_travel = 20;  // mm, of bores whose places determine a slope
constexpr double cost = 1.3;         // by which a term has to improve the prediction
constexpr double cost_of_speed = 2;  // the same: friction depends on grease, preload and load

GrowthSamples driven(const GrowthSamples& speeds, const SpindleDrive::Settings& settings) {
    GrowthSamples result;
    SpindleDrive drive;
    double before = speeds.front().first, speed = 0;
    for (const auto& [time, next] : speeds) {
        if (time > before) drive.step(speed, settings, time - before);
        speed = next;
        before = time;
        result.emplace_back(time, drive.value());
    }
    return result;
}

AxisLaw fit(const GrowthObservations& data, int axis, const LawForm& form, double power) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < data.values.size(); ++i)
        if (std::isfinite(data.values[i].place[axis])) rows.push_back(i);
    const auto count = static_cast<Index>(rows.size());
    const auto chosen = static_cast<Index>(form.sensors.size());
    const Index all = chosen + (data.structure ? 1 : 0);
    const auto [low, high] = travel_of(data, axis);
    AxisLaw result;
    result.form = form;
    if (data.course->places) {
        result.pivot = std::round((low + high) / 2) + 0.0;  // no -0
        result.travel = std::ceil((high - low) / 2);
    }
    // k of the sensors and of the structure, b of them, s; and the expansion of the artifact, from its clamp,
    // which is not used
    const Index slopes = form.slope ? all : 0, speeds = form.speed ? 1 : 0;
    const Index own = data.artifact ? (data.course->places ? 2 : 1) : 0;
    GrowthVisits its;
    its.terms.resize(count, all + slopes + speeds + own);
    its.growth.resize(count);
    its.weight.resize(count);
    VectorXd usual(its.terms.cols());
    usual.head(all).setConstant(usual_growth);
    if (data.structure) usual[chosen] = usual_common;
    usual.segment(all, slopes).setConstant(usual_slope);
    usual.segment(all + slopes, speeds).setConstant(usual_by_speed);
    if (own > 0) usual[usual.size() - own] = usual_common;
    if (own > 1) usual[usual.size() - 1] = 20e-6;  // 1/K, of aluminium
    SpindleDrive::Settings settings;
    settings.turning_time = form.turning;
    settings.stopped_time = form.stopped;
    settings.exponent = power;
    const GrowthSamples drive = form.speed ? driven(data.course->speeds, settings) : GrowthSamples();
    for (Index i = 0; i < count; ++i) {
        const std::size_t row = rows[static_cast<std::size_t>(i)];
        const GrowthCourse::Value& value = data.values[row];
        const double from_pivot = value.place[axis] - result.pivot;
        for (Index s = 0; s < all; ++s) {
            const double rise =
                s < chosen ? data.rise(data.sensors[form.sensors[static_cast<std::size_t>(s)]], value.time)
                           : data.common(value.time);
            its.terms(i, s) = rise;
            if (form.slope) its.terms(i, all + s) = rise * from_pivot;
        }
        if (form.speed) its.terms(i, all + slopes) = value_at(drive, value.time);
        if (own > 0) {
            const double rise = value_at(data.artifact->samples, value.time) - data.reference(*data.artifact);
            its.terms(i, its.terms.cols() - own) = rise;
            if (own > 1) its.terms(i, its.terms.cols() - 1) = rise * from_pivot;
        }
        its.growth[i] = value.place[axis];
        its.weight[i] = data.weight[row];
        its.groups.push_back(value.group);
        its.duties.push_back(data.duty[row]);
    }
    result.found = identified_growth(its, usual, value_sigma);
    const VectorXd& w = result.found.value;
    const VectorXd variance = result.found.covariance.diagonal();
    result.growth = w.head(all);
    result.slope = form.slope ? VectorXd(w.segment(all, all)) : VectorXd::Zero(all);
    result.growth_sigma = VectorXd::Zero(all);
    const double share = result.found.share;
    for (Index s = 0; s < all; ++s) {
        const double by_slope = form.slope ? variance[all + s] * result.travel * result.travel : 0;
        result.growth_sigma[s] = std::sqrt(variance[s] + by_slope + std::pow(share * w[s], 2));
    }
    if (form.speed) {
        result.by_speed = w[all + slopes];
        result.speed_sigma = std::hypot(std::sqrt(variance[all + slopes]), share * result.by_speed);
    }
    const bool physical = (result.growth.head(chosen).array().abs() <= most_growth).all() &&
                          (result.slope.array().abs() <= most_slope).all() &&
                          std::abs(result.by_speed) <= most_by_speed;
    bool separate = true;
    for (Index s = 0; s < chosen && chosen > 1; ++s)
        separate &= std::abs(w[s]) > determined * std::sqrt(variance[s]);
    if (physical && separate && w.size() > own)
        result.score =
            result.found.predicted_rest * std::pow(cost, form.terms()) * (form.speed ? cost_of_speed : 1);
    return result;
}

double squares_of(const AxisLaws& laws) {
    double sum = 0;
    for (const auto& law : laws)
        if (law && std::isfinite(law->score)) sum += law->score * law->score;
    return sum;
}

// Each way to choose up to `most` sensors.
std::vector<std::vector<std::size_t>> choices(std::size_t sensors, std::size_t most) {
    std::vector<std::vector<std::size_t>> all{{}};
    for (std::size_t begin = 0, size = 1; size <= std::min(most, sensors); ++size) {
        const std::size_t end = all.size();
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t s = all[i].empty() ? 0 : all[i].back() + 1; s < sensors; ++s) {
                all.push_back(all[i]);
                all.back().push_back(s);
            }
        begin = end;
    }
    return all;
}

}  // namespace

AxisLaws best_laws(const GrowthObservations& data, double power) {
    const std::size_t places = GrowthLaw::sensors - (data.structure ? 1 : 0);
    const auto subsets = choices(data.sensors.size(), data.sensors.size() > 3 ? 2 : 3);
    std::vector<std::pair<double, int>> order;
    for (int axis = 0; axis < 3; ++axis)
        if (data.measured[static_cast<std::size_t>(axis)])
            order.emplace_back(-fit(data, axis, {}, power).found.drift, axis);
    std::sort(order.begin(), order.end());
    const auto best_of = [&](int axis, std::set<std::size_t>& used, const LawForm& form) {
        AxisLaw best = fit(data, axis, form, power);
        const auto [low, high] = travel_of(data, axis);
        const bool travels = data.course->places && high - low >= least_travel;
        for (const auto& subset : subsets) {
            std::set<std::size_t> together = used;
            together.insert(subset.begin(), subset.end());
            if (together.size() > places) continue;
            for (const bool slope : {false, true}) {
                if (slope && !travels) continue;
                if (subset.empty() && !slope) continue;
                LawForm its = form;
                its.sensors = subset;
                its.slope = slope;
                AxisLaw result = fit(data, axis, its, power);
                if (result.score < best.score) best = std::move(result);
            }
        }
        used.insert(best.form.sensors.begin(), best.form.sensors.end());
        return best;
    };
    const auto laws_of = [&](const LawForm& form, const AxisLaws& without) {
        AxisLaws laws;
        std::set<std::size_t> used;
        for (const auto& [drift, axis] : order) {
            const auto at = static_cast<std::size_t>(axis);
            laws[at] = best_of(axis, used, form);
            if (without[at] && !(laws[at]->score < without[at]->score)) laws[at] = without[at];
        }
        return laws;
    };
    AxisLaws best = laws_of({}, {});
    if (!data.turned) return best;
    const AxisLaws without = best;
    for (const double turning : {150.0, 300.0, 600.0, 1200.0, 2400.0})
        for (const double ratio : {1.0, 2.0, 4.0}) {
            LawForm form;
            form.speed = true;
            form.turning = turning;
            form.stopped = ratio * turning;
            const AxisLaws with = laws_of(form, without);
            if (squares_of(with) < squares_of(best)) best = with;
        }
    return best;
}

}  // namespace plumb::commissioning

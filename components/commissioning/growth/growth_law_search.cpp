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

// A coefficient is 0 within these beforehand, and no machine has a larger one: a metre of steel grows by 11.5
// um/K, but a sensor beside a bearing may warm by a third of it.
constexpr double usual_growth = 0.050;   // mm/K
constexpr double usual_slope = 12e-6;    // 1/K
constexpr double usual_by_speed = 0.05;  // mm
// A door that opens cools the air by 3 K and no part of the machine: that may move no axis by more than 5 um.
constexpr double most_by_air = 0.005 / 3;  // mm/K
constexpr double most_growth = 0.050, most_slope = 30e-6, most_by_speed = 0.15;

constexpr double least_travel = 20;  // mm, of bores whose places determine a slope
// By which a law other than the line has to improve the prediction, for each of its terms beyond one. On the
// measured days 1.5 takes terms that make another day worse, and 2 leaves out some that help.
constexpr double cost = 1.7;

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

AxisLaw fit(const GrowthObservations& data, int axis, const LawForm& form) {
    std::vector<const GrowthObservations::Value*> values;
    for (const auto& value : data.values)
        if (std::isfinite(value.place[axis])) values.push_back(&value);
    const auto count = static_cast<Index>(values.size());
    const auto all = static_cast<Index>(form.sensors.size());
    const auto [low, high] = travel_of(data, axis);
    AxisLaw result;
    result.form = form;
    if (data.places) {
        result.pivot = std::round((low + high) / 2) + 0.0;  // no -0
        result.travel = std::ceil((high - low) / 2);
    }
    // k and b of the sensors, s; and the expansion of the artifact, from its clamp, which is not used
    const Index slopes = form.slope ? all : 0, speeds = form.speed ? 1 : 0;
    const Index own = data.artifact ? (data.places ? 2 : 1) : 0;
    GrowthVisits its;
    its.terms.resize(count, all + slopes + speeds + own);
    its.growth.resize(count);
    its.weight.resize(count);
    VectorXd usual(its.terms.cols());
    usual.head(all).setConstant(usual_growth);
    usual.segment(all, slopes).setConstant(usual_slope);
    usual.segment(all + slopes, speeds).setConstant(usual_by_speed);
    if (own > 0) usual[usual.size() - own] = 0.003;  // mm/K
    if (own > 1) usual[usual.size() - 1] = 20e-6;    // 1/K, of aluminium
    SpindleDrive::Settings settings;
    settings.turning_time = form.turning;
    settings.stopped_time = form.stopped;
    std::vector<GrowthSamples> drives;
    for (const GrowthSamples& day : data.speeds)
        drives.push_back(form.speed ? driven(day, settings) : GrowthSamples());
    for (Index i = 0; i < count; ++i) {
        const GrowthObservations::Value& value = *values[static_cast<std::size_t>(i)];
        const double from_pivot = value.place[axis] - result.pivot;
        for (Index s = 0; s < all; ++s) {
            const double rise =
                data.sensors[form.sensors[static_cast<std::size_t>(s)]].rise(value.day, value.time);
            its.terms(i, s) = rise;
            if (form.slope) its.terms(i, all + s) = rise * from_pivot;
        }
        if (form.speed) its.terms(i, all + slopes) = value_at(drives[value.day], value.time);
        if (own > 0) {
            const double rise = data.artifact->rise(value.day, value.time);
            its.terms(i, its.terms.cols() - own) = rise;
            if (own > 1) its.terms(i, its.terms.cols() - 1) = rise * from_pivot;
        }
        its.growth[i] = value.place[axis];
        its.weight[i] = value.weight;
        its.groups.push_back(value.group);
        its.blocks.push_back(value.block);
        its.days.push_back(static_cast<int>(value.day));
    }
    result.found = identified_growth(its, usual, value_sigma);
    const VectorXd& w = result.found.value;
    const VectorXd variance = result.found.covariance.diagonal();
    result.growth = w.head(all);
    result.slope = form.slope ? VectorXd(w.segment(all, all)) : VectorXd::Zero(all);
    result.growth_sigma = VectorXd::Zero(all);
    const double scale = std::min(result.found.scale, 1.0);
    for (Index s = 0; s < all; ++s) {
        const double at_end = result.slope[s] * result.travel;
        const double by_slope = form.slope ? variance[all + s] * result.travel * result.travel : 0;
        result.growth_sigma[s] =
            std::sqrt(variance[s] + by_slope + scale * scale * (w[s] * w[s] + at_end * at_end));
    }
    if (form.speed) {
        result.by_speed = w[all + slopes];
        result.speed_sigma = std::hypot(std::sqrt(variance[all + slopes]), scale * result.by_speed);
    }
    bool physical =
        (result.slope.array().abs() <= most_slope).all() && std::abs(result.by_speed) <= most_by_speed;
    bool separate = true;
    for (Index s = 0; s < all; ++s) {
        const bool air = data.sensors[form.sensors[static_cast<std::size_t>(s)]].air;
        physical &= std::abs(w[s]) <= (air ? most_by_air : most_growth);
        separate &= all == 1 || std::abs(w[s]) > determined * std::sqrt(variance[s]);
    }
    if (physical && separate) result.score = result.found.predicted_rest;
    return result;
}

double squares_of(const AxisLaws& laws) {
    double sum = 0;
    for (const auto& law : laws)
        if (law && std::isfinite(law->score)) sum += law->score * law->score;
    return sum;
}

// Each way to choose up to `most` sensors, of few at first.
std::vector<std::vector<std::size_t>> choices(std::size_t sensors, std::size_t most) {
    std::vector<std::vector<std::size_t>> all{{}};
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t s = all[i].empty() ? 0 : all[i].back() + 1; s < sensors; ++s) {
            if (all[i].size() == most) break;
            std::vector<std::size_t> its = all[i];
            its.push_back(s);
            all.push_back(std::move(its));
        }
    return all;
}

// A law that is neither no law nor the line has to be better by far.
double price(const LawForm& form) {
    return std::pow(cost, std::max(form.terms() - 1, 1));
}

bool beats(const AxisLaw& law, const AxisLaw& rival) {
    const auto &its = law.found.block_rests, &others = rival.found.block_rests;
    return std::equal(its.begin(), its.end(), others.begin(), others.end(),
                      [](double a, double b) { return a < b; });
}

}  // namespace

AxisLaws best_laws(const GrowthObservations& data) {
    const auto subsets = choices(data.sensors.size(), data.sensors.size() > 3 ? 2 : 3);
    std::vector<std::pair<double, int>> order;
    for (int axis = 0; axis < 3; ++axis)
        if (data.measured[static_cast<std::size_t>(axis)])
            order.emplace_back(-fit(data, axis, {}).found.drift, axis);
    std::sort(order.begin(), order.end());
    const auto best_of = [&](int axis, std::set<std::size_t>& used, const LawForm& form) {
        const auto fits = [&](const std::vector<std::size_t>& subset) {
            std::set<std::size_t> together = used;
            together.insert(subset.begin(), subset.end());
            return together.size() <= GrowthLaw::sensors;
        };
        const AxisLaw none = fit(data, axis, {});
        // The rivals: no law, and the line that fits the whole best.
        AxisLaw line = none;
        for (std::size_t s = 0; s < data.sensors.size(); ++s) {
            if (!fits({s})) continue;
            AxisLaw its = fit(data, axis, {{s}});
            if (line.form.sensors.empty() || its.found.rest < line.found.rest) line = std::move(its);
        }
        AxisLaw best = line.score < none.score ? line : none;
        const auto [low, high] = travel_of(data, axis);
        const bool travels = data.places && high - low >= least_travel;
        for (const auto& subset : subsets) {
            if (!fits(subset)) continue;
            for (const bool speed : {false, true})
                for (const bool slope : {false, true}) {
                    if ((slope && (!travels || subset.empty())) || (speed && !form.speed)) continue;
                    LawForm its = form;
                    its.sensors = subset;
                    its.slope = slope;
                    its.speed = speed;
                    if (its.terms() == 0) continue;
                    AxisLaw law = fit(data, axis, its);
                    law.score *= price(its);
                    if (law.score < best.score && beats(law, none) && beats(law, line)) best = std::move(law);
                }
        }
        used.insert(best.form.sensors.begin(), best.form.sensors.end());
        best.none = none.found.predicted_rest;
        best.line = line.found.predicted_rest;
        return best;
    };
    const auto laws_of = [&](const LawForm& form) {
        AxisLaws laws;
        std::set<std::size_t> used;
        for (const auto& [drift, axis] : order)
            laws[static_cast<std::size_t>(axis)] = best_of(axis, used, form);
        return laws;
    };
    AxisLaws best = laws_of({});
    if (!data.turned) return best;
    for (const double turning : {150.0, 300.0, 600.0, 1200.0, 2400.0})
        for (const double ratio : {1.0, 2.0, 4.0}) {
            LawForm form;
            form.speed = true;
            form.turning = turning;
            form.stopped = ratio * turning;
            const AxisLaws with = laws_of(form);
            if (squares_of(with) < squares_of(best)) best = with;
        }
    return best;
}

}  // namespace plumb::commissioning

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/turning/cut_fit.hpp"
#include "components/math/turning/entry_slip.hpp"
#include "components/math/turning/land_pair.hpp"
#include "components/math/turning/prediction.hpp"
#include "components/math/turning/two_cuts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// Height of a tip from its cuts, by the method that the settings choose.
struct TipHeight {
    using Settings = HeightSettings::Values;

    bool valid = false;
    bool signed_ = false;
    double height = 0;  // at Y = 0, or |height| if the sign is unknown
    double sigma = 0, within = 0;
    double x = 0, sigma_x = 0, theta = 0;  // at the first cut, theta in rad
    double by_diameter_1 = 0, by_diameter_2 = 0, by_travel = 0;
    double disagreement = 0;        // in sigmas
    double predicted = 0;           // diameter of the last cut, by the estimate
    double bias_y = 0, bias_x = 0;  // by a burr that no other cut shows; of two cuts, that of y squared
    std::uint32_t rejected = 0;     // a bit for each cut that is an outlier
    Detail fault = Detail::none;

    // What an entry may be. A tool on centre would leave `expected`, steps of Y included. X is the programmed
    // one, or that of the announced lands.
    static Detail slip(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        const SkewedAxes axes(settings.angle);
        const double y = cuts[i].y;
        const double x = settings.x_is_radius && cuts.programmed(i) > 0 ? cuts.programmed(i)
                         : settings.method == Method::two_lands         ? settings.land_diameter / 2
                                                                        : 0;
        // Beside a radius as small as the errors that a tool may have there is no slip to be seen.
        const double least = std::min(settings.max_x_correction, settings.max_move) / 2;
        const double expected = x > least ? std::hypot(x + axes.x_of(y), axes.height_of(y)) : 0;
        switch (slip_of(cuts[i].radius, expected)) {
            case EntrySlip::not_positive: return Detail::diameter;
            case EntrySlip::radius: return Detail::radius;
            case EntrySlip::doubled: return Detail::doubled;
            case EntrySlip::inch: return Detail::inch;
            case EntrySlip::metric: return Detail::metric;
            case EntrySlip::none: break;
        }
        return Detail::none;
    }

    // The cut i, with those before it.
    static Detail refusal(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        const Cut& cut = cuts[i];
        const auto finite = [](double z) { return std::abs(z) <= HeightSettings::farthest; };
        if (!finite(cut.x) || !finite(cut.y)) return Detail::position;
        if (const Detail fault = slip(settings, cuts, i); fault != Detail::none) return fault;
        const double height = SkewedAxes(settings.angle).height_of(cut.y);
        if (!LandPair::clears(height, cut.radius, settings.clearance, settings.rubbing()))
            return Detail::clearance;
        const bool same_land = settings.air_cut_check || settings.method == Method::y_step;
        const bool deeper =
            i == 0 || (settings.inside ? cut.radius > cuts[i - 1].radius : cut.radius < cuts[i - 1].radius);
        if (same_land && !deeper) return i == 1 ? Detail::order : Detail::air_cut;
        const double stock = settings.stock_diameter / 2;
        const double depth = (settings.inside ? cut.radius - stock : stock - cut.radius);
        const double unsure = 3 * std::hypot(settings.sigmas.radius(), settings.stock_sigma / 2);
        if (stock > 0 && !(depth > unsure)) return Detail::air_cut;
        return plausible(settings, cuts, i) ? Detail::none : Detail::implausible;
    }

    // Whether a tool whose X and Y are wrong by no more than the limits can leave this radius.
    static bool plausible(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        const double programmed = cuts.programmed(i);
        if (!settings.x_is_radius || !(programmed > 0)) return true;
        const SkewedAxes axes(settings.angle);
        const double x = std::abs(programmed + axes.x_of(cuts[i].y)), dx = settings.max_x_correction;
        const double y = std::abs(axes.height_of(cuts[i].y)), dy = settings.max_move;
        const double unsure = 3 * settings.sigmas.radius();
        return cuts[i].radius >= std::hypot(std::max(x - dx, 0.0), std::max(y - dy, 0.0)) - unsure &&
               cuts[i].radius <= std::hypot(x + dx, y + dy) + unsure;
    }

    static TipHeight of(const Settings& settings, const TurnedCuts& cuts) noexcept {
        TipHeight result;
        for (std::size_t i = 0; i < cuts.count && result.fault == Detail::none; ++i)
            result.fault = refusal(settings, cuts, i);
        if (result.fault != Detail::none) return result;
        const std::size_t needed = settings.method == Method::y_step && !settings.x_known ? 3 : 2;
        if (cuts.count < needed) {
            result.fault = Detail::too_few;
            return result;
        }
        if (settings.method == Method::two_cuts)
            result.by_two_cuts(settings, cuts);
        else
            result.by_fit(settings, cuts);
        result.valid = result.fault == Detail::none;
        return result;
    }

private:
    // Of the largest unseen burr, if one stands on one cut of twelve: half of them are smaller than two
    // sigmas.
    static constexpr double burrs_in_sigma = 0.25;

    void by_two_cuts(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const double inward = settings.inside ? 1 : -1;
        const double moved = (cuts[1].x - cuts[0].x) * inward;
        const bool entered = cuts.travel != 0;
        // An entered travel in diameter is twice the travel of X.
        if (entered && moved > 0 && std::abs(cuts.travel - moved) > 0.2 * moved) {
            fault = Detail::travel_differs;
            return;
        }
        const double travel = entered ? cuts.travel : moved;
        TwoCuts two = TwoCuts::of(cuts[0].radius, cuts[1].radius, travel, settings.inside, settings.sigmas,
                                  depth_of(settings, cuts, 1) - depth_of(settings, cuts, 0));
        fault = fault_of(two.refusal);
        if (fault != Detail::none) return;
        signed_ = settings.sign != 0;
        height = two.y() * (signed_ ? settings.sign : 1);
        // A burr that no third cut shows.
        const double burr = cuts.count == 2 ? settings.largest_burr / 2 : 0;
        bias_y = std::max(std::abs(two.by_r1), std::abs(two.by_r2)) * burr;
        bias_x = std::max(cuts[0].radius, cuts[1].radius) / travel * burr;
        two.sigma_y_squared = std::hypot(two.sigma_y_squared, burrs_in_sigma * bias_y);
        sigma = two.sigma();
        within = two.floor();
        x = two.x1;
        sigma_x = std::hypot(two.sigma_x1, burrs_in_sigma * bias_x);
        theta = two.theta;
        by_diameter_1 = two.sensitivity(two.by_r1) / 2;
        by_diameter_2 = two.sensitivity(two.by_r2) / 2;
        by_travel = two.sensitivity(two.by_travel);
        if (cuts.count > 2 && !signed_) find_sign(settings, cuts, two, travel);
        if (cuts.count > 2) compare(settings, cuts, two, travel);
        correct(settings);
    }

    // A further cut, or a touch of the turned land, at another Y: the sign by which it agrees with the two,
    // if it does not agree by the other one.
    void find_sign(const Settings& settings, const TurnedCuts& cuts, const TwoCuts& two,
                   double travel) noexcept {
        const Cut& last = cuts[cuts.count - 1];
        const auto disagreement_by = [&](double side) {
            const Prediction its = expected(settings, cuts, two, travel, side * two.y());
            return its.radius > 0 ? its.disagreement(last.radius) : HUGE_VAL;
        };
        const double above = disagreement_by(1), below = disagreement_by(-1);
        signed_ = last.y != cuts[0].y && std::min(above, below) <= 3 && std::max(above, below) > 6;
        if (signed_ && below < above) height = -height;
    }

    Prediction expected(const Settings& settings, const TurnedCuts& cuts, const TwoCuts& two, double travel,
                        double y) const noexcept {
        FurtherCut last = further(settings, cuts);
        last.drifts = static_cast<double>(cuts.count) - 1;
        return predict(two, cuts[0], cuts[1], travel, settings.inside ? 1 : -1, y, sigma, last,
                       settings.sigmas);
    }

    // Predicts the last cut from the first two, and compares. Independent of the sign if Y has not moved.
    void compare(const Settings& settings, const TurnedCuts& cuts, const TwoCuts& two,
                 double travel) noexcept {
        const Prediction its = expected(settings, cuts, two, travel, height);
        if (!(its.radius > 0) || (cuts[cuts.count - 1].y != cuts[0].y && !signed_)) return;
        predicted = 2 * its.radius;
        disagreement = its.disagreement(cuts[cuts.count - 1].radius);
    }

    void by_fit(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const SkewedAxes axes(settings.angle);
        CutFit fit = fit_of(settings, cuts, cuts.count);
        // A burr: the radius is too large, and no other cut explains it as well. Two spare cuts must remain.
        const double material = settings.inside ? -1 : 1;
        for (std::size_t n = 0;
             n < cuts.count / 4 && fit.refusal == CutFit::Refusal::none && fit.excess > 3 && fit.spare > 2 &&
             fit.suspect.sigmas * material > 3 && fit.suspect.lead > 9;
             ++n) {
            rejected |= std::uint32_t{1} << fit.suspect.cut;
            fit = fit_of(settings, cuts, cuts.count);
        }
        fault = fault_of(fit.refusal);
        if (fault != Detail::none) return;
        signed_ = true;
        bias_y = fit.bias_y;
        bias_x = fit.bias_x;
        const double first = axes.height_of(cuts[0].y);
        height = fit.y - first;
        sigma = within = std::hypot(fit.sigma_y, burrs_in_sigma * bias_y);
        x = fit.x - axes.x_of(cuts[0].y);
        sigma_x = std::hypot(fit.sigma_x, burrs_in_sigma * bias_x);
        theta = std::atan2(height, x);
        disagreement = fit.excess;
        compare(settings, cuts);
        const double between = axes.height_of(cuts[1].y - cuts[0].y);
        if (cuts.count == 2 && between != 0) {
            by_diameter_1 = -cuts[0].radius / (2 * between);
            by_diameter_2 = cuts[1].radius / (2 * between);
        }
        correct(settings);
    }

    // The last cut by the others, if there are enough of them.
    void compare(const Settings& settings, const TurnedCuts& cuts) noexcept {
        if ((rejected >> (cuts.count - 1) & 1) != 0) return;
        const CutFit others = fit_of(settings, cuts, cuts.count - 1);
        if (others.refusal != CutFit::Refusal::none) return;
        const double measured = cuts[cuts.count - 1].radius;
        FurtherCut last = further(settings, cuts);
        last.drifts = 0.5 * static_cast<double>(cuts.count);
        const Prediction expected = predict(others, cuts[0].radius, measured, last, settings.sigmas);
        predicted = 2 * expected.radius;
        disagreement = std::max(disagreement, expected.disagreement(measured));
    }

    // The place of the last cut against the first one.
    static FurtherCut further(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const SkewedAxes axes(settings.angle);
        const Cut& last = cuts[cuts.count - 1];
        const double step = last.y - cuts[0].y;
        const double deeper = depth_of(settings, cuts, cuts.count - 1) - depth_of(settings, cuts, 0);
        return {last.x - cuts[0].x + axes.x_of(step), axes.height_of(step), deeper, 0};
    }

    // Depth of the last pass of a cut. Only differences count, so that lands of one stock need not know it.
    // The first cut of a land is as deep as the second if the stock is not known.
    static double depth_of(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        if (settings.at_rest) return 0;
        const double stock = settings.stock_diameter / 2;
        const bool same_land = settings.same_land();
        if (!same_land && !(stock > 0) && settings.pass_depth > 0) return settings.pass_depth;
        const double before = same_land && i > 0 ? cuts[i - 1].radius : stock;
        const double depth =
            same_land && i == 0 && !(stock > 0) ? cuts[0].radius - cuts[1].radius : before - cuts[i].radius;
        const double whole = settings.inside ? -depth : depth;
        return settings.pass_depth > 0 ? std::min(whole, settings.pass_depth) : whole;
    }

    CutFit fit_of(const Settings& settings, const TurnedCuts& cuts, std::size_t count) const noexcept {
        std::array<Cut, CutFit::most> its = cuts.cuts;
        for (std::size_t i = 0; i < count; ++i) {
            its[i].depth = depth_of(settings, cuts, i);
            its[i].rejected = (rejected >> i & 1) != 0;
        }
        return CutFit::of(its.data(), count, SkewedAxes(settings.angle), settings.sigmas,
                          {settings.known_x, settings.known_x_sigma, settings.x_known},
                          settings.method == Method::two_lands, settings.largest_burr / 2);
    }

    // For the habits of a machine.
    void correct(const Settings& settings) noexcept {
        height = settings.correction_offset + settings.correction_factor * height;
        sigma *= settings.correction_factor;
    }

    static Detail fault_of(TwoCuts::Refusal refusal) noexcept {
        switch (refusal) {
            case TwoCuts::Refusal::order: return Detail::order;
            case TwoCuts::Refusal::travel: return Detail::travel;
            case TwoCuts::Refusal::short_travel: return Detail::short_travel;
            case TwoCuts::Refusal::long_travel: return Detail::long_travel;
            case TwoCuts::Refusal::past_centre: return Detail::past_centre;
            case TwoCuts::Refusal::none: break;
        }
        return Detail::none;
    }

    static Detail fault_of(CutFit::Refusal refusal) noexcept {
        switch (refusal) {
            case CutFit::Refusal::too_few: return Detail::too_few;
            case CutFit::Refusal::no_step: return Detail::no_step;
            case CutFit::Refusal::no_solution: return Detail::no_solution;
            case CutFit::Refusal::none: break;
        }
        return Detail::none;
    }
};

}  // namespace plumb

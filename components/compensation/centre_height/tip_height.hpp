// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/math/turning/cut_fit.hpp"
#include "components/math/turning/entry_slip.hpp"
#include "components/math/turning/land_pair.hpp"
#include "components/math/turning/two_cuts.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// The cuts of a procedure. X is outward, Y against the position for which the height is wanted; lengths in
// mu.
struct TurnedCuts {
    std::array<Cut, CutFit::most> cuts;
    std::size_t count = 0;
    double x_zero = 0;  // X at which the control has the axis, outward
    double travel = 0;  // of X between the first two cuts, as entered; 0 if not

    const Cut& operator[](std::size_t i) const noexcept { return cuts[i]; }
    double programmed(std::size_t i) const noexcept { return cuts[i].x - x_zero; }
};

// Height of a tip from its cuts, by the method that the settings choose.
struct TipHeight {
    using Settings = HeightSettings::Values;

    bool valid = false;
    bool signed_ = false;
    double height = 0;  // at Y = 0, or |height| if the sign is unknown
    double sigma = 0, within = 0;
    double x = 0, theta = 0;  // at the first cut, theta in rad
    double by_diameter_1 = 0, by_diameter_2 = 0, by_travel = 0;
    double disagreement = 0;  // in sigmas
    double predicted = 0;     // diameter of the last cut, by the estimate
    Fault fault = Fault::none;

    // What an entry may be. A tool on centre would leave `expected`, steps of Y included. X is the programmed
    // one, or that of the announced lands.
    static Fault slip(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        const SkewedAxes axes(settings.angle);
        const double y = cuts[i].y;
        const double x = settings.x_is_radius && cuts.programmed(i) > 0 ? cuts.programmed(i)
                         : settings.method == Method::two_lands         ? settings.land_diameter / 2
                                                                        : 0;
        const double expected = x > 0 ? std::hypot(x + axes.x_of(y), axes.height_of(y)) : 0;
        switch (slip_of(cuts[i].radius, expected)) {
            case EntrySlip::not_positive: return Fault::diameter;
            case EntrySlip::radius: return Fault::radius;
            case EntrySlip::doubled: return Fault::doubled;
            case EntrySlip::inch: return Fault::inch;
            case EntrySlip::metric: return Fault::metric;
            case EntrySlip::none: break;
        }
        return Fault::none;
    }

    // The cut i, with those before it.
    static Fault refusal(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        const Cut& cut = cuts[i];
        const auto finite = [](double z) { return std::abs(z) <= HeightSettings::farthest; };
        if (!finite(cut.x) || !finite(cut.y)) return Fault::position;
        if (const Fault fault = slip(settings, cuts, i); fault != Fault::none) return fault;
        const double height = SkewedAxes(settings.angle).height_of(cut.y);
        if (!LandPair::clears(height, cut.radius, settings.clearance, settings.rubbing()))
            return Fault::clearance;
        const bool same_land = settings.air_cut_check || settings.method == Method::y_step;
        const bool deeper =
            i == 0 || (settings.inside ? cut.radius > cuts[i - 1].radius : cut.radius < cuts[i - 1].radius);
        if (same_land && !deeper) return i == 1 ? Fault::order : Fault::air_cut;
        const double stock = settings.stock_diameter / 2;
        if (stock > 0 && (settings.inside ? cut.radius <= stock : cut.radius >= stock)) return Fault::air_cut;
        return Fault::none;
    }

    static TipHeight of(const Settings& settings, const TurnedCuts& cuts) noexcept {
        TipHeight result;
        for (std::size_t i = 0; i < cuts.count && result.fault == Fault::none; ++i)
            result.fault = refusal(settings, cuts, i);
        if (result.fault != Fault::none) return result;
        const std::size_t needed = settings.method == Method::y_step && !settings.x_known ? 3 : 2;
        if (cuts.count < needed) {
            result.fault = Fault::too_few;
            return result;
        }
        if (settings.method == Method::two_cuts)
            result.by_two_cuts(settings, cuts);
        else
            result.by_fit(settings, cuts);
        result.valid = result.fault == Fault::none;
        return result;
    }

private:
    void by_two_cuts(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const double inward = settings.inside ? 1 : -1;
        const double moved = (cuts[1].x - cuts[0].x) * inward;
        const bool entered = cuts.travel != 0;
        // An entered travel in diameter is twice the travel of X.
        if (entered && moved > 0 && std::abs(cuts.travel - moved) > 0.2 * moved) {
            fault = Fault::travel_differs;
            return;
        }
        const TwoCuts two = TwoCuts::of(cuts[0].radius, cuts[1].radius, entered ? cuts.travel : moved,
                                        settings.inside, settings.sigmas);
        fault = fault_of(two.refusal);
        if (fault != Fault::none) return;
        signed_ = settings.sign != 0;
        height = two.y() * (signed_ ? settings.sign : 1);
        sigma = two.sigma();
        within = two.floor();
        x = two.x1;
        theta = two.theta;
        by_diameter_1 = two.sensitivity(two.by_r1) / 2;
        by_diameter_2 = two.sensitivity(two.by_r2) / 2;
        by_travel = two.sensitivity(two.by_travel);
        correct(settings);
        if (cuts.count > 2) compare(settings, cuts, two, entered);
    }

    // Predicts the last cut from the first two, and compares. Independent of the sign if Y has not moved.
    void compare(const Settings& settings, const TurnedCuts& cuts, const TwoCuts& two,
                 bool entered) noexcept {
        const Cut& last = cuts[cuts.count - 1];
        const SkewedAxes axes(settings.angle);
        const double step = last.y - cuts[0].y;
        const double dx = last.x - cuts[0].x + axes.x_of(step), dy = axes.height_of(step);
        const double y = two.y() * (signed_ ? settings.sign : 1);
        const double radius =
            std::sqrt(std::max((two.x1 + dx) * (two.x1 + dx) + two.y_squared + 2 * y * dy + dy * dy, 0.0));
        if (!(radius > 0) || (dy != 0 && !signed_)) return;
        predicted = 2 * radius;
        // Of r3^2 by r1, r2 and the travel, then by r3 and its own travel.
        const double outward = settings.inside ? 1 : -1;
        const double travel = entered ? cuts.travel : (cuts[1].x - cuts[0].x) * outward;
        const double per_r1 = 2 * cuts[0].radius * (1 - dx * outward / travel);
        const double per_r2 = 2 * cuts[1].radius * dx * outward / travel;
        const double per_travel = -2 * dx * (two.x1 + outward * travel) / travel;
        const double s = settings.sigmas.radius(), t = settings.sigmas.travel;
        const double of_step = 2 * (y + dy) * (dy != 0 ? settings.sigmas.step : 0);
        const double of_y = dy != 0 ? 2 * dy * sigma : 0;
        const double later =
            static_cast<double>(cuts.count) - 1;  // drifts between the first cut and the last
        const double of_drift = (per_r2 - 2 * radius * later) * settings.sigmas.drift;
        const double of_scale =
            (per_r2 * (cuts[1].radius - cuts[0].radius) - 2 * radius * (radius - cuts[0].radius)) *
            settings.sigmas.scale;
        const double noise =
            std::sqrt(per_r1 * per_r1 * s * s + per_r2 * per_r2 * s * s + per_travel * per_travel * t * t +
                      4 * radius * radius * s * s + 4 * (two.x1 + dx) * (two.x1 + dx) * t * t +
                      of_step * of_step + of_y * of_y + of_drift * of_drift + of_scale * of_scale) /
            (2 * radius);
        disagreement = std::abs(last.radius - radius) / std::max(noise, 1e-9 * radius);
    }

    void by_fit(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const SkewedAxes axes(settings.angle);
        const CutFit fit = fit_of(settings, cuts, cuts.count);
        fault = fault_of(fit.refusal);
        if (fault != Fault::none) return;
        signed_ = true;
        const double first = axes.height_of(cuts[0].y);
        height = fit.y - first;
        sigma = within = fit.sigma_y;
        x = fit.x - axes.x_of(cuts[0].y);
        theta = std::atan2(height, x);
        disagreement = fit.excess;
        predict(settings, cuts);
        const double between = axes.height_of(cuts[1].y - cuts[0].y);
        if (cuts.count == 2 && between != 0) {
            by_diameter_1 = -cuts[0].radius / (2 * between);
            by_diameter_2 = cuts[1].radius / (2 * between);
        }
        correct(settings);
    }

    // The last cut by the others, if there are enough of them.
    void predict(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const SkewedAxes axes(settings.angle);
        const CutFit others = fit_of(settings, cuts, cuts.count - 1);
        if (others.refusal != CutFit::Refusal::none) return;
        const Cut& last = cuts[cuts.count - 1];
        const double step = last.y - cuts[0].y;
        const double dx = last.x - cuts[0].x + axes.x_of(step), dy = axes.height_of(step);
        predicted = 2 * others.predicted(dx, dy);
        const double later = 0.5 * static_cast<double>(cuts.count);  // drifts from the middle of the others
        const double own = std::hypot(settings.sigmas.radius(), settings.sigmas.drift * later,
                                      settings.sigmas.scale * (last.radius - cuts[0].radius));
        const double noise = std::hypot(others.sigma_predicted(dx, dy), own, 1e-9 * last.radius);
        disagreement = std::max(disagreement, std::abs(last.radius - predicted / 2) / noise);
    }

    static CutFit fit_of(const Settings& settings, const TurnedCuts& cuts, std::size_t count) noexcept {
        return CutFit::of(cuts.cuts.data(), count, SkewedAxes(settings.angle), settings.sigmas,
                          {settings.known_x, settings.known_x_sigma, settings.x_known},
                          settings.method == Method::two_lands);
    }

    // For the habits of a machine.
    void correct(const Settings& settings) noexcept {
        height = settings.correction_offset + settings.correction_factor * height;
        sigma *= settings.correction_factor;
    }

    static Fault fault_of(TwoCuts::Refusal refusal) noexcept {
        switch (refusal) {
            case TwoCuts::Refusal::order: return Fault::order;
            case TwoCuts::Refusal::travel: return Fault::travel;
            case TwoCuts::Refusal::short_travel: return Fault::short_travel;
            case TwoCuts::Refusal::long_travel: return Fault::long_travel;
            case TwoCuts::Refusal::past_centre: return Fault::past_centre;
            case TwoCuts::Refusal::none: break;
        }
        return Fault::none;
    }

    static Fault fault_of(CutFit::Refusal refusal) noexcept {
        switch (refusal) {
            case CutFit::Refusal::too_few: return Fault::too_few;
            case CutFit::Refusal::no_step: return Fault::no_step;
            case CutFit::Refusal::no_solution: return Fault::no_solution;
            case CutFit::Refusal::none: break;
        }
        return Fault::none;
    }
};

}  // namespace plumb

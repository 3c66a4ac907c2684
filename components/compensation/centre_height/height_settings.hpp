// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/math/turning/height_sigma.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// The settings of integrator and operator.
struct HeightSettings final : hal::Group {
    using Group::Group;

    static constexpr std::size_t posts = 4;
    static constexpr double farthest = 1e5;  // mu

    hal::In<std::int32_t> method{this, "method", 1, "0 two cuts, 1 two lands, 2 step of Y, 3 any cuts."};
    hal::In<bool> inside{this, "inside", false, "Internal turning: X goes outward to cut deeper."};
    hal::In<std::int32_t> post{this, "post", 0, "Slide and spindle in use, 0 to 3."};
    hal::Row<hal::In<bool>, posts> x_reversed{this, "x-reversed", false,
                                              "The tool is on the side of -X: +X goes inward."};
    hal::Row<hal::In<bool>, posts> inverted{
        this, "inverted", false, "The tool rubs below the axis: upside down, or reversed spindle."};
    hal::Row<hal::In<double>, posts> axes_angle{this, "axes-angle", 90, "deg", "Angle from outward X to +Y."};
    hal::In<bool> x_is_radius{this, "x-is-radius", false,
                              "X less x-zero is the programmed radius; entries are compared with it."};

    hal::In<double> gauge_sigma{this, "gauge-sigma", 0.002, "mu", "Sigma of a measured diameter."};
    hal::In<double> gauge_scale_sigma{this, "gauge-scale-sigma", 0.0002, "1",
                                      "Sigma of the gauge's error per difference of two diameters."};
    hal::In<double> cut_repeatability{this, "cut-repeatability", 0.0012, "mu",
                                      "Sigma of the radius that a cut leaves, built-up edge included."};
    hal::In<double> travel_sigma{this, "travel-sigma", 0.001, "mu", "Sigma of a travel of X."};
    hal::In<double> step_sigma{this, "step-sigma", 0.002, "mu", "Sigma of a step of Y."};
    hal::In<double> drift_sigma{this, "drift-sigma", 0.0005, "mu",
                                "Sigma of the drift from cut to cut: wear, warming, lift of the spindle."};
    hal::In<bool> x_known{this, "x-known", false, "The true X of the first cut is known: known-x."};
    hal::In<double> known_x{this, "known-x", 0, "mu",
                            "True distance of the tip from the axis at cut 1, in X."};
    hal::In<double> known_x_sigma{this, "known-x-sigma", 0.002, "mu", "Sigma of known-x."};

    hal::In<double> land_step{this, "land-step", 0.2, "mu", "Largest step of Y for lands, either way."};
    hal::In<double> land_diameter{this, "land-diameter", 0, "mu", "Diameter that the lands will have."};
    hal::In<double> clearance_angle{this, "clearance-angle", 0, "deg",
                                    "Clearance of the tool; 0: unchecked."};
    hal::In<bool> air_cut_check{this, "air-cut-check", false,
                                "Each cut is on the land of the one before, and must go deeper."};
    hal::In<double> stock_diameter{this, "stock-diameter", 0, "mu",
                                   "Diameter before the cuts, for lands; 0: unchecked."};

    hal::In<bool> at_rest{this, "at-rest", false,
                          "The cuts are spring passes, without bend: the height is that at rest."};
    hal::In<double> tool{this, "program-tool", 0, "1", "Number of the tool; a new one has no bend yet."};
    hal::In<std::int32_t> sign{this, "sign", 0, "Sign of the height for two cuts: 1, -1, or 0 unknown."};
    hal::In<bool> automatic{this, "automatic", false, "Y may be moved; else the value is only shown."};
    hal::In<double> target_height{this, "target-height", 0, "mu", "Height that the tip shall have."};
    hal::In<double> correction_offset{this, "correction-offset", 0, "mu", "Added to the height."};
    hal::In<double> correction_factor{this, "correction-factor", 1, "1",
                                      "Multiplies the height before that."};
    hal::In<double> diameter_offset{this, "diameter-offset", 0, "mu", "Added to a measured diameter."};
    hal::In<double> diameter_factor{this, "diameter-factor", 1, "1", "Multiplies a diameter before that."};
    hal::In<double> max_move{this, "max-move", 0.5, "mu", "Largest move of Y."};
    hal::In<double> max_sigma{this, "max-sigma", 0.02, "mu", "Largest sigma of a height that moves Y."};
    hal::In<double> tolerance{this, "tolerance", 0.002, "mu", "Distance from target-height that is good."};
    hal::In<double> target_diameter{this, "target-diameter", 0, "mu", "Diameter to turn, for target-x."};

    struct Values {
        Method method = Method::two_lands;
        std::size_t post = 0;
        bool inside = false, outward_is_minus = false, inverted = false, x_is_radius = false, x_known = false,
             at_rest = false;
        bool air_cut_check = false, automatic = false, good = false;
        double angle = 0, clearance = 0;  // rad
        CutSigmas sigmas;
        double known_x = 0, known_x_sigma = 0, land_step = 0, land_diameter = 0, stock_diameter = 0;
        double sign = 0, target_height = 0, correction_offset = 0, correction_factor = 1;
        double diameter_offset = 0, diameter_factor = 1, max_move = 0, max_sigma = 0, tolerance = 0;
        double target_diameter = 0;

        double tool = 0;

        double radius_of(double diameter) const noexcept {
            return (diameter_offset + diameter_factor * diameter) / 2;
        }
        double outward() const noexcept { return outward_is_minus ? -1 : 1; }
        double rubbing() const noexcept { return inverted ? -1 : 1; }
    };

    // `good` is false if one of them is out of range. A program has only numbers with a point; `post_word` is
    // one more than the post, or 0.
    Values read(double post_word) noexcept {
        constexpr double degree = 0.017453292519943295;
        Values now;
        const std::int32_t its_method = method, its_sign = sign;
        const std::int32_t its_post = post_word == 0 ? std::int32_t{post}
                                      : post_word > 0.5 && post_word < 4.5
                                          ? static_cast<std::int32_t>(post_word - 0.5)
                                          : -1;
        now.good = its_method >= 0 && its_method <= 3 && its_post >= 0 &&
                   its_post < static_cast<std::int32_t>(posts) && its_sign >= -1 && its_sign <= 1;
        now.method = now.good ? static_cast<Method>(its_method) : Method::two_lands;
        now.post = now.good ? static_cast<std::size_t>(its_post) : 0;
        now.sign = its_sign;
        now.inside = inside;
        now.outward_is_minus = x_reversed[now.post];
        now.inverted = inverted[now.post];
        now.x_is_radius = x_is_radius;
        now.x_known = x_known;
        now.air_cut_check = air_cut_check;
        now.automatic = automatic;
        now.at_rest = at_rest;
        now.tool = tool;
        now.angle = axes_angle[now.post] * degree;
        now.clearance = clearance_angle * degree;
        now.sigmas.gauge = gauge_sigma;
        now.sigmas.scale = gauge_scale_sigma;
        now.sigmas.repeatability = cut_repeatability;
        now.sigmas.travel = travel_sigma;
        now.sigmas.step = step_sigma;
        now.sigmas.drift = drift_sigma;
        now.known_x = known_x;
        now.known_x_sigma = known_x_sigma;
        now.land_step = land_step;
        now.land_diameter = land_diameter;
        now.stock_diameter = stock_diameter;
        now.target_height = target_height;
        now.correction_offset = correction_offset;
        now.correction_factor = correction_factor;
        now.diameter_offset = diameter_offset;
        now.diameter_factor = diameter_factor;
        now.max_move = max_move;
        now.max_sigma = max_sigma;
        now.tolerance = tolerance;
        now.target_diameter = target_diameter;

        const auto all = [](double low, double high, std::initializer_list<double> values) {
            bool within = true;
            for (const double x : values) within &= x >= low && x <= high;
            return within;
        };
        const CutSigmas& s = now.sigmas;
        now.good =
            now.good && all(0.1, 3, {now.angle}) && all(0, 1.5, {now.clearance}) &&
            all(0, 1, {s.gauge, s.scale, s.repeatability, s.travel, s.step, s.drift, now.known_x_sigma}) &&
            all(0, farthest,
                {now.land_step, now.land_diameter, now.stock_diameter, now.max_move, now.max_sigma,
                 now.tolerance, now.target_diameter}) &&
            all(-farthest, farthest, {now.known_x}) &&
            all(-100, 100, {now.target_height, now.correction_offset, now.diameter_offset}) &&
            all(0.5, 2, {now.correction_factor, now.diameter_factor});
        return now;
    }
};

}  // namespace plumb

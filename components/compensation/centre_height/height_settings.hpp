// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/blocks/pi.hpp"
#include "hal/component.hpp"
#include "hal/turning.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// The settings of integrator and operator.
struct HeightSettings final : hal::Group {
    HeightSettings(hal::Owner owner, std::size_t posts) : Group(owner), posts_(posts) {}

private:
    const std::size_t posts_;  // their number

public:
    static constexpr std::size_t most_posts = 4;
    static constexpr double farthest = 1e5;  // mu
    static constexpr hal::Range methods{0, 4}, posts_in_use{0, 3}, signs{-1, 1};
    static constexpr hal::Range sigmas{0, 1}, lengths{0, farthest};
    static constexpr hal::Range offsets{-100, 100}, factors{0.5, 2};      // mu, 1
    static constexpr hal::Range between_axes{6, 170}, clearances{0, 85};  // deg

    hal::In<std::int32_t> method{
        this, "method", 1, "0 two cuts, 1 two lands, 2 step of Y, 3 any cuts, 4 a height from elsewhere.",
        hal::machine(methods)};
    hal::In<bool> inside{this, "inside", false, "Internal turning: X goes outward to cut deeper.",
                         hal::machine()};
    hal::In<std::int32_t> post{this, "post", 0, "Slide and spindle in use, 0 to 3.",
                               hal::machine(posts_in_use)};
    hal::Row<hal::In<bool>> x_reversed{
        this, posts_, "x-reversed", false, "The tool is on the side of -X: +X goes inward.", hal::machine()};
    hal::Row<hal::In<bool>> inverted{this,
                                     posts_,
                                     "inverted",
                                     false,
                                     "The tool rubs below the axis: upside down, or reversed spindle.",
                                     hal::machine()};
    hal::Row<hal::In<double>> axes_angle{
        this, posts_, "axes-angle", 90, "deg", "Angle from outward X to +Y.", hal::machine(between_axes)};
    hal::In<bool> x_is_radius{this, "x-is-radius", false,
                              "X less x-zero is the programmed radius; entries are compared with it.",
                              hal::must()};
    hal::Turning turning{this, x_reversed, axes_angle, x_is_radius};

    hal::In<double> gauge_sigma{
        this, "gauge-sigma", 0.002, "mu", "Sigma of a measured diameter.", hal::must(sigmas)};
    hal::In<double> gauge_scale_sigma{this,
                                      "gauge-scale-sigma",
                                      0.0002,
                                      "1",
                                      "Sigma of the gauge's error per difference of two diameters.",
                                      hal::expert(sigmas)};
    hal::In<double> cut_repeatability{this,
                                      "cut-repeatability",
                                      0.0012,
                                      "mu",
                                      "Sigma of the radius that a cut leaves, built-up edge included.",
                                      hal::machine(sigmas)};
    hal::In<double> travel_sigma{
        this, "travel-sigma", 0.001, "mu", "Sigma of a travel of X.", hal::expert(sigmas)};
    hal::In<double> step_sigma{this, "step-sigma", 0.002, "mu", "Sigma of a step of Y.", hal::expert(sigmas)};
    hal::In<double> drift_sigma{this,
                                "drift-sigma",
                                0.0005,
                                "mu",
                                "Sigma of the drift from cut to cut: wear, warming, lift of the spindle.",
                                hal::expert(sigmas)};
    hal::In<double> largest_burr{
        this,
        "largest-burr",
        0,
        "mu",
        "Largest burr on a measured diameter; a height that an unseen one could make moves nothing.",
        hal::must(sigmas)};
    hal::In<double> land_step{
        this, "land-step", 0.2, "mu", "Largest step of Y for lands, either way.", hal::must(lengths)};
    hal::In<double> land_diameter{
        this, "land-diameter", 0, "mu", "Diameter that the lands will have.", hal::machine(lengths)};
    hal::In<double> clearance_angle{
        this, "clearance-angle", 0, "deg", "Clearance of the tool; 0: unchecked.", hal::must(clearances)};
    hal::In<bool> air_cut_check{this, "air-cut-check", false,
                                "Each cut is on the land of the one before, and must go deeper.",
                                hal::machine()};
    hal::In<double> stock_diameter{this,
                                   "stock-diameter",
                                   0,
                                   "mu",
                                   "Diameter before the cuts; 0: not checked for air.",
                                   hal::machine(lengths)};
    hal::In<double> program_stock{this, "program-stock", 0, "mu",
                                  "Diameter of the stock by a word of a program; 0: the pin stock-diameter."};
    hal::In<double> pass_depth{this,
                               "pass-depth",
                               0,
                               "mu",
                               "Depth of the last pass of each cut, in radius; 0: each cut is one pass.",
                               hal::machine(lengths)};
    hal::In<double> bend_per_depth{this,
                                   "bend-per-depth",
                                   0.005,
                                   "1",
                                   "Sigma of the bend of work and tool per depth of a pass.",
                                   hal::expert(sigmas)};

    hal::In<bool> at_rest{this, "at-rest", false,
                          "The cuts are spring passes, without bend: the height is that at rest."};
    hal::In<double> tool{this, "program-tool", 0, "1", "Number of the tool; a new one has no bend yet."};
    hal::In<std::int32_t> sign{this, "sign", 0, "Sign of the height for two cuts: 1, -1, or 0 unknown.",
                               hal::machine(signs)};
    hal::In<double> program_sign{this, "program-sign", 0, "1",
                                 "Sign by a word of a program: 1, -1; 0: the pin sign."};
    hal::In<double> least_load{this,
                               "least-load",
                               0,
                               "%",
                               "Smallest load of the spindle that shows a cut; 0: the load is not wired.",
                               hal::machine(hal::Range{0, 1000})};
    hal::In<bool> without_y{this, "without-y", false,
                            "The machine has no Y: a shim raises the tool by y-move.", hal::machine()};
    hal::In<double> target_height{
        this, "target-height", 0, "mu", "Height that the tip shall have.", hal::expert(offsets)};
    hal::In<double> correction_offset{this, "correction-offset",    0,
                                      "mu", "Added to the height.", hal::expert(offsets)};
    hal::In<double> correction_factor{
        this, "correction-factor", 1, "1", "Multiplies the height before that.", hal::expert(factors)};
    hal::In<double> diameter_offset{
        this, "diameter-offset", 0, "mu", "Added to a measured diameter.", hal::expert(offsets)};
    hal::In<double> diameter_factor{
        this, "diameter-factor", 1, "1", "Multiplies a diameter before that.", hal::expert(factors)};
    hal::In<double> max_move{this, "max-move", 0.5, "mu", "Largest move of Y.", hal::must(lengths)};
    hal::In<double> max_x_correction{
        this, "max-x-correction", 0.5, "mu", "Largest correction of the tool's X.", hal::must(lengths)};
    hal::In<double> max_sigma{
        this, "max-sigma", 0.02, "mu", "Largest sigma of a height that moves Y.", hal::must(lengths)};
    hal::In<double> tolerance{
        this, "tolerance", 0.002, "mu", "Largest error of Y and X of a tool on centre.", hal::must(lengths)};
    hal::In<double> target_diameter{
        this, "target-diameter", 0, "mu", "Diameter to turn, for target-x.", hal::machine(lengths)};

    // Of a stock that was turned or ground, by a hand micrometer: a cut that is not 30 um deep is none.
    const double stock_sigma = 0.01 / hal::Owner(this).registrar().millimetres();
    const double check_depth = 0.1 / hal::Owner(this).registrar().millimetres();

    struct Values {
        Method method = Method::two_lands;
        std::size_t post = 0;
        bool inside = false, outward_is_minus = false, inverted = false, x_is_radius = false, at_rest = false;
        bool air_cut_check = false, automatic = false, table_asks = false, without_y = false, good = false;
        double angle = 0, clearance = 0;  // rad
        CutSigmas sigmas;
        double land_step = 0, land_diameter = 0, stock_diameter = 0;
        double sign = 0, target_height = 0, correction_offset = 0, correction_factor = 0;
        double diameter_offset = 0, diameter_factor = 0, max_move = 0, max_sigma = 0, tolerance = 0;
        double target_diameter = 0;
        double stock_sigma = 0, check_depth = 0, pass_depth = 0, max_x_correction = 0, largest_burr = 0,
               least_load = 0;

        double tool = 0;

        double radius_of(double diameter) const noexcept {
            return (diameter_offset + diameter_factor * diameter) / 2;
        }
        double outward() const noexcept { return outward_is_minus ? -1 : 1; }
        bool same_land() const noexcept {
            return air_cut_check || method == Method::two_cuts || method == Method::y_step;
        }
        double rubbing() const noexcept { return inverted ? -1 : 1; }
        LandPair lands() const noexcept {
            return LandPair::of(land_step, land_diameter / 2, clearance, rubbing());
        }
    };

    // `good` is false if one of them is out of range. A program has only numbers with a point; `post_word`
    // and `method_word` are one more than the post and the method, or 0.
    Values values(double post_word, double method_word) noexcept {
        constexpr double degree = pi / 180;
        Values now;
        hal::SettingsReader read;
        const std::int32_t its_method = read(method), own_post = read(post);
        const double its_post = post_word == 0 ? own_post : post_word - 1;
        const bool has_post = its_post > -0.5 && its_post < static_cast<double>(posts_) - 0.5;
        const double own_sign = read(sign), its_sign = program_sign;
        const bool has_sign = its_sign == 0 || its_sign == 1 || its_sign == -1;
        now.sign = has_sign && its_sign != 0 ? its_sign : own_sign;
        now.least_load = read(least_load);
        now.method = methods.contains(its_method) ? static_cast<Method>(its_method) : Method::two_lands;
        now.post = has_post ? static_cast<std::size_t>(its_post + 0.5) : 0;
        now.inside = inside;
        now.outward_is_minus = x_reversed[now.post];
        now.inverted = inverted[now.post];
        now.x_is_radius = x_is_radius;
        now.air_cut_check = air_cut_check;
        now.without_y = without_y;
        now.at_rest = at_rest;
        now.tool = tool;
        now.angle = read(axes_angle[now.post]) * degree;
        now.clearance = read(clearance_angle) * degree;
        now.sigmas.gauge = read(gauge_sigma);
        now.sigmas.scale = read(gauge_scale_sigma);
        now.sigmas.repeatability = read(cut_repeatability);
        now.sigmas.travel = read(travel_sigma);
        now.sigmas.step = read(step_sigma);
        now.sigmas.drift = read(drift_sigma);
        now.largest_burr = read(largest_burr);
        now.land_step = read(land_step);
        now.land_diameter = read(land_diameter);
        const double own_stock = read(stock_diameter), its_stock = program_stock;
        const bool has_stock = its_stock >= 0 && its_stock <= farthest;
        now.stock_diameter = its_stock > 0 ? its_stock : own_stock;
        now.stock_sigma = stock_sigma;
        now.check_depth = check_depth;
        now.pass_depth = read(pass_depth);
        now.sigmas.bend = read(bend_per_depth);
        now.max_x_correction = read(max_x_correction);
        now.target_height = read(target_height);
        now.correction_offset = read(correction_offset);
        now.correction_factor = read(correction_factor);
        now.diameter_offset = read(diameter_offset);
        now.diameter_factor = read(diameter_factor);
        now.max_move = read(max_move);
        now.max_sigma = read(max_sigma);
        now.tolerance = read(tolerance);
        now.target_diameter = read(target_diameter);

        const bool has_method = method_word == 0 || (method_word > 0.5 && method_word < 6.5);
        now.good = read.good() && has_post && has_method && has_stock && has_sign;
        if (now.good && method_word != 0)
            now.method = static_cast<Method>(static_cast<int>(method_word - 0.5));
        return now;
    }
};

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_procedure.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/turning/land_pair.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// The outputs of a procedure: its results, and the next act that it waits for.
struct HeightOutputs final : hal::Group {
    using Group::Group;

    hal::Out<bool> measure{this, "measure", "The last cut waits for its diameter."};
    hal::Out<std::int32_t> cut_number{this, "cut-number", "Number of cuts that have their diameter."};
    hal::Out<bool> fault{this, "fault", "Cuts or an entry are refused; detail-code gives the cause."};
    hal::Code<Detail> detail{
        this, "detail-code",
        "Why there is no height, why Y may not move, or which cuts make the height known; 0 for none."};
    hal::Out<bool> value_valid{this, "value-valid", "The height is valid."};
    hal::Out<bool> sign_known{this, "sign-known", "The height has a sign."};
    hal::Out<bool> move_allowed{this, "move-allowed", "Y may move by y-move."};
    hal::Out<bool> on_centre{
        this, "on-centre", "Y and X of the tool are within tolerance with 95 %, by cuts that met the stock."};
    hal::Out<bool> x_allowed{this, "x-allowed", "X of the tool may change by x-correction."};
    hal::Out<bool> checked_for_air{this, "checked-for-air", "The diameter of the stock is known."};
    hal::Out<std::int32_t> cuts_needed{this, "cuts-needed", "Number of cuts that detail-code asks for."};
    hal::Out<double> height{this, "height", "mu", "Height of the tip; its size if the sign is unknown."};
    hal::Out<double> size{this, "height-size", "mu", "Size of the height."};
    hal::Out<double> sigma{this, "sigma", "mu", "Sigma of the height."};
    hal::Out<double> within{this, "within", "mu", "Sigma of a height of 0: on centre within."};
    hal::Out<double> tip_x{this, "tip-x", "mu", "Distance of the tip from the axis in X, at the first cut."};
    hal::Out<double> x_sigma{this, "x-sigma", "mu", "Sigma of x-correction."};
    hal::Out<double> theta{this, "theta", "deg", "Angle of the tip above X, at the first cut."};
    hal::Out<double> by_diameter_1{this, "height-by-diameter-1", "1", "Change of height with diameter 1."};
    hal::Out<double> by_diameter_2{this, "height-by-diameter-2", "1", "Change of height with diameter 2."};
    hal::Out<double> by_travel{this, "height-by-travel", "1", "Change of height with the travel."};
    hal::Out<double> smallest_diameter{this, "smallest-diameter", "mu", "Smallest diameter at this height."};
    hal::Out<double> y_move{this, "y-move", "mu", "Move of Y to target-height."};
    hal::Out<double> x_correction{this, "x-correction", "mu",
                                  "Added to the tool's X, as a radius, if x-allowed."};
    hal::Out<double> target_x{this, "target-x", "mu", "Position of X for target-diameter, at this height."};
    hal::Out<bool> target_reachable{this, "target-reachable", "The target-diameter is above the smallest."};
    hal::Out<double> land_1_y{this, "land-1-y", "mu", "Y of the first land, against the present one."};
    hal::Out<double> land_2_y{this, "land-2-y", "mu", "Y of the second land, against the present one."};
    hal::Out<double> predicted{this, "predicted-diameter", "mu", "Diameter of the last cut, by the others."};
    hal::Out<double> disagreement{this, "disagreement", "1", "Disagreement of the cuts, in sigmas."};
    hal::Out<std::int32_t> rejected_cuts{this, "rejected-cuts",
                                         "Number of cuts that do not count, as a burr stands on them."};
    hal::Out<std::int32_t> rejected_cut{this, "rejected-cut", "Number of the first of these cuts; 0: none."};
    hal::Out<bool> bend_known{this, "bend-known", "This tool has a height under the cut and one at rest."};
    hal::Out<double> bend{this, "bend", "mu", "Height at rest less the one under the cut."};
    hal::Out<double> bend_sigma{this, "bend-sigma", "mu", "Sigma of the bend."};

    void show(const HeightProcedure& procedure, const HeightSettings::Values& now) noexcept {
        const TipHeight& result = procedure.result();
        const bool valid = result.valid;
        const auto if_valid = [valid](double x) { return valid ? x : 0; };
        measure = procedure.state() == State::measure;
        cut_number = static_cast<std::int32_t>(procedure.cuts().count);
        fault = procedure.fault() != Detail::none;
        detail = procedure.detail();
        value_valid = valid;
        sign_known = valid && result.signed_;
        const HeightVerdict& its = procedure.verdict();
        move_allowed = valid && its.y_moves;
        x_allowed = valid && its.x_changes;
        on_centre = valid && its.verdict == Verdict::on_centre;
        checked_for_air = now.good && now.stock_diameter > 0;
        cuts_needed = valid ? its.cuts_needed : 0;
        x_sigma = if_valid(result.sigma_x);
        height = if_valid(result.height);
        size = if_valid(std::abs(result.height));
        sigma = if_valid(result.sigma);
        within = if_valid(result.within);
        tip_x = if_valid(result.x);
        theta = if_valid(result.theta * (180 / pi));
        by_diameter_1 = result.by_diameter_1;
        by_diameter_2 = result.by_diameter_2;
        by_travel = result.by_travel;
        predicted = result.predicted;
        disagreement = result.disagreement;
        std::int32_t burrs = 0, first = 0;
        std::int32_t cut = 1;
        for (std::uint32_t left = result.rejected; left != 0; left >>= 1, ++cut) {
            if ((left & 1) == 0) continue;
            if (first == 0) first = cut;
            burrs += 1;
        }
        rejected_cuts = valid ? burrs : 0;
        rejected_cut = valid ? first : 0;
        smallest_diameter = if_valid(2 * std::abs(result.height));
        y_move = valid && result.signed_ ? procedure.move() : 0;
        x_correction = if_valid(procedure.correction());
        bend_known = procedure.bend().known();
        bend = procedure.bend().bend();
        bend_sigma = procedure.bend().sigma();

        const double target = now.good ? now.target_diameter / 2 : 0;
        const bool reachable = valid && target > std::abs(result.height);
        target_reachable = reachable;
        // The position of the first cut, further by the way of the tip to its new place.
        const double tip = reachable ? std::sqrt((target - result.height) * (target + result.height)) : 0;
        target_x = reachable ? (procedure.cuts()[0].x + tip - result.x) * now.outward() : 0;

        const LandPair lands =
            now.good ? LandPair::of(now.land_step, now.land_diameter / 2, now.clearance, now.rubbing())
                     : LandPair{};
        land_1_y = lands.first;
        land_2_y = lands.second;
    }
};

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/tip_height.hpp"
#include "components/compensation/centre_height/tool_bend.hpp"
#include "hal/codes.hpp"

#include <cmath>
#include <cstddef>

namespace plumb {

// The sequence from the first cut to the height: the cuts that are measured, and the next act. Lengths in mu.
struct HeightProcedure {
    using Settings = HeightSettings::Values;

    TurnedCuts cuts;
    TipHeight result;
    State state = State::idle;
    Fault fault = Fault::none;
    Hold hold = Hold::none;
    ToolBend bend;
    double move = 0, correction = 0;  // of Y, and of X
    bool on_centre = false;

    static bool known(double position) noexcept { return std::abs(position) <= HeightSettings::farthest; }

    // Y at which the height is wanted, and the X that the program calls 0.
    void begin(const Settings& now, double y, double x_zero) noexcept {
        end();
        y_origin_ = y;
        cuts.x_zero = x_zero * now.outward();
        state = State::cut;
        if (!now.good) fail(Fault::settings);
        if (!known(y_origin_) || !known(cuts.x_zero)) fail(Fault::position);
    }

    // A height is used once: the tool table must not receive it again.
    void end() noexcept {
        forget();
        cuts = TurnedCuts{};
        state = State::idle;
    }

    void interrupt() noexcept {
        if (state == State::idle || state == State::aborted) return;
        state_before_abort_ = state;
        fault_before_abort_ = fault;
        forget();
        state = State::aborted;
    }

    void go_on(const Settings& now) noexcept {
        if (state != State::aborted) return;
        state = state_before_abort_;
        fault = fault_before_abort_;
        if (state == State::known) evaluate(now);
    }

    // The tool stands at the end of a cut.
    bool take_position(const Settings& now, double x, double y) noexcept {
        if ((state != State::cut && state != State::known) || cuts.count == CutFit::most) return false;
        if (!known(x) || !known(y)) {
            fail(Fault::position);
            return false;
        }
        forget();
        Cut& cut = cuts.cuts[cuts.count];
        cut.x = x * now.outward();
        cut.y = y - y_origin_;
        state = State::measure;
        return true;
    }

    // The diameter of the cut; from the `wanted` one on, the height is computed. A slip is to be entered
    // again.
    void take_diameter(const Settings& now, double diameter, double wanted) noexcept {
        if (!now.good) return fail(Fault::settings);
        cuts.cuts[cuts.count].radius = now.radius_of(diameter);
        fault = TipHeight::slip(now, cuts, cuts.count);
        if (fault != Fault::none) return;
        cuts.count += 1;
        if (const Fault refusal = TipHeight::refusal(now, cuts, cuts.count - 1); refusal != Fault::none)
            return fail(refusal);
        state = State::cut;
        if (static_cast<double>(cuts.count) >= wanted) evaluate(now);
    }

    void evaluate(const Settings& now) noexcept {
        if (!now.good) return fail(Fault::settings);
        if (!known(cuts.travel) || cuts.travel < 0) return fail(Fault::travel);
        result = TipHeight::of(now, cuts);
        fault = result.fault;
        state = fault == Fault::none ? State::known : State::refused;
        if (!result.valid) return;
        const SkewedAxes axes(now.angle);
        const double rise = now.target_height - result.height;
        move = axes.travel_for(rise);
        correction = (cuts.programmed(0) - result.x - axes.x_of(move)) * now.outward();
        on_centre = std::abs(rise) <= now.tolerance;
        hold = reason_to_hold(now, rise);
        if (on_centre && hold == Hold::insignificant) hold = Hold::none;  // nothing is to be moved
        if (result.signed_ && hold != Hold::disagreement)
            bend.take(now.tool, now.at_rest, result.height - axes.height_of(y_origin_), result.sigma);
    }

    void fail(Fault reason) noexcept {
        forget();
        fault = reason;
        state = State::refused;
    }

private:
    void forget() noexcept {
        result = TipHeight{};
        fault = Fault::none;
    }

    // For two cuts the sigma is that of y squared, twice its root is the smallest height that counts.
    Hold reason_to_hold(const Settings& now, double rise) const noexcept {
        const bool squared = now.method == Method::two_cuts;
        const double least = squared ? 2 * result.within : 3 * result.sigma;
        const double found = squared ? std::abs(result.height) : std::abs(rise);
        return hal::first<Hold>({{!result.signed_, Hold::sign},
                                 {result.disagreement > 3, Hold::disagreement},
                                 {!(result.sigma <= now.max_sigma), Hold::sigma},
                                 {!(std::abs(move) <= now.max_move), Hold::move},
                                 {now.at_rest, Hold::at_rest},
                                 {!(found >= least), Hold::insignificant},
                                 {!now.automatic, Hold::value_only}});
    }

    double y_origin_ = 0;
    State state_before_abort_ = State::idle;
    Fault fault_before_abort_ = Fault::none;
};

}  // namespace plumb

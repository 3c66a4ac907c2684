// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/height_verdict.hpp"
#include "components/compensation/centre_height/tip_height.hpp"
#include "components/compensation/centre_height/tool_bend.hpp"
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "hal/codes.hpp"

#include <cmath>
#include <cstddef>

namespace plumb {

// The sequence from the first cut to the height: it takes orders, and shows the cuts that are measured, the
// height, and the next act. Lengths in mu.
class HeightProcedure {
public:
    using Settings = HeightSettings::Values;

    struct Entry {
        double diameter = 0;
        bool by_beam = false;
        double wanted = 0;  // number of cuts from which on the height is computed
        double travel = 0;  // of X between the first two cuts; 0: positions
    };

    const TurnedCuts& cuts() const noexcept { return cuts_; }
    const TipHeight& result() const noexcept { return result_; }
    State state() const noexcept { return state_; }
    Detail fault() const noexcept { return fault_; }
    Detail detail() const noexcept {
        if (fault_ != Detail::none) return fault_;
        if (!result_.valid) return Detail::none;
        switch (verdict_.verdict) {
            case Verdict::unsure: return verdict_.remedy != Detail::none ? verdict_.remedy : hold_;
            case Verdict::held: return hold_ != Detail::none ? hold_ : Detail::x_bounded;
            case Verdict::x: return hold_;  // of Y
            default: return Detail::none;
        }
    }
    const ToolBend& bend() const noexcept { return bend_; }
    double move() const noexcept { return move_; }              // of Y
    double correction() const noexcept { return correction_; }  // of X
    const HeightVerdict& verdict() const noexcept { return verdict_; }

    // Y at which the height is wanted, and the X that the program calls 0.
    void begin(const Settings& now, double y, double x_zero) noexcept {
        end();
        y_origin_ = y;
        cuts_.x_zero = x_zero * now.outward();
        state_ = State::cut;
        if (!now.good) fail(Detail::settings);
        if (!known(y_origin_) || !known(cuts_.x_zero)) fail(Detail::position);
    }

    // A height is used once: the tool table must not receive it again.
    void end() noexcept {
        forget();
        cuts_ = TurnedCuts{};
        state_ = State::idle;
    }

    // Refused cuts stay refused: the abort that tells LinuxCNC of them comes here, too.
    void interrupt() noexcept {
        if (state_ == State::idle || state_ == State::aborted || state_ == State::refused) return;
        state_before_abort_ = state_;
        fault_before_abort_ = fault_;
        forget();
        state_ = State::aborted;
    }

    void go_on(const Settings& now) noexcept {
        if (state_ != State::aborted) return;
        state_ = state_before_abort_;
        fault_ = fault_before_abort_;
        if (state_ == State::known) evaluate(now);
    }

    // The tool stands at the end of a cut. `load` is the largest one of the spindle since the cut before, in
    // %.
    bool take_position(const Settings& now, double x, double y, double load) noexcept {
        if ((state_ != State::cut && state_ != State::known) || cuts_.count == CutFit::most) return false;
        if (!known(x) || !known(y)) {
            fail(Detail::position);
            return false;
        }
        if (now.least_load > 0 && !now.at_rest && !(load >= now.least_load)) {
            fail(Detail::no_load);
            return false;
        }
        forget();
        Cut& cut = cuts_.cuts[cuts_.count];
        cut.x = x * now.outward();
        cut.y = y - y_origin_;
        state_ = State::measure;
        return true;
    }

    // The diameter of the cut, in state measure. A slip, or a beam without a diameter, is to be entered
    // again.
    void take_diameter(const Settings& now, const Entry& entry) noexcept {
        cuts_.travel = entry.travel;
        if (entry.by_beam && !(entry.diameter > 0)) {
            fault_ = Detail::beam;
            return;
        }
        if (!now.good) return fail(Detail::settings);
        cuts_.cuts[cuts_.count].radius = now.radius_of(entry.diameter);
        fault_ = TipHeight::slip(now, cuts_, cuts_.count);
        if (fault_ != Detail::none) return;
        cuts_.count += 1;
        if (const Detail refusal = TipHeight::refusal(now, cuts_, cuts_.count - 1); refusal != Detail::none)
            return fail(refusal);
        state_ = State::cut;
        if (static_cast<double>(cuts_.count) >= entry.wanted) evaluate(now);
    }

    // Another diameter for the cut of this number, from 1. Returns whether there is such a cut. A slip
    // changes nothing.
    bool correct(const Settings& now, const Entry& entry, double number) noexcept {
        const double count = static_cast<double>(cuts_.count);
        const bool may =
            state_ != State::idle && state_ != State::aborted && number >= 1 && number < count + 1;
        if (!may) return false;
        const std::size_t i = static_cast<std::size_t>(number) - 1;
        const double former = cuts_.cuts[i].radius;
        cuts_.cuts[i].radius = now.radius_of(entry.diameter);
        if (const Detail slip = TipHeight::slip(now, cuts_, i); slip != Detail::none || !now.good) {
            cuts_.cuts[i].radius = former;
            fault_ = now.good ? slip : Detail::settings;
            return true;
        }
        forget();
        cuts_.travel = entry.travel;
        if (state_ == State::measure) return true;  // all cuts are judged with the last one
        state_ = State::cut;
        if (count >= entry.wanted) evaluate(now);
        return true;
    }

    // The last cut, of this number from 1, waits for its diameter again. Returns whether there is such a cut.
    bool take_back(double number) noexcept {
        const bool may = state_ == State::cut || state_ == State::known || state_ == State::refused;
        if (!may || cuts_.count == 0 || number != static_cast<double>(cuts_.count)) return false;
        forget();
        cuts_.count -= 1;
        state_ = State::measure;
        return true;
    }

    // From the cuts that there are, or from keyed ones.
    void compute(const Settings& now, double travel) noexcept {
        if (state_ == State::aborted) return;
        cuts_.travel = travel;
        evaluate(now);
    }
    void compute(const Settings& now, const TurnedCuts& keyed) noexcept {
        end();
        cuts_ = keyed;
        evaluate(now);
    }

private:
    static bool known(double position) noexcept { return std::abs(position) <= HeightSettings::farthest; }

    void evaluate(const Settings& now) noexcept {
        if (!now.good) return fail(Detail::settings);
        if (!known(cuts_.travel) || cuts_.travel < 0) return fail(Detail::travel);
        result_ = TipHeight::of(now, cuts_);
        fault_ = result_.fault;
        state_ = fault_ == Detail::none ? State::known : State::refused;
        if (!result_.valid) return;
        const SkewedAxes axes(now.angle);
        const double rise = now.target_height - result_.height;
        move_ = axes.travel_for(rise);
        hold_ = reason_to_hold(now, rise);
        const double size =
            result_.signed_ ? std::abs(rise) : std::abs(now.target_height) + std::abs(result_.height);
        HeightVerdict::Asked asked;
        asked.y = {size, result_.sigma};
        const bool stays = HeightVerdict::centred(asked.y, hold_, now.tolerance);
        if (stays && hold_ != Detail::value_only) hold_ = Detail::none;
        const bool y_moves = !now.without_y && !stays && result_.signed_ && hold_ != Detail::insignificant;
        correction_ =
            correction_of_x(y_moves ? axes.x_of(move_) : 0, y_moves ? 0 : result_.height) * now.outward();
        asked.x = {std::abs(correction_), result_.sigma_x, result_.bias_x};
        asked.x_asked = now.x_is_radius && cuts_.programmed(0) > 0;
        asked.hold = hold_;
        asked.checked_for_air = now.stock_diameter > 0;
        asked.automatic = now.automatic;
        asked.without_y = now.without_y;
        asked.largest_x = now.max_x_correction;
        verdict_ = HeightVerdict::of(asked, now.tolerance);
        verdict_.ask_for_cuts(asked, now, cuts_.count, cuts_[0].radius, CutFit::most);
        if (result_.signed_ && hold_ != Detail::disagreement)
            bend_.take(now.tool, now.at_rest, result_.height - axes.height_of(y_origin_), result_.sigma);
    }

    void fail(Detail reason) noexcept {
        forget();
        fault_ = reason;
        state_ = State::refused;
    }

    void forget() noexcept {
        result_ = TipHeight{};
        verdict_ = HeightVerdict{};
        fault_ = Detail::none;
    }

    // Of a tip that Y moves in X by `moved` and that then has this height: the programmed radius is turned.
    double correction_of_x(double moved, double height) const noexcept {
        const double programmed = cuts_.programmed(0);
        const double tip = std::sqrt(std::max((programmed - height) * (programmed + height), 0.0));
        return (height != 0 && tip > 0 ? tip : programmed) - result_.x - moved;
    }

    // For two cuts the sigma is that of y squared, twice its root is the smallest height that counts.
    Detail reason_to_hold(const Settings& now, double rise) const noexcept {
        const bool squared = now.method == Method::two_cuts;
        const double least = squared ? std::sqrt(4 * result_.within * result_.within + 2 * result_.bias_y)
                                     : std::max(3 * result_.sigma, 2 * result_.bias_y);
        const double found = squared ? std::abs(result_.height) : std::abs(rise);
        return hal::first<Detail>({{!result_.signed_, now.without_y ? Detail::sign_by_shim : Detail::sign},
                                   {result_.disagreement > 3, Detail::disagreement},
                                   {!(result_.sigma <= now.max_sigma), Detail::sigma},
                                   {!(std::abs(move_) <= now.max_move), Detail::move},
                                   {now.at_rest, Detail::at_rest},
                                   {!(found >= least), Detail::insignificant},
                                   {now.without_y, Detail::shim},
                                   {!now.automatic, Detail::value_only}});
    }

    TurnedCuts cuts_;
    TipHeight result_;
    State state_ = State::idle, state_before_abort_ = State::idle;
    Detail fault_ = Detail::none, fault_before_abort_ = Detail::none;
    Detail hold_ = Detail::none;
    ToolBend bend_;
    double y_origin_ = 0, move_ = 0, correction_ = 0;
    HeightVerdict verdict_;
};

}  // namespace plumb

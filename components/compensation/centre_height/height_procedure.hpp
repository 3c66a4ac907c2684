// SPDX-License-Identifier: GPL-2.0-or-later
// From the cuts of a tool to its height, and to the next act.
//
//     HeightProcedure   the sequence: begin, then for each cut take_position and take_diameter; compute; end
//     TipHeight::of     the height by the method in force: TwoCuts or CutFit of turned_cuts.hpp
//     HeightVerdict::of whether Y and X may change, and the cuts that would decide it
//
// Each entry is judged first (slip, refusal). With the last one evaluate() computes the height, the reason
// that holds Y, the correction of X, and the verdict.
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "hal/codes.hpp"

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
    double bias_y = 0, bias_x = 0;  // error by a burr on one cut; two cuts: error of y squared
    std::uint32_t rejected = 0;     // a bit for each cut that is an outlier
    Detail fault = Detail::none;

    // Judges an entry against `expected`, the radius of a tool on centre, steps of Y included. X comes from
    // the program, or else from the announced lands.
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
        const std::size_t needed = settings.method == Method::y_step ? 3 : 2;
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
            const Prediction prediction = expected(settings, cuts, two, travel, side * two.y());
            return prediction.radius > 0 ? prediction.disagreement(last.radius) : HUGE_VAL;
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
        const Prediction prediction = expected(settings, cuts, two, travel, height);
        if (!(prediction.radius > 0) || (cuts[cuts.count - 1].y != cuts[0].y && !signed_)) return;
        predicted = 2 * prediction.radius;
        disagreement = prediction.disagreement(cuts[cuts.count - 1].radius);
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
        std::array<Cut, CutFit::most> all = cuts.cuts;
        for (std::size_t i = 0; i < count; ++i) {
            all[i].depth = depth_of(settings, cuts, i);
            all[i].rejected = (rejected >> i & 1) != 0;
        }
        return CutFit::of(all.data(), count, SkewedAxes(settings.angle), settings.sigmas,
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

// Answers about Y and about X of a tool, each by its own sigma, and the next act that they ask for.
struct HeightVerdict {
    Verdict verdict = Verdict::none;
    Detail remedy = Detail::none;
    int cuts_needed = 0;  // 0 if no number of cuts is asked for
    bool y_moves = false, x_changes = false;
    bool x_alone_unsure = false;  // no Y waits for it

    struct Asked {
        KnownError y, x;
        bool x_asked = false;  // the programmed radius is known
        Detail hold = Detail::none;
        bool checked_for_air = false, automatic = false, without_y = false;
        double largest_x = 0;  // mu
    };

    // Whether Y has its answer: on centre.
    static bool centred(const KnownError& error, Detail hold, double tolerance) noexcept {
        return (hold == Detail::none || hold == Detail::insignificant || hold == Detail::value_only ||
                no_sign(hold) || hold == Detail::shim) &&
               error.within(tolerance);
    }

    static bool no_sign(Detail hold) noexcept { return hold == Detail::sign || hold == Detail::sign_by_shim; }

    static HeightVerdict of(const Asked& asked, double tolerance) noexcept {
        HeightVerdict answer;
        const bool y_centred = centred(asked.y, asked.hold, tolerance);
        const bool x_centred = !asked.x_asked || asked.x.within(tolerance);
        answer.y_moves = asked.hold == Detail::none && !y_centred;
        // X turns the programmed diameter at the height that a tool has until it is shimmed, on either side.
        const bool height_stays = asked.without_y && (asked.hold == Detail::shim || no_sign(asked.hold));
        const bool y_answered = y_centred || answer.y_moves || height_stays;
        answer.x_alone_unsure = height_stays && asked.x_asked && !x_centred && !asked.x.significant();
        answer.x_changes =
            asked.x_asked && asked.automatic && asked.x.significant() && asked.x.size <= asked.largest_x &&
            (y_answered || asked.hold == Detail::insignificant) && (answer.y_moves || !x_centred);
        answer.verdict = answer.y_moves && answer.x_changes                  ? Verdict::both
                         : answer.y_moves                                    ? Verdict::y
                         : answer.x_changes                                  ? Verdict::x
                         : answer.x_alone_unsure                             ? Verdict::unsure
                         : !y_centred && asked.hold != Detail::insignificant ? Verdict::held
                         : !y_centred || !x_centred
                             ? (y_centred && asked.x.significant() ? Verdict::held : Verdict::unsure)
                         : !asked.checked_for_air ? Verdict::unchecked
                                                  : Verdict::on_centre;
        return answer;
    }

    // The cuts that would answer, if there is no answer yet.
    void ask_for_cuts(const Asked& asked, const HeightSettings::Values& now, std::size_t cuts, double radius,
                      std::size_t most) noexcept {
        if (verdict != Verdict::unsure && asked.hold != Detail::disagreement && asked.hold != Detail::sigma)
            return;
        // A third cut shows whether one of the first two has a burr.
        if (x_alone_unsure && now.method == Method::two_cuts) {
            remedy = cuts == 2 && asked.x.bias > 0 ? Detail::more_cuts : Detail::finer_two;
            cuts_needed = remedy == Detail::more_cuts ? 3 : 0;
            return;
        }
        const bool goes_on = now.method == Method::two_lands || now.method == Method::any_cuts;
        double count = 0;
        if (asked.hold == Detail::disagreement) {
            if (!goes_on) return;  // begin again
        } else if (goes_on) {
            const double of_y = asked.y.within(now.tolerance) ? 1 : asked.y.more_cuts(now.tolerance);
            const double of_x =
                !asked.x_asked || asked.x.within(now.tolerance) ? 1 : asked.x.more_cuts(now.tolerance);
            count = static_cast<double>(cuts) * std::max(of_y, of_x);
        } else {
            // Sigma of a pair of lands; half of the tolerance remains for the height itself.
            const double half = LandPair::of(now.land_step, radius, now.clearance, now.rubbing()).half();
            const double of_pair = radius * now.sigmas.radius() / (std::abs(half) * std::sqrt(2.0));
            count = 2 * KnownError{0, of_pair}.more_cuts(now.tolerance / 2);
        }
        constexpr double round = 4;  // the order 1 2 2 1
        count = std::max(round * std::ceil(count / round - 1e-9), round);
        if (goes_on) count = std::max(count, round * std::floor(static_cast<double>(cuts) / round + 1));
        if (!(count <= static_cast<double>(most))) {
            remedy = Detail::finer;
            return;
        }
        remedy = goes_on ? Detail::more_cuts : Detail::lands;
        cuts_needed = static_cast<int>(count);
    }
};

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

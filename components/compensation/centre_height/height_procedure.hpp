// SPDX-License-Identifier: GPL-2.0-or-later
// From the cuts of a tool to its height, and to the next act.
//
//     HeightProcedure   the sequence: begin, then for each cut take_position and take_diameter; compute; end
//     TipHeight::of     the height by the method in force: TwoCuts or CutFit of turned_cuts.hpp
//     HeightVerdict::of whether Y and X may change, and the cuts that would decide it
//     StoredHeight      what a program has stored, for the land that must show it
//
// Each entry is judged first (slip, refusal). With the last one evaluate() computes the height, the reason
// that holds Y, the correction of X, and the verdict.
//
// No answer counts before a check: a cut at a place of its own, whose diameter the others predict, which is
// none of their diameters by six sigmas, and which agrees within three. The same reading for each land, a cut
// in the air, a swapped pair and another tool do not pass. A newest cut that does not fit is asked for again,
// twice at most. After the store one land more must have the programmed diameter.
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
#include <optional>

namespace plumb {

// Height of a tip from its cuts, by the method that the settings choose.
struct TipHeight {
    using Settings = HeightSettings::Values;

    bool valid = false;
    bool signed_ = false;
    double height = 0;  // at Y = 0, or |height| if the sign is unknown
    double sigma = 0, within = 0;
    double x = 0, theta = 0;        // at the first cut, theta in rad
    double x_now = 0, sigma_x = 0;  // the same, as after the last cut
    double by_diameter_1 = 0, by_diameter_2 = 0, by_travel = 0;
    double disagreement = 0;        // in sigmas
    double spread = 1;              // by which the cuts have raised sigma
    double predicted = 0;           // diameter of the last cut, by the estimate
    double bias_y = 0, bias_x = 0;  // error by a burr on one cut; two cuts: error of y squared
    std::uint32_t rejected = 0;     // a bit for each cut that is an outlier
    std::size_t suspect = 0;        // number of the cut that contradicts the others most, from 1; 0: none
    bool suspect_sure = false;      // no other cut explains as much
    bool newest_fits = true;        // or the others contradict each other
    bool checked = false;           // by a cut whose diameter the others predict
    Detail fault = Detail::none;

    // Judges an entry against `expected`, the radius of a tool on centre, steps of Y included. X comes from
    // the program, or else from the announced lands.
    static Detail slip(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        const SkewedAxes axes(settings.angle);
        const double y = cuts[i].y;
        const double x = settings.x_is_radius && cuts.programmed(i) > 0 ? cuts.programmed(i)
                         : settings.method == Method::two_lands && settings.land_diameter > 0
                             ? settings.land_diameter / 2 + cuts[i].x - cuts[0].x
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
        x = x_now = two.x1;
        sigma_x = std::hypot(two.sigma_x1, burrs_in_sigma * bias_x);
        theta = two.theta;
        by_diameter_1 = two.sensitivity(two.by_r1) / 2;
        by_diameter_2 = two.sensitivity(two.by_r2) / 2;
        by_travel = two.sensitivity(two.by_travel);
        if (cuts.count > 2 && !signed_) find_sign(settings, cuts, two, travel);
        if (cuts.count > 2) compare(settings, cuts, two, travel);
        correct(settings);
    }

    // Of the cuts that stand where the last one does.
    static std::uint32_t last_place(const TurnedCuts& cuts) noexcept {
        const Cut& last = cuts[cuts.count - 1];
        const double near = 2e-3 * last.radius;
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < cuts.count; ++i)
            if (std::abs(cuts[i].x - last.x) <= near && std::abs(cuts[i].y - last.y) <= near)
                bits |= std::uint32_t{1} << i;
        return bits;
    }

    // Judges the last cut by the radius that the others predict; it may check them if `own`, a bit for each
    // cut, has no part in that.
    void judge_last(const TurnedCuts& cuts, const Prediction& expected, std::uint32_t own, bool may_check,
                    bool others_agree) noexcept {
        const double measured = cuts[cuts.count - 1].radius, off = expected.disagreement(measured);
        predicted = 2 * expected.radius;
        disagreement = std::max(disagreement, off);
        newest_fits = off <= 3 || !others_agree;
        if (!newest_fits && !suspect_sure) suspect = cuts.count;
        checked = may_check && off <= 3;
        for (std::size_t i = 0; i < cuts.count; ++i)
            if ((own >> i & 1) == 0)
                checked &= std::abs(cuts[i].radius - expected.radius) >= 6 * expected.sigma;
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
        judge_last(cuts, prediction, ~std::uint32_t{3}, true, true);
    }

    void by_fit(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const SkewedAxes axes(settings.angle);
        // Lands are cut at one X; a check has no part in their height.
        const std::uint32_t last = last_place(cuts);
        CutFit fit = fit_of(settings, cuts, 0);
        const CutFit others = fit_of(settings, cuts, last);
        const bool checks = others.refusal == CutFit::Refusal::none && others.sigma_y < 1e3 * fit.sigma_y;
        const std::uint32_t left_out = checks && settings.method == Method::two_lands ? last : 0;
        if (left_out != 0) fit = others;
        // A burr: the radius is too large, and no other cut explains it as well. Two spare cuts must remain.
        const double material = settings.inside ? -1 : 1;
        for (std::size_t n = 0;
             n < cuts.count / 4 && fit.refusal == CutFit::Refusal::none && fit.excess > 3 && fit.spare > 2 &&
             fit.suspect.sigmas * material > 3 && fit.suspect.lead > 9;
             ++n) {
            rejected |= std::uint32_t{1} << fit.suspect.cut;
            fit = fit_of(settings, cuts, left_out | rejected);
        }
        fault = fault_of(fit.refusal);
        if (fault != Detail::none) return;
        signed_ = true;
        suspect = fit.excess > 3 ? fit.suspect.cut + 1 : 0;
        suspect_sure = suspect > 0 && fit.suspect.lead > 9;
        spread = fit.spread;
        bias_y = fit.bias_y;
        bias_x = fit.bias_x;
        const double first = axes.height_of(cuts[0].y);
        height = fit.y - first;
        sigma = within = std::hypot(fit.sigma_y, burrs_in_sigma * bias_y);
        x = fit.x - axes.x_of(cuts[0].y);
        x_now = fit.x_now - axes.x_of(cuts[0].y);
        sigma_x = std::hypot(fit.sigma_x_now, burrs_in_sigma * bias_x);
        theta = std::atan2(height, x);
        disagreement = fit.excess;
        compare(settings, cuts, checks);
        const double between = axes.height_of(cuts[1].y - cuts[0].y);
        if (cuts.count == 2 && between != 0) {
            by_diameter_1 = -cuts[0].radius / (2 * between);
            by_diameter_2 = cuts[1].radius / (2 * between);
        }
        correct(settings);
    }

    // The last cut by the others, if there are enough of them.
    void compare(const Settings& settings, const TurnedCuts& cuts, bool checks) noexcept {
        const std::uint32_t alone = std::uint32_t{1} << (cuts.count - 1);
        if ((rejected & alone) != 0) {
            newest_fits = false;
            suspect = cuts.count;
            return;
        }
        const std::uint32_t own = checks ? last_place(cuts) : alone;
        const CutFit others = fit_of(settings, cuts, own | rejected);
        if (others.refusal != CutFit::Refusal::none) return;
        const double measured = cuts[cuts.count - 1].radius;
        FurtherCut last = further(settings, cuts);
        last.drifts = 0.5 * static_cast<double>(cuts.count);
        judge_last(cuts, predict(others, cuts[0].radius, measured, last, settings.sigmas), own | rejected,
                   checks, others.excess <= 3);
    }

    // The place of the last cut against the first one.
    static FurtherCut further(const Settings& settings, const TurnedCuts& cuts) noexcept {
        const SkewedAxes axes(settings.angle);
        const Cut& last = cuts[cuts.count - 1];
        const double step = last.y - cuts[0].y;
        const double deeper = depth_of(settings, cuts, cuts.count - 1) - depth_of(settings, cuts, 0);
        const bool travelled = std::abs(last.x - cuts[0].x) > 1e-9 * cuts[0].radius;
        return {last.x - cuts[0].x + axes.x_of(step), axes.height_of(step), deeper, 0, travelled};
    }

    // Depth of the last pass of a cut. Only differences count, so that lands of one stock need not know it.
    // The first cut of a land is as deep as the second if the stock is not known.
    static double depth_of(const Settings& settings, const TurnedCuts& cuts, std::size_t i) noexcept {
        if (settings.at_rest) return 0;
        const double stock = settings.stock_diameter / 2;
        if (cuts[i].again && !(stock > 0)) i = 0;  // the depth of the others is not known
        const bool same_land = settings.same_land() || cuts[i].again;
        if (!same_land && !(stock > 0) && settings.pass_depth > 0) return settings.pass_depth;
        const double before = same_land && i > 0 ? cuts[i - 1].radius : stock;
        const double depth =
            same_land && i == 0 && !(stock > 0) ? cuts[0].radius - cuts[1].radius : before - cuts[i].radius;
        const double whole = settings.inside ? -depth : depth;
        return settings.pass_depth > 0 ? std::min(whole, settings.pass_depth) : whole;
    }

    // Without the cuts of these bits. The last ones are left away, so that they are no part of the middle.
    static CutFit fit_of(const Settings& settings, const TurnedCuts& cuts, std::uint32_t without) noexcept {
        std::array<Cut, CutFit::most> all = cuts.cuts;
        std::size_t count = cuts.count;
        while (count > 0 && (without >> (count - 1) & 1) != 0) --count;
        for (std::size_t i = 0; i < count; ++i) {
            all[i].depth = depth_of(settings, cuts, i);
            all[i].rejected = (without >> i & 1) != 0;
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

    // Nothing is stored now.
    void wait(Verdict instead) noexcept {
        verdict = instead;
        y_moves = x_changes = false;
    }

    void ask_again(std::size_t cuts) noexcept {
        wait(Verdict::unsure);
        remedy = Detail::again;
        cuts_needed = static_cast<int>(cuts) + 1;
    }

    // An answer, or the advice of a shim, needs a check first.
    void wait_for_check(Detail hold) noexcept {
        const bool answered =
            y_moves || x_changes || verdict == Verdict::on_centre || verdict == Verdict::unchecked ||
            (verdict == Verdict::held && (hold == Detail::shim || hold == Detail::value_only));
        if (answered) wait(Verdict::check);
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

// The values that a program has stored: their uncertainty, and the error that remains. Lengths in mu.
struct StoredHeight {
    double sigma = 0, sigma_x = 0;  // of Y and X of the tip
    double height = 0, x = 0;  // of the tip that remain above the target and beyond the programmed radius
    double radius = 0;         // of the last cut
    double step = 0;           // of Y, for the land

    // The radius that a cut leaves at this programmed radius and this height above the target.
    Prediction expected(const HeightSettings::Values& now, double programmed, double above) const noexcept {
        const double x_ = programmed + x, h = now.target_height + height + above;
        const double left = std::hypot(x_, h);
        if (!(left > 0)) return {};
        const CutSigmas& s = now.sigmas;
        const double by_place =
            std::hypot(x_ / left * std::hypot(sigma_x, s.travel), h / left * std::hypot(sigma, s.step));
        return {left,
                std::hypot(by_place, std::hypot(s.radius(), 2 * s.drift), 2 * now.check_depth * s.bend)};
    }
};

// Where the next cut belongs: X as the program calls it, outward, and Y against the beginning.
struct NextCut {
    double x = 0, y = 0, radius = 0;
};

// The sequence from the first cut to the height: it takes orders, and shows the cuts that are measured, the
// height, and the next act. Lengths in mu.
class HeightProcedure {
public:
    using Settings = HeightSettings::Values;

    struct Entry {
        double diameter = 0;
        double second = 0;  // diameter at another angle; 0: not read
        double given = 0;   // as it was entered
        bool by_hand = false;
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

    bool cut_due() const noexcept {
        return state_ == State::cut ||
               (state_ == State::known && (verdict_.verdict == Verdict::check || misfit_ > 0));
    }
    // The cut that is due goes deeper into the land of the last one.
    bool check_due(const Settings& now) const noexcept {
        return state_ == State::known && cut_due() && !misfit_land(now.lands());
    }
    // A check by hand: a lobe that one reading of each land has not shown.
    bool reads_twice() const noexcept { return state_ == State::measure && cuts_[cuts_.count].again; }
    std::size_t suspect() const noexcept { return suspect_ > 0 ? suspect_ : result_.suspect; }

    // Y at which the height is wanted, and the X that the program calls 0. For the land that shows what was
    // stored the program calls this Y `program_y`.
    void begin(const Settings& now, double y, double program_y, double x_zero) noexcept {
        end();
        y_origin_ = now.method == Method::show ? y - program_y : y;
        cuts_.x_zero = x_zero * now.outward();
        state_ = now.method == Method::given ? State::measure : State::cut;
        if (now.method == Method::show && !stored_) fail(Detail::nothing_stored);
        if (now.method != Method::show) stored_.reset();
        if (!now.good) fail(Detail::settings);
        if (!known(y_origin_) || !known(cuts_.x_zero)) fail(Detail::position);
    }

    void end() noexcept {
        forget();
        cuts_ = TurnedCuts{};
        misfit_ = 0;
        refused_ = false;
        state_ = State::idle;
    }

    // A height is used once: the tool table must not receive it again.
    void store(const Settings& now) noexcept {
        std::optional<StoredHeight> all;
        if (state_ == State::known && (verdict_.y_moves || verdict_.x_changes)) {
            StoredHeight& stored = all.emplace();
            stored.sigma = result_.sigma / result_.spread;
            stored.sigma_x = result_.sigma_x / result_.spread;
            stored.height = verdict_.y_moves ? 0 : result_.height - now.target_height;
            stored.x = verdict_.x_changes ? 0 : -correction_ * now.outward();
            stored.radius = cuts_.count > 0 ? cuts_[cuts_.count - 1].radius : now.land_diameter / 2;
            const double step = std::min(2 * now.lands().half(), LandPair::steepest * stored.radius);
            stored.step = result_.signed_ ? -now.rubbing() * step : 0;  // away from the side that rubs
        }
        end();
        stored_ = all;
    }

    // Lands at their Y; else deeper into the land of the last cut: a check where the others predict it.
    NextCut next(const Settings& now) const noexcept {
        const NextCut its = place_of_next(now);
        return known(its.x) && known(its.y) && known(its.radius) ? its : NextCut{};
    }

    // Refused cuts stay refused: the abort that tells LinuxCNC of them comes here, too.
    void interrupt() noexcept {
        if (state_ == State::idle || state_ == State::aborted || state_ == State::refused) return;
        state_before_abort_ = state_;
        forget();
        state_ = State::aborted;
    }

    void go_on(const Settings& now) noexcept {
        if (state_ != State::aborted) return;
        state_ = state_before_abort_;  // an entry that was refused is told already
        if (state_ == State::known && now.method == Method::given) state_ = State::measure;
        if (state_ == State::known && now.method == Method::show) state_ = State::idle;
        if (state_ == State::known) evaluate(now);
    }

    // The tool stands at the end of a cut. `load` is the largest one of the spindle since the cut before, in
    // %.
    bool take_position(const Settings& now, double x, double y, double load) noexcept {
        const bool again = state_ == State::measure && refused_;  // of a cut that removed nothing
        const bool may =
            state_ == State::cut || again || (state_ == State::known && now.method != Method::show);
        if (!may || cuts_.count == CutFit::most) return false;
        if (!known(x) || !known(y)) {
            fail(Detail::position);
            return false;
        }
        if (now.least_load > 0 && !now.at_rest && !(load >= now.least_load)) {
            fail(Detail::no_load);
            return false;
        }
        Cut& cut = cuts_.cuts[cuts_.count];
        const bool deeper = again ? cut.again : verdict_.verdict == Verdict::check || misfit_ > 0;
        cut = Cut{};
        cut.x = x * now.outward();
        cut.y = y - y_origin_;
        cut.again = deeper;
        forget();
        refused_ = false;
        state_ = State::measure;
        return true;
    }

    // The diameter of the cut, in state measure. A slip, or a beam without a diameter, is to be entered
    // again.
    void take_diameter(const Settings& now, const Entry& entry) noexcept {
        if (now.method == Method::given) {
            if (entry.by_hand) take_height(now, entry.given);
            return;
        }
        cuts_.travel = entry.travel;
        refused_ = true;  // unless it is taken
        if (entry.by_beam && !(entry.diameter > 0)) {
            fault_ = Detail::beam;
            return;
        }
        if (!now.good) return fail(Detail::settings);
        suspect_ = cuts_.count + 1;
        if (entry.by_hand && reads_twice() && !(entry.second > 0)) {
            fault_ = Detail::second_angle;
            return;
        }
        read(now, entry, cuts_.cuts[cuts_.count]);
        fault_ = TipHeight::slip(now, cuts_, cuts_.count);
        if (fault_ != Detail::none) return;
        if (now.method == Method::show) return show(now);
        if (const Detail refusal = TipHeight::refusal(now, cuts_, cuts_.count); refusal != Detail::none) {
            const bool reading = refusal == Detail::air_cut || refusal == Detail::implausible;
            if (!(entry.by_hand && reading)) return fail(refusal);
            fault_ = refusal;  // a reading may be wrong, where a gauge is right
            return;
        }
        cuts_.count += 1;
        refused_ = false;
        suspect_ = 0;
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
        const Cut former = cuts_.cuts[i];
        if (former.again && !(entry.second > 0)) {
            fault_ = Detail::second_angle;
            return true;
        }
        read(now, entry, cuts_.cuts[i]);
        if (const Detail slip = TipHeight::slip(now, cuts_, i); slip != Detail::none || !now.good) {
            cuts_.cuts[i] = former;
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
        if (misfit_ > cuts_.count) misfit_ = 0;
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
    NextCut place_of_next(const Settings& now) const noexcept {
        const double inward = now.inside ? 1 : -1;
        NextCut its;
        if (now.method == Method::show) {
            if (!stored_) return its;
            its.radius = stored_->radius + inward * now.check_depth;
            its.y = stored_->step;
            its.x = std::sqrt(std::max(its.radius * its.radius - its.y * its.y, 0.0));
            return its;
        }
        const LandPair lands = now.lands();
        const bool is_land = now.method == Method::two_lands && (state_ == State::cut || misfit_land(lands));
        if (cuts_.count == 0 || is_land) {
            const std::size_t k = misfit_ > 0 ? cuts_.count - 1 : cuts_.count;
            if (now.method == Method::two_lands)
                its.y = k % 4 == 0 || k % 4 == 3 ? lands.first : lands.second;
            its.x = cuts_.count > 0 ? cuts_.programmed(0) : now.land_diameter / 2;
            its.radius = std::hypot(its.x, its.y);
            return its;
        }
        const SkewedAxes axes(now.angle);
        const Cut& last = cuts_[cuts_.count - 1];
        // Below all of them, so that it has the diameter of none.
        its.radius = last.radius;
        for (std::size_t i = 0; i < cuts_.count; ++i)
            its.radius =
                now.inside ? std::max(its.radius, cuts_[i].radius) : std::min(its.radius, cuts_[i].radius);
        its.radius += inward * std::max(now.check_depth, 8 * now.sigmas.radius());
        // Asked for again it is cut in the middle, where a chip shows the most.
        its.y = now.method != Method::two_lands ? last.y
                : misfit_ > 0                   ? (lands.first + lands.second) / 2
                                                : lands.check(its.radius, now.clearance, now.rubbing());
        const double height = result_.valid ? result_.height + axes.height_of(its.y) : 0;
        const double tip = std::sqrt(std::max(its.radius * its.radius - height * height, 0.0));
        // Close to the axis there is no room: between the first two cuts.
        if (!(its.radius > 0.3 * last.radius && tip > 0) && !now.inside && cuts_.count > 1) {
            its.x = (cuts_.programmed(0) + cuts_.programmed(1)) / 2;
            its.radius = (cuts_[0].radius + cuts_[1].radius) / 2;
        } else {
            its.x = result_.valid ? cuts_.programmed(0) + tip - result_.x - axes.x_of(its.y)
                                  : cuts_.programmed(cuts_.count - 1) + inward * now.check_depth;
        }
        return its;
    }

    static bool known(double position) noexcept { return std::abs(position) <= HeightSettings::farthest; }

    static void read(const Settings& now, const Entry& entry, Cut& cut) noexcept {
        cut.radius = now.radius_of(entry.diameter);
        cut.apart = 0;
        if (!(entry.second > 0)) return;
        const double second = now.radius_of(entry.second);
        cut.apart = second - cut.radius;
        cut.radius = (cut.radius + second) / 2;
    }

    // Of a bar that is not round: sigma of a diameter, by the differences of two readings beyond their own
    // sigma; larger the fewer there are.
    double lobes(double gauge) const noexcept {
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < cuts_.count; ++i) {
            sum += cuts_[i].apart * cuts_[i].apart;
            count += cuts_[i].apart != 0 ? 1 : 0;
        }
        return count > 0 ? std::sqrt(std::max(sum / count - gauge * gauge / 2, 0.0)) * (1 + 1 / count) : 0;
    }

    // Whether the cut that does not fit is the newest one: it is asked for again.
    bool misfit_land(const LandPair& lands) const noexcept {
        if (misfit_ == 0 || cuts_.count == 0) return false;
        const double y = cuts_[cuts_.count - 1].y;
        return std::min(std::abs(y - lands.first), std::abs(y - lands.second)) < 2e-3 * cuts_[0].radius &&
               std::abs(cuts_[cuts_.count - 1].x - cuts_[0].x) < 2e-3 * cuts_[0].radius;
    }

    // A height that was worked out elsewhere.
    void take_height(const Settings& now, double height) noexcept {
        if (!now.good) return fail(Detail::settings);
        if (!known(height)) return fail(Detail::implausible);
        const SkewedAxes axes(now.angle);
        forget();
        result_.valid = result_.signed_ = result_.checked = true;
        result_.height = height;
        move_ = axes.travel_for(now.target_height - height);
        correction_ = -axes.x_of(move_) * now.outward();
        hold_ = hal::first<Detail>({{!(std::abs(move_) <= now.max_move), Detail::move},
                                    {now.without_y, Detail::shim},
                                    {!now.automatic, Detail::value_only}});
        verdict_.y_moves = hold_ == Detail::none;
        verdict_.x_changes = verdict_.y_moves && std::abs(correction_) > 1e-9;
        verdict_.verdict = !verdict_.y_moves    ? Verdict::held
                           : verdict_.x_changes ? Verdict::both
                                                : Verdict::y;
        state_ = State::known;
    }

    // The land that tests the stored values.
    void show(const Settings& now) noexcept {
        const Cut& cut = cuts_[0];
        const SkewedAxes axes(now.angle);
        const double above = axes.height_of(cut.y), programmed = cuts_.programmed(0) + axes.x_of(cut.y);
        if (!stored_) return fail(Detail::nothing_stored);
        const StoredHeight stored = *stored_;
        const Prediction expected = stored.expected(now, programmed, above);
        stored_.reset();
        if (!(expected.radius > 0 && expected.disagreement(cut.radius) <= 3)) return fail(Detail::not_shown);
        cuts_.count = 1;
        result_.valid = result_.signed_ = result_.checked = true;
        result_.height = now.target_height + stored.height;
        result_.sigma = stored.sigma;
        result_.predicted = 2 * expected.radius;
        verdict_.verdict = Verdict::shown;
        state_ = State::known;
    }

    void evaluate(Settings now) noexcept {
        if (!now.good) return fail(Detail::settings);
        if (!known(cuts_.travel) || cuts_.travel < 0) return fail(Detail::travel);
        const double gauge = now.sigmas.gauge, lobed = lobes(gauge);
        now.sigmas.gauge = std::hypot(gauge, lobed);
        result_ = TipHeight::of(now, cuts_);
        fault_ = result_.fault;
        state_ = fault_ == Detail::none ? State::known : State::refused;
        if (!result_.valid) return;
        // Older cuts that now seem to have burrs may be those of the edge before it slipped.
        const std::uint32_t older = misfit_ > 0 ? (std::uint32_t{1} << (misfit_ - 1)) - 1 : 0;
        // Deeper cuts show a chip less clearly: the third one must agree the best.
        const double most = misfit_ > 0 && cuts_.count > misfit_ + 1 ? 1 : 2;
        const bool explained =
            result_.disagreement <= most && (result_.rejected & older & ~rejected_before_) == 0;
        const bool fits = result_.newest_fits && (misfit_ == 0 || explained);
        if (fits) misfit_ = 0;
        if (!fits && misfit_ == 0) misfit_ = cuts_.count;
        if (misfit_ == 0 || misfit_ == cuts_.count) rejected_before_ = result_.rejected;
        if (misfit_ > 0 && cuts_.count >= misfit_ + 2) return fail(Detail::insert);
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
        verdict_.ask_for_cuts(asked, now, cuts_.count, cuts_[0].radius, CutFit::most_asked);
        if (verdict_.verdict == Verdict::unsure && lobed > 2 * gauge) verdict_.remedy = Detail::lobes;
        if (misfit_ > 0) verdict_.ask_again(cuts_.count);
        if (!result_.checked && !now.at_rest && misfit_ == 0) verdict_.wait_for_check(hold_);
        if (result_.signed_ && hold_ != Detail::disagreement)
            bend_.take(now.tool, now.at_rest, result_.height - axes.height_of(y_origin_), result_.sigma);
    }

    void fail(Detail reason) noexcept {
        const std::size_t cut = suspect();
        forget();
        suspect_ = cut;
        fault_ = reason;
        state_ = State::refused;
    }

    void forget() noexcept {
        result_ = TipHeight{};
        verdict_ = HeightVerdict{};
        fault_ = Detail::none;
        suspect_ = 0;
    }

    // Of a tip that Y moves in X by `moved` and that then has this height: the programmed radius is turned.
    double correction_of_x(double moved, double height) const noexcept {
        const double programmed = cuts_.programmed(0);
        const double tip = std::sqrt(std::max((programmed - height) * (programmed + height), 0.0));
        return (height != 0 && tip > 0 ? tip : programmed) - result_.x_now - moved;
    }

    // For two cuts the sigma is that of y squared, twice its root is the smallest height that counts.
    Detail reason_to_hold(const Settings& now, double rise) const noexcept {
        const bool squared = now.method == Method::two_cuts;
        const double least = squared ? std::sqrt(4 * result_.within * result_.within + 2 * result_.bias_y)
                                     : std::max(KnownError::sure * result_.sigma, 2 * result_.bias_y);
        const double found = squared ? std::abs(result_.height) : std::abs(rise);
        const bool may_be_none = !(found >= least), has_other_y = cuts_[cuts_.count - 1].y != cuts_[0].y;
        return hal::first<Detail>({{!result_.signed_ && has_other_y && may_be_none, Detail::insignificant},
                                   {!result_.signed_, now.without_y ? Detail::sign_by_shim : Detail::sign},
                                   {misfit_ > 0, Detail::again},
                                   {result_.disagreement > 3, Detail::disagreement},
                                   {!(result_.sigma <= now.max_sigma), Detail::sigma},
                                   {!(std::abs(move_) <= now.max_move), Detail::move},
                                   {now.at_rest, Detail::at_rest},
                                   {may_be_none, Detail::insignificant},
                                   {now.without_y, Detail::shim},
                                   {!now.automatic, Detail::value_only}});
    }

    TurnedCuts cuts_;
    TipHeight result_;
    State state_ = State::idle, state_before_abort_ = State::idle;
    Detail fault_ = Detail::none, hold_ = Detail::none;
    bool refused_ = false;  // the entry of the cut that waits, or the one before it
    ToolBend bend_;
    double y_origin_ = 0, move_ = 0, correction_ = 0;
    std::size_t misfit_ = 0;  // number of the first of the last cuts that do not fit; 0: the last one fits
    std::uint32_t rejected_before_ = 0;  // with burrs, a bit for each, before the last cuts did not fit
    std::size_t suspect_ = 0;            // number of the cut whose reading is refused
    std::optional<StoredHeight> stored_;
    HeightVerdict verdict_;
};

}  // namespace plumb

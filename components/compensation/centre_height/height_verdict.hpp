// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/math/turning/known_error.hpp"
#include "components/math/turning/land_pair.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace plumb {

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
        HeightVerdict its;
        const bool y_centred = centred(asked.y, asked.hold, tolerance);
        const bool x_centred = !asked.x_asked || asked.x.within(tolerance);
        its.y_moves = asked.hold == Detail::none && !y_centred;
        // X turns the programmed diameter at the height that a tool has until it is shimmed, on either side.
        const bool height_stays = asked.without_y && (asked.hold == Detail::shim || no_sign(asked.hold));
        const bool y_answered = y_centred || its.y_moves || height_stays;
        its.x_alone_unsure = height_stays && asked.x_asked && !x_centred && !asked.x.significant();
        its.x_changes = asked.x_asked && asked.automatic && asked.x.significant() &&
                        asked.x.size <= asked.largest_x &&
                        (y_answered || asked.hold == Detail::insignificant) && (its.y_moves || !x_centred);
        its.verdict = its.y_moves && its.x_changes                        ? Verdict::both
                      : its.y_moves                                       ? Verdict::y
                      : its.x_changes                                     ? Verdict::x
                      : its.x_alone_unsure                                ? Verdict::unsure
                      : !y_centred && asked.hold != Detail::insignificant ? Verdict::held
                      : !y_centred || !x_centred
                          ? (y_centred && asked.x.significant() ? Verdict::held : Verdict::unsure)
                      : !asked.checked_for_air ? Verdict::unchecked
                                               : Verdict::on_centre;
        return its;
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

}  // namespace plumb

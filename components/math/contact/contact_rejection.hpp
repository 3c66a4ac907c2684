// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/displacement_law.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// Why a contact is rejected.
enum class Rejection : std::int32_t {
    none,
    blanked,
    no_reference,
    unexpected,
    feed_differs,
    time_differs,
    outside_window,
    too_large,
    beyond_gate,
    unsteady_feed,
    no_onset,
    unconfirmed,
    withdrawn,
    no_clock,
    unlike_reference,
    rises_twice,
};

// Values of pins stand in braces.
constexpr const char* sentence(Rejection rejection) {
    using R = Rejection;
    switch (rejection) {
        case R::blanked:
            return "The spindle speed changed less than blanking-time before the contact. Let the spindle "
                   "settle.";
        case R::no_reference: return "There is no reference for this program and these tools.";
        case R::unexpected:
            return "The reference has no such contact (tool {contact-tool}, operation {contact-operation}).";
        case R::feed_differs: return "The feed or the override differs from the reference.";
        case R::time_differs:
            return "The time cannot be compared: a hold or dwell stopped the tool, or the clock started "
                   "elsewhere.";
        case R::outside_window:
            return "The contact (tool {contact-tool}, operation {contact-operation}) lies farther than "
                   "window from its reference.";
        case R::too_large:
            return "The growth of the contact ({displacement}, tool {contact-tool}) differs by more than "
                   "max-correction.";
        case R::beyond_gate:
            return "The growth of the contact ({displacement}, tool {contact-tool}) differs by more than the "
                   "gate ({gate}). Look for a chip, odd stock or another tool.";
        case R::unsteady_feed:
            return "A feed hold, a stop or another override came less than 0.2 s before the contact.";
        case R::no_onset:
            return "The load has no clear rise (tool {contact-tool}, operation {contact-operation}).";
        case R::unconfirmed:
            return "The contact ({displacement}, tool {contact-tool}) is no growth as expected; the next "
                   "contacts decide.";
        case R::withdrawn:
            return "The contacts of this operation ({contact-operation}) move with the offset. Exclude it, "
                   "or learn again with a steady load.";
        case R::no_clock:
            return "By time: no clock ran. The program must set start-height or clock-start before each "
                   "plunge.";
        case R::unlike_reference:
            return "The load does not rise as at the reference (tool {contact-tool}, operation "
                   "{contact-operation}). Look for coolant, a dip or a resonance.";
        case R::rises_twice:
            return "The load rises twice before the contact: coolant, or a dip that ends? Keep the load "
                   "steady for half a second before it, or exclude the operation.";
        default: return nullptr;
    }
}

struct ContactLimits {
    double window = 0;               // mu, about the coordinate of the reference
    double feed_tolerance = 0;       // part of the feed of the reference
    double lost_time_tolerance = 0;  // s
    double steady_time = 0;          // s of steady feed before the contact
    double feed_range = 0.5;         // as feed_tolerance, by coordinate: beyond it costs certainty

    bool valid() const noexcept {
        return window >= 0 && window <= 1e3 && feed_tolerance >= 0 && feed_tolerance <= 1 &&
               feed_range >= 0 && feed_range <= 0.9 && lost_time_tolerance >= 0 &&
               lost_time_tolerance <= 1e3 && steady_time >= 0 && steady_time <= 1e3;
    }
};

// Whether two feeds, or overrides, are the same: b that of a.
inline bool alike(double b, double a, double tolerance) noexcept {
    return std::abs(b - a) <= tolerance * std::abs(a);
}

// A contact without a time has no use by time, not even as a reference.
inline bool lacks_clock(Method method, const Contact& contact) noexcept {
    return method == Method::time && !(contact.time > 0);
}

// Whether contact b can be compared with its reference a. By time a different feed is rejected and not scaled
// away: the place of a loss is unknown. By coordinate it costs certainty, see feed_sigma().
inline Rejection comparison(Method method, const Contact& b, const Contact& a,
                            const ContactLimits& limits) noexcept {
    const double tolerance =
        method == Method::time ? limits.feed_tolerance : std::max(limits.feed_tolerance, limits.feed_range);
    if (!alike(b.feed, a.feed, tolerance) || !alike(b.feed_override, a.feed_override, tolerance))
        return Rejection::feed_differs;
    if (lacks_clock(method, a) || lacks_clock(method, b)) return Rejection::no_clock;
    if (method == Method::time && !(std::abs(b.lost_time - a.lost_time) <= limits.lost_time_tolerance))
        return Rejection::time_differs;
    const double moved = b.coordinate - a.coordinate;  // of the work, or of the program's zero with it
    if (!(std::min(std::abs(moved), std::abs(moved - b.origin_since(a))) <= limits.window))
        return Rejection::outside_window;
    return Rejection::none;
}

// The load of contact b rises in another way than at its reference a, the mean of `cycles`, by so much that
// it matters: that error is none of noise, and does not go away by many contacts. A kink is as uncertain as
// the contact itself. A rise that is none of another filter either is not fitted by one. The first factor is
// that of LearningCheck.
inline bool rises_unlike(const Contact& b, const Contact& a, std::int32_t cycles, double harmless) noexcept {
    constexpr double most = 3, most_kink = 4;
    const double sigma = a.sigma * std::sqrt(static_cast<double>(cycles));
    const bool refitted = b.time_constant != a.time_constant;
    const double with_it = sigma * std::sqrt(2 * b.time_constant / a.time_constant);
    return b.sigma > (refitted ? most * with_it : std::max(most * sigma, harmless)) ||
           std::abs(b.kink - a.kink) > std::max(most_kink * sigma, harmless / 2);
}

// Standard deviation, in mu, by a feed that differs from the reference: a delay of the load that the fit does
// not know, a part of its time constant, shifts a contact by feed × delay.
inline double feed_sigma(const Contact& b, const Contact& a) noexcept {
    constexpr double unknown_delay = 0.25;  // of the time constant
    return std::abs(b.feed - a.feed) * unknown_delay * a.time_constant;
}

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/displacement_law.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// Why a contact is not believed.
enum class Rejection : std::int32_t {
    none = 0,
    blanked = 1,         // within the blanking time after a change of spindle speed
    no_reference = 2,    // nothing was learnt for this program and these tools, or it is refused
    unexpected = 3,      // the reference has no contact of this operation, tool and occurrence
    feed_differs = 4,    // from the feed or the override of the reference
    time_differs = 5,    // time method: no clock, or a feed hold, dwell, tool change or override on the way
    outside_window = 6,  // too far from the coordinate of the reference
    too_large = 7,       // a larger single correction than allowed
    beyond_gate = 8,     // larger than growth can be since the last accepted contact
    unsteady_feed = 9,   // a feed hold, a stop or another override came just before it
    no_onset = 10,       // the load has no clear rise that could be fitted
};

struct ContactLimits {
    double window = 0;               // mu, about the coordinate of the reference
    double feed_tolerance = 0;       // part of the feed of the reference
    double lost_time_tolerance = 0;  // s
    double max_correction = 0;       // mu, from the last accepted growth
    double steady_time = 0;          // s of steady feed before the contact

    bool valid() const noexcept {
        return window >= 0 && window <= 1e3 && feed_tolerance >= 0 && feed_tolerance <= 1 &&
               lost_time_tolerance >= 0 && lost_time_tolerance <= 1e3 && max_correction >= 0 &&
               max_correction <= 1e3 && steady_time >= 0 && steady_time <= 1e3;
    }
};

// Whether two feeds, or overrides, are the same: b that of a.
inline bool alike(double b, double a, double tolerance) noexcept {
    return std::abs(b - a) <= tolerance * std::abs(a);
}

// Whether contact b can be compared with its reference a.  A different feed is rejected and not scaled away:
// a delay of the load shifts the contact by feed × delay, and by time nothing is known of where the rest was
// lost.
inline Rejection comparison(Method method, const Contact& b, const Contact& a,
                            const ContactLimits& limits) noexcept {
    if (!alike(b.feed, a.feed, limits.feed_tolerance) ||
        !alike(b.feed_override, a.feed_override, limits.feed_tolerance))
        return Rejection::feed_differs;
    if (method == Method::time &&
        !(a.time > 0 && b.time > 0 && std::abs(b.lost_time - a.lost_time) <= limits.lost_time_tolerance))
        return Rejection::time_differs;
    if (!(std::abs(b.coordinate - a.coordinate) <= limits.window)) return Rejection::outside_window;
    return Rejection::none;
}

}  // namespace plumb

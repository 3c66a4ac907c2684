// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// One contact of a tool with the work.  +Z points away from the work.
struct Contact {
    double coordinate = 0;      // mu, of Z in the machine, offset included
    double time = 0;            // s since the approach began
    double lost_time = 0;       // s of these that Z did not feed at `feed`
    double feed = 0;            // mu/s, signed: negative towards the work
    double feed_override = 1;   // ratio
    double applied_offset = 0;  // mu, that the stage added to the Z origin
    double sigma = 0;           // mu, standard deviation of the contact by noise
    double time_constant = 0;   // s, of the rise of the load; a contact is fitted by that of its reference
};

enum class Method { coordinate, time };

// Displacement between two contacts of the same tool with equal work, B now and A in the reference: growth
// g > 0 makes the spindle longer. In mu. Source: CN104227498A, claims 2 and 1.

// The whole growth: to be SET as offset.
inline double displacement_by_coordinate(const Contact& b, const Contact& a) noexcept {
    return b.coordinate - a.coordinate;
}

// The rest that the applied offset has not yet removed: to be ADDED to it. The signed feed makes the sign
// right on any machine; both contacts must have been fed alike (see contact_rejection.hpp).
inline double displacement_by_time(const Contact& b, const Contact& a) noexcept {
    return a.feed * (b.time - a.time);
}

// The offset that brings the tool back to its depth in the reference, by either method.
inline double growth(Method method, const Contact& b, const Contact& a) noexcept {
    return method == Method::coordinate ? displacement_by_coordinate(b, a)
                                        : b.applied_offset - a.applied_offset + displacement_by_time(b, a);
}

}  // namespace plumb

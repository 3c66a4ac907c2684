// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

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
    double kink = 0;            // mu, by which the load leaves its baseline before that rise: see OnsetShape
    double work_offset = 0;     // mu, along Z: G54 to G59.3 and G92
    double tool_length = 0;     // mu, along Z, by G43

    // By how much the program's origin along Z is higher than at contact `a`.
    double origin_since(const Contact& a) const noexcept {
        return work_offset - a.work_offset + (tool_length - a.tool_length);
    }

    // The contact as it would have been with another work offset and tool length. If the zero has moved, the
    // work has moved with it. Else the program goes to another depth of the same work, whose contact has
    // another place in the program.
    void have_origin(double offset, double length, bool zero_moved) noexcept {
        const double change = offset - work_offset + (length - tool_length);
        work_offset = offset;
        tool_length = length;
        if (zero_moved)
            coordinate += change;
        else
            be_higher(-change);
    }
    // As if it had come earlier, by a distance of the feed.
    void be_higher(double distance) noexcept {
        if (time > 0) time = std::max(time + distance / feed, 1e-9);
    }
};

enum class Method { coordinate, time };

// Displacement between two contacts of the same tool with equal work, B now and A in the reference: growth
// g > 0 makes the spindle longer. In mu. Source: CN104227498A, claims 2 and 1.

// The whole growth: to be SET as offset. Places count in the program: another zero has taken over the rest.
inline double displacement_by_coordinate(const Contact& b, const Contact& a) noexcept {
    return b.coordinate - a.coordinate - b.origin_since(a);
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

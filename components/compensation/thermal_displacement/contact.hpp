// SPDX-License-Identifier: GPL-2.0-or-later
// A contact of a tool with the work, and what may be compared with it.
//
// 1. growth() is the displacement from a reference contact to a later one, by coordinate or by time.
// 2. ContactReferences keeps one contact for each key: the n-th of a tool in an operation. take_in() makes a
//    mean of several cycles.
// 3. comparison() and rises_unlike() reject a contact that shows something else than growth.
#pragma once

#include "components/compensation/thermal_displacement/displacement_settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

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
    double time_constant = 0;   // s, of the load's rise; the fit takes the reference's time constant
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
    // The contact as it would have been with a spindle that is shorter by a distance.
    void displace(double distance) noexcept {
        coordinate += distance;
        be_higher(distance);
    }
    // As if it had come earlier, by a distance of the feed.
    void be_higher(double distance) noexcept {
        if (time > 0) time = std::max(time + distance / feed, 1e-9);
    }
};

// Why the origin of the program along Z has changed: a new zero, or a tool measured again; a correction of
// the growth by hand; or another depth.
enum class OriginReason : std::int32_t { none, zero, by_hand, depth };

// Displacement between two contacts of the same tool with equal work, B now and A in the reference: growth
// g > 0 makes the spindle longer. In mu. Source: CN104227498A, claims 2 and 1.

// The whole growth: to be SET as offset. Places count in the program: another zero has taken over the rest.
inline double displacement_by_coordinate(const Contact& b, const Contact& a) noexcept {
    return b.coordinate - a.coordinate - b.origin_since(a);
}

// The rest that the applied offset has not yet removed: to be ADDED to it. The signed feed makes the sign
// right on any machine; both contacts must have been fed alike (see comparison()).
inline double displacement_by_time(const Contact& b, const Contact& a) noexcept {
    return a.feed * (b.time - a.time);
}

// The offset that brings the tool back to its depth in the reference, by either method.
inline double growth(Method method, const Contact& b, const Contact& a) noexcept {
    return method == Method::coordinate ? displacement_by_coordinate(b, a)
                                        : b.applied_offset - a.applied_offset + displacement_by_time(b, a);
}

// Identifies a contact of a cycle: the n-th of a tool in an operation, counted from 1.
struct ContactKey {
    std::int32_t operation = 0;
    std::int32_t tool = 0;
    std::int32_t occurrence = 0;

    bool operator==(const ContactKey& other) const noexcept {
        return operation == other.operation && tool == other.tool && occurrence == other.occurrence;
    }
};

// A contact is compared only under the setup of its reference.
struct MachiningSetup {
    std::int32_t program = 0;
    std::int32_t tool_set = 0;

    bool operator==(const MachiningSetup& other) const noexcept {
        return program == other.program && tool_set == other.tool_set;
    }
};

// A contact with which later ones are compared, and the state of the machine at that contact. It may be the
// mean over several cycles.
struct ContactReference {
    ContactKey key;
    Contact contact;
    MachiningSetup setup;
    double speed_history = 0;  // rpm, spindle speed averaged over the past minutes
    double temperature = 20;   // degC
    std::int32_t date = 0;     // YYYYMMDD of the last cycle; 0 when not known
    std::int32_t cycles = 1;   // of which it is the mean
    double scatter = 0;        // mu, standard deviation of one cycle's contact; 0 when there is one only
    double common_sigma = 0;   // mu, of the growth that was subtracted as it was learned

    // Whether a reference from a file is plausible.
    bool valid() const noexcept {
        const Contact& c = contact;
        const auto plausible = [](double x) { return std::abs(x) <= 1e6; };
        return key.occurrence >= 1 && plausible(c.coordinate) && plausible(c.time) && c.time >= 0 &&
               plausible(c.lost_time) && plausible(c.feed) && c.feed < 0 && plausible(c.feed_override) &&
               plausible(c.applied_offset) && plausible(c.sigma) && c.sigma >= 0 &&
               plausible(c.time_constant) && c.time_constant > 0 && plausible(c.work_offset) &&
               plausible(c.tool_length) && plausible(c.kink) && plausible(speed_history) &&
               plausible(temperature) && date >= 0 && cycles >= 1 && plausible(scatter) && scatter >= 0 &&
               plausible(common_sigma) && common_sigma >= 0;
    }
};

// Takes the contact of one more cycle into a mean. `scatter` is the sample standard deviation of the
// displacements by that method; `sigma` is the standard deviation of the mean, by the noise of the load.
inline void take_in(Method method, ContactReference& mean, const ContactReference& next) noexcept {
    mean.contact.have_origin(next.contact.work_offset, next.contact.tool_length, true);
    const double before = mean.cycles++;
    const double part = 1 / (before + 1);
    const double away = growth(method, next.contact, mean.contact);  // from the mean before
    const double squares = (before - 1) * mean.scatter * mean.scatter + before * part * away * away;
    mean.scatter = std::sqrt(squares / before);
    mean.contact.sigma = part * std::hypot(before * mean.contact.sigma, next.contact.sigma);
    for (double Contact::*value :
         {&Contact::coordinate, &Contact::time, &Contact::lost_time, &Contact::feed, &Contact::feed_override,
          &Contact::applied_offset, &Contact::time_constant, &Contact::kink})
        mean.contact.*value += part * (next.contact.*value - mean.contact.*value);
    mean.speed_history += part * (next.speed_history - mean.speed_history);
    mean.temperature += part * (next.temperature - mean.temperature);
    mean.date = next.date;
}

// Standard deviation, in mu, of the displacement from a reference to a contact. All that scatters from
// cycle to cycle (blanks, the seat of the tool, a warmer machine) scatters in the present contact too.
inline double displacement_sigma(const Contact& now, const ContactReference& reference) noexcept {
    const double mean = reference.scatter / std::sqrt(static_cast<double>(reference.cycles));
    return std::hypot(std::max(now.sigma, reference.scatter), std::max(reference.contact.sigma, mean));
}

// The contacts of one cycle, in the order in which they were made.
class ContactReferences {
public:
    static constexpr std::int32_t capacity = 64, most_programs = 8;  // contacts of each program

    bool feed_differed = false;  // they are refused, because all contacts of a cycle came with another feed

    std::int32_t size() const noexcept { return size_; }
    const ContactReference& operator[](std::int32_t i) const noexcept { return list_[i]; }  // 0 ≤ i < size()
    ContactReference& operator[](std::int32_t i) noexcept { return list_[i]; }

    // -1 if there is none.
    std::int32_t find(const ContactKey& key) const noexcept {
        for (std::int32_t i = 0; i < size_; ++i)
            if (list_[i].key == key) return i;
        return -1;
    }

    // There are some, and they belong to this program and these tools.
    bool made_with(const MachiningSetup& setup) const noexcept {
        return size_ > 0 && list_[0].setup == setup;
    }

    // False, without a change, if the list is full or has this contact already.
    bool add(const ContactReference& reference) noexcept {
        if (size_ == capacity || find(reference.key) >= 0) return false;
        list_[size_++] = reference;
        return true;
    }

    // Drops all references for whose index keep(index) is false.
    template <class Keep>
    void retain(const Keep& keep) noexcept {
        std::int32_t kept = 0;
        for (std::int32_t i = 0; i < size_; ++i)
            if (keep(i)) list_[kept++] = list_[i];
        size_ = kept;
    }

    void clear() noexcept {
        size_ = 0;
        feed_differed = false;
    }

private:
    std::array<ContactReference, capacity> list_;
    std::int32_t size_ = 0;
};

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
                            const DisplacementSettings& limits) noexcept {
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

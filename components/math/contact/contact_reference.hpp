// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/displacement_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace plumb {

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

    // Whether a reference from a file is plausible.
    bool valid() const noexcept {
        const Contact& c = contact;
        const auto plausible = [](double x) { return std::abs(x) <= 1e6; };
        return key.occurrence >= 1 && plausible(c.coordinate) && plausible(c.time) && c.time >= 0 &&
               plausible(c.lost_time) && plausible(c.feed) && c.feed < 0 && plausible(c.feed_override) &&
               plausible(c.applied_offset) && plausible(c.sigma) && c.sigma >= 0 &&
               plausible(c.time_constant) && c.time_constant > 0 && plausible(c.work_offset) &&
               plausible(c.tool_length) && plausible(c.kink) && plausible(speed_history) &&
               plausible(temperature) && date >= 0 && cycles >= 1 && plausible(scatter) && scatter >= 0;
    }
};

// Takes the contact of one more cycle into a mean. `scatter` is the sample standard deviation of the
// displacements by that method, `sigma` that of the mean by the noise of the load.
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
    static constexpr std::int32_t capacity = 64;

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

    void clear() noexcept { size_ = 0; }

private:
    std::array<ContactReference, capacity> list_;
    std::int32_t size_ = 0;
};

}  // namespace plumb

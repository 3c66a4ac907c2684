// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/displacement_law.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace plumb {

// Which contact of a cycle: the n-th of a tool in an operation, counted from 1.
struct ContactKey {
    std::int32_t operation = 0;
    std::int32_t tool = 0;
    std::int32_t occurrence = 0;

    bool operator==(const ContactKey& other) const noexcept {
        return operation == other.operation && tool == other.tool && occurrence == other.occurrence;
    }
};

// A contact with which later ones are compared, and the state of the machine that made it.
struct ContactReference {
    ContactKey key;
    Contact contact;
    std::int32_t program = 0;
    double speed_history = 0;  // rpm, spindle speed averaged over the past minutes

    // What may be believed when it comes from a file.
    bool valid() const noexcept {
        const Contact& c = contact;
        const auto plausible = [](double x) { return std::abs(x) <= 1e6; };
        return key.occurrence >= 1 && plausible(c.coordinate) && plausible(c.time) && c.time >= 0 &&
               plausible(c.lost_time) && plausible(c.feed) && c.feed < 0 && plausible(c.feed_override) &&
               plausible(c.applied_offset) && plausible(c.sigma) && c.sigma >= 0 && plausible(speed_history);
    }
};

// The contacts of one cycle, in the order in which they were made.
class ContactReferences {
public:
    static constexpr std::int32_t capacity = 64;

    std::int32_t size() const noexcept { return size_; }
    const ContactReference& operator[](std::int32_t i) const noexcept { return list_[i]; }  // 0 ≤ i < size()

    // -1 if there is none.
    std::int32_t find(const ContactKey& key) const noexcept {
        for (std::int32_t i = 0; i < size_; ++i)
            if (list_[i].key == key) return i;
        return -1;
    }

    // False, and nothing is added, if the list is full or has this contact already.
    bool add(const ContactReference& reference) noexcept {
        if (size_ == capacity || find(reference.key) >= 0) return false;
        list_[size_++] = reference;
        return true;
    }

    void clear() noexcept { size_ = 0; }

private:
    std::array<ContactReference, capacity> list_;
    std::int32_t size_ = 0;
};

}  // namespace plumb

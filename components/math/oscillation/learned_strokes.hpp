// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// What was learned for the last strokes. Offsets are outward, of the lower and the upper dead point.
class LearnedStrokes {
public:
    static constexpr int most = 8;

    // What a correction holds for.
    struct Stroke {
        double lower = 0, upper = 0, speed = 0, acceleration = 0;
        int sections = 0;  // a number that changes with them, and with dwells

        bool operator==(const Stroke& other) const noexcept {
            return lower == other.lower && upper == other.upper && speed == other.speed &&
                   acceleration == other.acceleration && sections == other.sections;
        }
    };

    struct Learned {
        Stroke stroke;
        std::array<double, 2> offset{}, first_offset{};  // mu, now, and when it was first learned
        double reversal = 0;                             // mu/s2, the acceleration at the dead points
        double proven = 0;  // mu/s2, the largest one that the joint has shown; 0 in an old record
        // Mu, by which the axis turns beyond its command in the last cycle of a climb; 0: unknown.
        std::array<double, 2> slow{};
        // Mu/s2, of the axis itself after the ends, in this cycle; 0: unknown.
        std::array<double, 2> shown{};

        // False for NaN too.
        bool valid() const noexcept {
            const auto within = [](double x, double largest) { return std::abs(x) <= largest; };
            return within(stroke.lower, 1e6) && within(stroke.upper, 1e6) && stroke.lower < stroke.upper &&
                   stroke.speed > 0 && within(stroke.speed, 1e6) && stroke.acceleration > 0 &&
                   within(stroke.acceleration, 1e9) && within(offset[0], 1e3) && within(offset[1], 1e3) &&
                   within(first_offset[0], 1e3) && within(first_offset[1], 1e3) && reversal > 0 &&
                   within(reversal, 1e9) && proven >= 0 && within(proven, 1e9) && within(slow[0], 1e3) &&
                   within(slow[1], 1e3) && within(shown[0], 1e9) && within(shown[1], 1e9);
        }
    };

    int size() const noexcept { return count_; }
    // 0 <= i < size().
    const Learned& operator[](int i) const noexcept { return list_[static_cast<std::size_t>(i)]; }

    const Learned* find(const Stroke& stroke) const noexcept {
        const int place = place_of(stroke);
        return place < count_ ? &(*this)[place] : nullptr;
    }

    // Mu/s2, of the joint, in any stroke; 0 if there is none.
    double largest_proven() const noexcept {
        double largest = 0;
        for (int i = 0; i < count_; ++i)
            largest = std::max({largest, (*this)[i].proven, (*this)[i].reversal});
        return largest;
    }

    // S2, how far the joint turned beyond an end for each acceleration, in any stroke; 0 if it never did.
    double largest_overshoot() const noexcept {
        double largest = 0;
        for (int i = 0; i < count_; ++i)
            for (const double offset : (*this)[i].offset)
                largest = std::max(largest, -offset / (*this)[i].reversal);
        return largest;
    }

    // In the place of the oldest one where all are taken.
    void remember(const Learned& learned) noexcept {
        int place = place_of(learned.stroke);
        if (place == most) {
            place = oldest_;
            oldest_ = (oldest_ + 1) % most;
        }
        put(place, learned);
    }

    // From before the start; false if it is impossible, already there, or too many.
    bool restore(const Learned& learned) noexcept {
        if (!learned.valid() || find(learned.stroke) || count_ == most) return false;
        put(count_, learned);
        return true;
    }

    void forget() noexcept { count_ = oldest_ = 0; }

private:
    // Of a stroke that is not remembered, size().
    int place_of(const Stroke& stroke) const noexcept {
        int i = 0;
        while (i < count_ && !((*this)[i].stroke == stroke)) ++i;
        return i;
    }

    void put(int place, const Learned& learned) noexcept {
        count_ = std::max(count_, place + 1);
        list_[static_cast<std::size_t>(place)] = learned;
    }

    std::array<Learned, most> list_{};
    int count_ = 0, oldest_ = 0;
};

}  // namespace plumb

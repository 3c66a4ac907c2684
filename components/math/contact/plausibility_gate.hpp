// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// Separates growth from other displacements of a contact, as far as possible, by the largest growth since
// the last accepted contact:
//
//     spread = max_growth_rate × time,  at least floor,  at most cap;  cap if none was accepted yet.
//
// A change beyond it is refused, unless `confirm` further contacts agree with it within the floor, each with
// another tool and in another cycle than the one before: a chip, an odd blank or a wrong tool cannot confirm
// itself, a whole batch of odd blanks can.
class PlausibilityGate {
public:
    struct Settings {
        double max_growth_rate = 0;  // mu/s
        double floor = 0;            // mu
        double cap = 0;              // mu, not below the floor
        std::int32_t confirm = 0;    // 0: never

        bool valid() const noexcept {
            return max_growth_rate >= 0 && max_growth_rate <= 1 && floor >= 0 && floor <= cap && cap <= 1e3 &&
                   confirm >= 0;
        }
    };

    void step(double dt) noexcept { elapsed_ += dt; }

    double spread(const Settings& settings) const noexcept {
        return known_ ? std::clamp(settings.max_growth_rate * elapsed_, settings.floor, settings.cap)
                      : settings.cap;
    }

    // Whether a growth, in mu, is accepted. Ask once for each contact; `tool` and `cycle` are numbers that
    // identify tools and cycles.
    bool admits(double growth, std::int32_t tool, std::int32_t cycle, const Settings& settings) noexcept {
        if (std::abs(growth - growth_) <= spread(settings)) {
            agreeing_ = 0;
            return true;
        }
        if (agreeing_ == 0 || !(std::abs(growth - claimed_) <= settings.floor)) {
            claimed_ = growth;
            agreeing_ = 1;
        } else if (tool != tool_ && cycle != cycle_) {
            ++agreeing_;
        } else {
            return false;
        }
        tool_ = tool;
        cycle_ = cycle;
        return settings.confirm > 0 && agreeing_ > settings.confirm;
    }

    // A contact was accepted, or made the reference.
    void accept(double growth) noexcept {
        known_ = true;
        growth_ = growth;
        elapsed_ = 0;
        agreeing_ = 0;
    }

    // The growth counts from another origin.
    void displace(double distance) noexcept {
        growth_ += distance;
        agreeing_ = 0;
    }

    bool known() const noexcept { return known_; }      // a contact was accepted
    double growth() const noexcept { return growth_; }  // mu, of the last accepted contact; 0 before

    // Returns to the state after start.
    void forget() noexcept { *this = PlausibilityGate(); }

private:
    bool known_ = false;
    double growth_ = 0;          // mu, of the last accepted contact
    double elapsed_ = 0;         // s since then
    std::int32_t agreeing_ = 0;  // contacts beyond the spread that agree
    double claimed_ = 0;         // mu, by the first of them
    std::int32_t tool_ = 0;      // ... of the last of them
    std::int32_t cycle_ = 0;
};

}  // namespace plumb

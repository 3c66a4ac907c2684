// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// How much of an estimated correction may be applied: 1 for all of it, 0 for nothing. It is a continuous
// function of three doubts, the product of
//
//     certainty   (|value| + harmless) / (2 sigma)      0 up to `none`, 1 from `all` on
//     age         s since the evidence failed to come      1 up to `hold`, 0 from twice that on
//     agreement   part of the last evidence that agreed    0 up to 1/4, 1 from 3/4 on
//
// A correction c does harm where less than half of it is true, and more than m of harm where less than (c -
// m) / 2 is. So the certainty is the number of standard deviations from that. There is hysteresis: each of
// them must turn by a margin before the authority follows it back, so that noise at an edge does not move an
// axis to and fro. While work is under way the authority may rise but never falls: the correction in force
// holds, and cuts no step into a part.
class Authority {
public:
    struct Settings {
        double none = 1, all = 2;  // standard deviations
        double harmless = 0;       // in the unit of the value
        double hold = 0;           // s
    };

    struct Evidence {
        double value = 0, sigma = 0;  // in one unit
        double age = 0;               // s
        double agreement = 1;         // 0 to 1
    };

    // Once a period. `holds`: work is under way. Values that are not finite count for nothing.
    double step(const Evidence& e, bool holds, const Settings& settings) noexcept {
        if (!finite(e)) return part_ = holds ? part_ : 0;
        const double certainty = e.sigma > 0 ? (std::abs(e.value) + settings.harmless) / (2 * e.sigma) : 1e9;
        const double wanted =
            rising(certainty_.step(certainty, margin * settings.all), settings.none, settings.all) *
            rising(-e.age, -2 * settings.hold, -settings.hold) *
            rising(agreement_.step(e.agreement, margin), 0.25, 0.75);
        return part_ = holds ? std::max(part_, wanted) : wanted;
    }

    double part() const noexcept { return part_; }

    void forget() noexcept { *this = Authority(); }

    // 0 up to `from`, 1 from `to` on, straight between; from < to.
    static double rising(double x, double from, double to) noexcept {
        return std::clamp((x - from) / (to - from), 0.0, 1.0);
    }

private:
    static bool finite(const Evidence& e) noexcept {
        return std::isfinite(e.value) && std::isfinite(e.sigma) && std::isfinite(e.age) &&
               std::isfinite(e.agreement);
    }

    static constexpr double margin = 0.1;

    // Follows its input as with a lost motion.
    struct Play {
        double value = 0;
        double step(double x, double half) noexcept { return value = std::clamp(value, x - half, x + half); }
    };

    Play certainty_, agreement_{1};
    double part_ = 0;
};

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
// A property of a simulated machine: given by a pin, or else drawn by the machine's seed. An absurd value,
// a hundred times the largest that is drawn or a thousandth of the smallest, counts as not given; 0 does
// not.
#pragma once

#include "components/math/blocks/random.hpp"
#include "hal/component.hpp"

#include <cstdint>
#include <sstream>
#include <string>

namespace plumb {

class Drawn {
public:
    // Machine 0 has the typical value, any other one a value from low to high. The value of one property
    // does not depend on the other properties. `doc` is the sentence without its full stop.
    Drawn(hal::Owner owner, const std::string& name, double typical, double low, double high,
          const std::string& unit, const std::string& doc)
        : given_{owner, name, -1, unit, sentence(typical, low, high, doc)},
          typical_(typical),
          low_(low),
          high_(high),
          stream_(number(given_.name())),
          value_(typical) {}

    double operator()(std::int32_t seed) noexcept {
        const double given = given_;
        if (given != last_ || seed != seed_) {
            last_ = given;
            seed_ = seed;
            value_ = value(given, seed);
        }
        return value_;
    }

private:
    double value(double given, std::int32_t seed) const noexcept {
        if (given == 0 || (given >= low_ / 1000 && given <= 100 * high_ && given > 0)) return given;
        return seed == 0 ? typical_ : Random(static_cast<std::uint64_t>(seed), stream_).uniform(low_, high_);
    }

    static std::string sentence(double typical, double low, double high, const std::string& doc) {
        std::ostringstream text;
        text << doc << "; when negative " << typical << " for seed 0 and drawn from " << low << " to " << high
             << " for any other.";
        return text.str();
    }

    static std::uint64_t number(const std::string& name) noexcept {
        std::uint64_t n = 0;
        for (const char c : name) n = n * 131 + static_cast<unsigned char>(c);
        return n;
    }

    const hal::In<double> given_;
    const double typical_;
    const double low_;
    const double high_;
    const std::uint64_t stream_;
    double last_ = -1;  // given, with this seed, for which this is the value
    std::int32_t seed_ = 0;
    double value_;
};

}  // namespace plumb

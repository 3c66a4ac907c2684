// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/pin.hpp"

#include <cstddef>
#include <deque>
#include <string>

namespace plumb {

// As hal::Row, for a number that is known at load, and without a leading 0: STEM-0 to STEM-16.
template <class P>
class NumberedRow {
public:
    template <class... Rest>
    NumberedRow(hal::Owner owner, std::size_t number, const std::string& stem, const Rest&... rest) {
        for (std::size_t i = 0; i < number; ++i)
            pins_.emplace_back(owner, stem + "-" + std::to_string(i), rest...);
    }

    P& operator[](std::size_t i) noexcept { return pins_[i]; }

private:
    std::deque<P> pins_;
};

}  // namespace plumb

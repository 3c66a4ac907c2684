// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/pin.hpp"

#include <cstddef>
#include <string>
#include <utility>

namespace plumb {

// As hal::Row, but numbered without a leading 0: so the first ten keep their names when there are more.
template <class P, std::size_t N>
class NumberedRow {
public:
    template <class... Rest>
    NumberedRow(hal::Owner owner, const std::string& stem, const Rest&... rest)
        : NumberedRow(std::make_index_sequence<N>{}, owner, stem, rest...) {}

    P& operator[](std::size_t i) noexcept { return pins_[i]; }
    P* begin() noexcept { return pins_; }
    P* end() noexcept { return pins_ + N; }

private:
    template <std::size_t... I, class... Rest>
    NumberedRow(std::index_sequence<I...> /*numbers*/, hal::Owner owner, const std::string& stem,
                const Rest&... rest)
        : pins_{P(owner, stem + "-" + std::to_string(I), rest...)...} {}

    P pins_[N];
};

}  // namespace plumb

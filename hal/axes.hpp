// SPDX-License-Identifier: GPL-2.0-or-later
// A pin, or a group of pins, for each axis:
//
//     hal::Axes<hal::Out<double>, 3> correction{this, "%-correction", "mu", "Correction of %."};
//
// declares x-correction, y-correction and z-correction. Three are X to Z, six the linear axes X to W, nine
// are all axes of LinuxCNC. Without a number their letters are given, where an option says which axes there
// are:
//
//     hal::Axes<hal::Out<double>> correction{this, "xyw", "%-correction", "mu", "Correction of %."};
#pragma once

#include "hal/owner.hpp"

#include <cstddef>
#include <deque>
#include <string>
#include <utility>

namespace plumb::hal {

template <class P, std::size_t N = 0>
class Axes {
    static_assert(N == 3 || N == 6 || N == 9, "X to Z, the linear axes, or all axes of LinuxCNC");
    static constexpr const char* letters = N == 6 ? "xyzuvw" : "xyzabcuvw";

public:
    template <class... Rest>
    Axes(Owner owner, const Rest&... rest) : Axes(std::make_index_sequence<N>{}, owner, rest...) {}

    P& operator[](std::size_t i) noexcept { return pins_[i]; }
    const P& operator[](std::size_t i) const noexcept { return pins_[i]; }
    P* begin() noexcept { return pins_; }
    P* end() noexcept { return pins_ + N; }
    const P* begin() const noexcept { return pins_; }
    const P* end() const noexcept { return pins_ + N; }

private:
    template <std::size_t... I, class... Rest>
    Axes(std::index_sequence<I...>, Owner owner, const Rest&... rest)
        : pins_{P(Owner(owner, letters[I]), rest...)...} {}

    P pins_[N];
};

// By their place in the letters.
template <class P>
class Axes<P, 0> {
public:
    template <class... Rest>
    Axes(Owner owner, const std::string& letters, const Rest&... rest) {
        for (const char letter : letters) pins_.emplace_back(Owner(owner, letter), rest...);
    }

    std::size_t size() const noexcept { return pins_.size(); }
    P& operator[](std::size_t i) noexcept { return pins_[i]; }
    const P& operator[](std::size_t i) const noexcept { return pins_[i]; }
    auto begin() noexcept { return pins_.begin(); }
    auto end() noexcept { return pins_.end(); }
    auto begin() const noexcept { return pins_.begin(); }
    auto end() const noexcept { return pins_.end(); }

private:
    std::deque<P> pins_;
};

}  // namespace plumb::hal

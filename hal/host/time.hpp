// SPDX-License-Identifier: GPL-2.0-or-later
// Virtual time is a signed count of nanoseconds since the host began; every instant and every span has this
// type.
#pragma once

#include <cstdint>
#include <limits>

namespace plumb::host {

using Nanoseconds = std::int64_t;

inline constexpr Nanoseconds never = std::numeric_limits<Nanoseconds>::max();
inline constexpr Nanoseconds one_second = 1'000'000'000;

// The instant after a span of time; `never` where time ends before.
constexpr Nanoseconds after(Nanoseconds instant, Nanoseconds span) {
    return instant > 0 && span > never - instant ? never : instant + span;
}

}  // namespace plumb::host

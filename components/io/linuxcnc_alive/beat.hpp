// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace plumb {

// A counter that advances while a program lives: as a bit that changes with it, and its longest pause.
class Beat {
public:
    // count: nothing while it cannot be read; now: s.
    void see(std::optional<std::uint64_t> count, double now) noexcept {
        if (beats_) longest_ = std::max(longest_, now - since_);
        if (!count) return;
        const bool advanced = last_ && *count != *last_;
        last_ = count;
        if (!advanced) return;
        bit_ = !bit_;
        beats_ = true;
        since_ = now;
    }

    bool bit() const noexcept { return bit_; }
    bool beats() const noexcept { return beats_; }              // it has advanced
    double longest_pause() const noexcept { return longest_; }  // s, since it first advanced

private:
    std::optional<std::uint64_t> last_;
    double since_ = 0, longest_ = 0;
    bool bit_ = false, beats_ = false;
};

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace plumb {

// A counter that advances while a program lives, and its longest pause.
class Beat {
public:
    // Whether it has advanced. count: nothing while it cannot be read; now: s.
    bool see(std::optional<std::uint64_t> count, double now) noexcept {
        if (beats_) longest_ = std::max(longest_, now - since_);
        if (!count) return false;
        const bool advanced = last_ && *count != *last_;
        last_ = count;
        if (advanced) {
            beats_ = true;
            since_ = now;
        }
        return advanced;
    }

    double longest_pause() const noexcept { return longest_; }  // s, since it first advanced

private:
    std::optional<std::uint64_t> last_;
    double since_ = 0, longest_ = 0;
    bool beats_ = false;
};

}  // namespace plumb

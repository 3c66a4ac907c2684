// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// The changes of a bit from period to period. Call one of them once in each period.
class Edge {
public:
    Edge() = default;
    // The bit before the first period: one that is true already does not rise.
    explicit Edge(bool before) noexcept : before_(before) {}

    bool rises(bool now) noexcept { return changes(now) && now; }
    bool changes(bool now) noexcept {
        const bool change = now != before_;
        before_ = now;
        return change;
    }

private:
    bool before_ = false;
};

}  // namespace plumb

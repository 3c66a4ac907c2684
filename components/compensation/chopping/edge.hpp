// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// The changes of a bit, which is false before the first period.
class Edge {
public:
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

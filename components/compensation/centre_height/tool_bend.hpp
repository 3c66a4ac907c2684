// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// How far work and tool bend: the height of a tool at rest less the one under the cut. Lengths in mu.
class ToolBend {
public:
    // The height of a tool against an origin that both share. Another tool forgets the one before.
    void take(double tool, bool at_rest, double height, double sigma) noexcept {
        if (tool != tool_) *this = ToolBend{};
        tool_ = tool;
        (at_rest ? rest_ : cut_) = {height, sigma, true};
    }

    bool known() const noexcept { return cut_.valid && rest_.valid; }
    double bend() const noexcept { return known() ? rest_.height - cut_.height : 0; }
    double sigma() const noexcept { return known() ? std::hypot(rest_.sigma, cut_.sigma) : 0; }

private:
    struct Height {
        double height = 0, sigma = 0;
        bool valid = false;
    };

    double tool_ = 0;
    Height cut_, rest_;
};

}  // namespace plumb

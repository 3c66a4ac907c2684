// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

// Turns a wanted offset into the counts of LinuxCNC's external offsets. LinuxCNC adds each step of the
// counts, times the scale, to the requested offset (the request), and loses all steps that come while it
// ignores the counts. So the loop is closed on the request:
//
//     counts += round((wanted - request) / scale)
//
// and a step is sent only after the request has shown the one before. So lost steps can neither add up nor
// wind up.
class OffsetCounter {
public:
    // Forgets a step under way, and takes the request as it is.
    void start(double request) noexcept {
        expected_ = request;
        silence_ = 0;
        under_way_ = false;
    }

    // Whether the request shows the last step.
    bool agrees(double request, double scale) const noexcept {
        return std::abs(request - expected_) <= scale / 2;
    }

    // The same. Call it once in each period: it counts periods without an answer.
    bool answered(double request, double scale) noexcept {
        const bool heard = agrees(request, scale);
        silence_ = heard ? 0 : silence_ + 1;
        under_way_ = under_way_ && !heard;
        return heard;
    }

    // Sends the step that brings the request to the wanted offset; only after answered(). Both finite, scale
    // > 0.
    void ask(double wanted, double request, double scale) noexcept {
        const double step = std::round((wanted - request) / scale);
        const double counts = counts_ + step;
        used_up_ = std::abs(counts) > std::numeric_limits<std::int32_t>::max();
        if (used_up_) return;
        counts_ = static_cast<std::int32_t>(counts);
        expected_ = request + step * scale;
        under_way_ = step != 0;
    }

    std::int32_t counts() const noexcept { return counts_; }
    bool under_way() const noexcept { return under_way_; }        // a step has no answer yet
    bool silent() const noexcept { return silence_ > patience; }  // LinuxCNC does not take the steps
    bool used_up() const noexcept { return used_up_; }            // the step does not fit into 32 bits

private:
    static constexpr int patience = 10;  // periods

    std::int32_t counts_ = 0;
    double expected_ = 0;
    int silence_ = 0;
    bool used_up_ = false, under_way_ = false;
};

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// A bit that rises after its input has been true for `on` seconds without a break, and falls after it has
// been false for `off` seconds.  Without a delay it follows at once.
class DelayedBit {
public:
    // on and off at least 0, dt above 0.
    bool step(bool input, double on, double off, double dt) noexcept {
        if (input == bit_)
            waited_ = 0;
        else if ((waited_ += dt) > (input ? on : off)) {
            bit_ = input;
            waited_ = 0;
        }
        return bit_;
    }

    bool value() const noexcept { return bit_; }
    bool waits() const noexcept { return waited_ > 0; }  // for a delay

private:
    bool bit_ = false;
    double waited_ = 0;  // s, for which the input differs
};

}  // namespace plumb

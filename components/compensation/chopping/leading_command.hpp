// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/jerk_limit.hpp"

#include <cstddef>

namespace plumb {

// The command of a stroke: its positions with a limited jerk, ahead by the lead times their velocity.
class LeadingCommand {
public:
    // At rest at a position, mu, with the samples that limit the jerk.
    void begin(double position, std::size_t samples) noexcept {
        jerk_.reset(position, samples);
        position_ = position;
        velocity_ = 0;
    }

    // The lead is in s.
    void step(double position, double lead, double dt) noexcept {
        const double before = jerk_.value(), velocity_before = velocity_;
        velocity_ = (jerk_.step(position) - before) / dt;
        acceleration_ = (velocity_ - velocity_before) / dt;
        position_ = jerk_.value() + lead * velocity_;
    }

    void rest() noexcept { velocity_ = acceleration_ = 0; }

    double position() const noexcept { return position_; }          // mu
    double mean() const noexcept { return jerk_.value(); }          // mu, without the lead
    double velocity() const noexcept { return velocity_; }          // mu/s, without the lead
    double acceleration() const noexcept { return acceleration_; }  // mu/s2, without the lead
    bool settled() const noexcept { return jerk_.settled(); }

private:
    JerkLimit jerk_;
    double position_ = 0, velocity_ = 0, acceleration_ = 0;
};

}  // namespace plumb

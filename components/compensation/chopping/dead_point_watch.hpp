// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/math/oscillation/dead_point_meter.hpp"
#include "components/math/oscillation/oscillation_leg.hpp"

namespace plumb {

// Measures each dead point, compares it with the commanded one, and learns from it.
class DeadPointWatch {
public:
    using Arrival = OscillationLeg::Arrival;

    enum class Event { none, corrected, beyond, wrong_scale };

    // Of the strokes that are planned now.
    struct Present {
        bool learns = false;
        bool without_override = true;
        double speed = 0;  // mu/s
    };

    DeadPointLearning& learning() noexcept { return learning_; }
    const DeadPointLearning& learning() const noexcept { return learning_; }

    // A motion begins.
    void begin() noexcept {
        arrival_[0] = arrival_[1] = {};
        doubts_[0] = doubts_[1] = 0;
        metering_ = false;
    }

    // The next dead point is not that of a whole stroke.
    void pause() noexcept { metering_ = false; }

    void arrive(const Arrival& arrival) noexcept { arrival_[arrival.upper] = arrival; }

    // A measured position; a dead point is between the second halves of two strokes.
    Event step(double measured, bool second_half, bool upward, const Present& present) noexcept {
        Event event = Event::none;
        if (second_half && (!metering_ || upward != upward_)) {
            if (metering_) event = evaluate(upward_, present);
            metering_ = true;
            upward_ = upward;
            meter_.begin(upward);
        }
        if (metering_) meter_.step(measured);
        return event;
    }

    // The last ones.
    const Arrival& arrival(bool upper) const noexcept { return arrival_[upper]; }
    double position(bool upper) const noexcept { return position_[upper]; }  // mu
    double error(bool upper) const noexcept { return error_[upper]; }        // mu, positive outside

private:
    Event evaluate(bool upper, const Present& present) noexcept {
        const Arrival& its = arrival_[upper];
        if (!meter_.found() || !its.happened) return Event::none;
        position_[upper] = meter_.position();
        error_[upper] = upper ? position_[1] - its.bound : its.bound - position_[0];
        if (!present.learns || !its.regular || its.first) return Event::none;
        const bool plausible = learning_.plausible(upper, error_[upper], its.offset, its.speed);
        doubts_[upper] = plausible ? 0 : doubts_[upper] + 1;
        if (doubts_[upper] >= 2) return Event::wrong_scale;
        if (doubts_[0] + doubts_[1] > 0 || !present.without_override || its.speed != present.speed)
            return Event::none;
        const int beyond = learning_.beyond();
        learning_.measured(upper, error_[upper], its.offset, its.acceleration, its.speed);
        if (learning_.beyond() == beyond) return Event::corrected;
        learning_.restart();
        return Event::beyond;
    }

    DeadPointLearning learning_;
    DeadPointMeter meter_;
    Arrival arrival_[2];  // lower, upper
    double position_[2] = {0, 0}, error_[2] = {0, 0};
    int doubts_[2] = {0, 0};  // of the scale, in a row
    bool metering_ = false, upward_ = false;
};

}  // namespace plumb

// SPDX-License-Identifier: GPL-2.0-or-later
// An axis of a simulated machine: its drive, its guide, and how that leans.
#pragma once

#include "components/math/blocks/servo_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/sim_portal/drive_play.hpp"
#include "components/plants/sim_portal/guide_errors.hpp"
#include "components/plants/sim_portal/rigid_machine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

class PortalAxis final : public hal::Group {
public:
    PortalAxis(hal::Owner owner, int direction) : Group(owner), direction_(direction) {}

    // Machine number `seed`, at rest; when switched on, at its command.
    void start(std::int32_t seed, bool switched_on) noexcept {
        if (switched_on) {
            commanded_ = usable(command_, longest, 0);
            wanted_ = usable(nominal_, longest, 0);
            drive_.reset(commanded_);
            led_ = 0;
            ideal_.reset(wanted_);
            play_.reset(commanded_);
        }
        errors_.draw(seed);
        play_.draw(seed, static_cast<std::uint64_t>('p' + direction_ * 256));
        Random random(static_cast<std::uint32_t>(seed), static_cast<std::uint64_t>('d' + direction_ * 256));
        for (int i = 0; i < 3; ++i) {
            const double rate = random.uniform(0.5, 1);
            drifting_[i] = i == direction_ ? 0 : random.index(2) == 0 ? rate : -rate;
        }
    }

    // Follows its command for dt > 0 seconds, unless it is clamped. `drift`, in rad, is the largest change
    // of the tilts so far.
    void move(double gain, double drift, bool clamped, double dt) noexcept {
        commanded_ = usable(command_, longest, commanded_);
        wanted_ = usable(nominal_, longest, wanted_);
        ideal_.step(wanted_, gain, dt);
        const double loop = at_load_ ? motor() - play_.load() : 0;  // the loop is closed at the load
        if (clamped) {
            drive_.reset(motor());
            led_ = 0;
        } else {
            drive_.step(commanded_ + loop, gain, dt);
            const double kept = std::exp(-gain * dt);  // the velocity holds over the period
            led_ = led_ * kept + usable(added_, longest, 0) / gain * (1 - kept);
        }
        zero_ = usable(pivot_, longest, zero_);
        begin_ = usable(lowest_, longest, begin_);
        end_ = usable(highest_, longest, end_);
        play_.step(motor(), in_use(given_play_, 1, most_play_), in_use(given_variation_, 0.9, variation_),
                   in_use(given_stick_, 1, stick_), part(motor()));
        body_.direction = direction_;
        body_.travel = motor() - zero_;
        body_.end_follows = follows_;
        const Eigen::Vector3d given(ea0_, eb0_, ec0_);
        for (int i = 0; i < 3; ++i) {
            body_.tilt[i] = tilt_[i] = usable(given[i], 0.1, tilt_[i]);
            drift_[i] = drifting_[i] * drift;
        }
        true_ea0_ = tilt_[0] + drift_[0];
        true_eb0_ = tilt_[1] + drift_[1];
        true_ec0_ = tilt_[2] + drift_[2];
        position_ = at_load_ ? play_.load() : motor();
        load_position_ = play_.load();
    }

    // The body by the tilts that were measured at the start.
    const GuidedBody& by_tilts() const noexcept { return body_; }

    // The real body, with `more` added to the errors of its guide.
    GuidedBody as_is(const Eigen::Vector3d& more) noexcept {
        GuidedBody body = body_;
        body.tilt += drift_;
        body.travel = play_.load() - zero_;
        body.error = errors_at(play_.load());
        body.error.translation += more;
        body.error.translation[(direction_ + 1) % 3] +=
            play_.part() * in_use(given_straightness_, 0.1, straightness_reversal_);
        body.error.turn[(direction_ + 2) % 3] += play_.part() * in_use(given_yaw_, 1e-3, yaw_reversal_);
        return body;
    }

    GuideMotion errors_at(double position) noexcept { return errors_.between(part(zero_), part(position)); }

    double position() const noexcept { return play_.load(); }
    double pivot() const noexcept { return zero_; }
    double ideal_position() const noexcept { return ideal_.value(); }
    // The part of the travel above a position, 0 to 1.
    double above(double position) const noexcept { return (1 - part(position)) / 2; }

private:
    static constexpr double longest = 1e5;  // mm

    double motor() const noexcept { return drive_.value() + led_; }

    // An absurd value keeps the last good one.
    static double in_use(double given, double most, double& last) noexcept {
        return last = given >= 0 ? usable(given, most, last) : last;
    }

    // Place in the travel, -1 to 1.
    double part(double position) const noexcept {
        return end_ > begin_ ? std::clamp(2 * (position - begin_) / (end_ - begin_) - 1, -1.0, 1.0) : 0;
    }

    const hal::In<double> command_{this, "%-position-cmd", 0, "mu",
                                   "Command of the drive: motor position plus correction."};
    const hal::In<double> nominal_{this, "%-nominal", 0, "mu",
                                   "Commanded position of the axis without correction: joint position."};
    const hal::In<double> pivot_{this, "%-pivot", 0, "mu",
                                 "Position at which the axis has no error but its tilt."};
    const hal::In<double> lowest_{this, "%-min-limit", 0, "mu", "Begin of the travel."};
    const hal::In<double> highest_{this, "%-max-limit", 1000, "mu", "End of the travel."};
    const hal::In<double> ea0_{this, "ea0%", 0, "rad", "Tilt of the axis about X at the start."};
    const hal::In<double> eb0_{this, "eb0%", 0, "rad", "Tilt of the axis about Y at the start."};
    const hal::In<double> ec0_{this, "ec0%", 0, "rad", "Tilt of the axis about Z at the start."};
    const hal::In<bool> follows_{
        this, "%-tool-follows", true,
        "Tool or work turn with the axis; false where they were shimmed square on it."};
    const hal::In<double> added_{this, "%-feed-forward", 0, "mu/s",
                                 "Velocity that the drive adds: its feed-forward."};
    const hal::In<double> given_play_{this, "%-play", 0, "mu",
                                      "Play between motor and load: lost motion where it turns."};
    const hal::In<double> given_variation_{this, "%-play-variation", 0, "1",
                                           "Variation of the play along the travel, either way."};
    const hal::In<double> given_stick_{this, "%-stick", 0, "mu",
                                       "Windup beyond the play that breaks the resting load away."};
    const hal::In<double> given_straightness_{
        this, "%-straightness-reversal", 0, "mu",
        "Half of the displacement across when it turns: of Y for X, of Z for Y, of X for Z and W."};
    const hal::In<double> given_yaw_{
        this, "%-yaw-reversal", 0, "rad",
        "Half of the rotation when it turns: about Z for X, about X for Y, about Y for Z and W."};
    const hal::In<bool> at_load_{this, "%-scale-at-load", false,
                                 "The scale is at the load, and the drive follows it; false: at the motor."};
    const int direction_;
    GuideErrors errors_{this, direction_};
    hal::Out<double> position_{this, "%-position", "mu", "Position that the encoder reads."};
    hal::Out<double> load_position_{this, "truth-%-load", "mu", "Position of the load."};
    hal::Out<double> true_ea0_{this, "truth-ea0%", "rad", "Tilt of the axis about X by now."};
    hal::Out<double> true_eb0_{this, "truth-eb0%", "rad", "Tilt of the axis about Y by now."};
    hal::Out<double> true_ec0_{this, "truth-ec0%", "rad", "Tilt of the axis about Z by now."};

    ServoLag drive_, ideal_;
    DrivePlay play_;
    double most_play_ = 0, variation_ = 0, stick_ = 0, straightness_reversal_ = 0, yaw_reversal_ = 0;
    double led_ = 0;  // mu, by which feed-forward leads the loop
    double commanded_ = 0, wanted_ = 0, zero_ = 0, begin_ = 0, end_ = 1000;  // last good inputs
    Eigen::Vector3d tilt_ = Eigen::Vector3d::Zero(), drift_ = tilt_, drifting_ = tilt_;
    GuidedBody body_;
};

}  // namespace plumb

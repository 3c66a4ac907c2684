// SPDX-License-Identifier: GPL-2.0-or-later
// An axis of a simulated machine: its drive, its guide, and how that leans.
#pragma once

#include "components/math/blocks/servo_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/sim_portal/guide_errors.hpp"
#include "components/plants/sim_portal/rigid_machine.hpp"

#include <algorithm>
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
            ideal_.reset(wanted_);
        }
        errors_.draw(seed);
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
        if (clamped) {
            drive_.reset(drive_.value());
        } else {
            drive_.step(commanded_, gain, dt);
        }
        zero_ = usable(pivot_, longest, zero_);
        begin_ = usable(lowest_, longest, begin_);
        end_ = usable(highest_, longest, end_);
        body_.direction = direction_;
        body_.travel = drive_.value() - zero_;
        body_.end_follows = follows_;
        const Eigen::Vector3d given(ea0_, eb0_, ec0_);
        for (int i = 0; i < 3; ++i) {
            body_.tilt[i] = tilt_[i] = usable(given[i], 0.1, tilt_[i]);
            drift_[i] = drifting_[i] * drift;
        }
        true_ea0_ = tilt_[0] + drift_[0];
        true_eb0_ = tilt_[1] + drift_[1];
        true_ec0_ = tilt_[2] + drift_[2];
        position_ = drive_.value();
    }

    // The body by the tilts that were measured at the start.
    const GuidedBody& by_tilts() const noexcept { return body_; }

    // The real body, with `more` added to the errors of its guide.
    GuidedBody as_is(const Eigen::Vector3d& more) noexcept {
        GuidedBody body = body_;
        body.tilt += drift_;
        body.error = errors_at(drive_.value());
        body.error.shift += more;
        return body;
    }

    GuideMotion errors_at(double position) noexcept { return errors_.between(part(zero_), part(position)); }

    double position() const noexcept { return drive_.value(); }
    double pivot() const noexcept { return zero_; }
    double ideal_position() const noexcept { return ideal_.value(); }
    // The part of the travel above a position, 0 to 1.
    double above(double position) const noexcept { return (1 - part(position)) / 2; }

private:
    static constexpr double longest = 1e5;  // mm

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
    const int direction_;
    GuideErrors errors_{this, direction_};
    hal::Out<double> position_{this, "%-position", "mu", "Position that the encoder reads."};
    hal::Out<double> true_ea0_{this, "truth-ea0%", "rad", "Tilt of the axis about X by now."};
    hal::Out<double> true_eb0_{this, "truth-eb0%", "rad", "Tilt of the axis about Y by now."};
    hal::Out<double> true_ec0_{this, "truth-ec0%", "rad", "Tilt of the axis about Z by now."};

    ServoLag drive_, ideal_;
    double commanded_ = 0, wanted_ = 0, zero_ = 0, begin_ = 0, end_ = 1000;  // last good inputs
    Eigen::Vector3d tilt_ = Eigen::Vector3d::Zero(), drift_ = tilt_, drifting_ = tilt_;
    GuidedBody body_;
};

}  // namespace plumb

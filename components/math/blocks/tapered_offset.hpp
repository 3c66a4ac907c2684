// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/soft_limits.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// The offset of a joint: it follows the sum of its sources at limited rates and accelerations, within
// max_offset and, tapered, within the soft limits of the joint.
class TaperedOffset {
public:
    static constexpr double slack = 1e-9;  // mu, without meaning

    struct Settings {
        double max_offset, ramp_rate, max_rate;  // mu, mu/s
    };

    // The joint in a period.
    struct Joint {
        double from, to;  // mu, its last position and this one
        double moved;     // mu, the distance that motion moves it
        bool guarded;     // the soft limits are in force: homed, and they are valid
    };

    explicit TaperedOffset(const Settings& settings) noexcept : settings_(settings) {}

    // False if max_offset is too small for the present offset; the last one stays in force.
    bool take(const Settings& given, double dt) noexcept {
        const double most = settings_.max_offset;
        settings_ = given;
        if (given.max_offset >= most || stops_within(given.max_offset, acceleration(), dt)) return true;
        settings_.max_offset = most;
        return false;
    }

    // A smaller offset_acceleration waits until the offset can stop within max_offset by it.
    void take(const SoftLimits& given, double dt) noexcept {
        const double before = limits_.offset_acceleration;
        limits_ = given;
        if (given.offset_acceleration < before &&
            !stops_within(settings_.max_offset, given.offset_acceleration, dt))
            limits_.offset_acceleration = before;
    }

    const Settings& settings() const noexcept { return settings_; }
    bool knows_limits() const noexcept { return limits_.valid(); }
    double value() const noexcept { return applied_.value(); }
    double sum() const noexcept { return source_.value(); }  // of the sources, bounded and ramped
    bool ramping() const noexcept { return ramping_; }
    // A soft limit, or a rate beside a ramp, keeps the offset from this sum.
    bool falls_short(double possible) const noexcept {
        return tapered_ || (!ramping_ && std::abs(possible - applied_.value()) > slack);
    }

    // The way to the sum is not caused by motion: it is gone at ramp_rate.
    void ramp() noexcept { ramping_ = true; }

    // In the command of the drive, motion has the rest of it.
    void move_to(double place, double dt) noexcept {
        source_.move_to(place, acceleration(), dt);
        applied_.move_to(place, acceleration(), dt);
        hold();
    }

    void hold() noexcept {
        source_.hold();
        applied_.hold();
    }

    // The sources, then the soft limits, then the drive.
    void follow(double possible, const Joint& its, double dt) noexcept {
        const double most = settings_.max_offset, rate = settings_.max_rate;
        const double acceleration = this->acceleration();
        if (guarded_ && !its.guarded) {  // the rest of the sum must not come at once
            source_.move_to(applied_.value(), acceleration, dt);
            source_.hold();
        }
        guarded_ = its.guarded;
        const double source = source_.value(), applied = applied_.value();
        const SoftLimits::Step joint{its.from, its.to, its.moved, dt};
        share_out(guarded_ && (limits_.tapers(std::max(source, possible), joint) ||
                               limits_.tapers(std::min(source, possible), joint)),
                  acceleration, dt);
        AccelerationLimit::Limits speeds{
            ramping_ ? settings_.ramp_rate : rate, rate, acceleration * source_share(), rate, rate, most};
        if (guarded_) {
            speeds.down = limits_.largest_speed(-1, source, joint);
            speeds.up = limits_.largest_speed(1, source, joint);
        }
        source_.step(possible, speeds, dt);
        const bool held = (possible > source ? speeds.up : speeds.down) * dt <= slack;  // by a soft limit
        ramping_ = ramping_ && source_.value() != possible && !held;

        const double now = source_.value();
        const double allowed = guarded_ ? limits_.allowed(now, its.to) : now;
        tapered_ = allowed != now;
        // At most share(), so that the offset brakes in time when motion does.
        const double by_motion = guarded_ ? std::min(std::abs(allowed - limits_.allowed(now, its.from)),
                                                     limits_.share() * its.moved)
                                          : 0;
        const double fastest = rate + by_motion / dt;
        applied_.step(allowed, {rate, fastest, acceleration, fastest, fastest, most}, dt);
        if (!guarded_) return;
        const double within = limits_.largest_offset(applied_.value(), applied, joint);
        if (std::abs(applied_.value()) > within)
            applied_.move_to(std::copysign(within, applied_.value()), acceleration, dt);
    }

private:
    static constexpr double gentle = 100;    // mu/s2, without valid limits
    static constexpr double quarter = 0.25;  // of the acceleration, for sources, beside a taper

    bool stops_within(double bound, double acceleration, double dt) const noexcept {
        return source_.stops_within(bound, acceleration * source_share(), dt) &&
               applied_.stops_within(bound, acceleration, dt);
    }

    // While the taper may act, it needs all of the acceleration but a quarter. The sources have all of it
    // elsewhere; they give it back when they do not need it to stop within max_offset.
    void share_out(bool tapers, double acceleration, double dt) noexcept {
        const double rest = acceleration * quarter;
        if (!tapers)
            shares_ = false;
        else if (source_.settled(rest, dt) && source_.stops_within(settings_.max_offset, rest, dt))
            shares_ = true;
    }

    double acceleration() const noexcept { return limits_.valid() ? limits_.offset_acceleration : gentle; }
    double source_share() const noexcept { return shares_ ? quarter : 1; }

    Settings settings_;  // the last good ones
    SoftLimits limits_{};
    AccelerationLimit source_;   // the sum, bounded and ramped
    AccelerationLimit applied_;  // source_ within the soft limits; the last command contains it
    bool ramping_ = false;
    bool guarded_ = false, tapered_ = false;  // by the soft limits
    bool shares_ = true;                      // the acceleration, with the taper
};

}  // namespace plumb
